// Rates, medians and root mean squares over the last moments of a stream. Time comes from the caller, in seconds.

/** Events a second from a sequence number, so that messages skipped on the way still count. */
export class RateMeter {
  private readonly samples: { at: number; sequence: number }[] = [];

  constructor(private readonly window: number = 2) {}

  add(at: number, sequence: number): void {
    const last = this.samples.at(-1);
    if (last && (sequence < last.sequence || at < last.at)) this.samples.length = 0;
    this.samples.push({ at, sequence });
    this.forget(at);
  }

  /** `null` until there are two samples, and when none came during the window. */
  rate(now: number): number | null {
    this.forget(now);
    const [first, last] = [this.samples[0], this.samples.at(-1)];
    if (!first || !last || last.at - first.at < 0.2) return null;
    return (last.sequence - first.sequence) / (last.at - first.at);
  }

  private forget(now: number): void {
    while (this.samples[0] && this.samples[0].at < now - this.window) this.samples.shift();
  }
}

/** The last values of a stream, at most `capacity` of them. */
export class Recent {
  private readonly values: number[] = [];
  private next = 0;

  constructor(private readonly capacity: number = 32) {}

  add(value: number): void {
    this.values[this.next] = value;
    this.next = (this.next + 1) % this.capacity;
  }

  clear(): void {
    this.values.length = 0;
    this.next = 0;
  }

  median(): number | null {
    if (this.values.length === 0) return null;
    const sorted = [...this.values].sort((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? null;
  }

  rootMeanSquare(): number | null {
    if (this.values.length === 0) return null;
    return Math.sqrt(this.values.reduce((sum, value) => sum + value * value, 0) / this.values.length);
  }
}
