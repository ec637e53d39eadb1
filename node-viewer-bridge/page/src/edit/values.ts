// What the editor shows of poses and sizes, and what a person wrote there. What nobody has touched stays exactly as it
// is. Touches no element of the page.

import { quaternionOf, rollPitchYaw } from "../attitude.ts";
import type { Quaternion, Vec3 } from "../protocol.ts";
import { Wrong } from "../wizard/command.ts";

/** How orientations are written. */
export type Convention = "angles" | "quaternion";

export const PARTS: Record<Convention, readonly string[]> = {
  angles: ["roll", "pitch", "yaw"],
  quaternion: ["x", "y", "z", "w"],
};

/** Degrees, metres and millimetres are shown to this many decimals: finer than anybody can place a camera or a tag. */
const DECIMALS = 4;
const QUATERNION_DECIMALS = 8;
/** A quaternion whose length differs from 1 by more is a slip of the pen. */
const LENGTH_TOLERANCE = 0.01;

const written = (value: number, decimals: number): string => String(Number(value.toFixed(decimals)) || 0);

/** A length of `value` metres in another unit; `scale` is that of the unit, m. */
export const writtenLength = (value: number, scale: number): string =>
  written(value / scale, scale === 1 ? DECIMALS + 2 : DECIMALS);

export const writtenAngle = (degrees: number): string => written(degrees, DECIMALS);

export const writtenPosition = (position: Vec3, scale: number): string[] =>
  position.map((value) => writtenLength(value, scale));

export function writtenOrientation(orientation: Quaternion, convention: Convention): string[] {
  if (convention === "quaternion") return orientation.map((value) => written(value, QUATERNION_DECIMALS));
  return rollPitchYaw(orientation).map(writtenAngle);
}

/** What was read, with the exact values of the boxes that nobody has touched. */
export function keepUntouched<T extends number[]>(
  read: T,
  exact: readonly number[],
  isTouched: (at: number) => boolean,
): T {
  return read.map((value, at) => (isTouched(at) ? value : (exact[at] ?? value))) as T;
}

/** A number as people write it, with a point or a comma; `null` where nothing is written. */
export function readNumber(text: string, field: string, what: string): number | null {
  const trimmed = text.trim();
  if (trimmed === "") return null;
  const value = Number(trimmed.replace(",", "."));
  if (!Number.isFinite(value)) throw new Wrong(field, `${what} is a number, not “${trimmed}”`);
  return value;
}

/** The numbers of boxes that are written in together; `null` where all are empty. */
function readTogether(texts: readonly string[], field: string, names: readonly string[]): number[] | null {
  const values = texts.map((text, at) => readNumber(text, field, names[at] ?? field));
  if (values.every((value) => value === null)) return null;
  const missing = names.filter((_, at) => values[at] === null);
  if (missing.length > 0) throw new Wrong(field, `Write ${missing.join(", ")} too, or leave all of them empty`);
  return values as number[];
}

/** Metres of three boxes in units of `scale` metres. */
export function readPosition(texts: readonly string[], scale: number): Vec3 | null {
  const values = readTogether(texts, "position", ["x", "y", "z"]);
  return values && (values.map((value) => Number((value * scale).toPrecision(12))) as Vec3);
}

/** The orientation of three angles or four parts of a quaternion; angles that nobody touched are those of `given`. */
export function readOrientation(
  texts: readonly string[],
  convention: Convention,
  given: Quaternion | null = null,
  isTouched: (at: number) => boolean = () => true,
): Quaternion | null {
  const values = readTogether(texts, "orientation", PARTS[convention]);
  if (values === null) return null;
  if (convention === "angles") {
    const exact = given ? rollPitchYaw(given) : [];
    return quaternionOf(keepUntouched(values as Vec3, exact, isTouched));
  }
  const length = Math.hypot(...values);
  if (Math.abs(length - 1) > LENGTH_TOLERANCE)
    throw new Wrong("orientation", `The quaternion's length is ${written(length, 4)}; it has to be 1`);
  return values.map((value) => value / length) as Quaternion;
}

/** A standard deviation in units of `scale`; `null` where none is given. */
export function readSigma(text: string, field: string, scale: number): number | null {
  const value = readNumber(text, field, "A standard deviation");
  if (value === null) return null;
  if (value < 0) throw new Wrong(field, "A standard deviation is not negative; 0 says that the value is exact");
  return Number((value * scale).toPrecision(12));
}
