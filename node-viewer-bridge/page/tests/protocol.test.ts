import assert from "node:assert/strict";
import { test } from "node:test";
import { parseMessage, parsePreview } from "../src/protocol.ts";

const pose = {
  type: "pose",
  object: "cube",
  sequence: 1,
  t_ns: 1790000000000000000,
  position: [0, 0, 0],
  orientation: [0, 0, 0, 1],
  covariance: Array.from({ length: 36 }, () => 0),
  twist: [0, 0, 0, 0, 0, 0],
  state: "tracking",
  cameras: 1,
  tags: 1,
  rms_px: 0.1,
  latency_ms: 20,
};
const read = (message: object): unknown => parseMessage(JSON.stringify(message));

test("a whole message is read", () => {
  assert.deepEqual(read(pose), pose);
});

test("fields that the page does not know are no fault", () => {
  assert.notEqual(read({ ...pose, invented: true }), null);
});

test("a message with a missing or wrong field is none", () => {
  for (const wrong of [{ position: [0, 0] }, { state: "asleep" }, { covariance: [] }, { object: 3 }, { rms_px: null }]) {
    assert.equal(read({ ...pose, ...wrong }), null, JSON.stringify(wrong));
  }
});

const detection = {
  type: "detection_report",
  camera: "north",
  sequence: 7,
  capture_ns: 1790000000000000000,
  resolution: [640, 480],
  searched: 1,
  stage_ms: { tiles: 0.1, threshold: 0.1, components: 0.1, quads: 0.1, decode: 0.1, refine: 0.1 },
  noise_sigma: 1.5,
  contrast_gate: 20,
  components: 9,
  candidates: 4,
  dropped: 0,
  tags: 1,
  rejected: { not_a_quad: 1, shape: 0, faint_border: 0, no_code: 2, small_margin: 0 },
  examples: [{ cause: "no_code", corners: [[0, 0], [1, 0], [1, 1], [0, 1]] }],
};

test("a detection report is read whole or not at all", () => {
  assert.notEqual(read(detection), null);
  const corners = detection.examples[0]?.corners;
  for (const wrong of [{ examples: [{ cause: "bad_luck", corners }] }, { stage_ms: { tiles: 1 } }, { rejected: {} }]) {
    assert.equal(read({ ...detection, ...wrong }), null, JSON.stringify(wrong));
  }
});

test("what a fusion node offers is read whole or not at all", () => {
  const offer = { type: "proposal", node: "fusion", t_ns: 1, rig: true, objects: ["cube"], n_images: 24, before_px: 0.9, after_px: 0.4 };
  assert.notEqual(read(offer), null);
  assert.notEqual(read({ ...offer, type: "former" }), null);
  for (const wrong of [{ rig: 1 }, { objects: [3] }, { node: null }]) assert.equal(read({ ...offer, ...wrong }), null);
});

test("an unknown type and text that is no message are none", () => {
  for (const text of ['{"type":"weather"}', '{"type":"toString"}', "[]", "null", "7", "{", ""]) {
    assert.equal(parseMessage(text), null, text);
  }
});

test("a camera without a pose in the world is read", () => {
  const lens = { model: "pinhole", fx: 1, fy: 1, cx: 0, cy: 0 };
  const camera = { id: "north", resolution: [640, 480], lens, world_from_camera: null, version: "1" };
  assert.notEqual(read({ type: "rig", cameras: [camera] }), null);
});

function previewFrame(kind: number, id: string, time: bigint, picture: number[]): ArrayBuffer {
  const bytes = [kind, id.length, ...new TextEncoder().encode(id), ...new Uint8Array(8), ...picture];
  const frame = new Uint8Array(bytes);
  new DataView(frame.buffer).setBigUint64(2 + id.length, time, true);
  return frame.buffer;
}

test("a preview names its camera and time", () => {
  const preview = parsePreview(previewFrame(1, "north", 1790000000000000000n, [0xff, 0xd8]));
  assert.equal(preview?.camera, "north");
  assert.equal(preview?.t_ns, 1790000000000000000);
  assert.deepEqual([...(preview?.jpeg ?? [])], [0xff, 0xd8]);
});

test("a truncated preview and one of another kind are none", () => {
  const whole = previewFrame(1, "north", 1n, [1]);
  for (let length = 0; length < whole.byteLength; length++) assert.equal(parsePreview(whole.slice(0, length)), null);
  assert.equal(parsePreview(previewFrame(9, "north", 1n, [1])), null);
});
