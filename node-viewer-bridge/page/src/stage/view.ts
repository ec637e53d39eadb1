// From where the stage is seen: orbit controls with z up, a first view that shows everything, and a close one of the
// followed object.

import { Box2, PerspectiveCamera, Quaternion, type Sphere, Spherical, Vector2, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const FIELD_DEG = 42;
const FROM = new Vector3(0.52, -1, 0.72).normalize();
/** From z up to y up, as spherical coordinates have it, and back. */
const UPRIGHT = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(0, 1, 0));
const FROM_UPRIGHT = UPRIGHT.clone().invert();
/** Share of the picture's width and height that the points fill. */
const FILLED = 0.8;
/** Share of the picture's smaller side that a followed object fills. */
const FOLLOWED_FILLS = 0.55;
/** Time constant of a glide from one view to another, s. */
const GLIDE_S = 0.13;
/** A glide ends where less than this share of the way is left. */
const ARRIVED = 0.002;
/** What a press of a key turns the view by, rad, and how much nearer it goes. */
const TURN = Math.PI / 36;
const NEARER = 0.88;
/** The view never goes over the pole, rad. */
const POLE = 0.02;

/** A view: what is looked at, and from where relative to it. */
interface Aim {
  target: Vector3;
  offset: Vector3;
}

export class View {
  readonly camera = new PerspectiveCamera(FIELD_DEG, 1, 0.02, 200);
  private readonly controls: OrbitControls;
  private points = [new Vector3(1, 1, 0), new Vector3(-1, -1, 0), new Vector3(1, -1, 0), new Vector3(-1, 1, 0)];
  private touched = false;
  /** The followed object and where it was last. */
  private followed: { id: string; at: Vector3 } | null = null;
  /** The view before an object was followed, and whether a person had chosen it. */
  private before: (Aim & { touched: boolean }) | null = null;
  /** Where the view glides to. */
  private goal: Aim | null = null;
  private glidedAt = 0;
  private readonly step = new Vector3();
  private readonly isCalm = matchMedia("(prefers-reduced-motion: reduce)").matches;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly changed: () => void,
  ) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !this.isCalm;
    this.controls.dampingFactor = 0.12;
    this.controls.minDistance = 0.05;
    this.controls.maxDistance = 60;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("start", () => this.touch());
    this.controls.addEventListener("change", changed);
    this.reset();
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.touched) this.reset();
  }

  /** Pixels of a metre at a distance of one, in a picture of this height. */
  pixelsAtOne(height: number): number {
    return height / (2 * Math.tan((FIELD_DEG / 2) * (Math.PI / 180)));
  }

  /** Shows all of `points`, unless the user has already turned the view. */
  frame(points: Vector3[]): void {
    if (points.length < 2) return;
    this.points = points;
    if (!this.touched) this.reset();
  }

  /** Turns to the first direction, then moves until the points fill the picture; a few rounds settle it. */
  reset(): void {
    this.touched = false;
    this.followed = this.before = this.goal = null;
    this.controls.zoomToCursor = true;
    this.controls.target.set(0, 0, 0);
    let distance = 2 * Math.max(...this.points.map((point) => point.length()));
    for (let round = 0; round < 8; round++) distance = this.approach(distance);
    this.controls.update();
  }

  private approach(distance: number): number {
    const { target } = this.controls;
    this.camera.position.copy(target).addScaledVector(FROM, distance);
    this.camera.lookAt(target);
    this.camera.updateMatrixWorld();
    const seen = this.points.map((point) => point.clone().project(this.camera));
    const box = new Box2().setFromPoints(seen.map(({ x, y }) => new Vector2(x, y)));
    const [centre, extent] = [box.getCenter(new Vector2()), box.getSize(new Vector2())];
    const half = distance * Math.tan((FIELD_DEG / 2) * (Math.PI / 180));
    const [right, up] = [new Vector3(), new Vector3()];
    this.camera.matrixWorld.extractBasis(right, up, new Vector3());
    target.addScaledVector(right, centre.x * half * this.camera.aspect).addScaledVector(up, centre.y * half);
    const grow = Math.max(extent.x, extent.y) / 2 / FILLED;
    return Math.max(0.3, distance * Math.min(2, Math.max(0.5, grow)));
  }

  /** Goes up to an object, which then stays where it is in the picture. */
  follow(id: string, object: Sphere): void {
    if (this.followed?.id !== id) {
      this.before ??= { ...this.aim(), touched: this.touched };
      this.followed = { id, at: object.center.clone() };
      this.touched = true;
      this.controls.zoomToCursor = false;
      this.approachObject(object);
    }
    const { at } = this.followed;
    this.step.copy(object.center).sub(at);
    at.copy(object.center);
    this.controls.target.add(this.step);
    this.camera.position.add(this.step);
    this.goal?.target.copy(object.center);
  }

  /** Follows no object any more: back to the view before. */
  leave(): void {
    if (!this.before) return;
    this.glide(this.before);
    this.touched = this.before.touched;
    this.followed = this.before = null;
    this.controls.zoomToCursor = true;
  }

  /** Turns the view to the right and up by so many steps. */
  turn(right: number, up: number): void {
    this.touch();
    const offset = this.aim().offset.applyQuaternion(UPRIGHT);
    const around = new Spherical().setFromVector3(offset);
    around.theta += right * TURN;
    around.phi = Math.min(Math.PI - POLE, Math.max(POLE, around.phi - up * TURN));
    this.look({ target: this.controls.target, offset: offset.setFromSpherical(around).applyQuaternion(FROM_UPRIGHT) });
  }

  /** Goes nearer by so many steps; negative ones go away. */
  approachBy(steps: number): void {
    this.touch();
    const offset = this.aim().offset.multiplyScalar(NEARER ** steps);
    this.look({ target: this.controls.target, offset: offset.clampLength(this.controls.minDistance, this.controls.maxDistance) });
  }

  /** Goes on with a movement that is dying away; it asks for further frames through `changed`. */
  update(): void {
    if (this.goal) this.glideOn(this.goal);
    this.controls.update();
  }

  private touch(): void {
    this.touched = true;
    this.goal = null;
  }

  private aim(): Aim {
    const { target } = this.controls;
    return { target: target.clone(), offset: this.camera.position.clone().sub(target) };
  }

  private look({ target, offset }: Aim): void {
    this.controls.target.copy(target);
    this.camera.position.copy(target).add(offset);
    // Not only with the next frame, since the next key may come before.
    this.camera.lookAt(target);
    this.changed();
  }

  private approachObject(object: Sphere): void {
    const half = Math.tan((FIELD_DEG / 2) * (Math.PI / 180)) * Math.min(1, this.camera.aspect);
    const distance = object.radius / (half * FOLLOWED_FILLS);
    this.glide({ target: object.center.clone(), offset: this.aim().offset.setLength(Math.max(this.controls.minDistance, distance)) });
  }

  private glide(goal: Aim): void {
    if (this.isCalm) return this.look(goal);
    this.goal = goal;
    this.glidedAt = performance.now() / 1000;
    this.changed();
  }

  /** As far as the time since the last frame takes it: direction and distance change evenly. */
  private glideOn(goal: Aim): void {
    const now = performance.now() / 1000;
    const share = 1 - Math.exp(-(now - this.glidedAt) / GLIDE_S);
    this.glidedAt = now;
    const { target, offset } = this.aim();
    const distance = offset.length() * (goal.offset.length() / offset.length()) ** share;
    const left = target.distanceTo(goal.target) + offset.distanceTo(goal.offset);
    const hasArrived = left < ARRIVED * distance;
    if (hasArrived) this.goal = null;
    this.look(hasArrived ? goal : { target: target.lerp(goal.target, share), offset: offset.lerp(goal.offset, share).setLength(distance) });
  }
}
