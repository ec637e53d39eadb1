// Text at points of the world: crisp, readable by screen readers, moved by transforms only.

import { type PerspectiveCamera, Vector3 } from "three";
import { lifts } from "./apart.ts";

/** How a label lies over its point: objects' names stand above theirs. */
const RISE = { camera: "-50%", object: "-100%", axis: "-50%" };
/** Share of the way to its new height that a lifted label goes in a frame: it glides where things pass one another. */
const GLIDE = 0.2;

export class Label {
  readonly at = new Vector3();
  visible = true;
  /** Pixels above its point, so as not to lie over another. */
  lift = 0;
  private extent: { width: number; height: number } | null = null;
  private shownText = "";
  private shownTransform = "";
  private shownCondition = "";

  constructor(
    readonly element: HTMLElement,
    readonly kind: keyof typeof RISE,
  ) {}

  /** Width and height in pixels; asked of the page once for each text, for it costs a layout. */
  get size(): { width: number; height: number } {
    // What is not shown has no extent.
    if (!this.extent?.width) this.extent = { width: this.element.offsetWidth, height: this.element.offsetHeight };
    return this.extent;
  }

  set text(text: string) {
    if (text === this.shownText) return;
    this.shownText = text;
    this.extent = null;
    this.element.textContent = text;
  }

  set condition(condition: string) {
    if (condition === this.shownCondition) return;
    this.shownCondition = condition;
    this.element.dataset["condition"] = condition;
  }

  place(x: number, y: number): void {
    const transform = `translate(${x.toFixed(1)}px, ${(y - this.lift).toFixed(1)}px) translate(-50%, ${RISE[this.kind]})`;
    if (transform === this.shownTransform) return;
    this.shownTransform = transform;
    this.element.style.transform = transform;
  }
}

export class LabelLayer {
  private readonly labels = new Set<Label>();
  private readonly projected = new Vector3();

  constructor(private readonly parent: HTMLElement) {}

  create(kind: "camera" | "object" | "axis", text: string): Label {
    const element = document.createElement("span");
    element.className = `label label-${kind}`;
    this.parent.append(element);
    const label = new Label(element, kind);
    label.text = text;
    this.labels.add(label);
    return label;
  }

  remove(label: Label): void {
    this.labels.delete(label);
    label.element.remove();
  }

  /** Puts each label where the camera sees its point, objects' names above one another where they would lie over one another. */
  update(camera: PerspectiveCamera, width: number, height: number): void {
    const names: { label: Label; x: number; y: number }[] = [];
    for (const label of this.labels) {
      const point = this.projected.copy(label.at).project(camera);
      const seen = label.visible && point.z < 1 && Math.abs(point.x) < 1.1 && Math.abs(point.y) < 1.1;
      if (label.element.hidden === seen) label.element.hidden = !seen;
      if (!seen) continue;
      const [x, y] = [((point.x + 1) / 2) * width, ((1 - point.y) / 2) * height];
      if (label.kind === "object") names.push({ label, x, y });
      else label.place(x, y);
    }
    const wanted = lifts(names.map(({ label, x, y }) => ({ x, bottom: y, ...label.size })));
    names.forEach(({ label, x, y }, index) => {
      label.lift += ((wanted[index] ?? 0) - label.lift) * GLIDE;
      label.place(x, y);
    });
  }
}
