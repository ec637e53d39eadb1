// A made-up site for work on the page: four cameras, three moving objects, pictures of them. Nothing here is exact, and
// the tags' patterns are invented; the real thing is `cargo demo`.

import { crc32, deflateSync } from "./png.mjs";

const PICTURE = [320, 240];
const IMAGE = [640, 480];
const FOCAL = 560;

const add = (a, b) => a.map((value, i) => value + b[i]);
const sub = (a, b) => a.map((value, i) => value - b[i]);
const scale = (a, s) => a.map((value) => value * s);
const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => scale(a, 1 / Math.hypot(...a));

/** Rotates a vector by a quaternion x, y, z, w. */
export function turn([x, y, z, w], v) {
  const t = scale(cross([x, y, z], v), 2);
  return add(add(v, scale(t, w)), cross([x, y, z], t));
}

function product([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

const about = (axis, angle) => [...scale(unit(axis), Math.sin(angle / 2)), Math.cos(angle / 2)];

/** The quaternion of a rotation with these columns. */
function fromColumns(a, b, c) {
  const w = Math.sqrt(Math.max(0, 1 + a[0] + b[1] + c[2])) / 2;
  if (w > 1e-3) return [(b[2] - c[1]) / (4 * w), (c[0] - a[2]) / (4 * w), (a[1] - b[0]) / (4 * w), w];
  const x = Math.sqrt(Math.max(0, 1 + a[0] - b[1] - c[2])) / 2;
  if (x > 1e-3) return [x, (b[0] + a[1]) / (4 * x), (c[0] + a[2]) / (4 * x), (b[2] - c[1]) / (4 * x)];
  const y = Math.sqrt(Math.max(0, 1 - a[0] + b[1] - c[2])) / 2;
  return y > 1e-3 ? [0, y, (c[1] + b[2]) / (4 * y), 0] : [0, 0, 1, 0];
}

function lookingAt(position, target) {
  const z = unit(sub(target, position));
  const x = unit(cross(z, [0, 0, 1]));
  return { position, orientation: fromColumns(x, cross(z, x), z) };
}

/** CAMERAS beyond the four stand between them. */
const more = Array.from({ length: Math.max(0, Number(process.env.CAMERAS ?? 4) - 4) }, (_, k) => {
  const angle = Math.PI * (0.25 + k / 2);
  return [`extra-${k + 1}`, [1.3 * Math.cos(angle), 1.3 * Math.sin(angle), 1.1]];
});

export const cameras = [["north", [0.1, 1.15, 0.85]], ["east", [1.2, 0.1, 0.75]], ["south", [-0.1, -1.15, 0.9]], ["west", [-1.2, -0.1, 0.7]], ...more].map(
  ([id, position]) => ({
    id,
    resolution: IMAGE,
    lens: { model: "pinhole", fx: FOCAL, fy: FOCAL, cx: 319.5, cy: 239.5 },
    world_from_camera: lookingAt(position, [0, 0, 0.15]),
    version: "1",
  }),
);

function inventedModules(id) {
  let seed = id * 2654435761 + 12345;
  const bit = () => ((seed = (seed * 1103515245 + 12345) & 0x7fffffff), (seed >> 16) & 1);
  return Array.from({ length: 10 }, (_, row) =>
    Array.from({ length: 10 }, (_, column) => {
      const ring = Math.min(row, column, 9 - row, 9 - column);
      return ring === 0 ? 1 : ring === 1 ? 0 : bit();
    }).join(""),
  );
}

function tag(id, size, position, z, up) {
  const x = cross(up, z);
  return { family: "tag36h11", id, size_m: size, printed_size_m: size * 1.25, object_from_tag: { position, orientation: fromColumns(x, up, z) }, modules: inventedModules(id) };
}

function boxTags(first, size, half) {
  const faces = [[[0, 0, 1], [0, 1, 0]], [[1, 0, 0], [0, 0, 1]], [[0, 1, 0], [0, 0, 1]], [[-1, 0, 0], [0, 0, 1]], [[0, -1, 0], [0, 0, 1]]];
  return faces.map(([normal, up], i) => tag(first + i, size, scale(normal, half), normal, up));
}

export const objects = [
  { id: "cube", tags: boxTags(0, 0.08, 0.055) },
  { id: "gamepad", tags: [tag(10, 0.06, [-0.06, 0, 0], unit([-0.5, 0, 0.9]), [0, 1, 0]), tag(11, 0.06, [0.06, 0, 0], unit([0.5, 0, 0.9]), [0, 1, 0])] },
  { id: "plate", tags: [tag(20, 0.1, [0, 0, 0], [0, 0, 1], [0, 1, 0])] },
  // OBJECTS beyond the three are cubes on circles of their own.
  ...Array.from({ length: Math.max(0, Number(process.env.OBJECTS ?? 3) - 3) }, (_, k) => ({ id: `box-${k + 1}`, tags: boxTags(30 + 5 * k, 0.05, 0.035) })),
].map((object) => ({ ...object, version: "1" }));

const noise = (seed) => (Math.sin(seed * 12.9898) * 43758.5453) % 1;

/** True pose of an object at `t` seconds. */
export function truePose(id, t) {
  const turned = (axis, rate) => about(axis, rate * t);
  if (id.startsWith("box-")) {
    const [k, phase] = [Number(id.slice(4)), (0.4 + 0.1 * Number(id.slice(4))) * t];
    return { position: [0.6 * Math.cos(phase + k), 0.6 * Math.sin(phase + k), 0.05 + 0.05 * k], orientation: turned([0, 0, 1], 0.2 * k) };
  }
  if (id === "cube") return { position: [0.35 * Math.cos(0.7 * t), 0.35 * Math.sin(0.7 * t), 0.16 + 0.05 * Math.sin(1.3 * t)], orientation: product(turned([0, 0, 1], 0.9), about([1, 0, 0], 0.3 * Math.sin(t))) };
  if (id === "gamepad") return { position: [-0.15 + 0.1 * Math.sin(1.1 * t), 0.25 * Math.sin(0.55 * t), 0.34 + 0.04 * Math.cos(1.7 * t)], orientation: product(about([0, 0, 1], 0.8 * Math.sin(0.4 * t)), about([0, 1, 0], 0.35 * Math.sin(0.9 * t))) };
  return { position: [0.1 + 0.22 * Math.sin(0.33 * t), -0.3 + 0.08 * Math.cos(0.5 * t), 0.02], orientation: turned([0, 0, 1], -0.35) };
}

function printCorners(tagModel, pose) {
  const half = tagModel.size_m / 2;
  return [[-half, half], [half, half], [half, -half], [-half, -half]].map(([x, y]) => inWorld(tagModel, pose, [x, y, 0]));
}

function inWorld(tagModel, pose, point) {
  const { position, orientation } = tagModel.object_from_tag;
  return add(pose.position, turn(pose.orientation, add(position, turn(orientation, point))));
}

function project(camera, point) {
  const { position, orientation: [x, y, z, w] } = camera.world_from_camera;
  const [cx, cy, cz] = turn([-x, -y, -z, w], sub(point, position));
  return cz > 0.05 ? [319.5 + (FOCAL * cx) / cz, 239.5 + (FOCAL * cy) / cz] : null;
}

/** The tags that a camera sees at `t`, far ones first. */
export function seenTags(camera, t) {
  const seen = [];
  for (const object of objects) {
    const pose = truePose(object.id, t);
    for (const model of object.tags) {
      const corners = printCorners(model, pose).map((corner) => project(camera, corner));
      const centre = inWorld(model, pose, [0, 0, 0]);
      const towards = unit(sub(camera.world_from_camera.position, centre));
      const normal = sub(inWorld(model, pose, [0, 0, 1]), centre);
      if (dot(towards, normal) < 0.25 || corners.some((c) => !c || c[0] < 4 || c[1] < 4 || c[0] > 635 || c[1] > 475)) continue;
      seen.push({ model, corners, distance: Math.hypot(...sub(centre, camera.world_from_camera.position)) });
    }
  }
  return seen.sort((a, b) => b.distance - a.distance);
}

/** A measured pose: the truth with some noise. */
export function measuredPose(id, t) {
  const truth = truePose(id, t);
  const error = [0, 1, 2].map((k) => 0.0011 * noise(t * 91 + k + id.length));
  return { truth, position: add(truth.position, error), orientation: truth.orientation, error_mm: Math.hypot(...error) * 1000 };
}

/** A grey picture (PNG: the browser looks at the bytes, not at the name) of what a camera sees. */
export function picture(camera, seen, t) {
  const [width, height] = PICTURE;
  const rows = Buffer.alloc((width + 1) * height);
  for (let v = 0; v < height; v++) {
    for (let u = 0; u < width; u++) {
      const floor = ((u >> 5) + (v >> 5)) & 1 ? 6 : 0;
      rows[v * (width + 1) + 1 + u] = 74 + floor + 40 * (v / height) + 5 * noise(u * 3.1 + v * 7.7 + t);
    }
  }
  for (const { model, corners } of seen) paint(rows, width, height, model, corners.map(([x, y]) => [((x + 0.5) * width) / IMAGE[0], ((y + 0.5) * height) / IMAGE[1]]));
  return encode(rows, width, height);
}

function paint(rows, width, height, model, [tl, tr, br, bl]) {
  const map = squareFrom(tl, tr, br, bl);
  const margin = 0.3 * Math.hypot(tr[0] - bl[0], tr[1] - bl[1]);
  const range = (k, limit) => [Math.max(0, Math.floor(Math.min(tl[k], tr[k], br[k], bl[k]) - margin)), Math.min(limit, Math.ceil(Math.max(tl[k], tr[k], br[k], bl[k]) + margin))];
  const [u0, u1] = range(0, width);
  const [v0, v1] = range(1, height);
  for (let v = v0; v < v1; v++) {
    for (let u = u0; u < u1; u++) {
      const [x, y] = map(u + 0.5, v + 0.5).map((value) => Math.floor(value * 8 + 1));
      const module = model.modules[y]?.[x];
      if (module !== undefined) rows[v * (width + 1) + 1 + u] = module === "1" ? 205 : 38;
    }
  }
}

/** Picture to unit square, by the inverse of the projective map of the square (Heckbert 1989). */
function squareFrom([x0, y0], [x1, y1], [x2, y2], [x3, y3]) {
  const [dx1, dx2, sx] = [x1 - x2, x3 - x2, x0 - x1 + x2 - x3];
  const [dy1, dy2, sy] = [y1 - y2, y3 - y2, y0 - y1 + y2 - y3];
  const d = dx1 * dy2 - dx2 * dy1;
  const [g, h] = [(sx * dy2 - dx2 * sy) / d, (dx1 * sy - sx * dy1) / d];
  const [a, b, c, e, f, i] = [x1 - x0 + g * x1, x3 - x0 + h * x3, x0, y1 - y0 + g * y1, y3 - y0 + h * y3, y0];
  return (u, v) => {
    const [A, B, C, D] = [a - g * u, b - h * u, e - g * v, f - h * v];
    const det = A * D - B * C;
    return [((u - c) * D - B * (v - i)) / det, (A * (v - i) - C * (u - c)) / det];
  };
}

function encode(rows, width, height) {
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header[8] = 8;
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", header), chunk("IDAT", deflateSync(rows, { level: 1 })), chunk("IEND", Buffer.alloc(0))]);
}

function chunk(name, data) {
  const body = Buffer.concat([Buffer.from(name, "latin1"), data]);
  const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
  length.writeUInt32BE(data.length);
  sum.writeUInt32BE(crc32(body));
  return Buffer.concat([length, body, sum]);
}
