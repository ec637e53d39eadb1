// Light or dark: as the system has it, until a person chooses.

import { remember, remembered } from "./storage.ts";

export type Theme = "light" | "dark";

const system = matchMedia("(prefers-color-scheme: light)");
const listeners: ((theme: Theme) => void)[] = [];
let chosen = remembered("theme");

export function theme(): Theme {
  if (chosen === "light" || chosen === "dark") return chosen;
  return system.matches ? "light" : "dark";
}

/** Calls the listener with each change. */
export function onTheme(listener: (theme: Theme) => void): void {
  listeners.push(listener);
}

/** The other one; that of the system is followed again where they agree. */
export function toggleTheme(): void {
  const other: Theme = theme() === "light" ? "dark" : "light";
  chosen = other === (system.matches ? "light" : "dark") ? null : other;
  remember("theme", chosen);
  apply();
}

/** A colour of the style sheet, such as `--line`. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function apply(): void {
  document.documentElement.dataset["theme"] = theme();
  document.querySelector("meta[name=theme-color]")?.setAttribute("content", colour("--background"));
  for (const listener of listeners) listener(theme());
}

system.addEventListener("change", apply);
apply();
