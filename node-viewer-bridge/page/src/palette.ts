// Colours that carry meaning in the 3-D view, on the pictures and in the tables; the rest is in style.css.

import type { Cause, StageName } from "./protocol.ts";

const OBJECTS = ["#5fd0b4", "#7aa7ff", "#e7b46a", "#e58bb6", "#a3d36b", "#b79af0", "#62c5e6", "#f0926e"];

const CAMERAS = ["#e58bb6", "#62c5e6", "#a3d36b", "#b79af0", "#f0926e", "#5fd0b4", "#e7b46a", "#7aa7ff"];

/** The n-th object's colour. */
export function objectColour(index: number): string {
  return OBJECTS[index % OBJECTS.length] ?? "#ffffff";
}

/** The n-th camera's colour in charts. */
export function cameraColour(index: number): string {
  return CAMERAS[Math.max(0, index) % CAMERAS.length] ?? "#8899aa";
}

interface StageColours {
  background: string;
  floor: string;
  gridMinor: string;
  gridMajor: string;
  frustum: string;
  frustumOffline: string;
  zone: string;
  ruler: string;
  axes: readonly [string, string, string];
}

const DARK: StageColours = {
  background: "#0c0f13",
  floor: "#171c23",
  gridMinor: "#232b36",
  gridMajor: "#3a4657",
  frustum: "#8b98aa",
  frustumOffline: "#46505d",
  zone: "#e0b15a",
  ruler: "#e8ecf1",
  axes: ["#e2675f", "#58b368", "#5b93f0"],
};

const LIGHT: StageColours = {
  background: "#f4f6f8",
  floor: "#e4e9ee",
  gridMinor: "#d5dce4",
  gridMajor: "#b3bfcc",
  frustum: "#5a6878",
  frustumOffline: "#a9b4c0",
  zone: "#9a6a10",
  ruler: "#14181d",
  axes: DARK.axes,
};

/** The stage's colours, those of the theme. */
export const STAGE: StageColours = { ...DARK };

export function useStageColours(theme: "light" | "dark"): void {
  Object.assign(STAGE, theme === "light" ? LIGHT : DARK);
}

/** What the detector turned down: the further a candidate came, the warmer. */
export const CAUSE: Record<Cause, string> = {
  not_a_quad: "#66707e",
  shape: "#8f9bab",
  faint_border: "#7aa7ff",
  no_code: "#eab55b",
  small_margin: "#f27d72",
};

/** The detector's stages, first to last. */
export const STAGE_TIME: Record<StageName, string> = {
  tiles: "#4a5666",
  threshold: "#5f7390",
  components: "#6f93bd",
  quads: "#62b3c4",
  decode: "#5fd0b4",
  refine: "#a3d36b",
};

/** A tag that belongs to no object. */
export const STRANGER = "#9aa5b4";
