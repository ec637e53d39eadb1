// When something is silent: one rule for cameras, objects and nodes, with the figures of the bridge.

import type { Hello } from "./protocol.ts";

export class Silence {
  /** Until the bridge says hello, nothing is. */
  private rule: Hello["silence"] = { seconds: Infinity, messages: 0 };

  take(rule: Hello["silence"]): void {
    this.rule = rule;
  }

  /** Whether what was last heard at a time, s, is silent now; `rateHz` is its rate, 0 where that is unknown. */
  holds(heardAt: number, now: number, rateHz = 0): boolean {
    const slow = rateHz > 0 ? this.rule.messages / rateHz : 0;
    return now - heardAt > Math.max(this.rule.seconds, slow);
  }
}
