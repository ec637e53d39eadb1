import assert from "node:assert/strict";
import { test } from "node:test";
import { blankPose, Figures, ObjectTrack, Ring, TRACK } from "../src/history.ts";

test("a ring keeps the newest rows in order and never grows", () => {
  const ring = new Ring(4, 1);
  for (let k = 0; k < 10; k++) ring.push(k, [k * k]);
  assert.equal(ring.length, 4);
  assert.deepEqual([0, 1, 2, 3].map((k) => [ring.time(k), ring.value(0, k)]), [[6, 36], [7, 49], [8, 64], [9, 81]]);
  assert.deepEqual([5, 6, 7.5, 20].map((time) => ring.before(time)), [-1, 0, 1, 3]);
});

test("late rows are passed over, and a clock that was set begins anew", () => {
  const ring = new Ring(8, 1);
  for (const time of [100, 101, 100.5, 101, 102]) ring.push(time, [time]);
  assert.equal(ring.length, 3);
  ring.push(50, [50]);
  assert.deepEqual([ring.length, ring.firstTime, ring.lastTime], [1, 50, 50]);
});

const pose = (t: number, x: number) => ({ ...blankPose("cube"), t_ns: t * 1e9, position: [x, 0, 0] as [number, number, number], state: "tracking" as const });

test("a track interpolates between poses and knows nothing across gaps", () => {
  const track = new ObjectTrack();
  track.add({ ...pose(10, 1), orientation: [0, 0, 0, 1] });
  track.add({ ...pose(10.1, 2), orientation: [0, 0, -Math.SQRT1_2, -Math.SQRT1_2] });
  track.add(pose(20, 3));
  const at = blankPose("cube");
  assert.ok(track.at(10.05, at));
  assert.ok(Math.abs(at.position[0] - 1.5) < 1e-5);
  // Half of a quarter turn about z, whichever sign the quaternions have.
  assert.ok(Math.abs(Math.abs(at.orientation[2]) - Math.sin(Math.PI / 8)) < 1e-6);
  assert.equal(at.state, "tracking");
  assert.ok(track.at(10.3, at));
  assert.equal(track.at(15, at), false);
  assert.equal(track.at(9, at), false);
});

test("a track keeps every pose of the last minute and some of the last ten, whatever the rate", () => {
  const track = new ObjectTrack();
  for (let k = 0; k < 60 * 700; k++) track.add(pose(1000 + k / 60, k));
  assert.equal(track.fine.length, track.fine.capacity);
  assert.equal(track.coarse.length, track.coarse.capacity);
  assert.ok(track.coarse.lastTime - track.coarse.firstTime > 600);
  const at = blankPose("cube");
  assert.ok(track.at(1100, at));
  assert.ok(Math.abs(at.position[0] - 6000) < 1);
});

test("a kept covariance gives the same sigma", () => {
  const track = new ObjectTrack();
  const covariance = Array.from({ length: 36 }, (_, k) => (k % 7 === 0 ? (1 + k) * 1e-8 : 0));
  track.add({ ...pose(1, 0), covariance });
  const at = blankPose("cube");
  assert.ok(track.at(1, at));
  assert.ok(Math.abs((at.covariance[14] ?? 0) / 15e-8 - 1) < 1e-6);
  const attitude = Math.sqrt([21, 28, 35].reduce((sum, k) => sum + (at.covariance[k] ?? 0), 0)) * (180 / Math.PI);
  assert.ok(Math.abs(attitude - track.fine.value(TRACK.sigma_deg, 0)) < 1e-6);
});

test("figures that are missing are missing, and those of who left are dropped after a turn", () => {
  const figures = new Figures(4);
  figures.begin(1);
  figures.write("a/rate", 30);
  figures.write("b/rate", null);
  figures.begin(2);
  figures.write("b/rate", 20);
  assert.deepEqual(figures.names(""), ["a/rate", "b/rate"]);
  assert.deepEqual([figures.value("a/rate", 0), figures.value("a/rate", 1)], [30, NaN]);
  for (let k = 3; k < 12; k++) {
    figures.begin(k);
    figures.write("b/rate", k);
  }
  assert.deepEqual(figures.names(""), ["b/rate"]);
  assert.deepEqual([figures.length, figures.time(0), figures.value("b/rate", 3)], [4, 8, 11]);
});

test("figures are bounded in number", () => {
  const figures = new Figures(4);
  figures.begin(1);
  for (let k = 0; k < 2000; k++) figures.write(`x${k}`, k);
  assert.equal(figures.names("").length, 512);
});
