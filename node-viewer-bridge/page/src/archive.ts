// Pictures of the last minutes for the time line: one a second of each camera, all together within a fixed number of
// bytes; the oldest give way.

import type { Preview } from "./protocol.ts";

const STEP_NS = 1e9;
const MAX_BYTES = 24 << 20;
/** A picture further away than this says nothing about a time. */
const REACH_NS = 3e9;

export class PictureArchive {
  /** In the order in which they came. */
  private readonly pictures: Preview[] = [];
  private readonly lastAt = new Map<string, number>();
  private bytes = 0;

  constructor(private readonly maxBytes = MAX_BYTES) {}

  add(preview: Preview): void {
    const last = this.lastAt.get(preview.camera) ?? -Infinity;
    if (Math.abs(preview.t_ns - last) < STEP_NS) return;
    this.lastAt.set(preview.camera, preview.t_ns);
    // A copy: the picture is a part of the frame that it came in.
    this.pictures.push({ ...preview, jpeg: preview.jpeg.slice() });
    this.bytes += preview.jpeg.byteLength;
    let dropped = 0;
    while (this.bytes > this.maxBytes && dropped < this.pictures.length) this.bytes -= this.pictures[dropped++]?.jpeg.byteLength ?? 0;
    if (dropped > 0) this.pictures.splice(0, dropped);
  }

  /** The picture of a camera nearest to a time. */
  near(camera: string, t_ns: number): Preview | null {
    let nearest: Preview | null = null;
    for (const picture of this.pictures) {
      if (picture.camera !== camera) continue;
      if (!nearest || Math.abs(picture.t_ns - t_ns) < Math.abs(nearest.t_ns - t_ns)) nearest = picture;
    }
    return nearest && Math.abs(nearest.t_ns - t_ns) <= REACH_NS ? nearest : null;
  }

  get size(): number {
    return this.bytes;
  }
}
