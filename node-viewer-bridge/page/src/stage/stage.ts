// The stage in 3-D: floor, cameras, objects with trails and uncertainty. Draws what the site says, when it changes.

import { AmbientLight, Color, DirectionalLight, Scene, Sphere, Vector3, type WebGLRenderer } from "three";
import { STAGE } from "../palette.ts";
import type { Pose, RigCamera, Vec3, Zone } from "../protocol.ts";
import type { Selection } from "../selection.ts";
import type { CameraState, ObjectState, Site } from "../site.ts";
import { Actor } from "./actor.ts";
import { Floor } from "./floor.ts";
import { Frames } from "./frames.ts";
import { createRenderer } from "./graphics.ts";
import { Frustum } from "./frustum.ts";
import { LabelLayer } from "./labels.ts";
import type { StageOptions } from "./options.ts";
import { Picker } from "./picker.ts";
import { Ruler } from "./ruler.ts";
import { View } from "./view.ts";
import { ZoneWires } from "./zone.ts";

export class Stage {
  readonly frames = new Frames((now) => this.draw(now / 1000));
  private readonly scene = new Scene();
  private readonly renderer: WebGLRenderer;
  private readonly labels: LabelLayer;
  private readonly floor: Floor;
  private readonly view: View;
  private readonly ruler: Ruler;
  private readonly zoneWires: ZoneWires;
  private readonly bounds = new Sphere();
  private readonly projected = new Vector3();
  private readonly frusta = new Map<string, Frustum>();
  private readonly actors = new Map<string, Actor>();
  private cameras: RigCamera[] = [];
  private frustumSize = 0.5;
  /** Places of landmarks in the world. */
  private readonly landmarks = new Map<string, Vector3>();
  private size: [number, number] = [1, 1];

  /** Throws where the browser has no WebGL 2. */
  constructor(
    canvas: HTMLCanvasElement,
    private readonly labelParent: HTMLElement,
    private readonly options: StageOptions,
    private readonly selection: Selection,
  ) {
    this.renderer = createRenderer(canvas);
    this.scene.background = new Color(STAGE.background);
    this.scene.add(new AmbientLight("#ffffff", 1.6), sun());
    this.labels = new LabelLayer(labelParent);
    this.floor = new Floor(this.labels);
    this.floor.span(2);
    this.ruler = new Ruler(this.labels);
    this.zoneWires = new ZoneWires(this.labels);
    this.scene.add(this.floor.group, this.ruler.line, this.zoneWires.group);
    this.view = new View(canvas, () => this.frames.request());
    new Picker(canvas, this.view.camera, { objects: this.actors, cameras: this.frusta }, selection);
    selection.changed(() => this.select());
    new ResizeObserver(() => this.resize(canvas)).observe(canvas.parentElement ?? canvas);
  }

  /** Options changed. */
  refresh(): void {
    this.labelParent.hidden = !this.options.labels;
    for (const actor of this.actors.values()) actor.show(this.options);
    if (!this.options.pictures) for (const frustum of this.frusta.values()) frustum.picture(null);
    this.frames.request();
  }

  resetView(): void {
    this.selection.follow(null);
    this.view.reset();
    this.frames.request();
  }

  /** Turns the view to the right and up, by steps. */
  turn(right: number, up: number): void {
    this.view.turn(right, up);
  }

  /** Goes nearer by so many steps. */
  zoom(steps: number): void {
    this.view.approachBy(steps);
  }

  rig(cameras: RigCamera[]): void {
    const seen = new Set(cameras.map((camera) => camera.id));
    for (const [id, frustum] of this.frusta) if (!seen.has(id)) this.drop(id, frustum);
    this.cameras = cameras;
    this.arrange();
  }

  /** Sizes floor, cameras and view by what stands still. */
  private arrange(): void {
    const placed = this.cameras.flatMap(({ world_from_camera: pose }) => (pose ? [new Vector3(...pose.position)] : []));
    const positions = [...placed, ...this.landmarks.values()];
    const reach = Math.max(0.5, ...positions.map((position) => position.length()));
    this.frustumSize = Math.min(0.5, reach * 0.16);
    for (const camera of this.cameras) this.frustum(camera.id).model(camera, this.frustumSize);
    this.floor.span(reach * 1.45);
    this.view.frame([...positions, ...floorAround(0.45 * reach)]);
    this.frames.request();
  }

  /** Draws a camera as it would be; none draws all as they are. */
  preview(camera: RigCamera | null): void {
    for (const each of camera ? [camera] : this.cameras) this.frustum(each.id).model(each, this.frustumSize);
    this.frames.request();
  }

  objectTags(object: ObjectState): void {
    const actor = this.actor(object);
    actor.tags(object.tags);
    if (object.place && !object.shown) actor.stand(object.place);
    const former = this.landmarks.get(object.id);
    const place = object.place && new Vector3(...object.place.position);
    if (place) this.landmarks.set(object.id, place);
    else this.landmarks.delete(object.id);
    if (place ? !former?.equals(place) : former) this.arrange();
    this.frames.request();
  }

  /** An object is gone. */
  forget(id: string): void {
    this.actors.get(id)?.remove();
    this.actors.delete(id);
    this.carry(id, null);
    if (this.landmarks.delete(id)) this.arrange();
    this.frames.request();
  }

  pose(object: ObjectState, pose: Pose): void {
    this.actor(object).pose(pose, performance.now() / 1000);
    this.carry(object.id, pose);
    this.frames.request();
  }

  zones(zones: Zone[]): void {
    if (this.zoneWires.show(zones)) this.frames.request();
  }

  /** Another time is shown: objects are where they were then. */
  replay(site: Site, jumped: boolean): void {
    for (const [id, actor] of this.actors) {
      const object = site.objects.get(id);
      if (jumped) actor.clearTrail();
      if (object?.shown) actor.pose(object.shown, performance.now() / 1000);
      else if (object?.place) actor.stand(object.place);
      else actor.hide();
      this.carry(id, object?.shown ?? null);
    }
    this.frames.request();
  }

  /** The theme changed. */
  recolour(site: Site): void {
    this.scene.background = new Color(STAGE.background);
    this.floor.recolour();
    this.ruler.recolour();
    for (const actor of this.actors.values()) actor.recolour();
    for (const frustum of this.frusta.values()) frustum.recolour();
    this.zoneWires.show(site.zones);
    this.frames.request();
  }

  /** What nodes are up and whose figures are live; called now and then. */
  conditions(site: Site, now: number): void {
    const camera = (id: string) => site.cameras.get(id)?.condition(now) ?? "silent";
    let news = false;
    for (const [id, frustum] of this.frusta) news = frustum.condition(camera(id)) || news;
    for (const [id, actor] of this.actors) {
      const object = site.objects.get(id);
      if (object) news = actor.condition(object.condition(now)) || news;
      else this.forget(id);
    }
    if (news) this.frames.request();
  }

  picture(camera: CameraState, canvas: HTMLCanvasElement): void {
    if (!this.options.pictures) return;
    this.frusta.get(camera.id)?.picture(canvas);
    this.frames.request();
  }

  /** Where things are drawn, for tests and the curious. */
  positions(): Record<string, Vec3> {
    return Object.fromEntries([...this.actors].map(([id, actor]) => [id, actor.position()]));
  }

  /** Where an object is on the page and how far it reaches from there, pixels; for tests. */
  screen(id: string): [number, number, number] | null {
    const actor = this.actors.get(id);
    if (!actor) return null;
    // As the next frame will have it.
    this.track();
    this.view.camera.updateMatrixWorld();
    const { center, radius } = actor.bounds(this.bounds);
    const reach = (radius * this.view.pixelsAtOne(this.size[1])) / center.distanceTo(this.view.camera.position);
    const point = this.projected.copy(center).project(this.view.camera);
    const { left, top } = this.renderer.domElement.getBoundingClientRect();
    return [left + ((point.x + 1) / 2) * this.size[0], top + ((1 - point.y) / 2) * this.size[1], reach];
  }

  /** Where the next frame is seen from, m. */
  eye(): [number, number, number] {
    this.track();
    return this.view.camera.position.toArray();
  }

  /** Cameras that an object carries go where it is. */
  private carry(object: string, pose: Pose | null): void {
    for (const frustum of this.frusta.values()) frustum.carried(object, pose);
  }

  private frustum(id: string): Frustum {
    const known = this.frusta.get(id);
    if (known) return known;
    const frustum = new Frustum(id, this.labels);
    this.frusta.set(id, frustum);
    this.scene.add(frustum.group);
    return frustum;
  }

  private drop(id: string, frustum: Frustum): void {
    frustum.remove();
    this.frusta.delete(id);
  }

  private actor(object: ObjectState): Actor {
    const known = this.actors.get(object.id);
    if (known) return known;
    const actor = new Actor(object, this.scene, this.labels);
    actor.show(this.options);
    this.actors.set(object.id, actor);
    return actor;
  }

  private select(): void {
    for (const [id, actor] of this.actors) actor.select(id === this.selection.object);
    this.frames.hold(this.selection.camera !== null);
    this.frames.request();
  }

  /** The view moves with the followed object, the ruler with the measured ones. */
  private track(): void {
    const { object, pair } = this.selection;
    const followed = object === null ? undefined : this.actors.get(object);
    if (object === null) this.view.leave();
    else if (followed?.visible) this.view.follow(object, followed.bounds(this.bounds));
    const from = pair ? this.actors.get(pair[0]) : undefined;
    const to = pair ? this.actors.get(pair[1]) : undefined;
    if (from?.visible && to?.visible) this.ruler.show(from.group.position, to.group.position);
    else this.ruler.hide();
  }

  private resize(canvas: HTMLCanvasElement): void {
    const parent = canvas.parentElement ?? canvas;
    this.size = [Math.max(1, parent.clientWidth), Math.max(1, parent.clientHeight)];
    this.renderer.setSize(...this.size, false);
    this.view.resize(...this.size);
    this.frames.request();
  }

  private draw(now: number): boolean {
    this.track();
    this.view.update();
    let fading = false;
    for (const actor of this.actors.values()) fading = actor.update(now) || fading;
    this.renderer.render(this.scene, this.view.camera);
    this.labels.update(this.view.camera, this.view.pixelsAtOne(this.size[1]), ...this.size);
    return fading && this.options.trails;
  }
}

/** Points of the floor around the origin, where objects most likely are. */
function floorAround(radius: number): Vector3[] {
  return [[1, 0], [0, 1], [-1, 0], [0, -1]].map(([x = 0, y = 0]) => new Vector3(x * radius, y * radius, 0));
}

function sun(): DirectionalLight {
  const light = new DirectionalLight("#ffffff", 1.7);
  light.position.set(1.5, -2, 4);
  return light;
}
