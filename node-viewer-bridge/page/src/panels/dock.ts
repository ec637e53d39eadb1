// The panels below the stage: one is shown, a row of tabs chooses it.

import { remember, remembered } from "../storage.ts";
import { element, testId, Text } from "./dom.ts";

export interface Tab {
  key: string;
  title: string;
  panel: HTMLElement;
}

export class Dock {
  private readonly row = element("div", "tabs");
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private readonly badges = new Map<string, Text>();
  private readonly panels = new Map<string, HTMLElement>();
  current = "";

  constructor(root: HTMLElement, tabs: Tab[]) {
    this.row.setAttribute("role", "tablist");
    for (const tab of tabs) this.add(tab);
    root.prepend(this.row);
    const last = remembered("tab");
    this.show(typeof last === "string" && this.panels.has(last) ? last : (tabs[0]?.key ?? ""));
  }

  show(key: string): void {
    this.current = key;
    for (const [each, button] of this.buttons) {
      button.setAttribute("aria-selected", String(each === key));
      button.tabIndex = each === key ? 0 : -1;
    }
    for (const [each, panel] of this.panels) panel.hidden = each !== key;
    remember("tab", key);
  }

  /** A number beside a tab's title. */
  badge(key: string, count: number): void {
    const badge = this.badges.get(key);
    badge?.set(count > 0 ? String(count) : "");
    if (badge) badge.element.hidden = count === 0;
  }

  private add({ key, title, panel }: Tab): void {
    const badge = element("span", "badge");
    badge.hidden = true;
    this.badges.set(key, new Text(badge));
    const button = testId(element("button", "", title, badge), `tab-${key}`);
    button.type = "button";
    button.id = `tab-${key}`;
    button.setAttribute("role", "tab");
    button.addEventListener("click", () => this.show(key));
    button.addEventListener("keydown", (event) => this.move(event, key));
    panel.setAttribute("role", "tabpanel");
    panel.setAttribute("aria-labelledby", button.id);
    this.buttons.set(key, button);
    this.panels.set(key, panel);
    this.row.append(button);
  }

  private move(event: KeyboardEvent, from: string): void {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    event.preventDefault();
    event.stopPropagation();
    const keys = [...this.buttons.keys()];
    const next = keys[(keys.indexOf(from) + step + keys.length) % keys.length] ?? from;
    this.show(next);
    this.buttons.get(next)?.focus();
  }
}
