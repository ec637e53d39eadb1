// The time line below the stage: goes back through the last minutes, and forward to the present.

import { fixed } from "../format.ts";
import type { Playback } from "../playback.ts";
import type { Site } from "../site.ts";
import { clock } from "./chart.ts";
import { element, pressButton, testId, Text } from "./dom.ts";

/** Steps of the slider a second. */
const STEPS = 20;

export class Timeline {
  private readonly slider = testId(element("input"), "timeline-slider");
  private readonly play: HTMLButtonElement;
  private readonly live: HTMLButtonElement;
  private readonly readout = new Text(testId(element("output"), "timeline-time"));
  private readonly marks = element("div", "marks");
  private shownMarks = "";
  private held = false;

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
    private readonly playback: Playback,
  ) {
    this.slider.type = "range";
    this.slider.min = "0";
    this.slider.setAttribute("aria-label", "Time that is shown");
    this.slider.addEventListener("input", () => this.seek());
    this.slider.addEventListener("pointerdown", () => (this.held = true));
    for (const end of ["pointerup", "pointercancel", "blur"]) this.slider.addEventListener(end, () => (this.held = false));
    this.play = pressButton("", "timeline-play", () => playback.toggle());
    this.live = pressButton("Live", "timeline-live", () => playback.live());
    root.append(this.play, element("div", "rail", this.slider, this.marks), this.readout.element, this.live);
  }

  update(): void {
    const range = this.playback.range();
    this.root.dataset["live"] = String(this.playback.at === null);
    this.slider.disabled = this.play.disabled = range === null;
    const moving = this.playback.at === null || this.playback.playing;
    this.play.dataset["moving"] = String(moving);
    this.play.setAttribute("aria-label", moving ? "Hold" : "Play");
    this.live.setAttribute("aria-pressed", String(this.playback.at === null));
    if (!range) return this.readout.set("–");
    const [from, to] = range;
    const at = this.playback.at ?? to;
    this.slider.max = String(Math.round((to - from) * STEPS));
    if (!this.held) this.slider.value = String(Math.round((at - from) * STEPS));
    const text = this.playback.at === null ? clock(to) : `${clock(at, 1)}  −${fixed(to - at, 1)} s`;
    this.readout.set(text);
    this.slider.setAttribute("aria-valuetext", text);
    this.showMarks(from, to);
  }

  private seek(): void {
    const range = this.playback.range();
    if (range) this.playback.seek(range[0] + Number(this.slider.value) / STEPS);
  }

  /** A mark for each event of the zones. */
  private showMarks(from: number, to: number): void {
    const span = to - from;
    const places = this.site.events.map((event) => (event.t_ns / 1e9 - from) / span).filter((place) => place >= 0 && place <= 1);
    const key = places.map((place) => place.toFixed(2)).join();
    if (key === this.shownMarks) return;
    this.shownMarks = key;
    this.marks.replaceChildren(
      ...places.map((place) => {
        const mark = element("i");
        mark.style.left = `${(100 * place).toFixed(2)}%`;
        return mark;
      }),
    );
  }
}
