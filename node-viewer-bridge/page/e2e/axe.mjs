// What axe finds wrong with a page as it is now: contrast, names, roles of WCAG 2.1 A and AA.

import axe from "axe-core";

const LEVELS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"];

/** A sentence for each finding. */
export async function barriers(page) {
  await page.evaluate(axe.source);
  const { violations } = await page.evaluate((runOnly) => window.axe.run(document, { runOnly }), LEVELS);
  return violations.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${id} ${target.join(" ")}: ${failureSummary.split("\n").slice(1).join(" ").trim()}`));
}
