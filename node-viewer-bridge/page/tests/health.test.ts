import assert from "node:assert/strict";
import { test } from "node:test";
import type { Report } from "../src/findings.ts";
import { HealthLog } from "../src/health.ts";

const report = (key: string, id: string, cause = key): Report => ({ key, severity: "fault", subject: { kind: "camera", id }, cause, remedy: "", action: null });

test("a report keeps its place while its amounts change, and its acknowledgement until it ends", () => {
  const log = new HealthLog();
  log.take([report("a", "north", "off by 1 mm")], 100);
  log.take([report("a", "north", "off by 2 mm")], 101);
  assert.equal(log.open, 1);
  log.acknowledge("a");
  log.take([report("a", "north", "off by 3 mm")], 102);
  const [entry] = log.groups("fault").flat();
  assert.deepEqual([entry?.since, entry?.cause, entry?.acknowledged, log.open], [100, "off by 3 mm", true, 0]);
  log.take([], 110);
  assert.equal(log.groups("fault").flat()[0]?.active, false);
  log.take([report("a", "north")], 120);
  assert.deepEqual([log.open, log.groups("fault").flat()[0]?.since], [1, 120]);
});

test("a report that flickers goes on", () => {
  const log = new HealthLog();
  log.take([report("a", "north")], 100);
  log.take([], 103);
  assert.equal(log.groups("fault").flat()[0]?.active, true);
});

test("groups come newest first, and what is active before what has ended", () => {
  const log = new HealthLog();
  log.take([report("old", "north")], 100);
  log.take([report("a", "south")], 110);
  log.take([report("a", "south"), report("b", "east")], 112);
  assert.deepEqual(log.groups("fault").map((group) => group.map((entry) => entry.key)), [["b"], ["a"], ["old"]]);
});

test("entries are bounded, and what is active stays", () => {
  const log = new HealthLog();
  for (let k = 0; k < 1000; k++) log.take([report("lasting", "north"), report(`x${k}`, "south")], 100 + 10 * k);
  const entries = log.groups("fault").flat();
  assert.equal(entries.length, 200);
  assert.ok(entries.some((entry) => entry.key === "lasting"));
});

test("information is listed apart and wants no attention", () => {
  const log = new HealthLog();
  log.take([{ ...report("a", "north"), severity: "information" }], 100);
  assert.deepEqual([log.open, log.faults.length, log.groups("fault").length, log.groups("information").length], [0, 0, 0, 1]);
});
