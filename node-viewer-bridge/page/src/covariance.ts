// What a 6x6 covariance (row-major; x, y, z, rx, ry, rz) says to people: two sigmas and an ellipsoid.

import { DEGREES } from "./attitude.ts";
import type { Vec3 } from "./protocol.ts";

type Matrix3 = [Vec3, Vec3, Vec3];

export interface Sigma {
  position_mm: number;
  attitude_deg: number;
}

export interface Ellipsoid {
  /** Standard deviations along the axes, metres. */
  radii: Vec3;
  /** Unit axes, right-handed. */
  axes: Matrix3;
}

/** Root of the summed variances: the expected length of the error, comparable to the distance from the truth. */
export function sigma(covariance: readonly number[]): Sigma {
  const summed = (from: number): number =>
    Math.sqrt(Math.max(0, variance(covariance, from) + variance(covariance, from + 1) + variance(covariance, from + 2)));
  return { position_mm: summed(0) * 1000, attitude_deg: summed(3) * DEGREES };
}

/** The 1-sigma ellipsoid of the position. */
export function positionEllipsoid(covariance: readonly number[]): Ellipsoid {
  const block = [0, 1, 2].map((row) => [0, 1, 2].map((column) => covariance[row * 6 + column] ?? 0)) as Matrix3;
  const { values, vectors } = symmetricEigen(block);
  const radii = values.map((value) => Math.sqrt(Math.max(0, value))) as Vec3;
  return { radii, axes: rightHanded(vectors) };
}

function variance(covariance: readonly number[], index: number): number {
  return covariance[index * 6 + index] ?? 0;
}

function rightHanded([a, b, c]: Matrix3): Matrix3 {
  const cross: Vec3 = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const handedness = cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2];
  return handedness < 0 ? [a, b, [-c[0], -c[1], -c[2]]] : [a, b, c];
}

const SWEEPS = 12;

/** Eigenvalues and unit eigenvectors of a symmetric matrix by cyclic Jacobi rotations (Golub and Van Loan, 8.5). */
export function symmetricEigen(matrix: Matrix3): { values: Vec3; vectors: Matrix3 } {
  const a = matrix.map((row) => [...row]) as Matrix3;
  const v: Matrix3 = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    rotate(a, v, 0, 1);
    rotate(a, v, 0, 2);
    rotate(a, v, 1, 2);
  }
  const column = (k: 0 | 1 | 2): Vec3 => [v[0][k], v[1][k], v[2][k]];
  return { values: [a[0][0], a[1][1], a[2][2]], vectors: [column(0), column(1), column(2)] };
}

function rotate(a: Matrix3, v: Matrix3, p: 0 | 1, q: 1 | 2): void {
  if (a[p][q] === 0) return;
  const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  if (!Number.isFinite(t)) return;
  const c = 1 / Math.hypot(t, 1);
  const s = t * c;
  for (const row of a) turn(row, p, q, c, s);
  for (let k = 0; k < 3; k++) {
    const i = k as 0 | 1 | 2;
    const [ap, aq] = [a[p][i], a[q][i]];
    a[p][i] = c * ap - s * aq;
    a[q][i] = s * ap + c * aq;
  }
  for (const row of v) turn(row, p, q, c, s);
}

function turn(row: Vec3, p: 0 | 1, q: 1 | 2, c: number, s: number): void {
  const [rp, rq] = [row[p], row[q]];
  row[p] = c * rp - s * rq;
  row[q] = s * rp + c * rq;
}
