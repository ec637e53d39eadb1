// Text at points of the world: crisp, readable by screen readers, moved by transforms only, never over one another.

import { type PerspectiveCamera, Vector3 } from "three";
import { type LabelBox, Places } from "./apart.ts";

/**
 * Share of a label's height that lies below its point: zones' names stand above theirs. Those of the first kinds keep
 * their place, others give way.
 */
const BELOW = { camera: 0.5, axis: 0.5, zone: 0, ruler: 0.5, object: 0.5 };
export type LabelKind = keyof typeof BELOW;
const ORDER = Object.keys(BELOW);
/** Where an object's label may lie: above, right, left and below; the first that is free. */
const SPOTS = [[0, -1], [1, 0], [-1, 0], [0, 1]] as const;
/** Pixels between an object and its label. */
const GAP = 3;
/** Share of the way to its new place that a label goes in a frame: it glides where there is room. */
const GLIDE = 0.35;
/** Pixels. Less is not worth a change of the page. */
const STEP = 0.1;

export class Label implements LabelBox {
  readonly at = new Vector3();
  /** Of the sphere around `at` that the label lies beside; 0 for a point. */
  radius = 0;
  visible = true;
  /** Whether it is on the stage in this frame. */
  seen = false;
  /** Where it lies on the stage, pixels: its middle at the bottom. */
  x = 0;
  bottom = 0;
  width = 0;
  height = 0;
  /** Where its point is on the stage, and the radius there, pixels. */
  private readonly point = { x: 0, y: 0, reach: 0 };
  /** From its point to where it lies. */
  private readonly shift = { x: NaN, y: NaN };
  private spot = 0;
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

  show(seen: boolean): void {
    this.seen = seen;
    if (this.element.hidden === seen) this.element.hidden = !seen;
    if (!seen) this.shift.x = NaN;
    // Asked of the page once for each text, for it costs a layout.
    if (!seen || this.width > 0) return;
    this.width = this.element.offsetWidth;
    this.height = this.element.offsetHeight;
  }

  /** Its object is there on the stage, and that large. */
  project(x: number, y: number, reach: number, bodies: Places): void {
    Object.assign(this.point, { x, y, reach });
    if (reach > 0) bodies.take({ x, bottom: y + reach, width: 2 * reach, height: 2 * reach });
  }

  /** Finds its place, over no other label and, where that can be, over no object. */
  settle(labels: Places, bodies: Places, stageWidth: number): void {
    if (!this.choose(labels, bodies)) {
      this.moveTo(0);
      this.bottom -= labels.lift(this);
    }
    const { point, shift } = this;
    const wanted = { x: this.x - point.x, y: this.bottom - point.y };
    if (Number.isNaN(shift.x)) Object.assign(shift, wanted);
    shift.x += (wanted.x - shift.x) * GLIDE;
    shift.y += (wanted.y - shift.y) * GLIDE;
    const hold = this.width / 2;
    this.x = Math.min(stageWidth - hold, Math.max(hold, point.x + shift.x));
    this.bottom = point.y + shift.y;
    // On its way and at the stage's edge it may not lie over another either.
    if (!labels.isFree(this)) {
      Object.assign(shift, wanted);
      this.x = point.x + shift.x;
      this.bottom = point.y + shift.y;
    }
    labels.take(this);
    this.place();
  }

  private choose(labels: Places, bodies: Places): boolean {
    const nSpots = this.point.reach > 0 ? SPOTS.length : 1;
    for (const others of [bodies, null])
      // It stays where it is as long as it can.
      for (let k = -1; k < nSpots; k++) {
        const spot = k < 0 ? this.spot : k;
        this.moveTo(spot);
        if (!labels.isFree(this) || others?.isFree(this) === false) continue;
        this.spot = spot;
        return true;
      }
    return false;
  }

  private moveTo(spot: number): void {
    const { x, y, reach } = this.point;
    const [right, down] = reach > 0 ? SPOTS[spot as 0 | 1 | 2 | 3] : ([0, 0] as const);
    const below = reach > 0 ? 0.5 : BELOW[this.kind];
    this.x = x + right * (reach + GAP + this.width / 2);
    this.bottom = y + down * (reach + GAP + this.height / 2) + below * this.height;
  }

  private place(): void {
    const y = this.bottom - this.height;
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
  private readonly bodies = new Places();

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

  /**
   * Puts each label where the camera sees its point, beside its object, over no other label. `scale`: pixels of a metre
   * at a distance of one.
   */
  update(camera: PerspectiveCamera, scale: number, width: number, height: number): void {
    this.places.clear();
    this.bodies.clear();
    for (const label of this.labels) {
      const distance = label.at.distanceTo(camera.position);
      const point = this.projected.copy(label.at).project(camera);
      label.show(label.visible && point.z < 1 && Math.abs(point.x) < 1.1 && Math.abs(point.y) < 1.1);
      if (label.seen) label.project(((point.x + 1) / 2) * width, ((1 - point.y) / 2) * height, (label.radius * scale) / distance, this.bodies);
    }
    for (const label of this.labels) if (label.seen) label.settle(this.places, this.bodies, width);
  }
}
