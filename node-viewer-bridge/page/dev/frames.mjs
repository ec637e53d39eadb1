// How fast the page draws and what it keeps, in headless Chromium:
//
//     node dev/frames.mjs URL [--seconds 20] [--tab objects] [--rounds 1]
//
// Prints a JSON line a round: frames a second, script time a frame for drawing, script and layout time a second for
// everything, the longest task, the heap after a collection, and changes of the page a second. Drawing by software
// limits the frames, not the page. With a mock bridge of SPEED=20 a minute is twenty.

import { parseArgs } from "node:util";
import { launch } from "../e2e/chromium.mjs";

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { seconds: { type: "string", default: "20" }, tab: { type: "string", default: "objects" }, rounds: { type: "string", default: "1" } },
});
const [url] = positionals;
if (!url) {
  console.error("usage: node dev/frames.mjs URL [--seconds 20] [--tab objects] [--rounds 1]");
  process.exit(2);
}

const browser = await launch();
try {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable");
  await page.goto(url);
  await page.waitForFunction(() => window.sextant?.frames() > 20, null, { timeout: 60_000 });
  await page.click(`[data-testid=tab-${options.tab}]`);
  await page.evaluate(() => {
    window.measured = { longest: 0, changes: 0 };
    new PerformanceObserver((list) => list.getEntries().forEach((task) => (window.measured.longest = Math.max(window.measured.longest, task.duration)))).observe({ type: "longtask" });
    new MutationObserver((list) => (window.measured.changes += list.length)).observe(document.body, { subtree: true, childList: true, characterData: true });
  });
  for (let round = 0; round < Number(options.rounds); round++) console.log(JSON.stringify(await measure(page, session)));
} finally {
  await browser.close();
}

async function metrics(page, session) {
  const { metrics } = await session.send("Performance.getMetrics");
  const value = (name) => metrics.find((metric) => metric.name === name).value;
  const [frames, draw_ms] = await page.evaluate(() => [window.sextant.frames(), window.sextant.drawMs()]);
  return { frames, draw_ms, script_s: value("ScriptDuration"), layout_s: value("LayoutDuration") + value("RecalcStyleDuration"), at: value("Timestamp") };
}

async function measure(page, session) {
  await page.evaluate(() => Object.assign(window.measured, { longest: 0, changes: 0 }));
  const before = await metrics(page, session);
  await page.waitForTimeout(Number(options.seconds) * 1000);
  const after = await metrics(page, session);
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  const { longest, changes } = await page.evaluate(() => window.measured);
  const [seconds, frames] = [after.at - before.at, after.frames - before.frames];
  return {
    frames_per_s: Number((frames / seconds).toFixed(1)),
    draw_ms_per_frame: Number(((after.draw_ms - before.draw_ms) / frames).toFixed(2)),
    script_ms_per_s: Math.round((1000 * (after.script_s - before.script_s)) / seconds),
    layout_ms_per_s: Math.round((1000 * (after.layout_s - before.layout_s)) / seconds),
    longest_task_ms: Math.round(longest),
    heap_MB: Number((usedSize / 1e6).toFixed(1)),
    changes_per_s: Math.round(changes / seconds),
  };
}
