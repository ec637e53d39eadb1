import assert from "node:assert/strict";
import { test } from "node:test";
import { rollPitchYaw, wrapDegrees } from "../src/attitude.ts";
import { positionEllipsoid, sigma, symmetricEigen } from "../src/covariance.ts";
import { clockFigure, clockStory, count, fixed, magnitude, NONE, plural } from "../src/format.ts";
import { RateMeter, Recent } from "../src/measure.ts";
import type { Quaternion, Vec3 } from "../src/protocol.ts";

const close = (actual: number, expected: number, tolerance = 1e-9): void =>
  assert.ok(Math.abs(actual - expected) <= tolerance, `${actual} is not ${expected}`);

/** Rz(yaw) Ry(pitch) Rx(roll) as a quaternion, by half angles. */
function fromRollPitchYaw([roll, pitch, yaw]: Vec3): Quaternion {
  const [cr, cp, cy] = [roll, pitch, yaw].map((a) => Math.cos((a * Math.PI) / 360)) as Vec3;
  const [sr, sp, sy] = [roll, pitch, yaw].map((a) => Math.sin((a * Math.PI) / 360)) as Vec3;
  return [
    sr * cp * cy - cr * sp * sy,
    cr * sp * cy + sr * cp * sy,
    cr * cp * sy - sr * sp * cy,
    cr * cp * cy + sr * sp * sy,
  ];
}

test("roll, pitch and yaw come back from their quaternion", () => {
  for (const roll of [-179, -30, 0, 75, 179]) {
    for (const pitch of [-89, -20, 0, 45, 89]) {
      for (const yaw of [-179, -90, 0, 10, 180]) {
        const back = rollPitchYaw(fromRollPitchYaw([roll, pitch, yaw]));
        [roll, pitch, yaw].forEach((angle, axis) => close(wrapDegrees((back[axis] ?? NaN) - angle), 0, 1e-6));
      }
    }
  }
});

test("looking straight up has no roll and stays finite", () => {
  for (const pitch of [90, -90]) {
    const [roll, back, yaw] = rollPitchYaw(fromRollPitchYaw([0, pitch, 40]));
    assert.equal(roll, 0);
    close(back, pitch, 1e-4);
    close(yaw, 40, 1e-4);
  }
});

test("angles wrap into one turn", () => {
  assert.deepEqual([181, -180, 540, -10].map(wrapDegrees), [-179, 180, 180, -10]);
});

test("sigma is the expected length of the error", () => {
  const covariance = Array.from({ length: 36 }, (_, i) => (i % 7 === 0 ? (i < 18 ? 1e-6 : 1e-4) : 0));
  close(sigma(covariance).position_mm, Math.sqrt(3));
  close(sigma(covariance).attitude_deg, (Math.sqrt(3) * 0.01 * 180) / Math.PI);
});

test("eigenvectors and eigenvalues rebuild their matrix", () => {
  const matrix: [Vec3, Vec3, Vec3] = [[4, 1, -2], [1, 3, 0.5], [-2, 0.5, 5]];
  const { values, vectors } = symmetricEigen(matrix);
  for (const i of [0, 1, 2] as const) {
    for (const j of [0, 1, 2] as const) {
      const rebuilt = [0, 1, 2].reduce((sum, k) => sum + (values[k] ?? 0) * (vectors[k]?.[i] ?? 0) * (vectors[k]?.[j] ?? 0), 0);
      close(rebuilt, matrix[i][j], 1e-9);
    }
  }
});

test("an ellipsoid has right-handed axes and no imaginary radius", () => {
  const covariance = Array.from({ length: 36 }, () => 0);
  [covariance[0], covariance[7], covariance[14], covariance[1], covariance[6]] = [1e-6, 1e-6, -1e-9, 2e-6, 2e-6];
  const { radii, axes: [a, b, c] } = positionEllipsoid(covariance);
  assert.ok(radii.every((radius) => Number.isFinite(radius) && radius >= 0));
  const cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  cross.forEach((value, axis) => close(value, c[axis] ?? NaN));
});

test("numbers are written for people", () => {
  assert.deepEqual([fixed(-1.25, 1), fixed(-0.01, 1), fixed(3, 2), fixed(NaN, 1), fixed(null, 1)], ["−1.3", "0.0", "3.00", NONE, NONE]);
  assert.deepEqual([0.123, 3.14159, 27.18, null].map(magnitude), ["0.12", "3.1", "27", NONE]);
  assert.deepEqual([9999, 12345, 4.56e6].map(count), ["9999", "12.3k", "4.6M"]);
  assert.deepEqual([plural(1, "camera"), plural(0, "camera")], ["1 camera", "0 cameras"]);
});

test("a rate counts skipped messages, forgets old ones and survives a restart of the sender", () => {
  const meter = new RateMeter(2);
  for (let i = 0; i <= 10; i++) meter.add(i / 10, i * 12);
  close(meter.rate(1) ?? NaN, 120);
  assert.equal(meter.rate(60), null);
  for (let i = 0; i <= 10; i++) meter.add(100 + i / 10, i * 3);
  close(meter.rate(101) ?? NaN, 30);
});

test("recent values are a window", () => {
  const recent = new Recent(3);
  assert.equal(recent.median(), null);
  for (const value of [100, 3, 4, 5]) recent.add(value);
  assert.equal(recent.median(), 4);
  close(recent.rootMeanSquare() ?? NaN, Math.sqrt((9 + 16 + 25) / 3));
});

test("a clock is its offset where the images tell it, else what keeps it", () => {
  const stated = { source: "ntp" as const, error_ns: 250_000 };
  const found = { camera: "north", offset_s: -0.0125, sigma_s: 0.0001, drift: 25e-6 };
  assert.deepEqual([clockFigure(found, stated), clockFigure(null, stated), clockFigure(null, null)], ["−12.5 ms", "ntp", NONE]);
  const story = clockStory(found, stated);
  for (const part of ["ntp", "0.25 ms", "−12.50 ms", "0.10 ms", "+25 ppm"]) assert.ok(story.includes(part), story);
  assert.equal(clockStory(null, null), "");
});
