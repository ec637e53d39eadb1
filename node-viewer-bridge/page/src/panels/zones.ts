// Zones: a list with the objects inside, a form for operators, and the last events.

import { age, fixed } from "../format.ts";
import type { SiteEvent, Vec3, Zone } from "../protocol.ts";
import type { Site } from "../site.ts";
import { type Complaint, readName, send, Wrong } from "../wizard/command.ts";
import { Field, textBox } from "../wizard/fields.ts";
import { clock } from "./chart.ts";
import { element, pressButton, testId } from "./dom.ts";

const PATH = "api/zones";

export class ZonesPanel {
  private readonly list = testId(element("ul", "zones"), "zones-list");
  private readonly events = testId(element("ol", "events"), "zones-events");
  private readonly form: ZoneForm;
  private readonly note = element("p", "note");
  private shown = "";
  private shownEvents = "";

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
  ) {
    this.form = new ZoneForm();
    const left = element("section", "", element("h3", "", "Zones"), this.list, this.note, this.form.root);
    root.append(left, element("section", "", element("h3", "", "Events"), this.events));
  }

  update(now: number): void {
    if (this.root.hidden) return;
    const key = JSON.stringify([this.site.zones, this.site.zonesKept]);
    if (key !== this.shown) {
      this.shown = key;
      this.showZones();
    }
    this.showEvents(this.site.time(now));
  }

  private showZones(): void {
    const items = this.site.zones.map((zone) => this.zone(zone));
    const none = element("li", "empty", "No zone yet. In a zone, objects that enter and leave are events.");
    this.list.replaceChildren(...(items.length > 0 ? items : [none]));
    this.note.textContent = this.site.zonesKept ? "" : "viewer.toml names no folder: zones last as long as the bridge runs.";
  }

  private zone(zone: Zone): HTMLElement {
    const remove = pressButton("Remove", "zone-remove", () => {
      remove.disabled = true;
      void send(PATH, { do: "remove", name: zone.name }).finally(() => (remove.disabled = false));
    });
    const edit = pressButton("Edit", "zone-edit", () => this.form.fill(zone));
    const inside = zone.inside.length > 0 ? zone.inside.join(", ") : "nothing";
    const item = testId(
      element("li", "", element("strong", "", zone.name), element("span", "extent", extent(zone)), element("span", "inside", `inside: ${inside}`), edit, remove),
      `zone-${zone.name}`,
    );
    item.dataset["inside"] = zone.inside.join(" ");
    return item;
  }

  private showEvents(time: number): void {
    const events = this.site.events.toReversed();
    const key = events.map((event) => `${event.sequence} ${age(time - event.t_ns / 1e9)}`).join();
    if (key === this.shownEvents) return;
    this.shownEvents = key;
    const items = events.map((event) => {
      const swatch = element("span", "swatch");
      swatch.style.background = this.site.objects.get(event.object)?.colour ?? "";
      const ago = element("span", "life", `${clock(event.t_ns / 1e9)}, ${age(time - event.t_ns / 1e9)} ago`);
      const item = element("li", "", element("span", "", swatch, element("strong", "", event.object), ` ${sentence(event)}`), ago);
      item.dataset["event"] = event.event;
      return item;
    });
    this.events.replaceChildren(...(items.length > 0 ? items : [element("li", "empty", "Nothing happened yet.")]));
  }
}

function sentence({ event, zone, cause }: SiteEvent): string {
  if (event === "fell") return cause === "tilt" ? "tipped over" : "fell down";
  return zone === undefined ? event : `${event} ${zone}`;
}

function extent(zone: Zone): string {
  const at = zone.centre.map((value) => fixed(value, 2)).join(", ");
  if (zone.shape === "sphere") return `sphere of radius ${fixed(zone.radius ?? 0, 2)} m at ${at}`;
  const turned = zone.yaw_deg ? `, turned by ${fixed(zone.yaw_deg, 0)}°` : "";
  return `box of ${(zone.size ?? []).map((value) => fixed(value, 2)).join(" × ")} m at ${at}${turned}`;
}

/** A name, a middle, and three edges for a box or one radius for a sphere. */
class ZoneForm {
  readonly root: HTMLFormElement;
  private readonly name = new Field("name", "Name", textBox(""));
  private readonly centre = new Field("centre", "Middle", textBox("0, 0, 0.2"), { unit: "m" });
  private readonly size = new Field("size", "Edges, or a radius", textBox("0.3, 0.3, 0.4"), { unit: "m" });
  private readonly yaw = new Field("yaw_deg", "Turned by", textBox("0", "decimal"), { unit: "°" });
  private readonly complaint = testId(element("p", "complaint"), "zone-complaint");

  constructor() {
    const set = pressButton("Set zone", "zone-set", () => {});
    set.type = "submit";
    this.root = testId(
      element("form", "zone-form", this.name.root, this.centre.root, this.size.root, this.yaw.root, set, this.complaint),
      "zone-form",
    );
    this.root.noValidate = true;
    this.root.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.submit();
    });
  }

  fill(zone: Zone): void {
    this.name.control.value = zone.name;
    this.centre.control.value = zone.centre.join(", ");
    this.size.control.value = zone.shape === "sphere" ? String(zone.radius) : zone.size.join(", ");
    this.yaw.control.value = String(zone.shape === "box" ? zone.yaw_deg : 0);
    this.name.control.focus();
  }

  private async submit(): Promise<void> {
    this.complaint.textContent = "";
    try {
      const complaint = await send(PATH, { do: "set", zone: this.read() });
      if (complaint) this.complain(complaint);
    } catch (error) {
      if (!(error instanceof Wrong)) throw error;
      this.complain({ field: error.field, cause: error.message });
    }
  }

  private read(): object {
    const name = readName(this.name.text, "name");
    const centre = readNumbers(this.centre.text, "centre", [3]) as Vec3;
    const extent = readNumbers(this.size.text, "size", [1, 3]);
    if (extent.length === 1) return { shape: "sphere", name, centre, radius: extent[0] };
    const [yaw_deg] = readNumbers(this.yaw.text, "yaw_deg", [1]);
    return { shape: "box", name, centre, size: extent, yaw_deg };
  }

  private complain({ field, cause }: Complaint): void {
    const fields = [this.name, this.centre, this.size, this.yaw];
    const about = fields.find((each) => each.name === (field === "radius" ? "size" : field));
    if (about) about.complain(cause);
    else this.complaint.textContent = cause;
  }
}

/** Numbers as people list them. */
export function readNumbers(text: string, field: string, counts: number[]): number[] {
  const values = text.trim().split(/[\s,;]+/).map(Number);
  if (text.trim() === "" || !values.every(Number.isFinite) || !counts.includes(values.length))
    throw new Wrong(field, `Write ${counts.map((count) => (count === 1 ? "one number" : `${count} numbers`)).join(" or ")}, such as ${counts.at(-1) === 3 ? "0.1, 0, 0.5" : "0"}`);
  return values;
}
