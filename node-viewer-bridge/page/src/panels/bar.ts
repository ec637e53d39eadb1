// The bar at the top and the banner below it: which site, how much of it, and whether we still hear it.

import { magnitude, plural } from "../format.ts";
import type { Site } from "../site.ts";
import { Condition, element, find, Text } from "./dom.ts";

export class Bar {
  private readonly name = new Text(find("[data-testid=site-name]"));
  private readonly summary = new Text(find("[data-testid=summary]"));
  private readonly link = new Condition(find("[data-testid=link]"));
  private readonly banner = find<HTMLElement>("[data-testid=connection-banner]");
  private readonly notices = find<HTMLDetailsElement>("[data-testid=notices]");
  private shownNotices = "";

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
    this.updateNotices(this.site.notices());
  }

  private updateNotices(notices: string[]): void {
    const key = notices.join("\n");
    if (key === this.shownNotices) return;
    this.shownNotices = key;
    this.notices.hidden = notices.length === 0;
    find("summary", this.notices).textContent = plural(notices.length, "notice");
    find("ul", this.notices).replaceChildren(...notices.map((text) => element("li", "", text)));
  }
}
