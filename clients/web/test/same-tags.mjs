// Finds tags in the images of a folder, compares them with those that its `images.json` gives, and writes a message of
// each kind beside them:
//
//     node test/same-tags.mjs DIR
//
// Prints the median time of each size of image.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { Detector } from "../dist/sextant.js";

const TOLERANCE_PX = 1e-3;
const REPETITIONS = 20;

const [folder] = process.argv.slice(2);
const images = JSON.parse(readFileSync(join(folder, "images.json"), "utf8"));
const detector = await Detector.load();
const times = new Map();
let off = 0;

for (const { file, width, height, tags } of images) {
  const picture = { data: new Uint8Array(readFileSync(join(folder, file))), width, height };
  const found = detector.detect(picture);
  const names = (list) => list.map(({ family, id, hamming }) => `${family} ${id} ${hamming}`);
  assert.deepEqual(names(found), names(tags), file);
  found.forEach((tag, i) => tag.corners.flat().forEach((x, k) => (off = Math.max(off, Math.abs(x - tags[i].corners.flat()[k])))));
  for (let i = 0; i < REPETITIONS; i++) {
    const begun = performance.now();
    detector.detect(picture);
    times.set(`${width}x${height}`, [...(times.get(`${width}x${height}`) ?? []), performance.now() - begun]);
  }
}
assert.ok(off <= TOLERANCE_PX, `${off} px`);
for (const [size, list] of times) console.log(size, `${list.sort((a, b) => a - b)[list.length >> 1].toFixed(2)} ms`);
console.log(`corners differ by at most ${off} px`);

// Colours, tracking, poses and refusals.
const { file, width, height, tags } = images[0];
const grey = readFileSync(join(folder, file));
const data = new Uint8ClampedArray(4 * width * height);
grey.forEach((value, i) => data.set([value, value, value, 255], 4 * i));
const coloured = detector.detect({ data, width, height, colorSpace: "srgb" });
assert.deepEqual(coloured.map(({ id }) => id), tags.map(({ id }) => id));
const light = detector.light();
assert.ok(light.brightness > 10 && light.sharpness > 0.2 && light.sharpness <= 1, JSON.stringify(light));
const [pose] = detector.poses(0, { fx: 600, fy: 600, cx: 319.5, cy: 239.5 }, 0.04);
assert.ok(pose.position[2] > 0.1 && pose.rmsPx < 5, JSON.stringify(pose));
assert.throws(() => detector.poses(0, { fx: NaN, fy: 1, cx: 0, cy: 0 }, 0.04));
assert.throws(() => detector.detect({ data: new Uint8Array(9), width: 640, height: 480 }), /fewer/);
assert.throws(() => detector.detect({ data: new Uint8Array(9), width: -1, height: 480 }), /outside/);
assert.throws(() => detector.configure({ families: ["tagStandard52h13"] }), /not read in browsers/);
assert.throws(() => detector.configure({ families: ["none"] }), /unknown tag family/);
detector.configure({ tracking: true });
for (let i = 0; i < 10; i++) detector.detect({ data: grey, width, height });

// Messages.
const times1 = { captureNs: 1_800_000_000_123_456_789n, receivedNs: 1_800_000_000_130_000_000n, detectedNs: 1_800_000_000_131_000_000n, isArrival: false };
const write = (name, bytes) => writeFileSync(join(folder, name), bytes);
write("observations.bin", detector.observations("pocket", 7, times1));
write("status.bin", detector.status("pocket", "a phone", { captured: 10, detected: 7, published: 7, rateHz: 29.9, detectMs: [1, 2], uptimeS: 3 }));
write("preview.bin", detector.preview("pocket", 7, 1n, [640, 480], new Uint8Array([1, 2, 3])));
assert.throws(() => detector.observations("NO NAME", 7, times1));
