// The line between two measured objects, with the distance at its middle.

import { BufferGeometry, Float32BufferAttribute, Line, LineBasicMaterial, type Vector3 } from "three";
import { fixed } from "../format.ts";
import { STAGE } from "../palette.ts";
import type { Label, LabelLayer } from "./labels.ts";

export class Ruler {
  readonly line: Line<BufferGeometry, LineBasicMaterial>;
  private readonly label: Label;
  private readonly ends = new Float32BufferAttribute(new Float32Array(6), 3);

  constructor(labels: LabelLayer) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.ends);
    this.line = new Line(geometry, new LineBasicMaterial({ color: STAGE.ruler, depthTest: false, transparent: true, opacity: 0.8 }));
    this.line.frustumCulled = false;
    this.line.renderOrder = 1;
    this.label = labels.create("ruler", "");
    this.hide();
  }

  show(from: Vector3, to: Vector3): void {
    this.ends.setXYZ(0, from.x, from.y, from.z);
    this.ends.setXYZ(1, to.x, to.y, to.z);
    this.ends.needsUpdate = true;
    this.label.at.copy(from).add(to).multiplyScalar(0.5);
    this.label.text = `${fixed(1000 * from.distanceTo(to), 1)} mm`;
    this.line.visible = this.label.visible = true;
  }

  hide(): void {
    this.line.visible = this.label.visible = false;
  }

  recolour(): void {
    this.line.material.color.set(STAGE.ruler);
  }
}
