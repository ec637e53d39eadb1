// The cameras: a card each, with the live picture and how the camera is doing.

import { clockFigure, clockStory, count, fixed, magnitude, NONE } from "../format.ts";
import type { Preview } from "../protocol.ts";
import type { Selection } from "../selection.ts";
import type { CameraState, Site } from "../site.ts";
import { DetectorPanel } from "./detector.ts";
import { Condition, element, pressButton, testId, Text } from "./dom.ts";
import { Picture } from "./picture.ts";
import { SettingsPanel } from "./settings.ts";

export class CamerasPanel {
  private readonly cards = new Map<string, CameraCard>();
  private readonly empty = element("p", "empty", "No camera yet. Cameras appear here as they come up.");

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
    private readonly selection: Selection,
    private readonly pictureShown: (camera: CameraState, canvas: HTMLCanvasElement) => void,
    private readonly edit: (camera: string) => void,
  ) {
    root.append(this.empty);
  }

  preview(preview: Preview): void {
    this.card(this.site.camera(preview.camera)).picture.show(preview);
  }

  /** The picture of an earlier time, or none. */
  recall(id: string, preview: Preview | null): void {
    const card = this.cards.get(id);
    if (preview) card?.picture.show(preview);
  }

  picture(camera: CameraState): Picture {
    return this.card(camera).picture;
  }

  /** New outlines came for a camera's picture. */
  outlines(camera: CameraState, t_ns: number): void {
    const picture = this.card(camera).picture;
    if (picture.wants(t_ns)) picture.redraw();
  }

  update(now: number): void {
    for (const [id, card] of this.cards) if (!this.site.cameras.has(id)) this.drop(id, card);
    for (const camera of this.site.cameras.values()) this.card(camera).update(now);
    this.empty.hidden = this.cards.size > 0;
  }

  private drop(id: string, card: CameraCard): void {
    card.root.remove();
    this.cards.delete(id);
  }

  private card(camera: CameraState): CameraCard {
    const known = this.cards.get(camera.id);
    if (known) return known;
    const shown = (canvas: HTMLCanvasElement): void => this.pictureShown(camera, canvas);
    const card = new CameraCard(camera, this.site, this.selection, shown, this.edit);
    this.cards.set(camera.id, card);
    const next = [...this.cards.keys()].sort().find((id) => id > camera.id);
    this.root.insertBefore(card.root, (next && this.cards.get(next)?.root) || null);
    return card;
  }
}

class CameraCard {
  readonly root: HTMLElement;
  readonly picture: Picture;
  private readonly detector: DetectorPanel;
  private readonly settings: SettingsPanel;
  private readonly edit: HTMLButtonElement;
  private readonly condition: Condition;
  private readonly rate: Text;
  private readonly latency: Text;
  private readonly dropped: Text;
  private readonly clock: Text;

  constructor(
    private readonly camera: CameraState,
    site: Site,
    selection: Selection,
    pictureShown: (canvas: HTMLCanvasElement) => void,
    edit: (camera: string) => void,
  ) {
    const { id } = camera;
    this.picture = new Picture(camera, site, () => pictureShown(this.picture.canvas));
    this.detector = new DetectorPanel(id);
    this.settings = new SettingsPanel(id);
    this.condition = new Condition(testId(element("span", "condition"), `camera-${id}-condition`));
    const facts = element("dl", "facts");
    this.rate = fact(facts, "Rate", "Hz", `camera-${id}-rate`);
    this.latency = fact(facts, "Latency", "ms", `camera-${id}-latency`);
    this.dropped = fact(facts, "Dropped", "", `camera-${id}-dropped`);
    this.clock = fact(facts, "Clock", "", `camera-${id}-clock`);
    const look = pressButton("Look through", `camera-${id}-eye`, () => selection.lookThrough(id));
    this.edit = pressButton("Edit", `camera-${id}-edit`, () => edit(id));
    this.edit.classList.add("edit");
    this.edit.setAttribute("aria-label", `Edit camera ${id}`);
    this.edit.title = "Name and pose of this camera";
    const named = element("div", "named", element("h3", "", id), this.edit);
    const heading = element("header", "", named, this.condition.element);
    this.root = testId(
      element("article", "camera", this.enlarger(), element("div", "about", heading, facts, look), this.settings.root, this.detector.root),
      `camera-card-${id}`,
    );
  }

  update(now: number): void {
    const condition = this.camera.condition(now);
    this.condition.set(condition);
    const live = condition === "live";
    this.edit.hidden = this.camera.model === null;
    this.rate.set(live ? fixed(this.camera.rateHz(now), 1) : NONE);
    this.latency.set(live ? magnitude(this.camera.latency.median()) : NONE);
    this.dropped.set(this.camera.status ? count(this.camera.status.dropped) : NONE);
    this.updateClock(live);
    this.detector.show(live && this.picture.withRejected ? this.camera.reports.newest : null);
    this.settings.show(live && this.picture.withRejected ? this.camera.status : null, now);
    if (this.root.dataset["condition"] !== condition) this.root.dataset["condition"] = condition;
  }

  private updateClock(live: boolean): void {
    const { clock, status } = this.camera;
    this.clock.set(live ? clockFigure(clock, status?.clock ?? null) : NONE);
    const story = clockStory(clock, status?.clock ?? null);
    if (this.clock.element.title !== story) this.clock.element.title = story;
  }

  /** The picture as a button that makes the card large and small again. */
  private enlarger(): HTMLButtonElement {
    const button = element("button", "enlarge", this.picture.root);
    button.type = "button";
    button.setAttribute("aria-expanded", "false");
    button.setAttribute("aria-label", `Enlarge the picture of camera ${this.camera.id}`);
    button.addEventListener("click", () => {
      const large = this.root.classList.toggle("large");
      button.setAttribute("aria-expanded", String(large));
      this.picture.withRejected = large;
      this.picture.redraw();
    });
    return button;
  }
}

function fact(list: HTMLElement, name: string, unit: string, id: string): Text {
  const value = testId(element("span"), id);
  const suffix = unit ? [element("span", "unit", ` ${unit}`)] : [];
  list.append(element("div", "", element("dt", "", name), element("dd", "", value, ...suffix)));
  return new Text(value);
}
