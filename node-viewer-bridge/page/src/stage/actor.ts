// One object on the stage: its body, label, trail and uncertainty move together.

import { type Group, type Scene, Sphere } from "three";
import type { PrintedTag, Pose, Transform, Vec3 } from "../protocol.ts";
import type { ObjectState } from "../site.ts";
import { Body } from "./body.ts";
import { Ellipsoid } from "./ellipsoid.ts";
import type { Label, LabelLayer } from "./labels.ts";
import type { StageOptions } from "./options.ts";
import { Plumb } from "./plumb.ts";
import { Trail } from "./trail.ts";

/** How clearly an object is drawn, by the condition of its pose. */
const PRESENCE: Record<ReturnType<ObjectState["condition"]>, number> = {
  tracking: 1,
  initialising: 0.6,
  coasting: 0.6,
  lost: 0.25,
  silent: 0.25,
  unseen: 0,
  landmark: 0.8,
};

export class Actor {
  private readonly body: Body;
  private readonly plumb: Plumb;
  private readonly trail: Trail;
  private readonly ellipsoid: Ellipsoid;
  private readonly label: Label;
  private readonly space = new Sphere();
  private options: StageOptions | null = null;
  private seen = false;
  private shown: ReturnType<ObjectState["condition"]> | null = null;

  constructor(
    private readonly object: ObjectState,
    scene: Scene,
    private readonly labels: LabelLayer,
  ) {
    this.body = new Body(object.colour);
    this.plumb = new Plumb(object.colour);
    this.trail = new Trail(object.colour);
    this.ellipsoid = new Ellipsoid(object.colour);
    this.label = labels.create("object", object.id);
    this.label.element.style.setProperty("--object", object.colour);
    this.label.visible = this.body.group.visible = this.plumb.line.visible = false;
    scene.add(this.body.group, this.plumb.line, this.trail.line, this.ellipsoid.group);
  }

  tags(tags: PrintedTag[]): void {
    this.body.tags(tags);
    this.shown = null;
  }

  pose(pose: Pose, now: number): void {
    this.move(pose);
    if (pose.state !== "lost") this.trail.add(now, pose.position);
    if (this.options?.sigma) this.ellipsoid.show(pose);
    this.condition(pose.state);
  }

  /** A landmark without poses is where its file says. */
  stand(place: Transform): void {
    this.move(place);
    this.condition("landmark");
  }

  private move(pose: Transform): void {
    this.seen = true;
    this.body.move(pose);
    this.plumb.move(pose.position);
    const { center, radius } = this.bounds(this.space);
    this.label.at.copy(center);
    this.label.radius = radius;
  }

  /** Tells whether that is news. */
  condition(condition: ReturnType<ObjectState["condition"]>): boolean {
    if (condition === this.shown) return false;
    this.shown = condition;
    this.body.group.visible = this.label.visible = this.plumb.line.visible = this.seen;
    this.body.presence(PRESENCE[condition]);
    this.label.condition = condition;
    this.label.text = condition === "tracking" || condition === "landmark" ? this.object.id : `${this.object.id} · ${condition}`;
    this.applyOptions();
    return true;
  }

  show(options: StageOptions): void {
    this.options = options;
    this.applyOptions();
    if (options.sigma && this.object.pose) this.ellipsoid.show(this.object.pose);
  }

  /** Whether something still changes with time alone. */
  update(now: number): boolean {
    return this.trail.update(now);
  }

  /** The past jumps: what was drawn of the way before is no way. */
  clearTrail(): void {
    this.trail.clear();
  }

  hide(): void {
    this.seen = false;
    this.shown = null;
    this.condition("unseen");
  }

  recolour(): void {
    this.trail.recolour();
    this.ellipsoid.recolour();
  }

  /** What can be clicked at. */
  get group(): Group {
    return this.body.group;
  }

  bounds(target: Sphere): Sphere {
    return this.body.bounds(target);
  }

  get visible(): boolean {
    return this.seen;
  }

  /** Marks the followed object. */
  select(selected: boolean): void {
    this.label.element.dataset["selected"] = String(selected);
  }

  position(): Vec3 {
    return this.body.group.position.toArray();
  }

  remove(): void {
    this.body.remove();
    this.plumb.remove();
    this.trail.remove();
    this.ellipsoid.remove();
    this.labels.remove(this.label);
  }

  private applyOptions(): void {
    this.trail.line.visible = this.options?.trails ?? false;
    this.ellipsoid.group.visible = this.seen && (this.options?.sigma ?? false);
  }
}
