// From the protocol's transforms to three.js.

import type { Object3D } from "three";
import type { Transform } from "../protocol.ts";

/** Puts something where a transform into its parent's frame says. */
export function place(thing: Object3D, pose: Transform): void {
  thing.position.fromArray(pose.position);
  thing.quaternion.fromArray(pose.orientation);
}
