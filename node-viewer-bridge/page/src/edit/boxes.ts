// Rows of small boxes for numbers that belong together, with a label before them and a complaint below.

import { element, testId } from "../panels/dom.ts";
import { textBox } from "../wizard/fields.ts";

export class Boxes {
  readonly root: HTMLElement;
  private readonly row = element("div", "boxes");
  private readonly complaint = element("p", "complaint");
  private boxes: HTMLInputElement[] = [];
  /** What is shown of the value that nobody has touched. */
  private shown: string[] = [];

  constructor(
    private readonly id: string,
    private readonly label: string,
    unit: string,
    private readonly edited: () => void,
  ) {
    this.complaint.id = `${id}-complaint`;
    this.complaint.hidden = true;
    const title = element("span", "title", label, ...(unit ? [element("span", "unit", ` ${unit}`)] : []));
    this.root = testId(element("div", "boxed", title, this.row, this.complaint), id);
    this.root.setAttribute("role", "group");
    this.root.setAttribute("aria-label", unit ? `${label}, ${unit}` : label);
  }

  get texts(): string[] {
    return this.boxes.map((box) => box.value);
  }

  /** Whether somebody has written another value than was shown. */
  get isEdited(): boolean {
    return this.texts.some((_, at) => this.isBoxEdited(at));
  }

  /** The same of one box. */
  isBoxEdited(at: number): boolean {
    return this.texts[at]?.trim() !== this.shown[at];
  }

  /** Shows a value in boxes of these names. */
  show(names: readonly string[], texts: readonly string[]): void {
    this.shown = names.map((_, at) => texts[at] ?? "");
    if (this.boxes.length !== names.length) this.build(names);
    this.write(this.shown);
  }

  /** Writes as a person would. */
  write(texts: readonly string[]): void {
    for (const [at, box] of this.boxes.entries()) box.value = texts[at] ?? "";
    this.complain("");
  }

  complain(cause: string): void {
    this.complaint.textContent = cause;
    this.complaint.hidden = cause === "";
    for (const box of this.boxes) box.setAttribute("aria-invalid", String(cause !== ""));
    if (cause !== "") this.boxes[0]?.focus();
  }

  private build(names: readonly string[]): void {
    this.boxes = names.map((name) => {
      const box = testId(textBox("", "text"), `${this.id}-${name.split(" ")[0]}`);
      box.setAttribute("aria-label", `${this.label} ${name}`);
      box.setAttribute("aria-describedby", this.complaint.id);
      box.placeholder = "–";
      box.addEventListener("input", () => {
        this.complain("");
        this.edited();
      });
      return box;
    });
    const named = this.boxes.map((box, at) => element("label", "", element("i", "", names[at] ?? ""), box));
    this.row.style.setProperty("--boxes", String(names.length));
    this.row.replaceChildren(...named);
  }
}
