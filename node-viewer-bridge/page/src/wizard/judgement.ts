// What came out: the verdict in words, the figures, and where it was kept.

import type { Wizard, WizardResult } from "../protocol.ts";
import { element, testId } from "../panels/dom.ts";
import { figuresOf, summaryOf } from "./figures.ts";

const GRADES = { good: "Good", usable: "Usable", poor: "Poor" };

export class Judgement {
  readonly verdict = testId(element("div", "verdict"), "wizard-verdict");
  readonly figures = testId(element("section", "results"), "wizard-figures");
  readonly kept = testId(element("ul", "kept"), "wizard-kept");
  private shown: string | null = null;

  constructor() {
    this.verdict.setAttribute("role", "status");
    this.figures.setAttribute("aria-label", "Figures");
  }

  show({ result }: Wizard): void {
    this.verdict.hidden = this.figures.hidden = result === undefined;
    this.kept.hidden = !result || result.kept.length === 0;
    const key = JSON.stringify(result ?? null);
    if (key === this.shown) return;
    this.shown = key;
    if (result) this.fill(result);
  }

  private fill(result: WizardResult): void {
    const { grade, because } = result.report.verdict;
    this.verdict.dataset["grade"] = grade;
    const reasons = because.length > 0 ? because : ["Nothing to complain of."];
    this.verdict.replaceChildren(
      element("p", "grade", GRADES[grade]),
      element("ul", "", ...reasons.map((reason) => element("li", "", reason))),
      element("p", "note", summaryOf(result)),
    );
    this.figures.replaceChildren(figuresOf(result));
    this.kept.replaceChildren(...result.kept.map((line) => element("li", "", line)));
  }
}
