// From where the stage is seen: orbit controls with z up, and a first view that shows everything.

import { Box2, PerspectiveCamera, Vector2, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const FIELD_DEG = 42;
const FROM = new Vector3(0.52, -1, 0.72).normalize();
/** Share of the picture's width and height that the points fill. */
const FILLED = 0.8;

export class View {
  readonly camera = new PerspectiveCamera(FIELD_DEG, 1, 0.02, 200);
  private readonly controls: OrbitControls;
  private points = [new Vector3(1, 1, 0), new Vector3(-1, -1, 0), new Vector3(1, -1, 0), new Vector3(-1, 1, 0)];
  private touched = false;
  /** Where the followed object was last. */
  private readonly followed = new Vector3();
  private following = false;
  private readonly step = new Vector3();

  constructor(canvas: HTMLCanvasElement, changed: () => void) {
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.dampingFactor = 0.12;
    this.controls.minDistance = 0.1;
    this.controls.maxDistance = 60;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("start", () => (this.touched = true));
    this.controls.addEventListener("change", changed);
    this.reset();
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.touched) this.reset();
  }

  /** Shows all of `points`, unless the user has already turned the view. */
  frame(points: Vector3[]): void {
    if (points.length < 2) return;
    this.points = points;
    if (!this.touched) this.reset();
  }

  /** Turns to the first direction, then moves until the points fill the picture; a few rounds settle it. */
  reset(): void {
    this.touched = this.following = false;
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

  /** Moves with an object, orbiting around it; `null` stays where it is. */
  follow(position: Vector3 | null): void {
    if (!position) {
      this.following = false;
      return;
    }
    if (!this.following) {
      this.following = this.touched = true;
      this.followed.copy(this.controls.target);
    }
    this.step.copy(position).sub(this.followed);
    this.followed.copy(position);
    this.controls.target.add(this.step);
    this.camera.position.add(this.step);
  }

  /** Goes on with a movement that is dying away; it asks for further frames through `changed`. */
  update(): void {
    this.controls.update();
  }
}
