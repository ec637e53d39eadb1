import assert from "node:assert/strict";
import { test } from "node:test";
import { lifts } from "../src/stage/apart.ts";

const box = (x: number, bottom: number) => ({ x, bottom, width: 40, height: 10 });

test("labels that are apart stay where they are", () => {
  assert.deepEqual(lifts([box(0, 100), box(41, 100), box(0, 111)]), [0, 0, 0]);
});

test("a label over another goes above it, and above whoever is there", () => {
  assert.deepEqual(lifts([box(0, 100), box(10, 104)]), [0, 14]);
  assert.deepEqual(lifts([box(0, 100), box(0, 100), box(0, 100)]), [0, 10, 20]);
  assert.deepEqual(lifts([box(0, 100), box(0, 89), box(0, 98)]), [0, 0, 19]);
});
