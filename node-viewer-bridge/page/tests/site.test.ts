import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import type { Fault, Message, PrintedTag, RigCamera } from "../src/protocol.ts";
import { parseMessage } from "../src/protocol.ts";
import { blankPose } from "../src/history.ts";
import { poseAt, Site } from "../src/site.ts";

const NONE_REJECTED = { bad_magic: 0, foreign_version: 0, wrong_kind: 0, damaged: 0, too_long: 0, out_of_range: 0, wrong_camera: 0 };
const tag = (id: number): PrintedTag => ({
  family: "tag36h11",
  id,
  size_m: 0.04,
  printed_size_m: 0.05,
  object_from_tag: null,
  modules: [],
});
const camera = (id: string): RigCamera => ({
  id,
  resolution: [640, 480],
  lens: { model: "pinhole", fx: 1, fy: 1, cx: 0, cy: 0 },
  world_from_camera: null,
  version: "1",
});

const silence = { seconds: 3, messages: 3 };
const hello: Message = { type: "hello", site: "lab", version: "1", protocol: 1, now_ns: 1e18, role: "viewer", silence };

function siteOf(...messages: Message[]): Site {
  const site = new Site();
  for (const message of [hello, ...messages]) site.take(message, 0);
  return site;
}

const object = (id: string, ...tags: number[]): Message => ({ type: "object", id, tags: tags.map(tag), version: "1" });

test("an object that is gone is forgotten with its tags, and its colour is free", () => {
  const site = siteOf(object("cube", 1), object("box", 2));
  const colour = site.objects.get("cube")?.colour;
  site.take({ type: "object_gone", id: "cube" }, 0);
  assert.deepEqual([...site.objects.keys()], ["box"]);
  assert.equal(site.ownerOf("tag36h11", 1), null);
  site.take(object("ball", 3), 0);
  assert.equal(site.objects.get("ball")?.colour, colour);
});

test("an object that changes gives up the tags that it has no more", () => {
  const site = siteOf(object("cube", 1, 2), object("cube", 2));
  assert.equal(site.ownerOf("tag36h11", 1), null);
  assert.equal(site.ownerOf("tag36h11", 2)?.id, "cube");
});

test("a camera that leaves the rig leaves the page unless it still sends", () => {
  const rig = (...ids: string[]): Message => ({ type: "rig", cameras: ids.map(camera) });
  const site = siteOf(rig("north", "south", "east"));
  const seen: Message = { type: "observations", camera: "east", sequence: 1, t_ns: 1, received_ms: null, detected_ms: null, latency_ms: 1, resolution: [640, 480], tags: [] };
  site.take(seen, 9.5);
  site.take(rig("north"), 10);
  assert.deepEqual([...site.cameras.keys()], ["north", "east"]);
});

test("a carried camera is where its carrier was when the image was taken", () => {
  const half = Math.SQRT1_2;
  const mounted: RigCamera = {
    ...camera("eye"),
    mount: { carrier: "drone", carrier_from_camera: { position: [0.1, 0, 0], orientation: [0, 0, 0, 1] } },
  };
  const site = siteOf({ type: "rig", cameras: [mounted] }, object("drone", 1));
  const eye = site.cameras.get("eye");
  assert.ok(eye);
  assert.equal(site.modelAt(eye, 10), null);
  // A quarter turn about z: what lies ahead along x lies along y of the world.
  site.take({ ...blankPose("drone"), type: "pose", state: "tracking", t_ns: 10e9, position: [1, 2, 3], orientation: [0, 0, half, half] }, 0);
  const [x, y, z] = site.modelAt(eye, 10)?.world_from_camera?.position ?? [];
  assert.ok(Math.hypot((x ?? 0) - 1, (y ?? 0) - 2.1, (z ?? 0) - 3) < 1e-6, `${x} ${y} ${z}`);
  assert.equal(site.modelAt(eye, 10.1), null, "no pose of that time yet");
});

test("a landmark is where its file says until it has poses", () => {
  const site = siteOf({ type: "object", id: "post", tags: [tag(7)], world_from_object: { position: [1, 2, 3], orientation: [0, 0, 0, 1] }, version: "1" });
  const post = site.objects.get("post");
  assert.equal(post?.condition(0), "landmark");
  const pose = blankPose("post");
  assert.ok(post && poseAt(post, 10, pose));
  assert.deepEqual(pose.position, [1, 2, 3]);
});

test("a site is healthy while a fusion node reports no fault, and every camera of the rig runs", () => {
  const status = (faults: Fault[], node = "fusion"): Message => ({
    type: "fusion_status", node, version: "1", uptime_s: 1, epoch: 1, cameras: [], foreign: NONE_REJECTED, objects: [], faults, faults_left_out: 0,
    imperfections: [{ focal_length_off: { camera: "north", ratio: 1.01 } }], notices: [],
  });
  const site = siteOf({ type: "rig", cameras: [camera("north")] });
  const at = (now: number, ...messages: Message[]): string => {
    for (const message of messages) site.take(message, now);
    site.sample(now);
    return site.condition;
  };
  assert.equal(at(0), "unknown");
  assert.equal(at(1, status([])), "healthy");
  assert.equal(at(2, status([{ camera_moved: { camera: "north" } }])), "faulty");
  assert.equal(at(9, status([])), "healthy");
  assert.equal(at(10, status([]), { type: "alive", kind: "camera", id: "north", up: false }), "faulty");
  assert.equal(at(17, status([]), { type: "alive", kind: "camera", id: "north", up: true }), "healthy");
  assert.equal(at(27), "faulty");
  // Another node takes over from one with a fault, which is gone.
  const moved: Fault[] = [{ camera_moved: { camera: "north" } }];
  assert.equal(at(40, status(moved), status([], "second")), "faulty");
  at(41, { type: "alive", kind: "fusion", id: "fusion", up: false });
  assert.equal(at(47, status([], "second")), "healthy");
  // Behind a cut nothing ends.
  at(48, status(moved, "second"));
  site.network = false;
  for (let now = 49; now < 99; now++) at(now);
  const ofCamera = site.health.faults.filter((entry) => entry.cause.includes("north"));
  assert.equal(ofCamera.length, 1);
});

test("the true error is that of tracked poses", () => {
  const scored = (t_ns: number, state: "tracking" | "coasting", error_mm: number): Message[] => [
    { ...blankPose("cube"), type: "pose", t_ns, state },
    { type: "truth", object: "cube", t_ns, position: [0, 0, 0], orientation: [0, 0, 0, 1], error_mm, error_deg: 0 },
  ];
  const site = siteOf(...scored(1e9, "tracking", 3), ...scored(1.1e9, "coasting", 100));
  assert.equal(site.objects.get("cube")?.errorMm.rootMeanSquare(), 3);
});

test("what images tell about a clock holds until they tell no more", () => {
  const clock = { camera: "north", offset_s: 0.01, sigma_s: 0.001, drift: null };
  const site = siteOf({ type: "rig", cameras: [camera("north")] }, { type: "clocks", node: "fusion", cameras: [clock] });
  assert.deepEqual(site.cameras.get("north")?.clock, clock);
  site.take({ type: "clocks", node: "fusion", cameras: [] }, 1);
  assert.equal(site.cameras.get("north")?.clock, null);
});

test("what a fusion node offers is there until it is withdrawn", () => {
  const offer = { node: "fusion", t_ns: 1, rig: true, objects: [], n_images: 24, before_px: 0.9, after_px: 0.4 };
  const none = { ...offer, rig: false };
  const site = siteOf({ type: "proposal", ...offer }, { type: "former", ...offer }, { type: "former", ...none });
  assert.deepEqual([...site.proposals.keys()], ["fusion"]);
  assert.equal(site.formers.size, 0);
  site.take({ type: "proposal", ...none }, 0);
  assert.equal(site.proposals.size, 0);
});

test("what several fusion nodes report about the site is shown once, and what each reports about itself or its objects as well", () => {
  const overload = { overload: { dropped: 1, total: 2 } };
  const status = (node: string, epoch: number, ...faults: Fault[]): Message => ({
    type: "fusion_status", node, version: "0.1.0", uptime_s: 1, epoch, cameras: [], foreign: NONE_REJECTED, objects: [],
    faults: [{ clock_off: { camera: "north", offset_s: epoch } }, ...faults], faults_left_out: 0, imperfections: [], notices: [overload],
  });
  const loose: Fault = { tag_misplaced: { object: "cube", tag: { family: "tag36h11", id: 3 } } };
  const site = siteOf(status("a", 6, loose), status("b", 7));
  site.sample(1);
  const entries = site.health.groups("fault").flat();
  assert.deepEqual(entries.map((entry) => entry.key).sort(), [
    "a/notice/overload", "b/notice/overload", "site/fault/clock_off north", "site/fault/tag_misplaced cube tag tag36h11:3",
  ]);
  assert.match(entries.find((entry) => entry.key.includes("clock_off"))?.cause ?? "", /7\.00 s ahead/);
});

test("what is silent follows from the bridge's rule and the rate of a camera", () => {
  const image = (t: number): Message => ({
    type: "observations", camera: "north", sequence: t, t_ns: t * 1e9, received_ms: null, detected_ms: null, latency_ms: 1, resolution: [640, 480], tags: [],
  });
  const site = siteOf(image(1));
  const north = site.camera("north");
  assert.equal(north.condition(3), "live");
  assert.equal(north.condition(3.1), "silent");
  const golden = readFileSync(new URL("../../../../proto/golden/camera_status.json", import.meta.url), "utf8");
  const status = parseMessage(JSON.stringify({ type: "camera_status", ...(JSON.parse(golden) as object) }));
  assert.ok(status?.type === "camera_status");
  status.controls.rate_hz.value = 0.5;
  site.take({ ...status, camera: "north" }, 0);
  assert.equal(north.condition(6), "live");
  assert.equal(north.condition(6.1), "silent");
});
