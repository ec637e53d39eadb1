// The uncertainty of an object's position as an ellipsoid, magnified: real ones are too small to see. It shows through
// bodies: inside one it would be hidden otherwise.

import { BufferGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import { positionEllipsoid } from "../covariance.ts";
import { STAGE } from "../palette.ts";
import type { Pose } from "../protocol.ts";
import { dispose } from "./dispose.ts";

/** The drawn semi-axes are this many standard deviations. */
export const MAGNIFICATION = 100;
const LARGEST_M = 1;
const SMALLEST_M = 1e-4;
/** After everything else. */
const LAST = 1;

export class Ellipsoid {
  readonly group = new Group();
  private readonly line = new LineBasicMaterial({ color: STAGE.ruler, transparent: true, opacity: 0.5, depthTest: false });
  private readonly basis = new Matrix4();
  private readonly columns: [Vector3, Vector3, Vector3] = [new Vector3(), new Vector3(), new Vector3()];

  constructor(colour: string) {
    const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.3, depthTest: false, depthWrite: false });
    const parts = [new Mesh(new SphereGeometry(1, 28, 18), material), new LineSegments(greatCircles(), this.line)];
    for (const part of parts) part.renderOrder = LAST;
    this.group.add(...parts);
    this.group.visible = false;
  }

  show(pose: Pose): void {
    const { radii, axes } = positionEllipsoid(pose.covariance);
    this.columns.forEach((column, k) => column.fromArray(axes[k as 0 | 1 | 2]));
    this.group.quaternion.setFromRotationMatrix(this.basis.makeBasis(...this.columns));
    this.group.position.fromArray(pose.position);
    const drawn = radii.map((radius) => Math.min(LARGEST_M, Math.max(SMALLEST_M, radius * MAGNIFICATION)));
    this.group.scale.fromArray(drawn);
  }

  recolour(): void {
    this.line.color.set(STAGE.ruler);
  }

  remove(): void {
    dispose(this.group);
    this.group.removeFromParent();
  }
}

/** The unit circles across the three axes, in segments. */
function greatCircles(): BufferGeometry {
  const SEGMENTS = 48;
  const points: Vector3[] = [];
  for (let axis = 0; axis < 3; axis++)
    for (let k = 0; k < 2 * SEGMENTS; k++) {
      const angle = (Math.ceil(k / 2) * 2 * Math.PI) / SEGMENTS;
      const point = [0, 0, 0];
      point[axis] = Math.cos(angle);
      point[(axis + 1) % 3] = Math.sin(angle);
      points.push(new Vector3().fromArray(point));
    }
  return new BufferGeometry().setFromPoints(points);
}
