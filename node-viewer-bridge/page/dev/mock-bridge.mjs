// Stands in for the bridge while one works on the page without the Rust side:
//     npm run mock            serves dist/ and a made-up site on http://127.0.0.1:8600
//     npm run dev             beside it: the page from source, with live reload
// PORT names another port; WITHOUT_TRUTH=1 plays a site that is not simulated; OBJECTS and CAMERAS say how many there
// are; SPEED=20 lets time go by that much faster.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { WebSocketServer } from "ws";
import { cameras, measuredPose, objects, picture, seenTags } from "./mock-site.mjs";

const port = Number(process.env.PORT ?? 8600);
const begun = Date.now();
const rejected = { bad_magic: 0, foreign_version: 0, wrong_kind: 0, damaged: 0, too_long: 0, out_of_range: 0, wrong_camera: 0 };
const withTruth = !process.env.WITHOUT_TRUTH;
const types = { html: "text/html; charset=utf-8", js: "text/javascript", css: "text/css", wasm: "application/wasm" };

/** As the bridge takes it, without its checks. */
function changeZones({ do: what, zone, name }) {
  zones = zones.filter((known) => known.name !== (zone?.name ?? name));
  if (what === "set") zones.push({ ...zone, inside: [] });
  send({ type: "zones", zones, kept: true });
}

/** As the bridge makes it, without its checks, and only of cameras and tags that are there. */
function changeModels({ do: what, camera, object, id, pose, sigma, tags }) {
  const next = (model) => (model.version = String(Number(model.version) + 1));
  const edited = cameras.find((known) => known.id === camera);
  if (what === "edit_camera" && edited) {
    Object.assign(edited, { id, world_from_camera: pose, ...(sigma ? { sigma } : {}) });
    next(edited);
    send({ type: "rig", cameras });
  }
  const known = objects.find((one) => one.id === object);
  if (what === "edit_object" && known) {
    known.tags = tags.map((tag) => {
      const before = known.tags.find((one) => one.id === tag.id) ?? known.tags[0];
      return { ...before, id: tag.id, size_m: tag.size_m, object_from_tag: tag.pose };
    });
    next(known);
    send({ type: "object", ...known });
  }
  return { said: ["in force on fusion node fusion, which keeps it in its files"] };
}

let zones = [{ shape: "box", name: "dock", centre: [0.3, 0, 0.15], size: [0.3, 0.5, 0.3], yaw_deg: 20, inside: [] }];
const events = [];

const http = createServer(async (request, response) => {
  if (request.url === "/api/session") return void response.writeHead(200, { "content-type": "application/json" }).end('{"role":"operator"}');
  if (request.url === "/api/zones") {
    let body = "";
    for await (const chunk of request) body += chunk;
    changeZones(JSON.parse(body));
    return void response.writeHead(202).end("{}");
  }
  if (request.url === "/api/models") {
    let body = "";
    for await (const chunk of request) body += chunk;
    const said = changeModels(JSON.parse(body));
    return void setTimeout(() => response.writeHead(200, { "content-type": "application/json" }).end(JSON.stringify(said)), 400);
  }
  const path = request.url.split("?")[0];
  const name = { "/": "index.html", "/camera": "camera.html" }[path] ?? path.slice(1);
  if (!/^[a-z]+\.(html|js|css|wasm)$/.test(name)) return void response.writeHead(404).end();
  const body = await readFile(new URL(`../dist/${name}`, import.meta.url)).catch(() => null);
  response.writeHead(body ? 200 : 404, { "content-type": types[name.split(".")[1]] }).end(body);
});
const sockets = new WebSocketServer({ server: http, path: "/ws" });
const speed = Number(process.env.SPEED ?? 1);
const nowNs = () => (begun + speed * (Date.now() - begun)) * 1e6;

function send(message) {
  const frame = message instanceof Buffer ? message : JSON.stringify(message);
  for (const socket of sockets.clients) if (socket.bufferedAmount < 1e6) socket.send(frame);
}

sockets.on("connection", (socket) => {
  const greet = (message) => socket.send(JSON.stringify(message));
  greet({ type: "hello", site: "mock", version: "0.0.0", protocol: 1, now_ns: nowNs(), role: "operator", silence: { seconds: 3, messages: 3 } });
  greet({ type: "rig", cameras });
  for (const object of objects) greet({ type: "object", ...object });
  greet({ type: "zones", zones, kept: true });
  for (const camera of cameras) greet({ type: "alive", kind: "camera", id: camera.id, up: true });
});

let sequence = 0;
setInterval(() => {
  sequence++;
  const t = (nowNs() - begun * 1e6) / 1e9;
  const t_ns = nowNs() - 20e6;
  cameras.forEach((camera, index) => sendImage(camera, t, t_ns + index * 1e6, sequence % 4 === index));
  for (const object of objects) sendPose(object, t, t_ns);
  send({ type: "joints", object: "gamepad", t_ns, joints: [{ joint: "stick", value: 0.3 * Math.sin(t), sigma: 0.004, velocity: 0 }] });
  occupy(t_ns);
}, 1000 / 30 / speed);

/** Without hysteresis: a cube that passes is enough. */
function occupy(t_ns) {
  const t = t_ns / 1e9 - begun / 1000;
  let news = false;
  for (const zone of zones) {
    for (const { id } of objects) {
      const { position } = measuredPose(id, t);
      const inside = position.every((value, k) => Math.abs(value - zone.centre[k]) < (zone.size?.[k] ?? 2 * zone.radius) / 2);
      if (inside === zone.inside.includes(id)) continue;
      zone.inside = inside ? [...zone.inside, id] : zone.inside.filter((other) => other !== id);
      events.push({ sequence: sequence * 100 + events.length, t_ns, object: id, event: inside ? "entered" : "left", zone: zone.name, position });
      news = true;
    }
  }
  if (events.length > 64) events.splice(0, events.length - 64);
  if (!news) return;
  send({ type: "zones", zones, kept: true });
  send({ type: "events", events, dropped: 0 });
}

function sendImage(camera, t, t_ns, withPicture) {
  const seen = seenTags(camera, t);
  const tags = seen.map(({ model, corners }) => ({ family: model.family, id: model.id, hamming: 0, margin: 80, corners }));
  if (withPicture) send(preview(camera.id, t_ns, picture(camera, seen, t)));
  if (withPicture) send(detectionReport(camera, t_ns, seen.length));
  send({ type: "observations", camera: camera.id, sequence, t_ns, received_ms: 3 + Math.random(), detected_ms: 6 + Math.random(), latency_ms: 9 + Math.random(), resolution: camera.resolution, tags });
}

/** As many candidates as the mock can think of; the outlines wander, as they do in pictures. */
function detectionReport(camera, t_ns, tags) {
  const box = (x, y, edge) => [[x, y], [x + edge, y], [x + edge, y + edge], [x, y + edge]];
  const examples = [
    { cause: "no_code", corners: box(90, 60, 48) },
    { cause: "faint_border", corners: box(420, 300, 30) },
    { cause: "not_a_quad", corners: box(200, 380, 60) },
  ];
  const rejected = { not_a_quad: 1, shape: 0, faint_border: 1, no_code: 1, small_margin: 0 };
  const stage_ms = { tiles: 0.01, threshold: 0.02, components: 0.03, quads: 0.01, decode: 0.05, refine: 0.02 * tags };
  return { type: "detection_report", camera: camera.id, sequence, capture_ns: t_ns, resolution: camera.resolution, searched: 1, stage_ms, noise_sigma: 1.2, contrast_gate: 20, components: 9, candidates: tags + 3, dropped: 0, tags, rejected, examples };
}

function preview(id, t_ns, bytes) {
  const time = Buffer.alloc(8);
  time.writeBigUInt64LE(BigInt(t_ns));
  return Buffer.concat([Buffer.from([1, id.length]), Buffer.from(id), time, bytes]);
}

function stateAt(id, t) {
  if (id !== "gamepad") return "tracking";
  const phase = t % 24;
  return phase < 16 ? "tracking" : phase < 19 ? "coasting" : phase < 22 ? "lost" : "initialising";
}

function sendPose({ id }, t, t_ns) {
  const state = stateAt(id, t);
  if (state === "lost" && sequence % 10) return;
  const { position, orientation, error_mm } = measuredPose(id, t);
  const wide = state === "coasting" ? 3 : 1;
  const variances = [0.0004, 0.0005, 0.0009, 0.002, 0.002, 0.003].map((sigma) => (wide * sigma) ** 2);
  const covariance = Array.from({ length: 36 }, (_, i) => (i % 7 === 0 ? variances[i / 7] : 0));
  send({ type: "pose", object: id, sequence: sequence * 4, t_ns, position, orientation, covariance, twist: [0, 0, 0, 0, 0, 0], state, cameras: 3, tags: 5, rms_px: 0.12, latency_ms: 18 + 5 * Math.random() });
  if (withTruth) send({ type: "truth", object: id, t_ns, position, orientation, error_mm, error_deg: error_mm / 5 });
}

setInterval(() => {
  for (const { id } of cameras) {
    send({ type: "camera_status", camera: id, version: "0.0.0", host: "mock", captured: sequence, detected: sequence - 3, dropped: 3, rate_hz: 30, detect_ms: [4, 7], clock: { source: "free-running", error_ns: 0 }, uptime_s: sequence / 30, published: sequence, fallbacks: 0, brightness: 118, controls: { exposure_us: { wanted: null, value: 4000, range: [100, 33000] }, gain: { wanted: null, value: null, range: [0, 64] }, rate_hz: { wanted: null, value: 30, range: null }, outcome: "none" }, notices: [] });
  }
  send({ type: "clocks", node: "fusion", cameras: [{ camera: "east", offset_s: 0.0021 + 0.0002 * Math.sin(sequence / 200), sigma_s: 0.0002, drift: null }] });
  send({ type: "fusion_status", node: "fusion", epoch: 1, version: "0.0.0", uptime_s: 1, cameras: [], foreign: rejected, objects: [], faults: process.env.FAULTS ? [{ camera_moved: { camera: "east" } }, { tag_size: { object: "cube", tag: { family: "tag36h11", id: 3 }, ratio: 1.03 } }] : [], faults_left_out: 0, imperfections: process.env.FAULTS ? [{ cameras_disagree: { a: "north", b: "south", apart_m: 0.0043 } }] : [], notices: process.env.FAULTS ? [{ camera_silent: { camera: "west", silent_s: sequence / 30 } }] : [] });
  send({ type: "bridge_status", now_ns: nowNs(), uptime_s: 1, network: true, clients: sockets.clients.size, replaced: 0, rejected: { ...rejected, wrong_id: 0, invalid_model: 0, too_many: 0 }, webhook: null });
}, 1000);

http.listen(port, "127.0.0.1", () => console.error(`mock bridge on http://127.0.0.1:${port}`));
