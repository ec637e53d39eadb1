// Colours that carry meaning in the 3-D view, on the pictures and in the tables; the rest is in style.css.

import type { Cause, StageName } from "./protocol.ts";

const OBJECTS = ["#5fd0b4", "#7aa7ff", "#e7b46a", "#e58bb6", "#a3d36b", "#b79af0", "#62c5e6", "#f0926e"];

/** The n-th object's colour. */
export function objectColour(index: number): string {
  return OBJECTS[index % OBJECTS.length] ?? "#ffffff";
}

export const STAGE = {
  background: "#0c0f13",
  floor: "#171c23",
  gridMinor: "#232b36",
  gridMajor: "#3a4657",
  frustum: "#8b98aa",
  frustumOffline: "#46505d",
  axes: ["#e2675f", "#73c66c", "#5b93f0"],
} as const;

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
