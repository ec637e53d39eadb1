// What each wizard has to know before it begins, and the request that is made of it.

import type { WizardKind } from "../protocol.ts";
import type { Site } from "../site.ts";
import { element, testId } from "../panels/dom.ts";
import { readName, readSize, readTags, readWhole, tagOf, type Complaint, wordsOf, Wrong } from "./command.ts";
import { Field, Segments, button, choice, fileBox, offer, textBox } from "./fields.ts";

const FAMILY = "tag36h11";

/** A form: what it shows, what it knows of the site, and the request. */
export interface Form {
  root: HTMLElement;
  /** The site may have changed. */
  refresh(): void;
  /** Fills in what is known of this camera or object. */
  about(subject: string): void;
  /** @throws Wrong where something entered cannot be right. */
  request(): Promise<object>;
  fields: Field[];
}

export function complainAt(form: Form, complaint: Complaint): boolean {
  const field = form.fields.find(({ name, root }) => name === complaint.field && !root.hidden);
  field?.complain(complaint.cause);
  field?.control.focus();
  return field !== undefined;
}

export function createForms(site: Site): Record<WizardKind, Form> {
  return { lens: lensForm(site), rig: rigForm(site), learn: learnForm(site) };
}

async function textOf(field: Field, what: string): Promise<string> {
  const file = (field.control as HTMLInputElement).files?.[0];
  if (!file) throw new Wrong(field.name, `Choose the ${what}`);
  return file.text();
}

function lensForm(site: Site): Form {
  const camera = new Field("camera", "Camera", choice([]));
  const columns = new Field("columns", "Columns", textBox("5", "numeric"));
  const rows = new Field("rows", "Rows", textBox("6", "numeric"));
  const size = new Field("size_m", "Black square", textBox("28", "decimal"), { unit: "mm" });
  const first = new Field("first", "First tag", textBox("0", "numeric"));
  const board = new Field("board", "Board file", fileBox(), { hint: "The TOML file that sextant print board wrote." });
  const models: [string, string][] = [["", "the images choose"], ...["pinhole", "brown-conrady", "kannala-brandt"].map((m): [string, string] => [m, m])];
  const model = new Field("model", "Lens model", choice(models));
  const grid = element("div", "quarters", columns.root, rows.root, size.root, first.root);
  const source = new Segments<"grid" | "board">("The board", { grid: "As printed", board: "From its file" }, "grid", (value) => {
    grid.hidden = value !== "grid";
    board.root.hidden = value !== "board";
  });
  board.root.hidden = true;
  const fields = [camera, columns, rows, size, first, board, model];
  return {
    fields,
    root: element("div", "fields", camera.root, source.root, grid, board.root, model.root),
    refresh: () => offerNames(camera, [...site.cameras.keys()]),
    about: (subject) => (camera.control.value = subject),
    request: async () => {
      const begin = { do: "start", wizard: "lens", camera: camera.text, model: model.text || null };
      if (source.value === "board") return { ...begin, board: { file: await textOf(board, "board's file") } };
      return {
        ...begin,
        board: {
          grid: {
            columns: readWhole(columns.text, "columns", "The number of columns", [1, 100]),
            rows: readWhole(rows.text, "rows", "The number of rows", [1, 100]),
            size_m: readSize(size.text),
            first: readWhole(first.text, "first", "The first tag", [0, 99_999]),
          },
        },
      };
    },
  };
}

function rigForm(site: Site): Form {
  const object = new Field("object", "What is carried", choice([]), {
    hint: "Any object with known or unknown tags; a cube or a board does well.",
  });
  const file = new Field("file", "Object file", fileBox());
  const origin = new Field("origin", "The world", choice([]));
  const tag = new Field("tags", "Tag on the floor", textBox("0", "numeric"));
  const size = new Field("size_m", "Black square", textBox("100", "decimal"), { unit: "mm" });
  const floor = element("div", "quarters", tag.root, size.root);
  const show = (): void => {
    file.root.hidden = object.text !== "";
    floor.hidden = origin.text !== "tag";
  };
  object.control.addEventListener("change", show);
  origin.control.addEventListener("change", show);
  const fields = [object, file, origin, tag, size];
  return {
    fields,
    root: element("div", "fields", object.root, file.root, origin.root, floor),
    refresh: () => {
      const names = [...site.objects.keys()].filter((id) => !id.includes(".")).sort();
      offer(object.control as HTMLSelectElement, [...names.map((id): [string, string] => [id, id]), ["", "from a file…"]]);
      const cameras = [...site.cameras.keys()].sort().map((id): [string, string] => [`camera ${id}`, `is camera ${id}`]);
      offer(origin.control as HTMLSelectElement, [["as_it_is", "stays as it is"], ["tag", "is a tag on the floor"], ...cameras]);
      show();
    },
    about: () => undefined,
    request: async () => {
      const carried = object.text === "" ? { file: await textOf(file, "object's file") } : { known: object.text };
      return { do: "start", wizard: "rig", object: carried, origin: world(origin.text, tag, size) };
    },
  };
}

function world(chosen: string, tag: Field, size: Field): unknown {
  if (chosen === "tag") return { tag: { family: FAMILY, id: readWhole(tag.text, "tags", "A tag", [0, 99_999]), size_m: readSize(size.text) } };
  return chosen.startsWith("camera ") ? { camera: chosen.slice("camera ".length) } : "as_it_is";
}

function learnForm(site: Site): Form {
  const id = new Field("id", "Name", textBox("object"));
  const size = new Field("size_m", "Black square", textBox("40", "decimal"), { unit: "mm" });
  const tags = new Field("tags", "Tags", textBox(""), { hint: "Such as 3, 4, 5 or 3-8; 3:50 for one of 50 mm." });
  const seen = testId(element("div", "seen"), "wizard-seen");
  const camera = new Field("cameras", "Seen by", choice([]));
  const origin = new Field("origin", "Its frame", choice([["", "in the middle of its tags"], ["first", "is its first tag's"]]));
  const others = new Field("others", "Its other tags", choice([["leave", "are no part of it"], ["keep", "stay where they are"]]));
  const fields = [id, size, tags, camera, origin, others];
  return {
    fields,
    root: element("div", "fields", id.root, tags.root, seen, element("div", "quarters two", size.root, camera.root), origin.root, others.root),
    refresh: () => {
      offerNames(camera, [...site.cameras.keys()], [["", "every camera"]]);
      others.root.hidden = !site.objects.has(id.text.trim());
      showSeen(seen, tags, site);
    },
    about: (subject) => {
      const known = (site.objects.get(subject)?.tags ?? []).filter(({ family }) => family === FAMILY);
      const [first] = known;
      id.control.value = subject;
      if (!first) return;
      size.control.value = String(round(first.size_m * 1000));
      const words = known.map((tag) => (tag.size_m === first.size_m ? String(tag.id) : `${tag.id}:${round(tag.size_m * 1000)}`));
      tags.control.value = words.join(", ");
    },
    request: async () => {
      const wanted = readTags(tags.text, readSize(size.text));
      return {
        do: "start",
        wizard: "learn",
        id: readName(id.text, "id"),
        family: FAMILY,
        tags: wanted,
        cameras: camera.text ? [camera.text] : [],
        origin: origin.text === "first" ? (wanted[0]?.id ?? null) : null,
        others: others.root.hidden ? "leave" : others.text,
      };
    },
  };
}

function offerNames(field: Field, names: string[], before: [string, string][] = []): void {
  offer(field.control as HTMLSelectElement, [...before, ...names.sort().map((id): [string, string] => [id, id])]);
}

/** Tags that cameras see now, each a button that adds it to the list or takes it out. */
function showSeen(root: HTMLElement, tags: Field, site: Site): void {
  const seen = site.tagsSeen(FAMILY);
  const chosen = new Set(wordsOf(tags.text).map(tagOf));
  const key = seen.map((id) => `${id}${chosen.has(String(id)) ? "+" : ""}`).join();
  if (root.dataset["shown"] === key) return;
  root.dataset["shown"] = key;
  const heading = element("span", "note", seen.length > 0 ? "Seen now" : "Show the object to a camera: its tags appear here to choose from.");
  const focused = root.contains(document.activeElement) ? (document.activeElement as HTMLElement).dataset["testid"] : undefined;
  const missing = seen.filter((id) => !chosen.has(String(id)));
  const chips = seen.map((id) => seenTag(root, tags, site, id, chosen.has(String(id))));
  root.replaceChildren(heading, ...chips, ...(missing.length > 1 ? [allSeen(root, tags, site, missing)] : []));
  if (focused) root.querySelector<HTMLElement>(`[data-testid="${focused}"]`)?.focus();
}

function allSeen(root: HTMLElement, tags: Field, site: Site, missing: number[]): HTMLButtonElement {
  const all = button("all of them", "wizard-seen-all", "chip");
  all.addEventListener("click", () => {
    tags.control.value = [...wordsOf(tags.text), ...missing].join(", ");
    tags.complain("");
    showSeen(root, tags, site);
  });
  return all;
}

function seenTag(root: HTMLElement, tags: Field, site: Site, id: number, isChosen: boolean): HTMLButtonElement {
  const chip = button(String(id), `wizard-seen-${id}`, "chip");
  chip.setAttribute("aria-pressed", String(isChosen));
  const owner = site.ownerOf(FAMILY, id);
  if (owner) chip.title = `of ${owner.id}`;
  chip.addEventListener("click", () => {
    const words = wordsOf(tags.text);
    const kept = words.filter((word) => tagOf(word) !== String(id));
    tags.control.value = (isChosen ? kept : [...words, String(id)]).join(", ");
    tags.complain("");
    showSeen(root, tags, site);
  });
  return chip;
}

/** To a hundredth, as people measure millimetres. */
const round = (value: number): number => Math.round(value * 100) / 100;
