import assert from "node:assert/strict";
import { test } from "node:test";
import { PictureArchive } from "../src/archive.ts";
import { Playback } from "../src/playback.ts";
import type { Message } from "../src/protocol.ts";
import { blankPose } from "../src/history.ts";
import { Site } from "../src/site.ts";

function recorded(): { shown: (number | null)[]; playback: Playback; span: [number, number] } {
  const shown: (number | null)[] = [];
  const span: [number, number] = [1000, 1100];
  const playback = new Playback({ span: () => span, replay: (time) => shown.push(time) }, () => {});
  return { shown, playback, span };
}

test("a time is held, runs on, and ends with the present", () => {
  const { shown, playback } = recorded();
  playback.seek(1050);
  playback.advance(1);
  assert.deepEqual(shown, [1050]);
  playback.toggle();
  playback.advance(0.5);
  playback.step(-10);
  playback.step(500);
  assert.deepEqual(shown, [1050, 1050.5, 1040.5, null]);
  playback.seek(1090);
  playback.toggle();
  playback.advance(60);
  assert.equal(playback.at, 1100);
});

test("what is no longer kept is not shown", () => {
  const { shown, playback, span } = recorded();
  playback.seek(0);
  span[0] = 1010;
  span[1] = 1110;
  playback.advance(0.1);
  assert.deepEqual(shown, [1000, 1010]);
  assert.equal(playback.at, 1010);
});

test("the site shows the past where it is kept, and goes on to listen", () => {
  const site = new Site();
  const pose = (t: number, x: number): Message => ({ type: "pose", ...blankPose("cube"), t_ns: t * 1e9, position: [x, 0, 0], state: "tracking" });
  for (let k = 0; k < 100; k++) site.take(pose(1000 + k / 10, k), k / 10);
  const cube = site.object("cube");
  site.replay(1005);
  assert.equal(Math.round(cube.shown?.position[0] ?? NaN), 50);
  site.take(pose(1010, 100), 10);
  assert.equal(Math.round(cube.shown?.position[0] ?? NaN), 50);
  site.replay(900);
  assert.equal(cube.condition(10), "unseen");
  site.replay(null);
  assert.equal(cube.shown?.position[0], 100);
});

test("kept pictures are bounded in bytes, one a second of each camera", () => {
  const archive = new PictureArchive(10_000);
  for (let k = 0; k < 600; k++)
    for (const camera of ["a", "b"]) archive.add({ camera, t_ns: k * 2e8, jpeg: new Uint8Array(500) });
  assert.ok(archive.size <= 10_000);
  assert.equal(archive.near("a", 119e9)?.t_ns, 119e9);
  assert.equal(archive.near("a", 10e9), null);
  assert.equal(archive.near("c", 119e9), null);
});
