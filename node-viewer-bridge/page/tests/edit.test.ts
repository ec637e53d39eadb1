import assert from "node:assert/strict";
import { test } from "node:test";
import { quaternionOf, rollPitchYaw } from "../src/attitude.ts";
import { keepUntouched, readOrientation, readPosition, readSigma } from "../src/edit/values.ts";
import { writtenLength, writtenOrientation, writtenPosition } from "../src/edit/values.ts";
import type { Quaternion, Vec3 } from "../src/protocol.ts";
import { post, sentence, Wrong } from "../src/wizard/command.ts";

const complains = (field: string, action: () => unknown): void => {
  assert.throws(action, (error) => error instanceof Wrong && error.field === field && error.message.length > 10);
};

test("angles become the quaternion that shows these angles", () => {
  const cases: Vec3[] = [[0, 0, 0], [10, 20, 30], [-121.2, 5, 175], [180, 0, 0], [0, 89, -90], [-30, -60, 10]];
  for (const angles of cases) {
    const quaternion = quaternionOf(angles);
    assert.ok(Math.abs(Math.hypot(...quaternion) - 1) < 1e-12);
    const read = rollPitchYaw(quaternion);
    read.forEach((angle, at) => assert.ok(Math.abs(angle - angles[at]!) < 1e-9, `${angles} as ${read}`));
  }
});

test("a yaw of 90 degrees turns x to y, as the files have it", () => {
  const half = Math.SQRT1_2;
  quaternionOf([0, 0, 90]).forEach((value, at) => assert.ok(Math.abs(value - [0, 0, half, half][at]!) < 1e-12));
  quaternionOf([90, 0, 0]).forEach((value, at) => assert.ok(Math.abs(value - [half, 0, 0, half][at]!) < 1e-12));
});

test("positions are read in the unit of their boxes, with a point or a comma", () => {
  assert.deepEqual(readPosition(["1.5", " -2,25 ", "0"], 1), [1.5, -2.25, 0]);
  assert.deepEqual(readPosition(["40", "0.1", "-3"], 0.001), [0.04, 0.0001, -0.003]);
  assert.equal(readPosition(["", " ", ""], 1), null);
  assert.deepEqual(writtenPosition([0.04, -0.00001, 1], 0.001), ["40", "-0.01", "1000"]);
  assert.equal(writtenLength(-0, 1), "0");
});

test("what is missing or no number is complained of at its field", () => {
  complains("position", () => readPosition(["1", "", "2"], 1));
  complains("position", () => readPosition(["1", "wide", "2"], 1));
  complains("orientation", () => readOrientation(["1", "2", ""], "angles"));
  complains("orientation", () => readOrientation(["1", "1", "1", "1"], "quaternion"));
  complains("sigma", () => readSigma("-1", "sigma", 0.001));
});

test("a quaternion is brought to length one, and a sigma may be left open", () => {
  const read = readOrientation(["0", "0", "0.7071", "0.7071"], "quaternion") as Quaternion;
  assert.ok(Math.abs(Math.hypot(...read) - 1) < 1e-15);
  assert.equal(readOrientation(["", "", "", ""], "quaternion"), null);
  assert.equal(readSigma("", "sigma", 0.001), null);
  assert.equal(readSigma("0", "sigma", 0.001), 0);
  assert.deepEqual(writtenOrientation([0, 0, 0, 1], "angles"), ["0", "0", "0"]);
});

test("what nobody has touched stays exactly as it is", () => {
  const given = quaternionOf([12.3456789, 1.23456789, 0]);
  const read = readOrientation(["12.3457", "1.2346", "90"], "angles", given, (at) => at === 2) as Quaternion;
  const angles = rollPitchYaw(read);
  [12.3456789, 1.23456789, 90].forEach((angle, at) => assert.ok(Math.abs(angle - angles[at]!) < 1e-9, `${angles}`));
  assert.deepEqual(keepUntouched([1, 2, 3], [1.00001, 2.00001, 3.00001], (at) => at === 1), [1.00001, 2, 3.00001]);
});

test("an answer brings what became of an edit, or the complaint with its field", async () => {
  const ask = (status: number, body: unknown) =>
    (async () => new Response(JSON.stringify(body), { status })) as typeof fetch;
  assert.deepEqual(await post("api/models", {}, ask(200, { said: ["in force"] })), { said: ["in force"] });
  const refusal = { field: "tags", cause: "taken" };
  assert.deepEqual(await post("api/models", {}, ask(409, refusal)), refusal);
  assert.deepEqual(await post("api/models", {}, ask(500, null)), { field: null, cause: "The bridge answered 500." });
  assert.equal(sentence("in force on fusion node main"), "In force on fusion node main.");
});
