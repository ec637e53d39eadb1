// A camera of the rig: its pyramid of view, its name and, on the image plane, what it sees.

import {
  BufferGeometry,
  CanvasTexture,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  SRGBColorSpace,
  Vector3,
} from "three";
import { STAGE } from "../palette.ts";
import { composed } from "../lens.ts";
import type { Mount, RigCamera, Transform } from "../protocol.ts";
import { dispose } from "./dispose.ts";
import type { Label, LabelLayer } from "./labels.ts";
import { place } from "./place.ts";

/** Edges between apex (0), corners (1 to 4, clockwise from top left) and the mark that shows which side is up (5). */
const EDGES = [0, 1, 0, 2, 0, 3, 0, 4, 1, 2, 2, 3, 3, 4, 4, 1, 1, 5, 5, 2];

export class Frustum {
  readonly group = new Group();
  private readonly label: Label;
  private lines: LineBasicMaterial | null = null;
  private plane: Mesh<BufferGeometry, MeshBasicMaterial> | null = null;
  private textureSize = "";
  private shown = "";
  /** How far the label is behind the apex, m. */
  private behind = 0;
  private mount: Mount | null = null;

  constructor(
    id: string,
    private readonly labels: LabelLayer,
  ) {
    this.label = labels.create("camera", id);
    this.group.visible = false;
  }

  /**
   * Takes the camera's model; drawn `depth` metres deep. Without a pose in the world the camera is not drawn, a carried
   * one not before its carrier has a pose.
   */
  model(camera: RigCamera, depth: number): void {
    dispose(this.group);
    this.plane = null;
    this.textureSize = this.shown = "";
    this.mount = camera.mount ?? null;
    this.behind = 0.22 * depth;
    this.at(camera.world_from_camera);
    const corners = imageCorners(camera).map((ray) => ray.multiplyScalar(depth));
    this.group.add(this.wires(corners), this.picturePlane(corners));
  }

  /** An object has a pose, or none any more: the camera goes with it where the object carries it. */
  carried(object: string, pose: Transform | null): void {
    if (this.mount?.carrier === object) this.at(pose && composed(pose, this.mount.carrier_from_camera));
  }

  private at(pose: Transform | null): void {
    this.group.visible = this.label.visible = pose !== null;
    if (!pose) return;
    place(this.group, pose);
    this.label.at.set(0, 0, -this.behind).applyQuaternion(this.group.quaternion).add(this.group.position);
  }

  /** Tells whether that is news. */
  condition(condition: string): boolean {
    if (condition === this.shown) return false;
    this.shown = condition;
    this.label.condition = condition;
    this.recolour();
    if (this.plane) this.plane.material.opacity = condition === "live" ? 0.92 : 0.3;
    return true;
  }

  /** Shows the canvas on the image plane, as it is now; `null` shows nothing. */
  picture(canvas: HTMLCanvasElement | null): void {
    if (!this.plane) return;
    this.plane.visible = canvas !== null && canvas.width > 1;
    if (!canvas || !this.plane.visible) return;
    const size = `${canvas.width}x${canvas.height}`;
    if (size !== this.textureSize) this.renewTexture(this.plane.material, canvas);
    this.textureSize = size;
    if (this.plane.material.map) this.plane.material.map.needsUpdate = true;
  }

  /** As the theme has it. */
  recolour(): void {
    this.lines?.color.set(this.shown === "live" ? STAGE.frustum : STAGE.frustumOffline);
  }

  remove(): void {
    dispose(this.group);
    this.labels.remove(this.label);
    this.group.removeFromParent();
  }

  /** A texture's size on the graphics card never changes: another size needs another texture. */
  private renewTexture(material: MeshBasicMaterial, canvas: HTMLCanvasElement): void {
    material.map?.dispose();
    material.map = new CanvasTexture(canvas);
    material.map.colorSpace = SRGBColorSpace;
    material.map.generateMipmaps = false;
    material.map.minFilter = material.map.magFilter;
    material.needsUpdate = true;
  }

  private wires(corners: Vector3[]): LineSegments {
    const [topLeft, topRight, , bottomLeft] = corners as [Vector3, Vector3, Vector3, Vector3];
    const middle = topLeft.clone().add(topRight).multiplyScalar(0.5);
    const up = topLeft.clone().sub(bottomLeft).multiplyScalar(0.16);
    const geometry = new BufferGeometry().setFromPoints([new Vector3(), ...corners, middle.add(up)]);
    geometry.setIndex(EDGES);
    this.lines = new LineBasicMaterial({ color: STAGE.frustum, transparent: true, opacity: 0.8 });
    return new LineSegments(geometry, this.lines);
  }

  private picturePlane(corners: Vector3[]): Mesh {
    const geometry = new BufferGeometry().setFromPoints(corners);
    geometry.setAttribute("uv", new Float32BufferAttribute([0, 1, 1, 1, 1, 0, 0, 0], 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const material = new MeshBasicMaterial({ side: DoubleSide, transparent: true, opacity: 0.92 });
    this.plane = new Mesh(geometry, material);
    this.plane.visible = false;
    return this.plane;
  }
}

/** The image's corners at depth 1, clockwise from top left. Distortion is left out: this is a drawing. */
function imageCorners({ resolution: [width, height], lens }: RigCamera): Vector3[] {
  const [left, right, top, bottom] = [-0.5, width - 0.5, -0.5, height - 0.5];
  const corners: [number, number][] = [[left, top], [right, top], [right, bottom], [left, bottom]];
  return corners.map(([u, v]) => {
    const ray = new Vector3((u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy, 0);
    return lens.model === "kannala-brandt" ? equidistant(ray) : ray.setZ(1);
  });
}

/** Fisheye: the distance from the principal point is the angle; beyond 70 degrees the pyramid would be endless. */
function equidistant(ray: Vector3): Vector3 {
  const angle = ray.length();
  return ray.multiplyScalar(Math.tan(Math.min(angle, 1.22)) / Math.max(angle, 1e-9)).setZ(1);
}
