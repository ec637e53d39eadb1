import assert from "node:assert/strict";
import { test } from "node:test";
import { onPicture, OutlineHistory, ReportHistory } from "../src/matching.ts";
import type { DetectionReport, Observations, TagOutline } from "../src/protocol.ts";

const MS = 1e6;

function tag(id: number, x: number): TagOutline {
  return { family: "tag36h11", id, hamming: 0, margin: 60, corners: [[x, 0], [x + 1, 0], [x + 1, 1], [x, 1]] };
}

function observed(t_ns: number, ...tags: TagOutline[]): Observations {
  return { camera: "north", sequence: 0, t_ns, received_ms: null, detected_ms: null, latency_ms: 0, resolution: [640, 480], tags };
}

test("outlines of the same capture time are taken as they are", () => {
  const history = new OutlineHistory();
  [0, 33, 66].forEach((ms) => history.add(observed(ms * MS, tag(1, ms))));
  assert.deepEqual(history.at(33 * MS), [tag(1, 33)]);
});

test("between two images outlines are interpolated, for tags that both show", () => {
  const history = new OutlineHistory();
  history.add(observed(40 * MS, tag(1, 40), tag(2, 0)));
  history.add(observed(0, tag(1, 0), tag(3, 0)));
  assert.deepEqual(history.at(10 * MS), [tag(1, 10)]);
});

test("the nearest outlines do until others come, but not from long ago", () => {
  const history = new OutlineHistory();
  history.add(observed(0, tag(1, 0)));
  assert.deepEqual(history.at(50 * MS), [tag(1, 0)]);
  assert.deepEqual(history.at(500 * MS), []);
});

test("the history is bounded", () => {
  const history = new OutlineHistory();
  for (let i = 0; i < 1000; i++) history.add(observed(i * 33 * MS, tag(1, i)));
  assert.deepEqual(history.at(0), []);
  assert.deepEqual(history.at(999 * 33 * MS), [tag(1, 999)]);
});

test("the centre of the first pixel scales with the picture", () => {
  assert.deepEqual(onPicture([-0.5, -0.5], [640, 480], [320, 240]), [0, 0]);
  assert.deepEqual(onPicture([639.5, 479.5], [640, 480], [320, 240]), [320, 240]);
  assert.deepEqual(onPicture([0, 0], [640, 480], [640, 480]), [0.5, 0.5]);
});

function report(ms: number): DetectionReport {
  const stage_ms = { tiles: 0, threshold: 0, components: 0, quads: 0, decode: 0, refine: 0 };
  const rejected = { not_a_quad: 0, shape: 0, faint_border: 0, no_code: 0, small_margin: 0 };
  const counts = { components: 0, candidates: 0, dropped: 0, tags: 0, rejected, examples: [] };
  return { camera: "north", sequence: ms, capture_ns: ms * MS, resolution: [640, 480], searched: 1, stage_ms, noise_sigma: 1, contrast_gate: 20, ...counts };
}

test("a picture gets the detector's report that is nearest, but none from long ago", () => {
  const history = new ReportHistory();
  [0, 200, 400].forEach((ms) => history.add(report(ms)));
  assert.deepEqual(history.near(290 * MS), report(200));
  assert.equal(history.near(2000 * MS), null);
  assert.deepEqual(history.newest, report(400));
});
