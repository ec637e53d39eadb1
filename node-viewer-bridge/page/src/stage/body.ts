// An object: its tags as printed, on a plain body that fills the space between them.

import {
  BackSide,
  Box3,
  DataTexture,
  EdgesGeometry,
  Group,
  LinearFilter,
  LinearMipmapLinearFilter,
  LineBasicMaterial,
  LineSegments,
  type Material,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PlaneGeometry,
  Sphere,
  SRGBColorSpace,
  Vector3,
} from "three";
import { ConvexGeometry } from "three/addons/geometries/ConvexGeometry.js";
import type { PrintedTag, Transform } from "../protocol.ts";
import { dispose } from "./dispose.ts";
import { place } from "./place.ts";

/** The body stands back behind the prints by this much, so that they don't flicker. */
const PRINT_THICKNESS_M = 0.0008;
/** Tags in one plane get a board of this thickness. */
const BOARD_THICKNESS_M = 0.005;
const TEXELS_PER_MODULE = 8;
const WHITE = 244;
const BLACK = 20;

export class Body {
  readonly group = new Group();
  /** What the prints span, in the object's frame. */
  readonly extent = new Sphere(new Vector3(), 0.05);
  private materials: Material[] = [];

  constructor(private readonly colour: string) {}

  tags(tags: PrintedTag[]): void {
    dispose(this.group);
    const placed = tags.flatMap((tag) => (tag.object_from_tag ? [{ tag, pose: tag.object_from_tag }] : []));
    const points = placed.flatMap(({ tag, pose }) => plateCorners(tag.printed_size_m, pose));
    if (points.length > 0) {
      new Box3().setFromPoints(points).getBoundingSphere(this.extent);
      this.group.add(...this.hull(points));
    }
    this.group.add(...placed.flatMap(({ tag, pose }) => this.plate(tag, pose)));
    this.materials = this.group.children.map((child) => (child as Mesh<PlaneGeometry, Material>).material);
    for (const material of this.materials) material.userData["opacity"] = material.opacity;
  }

  /** 1: here and now; less: shown as uncertain. */
  presence(share: number): void {
    for (const material of this.materials) {
      const full = material.userData["opacity"] as number;
      if (material.opacity === full * share) continue;
      material.transparent = full * share < 1;
      material.opacity = full * share;
      material.needsUpdate = true;
    }
  }

  move(pose: Transform): void {
    place(this.group, pose);
  }

  /** A sphere in the world that holds the object, about its origin. */
  bounds(target: Sphere): Sphere {
    return target.set(this.group.position, this.extent.center.length() + this.extent.radius);
  }

  remove(): void {
    dispose(this.group);
    this.group.removeFromParent();
  }

  private hull(points: Vector3[]): [Mesh, LineSegments] {
    const geometry = new ConvexGeometry(points);
    const body = new Mesh(geometry, new MeshLambertMaterial({ color: this.colour }));
    const line = new LineBasicMaterial({ color: this.colour, transparent: true, opacity: 0.5 });
    return [body, new LineSegments(new EdgesGeometry(geometry, 20), line)];
  }

  private plate(tag: PrintedTag, pose: Transform): [Mesh, Mesh] {
    const geometry = new PlaneGeometry(tag.printed_size_m, tag.printed_size_m);
    const front = new Mesh(geometry, new MeshBasicMaterial({ map: printTexture(tag.modules) }));
    const back = new Mesh(geometry, new MeshBasicMaterial({ color: this.colour, side: BackSide }));
    place(front, pose);
    place(back, pose);
    return [front, back];
  }
}

/** The print's corners on the body's surface and on the back of a board as thick as cardboard. */
function plateCorners(size: number, pose: Transform): Vector3[] {
  const frame = new Group();
  place(frame, pose);
  frame.updateMatrix();
  const half = size / 2;
  return [-half, half].flatMap((x) =>
    [-half, half].flatMap((y) =>
      [PRINT_THICKNESS_M, BOARD_THICKNESS_M].map((depth) => new Vector3(x, y, -depth).applyMatrix4(frame.matrix)),
    ),
  );
}

/** The print as a texture: some texels a module, so that filtering keeps the modules' edges sharp. */
function printTexture(modules: string[]): DataTexture {
  const side = Math.max(1, modules.length * TEXELS_PER_MODULE);
  const texels = new Uint8Array(side * side * 4);
  for (let row = 0; row < side; row++) {
    const line = modules[Math.floor((side - 1 - row) / TEXELS_PER_MODULE)] ?? "";
    for (let column = 0; column < side; column++) {
      const value = line[Math.floor(column / TEXELS_PER_MODULE)] === "1" ? WHITE : BLACK;
      texels.set([value, value, value, 255], (row * side + column) * 4);
    }
  }
  const texture = new DataTexture(texels, side, side);
  texture.colorSpace = SRGBColorSpace;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}
