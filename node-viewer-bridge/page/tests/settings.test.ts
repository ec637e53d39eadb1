import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { type CameraControls, parseMessage } from "../src/protocol.ts";
import { effect, inForce, isAnswered, readSetting, story, wantedBy, written } from "../src/settings.ts";
import { Wrong } from "../src/wizard/command.ts";

const golden = readFileSync(new URL("../../../../proto/golden/camera_status.json", import.meta.url), "utf8");
const status = parseMessage(JSON.stringify({ type: "camera_status", ...(JSON.parse(golden) as object) }));
assert.ok(status?.type === "camera_status");
const { controls } = status;

test("values are read in the units of people and written back alike", () => {
  assert.equal(readSetting("exposure_us", " 4,5 "), 4500);
  assert.equal(readSetting("gain", ""), null);
  assert.equal(readSetting("rate_hz", "29.97"), 29.97);
  assert.equal(written("exposure_us", 4500), "4.5");
  assert.equal(written("gain", null), "");
});

test("what is no value is complained of at its field", () => {
  for (const [key, text] of [["exposure_us", "0"], ["exposure_us", "2000"], ["gain", "-1"], ["rate_hz", "fast"]] as const)
    assert.throws(() => readSetting(key, text), (error) => error instanceof Wrong && error.field === key, text);
});

test("what is in force stands with its range", () => {
  assert.equal(inForce("exposure_us", controls.exposure_us), "now 3.9, 0.1 to 33");
  assert.equal(inForce("gain", controls.gain), "chosen by the camera");
  assert.equal(effect(status), "Mean grey level 119 of 255, 29.9 images/s".replace("29.9", status.rate_hz.toFixed(1)));
});

test("a camera has answered when it wants what was sent and is not waiting", () => {
  const sent = wantedBy(controls);
  assert.equal(isAnswered(controls, sent), true);
  assert.equal(isAnswered(controls, { ...sent, gain: 2 }), false);
  assert.equal(isAnswered({ ...controls, outcome: "pending" }, sent), false);
});

test("every outcome is a sentence, and what differs is a complaint", () => {
  const told = (outcome: CameraControls["outcome"]) => story({ ...controls, outcome });
  assert.equal(told("applied").isComplaint, false);
  assert.match(story(controls).text, /exposure 3900/);
  assert.deepEqual(told({ refused: { detail: "recorded" } }), { text: "The camera keeps what it had: recorded.", isComplaint: true });
});
