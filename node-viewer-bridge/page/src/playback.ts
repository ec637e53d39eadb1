// Which time the page shows: the present, or one of the last minutes. Knows only where poses come from, not how they
// are drawn, so that a recording may take the place of the page's own memory.

/** Somewhere with poses over time, seconds since the Unix epoch. */
export interface PoseSource {
  /** Oldest and newest time; none while there is nothing. */
  span(): [number, number] | null;
  /** Shows what was at a time; null: the present. */
  replay(time: number | null): void;
}

/** Nothing older than this is offered: poses of before are kept sparsely or not at all. */
export const REACH_S = 600;

export class Playback {
  /** The shown time; null: the present. */
  at: number | null = null;
  playing = false;

  constructor(
    private readonly source: PoseSource,
    private readonly changed: () => void,
  ) {}

  /** What can be shown. */
  range(): [number, number] | null {
    const span = this.source.span();
    return span && [Math.max(span[0], span[1] - REACH_S), span[1]];
  }

  /** Shows a time, as near to it as there are poses; stands still there. */
  seek(time: number): void {
    const range = this.range();
    if (!range) return;
    this.at = Math.min(range[1], Math.max(range[0], time));
    this.playing = false;
    this.show();
  }

  /** Goes back or forward; beyond the newest pose is the present. */
  step(seconds: number): void {
    const range = this.range();
    if (!range) return;
    const target = (this.at ?? range[1]) + seconds;
    if (target >= range[1]) this.live();
    else this.seek(target);
  }

  live(): void {
    this.at = null;
    this.playing = false;
    this.show();
  }

  /** Holds the present, or lets a held time run on. */
  toggle(): void {
    const range = this.range();
    if (!range) return;
    if (this.at === null) return this.seek(range[1]);
    this.playing = !this.playing;
    this.changed();
  }

  /** Time went by; called often. */
  advance(seconds: number): void {
    const range = this.range();
    if (this.at === null || !range) return;
    if (!this.playing && this.at >= range[0]) return;
    const target = this.playing ? this.at + seconds : this.at;
    this.at = Math.min(range[1], Math.max(range[0], target));
    this.show();
  }

  private show(): void {
    this.source.replay(this.at);
    this.changed();
  }
}
