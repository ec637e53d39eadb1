// The switches on the stage: what it shows, remembered for the next visit.

import type { StageOptions } from "../stage/stage.ts";
import { MAGNIFICATION } from "../stage/ellipsoid.ts";
import { element, testId } from "./dom.ts";

const NAMES: Record<keyof StageOptions, string> = {
  trails: "Trails",
  pictures: "Pictures",
  sigma: `σ ×${MAGNIFICATION}`,
  labels: "Names",
};

const STORED = "sextant.stage";

/** The options of the last visit. */
export function rememberedOptions(): StageOptions {
  const options: StageOptions = { trails: true, pictures: true, sigma: false, labels: true };
  try {
    const stored = JSON.parse(localStorage.getItem(STORED) ?? "{}") as Record<string, unknown>;
    for (const key of keys()) if (typeof stored[key] === "boolean") options[key] = stored[key];
  } catch {
    // Storage is switched off or holds something else: the defaults do.
  }
  return options;
}

/** Fills `parent` with a button for each option and one that resets the view. */
export function createTools(parent: HTMLElement, options: StageOptions, changed: () => void, reset: () => void): void {
  for (const key of keys()) {
    const button = toolButton(NAMES[key], `tool-${key}`);
    const show = (): void => button.setAttribute("aria-pressed", String(options[key]));
    button.addEventListener("click", () => {
      options[key] = !options[key];
      show();
      remember(options);
      changed();
    });
    show();
    parent.append(button);
  }
  const button = toolButton("Reset", "tool-reset");
  button.setAttribute("aria-label", "Reset the view");
  button.addEventListener("click", reset);
  parent.append(button);
}

function keys(): (keyof StageOptions)[] {
  return Object.keys(NAMES) as (keyof StageOptions)[];
}

function remember(options: StageOptions): void {
  try {
    localStorage.setItem(STORED, JSON.stringify(options));
  } catch {
    // Not remembered, then.
  }
}

function toolButton(text: string, id: string): HTMLButtonElement {
  const button = testId(element("button", "", text), id);
  button.type = "button";
  return button;
}
