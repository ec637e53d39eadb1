// The measuring tool: how far two objects are apart and how they are turned to one another, live.

import { fixed, magnitude, NONE } from "../format.ts";
import { relative } from "../relative.ts";
import type { Selection } from "../selection.ts";
import type { Site } from "../site.ts";
import { Choice, element, pressButton, testId, Text } from "./dom.ts";

const ROWS = ["Distance", "Position", "Attitude", "Angle"] as const;

export class DistancesPanel {
  private readonly from: Choice;
  private readonly to: Choice;
  private readonly button: HTMLButtonElement;
  private readonly values = new Map<string, Text>();

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
    private readonly selection: Selection,
  ) {
    const choose = (): void => {
      if (selection.pair) this.measure();
    };
    this.from = new Choice("From", "measure-from", choose);
    this.to = new Choice("To", "measure-to", choose);
    this.button = pressButton("Measure", "measure-toggle", () => (selection.pair ? selection.measure(null) : this.measure()));
    const swap = pressButton("Swap", "measure-swap", () => {
      const from = this.from.value;
      this.from.choose(this.to.value);
      this.to.choose(from);
      choose();
    });
    const list = element("dl", "measures");
    for (const row of ROWS) {
      const value = testId(element("dd", "", NONE), `measure-${row.toLowerCase()}`);
      this.values.set(row, new Text(value));
      list.append(element("div", "", element("dt", "", row), value));
    }
    const about = element("p", "note", "Position and attitude are those of the second object in the frame of the first. The two poses' errors are taken as independent.");
    root.append(element("div", "toolbar", this.from.root, this.to.root, swap, this.button), list, about);
    selection.changed(() => this.show());
    this.show();
  }

  update(): void {
    if (this.root.hidden) return;
    const ids = [...this.site.objects.keys()].sort();
    this.from.offer(ids);
    this.to.offer(ids);
    if (this.from.value === this.to.value && ids.length > 1 && !this.selection.pair) this.to.choose(ids.find((id) => id !== this.from.value) ?? "");
    this.showValues();
  }

  private measure(): void {
    const [from, to] = [this.from.value, this.to.value];
    this.selection.measure(from !== "" && to !== "" && from !== to ? [from, to] : null);
  }

  private show(): void {
    const { pair } = this.selection;
    this.button.setAttribute("aria-pressed", String(pair !== null));
    if (pair) {
      this.from.choose(pair[0]);
      this.to.choose(pair[1]);
    }
    this.showValues();
  }

  private showValues(): void {
    const pair = this.selection.pair ?? [this.from.value, this.to.value];
    const [a, b] = pair.map((id) => this.site.objects.get(id)?.shown);
    if (!a || !b || a === b) return this.values.forEach((value) => value.set(NONE));
    const found = relative(a, b);
    const list = (values: number[], digits: number): string => values.map((value) => fixed(value, digits)).join("  ");
    this.set("Distance", `${fixed(found.distance_m * 1000, 1)} ± ${magnitude(found.distance_sigma_m * 1000)} mm`);
    this.set("Position", `${list(found.position.map((value) => value * 1000), 1)} mm`);
    this.set("Attitude", `${list(found.attitude, 1)} °`);
    this.set("Angle", `${fixed(found.angle_deg, 2)} ± ${magnitude(found.angle_sigma_deg)} °`);
  }

  private set(row: (typeof ROWS)[number], text: string): void {
    this.values.get(row)?.set(text);
  }
}
