// Frame scheduling: draws only after a change and while visible, at most 60 times a second, less often where drawing is
// slow.

const SHORTEST_MS = 1000 / 60;
const LONGEST_MS = 160;

export class Frames {
  /** Pictures drawn so far, and the time that scripts took for them, ms. */
  count = 0;
  scriptMs = 0;
  private wanted = false;
  private scheduled = false;
  private drawnAt = -Infinity;
  private intervalMs = SHORTEST_MS;
  private costMs = 0;
  private held = false;
  private readonly next = (now: number): void => this.frame(now);
  private readonly nextLater = (): void => void requestAnimationFrame(this.next);
  private readonly measured = (): void => this.measure();

  /** `draw` tells whether it wants to be called again without a further change. */
  constructor(private readonly draw: (nowMs: number) => boolean) {}

  request(): void {
    this.wanted = true;
    this.schedule();
  }

  /** Draws nothing for a while: something else covers the stage. */
  hold(held: boolean): void {
    this.held = held;
    if (!held) this.request();
  }

  private schedule(): void {
    if (this.scheduled || this.held) return;
    this.scheduled = true;
    const wait = this.drawnAt + this.intervalMs - performance.now() - 4;
    if (wait > 4) window.setTimeout(this.nextLater, wait);
    else requestAnimationFrame(this.next);
  }

  private frame(now: number): void {
    this.scheduled = false;
    if (!this.wanted || this.held) return;
    this.wanted = false;
    this.drawnAt = performance.now();
    const again = this.draw(now);
    this.count++;
    this.scriptMs += performance.now() - this.drawnAt;
    requestAnimationFrame(this.measured);
    if (again) this.request();
  }

  /** The browser's next frame comes late where drawing is slow: then at most half of the time goes into drawing. */
  private measure(): void {
    if (document.hidden) return;
    this.costMs += 0.15 * (Math.min(500, performance.now() - this.drawnAt) - this.costMs);
    this.intervalMs = Math.min(LONGEST_MS, Math.max(SHORTEST_MS, 2 * (this.costMs - 17)));
  }
}
