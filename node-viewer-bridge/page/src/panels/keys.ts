// Keys, and the list of them.

import { element, find, testId } from "./dom.ts";

export interface Shortcut {
  key: string;
  /** As it stands on the keyboard, where that differs. */
  label?: string;
  about: string;
  /** Only where nothing else takes it: arrows also scroll, and move sliders. */
  onStage?: boolean;
  action(): void;
}

export class Shortcuts {
  private readonly dialog = testId(element("dialog", "shortcuts"), "shortcuts");

  constructor(private readonly shortcuts: Shortcut[]) {
    const rows = [...shortcuts, { key: "?", about: "This list" }].map(({ key, about, ...more }) => {
      const label = "label" in more && more.label ? more.label : key;
      return element("div", "", element("dt", "", element("kbd", "", label)), element("dd", "", about));
    });
    this.dialog.append(element("h2", "", "Keys"), element("dl", "", ...rows));
    this.dialog.addEventListener("click", () => this.dialog.close());
    document.body.append(this.dialog);
    document.addEventListener("keydown", (event) => this.press(event));
    find("[data-testid=shortcuts-open]").addEventListener("click", () => this.toggle());
  }

  private press(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    const isText = target.closest("input:not([type=range]), select, textarea, .wizard, .editor") !== null;
    if (event.ctrlKey || event.metaKey || event.altKey || isText) return;
    if (event.key === "?") return this.toggle();
    if (this.dialog.open) return;
    const shortcut = this.shortcuts.find(({ key }) => key === event.key);
    if (!shortcut || (shortcut.onStage && !isStage(target))) return;
    event.preventDefault();
    shortcut.action();
  }

  private toggle(): void {
    if (this.dialog.open) this.dialog.close();
    else this.dialog.showModal();
  }
}

/** Whether keys go to the stage: it has the focus, or nothing has and the page does not scroll. */
function isStage(target: HTMLElement): boolean {
  const { scrollHeight, clientHeight } = document.documentElement;
  return target.matches(scrollHeight > clientHeight ? ".stage canvas" : "body, .stage canvas");
}
