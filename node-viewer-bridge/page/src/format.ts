// Numbers as people read them in the tables: fixed decimals, true minus sign, a dash where there is none.

import type { CameraClock, CameraStatus } from "./protocol.ts";

export const NONE = "–";

/** `digits` decimals with a real minus sign; never "−0.0". */
export function fixed(value: number | null, digits: number): string {
  if (value === null || !Number.isFinite(value)) return NONE;
  const text = Math.abs(value).toFixed(digits);
  return value < 0 && Number(text) !== 0 ? `−${text}` : text;
}

/** Small magnitudes with two significant decimals, large ones without noise: 0.42, 3.1, 27. */
export function magnitude(value: number | null): string {
  if (value === null || !Number.isFinite(value)) return NONE;
  const size = Math.abs(value);
  if (size < 1) return fixed(value, 2);
  return fixed(value, size < 10 ? 1 : 0);
}

/** A count that may grow for weeks: 950, 12.3k, 4.6M. */
export function count(value: number): string {
  if (value < 10_000) return String(Math.round(value));
  if (value < 1_000_000) return `${(value / 1000).toFixed(1)}k`;
  return `${(value / 1_000_000).toFixed(1)}M`;
}

/** "1 camera", "4 cameras". */
export function plural(value: number, noun: string): string {
  return `${value} ${noun}${value === 1 ? "" : "s"}`;
}

/** A span of time in one figure: 12 s, 3 min, 2 h, 5 d. */
export function age(seconds: number): string {
  const span = Math.max(0, seconds);
  if (span < 60) return `${Math.floor(span)} s`;
  if (span < 3600) return `${Math.floor(span / 60)} min`;
  return span < 86_400 ? `${Math.floor(span / 3600)} h` : `${Math.floor(span / 86_400)} d`;
}

/** A clock in a few characters: its offset where the images tell it, else what keeps it. */
export function clockFigure(found: CameraClock | null, stated: CameraStatus["clock"] | null): string {
  if (found) return `${signed(found.offset_s * 1e3, 1)} ms`;
  return stated ? stated.source : NONE;
}

/** All that is known about a clock. */
export function clockStory(found: CameraClock | null, stated: CameraStatus["clock"] | null): string {
  const kept = stated ? [`kept by: ${stated.source}, stated error ${magnitude(stated.error_ns / 1e6)} ms`] : [];
  const drift = found?.drift == null ? "" : `, drift ${signed(found.drift * 1e6, 0)} ppm`;
  const told = found
    ? [`its images tell: ${signed(found.offset_s * 1e3, 2)} ms off (σ ${magnitude(found.sigma_s * 1e3)} ms${drift}), taken into account`]
    : [];
  return [...kept, ...told].join("\n");
}

function signed(value: number, digits: number): string {
  const text = fixed(value, digits);
  return value > 0 && text !== NONE ? `+${text}` : text;
}
