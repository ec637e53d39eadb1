// The bar at the top and the banner below it: which site, how much of it, and whether we still hear it.

import { magnitude, plural } from "../format.ts";
import type { Offer } from "../protocol.ts";
import type { Site } from "../site.ts";
import { send } from "../wizard/command.ts";
import { Condition, element, find, testId, Text } from "./dom.ts";

/** Something that a person may have done from the notices. */
interface Choice {
  text: string;
  label: "Apply" | "Revert";
  wish: { do: "apply_refinement" | "revert"; node: string };
}

export class Bar {
  private readonly name = new Text(find("[data-testid=site-name]"));
  private readonly summary = new Text(find("[data-testid=summary]"));
  private readonly link = new Condition(find("[data-testid=link]"));
  private readonly banner = find<HTMLElement>("[data-testid=connection-banner]");
  private readonly notices = find<HTMLDetailsElement>("[data-testid=notices]");
  private shownNotices = "";
  /** Fusion nodes whose proposal was applied from this page. */
  private readonly applied = new Set<string>();
  private complaint: string | null = null;

  constructor(private readonly site: Site) {}

  connected(up: boolean): void {
    this.link.set(up ? "connected" : "offline");
    this.banner.hidden = up;
    document.body.classList.toggle("offline", !up);
  }

  update(now: number): void {
    this.name.set(this.site.name);
    const live = [...this.site.cameras.values()].filter((camera) => camera.condition(now) === "live").length;
    const latencies = [...this.site.objects.values()].flatMap((object) => object.latency.median() ?? []);
    const slowest = latencies.length > 0 ? [`${magnitude(Math.max(...latencies))} ms`] : [];
    const parts = [plural(live, "camera"), plural(this.site.objects.size, "object"), ...slowest];
    this.summary.set(parts.join("  ·  "));
    const complaints = this.complaint === null ? [] : [this.complaint];
    this.updateNotices([...complaints, ...this.site.notices()], this.choices());
  }

  private choices(): Choice[] {
    const apply = [...this.site.proposals.values()].map((offer): Choice => ({
      text: `${offer.node}: a refined calibration of ${models(offer)} is proposed`,
      label: "Apply",
      wish: { do: "apply_refinement", node: offer.node },
    }));
    const applied = [...this.site.formers.values()].filter((offer) => this.applied.has(offer.node));
    const revert = applied.map((offer): Choice => ({
      text: `${offer.node}: the last change of ${models(offer)} can be taken back`,
      label: "Revert",
      wish: { do: "revert", node: offer.node },
    }));
    return [...apply, ...revert];
  }

  private async choose(choice: Choice): Promise<void> {
    const complaint = await send(choice.wish);
    this.complaint = complaint?.cause ?? null;
    if (complaint === null) this.applied.add(choice.wish.node);
  }

  private item(choice: Choice): HTMLElement {
    const button = testId(element("button", "", choice.label), choice.label === "Apply" ? "apply-refinement" : "revert");
    button.type = "button";
    button.addEventListener("click", () => {
      button.disabled = true;
      void this.choose(choice).finally(() => (button.disabled = false));
    });
    return element("li", "choice", choice.text, button);
  }

  private updateNotices(notices: string[], choices: Choice[]): void {
    const key = [...notices, ...choices.map((choice) => choice.text)].join("\n");
    if (key === this.shownNotices) return;
    this.shownNotices = key;
    const items = [...choices.map((choice) => this.item(choice)), ...notices.map((text) => element("li", "", text))];
    this.notices.hidden = items.length === 0;
    find("summary", this.notices).textContent = plural(items.length, "notice");
    find("ul", this.notices).replaceChildren(...items);
  }
}

function models(offer: Offer): string {
  const names = [...(offer.rig ? ["the cameras"] : []), ...offer.objects];
  return names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : names.join(", ");
}
