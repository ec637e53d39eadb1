// The geometry of a small 3-D picture: squares and lines seen from an orbit, farthest first. Pure; metres in, pixels
// out.

import type { Point, Quaternion, Vec3 } from "../protocol.ts";

/** A square tag somewhere. */
export interface Patch {
  name: string;
  position: Vec3;
  orientation: Quaternion;
  /** Edge, metres. */
  size: number;
  colour: string;
  /** A point behind the patch that lines run to: the centre of a camera whose picture it is. */
  apex?: Vec3;
}

/** A patch on the screen. */
export interface Drawn {
  patch: Patch;
  corners: Point[];
  centre: Point;
  apex: Point | null;
  /** Whether its face is turned to the viewer. */
  faces: boolean;
  depth: number;
}

/** From where it is looked at: angles in radians about the middle of all. */
export interface Orbit {
  turn: number;
  tilt: number;
}

const CORNERS: Point[] = [
  [-0.5, 0.5],
  [0.5, 0.5],
  [0.5, -0.5],
  [-0.5, -0.5],
];
/** Distance of the viewer, in radii of the whole. */
const DISTANCE = 4;
/** The whole, whichever way it is turned, fills this part of the picture. */
const FILLS = 0.9;

export function rotate([x, y, z, w]: Quaternion, [px, py, pz]: Vec3): Vec3 {
  const [cx, cy, cz] = [y * pz - z * py + w * px, z * px - x * pz + w * py, x * py - y * px + w * pz];
  return [px + 2 * (y * cz - z * cy), py + 2 * (z * cx - x * cz), pz + 2 * (x * cy - y * cx)];
}

/** The patches as they appear in a picture of `size` pixels, farthest first. */
export function appear(patches: Patch[], orbit: Orbit, size: [number, number]): Drawn[] {
  const placed = patches.map((patch) => ({ patch, corners: CORNERS.map((corner) => cornerOf(patch, corner)) }));
  const points = placed.flatMap(({ patch, corners }) => (patch.apex ? [patch.apex, ...corners] : corners));
  if (points.length === 0) return [];
  const centre = middle(points);
  const radius = Math.max(1e-6, ...points.map((point) => Math.hypot(...minus(point, centre))));
  const project = (point: Vec3): [Point, number] => onScreen(view(minus(point, centre), orbit), radius, size);
  const drawn = placed.map(({ patch, corners }) => {
    const seen = corners.map(project);
    const [at, depth] = project(patch.position);
    const apex = patch.apex ? project(patch.apex)[0] : null;
    return { patch, corners: seen.map(([point]) => point), centre: at, apex, faces: area(seen.map(([point]) => point)) > 0, depth };
  });
  return drawn.sort((a, b) => b.depth - a.depth);
}

function cornerOf(patch: Patch, [x, y]: Point): Vec3 {
  const [dx, dy, dz] = rotate(patch.orientation, [x * patch.size, y * patch.size, 0]);
  return [patch.position[0] + dx, patch.position[1] + dy, patch.position[2] + dz];
}

function middle(points: Vec3[]): Vec3 {
  const range = (axis: 0 | 1 | 2): number => {
    const values = points.map((point) => point[axis]);
    return (Math.min(...values) + Math.max(...values)) / 2;
  };
  return [range(0), range(1), range(2)];
}

function minus(a: Vec3, b: Vec3): Vec3 {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** Into the viewer's axes: x right, y up, z towards the viewer. The object's z is up on the screen. */
function view([x, y, z]: Vec3, { turn, tilt }: Orbit): Vec3 {
  const [right, away] = [Math.cos(turn) * x + Math.sin(turn) * y, -Math.sin(turn) * x + Math.cos(turn) * y];
  return [right, Math.cos(tilt) * z + Math.sin(tilt) * away, Math.sin(tilt) * z - Math.cos(tilt) * away];
}

function onScreen([x, y, z]: Vec3, radius: number, [width, height]: [number, number]): [Point, number] {
  const depth = DISTANCE * radius - z;
  const scale = (FILLS * 0.5 * Math.min(width, height) * Math.sqrt(DISTANCE * DISTANCE - 1)) / depth;
  return [[width / 2 + scale * x, height / 2 - scale * y], depth];
}

/** Positive where the corners run clockwise on the screen, as those of a tag do that faces the viewer. */
function area(corners: Point[]): number {
  return corners.reduce((sum, [x, y], at) => {
    const [nextX, nextY] = corners[(at + 1) % corners.length] as Point;
    return sum + x * nextY - nextX * y;
  }, 0);
}
