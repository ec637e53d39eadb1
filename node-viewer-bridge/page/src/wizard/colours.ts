// Colours that carry a number: errors from calm to alarming, and how much is covered.

type Rgb = [number, number, number];

/** Teal, amber, red: the page's own good, warn and bad. */
const ERROR_STOPS: Rgb[] = [
  [72, 190, 160],
  [205, 196, 92],
  [234, 160, 80],
  [242, 104, 96],
];
const GROUPS = ["#5fd0b4", "#7aa7ff", "#e7b46a", "#e58bb6", "#a3d36b", "#b79af0", "#62c5e6", "#f0926e"];

/** Colour of an error, 0 for none to 1 for large, with an opacity. */
export function errorColour(share: number, opacity = 1): string {
  const at = Math.min(1, Math.max(0, share)) * (ERROR_STOPS.length - 1);
  const index = Math.min(ERROR_STOPS.length - 2, Math.floor(at));
  const [from, to] = [ERROR_STOPS[index] as Rgb, ERROR_STOPS[index + 1] as Rgb];
  const mixed = from.map((value, i) => Math.round(value + (at - index) * ((to[i] ?? value) - value)));
  return `rgba(${mixed.join(", ")}, ${opacity})`;
}

/** A residual of so many pixels, root mean square, is large whatever the others are. */
export const LARGE_PX = 0.6;

/** The scale as a CSS gradient, for legends. */
export const ERROR_GRADIENT = `linear-gradient(90deg, ${[0, 1 / 3, 2 / 3, 1].map((share) => errorColour(share)).join(", ")})`;

/** The colour of a group of things that are joined. */
export function groupColour(index: number): string {
  return GROUPS[index % GROUPS.length] as string;
}

/** A round number not below `value`, for the end of a scale: 0.1, 0.2, 0.5, 1, 2, ... */
export function scaleEnd(value: number): number {
  if (!(value > 0)) return 0.1;
  const decade = 10 ** Math.floor(Math.log10(value));
  const step = [1, 2, 5, 10].find((step) => step * decade >= value * 0.9999) ?? 10;
  return Number((step * decade).toPrecision(1));
}
