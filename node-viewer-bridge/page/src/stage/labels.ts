// Text at points of the world: crisp, readable by screen readers, moved by transforms only, never over one another.

import { type PerspectiveCamera, Vector3 } from "three";
import { Places } from "./apart.ts";

/** How a label lies over its point: objects' and zones' names stand above theirs. Those of the first kinds keep their place, others give way. */
const RISE = { camera: "-50%", axis: "-50%", zone: "-100%", ruler: "-50%", object: "-100%" };
export type LabelKind = keyof typeof RISE;
const ORDER = Object.keys(RISE);
/** Share of the way to its new height that a lifted label goes in a frame: it glides where there is room. */
const GLIDE = 0.2;
/** Pixels. Less is not worth a change of the page. */
const STEP = 0.1;

export class Label {
  readonly at = new Vector3();
  visible = true;
  /** Pixels above its point, so as not to lie over another. */
  lift = 0;
  /** Where its point is on the stage, pixels; below, where its bottom would be without a lift. */
  x = 0;
  bottom = 0;
  width = 0;
  height = 0;
  private shownText = "";
  private shownX = NaN;
  private shownY = NaN;
  private shownCondition = "";

  constructor(
    readonly element: HTMLElement,
    readonly kind: LabelKind,
  ) {}

  set text(text: string) {
    if (text === this.shownText) return;
    this.shownText = text;
    this.width = 0;
    this.element.textContent = text;
  }

  set condition(condition: string) {
    if (condition === this.shownCondition) return;
    this.shownCondition = condition;
    this.element.dataset["condition"] = condition;
  }

  /** Asked of the page once for each text, for it costs a layout. */
  measure(): void {
    if (this.width > 0) return;
    this.width = this.element.offsetWidth;
    this.height = this.element.offsetHeight;
  }

  project(x: number, y: number): void {
    this.x = x;
    this.bottom = RISE[this.kind] === "-50%" ? y + this.height / 2 : y;
  }

  place(): void {
    const y = this.bottom - this.lift - this.height;
    if (Math.abs(this.x - this.shownX) < STEP && Math.abs(y - this.shownY) < STEP) return;
    this.shownX = this.x;
    this.shownY = y;
    this.element.style.transform = `translate(${(this.x - this.width / 2).toFixed(1)}px, ${y.toFixed(1)}px)`;
  }
}

export class LabelLayer {
  /** By kind, then by age. */
  private readonly labels: Label[] = [];
  private readonly projected = new Vector3();
  private readonly places = new Places();

  constructor(private readonly parent: HTMLElement) {}

  create(kind: LabelKind, text: string): Label {
    const element = document.createElement("span");
    element.className = `label label-${kind}`;
    // Until it has its place.
    element.hidden = true;
    this.parent.append(element);
    const label = new Label(element, kind);
    label.text = text;
    this.labels.push(label);
    this.labels.sort((a, b) => ORDER.indexOf(a.kind) - ORDER.indexOf(b.kind));
    return label;
  }

  remove(label: Label): void {
    const at = this.labels.indexOf(label);
    if (at >= 0) this.labels.splice(at, 1);
    label.element.remove();
  }

  /** Puts each label where the camera sees its point, above others where it would lie over them. */
  update(camera: PerspectiveCamera, width: number, height: number): void {
    this.places.clear();
    for (const label of this.labels) {
      const point = this.projected.copy(label.at).project(camera);
      const seen = label.visible && point.z < 1 && Math.abs(point.x) < 1.1 && Math.abs(point.y) < 1.1;
      if (label.element.hidden === seen) label.element.hidden = !seen;
      if (!seen) continue;
      label.measure();
      label.project(((point.x + 1) / 2) * width, ((1 - point.y) / 2) * height);
      const wanted = this.places.lift(label);
      label.lift += (wanted - label.lift) * GLIDE;
      // On its way it may not lie over another either.
      if (!this.places.isFree(label, label.lift)) label.lift = wanted;
      this.places.take(label, label.lift);
      label.place();
    }
  }
}
