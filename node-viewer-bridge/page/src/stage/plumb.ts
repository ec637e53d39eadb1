// A line from an object straight down to the floor: without it nobody can tell from a picture where a thing hovers.

import { BufferGeometry, LineBasicMaterial, LineSegments, Vector3 } from "three";
import type { Vec3 } from "../protocol.ts";

const RING = 20;
const RING_M = 0.02;

export class Plumb {
  readonly line: LineSegments<BufferGeometry, LineBasicMaterial>;

  constructor(colour: string) {
    const material = new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.4 });
    this.line = new LineSegments(new BufferGeometry().setFromPoints([...ring(), new Vector3(), new Vector3(0, 0, 1)]), material);
  }

  move([x, y, z]: Vec3): void {
    this.line.position.set(x, y, 0);
    this.line.scale.z = z || 1e-6;
  }

  remove(): void {
    this.line.geometry.dispose();
    this.line.material.dispose();
    this.line.removeFromParent();
  }
}

function ring(): Vector3[] {
  const point = (i: number): Vector3 => new Vector3(RING_M, 0, 0).applyAxisAngle(new Vector3(0, 0, 1), (2 * Math.PI * i) / RING);
  return Array.from({ length: RING }, (_, i) => [point(i), point(i + 1)]).flat();
}
