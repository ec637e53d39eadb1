// A person's requests on their way to the bridge, and what a form's texts mean. Touches no element of the page.

/** A complaint, and the field that it is about. */
export interface Complaint {
  field: string | null;
  cause: string;
}

/** Something entered that cannot be right. */
export class Wrong extends Error {
  constructor(
    readonly field: string,
    cause: string,
  ) {
    super(cause);
  }
}

/** No family in use has more tags. */
const LONGEST_RUN = 600;

export interface TagRequest {
  id: number;
  size_m: number;
}

/** Millimetres as people write them, in metres. */
export function readSize(text: string, field = "size_m"): number {
  const millimetres = Number(text.trim().replace(",", "."));
  if (text.trim() === "" || !Number.isFinite(millimetres)) throw new Wrong(field, "Write the edge of a black square in millimetres, such as 40");
  if (millimetres < 1 || millimetres > 100_000) throw new Wrong(field, "The edge of a black square is 1 mm to 100 m long");
  return Number((millimetres / 1000).toPrecision(12));
}

export function readWhole(text: string, field: string, what: string, [least, most]: [number, number]): number {
  const value = Number(text.trim());
  if (text.trim() === "" || !Number.isInteger(value) || value < least || value > most)
    throw new Wrong(field, `${what} is a whole number from ${least} to ${most}`);
  return value;
}

/**
 * Tags as people list them: "3, 4, 5" or "3 4 5:50", a size of its own in millimetres behind a colon; "3-8" is a run.
 */
export function readTags(text: string, size_m: number): TagRequest[] {
  const tags = text
    .split(/[\s,;]+/)
    .filter((word) => word !== "")
    .flatMap((word) => readTag(word, size_m));
  if (tags.length === 0) throw new Wrong("tags", "Name the object's tags, such as 3, 4, 5, or choose those that are seen");
  const twice = tags.find((tag, at) => tags.findIndex((other) => other.id === tag.id) < at);
  if (twice) throw new Wrong("tags", `Tag ${twice.id} is named twice`);
  return tags;
}

/** The words of such a list, runs written out: what can be added to and taken from. */
export function wordsOf(text: string): string[] {
  const words = text.split(/[\s,;]+/).filter((word) => word !== "");
  return words.flatMap((word) => {
    const run = /^(\d{1,6})-(\d{1,6})(:.*)?$/.exec(word);
    const [first, last] = [Number(run?.[1]), Number(run?.[2])];
    if (!run || last < first || last - first > LONGEST_RUN) return [word];
    return Array.from({ length: last - first + 1 }, (_, at) => `${first + at}${run[3] ?? ""}`);
  });
}

/** The tag that a word names. */
export const tagOf = (word: string): string => word.split(":")[0] ?? word;

function readTag(word: string, size_m: number): TagRequest[] {
  const match = /^(\d{1,6})(?:-(\d{1,6}))?(?::([\d.]+))?$/.exec(word);
  if (!match) throw new Wrong("tags", `“${word}” is no tag: write numbers such as 3, 4, 5, or 3:50 for one of 50 mm`);
  const [first, last] = [Number(match[1]), Number(match[2] ?? match[1])];
  const size = match[3] === undefined ? size_m : readSize(match[3], "tags");
  if (last < first || last - first > LONGEST_RUN) throw new Wrong("tags", `“${word}” is no run of tags`);
  return Array.from({ length: last - first + 1 }, (_, at) => ({ id: first + at, size_m: size }));
}

export function readName(text: string, field: string): string {
  const name = text.trim();
  if (!/^[a-z0-9_-]{1,32}$/.test(name))
    throw new Wrong(field, "A name has 1 to 32 small letters, digits, - and _");
  return name;
}

type Path = "api/wizard" | "api/zones" | "api/phones" | "api/models";

/** Sends a request; a complaint where the bridge does not obey, nothing where it does. */
export async function send(path: Path, request: object, ask: typeof fetch = fetch): Promise<Complaint | null> {
  const answer = await post(path, request, ask);
  return "cause" in answer ? answer : null;
}

/** What became of a request, a sentence each. */
export interface Said {
  said: string[];
}

/** Sends a request; what the bridge answers, or its complaint. */
export async function post(path: Path, request: object, ask: typeof fetch = fetch): Promise<Said | Complaint> {
  let answer: Response;
  try {
    const headers = { "content-type": "application/json" };
    answer = await ask(path, { method: "POST", headers, body: JSON.stringify(request) });
  } catch {
    return { field: null, cause: "The bridge does not answer." };
  }
  const content = (await answer.json().catch(() => null)) as Partial<Complaint & Said> | null;
  if (answer.ok) return { said: content?.said ?? [] };
  return { field: content?.field ?? null, cause: content?.cause ?? `The bridge answered ${answer.status}.` };
}

/** A text as a sentence: with a capital at its beginning and a stop at its end. */
export function sentence(text: string): string {
  const whole = text.trim();
  const begun = whole.charAt(0).toUpperCase() + whole.slice(1);
  return /[.!?…]$/.test(begun) ? begun : `${begun}.`;
}
