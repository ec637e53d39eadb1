// The objects' table: where each is, how sure, how fast, and how wrong where the truth is known.

import { rollPitchYaw } from "../attitude.ts";
import { sigma } from "../covariance.ts";
import { fixed, magnitude, NONE } from "../format.ts";
import type { JointValue } from "../protocol.ts";
import type { Selection } from "../selection.ts";
import type { ObjectState, Site } from "../site.ts";
import { Condition, element, pressButton, testId, Text } from "./dom.ts";

interface Column {
  key: string;
  title: string;
  unit: string;
  about: string;
  parts: string[];
}

const COLUMNS: Column[] = [
  { key: "position", title: "Position", unit: "mm", about: "Origin of the object in the world", parts: ["x", "y", "z"] },
  {
    key: "attitude",
    title: "Attitude",
    unit: "°",
    about: "Roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll)",
    parts: ["roll", "pitch", "yaw"],
  },
  { key: "sigma", title: "Sigma", unit: "", about: "Standard deviation of position and attitude", parts: ["mm", "°"] },
  {
    key: "error",
    title: "True error",
    unit: "",
    about: "Distance from the simulator's truth, root mean square of the last poses while tracking",
    parts: ["mm", "°"],
  },
  { key: "rate", title: "Rate", unit: "", about: "Poses a second", parts: ["Hz"] },
  { key: "latency", title: "Latency", unit: "", about: "From the middle of the exposure to the pose", parts: ["ms"] },
];

const TRUTH_KEPT_S = 3;

export class ObjectsPanel {
  private readonly rows = new Map<string, ObjectRow>();
  private readonly body = element("tbody");
  private readonly table = element("table", "", head(), this.body);
  private readonly empty = element("p", "empty", "No object yet. Objects appear here as the fusion node names them.");

  constructor(
    root: HTMLElement,
    private readonly site: Site,
    private readonly selection: Selection,
    private readonly edit: (object: string | null) => void,
  ) {
    selection.changed(() => this.mark());
    const add = pressButton("Add an object", "object-add", () => edit(null));
    add.classList.add("edit");
    root.append(this.empty, this.table, add);
    this.table.hidden = true;
  }

  update(now: number): void {
    for (const [id, row] of this.rows) if (!this.site.objects.has(id)) this.drop(id, row);
    let truth = false;
    for (const object of this.site.objects.values()) {
      this.row(object).update(now);
      truth ||= now - object.truthAt < TRUTH_KEPT_S;
    }
    this.table.classList.toggle("with-truth", truth);
    this.table.hidden = this.rows.size === 0;
    this.empty.hidden = this.rows.size > 0;
  }

  private drop(id: string, row: ObjectRow): void {
    row.root.remove();
    this.rows.delete(id);
  }

  private row(object: ObjectState): ObjectRow {
    const known = this.rows.get(object.id);
    if (known) return known;
    const row = new ObjectRow(object, this.selection, this.edit);
    this.rows.set(object.id, row);
    const next = [...this.rows.values()].sort((a, b) => order(a.object, b.object)).find((other) => order(other.object, object) > 0);
    this.body.insertBefore(row.root, next?.root ?? null);
    return row;
  }

  private mark(): void {
    for (const [id, row] of this.rows) row.root.dataset["selected"] = String(id === this.selection.object);
  }
}

/** Objects by name, each followed by its links. */
export function byGroup(a: string, b: string): number {
  const [[objectA = "", linkA = ""], [objectB = "", linkB = ""]] = [a.split("."), b.split(".")];
  if (objectA !== objectB) return objectA < objectB ? -1 : 1;
  return linkA === linkB ? 0 : linkA < linkB ? -1 : 1;
}

/** Landmarks come last: they stay where they are. */
const order = (a: ObjectState, b: ObjectState): number => Number(a.place !== null) - Number(b.place !== null) || byGroup(a.id, b.id);

/** Joints as people read them; how far each slides or turns is not said apart, so both are given as they come. */
function jointsText(joints: JointValue[]): string {
  return joints.map(({ joint, value, sigma }) => `${joint} ${fixed(value, 3)} ± ${magnitude(sigma)}`).join("   ");
}

class ObjectRow {
  readonly root: HTMLTableRowElement;
  private readonly edit: HTMLButtonElement;
  private readonly condition: Condition;
  private readonly cells = new Map<string, Text[]>();

  private readonly joints = new Text(element("span", "joints"));

  constructor(
    readonly object: ObjectState,
    selection: Selection,
    edit: (object: string) => void,
  ) {
    const { id, colour } = object;
    const swatch = element("span", "swatch");
    swatch.style.background = colour;
    const [, link] = id.split(".");
    const button = pressButton(link ?? id, `object-${id}-follow`, () => selection.follow(selection.object === id ? null : id));
    button.title = "Follow on the stage";
    this.edit = pressButton("Edit", `object-${id}-edit`, () => edit(id));
    this.edit.classList.add("edit");
    this.edit.setAttribute("aria-label", `Edit ${id}`);
    this.edit.title = "Name and tags of this object";
    const kind = link === undefined ? "name" : "name link";
    const name = element("th", kind, swatch, button, this.edit, this.joints.element);
    name.scope = "row";
    this.condition = new Condition(testId(element("span", "condition"), `object-${id}-state`));
    const cells = COLUMNS.map((column) => this.cell(column));
    this.root = testId(element("tr", "", name, element("td", "state", this.condition.element), ...cells), `object-row-${id}`);
  }

  update(now: number): void {
    const { object } = this;
    const condition = object.condition(now);
    this.condition.set(condition);
    this.edit.hidden = object.version === "";
    if (this.root.dataset["condition"] !== condition) this.root.dataset["condition"] = condition;
    this.updatePose();
    this.joints.set(jointsText(object.joints));
    const live = condition !== "silent" && condition !== "unseen" && condition !== "landmark";
    const truth = live && now - object.truthAt < TRUTH_KEPT_S;
    this.set("error", truth ? [object.errorMm, object.errorDeg].map((error) => magnitude(error.rootMeanSquare())) : []);
    this.set("rate", live ? [fixed(object.rate.rate(now), 0)] : []);
    this.set("latency", live ? [magnitude(object.latency.median())] : []);
  }

  private updatePose(): void {
    const { shown: pose, place } = this.object;
    const drawn = pose ?? place;
    if (!drawn) return;
    this.set("position", drawn.position.map((metres) => fixed(metres * 1000, 1)));
    this.set("attitude", rollPitchYaw(drawn.orientation).map((degrees) => fixed(degrees, 1)));
    if (!pose) return;
    const { position_mm, attitude_deg } = sigma(pose.covariance);
    this.set("sigma", [magnitude(position_mm), magnitude(attitude_deg)]);
  }

  private set(key: string, values: string[]): void {
    this.cells.get(key)?.forEach((text, part) => text.set(values[part] ?? NONE));
  }

  private cell(column: Column): HTMLTableCellElement {
    const numbers = column.parts.map((part) => testId(element("span", "number", NONE), `object-${this.object.id}-${slug(column, part)}`));
    this.cells.set(column.key, numbers.map((number) => new Text(number)));
    const labelled = numbers.map((number, part) => element("span", "part", element("i", "", column.parts[part] ?? ""), number));
    const cell = element("td", column.key, ...labelled);
    cell.dataset["label"] = column.unit ? `${column.title} ${column.unit}` : column.title;
    return cell;
  }
}

/** Names for tests: x, roll, sigma-mm, error-deg, rate, latency. */
function slug(column: Column, part: string): string {
  if (column.parts.length === 3) return part;
  if (column.parts.length === 1) return column.key;
  return `${column.key}-${part === "°" ? "deg" : part}`;
}

function head(): HTMLTableSectionElement {
  const cells = COLUMNS.map((column) => {
    const unit = column.unit ? [element("span", "unit", ` ${column.unit}`)] : [];
    const parts = element("span", "parts", ...column.parts.map((part) => element("span", "number", part)));
    const cell = element("th", column.key, element("span", "title", column.title, ...unit), parts);
    cell.title = column.about;
    cell.scope = "col";
    return cell;
  });
  const [name, state] = ["Object", "State"].map((title) => element("th", "", element("span", "title", title)));
  return element("thead", "", element("tr", "", name ?? "", state ?? "", ...cells));
}
