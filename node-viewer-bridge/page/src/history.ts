// The last minutes of the site in memory that does not grow: rings of numbers. Times are seconds since the Unix epoch,
// as the site's clocks have them.

import { rollPitchYaw } from "./attitude.ts";
import { sigma } from "./covariance.ts";
import type { Pose, State } from "./protocol.ts";

/**
 * A sample older than the last by more than this means that the clock was set, or that a recording begins again: what
 * was there is dropped.
 */
const CLOCK_SET_S = 3;

/** Rows of numbers by time; a new row replaces the oldest. */
export class Ring {
  private readonly times: Float64Array;
  private readonly columns: Float32Array[];
  private next = 0;
  length = 0;

  constructor(
    readonly capacity: number,
    nColumns: number,
  ) {
    this.times = new Float64Array(capacity);
    this.columns = Array.from({ length: nColumns }, () => new Float32Array(capacity));
  }

  /** Takes a row that is later than the last; others are passed over. */
  push(time: number, row: ArrayLike<number>): void {
    const last = this.lastTime;
    if (time < last - CLOCK_SET_S) this.clear();
    else if (time <= last) return;
    this.times[this.next] = time;
    for (let k = 0; k < this.columns.length; k++) (this.columns[k] as Float32Array)[this.next] = row[k] ?? NaN;
    this.next = (this.next + 1) % this.capacity;
    this.length = Math.min(this.length + 1, this.capacity);
  }

  clear(): void {
    this.length = this.next = 0;
  }

  /** Time of a row, 0 being the oldest. */
  time(index: number): number {
    return this.times[this.place(index)] ?? NaN;
  }

  value(column: number, index: number): number {
    return this.columns[column]?.[this.place(index)] ?? NaN;
  }

  get firstTime(): number {
    return this.length > 0 ? this.time(0) : Infinity;
  }

  get lastTime(): number {
    return this.length > 0 ? this.time(this.length - 1) : -Infinity;
  }

  /** The last row that is not after `time`; -1 where all are. */
  before(time: number): number {
    let [low, high] = [0, this.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  private place(index: number): number {
    return (this.next - this.length + index + this.capacity) % this.capacity;
  }
}

/** Columns of an object's track. */
export const TRACK = {
  x: 0, y: 1, z: 2, qx: 3, qy: 4, qz: 5, qw: 6, roll: 7, pitch: 8, yaw: 9, sigma_mm: 10, sigma_deg: 11,
  xx: 12, xy: 13, xz: 14, yy: 15, yz: 16, zz: 17, state: 18, latency_ms: 19,
} as const;
const N_COLUMNS = Object.keys(TRACK).length;
const STATES: readonly State[] = ["initialising", "tracking", "coasting", "lost"];

/** Each pose of the last minute, and four a second of the last ten. */
const FINE = 2048;
const COARSE = 2560;
const COARSE_STEP_S = 0.25;
/** Between poses further apart than this nothing is known. */
const GAP_S = 0.6;

/** Where one object was. */
export class ObjectTrack {
  readonly fine = new Ring(FINE, N_COLUMNS);
  readonly coarse = new Ring(COARSE, N_COLUMNS);
  private readonly row = new Float64Array(N_COLUMNS);

  add(pose: Pose): void {
    const { row } = this;
    const { position_mm, attitude_deg } = sigma(pose.covariance);
    const c = pose.covariance;
    row.set(pose.position, TRACK.x);
    row.set(pose.orientation, TRACK.qx);
    row.set(rollPitchYaw(pose.orientation), TRACK.roll);
    row[TRACK.sigma_mm] = position_mm;
    row[TRACK.sigma_deg] = attitude_deg;
    [c[0], c[1], c[2], c[7], c[8], c[14]].forEach((value, k) => (row[TRACK.xx + k] = value ?? 0));
    row[TRACK.state] = STATES.indexOf(pose.state);
    row[TRACK.latency_ms] = pose.latency_ms;
    const time = pose.t_ns / 1e9;
    this.fine.push(time, row);
    if (time >= this.coarse.lastTime + COARSE_STEP_S || time < this.coarse.lastTime - CLOCK_SET_S) this.coarse.push(time, row);
  }

  /** The ring that reaches back to `time`, the finer where both do. */
  ring(time: number): Ring {
    return time >= this.fine.firstTime || this.coarse.firstTime >= this.fine.firstTime ? this.fine : this.coarse;
  }

  /** Writes the pose at `time` into `target`, interpolated; tells whether there is one. */
  at(time: number, target: Pose): boolean {
    const ring = this.ring(time);
    const before = ring.before(time);
    if (before < 0) return false;
    const after = before + 1;
    const span = after < ring.length ? ring.time(after) - ring.time(before) : Infinity;
    if (span > GAP_S) {
      if (time - ring.time(before) > GAP_S) return false;
      read(ring, before, before, 0, target);
    } else read(ring, before, after, (time - ring.time(before)) / span, target);
    target.t_ns = time * 1e9;
    return true;
  }
}

/** A pose to be written into; covers what a track keeps. */
export function blankPose(object: string): Pose {
  return {
    object, sequence: 0, t_ns: 0, position: [0, 0, 0], orientation: [0, 0, 0, 1], covariance: new Array<number>(36).fill(0),
    twist: [0, 0, 0, 0, 0, 0], state: "lost", cameras: 0, tags: 0, rms_px: 0, latency_ms: 0,
  };
}

function read(ring: Ring, before: number, after: number, share: number, target: Pose): void {
  const mix = (column: number): number => {
    const from = ring.value(column, before);
    return from + (ring.value(column, after) - from) * share;
  };
  for (let k = 0; k < 3; k++) target.position[k] = mix(TRACK.x + k);
  readOrientation(ring, before, after, share, target);
  readCovariance(ring, before, target);
  target.state = STATES[ring.value(TRACK.state, before)] ?? "lost";
  target.latency_ms = ring.value(TRACK.latency_ms, before);
}

/** Along the shorter way between two attitudes, which lie close together. */
function readOrientation(ring: Ring, before: number, after: number, share: number, target: Pose): void {
  let dot = 0;
  for (let k = 0; k < 4; k++) dot += ring.value(TRACK.qx + k, before) * ring.value(TRACK.qx + k, after);
  const sign = dot < 0 ? -1 : 1;
  let length = 0;
  for (let k = 0; k < 4; k++) {
    const from = ring.value(TRACK.qx + k, before);
    const value = from + (sign * ring.value(TRACK.qx + k, after) - from) * share;
    target.orientation[k] = value;
    length += value * value;
  }
  for (let k = 0; k < 4; k++) target.orientation[k] = (target.orientation[k] ?? 0) / Math.sqrt(length || 1);
}

/**
 * The position's covariance as it was; of the attitude only how large it was is kept, taken as equal about all axes.
 */
function readCovariance(ring: Ring, at: number, target: Pose): void {
  const c = target.covariance;
  const kept = (column: number): number => ring.value(column, at);
  c[0] = kept(TRACK.xx);
  c[1] = c[6] = kept(TRACK.xy);
  c[2] = c[12] = kept(TRACK.xz);
  c[7] = kept(TRACK.yy);
  c[8] = c[13] = kept(TRACK.yz);
  c[14] = kept(TRACK.zz);
  const variance = ((kept(TRACK.sigma_deg) * Math.PI) / 180) ** 2 / 3;
  c[21] = c[28] = c[35] = variance;
}

/** Samples of figures that come and go, such as a camera's rate: five a second for ten minutes. */
const SAMPLES = 3000;
/** Figures that are kept; further ones are left out. */
const MAX_FIGURES = 512;

export class Figures {
  readonly capacity: number;
  private readonly times: Float64Array;
  private readonly columns = new Map<string, Float32Array>();
  private readonly writtenAt = new Map<string, number>();
  private next = 0;
  private written = 0;
  length = 0;

  constructor(capacity = SAMPLES) {
    this.capacity = capacity;
    this.times = new Float64Array(capacity);
  }

  /** Starts a row; false if it is not later than the last. Figures not written to it are missing. */
  begin(time: number): boolean {
    const last = this.length > 0 ? this.time(this.length - 1) : -Infinity;
    if (time < last - CLOCK_SET_S) this.clear();
    else if (time <= last) return false;
    this.next = this.written % this.capacity;
    this.written++;
    this.length = Math.min(this.written, this.capacity);
    this.times[this.next] = time;
    for (const column of this.columns.values()) column[this.next] = NaN;
    if (this.next === 0) this.dropStale();
    return true;
  }

  write(name: string, value: number | null): void {
    if (value === null || !Number.isFinite(value) || this.written === 0) return;
    const column = this.columns.get(name) ?? this.create(name);
    if (!column) return;
    column[this.next] = value;
    this.writtenAt.set(name, this.written);
  }

  clear(): void {
    this.columns.clear();
    this.writtenAt.clear();
    this.written = this.length = this.next = 0;
  }

  time(index: number): number {
    return this.times[this.place(index)] ?? NaN;
  }

  /** NaN where it is missing. */
  value(name: string, index: number): number {
    return this.columns.get(name)?.[this.place(index)] ?? NaN;
  }

  /** Names of the figures whose name begins so, in order. */
  names(prefix: string): string[] {
    return [...this.columns.keys()].filter((name) => name.startsWith(prefix)).sort();
  }

  private create(name: string): Float32Array | undefined {
    if (this.columns.size >= MAX_FIGURES) return undefined;
    const column = new Float32Array(this.capacity).fill(NaN);
    this.columns.set(name, column);
    return column;
  }

  /** Drops what was not written during a whole turn. */
  private dropStale(): void {
    for (const [name, at] of this.writtenAt) {
      if (at > this.written - this.capacity) continue;
      this.columns.delete(name);
      this.writtenAt.delete(name);
    }
  }

  private place(index: number): number {
    return (this.written - this.length + index) % this.capacity;
  }
}
