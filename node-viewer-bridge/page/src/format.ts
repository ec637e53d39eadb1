// Numbers as people read them in the tables: fixed decimals, true minus sign, a dash where there is none.

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
