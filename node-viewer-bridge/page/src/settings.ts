// Exposure, gain and rate of a camera: what a person writes, what a status says of it. Touches no element of the page.

import type { CameraControls, CameraStatus, Control } from "./protocol.ts";
import { fixed } from "./format.ts";
import { Wrong } from "./wizard/command.ts";

export const KEYS = ["exposure_us", "gain", "rate_hz"] as const;
export type Key = (typeof KEYS)[number];
export type Wanted = Record<Key, number | null>;

interface Setting {
  name: string;
  unit: string;
  /** Of the unit in that of the key. */
  scale: number;
  range: [number, number];
}

export const SETTINGS: Record<Key, Setting> = {
  exposure_us: { name: "Exposure", unit: "ms", scale: 1000, range: [0.001, 1000] },
  gain: { name: "Gain", unit: "", scale: 1, range: [0, 1_000_000] },
  rate_hz: { name: "Rate", unit: "images/s", scale: 1, range: [0.1, 1000] },
};

/** A value as it is written; empty where there is none. */
export function written(key: Key, value: number | null): string {
  return value === null ? "" : String(Number((value / SETTINGS[key].scale).toPrecision(6)));
}

const short = (key: Key, value: number): string => String(Number((value / SETTINGS[key].scale).toPrecision(3)));

/** What a person wrote; an empty text leaves the value to the camera's own file. */
export function readSetting(key: Key, text: string): number | null {
  const { name, unit, scale, range } = SETTINGS[key];
  if (text.trim() === "") return null;
  const value = Number(text.trim().replace(",", "."));
  const [least, most] = range;
  if (!Number.isFinite(value) || value < least || value > most)
    throw new Wrong(key, `${name} is a number from ${least} to ${most}${unit && ` ${unit}`}; leave it empty for the camera's own`);
  return Number((value * scale).toPrecision(12));
}

/** What is in force, and what is possible, in the unit of the label. */
export function inForce(key: Key, control: Control): string {
  const value = control.value === null ? "chosen by the camera" : `now ${short(key, control.value)}`;
  if (control.range === null) return value;
  const [least, most] = control.range;
  return least === most ? value : `${value}, ${short(key, least)} to ${short(key, most)}`;
}

export const wantedBy = (controls: CameraControls): Wanted => ({
  exposure_us: controls.exposure_us.wanted,
  gain: controls.gain.wanted,
  rate_hz: controls.rate_hz.wanted,
});

/** Whether a camera has taken what was sent, or said why not. */
export function isAnswered(controls: CameraControls, sent: Wanted): boolean {
  return controls.outcome !== "pending" && KEYS.every((key) => controls[key].wanted === sent[key]);
}

export interface Story {
  text: string;
  isComplaint: boolean;
}

/** What became of the site's settings. */
export function story({ outcome }: Pick<CameraControls, "outcome">): Story {
  if (outcome === "none") return { text: "All as the camera's own file has it.", isComplaint: false };
  if (outcome === "pending") return { text: "Waiting for the camera…", isComplaint: false };
  if (outcome === "applied") return { text: "The site's settings are applied.", isComplaint: false };
  if ("adjusted" in outcome) return { text: `The site's settings are applied as far as the camera can: ${outcome.adjusted.detail}.`, isComplaint: true };
  if ("refused" in outcome) return { text: `The camera keeps what it had: ${outcome.refused.detail}.`, isComplaint: true };
  return { text: "This page does not know what became of the site's settings: load it again.", isComplaint: true };
}

/** The effect on images. */
export const effect = ({ brightness, rate_hz }: CameraStatus): string =>
  `Mean grey level ${fixed(brightness, 0)} of 255, ${fixed(rate_hz, 1)} images/s`;
