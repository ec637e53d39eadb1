import assert from "node:assert/strict";
import { test } from "node:test";
import { blankPose } from "../src/history.ts";
import { project, projectWorld } from "../src/lens.ts";
import type { LensModel, Observations, Point, PrintedTag, RigCamera, RigLens, Vec3 } from "../src/protocol.ts";
import { relative } from "../src/relative.ts";
import { facesCamera, projectedTag, rmsResidual } from "../src/residuals.ts";

const near = (actual: Point | null, expected: Point): void => {
  assert.ok(actual);
  expected.forEach((value, k) => assert.ok(Math.abs((actual[k] ?? NaN) - value) < 1e-6, `${String(actual)} is not ${String(expected)}`));
};
const lens = (model: LensModel, distortion: number[] = []): RigLens => ({ model, fx: 500, fy: 510, cx: 320, cy: 240, distortion });

test("each lens model projects as its formula says", () => {
  const point: Vec3 = [0.3, -0.2, 1];
  near(project(lens("pinhole"), point), [470, 138]);
  // Worked out by hand: s = 0.13, R = 1 - 0.2 s + 0.05 s^2 + 0.01 s^3.
  const radial = 1 - 0.2 * 0.13 + 0.05 * 0.0169 + 0.01 * 0.002197;
  const x = 0.3 * radial + 2 * 0.001 * 0.3 * -0.2 + -0.002 * (0.13 + 2 * 0.09);
  const y = -0.2 * radial + 0.001 * (0.13 + 2 * 0.04) + 2 * -0.002 * 0.3 * -0.2;
  near(project(lens("brown-conrady", [-0.2, 0.05, 0.001, -0.002, 0.01]), point), [320 + 500 * x, 240 + 510 * y]);
  // A fisheye without coefficients: the distance from the centre is the angle.
  near(project(lens("kannala-brandt", [0, 0, 0, 0]), [1, 0, 1]), [320 + (500 * Math.PI) / 4, 240]);
  near(project(lens("kannala-brandt", [0.1, 0, 0, 0]), [0, 0, 2]), [320, 240]);
});

test("what lies behind a camera or far off its axis is not seen", () => {
  for (const model of ["pinhole", "brown-conrady", "kannala-brandt"] as const) {
    assert.equal(project(lens(model), [0.1, 0, -1]), null);
  }
  assert.equal(project(lens("brown-conrady"), [5, 0, 1]), null);
});

// Two metres above the floor, looking straight down: x right, y towards the viewer of the map.
const camera: RigCamera = {
  id: "top",
  resolution: [640, 480],
  lens: lens("pinhole"),
  world_from_camera: { position: [0, 0, 2], orientation: [1, 0, 0, 0] },
  version: "1",
};
const tag: PrintedTag = {
  family: "tag36h11", id: 3, size_m: 0.1, printed_size_m: 0.125, modules: [],
  object_from_tag: { position: [0, 0, 0], orientation: [0, 0, 0, 1] },
};

test("a tag on the floor is seen upright and clockwise from above", () => {
  near(projectWorld(camera, [0.1, 0.2, 0]), [345, 189]);
  const corners = projectedTag(camera, blankPose("cube"), tag);
  assert.ok(corners);
  near(corners[0] ?? null, [307.5, 227.25]);
  assert.ok(facesCamera(corners));
  const face_down = { ...blankPose("cube"), orientation: [1, 0, 0, 0] as [number, number, number, number] };
  assert.equal(facesCamera(projectedTag(camera, face_down, tag) ?? []), false);
});

test("the residual is the distance of seen from projected corners", () => {
  const pose = blankPose("cube");
  const corners = (projectedTag(camera, pose, tag) ?? []).map(([u, v]) => [u + 0.3, v - 0.4]) as [Point, Point, Point, Point];
  const image: Observations = {
    camera: "top", sequence: 1, t_ns: 1, received_ms: null, detected_ms: null, latency_ms: 1, resolution: [640, 480],
    tags: [3, 9].map((id) => ({ family: "tag36h11", id, hamming: 0, margin: 60, corners })),
  };
  const owner = (_: string, id: number) => (id === 3 ? { tags: [tag], pose } : null);
  assert.ok(Math.abs((rmsResidual(camera, image, owner) ?? NaN) - 0.5) < 1e-9);
  assert.equal(rmsResidual(camera, image, () => null), null);
});

test("one object in the frame of another, with sigmas", () => {
  const [sin, cos] = [Math.sin(Math.PI / 4), Math.cos(Math.PI / 4)];
  const isotropic = (sigma: number): number[] => Array.from({ length: 36 }, (_, k) => (k % 7 === 0 ? sigma * sigma : 0));
  const a = { ...blankPose("a"), position: [1, 0, 0] as Vec3, orientation: [0, 0, sin, cos] as [number, number, number, number], covariance: isotropic(0.003) };
  const b = { ...blankPose("b"), position: [1, 2, 0] as Vec3, covariance: isotropic(0.004) };
  const found = relative(a, b);
  assert.ok(Math.abs(found.distance_m - 2) < 1e-12);
  assert.ok(Math.abs(found.distance_sigma_m - 0.005) < 1e-12);
  assert.deepEqual(found.position.map((value) => Math.round(value * 1e9) / 1e9 + 0), [2, 0, 0]);
  assert.ok(Math.abs(found.attitude[2] + 90) < 1e-9);
  assert.ok(Math.abs(found.angle_deg - 90) < 1e-9);
  assert.ok(Math.abs(found.angle_sigma_deg - (0.005 * 180) / Math.PI) < 1e-9);
});
