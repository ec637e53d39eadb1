// Which tag outlines belong on a picture. Pictures and observations of a camera come on separate ways and either may be
// skipped: outlines are those of the same capture time where there are any, else interpolated between the neighbours.

import type { DetectionReport, Observations, Point, TagOutline } from "./protocol.ts";

const KEPT = 48;
const REPORTS_KEPT = 8;
/** Neighbours further apart than this are not interpolated. */
export const SPAN_NS = 400e6;
/** A single observation further away than this is not shown. */
const REACH_NS = 150e6;

/** The last observations of one camera, in order of capture time. */
export class OutlineHistory {
  private readonly history: Observations[] = [];

  add(observations: Observations): void {
    let at = this.history.length;
    while (at > 0 && (this.history[at - 1]?.t_ns ?? 0) > observations.t_ns) at--;
    this.history.splice(at, 0, observations);
    if (this.history.length > KEPT) this.history.shift();
  }

  clear(): void {
    this.history.length = 0;
  }

  /** All that were seen in these observations, tags several times. */
  recent(): TagOutline[] {
    return this.history.flatMap((entry) => entry.tags);
  }

  /** The newest that is not later than `t_ns`. */
  before(t_ns: number): Observations | null {
    return this.history.findLast((entry) => entry.t_ns <= t_ns) ?? null;
  }

  /** The outlines at capture time `t_ns`; empty when nothing near is known. */
  at(t_ns: number): TagOutline[] {
    const after = this.history.findIndex((entry) => entry.t_ns >= t_ns);
    const next = after < 0 ? undefined : this.history[after];
    if (next?.t_ns === t_ns) return next.tags;
    const previous = after < 0 ? this.history.at(-1) : this.history[after - 1];
    if (previous && next && next.t_ns - previous.t_ns < SPAN_NS) return interpolate(previous, next, t_ns);
    return nearest(previous, next, t_ns)?.tags ?? [];
  }
}

/** What a camera's detector made of the last images that it told of. */
export class ReportHistory {
  private readonly history: DetectionReport[] = [];

  add(report: DetectionReport): void {
    this.history.push(report);
    if (this.history.length > REPORTS_KEPT) this.history.shift();
  }

  clear(): void {
    this.history.length = 0;
  }

  get newest(): DetectionReport | null {
    return this.history.at(-1) ?? null;
  }

  /**
   * The report nearest to capture time `t_ns`; none when nothing near is known. Most of what is turned down stands
   * still.
   */
  near(t_ns: number): DetectionReport | null {
    const distance = (report: DetectionReport): number => Math.abs(report.capture_ns - t_ns);
    const nearest = [...this.history].sort((a, b) => distance(a) - distance(b))[0];
    return nearest && distance(nearest) <= SPAN_NS ? nearest : null;
  }
}

function nearest(a: Observations | undefined, b: Observations | undefined, t_ns: number): Observations | undefined {
  const distance = (entry: Observations | undefined): number => (entry ? Math.abs(entry.t_ns - t_ns) : Infinity);
  const closer = distance(a) <= distance(b) ? a : b;
  return distance(closer) <= REACH_NS ? closer : undefined;
}

function interpolate(from: Observations, to: Observations, t_ns: number): TagOutline[] {
  const share = (t_ns - from.t_ns) / (to.t_ns - from.t_ns);
  return from.tags.flatMap((tag) => {
    const later = to.tags.find((other) => other.id === tag.id && other.family === tag.family);
    return later ? [{ ...tag, corners: between(tag.corners, later.corners, share) }] : [];
  });
}

type Corners = TagOutline["corners"];

function between(from: Corners, to: Corners, share: number): Corners {
  const point = (k: 0 | 1 | 2 | 3): Point => [
    from[k][0] + (to[k][0] - from[k][0]) * share,
    from[k][1] + (to[k][1] - from[k][1]) * share,
  ];
  return [point(0), point(1), point(2), point(3)];
}

/** A point of the camera's image on a picture of another size; pixel (0, 0) is the centre of the top-left pixel. */
export function onPicture(point: Point, image: [number, number], picture: [number, number]): Point {
  return [((point[0] + 0.5) / image[0]) * picture[0], ((point[1] + 0.5) / image[1]) * picture[1]];
}
