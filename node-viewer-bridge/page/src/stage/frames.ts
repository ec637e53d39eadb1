// When to draw: only after something changed, at most 30 times a second, less often where drawing is slow.

const SHORTEST_MS = 1000 / 30;
const LONGEST_MS = 160;

export class Frames {
  /** Pictures drawn so far. */
  count = 0;
  private wanted = false;
  private scheduled = false;
  private drawnAt = -Infinity;
  private intervalMs = SHORTEST_MS;
  private costMs = 0;

  /** `draw` tells whether it wants to be called again without a further change. */
  constructor(private readonly draw: (nowMs: number) => boolean) {}

  request(): void {
    this.wanted = true;
    this.schedule();
  }

  private schedule(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    const wait = this.drawnAt + this.intervalMs - performance.now() - 4;
    if (wait > 4) window.setTimeout(() => requestAnimationFrame((now) => this.frame(now)), wait);
    else requestAnimationFrame((now) => this.frame(now));
  }

  private frame(now: number): void {
    this.scheduled = false;
    if (!this.wanted) return;
    this.wanted = false;
    this.drawnAt = performance.now();
    const again = this.draw(now);
    this.count++;
    this.measure();
    if (again) this.request();
  }

  /** The browser's next frame comes late where drawing is slow: then at most half of the time goes into drawing. */
  private measure(): void {
    const begun = this.drawnAt;
    requestAnimationFrame(() => {
      if (document.hidden) return;
      this.costMs += 0.15 * (Math.min(500, performance.now() - begun) - this.costMs);
      this.intervalMs = Math.min(LONGEST_MS, Math.max(SHORTEST_MS, 2 * (this.costMs - 17)));
    });
  }
}
