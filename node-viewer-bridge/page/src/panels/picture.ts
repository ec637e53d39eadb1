// A camera's live picture with tag outlines and ids over it, and on request what the detector turned down. One picture
// is decoded at a time; newer ones replace waiting ones, so that a slow machine skips pictures and holds none back.

import { onPicture, SPAN_NS } from "../matching.ts";
import { CAUSE, STRANGER } from "../palette.ts";
import type { Point, Preview, RejectedCandidate, TagOutline } from "../protocol.ts";
import type { CameraState, Site } from "../site.ts";
import { element, testId } from "./dom.ts";

const MAX_PIXEL_RATIO = 2;
/** A tag smaller than this on the screen gets a finer line. */
const SMALL_PX = 26;
/** A tag smaller than this has no room for its id; enlarging the picture shows it. */
const ILLEGIBLE_PX = 9;
const HALO = "rgba(8, 11, 15, 0.75)";

export class Picture {
  readonly root: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  private readonly overlay: HTMLCanvasElement;
  private shownAt_ns: number | null = null;
  private waiting: Preview | null = null;
  private decoding = false;
  private overlayWanted = false;
  /** Whether what the detector turned down is drawn too. */
  withRejected = false;

  constructor(
    private readonly camera: CameraState,
    private readonly site: Site,
    private readonly shown: () => void,
  ) {
    this.canvas = testId(element("canvas", "picture"), `camera-${camera.id}-picture`);
    this.overlay = testId(element("canvas", "overlay"), `camera-${camera.id}-overlay`);
    this.canvas.width = this.canvas.height = 1;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `Live picture of camera ${camera.id}`);
    this.root = element("div", "view", this.canvas, this.overlay);
    new ResizeObserver(() => this.redraw()).observe(this.root);
  }

  /** When the shown picture was taken. */
  get t_ns(): number | null {
    return this.shownAt_ns;
  }

  show(preview: Preview): void {
    if (preview.t_ns === this.shownAt_ns) return;
    this.waiting = preview;
    if (!this.decoding) void this.decodeWaiting();
  }

  /** Outlines may have changed; drawn with the browser's next frame. */
  redraw(): void {
    if (this.overlayWanted) return;
    this.overlayWanted = true;
    requestAnimationFrame(() => {
      this.overlayWanted = false;
      this.drawOutlines();
    });
  }

  /** Whether outlines of this capture time may matter to the shown picture. */
  wants(t_ns: number): boolean {
    return this.shownAt_ns !== null && Math.abs(t_ns - this.shownAt_ns) < SPAN_NS;
  }

  private async decodeWaiting(): Promise<void> {
    this.decoding = true;
    while (this.waiting) {
      const preview = this.waiting;
      this.waiting = null;
      await this.decode(preview);
    }
    this.decoding = false;
  }

  private async decode(preview: Preview): Promise<void> {
    let bitmap: ImageBitmap;
    try {
      bitmap = await createImageBitmap(new Blob([preview.jpeg], { type: "image/jpeg" }));
    } catch {
      return;
    }
    this.paint(bitmap);
    bitmap.close();
    this.shownAt_ns = preview.t_ns;
    this.root.dataset["live"] = "";
    this.redraw();
    this.shown();
  }

  private paint(bitmap: ImageBitmap): void {
    if (this.canvas.width !== bitmap.width) this.canvas.width = bitmap.width;
    if (this.canvas.height !== bitmap.height) this.canvas.height = bitmap.height;
    this.canvas.getContext("2d", { alpha: false })?.drawImage(bitmap, 0, 0);
  }

  private drawOutlines(): void {
    const context = this.overlay.getContext("2d");
    const image = this.camera.resolution;
    if (!context || !image || this.shownAt_ns === null) return;
    const ratio = Math.min(window.devicePixelRatio, MAX_PIXEL_RATIO);
    const size: [number, number] = [this.root.clientWidth, this.root.clientHeight];
    this.fit(Math.round(size[0] * ratio), Math.round(size[1] * ratio));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, ...size);
    const place = (corner: Point): Point => onPicture(corner, image, size);
    const rejected = this.rejected();
    for (const candidate of rejected) drawRejected(context, candidate, place);
    const tags = this.camera.outlines.at(this.shownAt_ns);
    for (const tag of tags) drawOutline(context, tag, this.colour(tag), place);
    this.overlay.dataset["tags"] = String(tags.length);
    this.overlay.dataset["rejected"] = String(rejected.length);
  }

  /**
   * What was turned down in the shown image or one beside it; those that came furthest last, so that they lie on top.
   */
  private rejected(): RejectedCandidate[] {
    if (!this.withRejected || this.shownAt_ns === null) return [];
    return [...(this.camera.reports.near(this.shownAt_ns)?.examples ?? [])].reverse();
  }

  private fit(width: number, height: number): void {
    if (this.overlay.width !== width) this.overlay.width = width;
    if (this.overlay.height !== height) this.overlay.height = height;
  }

  private colour(tag: TagOutline): string {
    return this.site.ownerOf(tag.family, tag.id)?.colour ?? STRANGER;
  }
}

function drawOutline(
  context: CanvasRenderingContext2D,
  tag: TagOutline,
  colour: string,
  place: (corner: Point) => Point,
): void {
  const corners = tag.corners.map(place);
  const smaller = Math.min(extent(corners, 0), extent(corners, 1));
  context.lineJoin = "round";
  context.beginPath();
  for (const [x, y] of corners) context.lineTo(x, y);
  context.closePath();
  if (smaller > SMALL_PX) stroke(context, HALO, 3.5);
  stroke(context, colour, smaller > SMALL_PX ? 1.7 : 1.3);
  if (smaller > ILLEGIBLE_PX) drawId(context, String(tag.id), centre(corners), smaller, colour);
}

function drawRejected(context: CanvasRenderingContext2D, { cause, corners }: RejectedCandidate, place: (corner: Point) => Point): void {
  context.lineJoin = "round";
  context.beginPath();
  for (const corner of corners) context.lineTo(...place(corner));
  context.closePath();
  context.setLineDash([4, 3]);
  stroke(context, CAUSE[cause], 1.2);
  context.setLineDash([]);
}

function stroke(context: CanvasRenderingContext2D, style: string, width: number): void {
  context.strokeStyle = style;
  context.lineWidth = width;
  context.stroke();
}

function drawId(context: CanvasRenderingContext2D, text: string, [x, y]: Point, room: number, colour: string): void {
  context.font = `600 ${Math.min(12, Math.max(8, 0.62 * room))}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.strokeStyle = HALO;
  context.lineWidth = 3;
  context.strokeText(text, x, y);
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

function centre(corners: Point[]): Point {
  const sum = corners.reduce(([sx, sy], [x, y]) => [sx + x, sy + y], [0, 0]);
  return [sum[0] / corners.length, sum[1] / corners.length];
}

function extent(corners: Point[], axis: 0 | 1): number {
  const values = corners.map((corner) => corner[axis]);
  return Math.max(...values) - Math.min(...values);
}
