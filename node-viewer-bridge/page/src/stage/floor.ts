// The floor z = 0: a grid in round metres that fades outwards, and the world's axes at its origin.

import {
  BufferGeometry,
  CircleGeometry,
  Color,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  Vector3,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { STAGE } from "../palette.ts";
import { dispose } from "./dispose.ts";
import type { Label, LabelLayer } from "./labels.ts";

const STEPS_M = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const LINES_ACROSS = 24;
const PIECES = 24;

export class Floor {
  readonly group = new Group();
  private radius = 0;
  private axisLabels: Label[] = [];

  constructor(private readonly labels: LabelLayer) {}

  /** Spans at least `radius` metres around the origin; rebuilt only when that changes visibly. */
  span(radius: number): void {
    if (Math.abs(radius - this.radius) < 0.05 * this.radius) return;
    this.build(radius);
  }

  /** As the theme has it. */
  recolour(): void {
    if (this.radius > 0) this.build(this.radius);
  }

  private build(radius: number): void {
    this.radius = radius;
    dispose(this.group);
    const step = STEPS_M.find((candidate) => (2 * radius) / candidate <= LINES_ACROSS) ?? radius / 10;
    this.group.add(disc(radius), grid(radius, step), this.axes(Math.max(step, radius * 0.12)));
  }

  private axes(length: number): LineSegments2 {
    this.axisLabels.forEach((label) => this.labels.remove(label));
    this.axisLabels = ["x", "y", "z"].map((name, axis) => {
      const label = this.labels.create("axis", name);
      label.at.setComponent(axis, length * 1.16);
      return label;
    });
    const geometry = new LineSegmentsGeometry();
    const tip = (axis: number): number[] => new Vector3().setComponent(axis, length).toArray();
    geometry.setPositions([0, 1, 2].flatMap((axis) => [0, 0, 0, ...tip(axis)]));
    geometry.setColors(STAGE.axes.flatMap((colour) => [...new Color(colour).toArray(), ...new Color(colour).toArray()]));
    return new LineSegments2(geometry, new LineMaterial({ vertexColors: true, linewidth: 2.5 }));
  }
}

function disc(radius: number): Mesh {
  const geometry = new CircleGeometry(radius, 64);
  const [inner, outer] = [new Color(STAGE.floor), new Color(STAGE.background)];
  const colours = Array.from({ length: geometry.getAttribute("position").count }, (_, i) => (i === 0 ? inner : outer));
  geometry.setAttribute("color", new Float32BufferAttribute(colours.flatMap((colour) => colour.toArray()), 3));
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ vertexColors: true, depthWrite: false }));
  mesh.renderOrder = -2;
  return mesh;
}

function grid(radius: number, step: number): LineSegments {
  const positions: number[] = [];
  const colours: number[] = [];
  const background = new Color(STAGE.background);
  const vertex = (x: number, y: number, line: Color): void => {
    positions.push(x, y, 0);
    const fade = Math.min(1, Math.hypot(x, y) / radius) ** 2;
    colours.push(...line.clone().lerp(background, fade).toArray());
  };
  const lines = Math.floor(radius / step);
  for (let i = -lines; i <= lines; i++) {
    const colour = new Color(i % 5 === 0 ? STAGE.gridMajor : STAGE.gridMinor);
    const half = Math.sqrt(Math.max(0, radius * radius - i * step * i * step));
    for (let piece = 0; piece < PIECES; piece++) {
      const [from, to] = [piece, piece + 1].map((k) => half * ((2 * k) / PIECES - 1)) as [number, number];
      vertex(i * step, from, colour);
      vertex(i * step, to, colour);
      vertex(from, i * step, colour);
      vertex(to, i * step, colour);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
  const segments = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true, depthWrite: false }));
  segments.renderOrder = -1;
  return segments;
}
