// Where an object has been during the last seconds: a line that fades with age. Memory is fixed, and nothing is
// allocated while it moves.

import { Color, InstancedInterleavedBuffer, InterleavedBufferAttribute } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { STAGE } from "../palette.ts";
import type { Vec3 } from "../protocol.ts";

const SECONDS = 4;
const POINTS = 120;
const SPACING_S = SECONDS / POINTS;
/** A pause or a jump longer than this breaks the line. */
const GAP_S = 0.5;
const FLOATS = 6;

export class Trail {
  readonly line: LineSegments2;
  /** A ring of the last points. */
  private readonly times = new Float64Array(POINTS);
  private readonly points = new Float32Array(3 * POINTS);
  private next = 0;
  private length = 0;
  private readonly positions = new InstancedInterleavedBuffer(new Float32Array(POINTS * FLOATS), FLOATS, 1);
  private readonly colours = new InstancedInterleavedBuffer(new Float32Array(POINTS * FLOATS), FLOATS, 1);
  private readonly geometry = new LineSegmentsGeometry();
  private readonly colour: Color;
  private readonly faded = new Color(STAGE.background);
  private readonly mixed = new Color();

  constructor(colour: string) {
    this.colour = new Color(colour);
    this.geometry.setAttribute("instanceStart", new InterleavedBufferAttribute(this.positions, 3, 0));
    this.geometry.setAttribute("instanceEnd", new InterleavedBufferAttribute(this.positions, 3, 3));
    this.geometry.setAttribute("instanceColorStart", new InterleavedBufferAttribute(this.colours, 3, 0));
    this.geometry.setAttribute("instanceColorEnd", new InterleavedBufferAttribute(this.colours, 3, 3));
    this.geometry.instanceCount = 0;
    this.line = new LineSegments2(this.geometry, new LineMaterial({ vertexColors: true, linewidth: 2 }));
    this.line.frustumCulled = false;
  }

  /** `at` in seconds of a steady clock. */
  add(at: number, position: Vec3): void {
    if (this.length > 0 && at - this.time(this.length - 1) < SPACING_S) return;
    this.times[this.next] = at;
    this.points.set(position, 3 * this.next);
    this.next = (this.next + 1) % POINTS;
    this.length = Math.min(this.length + 1, POINTS);
  }

  clear(): void {
    this.length = 0;
  }

  /** Rewrites the line as of `now`; tells whether there is still something that fades. */
  update(now: number): boolean {
    while (this.length > 0 && this.time(0) < now - SECONDS) this.length--;
    let segments = 0;
    for (let i = 1; i < this.length; i++) if (this.time(i) - this.time(i - 1) < GAP_S) this.write(segments++, i, now);
    this.geometry.instanceCount = segments;
    this.positions.needsUpdate = this.colours.needsUpdate = segments > 0;
    return segments > 0;
  }

  recolour(): void {
    this.faded.set(STAGE.background);
  }

  remove(): void {
    this.geometry.dispose();
    this.line.material.dispose();
    this.line.removeFromParent();
  }

  /** A point's place in the ring, 0 being the oldest. */
  private place(index: number): number {
    return (this.next - this.length + index + POINTS) % POINTS;
  }

  private time(index: number): number {
    return this.times[this.place(index)] ?? 0;
  }

  /** The segment that ends at a point. */
  private write(segment: number, end: number, now: number): void {
    const offset = segment * FLOATS;
    for (let half = 0; half < 2; half++) {
      const index = end - 1 + half;
      const at = offset + 3 * half;
      const from = 3 * this.place(index);
      for (let k = 0; k < 3; k++) this.positions.array[at + k] = this.points[from + k] ?? 0;
      this.shade(now - this.time(index)).toArray(this.colours.array, at);
    }
  }

  private shade(age: number): Color {
    const share = Math.min(1, age / SECONDS);
    return this.mixed.copy(this.colour).lerp(this.faded, 0.15 + 0.85 * share);
  }
}
