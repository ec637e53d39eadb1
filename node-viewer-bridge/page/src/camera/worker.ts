// The camera's worker: finds tags in images, sends them and, when wanted, pictures; one image at a time.

import { Detector } from "../../../../clients/web/dist/sextant.js";
import { detect, drawn, sizeOf } from "./pixels.ts";
import { Uplink } from "./uplink.ts";
import { nowMs, type StartMessage, type FromWorker, type FrameMessage, type ToWorker } from "./words.ts";

const STATUS_MS = 1000;
const PICTURE_MS = 500;
const PICTURE_WIDTH = 640;
const PICTURE_QUALITY = 0.6;
/** Detections from which rate and times are taken. */
const WINDOW = 128;
const RATE_SPAN_MS = 3000;

/** Of calibration boards, and of sites without objects. */
const USUAL_FAMILY = "tag36h11";

const tell = (message: FromWorker) => postMessage(message);
const nanoseconds = (ms: number) => BigInt(Math.round(ms * 1000)) * 1000n;

class Camera {
  #sequence = 0;
  #captured = 0;
  #published = 0;
  #watched = false;
  #begun = nowMs();
  #statusDue = 0;
  #pictureDue = 0;
  /** How much this worker's clock is ahead of the page's, with the delay of the quickest message. */
  #aheadMs = Infinity;
  #recent: { at: number; ms: number }[] = [];
  /** Families to look for, and those that the detector was told. */
  #wanted = [USUAL_FAMILY];
  #families = USUAL_FAMILY;
  readonly #uplink: Uplink;

  constructor(
    private readonly detector: Detector,
    private readonly start: StartMessage,
  ) {
    this.#uplink = new Uplink(start.url, (message) => {
      if (message.type === "report") {
        this.#watched = message.watched;
        this.#wanted = [...new Set([USUAL_FAMILY, ...message.families])];
      }
      tell(message);
    });
  }

  async take({ image, captureMs, isArrival, sentMs, captured }: FrameMessage): Promise<void> {
    const { camera } = this.start;
    const received = nowMs();
    this.#aheadMs = Math.min(this.#aheadMs, received - sentMs);
    this.#captured = captured;
    this.#lookForFamilies();
    const tags = await detect(this.detector, image);
    const detected = nowMs();
    this.#recent.push({ at: detected, ms: detected - received });
    if (this.#recent.length > WINDOW) this.#recent.shift();
    const sequence = ++this.#sequence;
    const times = { captureNs: nanoseconds(captureMs + this.#aheadMs), receivedNs: nanoseconds(received), detectedNs: nanoseconds(detected), isArrival };
    if (this.#uplink.joined && this.#uplink.send(this.detector.observations(camera, sequence, times))) this.#published++;
    const outlines = tags.map(({ id, corners }) => ({ id, corners }));
    tell({ type: "seen", outlines, size: sizeOf(image), light: this.detector.light(), rateHz: this.#rateHz(), detectMs: detected - received });
    this.#sendStatus(detected);
    if (this.start.pictures && this.#watched && this.#uplink.joined && detected >= this.#pictureDue) {
      this.#pictureDue = detected + PICTURE_MS;
      await this.#sendPicture(image, sequence, times.captureNs);
    }
  }

  /**
   * Looks for tags of the wanted families, as far as the detector reads them. Between images only: it forgets the
   * pixels.
   */
  #lookForFamilies(): void {
    if (this.#wanted.join() === this.#families) return;
    this.#families = this.#wanted.join();
    const unread = this.#wanted.filter((family) => !reads(this.detector, family));
    this.detector.configure({ families: this.#wanted.filter((family) => !unread.includes(family)), tracking: true });
    tell({ type: "unread", families: unread });
  }

  #sendStatus(now: number): void {
    if (now < this.#statusDue || !this.#uplink.joined) return;
    this.#statusDue = now + STATUS_MS;
    const times = this.#recent.map(({ ms }) => ms).sort((a, b) => a - b);
    const rank = (share: number) => times[Math.floor((times.length - 1) * share)] ?? 0;
    const figures = {
      captured: this.#captured,
      detected: this.#sequence,
      published: this.#published,
      rateHz: this.#rateHz(),
      detectMs: [rank(0.5), rank(0.99)] as [number, number],
      uptimeS: Math.floor((now - this.#begun) / 1000),
    };
    this.#uplink.send(this.detector.status(this.start.camera, this.start.host, figures));
  }

  async #sendPicture(image: VideoFrame | ImageBitmap, sequence: number, captureNs: bigint): Promise<void> {
    const size = sizeOf(image);
    const canvas = drawn(image, Math.min(1, PICTURE_WIDTH / size[0]));
    const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: PICTURE_QUALITY });
    const jpeg = new Uint8Array(await blob.arrayBuffer());
    this.#uplink.send(this.detector.preview(this.start.camera, sequence, captureNs, size, jpeg));
  }

  /** No image has come for a while; the site hears that the browser is there. */
  silent(): void {
    this.#recent = [];
    this.#sendStatus(nowMs());
  }

  #rateHz(): number {
    const last = this.#recent.at(-1);
    const recent = this.#recent.filter(({ at }) => last && last.at - at <= RATE_SPAN_MS);
    const span = last && recent[0] ? last.at - recent[0].at : 0;
    return span > 0 ? ((recent.length - 1) / span) * 1000 : 0;
  }

  end(): void {
    this.#uplink.close();
  }
}

function reads(detector: Detector, family: string): boolean {
  try {
    detector.configure({ families: [family] });
    return true;
  } catch {
    return false;
  }
}

let camera: Camera | null = null;
/** Counts beginnings and ends: a detector that was loaded meanwhile is not used. */
let run = 0;

async function obey(message: ToWorker): Promise<void> {
  switch (message.type) {
    case "begin": {
      const own = ++run;
      camera?.end();
      camera = null;
      const detector = await Detector.load({ families: [USUAL_FAMILY], tracking: true });
      if (own !== run) return;
      camera = new Camera(detector, message);
      return tell({ type: "ready" });
    }
    case "taken":
      try {
        await camera?.take(message);
      } finally {
        message.image.close();
        tell({ type: "ready" });
      }
      return;
    case "silent":
      return camera?.silent();
    case "end":
      run++;
      camera?.end();
      camera = null;
  }
}

addEventListener("message", ({ data }: MessageEvent<ToWorker>) => {
  obey(data).catch((cause: unknown) => tell({ type: "failed", cause: cause instanceof Error ? cause.message : String(cause) }));
});
