// The parts that forms are made of: a labelled control with a hint below it and a place for a complaint.

import { element, testId } from "../panels/dom.ts";

export type Control = HTMLInputElement | HTMLSelectElement;

/** A labelled control; complaints about it stand below. */
export class Field {
  readonly root: HTMLElement;
  private readonly complaint: HTMLElement;

  constructor(
    readonly name: string,
    label: string,
    readonly control: Control,
    options: { unit?: string; hint?: string } = {},
  ) {
    const id = `wizard-field-${name}`;
    control.id = id;
    testId(control, id);
    const title = element("label", "", label);
    title.htmlFor = id;
    const unit = options.unit ? [element("span", "unit", options.unit)] : [];
    this.complaint = testId(element("p", "complaint"), `wizard-complaint-${name}`);
    this.complaint.id = `${id}-complaint`;
    this.complaint.hidden = true;
    const hint = element("p", "note", options.hint ?? "");
    hint.id = `${id}-note`;
    hint.hidden = !options.hint;
    control.setAttribute("aria-describedby", `${this.complaint.id} ${hint.id}`);
    control.addEventListener("input", () => this.complain(""));
    this.root = element("div", "field", title, element("div", "control", control, ...unit), hint, this.complaint);
  }

  get text(): string {
    return this.control.value;
  }

  complain(cause: string): void {
    this.complaint.textContent = cause;
    this.complaint.hidden = cause === "";
    this.control.setAttribute("aria-invalid", String(cause !== ""));
  }
}

export function textBox(value: string, mode: "text" | "numeric" | "decimal" = "text"): HTMLInputElement {
  const box = element("input");
  box.value = value;
  box.inputMode = mode;
  box.autocomplete = "off";
  box.spellcheck = false;
  return box;
}

export function fileBox(): HTMLInputElement {
  const box = element("input");
  box.type = "file";
  box.accept = ".toml";
  return box;
}

export function choice(options: [value: string, title: string][]): HTMLSelectElement {
  const select = element("select");
  select.addEventListener("change", () => (select.dataset["chosen"] = ""));
  offer(select, options);
  return select;
}

/** Sets what may be chosen, and keeps what a person chose; until then it is the first. */
export function offer(select: HTMLSelectElement, options: [value: string, title: string][]): void {
  const known = [...select.options].map((option) => `${option.value}\n${option.text}`).join("\0");
  if (known === options.map((option) => option.join("\n")).join("\0")) return;
  const chosen = select.value;
  select.replaceChildren(...options.map(([value, title]) => new Option(title, value)));
  const isKept = "chosen" in select.dataset && options.some(([value]) => value === chosen);
  select.value = isKept ? chosen : (options[0]?.[0] ?? "");
}

/** Buttons of which one is pressed. */
export class Segments<T extends string> {
  readonly root = element("div", "segments");
  private readonly buttons = new Map<T, HTMLButtonElement>();

  constructor(
    label: string,
    names: Record<T, string>,
    public value: T,
    private readonly changed: (value: T) => void = () => {},
  ) {
    this.root.setAttribute("role", "group");
    this.root.setAttribute("aria-label", label);
    for (const [key, name] of Object.entries(names) as [T, string][]) this.add(key, name);
    this.show();
  }

  choose(value: T): void {
    if (value === this.value) return;
    this.value = value;
    this.show();
    this.changed(value);
  }

  private add(key: T, name: string): void {
    const button = testId(element("button", "", name), `wizard-choose-${key}`);
    button.type = "button";
    button.addEventListener("click", () => this.choose(key));
    this.buttons.set(key, button);
    this.root.append(button);
  }

  private show(): void {
    for (const [key, button] of this.buttons) button.setAttribute("aria-pressed", String(key === this.value));
  }
}

export function button(title: string, id: string, className = ""): HTMLButtonElement {
  const made = testId(element("button", className, title), id);
  made.type = "button";
  return made;
}
