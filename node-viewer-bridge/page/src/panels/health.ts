// What is wrong with the site, about whom, since when, and what to do; and calibrations that may be applied.

import type { HealthEntry } from "../health.ts";
import { age } from "../format.ts";
import type { Offer, WizardKind } from "../protocol.ts";
import type { Site } from "../site.ts";
import { send } from "../wizard/command.ts";
import { element, pressButton, testId } from "./dom.ts";

const WIZARDS: Record<WizardKind, string> = { rig: "Calibrate", lens: "Calibrate", learn: "Learn" };

export class HealthPanel {
  private readonly well = testId(element("p", "well", "All is well: no node reports a fault."), "health-well");
  private readonly list = testId(element("div", "groups"), "notices");
  private shown = "";
  /** Fusion nodes whose proposal was applied from this page. */
  private readonly applied = new Set<string>();
  private complaint: string | null = null;

  /** `openWizard` opens a wizard about a camera or an object. */
  constructor(
    root: HTMLElement,
    private readonly site: Site,
    private readonly openWizard: (kind: WizardKind, subject: string) => void,
  ) {
    root.append(this.well, this.list);
  }

  update(now: number): void {
    const time = this.site.time(now);
    const [faults, information] = [this.site.health.groups("fault"), this.site.health.groups("information")];
    const formers = [...this.site.formers.values()].filter((offer) => this.applied.has(offer.node));
    const { condition } = this.site;
    const lines = [...faults, ...information].map((group) => group.map((entry) => line(entry, time)));
    const key = JSON.stringify([condition, formers, [...this.site.proposals.keys()], this.complaint, lines]);
    if (key === this.shown) return;
    this.shown = key;
    this.well.hidden = condition !== "healthy";
    const complaint = this.complaint === null ? [] : [element("p", "complaint", this.complaint)];
    const offers = formers.length > 0 ? [element("ul", "", ...formers.map((offer) => this.former(offer)))] : [];
    const known = information.length > 0 ? [testId(element("h2", "", "Good to know"), "health-information")] : [];
    const sections = (groups: HealthEntry[][]): HTMLElement[] => groups.map((group) => this.group(group, time));
    this.list.replaceChildren(...complaint, ...offers, ...sections(faults), ...known, ...sections(information));
  }

  private group(entries: HealthEntry[], time: number): HTMLElement {
    const [first] = entries;
    const title = first ? `${first.subject.kind === "node" ? "" : `${first.subject.kind} `}${first.subject.id}` : "";
    return element("section", "", element("h3", "", title), element("ul", "", ...entries.map((entry) => this.entry(entry, time))));
  }

  private entry(entry: HealthEntry, time: number): HTMLElement {
    const item = element("li", "entry", element("span", "cause", entry.cause));
    if (entry.remedy) item.append(" ", element("span", "remedy", ...withCode(entry.remedy)));
    const life = entry.active ? `for ${age(time - entry.since)}` : `ended ${age(time - entry.lastAt)} ago`;
    item.append(element("span", "life", life));
    item.dataset["severity"] = entry.severity;
    item.dataset["active"] = String(entry.active);
    item.dataset["acknowledged"] = String(entry.acknowledged);
    if (entry.active) item.append(element("span", "acts", ...this.acts(entry)));
    return item;
  }

  private acts(entry: HealthEntry): HTMLButtonElement[] {
    const acts: HTMLButtonElement[] = [];
    const { action, subject } = entry;
    if (action === "apply" && this.site.proposals.has(subject.id)) acts.push(this.request("Apply", { do: "apply_refinement", node: subject.id }));
    else if (action && action !== "apply") acts.push(change(WIZARDS[action], `health-${action}`, () => this.openWizard(action, subject.id)));
    if (entry.severity === "fault" && !entry.acknowledged) {
      const note = pressButton("Noted", "health-acknowledge", () => {
        this.site.health.acknowledge(entry.key);
        this.update(performance.now() / 1000);
      });
      note.title = "Goes on being listed, but wants no attention";
      acts.push(note);
    }
    return acts;
  }

  private former(offer: Offer): HTMLElement {
    const revert = this.request("Revert", { do: "revert", node: offer.node });
    return element("li", "choice", element("span", "", `${offer.node}: the last change of ${models(offer)} can be taken back`), revert);
  }

  private request(label: string, request: { do: "apply_refinement" | "revert"; node: string }): HTMLButtonElement {
    const button = change(label, request.do === "revert" ? "revert" : "apply-refinement", () => {
      button.disabled = true;
      void this.ask(request).finally(() => (button.disabled = false));
    });
    return button;
  }

  private async ask(request: { do: string; node: string }): Promise<void> {
    const complaint = await send("api/wizard", request);
    this.complaint = complaint?.cause ?? null;
    if (complaint === null) this.applied.add(request.node);
  }
}

/** A button that changes the site: not for those who only look. */
function change(label: string, id: string, action: () => void): HTMLButtonElement {
  const button = pressButton(label, id, action);
  button.classList.add("act");
  return button;
}

/** A text whose parts between backticks are commands. */
function withCode(text: string): (Node | string)[] {
  return text.split("`").map((part, at) => (at % 2 === 1 ? element("code", "", part) : part));
}

/** What is shown of an entry, as a key: ages change it once a second at first, later once a minute. */
const line = (entry: HealthEntry, time: number): string =>
  [entry.key, entry.cause, entry.acknowledged, entry.active, age(time - (entry.active ? entry.since : entry.lastAt))].join("\n");

function models(offer: Offer): string {
  const names = [...(offer.rig ? ["the cameras"] : []), ...offer.objects];
  return names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : names.join(", ");
}
