// Log of the site's findings: start, end, and whether they were acknowledged. Draws nothing.

import type { Report, Severity } from "./findings.ts";

/** Entries that are kept, ended ones included; the longest ended give way. */
const MAX_ENTRIES = 200;
/** A report that is missing for less than this has not ended: statuses come once a second and some findings flicker. */
const LINGER_S = 5;

/** A report and its life, in seconds since the Unix epoch. */
export interface HealthEntry extends Report {
  since: number;
  lastAt: number;
  /** Whether it is reported now. */
  active: boolean;
  acknowledged: boolean;
}

export class HealthLog {
  private readonly entries = new Map<string, HealthEntry>();

  /** Takes everything that is reported now. */
  take(reports: readonly Report[], now: number): void {
    for (const report of reports) this.report(report, now);
    for (const entry of this.entries.values()) if (entry.active && now - entry.lastAt > LINGER_S) entry.active = false;
    this.makeRoom();
  }

  /** Nothing is known of what holds: it goes on for now. */
  hold(now: number): void {
    for (const entry of this.entries.values()) if (entry.active) entry.lastAt = now;
  }

  /** Another site, or the page's clock was set. */
  clear(): void {
    this.entries.clear();
  }

  acknowledge(key: string): void {
    const entry = this.entries.get(key);
    if (entry) entry.acknowledged = true;
  }

  /** Faults that hold now. */
  get faults(): HealthEntry[] {
    return [...this.entries.values()].filter((entry) => entry.active && entry.severity === "fault");
  }

  /** Those that want attention. */
  get open(): number {
    return this.faults.filter((entry) => !entry.acknowledged).length;
  }

  /**
   * Of one severity, by what they are about, the one with the newest entry first; in each, what is active before what
   * has ended, the newest first.
   */
  groups(severity: Severity): HealthEntry[][] {
    const groups = new Map<string, HealthEntry[]>();
    const newestFirst = [...this.entries.values()].sort((a, b) => Number(b.active) - Number(a.active) || b.since - a.since);
    for (const entry of newestFirst) {
      if (entry.severity !== severity) continue;
      const name = `${entry.subject.kind} ${entry.subject.id}`;
      groups.set(name, [...(groups.get(name) ?? []), entry]);
    }
    return [...groups.values()];
  }

  private report(report: Report, now: number): void {
    const known = this.entries.get(report.key);
    if (known?.active) Object.assign(known, report, { lastAt: now });
    else this.entries.set(report.key, { ...report, since: now, lastAt: now, active: true, acknowledged: false });
  }

  private makeRoom(): void {
    if (this.entries.size <= MAX_ENTRIES) return;
    const byAge = [...this.entries.values()].sort((a, b) => Number(a.active) - Number(b.active) || a.lastAt - b.lastAt);
    for (const entry of byAge.slice(0, this.entries.size - MAX_ENTRIES)) this.entries.delete(entry.key);
  }
}
