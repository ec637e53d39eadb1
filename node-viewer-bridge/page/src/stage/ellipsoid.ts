// The uncertainty of an object's position as an ellipsoid, magnified: real ones are too small to see.

import { Matrix4, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import { positionEllipsoid } from "../covariance.ts";
import type { Pose } from "../protocol.ts";

/** The drawn semi-axes are this many standard deviations. */
export const MAGNIFICATION = 100;
const LARGEST_M = 1;
const SMALLEST_M = 1e-4;

export class Ellipsoid {
  readonly mesh: Mesh<SphereGeometry, MeshBasicMaterial>;
  private readonly basis = new Matrix4();
  private readonly columns: [Vector3, Vector3, Vector3] = [new Vector3(), new Vector3(), new Vector3()];

  constructor(colour: string) {
    const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.26, depthWrite: false });
    this.mesh = new Mesh(new SphereGeometry(1, 28, 18), material);
    this.mesh.visible = false;
  }

  show(pose: Pose): void {
    const { radii, axes } = positionEllipsoid(pose.covariance);
    this.columns.forEach((column, k) => column.fromArray(axes[k as 0 | 1 | 2]));
    this.mesh.quaternion.setFromRotationMatrix(this.basis.makeBasis(...this.columns));
    this.mesh.position.fromArray(pose.position);
    const drawn = radii.map((radius) => Math.min(LARGEST_M, Math.max(SMALLEST_M, radius * MAGNIFICATION)));
    this.mesh.scale.fromArray(drawn);
  }

  remove(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.removeFromParent();
  }
}
