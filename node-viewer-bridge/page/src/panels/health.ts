// What is wrong with the site, about whom, since when, and what to do; and calibrations that may be applied.

import type { HealthEntry } from "../health.ts";
import { age } from "../format.ts";
import type { Offer } from "../protocol.ts";
import type { Site } from "../site.ts";
import { send } from "../wizard/command.ts";
import { element, pressButton, testId } from "./dom.ts";

/** Something that a person may have done. */
interface Choice {
  text: string;
  label: "Apply" | "Revert";
  request: { do: "apply_refinement" | "revert"; node: string };
}

export class HealthPanel {
  private readonly list = testId(element("div", "groups"), "notices");
  private readonly empty = element("p", "empty", "Nothing is wrong that the site knows of.");
  private shown = "";
  /** Fusion nodes whose proposal was applied from this page. */
  private readonly applied = new Set<string>();
  private complaint: string | null = null;

  constructor(
    root: HTMLElement,
    private readonly site: Site,
  ) {
    root.append(this.list, this.empty);
  }

  /** What wants attention. */
  get open(): number {
    return this.site.health.open + this.choices().length;
  }

  update(now: number): void {
    const time = this.site.time(now);
    const groups = this.site.health.groups();
    const choices = this.choices();
    const key = JSON.stringify([choices, this.complaint, groups.map((group) => group.map((entry) => line(entry, time)))]);
    if (key === this.shown) return;
    this.shown = key;
    const sections = groups.map((group) => this.group(group, time));
    const offers = element("ul", "", ...choices.map((choice) => this.item(choice)));
    const complaint = this.complaint === null ? [] : [element("p", "complaint", this.complaint)];
    this.list.replaceChildren(...complaint, ...(choices.length > 0 ? [offers] : []), ...sections);
    this.empty.hidden = groups.length + choices.length > 0;
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
    item.dataset["level"] = entry.level;
    item.dataset["active"] = String(entry.active);
    item.dataset["acknowledged"] = String(entry.acknowledged);
    if (entry.active && !entry.acknowledged) {
      const note = pressButton("Noted", "health-acknowledge", () => {
        this.site.health.acknowledge(entry.key);
        this.update(performance.now() / 1000);
      });
      note.title = "Goes on being listed, but wants no attention";
      item.append(note);
    }
    return item;
  }

  private choices(): Choice[] {
    const apply = [...this.site.proposals.values()].map((offer): Choice => ({
      text: `${offer.node}: a refined calibration of ${models(offer)} is proposed`,
      label: "Apply",
      request: { do: "apply_refinement", node: offer.node },
    }));
    const applied = [...this.site.formers.values()].filter((offer) => this.applied.has(offer.node));
    const revert = applied.map((offer): Choice => ({
      text: `${offer.node}: the last change of ${models(offer)} can be taken back`,
      label: "Revert",
      request: { do: "revert", node: offer.node },
    }));
    return [...apply, ...revert];
  }

  private async choose(choice: Choice): Promise<void> {
    const complaint = await send("api/wizard", choice.request);
    this.complaint = complaint?.cause ?? null;
    if (complaint === null) this.applied.add(choice.request.node);
  }

  private item(choice: Choice): HTMLElement {
    const button = pressButton(choice.label, choice.label === "Apply" ? "apply-refinement" : "revert", () => {
      button.disabled = true;
      void this.choose(choice).finally(() => (button.disabled = false));
    });
    return element("li", "choice", element("span", "", choice.text), button);
  }
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
