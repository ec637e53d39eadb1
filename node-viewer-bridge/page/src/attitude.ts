// Attitude for people: quaternion (x, y, z, w) to roll, pitch and yaw.

import type { Quaternion, Vec3 } from "./protocol.ts";

export const DEGREES = 180 / Math.PI;

/**
 * Roll, pitch and yaw in degrees: R = Rz(yaw) Ry(pitch) Rx(roll), the order of ROS and aviation.
 * Roll and yaw are in (-180, 180], pitch in [-90, 90]; at |pitch| = 90 the roll is set to zero.
 */
export function rollPitchYaw([x, y, z, w]: Quaternion): Vec3 {
  const sinPitch = 2 * (w * y - z * x);
  if (Math.abs(sinPitch) > 1 - 1e-9) {
    const yaw = -2 * Math.sign(sinPitch) * Math.atan2(x, w);
    return [0, Math.sign(sinPitch) * 90, wrapDegrees(yaw * DEGREES)];
  }
  const roll = Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
  const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  return [roll * DEGREES, Math.asin(sinPitch) * DEGREES, yaw * DEGREES];
}

/** The quaternion of roll, pitch and yaw in degrees, as {@link rollPitchYaw} reads it. */
export function quaternionOf([roll, pitch, yaw]: Vec3): Quaternion {
  const [cr, cp, cy] = [roll, pitch, yaw].map((angle) => Math.cos(angle / DEGREES / 2)) as Vec3;
  const [sr, sp, sy] = [roll, pitch, yaw].map((angle) => Math.sin(angle / DEGREES / 2)) as Vec3;
  return [
    sr * cp * cy - cr * sp * sy,
    cr * sp * cy + sr * cp * sy,
    cr * cp * sy - sr * sp * cy,
    cr * cp * cy + sr * sp * sy,
  ];
}

/** An angle in (-180, 180]. */
export function wrapDegrees(angle: number): number {
  const turned = angle % 360;
  if (turned > 180) return turned - 360;
  return turned <= -180 ? turned + 360 : turned;
}
