// What the page remembers from visit to visit. Where storage is switched off it forgets.

export function remembered(key: string): unknown {
  try {
    return JSON.parse(localStorage.getItem(`sextant.${key}`) ?? "null") as unknown;
  } catch {
    return null;
  }
}

export function remember(key: string, value: unknown): void {
  try {
    localStorage.setItem(`sextant.${key}`, JSON.stringify(value));
  } catch {
    // Not remembered, then.
  }
}
