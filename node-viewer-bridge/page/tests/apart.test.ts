import assert from "node:assert/strict";
import { test } from "node:test";
import { type LabelBox, Places } from "../src/stage/apart.ts";

const box = (x: number, bottom: number): LabelBox => ({ x, bottom, width: 40, height: 10 });

function lifts(boxes: LabelBox[]): number[] {
  const places = new Places();
  return boxes.map((box) => {
    const lift = places.lift(box);
    const lifted = { ...box, bottom: box.bottom - lift };
    assert.ok(places.isFree(lifted));
    places.take(lifted);
    return lift;
  });
}

test("labels that are apart stay where they are", () => {
  assert.deepEqual(lifts([box(0, 100), box(41, 100), box(0, 111)]), [0, 0, 0]);
});

test("a label over another goes above it, and above whoever is there", () => {
  assert.deepEqual(lifts([box(0, 100), box(10, 104)]), [0, 14]);
  assert.deepEqual(lifts([box(0, 100), box(0, 100), box(0, 100)]), [0, 10, 20]);
  assert.deepEqual(lifts([box(0, 100), box(0, 89), box(0, 98)]), [0, 0, 19]);
});

test("however many labels lie on one point, none lies over another", () => {
  const boxes = Array.from({ length: 60 }, (_, k) => box((k * 17) % 50, 100 + ((k * 31) % 23)));
  const lifted = lifts(boxes).map((lift, k) => ({ ...(boxes[k] as LabelBox), bottom: (boxes[k]?.bottom ?? 0) - lift }));
  for (const [k, a] of lifted.entries())
    for (const b of lifted.slice(k + 1)) {
      const apart = Math.abs(a.x - b.x) >= 40 || a.bottom - 10 >= b.bottom - 1e-9 || b.bottom - 10 >= a.bottom - 1e-9;
      assert.ok(apart, `${JSON.stringify(a)} ${JSON.stringify(b)}`);
    }
});
