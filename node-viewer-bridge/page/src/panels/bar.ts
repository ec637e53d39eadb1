// The bar at the top and the banner below it: which site, how much of it, and whether we still hear it.

import { magnitude, plural } from "../format.ts";
import type { Site } from "../site.ts";
import { Condition, find, Text } from "./dom.ts";

export class Bar {
  private readonly name = new Text(find("[data-testid=site-name]"));
  private readonly summary = new Text(find("[data-testid=summary]"));
  private readonly link = new Condition(find("[data-testid=link]"));
  private readonly banner = find<HTMLElement>("[data-testid=connection-banner]");
  private readonly notices = find<HTMLButtonElement>("[data-testid=notices-open]");
  private readonly health: Text;

  constructor(
    private readonly site: Site,
    openHealth: () => void,
  ) {
    this.health = new Text(this.notices);
    this.notices.addEventListener("click", openHealth);
  }

  connected(up: boolean): void {
    this.link.set(up ? "connected" : "offline");
    this.banner.hidden = up;
    document.body.classList.toggle("offline", !up);
  }

  update(now: number): void {
    this.name.set(this.site.name);
    let live = 0;
    for (const camera of this.site.cameras.values()) if (camera.condition(now) === "live") live++;
    let slowest = -Infinity;
    for (const object of this.site.objects.values()) slowest = Math.max(slowest, object.latency.median() ?? -Infinity);
    const latency = slowest > -Infinity ? `  ·  ${magnitude(slowest)} ms` : "";
    this.summary.set(`${plural(live, "camera")}  ·  ${plural(this.site.objects.size, "object")}${latency}`);
    const { condition, health } = this.site;
    this.notices.hidden = condition === "unknown";
    this.notices.dataset["condition"] = condition;
    const faults = health.open > 0 ? plural(health.open, "fault") : `${plural(health.faults.length, "fault")} noted`;
    this.health.set(condition === "faulty" ? faults : "healthy");
  }
}
