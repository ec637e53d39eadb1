// The switches on the stage: what it shows, remembered for the next visit.

import type { StageOptions } from "../stage/options.ts";
import { MAGNIFICATION } from "../stage/ellipsoid.ts";
import { remember, remembered } from "../storage.ts";
import { pressButton } from "./dom.ts";

const NAMES: Record<keyof StageOptions, string> = {
  trails: "Trails",
  pictures: "Pictures",
  sigma: `σ ×${MAGNIFICATION}`,
  labels: "Names",
};

/** The options of the last visit. */
export function rememberedOptions(): StageOptions {
  const options: StageOptions = { trails: true, pictures: true, sigma: false, labels: true };
  const stored = (remembered("stage") ?? {}) as Record<string, unknown>;
  for (const key of keys()) if (typeof stored[key] === "boolean") options[key] = stored[key];
  return options;
}

/** A button for each option and one that resets the view. */
export class StageTools {
  private readonly buttons = new Map<keyof StageOptions, HTMLButtonElement>();
  private changed = (): void => {};

  constructor(
    private readonly parent: HTMLElement,
    readonly options: StageOptions,
  ) {}

  /** Shows the buttons: there is a stage. */
  connect(changed: () => void, reset: () => void): void {
    this.changed = changed;
    for (const key of keys()) {
      const button = pressButton(NAMES[key], `tool-${key}`, () => this.toggle(key));
      this.buttons.set(key, button);
      this.parent.append(button);
      this.show(key);
    }
    const button = pressButton("Reset", "tool-reset", reset);
    button.setAttribute("aria-label", "Reset the view");
    this.parent.append(button);
  }

  toggle(key: keyof StageOptions): void {
    this.options[key] = !this.options[key];
    this.show(key);
    remember("stage", this.options);
    this.changed();
  }

  private show(key: keyof StageOptions): void {
    this.buttons.get(key)?.setAttribute("aria-pressed", String(this.options[key]));
  }
}

function keys(): (keyof StageOptions)[] {
  return Object.keys(NAMES) as (keyof StageOptions)[];
}
