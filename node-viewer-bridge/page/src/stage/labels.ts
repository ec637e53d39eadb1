// Text at points of the world: crisp, readable by screen readers, moved by transforms only.

import { type PerspectiveCamera, Vector3 } from "three";

/** How a label lies over its point: objects' names stand above theirs. */
const RISE = { camera: "-50%", object: "-100%", axis: "-50%" };

export class Label {
  readonly at = new Vector3();
  visible = true;
  private shownText = "";
  private shownTransform = "";
  private shownCondition = "";

  constructor(
    readonly element: HTMLElement,
    private readonly rise: string,
  ) {}

  set text(text: string) {
    if (text === this.shownText) return;
    this.shownText = text;
    this.element.textContent = text;
  }

  set condition(condition: string) {
    if (condition === this.shownCondition) return;
    this.shownCondition = condition;
    this.element.dataset["condition"] = condition;
  }

  place(x: number, y: number): void {
    const transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, ${this.rise})`;
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
    const label = new Label(element, RISE[kind]);
    label.text = text;
    this.labels.add(label);
    return label;
  }

  remove(label: Label): void {
    this.labels.delete(label);
    label.element.remove();
  }

  /** Puts each label where the camera sees its point. */
  update(camera: PerspectiveCamera, width: number, height: number): void {
    for (const label of this.labels) {
      const point = this.projected.copy(label.at).project(camera);
      const seen = label.visible && point.z < 1 && Math.abs(point.x) < 1.1 && Math.abs(point.y) < 1.1;
      if (label.element.hidden === seen) label.element.hidden = !seen;
      if (seen) label.place(((point.x + 1) / 2) * width, ((1 - point.y) / 2) * height);
    }
  }
}
