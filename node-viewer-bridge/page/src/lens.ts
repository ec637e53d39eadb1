// From points of the world to pixels of a camera's image, lens distortion included: `rig.toml`'s models
// (crates/geometry/src/lens).

import type { RigLens, Point, Quaternion, RigCamera, Transform, Vec3 } from "./protocol.ts";

/** Rotates a vector by a quaternion. */
export function rotate([x, y, z, w]: Quaternion, [a, b, c]: Vec3): Vec3 {
  const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

export const conjugate = ([x, y, z, w]: Quaternion): Quaternion => [-x, -y, -z, w];

/** First b, then a. */
export function product([ax, ay, az, aw]: Quaternion, [bx, by, bz, bw]: Quaternion): Quaternion {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

/** The transform of what has `inner` in the frame of `outer`. */
export function composed(outer: Transform, inner: Transform): Transform {
  return { position: transformed(outer, inner.position), orientation: product(outer.orientation, inner.orientation) };
}

/** A point of the transform's own frame in its parent's. */
export function transformed({ position, orientation }: Transform, point: Vec3): Vec3 {
  const [x, y, z] = rotate(orientation, point);
  return [x + position[0], y + position[1], z + position[2]];
}

/** A point of the parent's frame in the transform's own. */
export function intoFrame({ position, orientation }: Transform, [x, y, z]: Vec3): Vec3 {
  return rotate(conjugate(orientation), [x - position[0], y - position[1], z - position[2]]);
}

/** Beyond this angle off the axis the polynomials of a lens mean nothing. */
const WIDEST_RAD = { pinhole: 1.4, "brown-conrady": 1.2, "kannala-brandt": 1.65 } as const;

/** The pixel of a point of the camera's frame; none behind it or far outside its field. */
export function project(lens: RigLens, [x, y, z]: Vec3): Point | null {
  const angle = Math.atan2(Math.hypot(x, y), z);
  const widest = WIDEST_RAD[lens.model as keyof typeof WIDEST_RAD] ?? WIDEST_RAD.pinhole;
  if (!(angle < widest)) return null;
  const [u, v] = distorted(lens, x, y, z, angle);
  return [lens.fx * u + lens.cx, lens.fy * v + lens.cy];
}

function distorted({ model, distortion = [] }: RigLens, x: number, y: number, z: number, angle: number): Point {
  if (model === "kannala-brandt") {
    const [k1 = 0, k2 = 0, k3 = 0, k4 = 0] = distortion;
    const s = angle * angle;
    const bent = angle * (1 + s * (k1 + s * (k2 + s * (k3 + s * k4))));
    const scale = bent / (Math.hypot(x, y) || 1);
    return [x * scale, y * scale];
  }
  const [a, b] = [x / z, y / z];
  if (model !== "brown-conrady") return [a, b];
  const [k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0] = distortion;
  const s = a * a + b * b;
  const radial = 1 + s * (k1 + s * (k2 + s * k3));
  return [a * radial + 2 * p1 * a * b + p2 * (s + 2 * a * a), b * radial + p1 * (s + 2 * b * b) + 2 * p2 * a * b];
}

/** The pixel of a point of the world; none where the camera has no pose or cannot see it. */
export function projectWorld(camera: RigCamera, point: Vec3): Point | null {
  return camera.world_from_camera ? project(camera.lens, intoFrame(camera.world_from_camera, point)) : null;
}

/** A tag's corners in its own frame: top left, top right, bottom right, bottom left. */
export function tagCorners(size: number): [Vec3, Vec3, Vec3, Vec3] {
  const half = size / 2;
  return [[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]];
}
