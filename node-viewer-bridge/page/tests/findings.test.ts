import assert from "node:assert/strict";
import { test } from "node:test";
import { readFileSync } from "node:fs";
import { cameraReports, reports, type CameraFindings, type Findings, type Report } from "../src/findings.ts";
import { parseMessage } from "../src/protocol.ts";

const sentence = ({ cause, remedy }: Report): string => (remedy ? `${cause}: ${remedy}` : cause);

/** The golden status: every fault, imperfection, notice and refusal of the contract once. */
const golden = readFileSync(new URL("../../../../proto/golden/fusion_status.json", import.meta.url), "utf8");

test("every finding of the contract has a sentence", () => {
  const message = parseMessage(JSON.stringify({ type: "fusion_status", ...(JSON.parse(golden) as object) }));
  assert.ok(message?.type === "fusion_status");
  const told = reports("fusion", message);
  const said = told.map(sentence);
  assert.equal(said.length, message.faults.length + 1 + message.imperfections.length + message.notices.length);
  for (const text of said) {
    assert.doesNotMatch(text, /undefined|\[object|NaN/);
    assert.match(text, / /);
  }
  assert.equal(new Set(told.map((report) => report.key)).size, told.length);
  const moved = told.find((report) => report.key.includes("camera_moved"));
  assert.deepEqual(moved?.subject, { kind: "camera", id: "north" });
  assert.ok(said.includes("camera north is not where the rig says: calibrate it again"));
  assert.ok(said.some((text) => text.includes("refused: tag tag25h9:300 is on object cube and on object box")));
});

test("notices are as severe as nodes say", () => {
  const golden = (name: string): object => JSON.parse(readFileSync(new URL(`../../../../proto/golden/${name}.json`, import.meta.url), "utf8")) as object;
  const severities = golden("severities") as Record<"notices" | "camera_notices", Record<string, string>>;
  const fusion = parseMessage(JSON.stringify({ type: "fusion_status", ...golden("fusion_status") }));
  const camera = parseMessage(JSON.stringify({ type: "camera_status", ...golden("camera_status") }));
  assert.ok(fusion?.type === "fusion_status" && camera?.type === "camera_status");
  const told = [...reports("fusion", fusion), ...cameraReports("north", camera)];
  for (const [names, marker] of [[severities.notices, "/notice/"], [severities.camera_notices, "north/status/"]] as const)
    for (const [name, severity] of Object.entries(names)) {
      const report = told.find(({ key }) => key.includes(`${marker}${name}`));
      assert.equal(report?.severity, severity, name);
    }
  assert.ok(told.filter(({ key }) => key.includes("/fault/")).every(({ severity }) => severity === "fault"));
  assert.ok(told.filter(({ key }) => key.includes("/imperfection/")).every(({ severity }) => severity === "information"));
});

test("every notice of a camera has a sentence", () => {
  const golden = readFileSync(new URL("../../../../proto/golden/camera_status.json", import.meta.url), "utf8");
  const message = parseMessage(JSON.stringify({ type: "camera_status", ...(JSON.parse(golden) as object) }));
  assert.ok(message?.type === "camera_status");
  const said = cameraReports("north", message).map(sentence);
  assert.equal(said.length, 2 + message.notices.length);
  assert.ok(said.includes("The site's settings are applied as far as the camera can: exposure 3900 µs instead of 4000"));
  for (const text of said) {
    assert.doesNotMatch(text, /undefined|\[object|NaN/);
    assert.match(text, / /);
  }
  assert.ok(said.includes("the CPU made 31 images in place of the accelerator: see the log of the capturing part"));
});

test("the settings that a camera refuses are reported, and those that it applies are not", () => {
  const told = (outcome: CameraFindings["controls"]["outcome"]): string[] =>
    cameraReports("north", { fallbacks: 0, controls: { outcome }, notices: [] }).map(sentence);
  assert.deepEqual(told({ refused: { detail: "the camera is gone" } }), ["The camera keeps what it had: the camera is gone"]);
  assert.deepEqual(told("applied"), []);
});

test("a finding that the page does not know is named", () => {
  const none: Findings = { faults: [], faults_left_out: 0, imperfections: [], notices: [] };
  const told = reports("fusion", { ...none, faults: [{ lens_fogged: { camera: "north" } }, "storm"] as never[] });
  assert.deepEqual(told.map(sentence), ["lens fogged", "storm"]);
  assert.deepEqual(told.map((report) => report.subject.id), ["north", "fusion"]);
});
