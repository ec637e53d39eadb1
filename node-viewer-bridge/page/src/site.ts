// What this page knows of the site, built from the bridge's messages. Draws nothing.

import { sentences } from "./findings.ts";
import { OutlineHistory, ReportHistory } from "./matching.ts";
import { RateMeter, Recent } from "./measure.ts";
import { objectColour } from "./palette.ts";
import type { CameraClock, CameraStatus, Message, ObjectTag, Observations, Offer, Pose, RigCamera, State } from "./protocol.ts";

/** Seconds without a word after which shown figures are no longer called live. */
const SILENT_AFTER_S = 2;
/** A camera tells its status about once a second. */
const STATUS_KEPT_S = 3;

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
  readonly latency = new Recent();

  constructor(readonly id: string) {}

  /** Images detected a second, as the camera says; counted here while it says nothing. */
  rateHz(now: number): number | null {
    const told = this.status && now - this.statusAt < STATUS_KEPT_S ? this.status.rate_hz : null;
    return told ?? this.rate.rate(now);
  }

  condition(now: number): "live" | "silent" | "offline" {
    if (this.up === false) return "offline";
    return now - this.heardAt > SILENT_AFTER_S ? "silent" : "live";
  }
}

export class ObjectState {
  tags: ObjectTag[] = [];
  pose: Pose | null = null;
  heardAt = -Infinity;
  truthAt = -Infinity;
  readonly rate = new RateMeter();
  readonly latency = new Recent();
  readonly errorMm = new Recent();
  readonly errorDeg = new Recent();

  constructor(
    readonly id: string,
    readonly colour: string,
  ) {}

  condition(now: number): State | "silent" | "unseen" {
    if (!this.pose) return "unseen";
    return now - this.heardAt > SILENT_AFTER_S ? "silent" : this.pose.state;
  }
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
  private readonly findings = new Map<string, string[]>();
  private readonly tagOwners = new Map<string, ObjectState>();

  /** `now` in seconds, of any steady clock. */
  take(message: Message, now: number): void {
    switch (message.type) {
      case "hello":
        return this.hello(message.site, message.version);
      case "rig":
        return this.rig(message.cameras, now);
      case "object":
        return this.model(message.id, message.tags);
      case "object_gone":
        return this.gone(message.id);
      case "pose":
        return this.pose(message, now);
      case "truth":
        return this.truth(message.object, message.error_mm, message.error_deg, now);
      case "observations":
        return this.observations(message, now);
      case "camera_status":
        return this.cameraStatus(message, now);
      case "detection_report":
        this.camera(message.camera).reports.add(message);
        return;
      case "fusion_status":
        this.findings.set(message.node, sentences(message));
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
        return;
      case "wizard":
        return;
      case "bridge_status":
        this.network = message.network;
        return;
    }
  }

  camera(id: string): CameraState {
    return entry(this.cameras, id, () => new CameraState(id));
  }

  object(id: string): ObjectState {
    return entry(this.objects, id, () => new ObjectState(id, this.freeColour()));
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

  /** What nodes report, a sentence each. */
  notices(): string[] {
    const cameras = [...this.cameras.values()].flatMap((camera) =>
      (camera.status?.messages ?? []).map((text) => `${camera.id}: ${text}`),
    );
    const fusion = [...this.findings].flatMap(([node, findings]) => findings.map((text) => `${node}: ${text}`));
    const bridge = this.network ? [] : ["bridge: no connection to the site's network, retrying"];
    return [...bridge, ...cameras, ...fusion];
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
    this.findings.clear();
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

  private model(id: string, tags: ObjectTag[]): void {
    const object = this.object(id);
    object.tags = tags;
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
    object.heardAt = now;
    object.rate.add(now, pose.sequence);
    object.latency.add(pose.latency_ms);
  }

  private truth(id: string, errorMm: number, errorDeg: number, now: number): void {
    const object = this.object(id);
    object.truthAt = now;
    object.errorMm.add(errorMm);
    object.errorDeg.add(errorDeg);
  }

  private observations(observations: Observations, now: number): void {
    const camera = this.camera(observations.camera);
    camera.heardAt = now;
    camera.resolution = observations.resolution;
    camera.outlines.add(observations);
    camera.rate.add(now, observations.sequence);
    camera.latency.add(observations.latency_ms);
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
