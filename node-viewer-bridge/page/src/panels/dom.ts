// Making elements, and writing to them only what changed: untouched text costs no layout.

/** A new element with class and children. */
export function element<K extends keyof HTMLElementTagNameMap>(
  name: K,
  className = "",
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(name);
  if (className) made.className = className;
  made.append(...children);
  return made;
}

/** The one element that `selector` names; the page is ours, so it is there. */
export function find<E extends Element>(selector: string, parent: ParentNode = document): E {
  const found = parent.querySelector<E>(selector);
  if (!found) throw new Error(`the page lacks ${selector}`);
  return found;
}

export function testId<E extends HTMLElement>(target: E, id: string): E {
  target.dataset["testid"] = id;
  return target;
}

/** A text that is written when it differs. */
export class Text {
  private shown: string | null = null;

  constructor(readonly element: HTMLElement) {}

  set(text: string): void {
    if (text === this.shown) return;
    this.shown = text;
    this.element.textContent = text;
  }
}

/** A state as colour (by `data-condition`) and as text. */
export class Condition {
  private readonly text: Text;

  constructor(readonly element: HTMLElement) {
    this.text = new Text(element);
  }

  set(condition: string): void {
    this.text.set(condition);
    if (this.element.dataset["condition"] !== condition) this.element.dataset["condition"] = condition;
  }
}

/** A small button that does something, or stays pressed. */
export function pressButton(text: string, id: string, action: () => void): HTMLButtonElement {
  const button = testId(element("button", "press", text), id);
  button.type = "button";
  button.addEventListener("click", action);
  return button;
}

/** A labelled list to choose from, whose entries come and go. */
export class Choice {
  readonly root: HTMLElement;
  private readonly select: HTMLSelectElement;
  private offered = "";

  constructor(label: string, id: string, changed: () => void = () => {}) {
    this.select = testId(element("select"), id);
    this.select.setAttribute("aria-label", label);
    this.select.addEventListener("change", changed);
    this.root = element("label", "choice-of", element("span", "", label), this.select);
  }

  get value(): string {
    return this.select.value;
  }

  choose(value: string): void {
    this.select.value = value;
  }

  /** Offers these; what was chosen stays chosen if it is among them. */
  offer(values: string[]): void {
    const key = values.join("\n");
    if (key === this.offered) return;
    this.offered = key;
    const chosen = this.select.value;
    this.select.replaceChildren(...values.map((value) => new Option(value, value)));
    if (values.includes(chosen)) this.select.value = chosen;
  }
}
