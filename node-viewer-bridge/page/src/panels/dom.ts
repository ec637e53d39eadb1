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
