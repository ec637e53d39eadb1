// Where an object has been during the last seconds: a line that fades with age. Memory is fixed.

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

interface Step {
  at: number;
  position: Vec3;
}

export class Trail {
  readonly line: LineSegments2;
  private readonly steps: Step[] = [];
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
    const last = this.steps.at(-1);
    if (last && at - last.at < SPACING_S) return;
    this.steps.push({ at, position });
    if (this.steps.length > POINTS) this.steps.shift();
  }

  /** Rewrites the line as of `now`; tells whether there is still something that fades. */
  update(now: number): boolean {
    while (this.steps[0] && this.steps[0].at < now - SECONDS) this.steps.shift();
    let segments = 0;
    for (let i = 1; i < this.steps.length; i++) {
      const [from, to] = [this.steps[i - 1], this.steps[i]];
      if (from && to && to.at - from.at < GAP_S) this.write(segments++, from, to, now);
    }
    this.geometry.instanceCount = segments;
    this.positions.needsUpdate = this.colours.needsUpdate = segments > 0;
    return segments > 0;
  }

  remove(): void {
    this.geometry.dispose();
    this.line.material.dispose();
    this.line.removeFromParent();
  }

  private write(segment: number, from: Step, to: Step, now: number): void {
    const offset = segment * FLOATS;
    (this.positions.array as Float32Array).set(from.position, offset);
    (this.positions.array as Float32Array).set(to.position, offset + 3);
    this.shade(now - from.at).toArray(this.colours.array, offset);
    this.shade(now - to.at).toArray(this.colours.array, offset + 3);
  }

  private shade(age: number): Color {
    const share = Math.min(1, age / SECONDS);
    return this.mixed.copy(this.colour).lerp(this.faded, 0.15 + 0.85 * share);
  }
}
