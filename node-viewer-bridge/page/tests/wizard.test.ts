import assert from "node:assert/strict";
import { test } from "node:test";
import { parseMessage } from "../src/protocol.ts";
import { errorColour, scaleEnd } from "../src/wizard/colours.ts";
import { readName, readSize, readTags, readWhole, send, tagOf, wordsOf, Wrong } from "../src/wizard/command.ts";
import { tagName } from "../src/wizard/figures.ts";
import { inWords } from "../src/wizard/graph.ts";
import { appear, type Patch, rotate } from "../src/wizard/solid.ts";

const wrongField = (read: () => unknown): string | null => {
  try {
    read();
  } catch (error) {
    return error instanceof Wrong ? error.field : null;
  }
  return null;
};

test("tags are read as people list them", () => {
  assert.deepEqual(readTags("3, 4;5", 0.04), [3, 4, 5].map((id) => ({ id, size_m: 0.04 })));
  assert.deepEqual(readTags("3-5 9:50", 0.04).map((tag) => [tag.id, tag.size_m]), [[3, 0.04], [4, 0.04], [5, 0.04], [9, 0.05]]);
});

test("what is no list of tags is complained of at its field", () => {
  for (const text of ["", "x", "3,-4", "5-3", "1-9999", "3, 3", "2-4 3", "3:", "3:0", "3:a"])
    assert.equal(wrongField(() => readTags(text, 0.04)), "tags", text);
});

test("a run can be added to and taken from", () => {
  assert.deepEqual(wordsOf("1, 3-5:50 x 9-2"), ["1", "3:50", "4:50", "5:50", "x", "9-2"]);
  assert.deepEqual(["3:50", "7"].map(tagOf), ["3", "7"]);
});

test("millimetres become metres without noise", () => {
  assert.equal(readSize("28"), 0.028);
  assert.equal(readSize(" 28,5 "), 0.0285);
  for (const text of ["", "wide", "0", "-3", "0.5", "1e9", "NaN"]) assert.equal(wrongField(() => readSize(text)), "size_m", text);
});

test("numbers and names keep to their bounds", () => {
  assert.equal(readWhole("7", "rows", "It", [1, 100]), 7);
  for (const text of ["", "0", "101", "2.5", "two"]) assert.equal(wrongField(() => readWhole(text, "rows", "It", [1, 100])), "rows", text);
  assert.equal(readName(" cube-2 ", "id"), "cube-2");
  for (const text of ["", "Cube", "a b", "x".repeat(33), "../etc"]) assert.equal(wrongField(() => readName(text, "id")), "id", text);
});

test("a refused request is a complaint, whatever was answered", async () => {
  const answer = (status: number, body: string): typeof fetch => async () => new Response(body, { status });
  assert.equal(await send("api/wizard", {}, answer(202, "{}")), null);
  assert.deepEqual(await send("api/wizard", {}, answer(400, '{"field":"tags","cause":"no"}')), { field: "tags", cause: "no" });
  assert.match((await send("api/wizard", {}, answer(500, "<html>")))?.cause ?? "", /500/);
  const nobody: typeof fetch = async () => Promise.reject(new TypeError("refused"));
  assert.match((await send("api/wizard", {}, nobody))?.cause ?? "", /does not answer/);
});

const collecting = {
  type: "wizard",
  wizard: "learn",
  stage: "collecting",
  subject: "cube",
  missed: 0,
  progress: {
    kind: "learn",
    images: 3,
    fraction: 0.2,
    is_enough: false,
    hint: "Turn it",
    details: {
      joining: 1,
      tags: [{ tag: "tag36h11:3", images: 2, directions: 1, group: 0 }],
      sketch: [{ tag: "tag36h11:3", size_m: 0.04, position: [0, 0, 0], orientation: [0, 0, 0, 1] }],
    },
  },
};

test("an account of a wizard is read, and one that is damaged is none", () => {
  const read = (message: object): unknown => parseMessage(JSON.stringify(message));
  assert.notEqual(read(collecting), null);
  assert.notEqual(read({ type: "wizard", wizard: null, stage: "idle" }), null);
  const damaged = [{ stage: "asleep" }, { wizard: "bend" }, { progress: {} }, { progress: { ...collecting.progress, details: {} } }, { result: {} }];
  for (const wrong of damaged) assert.equal(read({ ...collecting, ...wrong }), null, JSON.stringify(wrong));
});

test("scales end at round numbers and colours run from calm to alarming", () => {
  assert.deepEqual([0.07, 0.1, 0.11, 0.34, 3, 0].map(scaleEnd), [0.1, 0.1, 0.2, 0.5, 5, 0.1]);
  assert.equal(errorColour(-1), errorColour(0));
  assert.equal(errorColour(9), errorColour(1));
  assert.notEqual(errorColour(0), errorColour(1));
});

const patch = (name: string, z: number): Patch => ({ name, position: [0, 0, z], orientation: [0, 0, 0, 1], size: 0.1, colour: "#fff" });

test("the near side of a thing is drawn last and faces the viewer", () => {
  const turned: Patch = { ...patch("bottom", -0.05), orientation: [1, 0, 0, 0] };
  const drawn = appear([patch("top", 0.05), turned], { turn: 0, tilt: 1.2 }, [400, 300]);
  assert.deepEqual(drawn.map(({ patch, faces }) => [patch.name, faces]), [["bottom", false], ["top", true]]);
});

test("a thing stays in its picture, whichever way it is turned", () => {
  const patches = [patch("a", 0), patch("b", 0.3), { ...patch("c", 0), position: [0.4, 0.2, 0.1] as [number, number, number] }];
  for (let turn = 0; turn < 6.3; turn += 0.3) {
    const corners = appear(patches, { turn, tilt: 0.4 }, [400, 300]).flatMap((drawn) => drawn.corners);
    for (const [x, y] of corners) assert.ok(x >= 0 && x <= 400 && y >= 0 && y <= 300, `${x}, ${y}`);
  }
  assert.deepEqual(appear([], { turn: 0, tilt: 0 }, [400, 300]), []);
});

test("a quarter turn about z brings x to y", () => {
  const [x, y, z] = rotate([0, 0, Math.SQRT1_2, Math.SQRT1_2], [1, 0, 0]);
  assert.ok(Math.abs(x) < 1e-12 && Math.abs(y - 1) < 1e-12 && z === 0);
});

test("who is joined with whom is told in words", () => {
  const camera = (camera: string, group: number) => ({ camera, images: 1, seeing: 1, fields: [], distances: 1, group });
  const words = inWords({ cameras: [camera("a", 0), camera("b", 0), camera("c", 2)], together: [["a", "b", 20]] });
  assert.match(words, /a, b are joined; c stands alone\./);
});

test("a tag of the usual family goes by its number", () => {
  assert.deepEqual(["tag36h11:7", "tag16h5:7"].map(tagName), ["7", "tag16h5:7"]);
});
