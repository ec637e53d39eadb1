// The device's camera: opened as a person wants it, its images with their times of capture, its focus and exposure.

/** What a person wants of the camera. */
export interface Wanted {
  width: number;
  height: number;
  rate: number;
}

/** From the exposure of an image to its arrival in the page, at most. */
const LONGEST_LATENCY_MS = 1000;

/** Constraints that TypeScript's own types do not have yet. */
type Modes = { focusMode?: string[]; exposureMode?: string[]; whiteBalanceMode?: string[] };

export interface Shot {
  image: VideoFrame | ImageBitmap;
  captureMs: number;
  isArrival: boolean;
}

export class Source {
  #handle = 0;
  /** Images that the camera has delivered. */
  captured = 0;
  /** When the last one came, by the page's clock. */
  #lastMs = performance.now();

  private constructor(
    private readonly video: HTMLVideoElement,
    private readonly stream: MediaStream,
  ) {}

  /** Opens the camera on the back, if there is one. `lost` is called when the system takes it away. */
  static async open(video: HTMLVideoElement, { width, height, rate }: Wanted, lost: () => void): Promise<Source> {
    const wanted = { width: { ideal: width }, height: { ideal: height }, frameRate: { ideal: rate }, facingMode: { ideal: "environment" } };
    const stream = await navigator.mediaDevices.getUserMedia({ audio: false, video: wanted });
    stream.getVideoTracks()[0]?.addEventListener("ended", lost);
    video.srcObject = stream;
    await video.play();
    return new Source(video, stream);
  }

  /** Calls with each image, but only makes one for which `isWanted`. */
  watch(isWanted: () => boolean, take: (shot: Shot) => void): void {
    const next = (now: number, metadata: VideoFrameCallbackMetadata) => {
      this.#handle = this.video.requestVideoFrameCallback(next);
      this.captured++;
      this.#lastMs = performance.now();
      if (!isWanted()) return;
      // Browsers state when a local camera took the image, as its driver says; else, or by a clock that is not the
      // page's, this is the best that is known.
      const captured = metadata.captureTime ?? -Infinity;
      const latency = performance.now() - captured;
      const isArrival = !(latency >= 0 && latency < LONGEST_LATENCY_MS);
      const captureMs = performance.timeOrigin + (isArrival ? now : captured);
      if ("VideoFrame" in window) {
        const image = new VideoFrame(this.video);
        // The video element may already show a newer frame than this callback reports.
        const newerMs = image.timestamp / 1000 - metadata.mediaTime * 1000;
        take({ image, captureMs: captureMs + (Math.abs(newerMs) < LONGEST_LATENCY_MS ? newerMs : 0), isArrival });
      } else void createImageBitmap(this.video).then((image) => take({ image, captureMs, isArrival }));
    };
    this.#handle = this.video.requestVideoFrameCallback(next);
  }

  /** For how long the camera has delivered nothing: another app has it, or the system has paused it, without an end. */
  get silentMs(): number {
    return performance.now() - this.#lastMs;
  }

  /** Whether focus or exposure can be fixed. */
  get canFix(): boolean {
    return this.#fixable().length > 0;
  }

  /** Keeps focus, exposure and white balance as they are now, or lets the camera choose. */
  async fix(fixed: boolean): Promise<void> {
    const constraints = Object.fromEntries(this.#fixable().map((name) => [name, fixed ? "manual" : "continuous"]));
    await this.stream.getVideoTracks()[0]?.applyConstraints({ advanced: [constraints as MediaTrackConstraintSet] });
  }

  #fixable(): (keyof Modes)[] {
    const track = this.stream.getVideoTracks()[0];
    const can = (track && "getCapabilities" in track ? track.getCapabilities() : {}) as Modes;
    return (["focusMode", "exposureMode", "whiteBalanceMode"] as const).filter((name) => can[name]?.includes("manual") && can[name].includes("continuous"));
  }

  close(): void {
    this.video.cancelVideoFrameCallback(this.#handle);
    for (const track of this.stream.getTracks()) track.stop();
    this.video.srcObject = null;
  }
}
