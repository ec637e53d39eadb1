// What this page knows of the site, built from the bridge's messages. Draws nothing.

import { cameraReports, type Report, silence, siteReports } from "./findings.ts";
import { HealthLog } from "./health.ts";
import { blankPose, Figures, ObjectTrack } from "./history.ts";
import { sigma } from "./covariance.ts";
import { composed } from "./lens.ts";
import { OutlineHistory, ReportHistory } from "./matching.ts";
import { RateMeter, Recent } from "./measure.ts";
import { objectColour } from "./palette.ts";
import {
  type CameraClock, type CameraStatus, type FusionStatus, type JointValue, type Message, type Object as ObjectModel, type PrintedTag, type Observations, type Offer, type Pose, type RigCamera, type SiteEvent, STAGES,
  type State, type Transform, type Truth, type Zone,
} from "./protocol.ts";
import { rmsResidual } from "./residuals.ts";
import { Silence } from "./silence.ts";

/** What the site's clock may differ from the page's idea of it. */
const CLOCK_STEP_S = 0.5;
/** Longer ones are no latencies: a clock is off. */
const MOST_LATENCY_MS = 60_000;

function note(latency: Recent, ms: number): void {
  if (Math.abs(ms) < MOST_LATENCY_MS) latency.add(ms);
}

export class CameraState {
  model: RigCamera | null = null;
  status: CameraStatus | null = null;
  statusAt = -Infinity;
  /** How far its clock is off, as its images tell; `null` while it is taken at its word. */
  clock: CameraClock | null = null;
  /** Whether the node is on the network; `null` while unknown. */
  up: boolean | null = null;
  heardAt = -Infinity;
  resolution: [number, number] | null = null;
  readonly outlines = new OutlineHistory();
  readonly reports = new ReportHistory();
  readonly rate = new RateMeter();
  readonly received = new Recent();
  readonly detected = new Recent();
  readonly latency = new Recent();

  constructor(
    readonly id: string,
    private readonly silence: Silence,
  ) {}

  /** Images detected a second, as the camera says; counted here while it says nothing. */
  rateHz(now: number): number | null {
    const told = this.status && !this.silence.holds(this.statusAt, now) ? this.status.rate_hz : null;
    return told ?? this.rate.rate(now);
  }

  /** Images a second as its status says: those in force, since a slow camera measures none between two images. */
  private get expectedHz(): number {
    return this.status?.controls.rate_hz.value ?? this.status?.rate_hz ?? 0;
  }

  condition(now: number): "live" | "silent" | "offline" {
    if (this.up === false) return "offline";
    return this.silence.holds(this.heardAt, now, this.expectedHz) ? "silent" : "live";
  }
}

export class ObjectState {
  tags: PrintedTag[] = [];
  /** Of its model; empty while that is unknown. */
  version = "";
  /** Where it stands by its file, of a landmark. */
  place: Transform | null = null;
  /** The newest. */
  pose: Pose | null = null;
  /** What is shown: the newest, or what was at an earlier time. */
  shown: Pose | null = null;
  joints: JointValue[] = [];
  readonly track = new ObjectTrack();
  /** Written into while the past is shown. */
  readonly former: Pose;
  heardAt = -Infinity;
  truthAt = -Infinity;
  readonly rate = new RateMeter();
  readonly latency = new Recent();
  readonly errorMm = new Recent();
  readonly errorDeg = new Recent();

  constructor(
    readonly id: string,
    readonly colour: string,
    private readonly silence: Silence,
  ) {
    this.former = blankPose(id);
  }

  condition(now: number): State | "silent" | "unseen" | "landmark" {
    if (!this.shown) return this.place ? "landmark" : "unseen";
    if (this.shown !== this.pose) return this.shown.state;
    return this.isSilent(now) ? "silent" : this.pose.state;
  }

  isSilent(now: number): boolean {
    return this.silence.holds(this.heardAt, now);
  }
}

/** Writes where an object is at a time of images, s, or where it stands; tells whether that is known. */
export function poseAt(object: ObjectState, time: number, into: Pose): boolean {
  if (object.track.at(time, into)) return true;
  if (!object.place) return false;
  into.position = [...object.place.position];
  into.orientation = [...object.place.orientation];
  return true;
}

export class Site {
  name = "";
  version = "";
  /** Whether the bridge has its place on the site's network. */
  network = true;
  readonly cameras = new Map<string, CameraState>();
  readonly objects = new Map<string, ObjectState>();
  /** Refined calibrations that fusion nodes propose, and what they worked from before the last change; by node. */
  readonly proposals = new Map<string, Offer>();
  readonly formers = new Map<string, Offer>();
  zones: Zone[] = [];
  /** Whether the bridge keeps its zones in a file. */
  zonesKept = false;
  events: SiteEvent[] = [];
  readonly health = new HealthLog();
  private readonly silence = new Silence();
  readonly figures = new Figures();
  /** Seconds since the Unix epoch at which an earlier time is shown; none while the present is. */
  replayedAt: number | null = null;
  private clockOffset_s: number | null = null;
  /** Last status of each fusion node, and when it came. */
  private readonly fusion = new Map<string, { status: FusionStatus; at: number }>();
  private readonly tagOwners = new Map<string, ObjectState>();

  /** `now` in seconds, of any steady clock. */
  take(message: Message, now: number): void {
    switch (message.type) {
      case "hello":
        this.setClock(message.now_ns, now);
        this.silence.take(message.silence);
        return this.hello(message.site, message.version);
      case "rig":
        return this.rig(message.cameras, now);
      case "object":
        return this.model(message);
      case "object_gone":
        return this.gone(message.id);
      case "pose":
        return this.pose(message, now);
      case "truth":
        return this.truth(message, now);
      case "observations":
        return this.observations(message, now);
      case "camera_status":
        return this.cameraStatus(message, now);
      case "detection_report":
        this.camera(message.camera).reports.add(message);
        return;
      case "fusion_status":
        this.fusion.set(message.node, { status: message, at: now });
        return;
      case "joints":
        this.object(message.object).joints = message.joints;
        return;
      case "zones":
        this.zones = message.zones;
        this.zonesKept = message.kept;
        return;
      case "events":
        this.events = message.events;
        return;
      case "proposal":
        return offered(this.proposals, message);
      case "former":
        return offered(this.formers, message);
      case "clocks":
        for (const camera of this.cameras.values())
          camera.clock = message.cameras.find((clock) => clock.camera === camera.id) ?? null;
        return;
      case "alive":
        if (message.kind === "camera") this.camera(message.id).up = message.up;
        // Where the last one has gone, that is to be reported.
        if (message.kind === "fusion" && !message.up && this.fusion.size > 1) this.fusion.delete(message.id);
        return;
      case "wizard":
        return;
      case "bridge_status":
        this.network = message.network;
        this.setClock(message.now_ns, now);
        return;
    }
  }

  camera(id: string): CameraState {
    return entry(this.cameras, id, () => new CameraState(id, this.silence));
  }

  object(id: string): ObjectState {
    return entry(this.objects, id, () => new ObjectState(id, this.freeColour(), this.silence));
  }

  /** The object that carries a tag. */
  ownerOf(family: string, id: number): ObjectState | null {
    return this.tagOwners.get(`${family}/${id}`) ?? null;
  }

  /** Tags of a family that cameras have seen in their last images, in order. */
  tagsSeen(family: string): number[] {
    const outlines = [...this.cameras.values()].flatMap((camera) => camera.outlines.recent());
    const ids = outlines.filter((tag) => tag.family === family).map((tag) => tag.id);
    return [...new Set(ids)].sort((a, b) => a - b);
  }

  /** The site's time now, seconds since the Unix epoch. */
  time(now: number): number {
    return now + (this.clockOffset_s ?? Date.now() / 1000 - now);
  }

  /** Oldest and newest time of which poses are kept; none before the first pose. */
  span(): [number, number] | null {
    let [from, to] = [Infinity, -Infinity];
    for (const { track } of this.objects.values()) {
      from = Math.min(from, track.coarse.firstTime, track.fine.firstTime);
      to = Math.max(to, track.fine.lastTime);
    }
    return from < to ? [from, to] : null;
  }

  /** Shows what was at a time, or the present. */
  replay(time: number | null): void {
    this.replayedAt = time;
    for (const object of this.objects.values()) {
      if (time === null) object.shown = object.pose;
      else object.shown = object.track.at(time, object.former) ? object.former : null;
    }
  }

  /** Takes note of how the site is doing; called a few times a second. */
  sample(now: number): void {
    const time = this.time(now);
    if (!this.figures.begin(time)) return;
    for (const object of this.objects.values()) this.sampleObject(object, now);
    for (const camera of this.cameras.values()) this.sampleCamera(camera, now);
    if (!this.network) this.health.hold(time);
    this.health.take(this.reports(now), time);
  }

  private sampleObject(object: ObjectState, now: number): void {
    const { id, pose, latency } = object;
    if (!pose || object.isSilent(now)) return;
    const { position_mm, attitude_deg } = sigma(pose.covariance);
    this.figures.write(`sigma_mm/${id}`, position_mm);
    this.figures.write(`sigma_deg/${id}`, attitude_deg);
    this.figures.write(`pose_ms/${id}`, latency.median());
  }

  private sampleCamera(camera: CameraState, now: number): void {
    if (camera.condition(now) !== "live") return;
    const { id } = camera;
    this.figures.write(`rate_hz/${id}`, camera.rateHz(now));
    this.figures.write(`image_ms/${id}`, camera.latency.median());
    for (const step of ["received", "detected"] as const) this.figures.write(`path_ms/${id}/${step}`, camera[step].median());
    this.figures.write(`path_ms/${id}/published`, camera.latency.median());
    this.figures.write(`residual_px/${id}`, this.residual(camera));
    if (camera.clock) this.figures.write(`clock_ms/${id}`, camera.clock.offset_s * 1e3);
    const report = camera.reports.newest;
    if (report) for (const stage of STAGES) this.figures.write(`stage_ms/${id}/${stage}`, report.stage_ms[stage]);
  }

  /**
   * A camera's model with its pose in the world at a time of images, s; none where it has none, or what carries it none
   * then.
   */
  modelAt({ model }: CameraState, time: number): RigCamera | null {
    if (!model?.mount) return model?.world_from_camera ? model : null;
    const carrier = this.objects.get(model.mount.carrier);
    if (!carrier || carrier.track.fine.lastTime < time || !carrier.track.at(time, this.scratch)) return null;
    return { ...model, world_from_camera: composed(this.scratch, model.mount.carrier_from_camera) };
  }

  /** Of the newest image of whose time poses are known. */
  private residual(camera: CameraState): number | null {
    const [, newest] = this.span() ?? [0, 0];
    const image = camera.outlines.before(newest * 1e9);
    const time = (image?.t_ns ?? 0) / 1e9;
    const model = this.modelAt(camera, time);
    if (!model || !image) return null;
    return rmsResidual(model, image, (family, tag) => {
      const object = this.ownerOf(family, tag);
      const isKnown = object && (object.place !== null || object.track.fine.lastTime >= time);
      if (!isKnown || !poseAt(object, time, this.scratch)) return null;
      return { tags: object.tags, pose: this.scratch };
    });
  }

  private readonly scratch = blankPose("");

  private setClock(now_ns: number, now: number): void {
    const offset = now_ns / 1e9 - now;
    // The way of a message takes longer now and then.
    if (this.clockOffset_s === null || Math.abs(offset - this.clockOffset_s) > CLOCK_STEP_S) this.clockOffset_s = offset;
  }

  /** How the site is; `unknown` before a fusion node has reported. */
  get condition(): "unknown" | "healthy" | "faulty" {
    if (this.health.faults.length > 0) return "faulty";
    return this.fusion.size > 0 ? "healthy" : "unknown";
  }

  /** What nodes report, and who is silent. */
  private reports(now: number): Report[] {
    if (!this.network) return [silence("bridge", "node", "no connection to the site's network, retrying", "check that the router or fusion node runs")];
    const cameras = [...this.cameras.values()];
    const said = cameras.flatMap(({ id, status }) => (status ? cameraReports(id, status) : []));
    const gone = cameras.filter((camera) => camera.model && camera.up === false).map(({ id }) =>
      silence(id, "camera", `camera ${id} is in the rig, but its node does not run`, "check its power and network, or take it out of the rig"),
    );
    const known = [...this.fusion.entries()];
    const silent = known.filter(([, { at }]) => this.silence.holds(at, now));
    const silences =
      silent.length > 0 && silent.length === known.length
        ? [silence("fusion", "node", "no fusion node reports any more", "see its log, and the load of its machine")]
        : silent.map(([id]) => silence(id, "node", `fusion node ${id} reports nothing`, "see its log, and the load of its machine"));
    const fresh = known.filter((node) => !silent.includes(node)).map(([, { status }]) => status);
    const fusion = [...silences, ...siteReports(fresh)];
    return [...said, ...gone, ...fusion];
  }

  /** The first colour that no object has; with more objects than colours they share. */
  private freeColour(): string {
    const taken = new Set([...this.objects.values()].map((object) => object.colour));
    const indices = Array.from({ length: this.objects.size }, (_, index) => index);
    const free = indices.find((index) => !taken.has(objectColour(index)));
    return objectColour(free ?? this.objects.size);
  }

  private hello(name: string, version: string): void {
    if (this.name !== name) this.forget();
    this.name = name;
    this.version = version;
    this.fusion.clear();
    this.proposals.clear();
    this.formers.clear();
    for (const camera of this.cameras.values()) {
      camera.outlines.clear();
      camera.reports.clear();
    }
  }

  private forget(): void {
    this.cameras.clear();
    this.objects.clear();
    this.tagOwners.clear();
    this.zones = [];
    this.events = [];
    this.health.clear();
    this.figures.clear();
  }

  /** A camera that left the rig leaves the page, unless it still sends. */
  private rig(models: RigCamera[], now: number): void {
    for (const [id, camera] of this.cameras) {
      const left = camera.model !== null && !models.some((model) => model.id === id);
      if (left) camera.model = null;
      if (left && camera.condition(now) !== "live") this.cameras.delete(id);
    }
    for (const model of models) this.rigCamera(model);
  }

  private rigCamera(model: RigCamera): void {
    const camera = this.camera(model.id);
    camera.model = model;
    camera.resolution ??= model.resolution;
  }

  private cameraStatus(status: CameraStatus, now: number): void {
    const camera = this.camera(status.camera);
    camera.status = status;
    camera.statusAt = now;
  }

  private model({ id, tags, world_from_object, version }: ObjectModel): void {
    const object = this.object(id);
    object.tags = tags;
    object.version = version;
    object.place = world_from_object ?? null;
    this.disown(object);
    for (const tag of tags) this.tagOwners.set(`${tag.family}/${tag.id}`, object);
  }

  private gone(id: string): void {
    const object = this.objects.get(id);
    if (object) this.disown(object);
    this.objects.delete(id);
  }

  private disown(object: ObjectState): void {
    for (const [tag, owner] of this.tagOwners) if (owner === object) this.tagOwners.delete(tag);
  }

  private pose(pose: Pose, now: number): void {
    const object = this.object(pose.object);
    object.pose = pose;
    if (this.replayedAt === null) object.shown = pose;
    object.track.add(pose);
    object.heardAt = now;
    object.rate.add(now, pose.sequence);
    note(object.latency, pose.latency_ms);
  }

  /** Scores poses of objects that were tracked at that time: others are predicted, or not settled yet. */
  private truth({ object: id, t_ns, error_mm, error_deg }: Truth, now: number): void {
    const object = this.object(id);
    object.truthAt = now;
    if (!object.track.at(t_ns / 1e9, this.scratch) || this.scratch.state !== "tracking") return;
    object.errorMm.add(error_mm);
    object.errorDeg.add(error_deg);
  }

  private observations(observations: Observations, now: number): void {
    const camera = this.camera(observations.camera);
    camera.heardAt = now;
    camera.resolution = observations.resolution;
    camera.outlines.add(observations);
    camera.rate.add(now, observations.sequence);
    if (observations.received_ms !== null) note(camera.received, observations.received_ms);
    if (observations.detected_ms !== null) note(camera.detected, observations.detected_ms);
    note(camera.latency, observations.latency_ms);
  }
}

function offered(offers: Map<string, Offer>, offer: Offer): void {
  if (offer.rig || offer.objects.length > 0) offers.set(offer.node, offer);
  else offers.delete(offer.node);
}

function entry<T>(map: Map<string, T>, id: string, create: () => T): T {
  const known = map.get(id);
  if (known) return known;
  const created = create();
  map.set(id, created);
  return created;
}
