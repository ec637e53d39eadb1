// What a value from outside must look like: small tests that combine. Knows no message.

export type Test = (value: unknown) => boolean;
export type Shape = Record<string, Test>;

export const isNumber: Test = (value) => typeof value === "number" && Number.isFinite(value);
export const isText: Test = (value) => typeof value === "string";
export const isFlag: Test = (value) => typeof value === "boolean";
export const listOf = (item: Test): Test => (value) => Array.isArray(value) && value.every(item);
export const numbers = (count: number): Test => (value) =>
  Array.isArray(value) && value.length === count && value.every(isNumber);
export const shaped = (shape: Shape): Test => (value) => fits(value, shape);
export const orNull = (test: Test): Test => (value) => value === null || test(value);
export const optional = (test: Test): Test => (value) => value === undefined || test(value);

/** Whether a value is an object whose fields pass; further fields are no fault. */
export function fits(value: unknown, shape: Shape): boolean {
  if (typeof value !== "object" || value === null) return false;
  const fields = value as Record<string, unknown>;
  return Object.entries(shape).every(([name, test]) => test(fields[name]));
}
