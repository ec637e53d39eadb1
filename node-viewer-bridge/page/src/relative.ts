// One object as another sees it: distance and relative attitude, with their standard deviations.

import { DEGREES, rollPitchYaw } from "./attitude.ts";
import { conjugate, product, rotate } from "./lens.ts";
import type { Pose, Quaternion, Vec3 } from "./protocol.ts";

/** b in the frame of a. */
export interface Relative {
  distance_m: number;
  /** Standard deviation of the distance. */
  distance_sigma_m: number;
  /** b's origin in a's frame, metres. */
  position: Vec3;
  /** Roll, pitch, yaw of b in a's frame, degrees. */
  attitude: Vec3;
  /** Angle between both attitudes, degrees. */
  angle_deg: number;
  angle_sigma_deg: number;
}

/**
 * The errors of the two poses are taken as independent; those of one camera move both objects alike, which makes real
 * distances between neighbours better than this says.
 */
export function relative(a: Pose, b: Pose): Relative {
  const apart: Vec3 = [b.position[0] - a.position[0], b.position[1] - a.position[1], b.position[2] - a.position[2]];
  const distance_m = Math.hypot(...apart);
  const back = conjugate(a.orientation);
  const turn = product(back, b.orientation);
  const angle = 2 * Math.atan2(Math.hypot(turn[0], turn[1], turn[2]), Math.abs(turn[3]));
  const axis = axisOf(turn);
  return {
    distance_m,
    distance_sigma_m: sigmaAlong(a, b, 0, unit(apart)),
    position: rotate(back, apart),
    attitude: rollPitchYaw(turn),
    angle_deg: angle * DEGREES,
    angle_sigma_deg: sigmaAlong(a, b, 3, rotate(a.orientation, axis)) * DEGREES,
  };
}

/**
 * Standard deviation of the difference of both poses along a unit vector of the world; from row 0 of position, from row
 * 3 of attitude.
 */
function sigmaAlong(a: Pose, b: Pose, from: 0 | 3, direction: Vec3): number {
  let variance = 0;
  for (let row = 0; row < 3; row++) {
    for (let column = 0; column < 3; column++) {
      const at = (from + row) * 6 + from + column;
      variance += (direction[row] ?? 0) * (direction[column] ?? 0) * ((a.covariance[at] ?? 0) + (b.covariance[at] ?? 0));
    }
  }
  return Math.sqrt(Math.max(0, variance));
}

function unit(vector: Vec3): Vec3 {
  const length = Math.hypot(...vector);
  return length > 0 ? [vector[0] / length, vector[1] / length, vector[2] / length] : [0, 0, 1];
}

const axisOf = ([x, y, z, w]: Quaternion): Vec3 => unit(w < 0 ? [-x, -y, -z] : [x, y, z]);
