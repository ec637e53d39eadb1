// What a value from outside must look like: small tests that combine, each with the type of what passes. Knows no
// message.

export type Test<T> = (value: unknown) => value is T;
/** The type of what passes a test. */
export type Checked<C> = C extends Test<infer T> ? T : never;
type Tests = Record<string, Test<unknown>>;
type All<R extends Tests> = { [K in keyof R]: Checked<R[K]> };
type Flat<T> = { [K in keyof T]: T[K] };
type Recorded<R extends Tests, O extends Tests> = Flat<All<R> & Partial<All<O>>>;

export const isNumber: Test<number> = (value): value is number => typeof value === "number" && Number.isFinite(value);
export const isText: Test<string> = (value) => typeof value === "string";
export const isFlag: Test<boolean> = (value) => typeof value === "boolean";
export const isObject: Test<Record<string, unknown>> = (value): value is Record<string, unknown> => typeof value === "object" && value !== null;
export const listOf =
  <T>(item: Test<T>): Test<T[]> =>
  (value) => Array.isArray(value) && value.every(item);
export const orNull =
  <T>(test: Test<T>): Test<T | null> =>
  (value) => value === null || test(value);
export const anyOf =
  <T extends Test<unknown>[]>(...tests: T): Test<Checked<T[number]>> =>
  (value): value is Checked<T[number]> => tests.some((test) => test(value));
export const tuple =
  <T extends Test<unknown>[]>(...items: T): Test<{ [K in keyof T]: Checked<T[K]> }> =>
  (value): value is { [K in keyof T]: Checked<T[K]> } =>
    Array.isArray(value) && value.length === items.length && items.every((item, index) => item(value[index]));

/** Short arrays have their length in their type. */
type Short<T> = { 2: [T, T]; 3: [T, T, T]; 4: [T, T, T, T] };
type ArrayOf<T, N> = N extends keyof Short<T> ? Short<T>[N] : T[];
export const arrayOf =
  <T, const N extends number>(item: Test<T>, length: N): Test<ArrayOf<T, N>> =>
  (value): value is ArrayOf<T, N> => Array.isArray(value) && value.length === length && value.every(item);

/** One of some words, which can be listed. */
export function oneOf<const W extends string>(...words: W[]): Test<W> & { words: readonly W[] } {
  return Object.assign((value: unknown): value is W => words.some((word) => word === value), { words });
}

/** An object whose fields pass; some may be missing, and further fields are no fault. */
export function record<R extends Tests, O extends Tests = Record<never, never>>(fields: R, mayBeMissing?: O): Test<Recorded<R, O>> {
  return (value): value is Recorded<R, O> =>
    isObject(value) &&
    Object.entries(fields).every(([name, test]) => test(value[name])) &&
    Object.entries(mayBeMissing ?? {}).every(([name, test]) => value[name] === undefined || test(value[name]));
}

type Variant<V> = { [K in keyof V]: V[K] extends Test<infer T> ? Record<K, T> : K }[keyof V];
/** The name of a variant, or an object with what it holds under its name. One that a newer bridge knows passes. */
export function variants<V extends Record<string, Test<unknown> | null>>(known: V): Test<Variant<V>> {
  return (value): value is Variant<V> => {
    if (isText(value)) return !known[value];
    const [entry, ...others] = isObject(value) ? Object.entries(value) : [];
    if (!entry || others.length > 0) return false;
    const [name, content] = entry;
    const test = Object.hasOwn(known, name) ? known[name] : isObject;
    return test ? test(content) : false;
  };
}
