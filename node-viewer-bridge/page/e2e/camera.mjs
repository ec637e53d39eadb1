// Makes headless Chromium a camera of a running bridge's site, with a video in the place of a webcam, and fails where
// something is missing:
//
//     node e2e/camera.mjs URL VIDEO [--name NAME] [--seconds N] [--screenshots DIR] [--timeout SECONDS]
//
// VIDEO is a y4m or mjpeg file with tags. The camera runs for N seconds after all checks. CHROMIUM names the browser
// (default /usr/bin/chromium). Writes a line per check on stderr; exit code 1 when one failed, 2 for wrong usage.

import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { barriers } from "./axe.mjs";
import { check, end, fail } from "./checks.mjs";
import { launch } from "./chromium.mjs";

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    name: { type: "string", default: "pocket" },
    seconds: { type: "string", default: "0" },
    screenshots: { type: "string" },
    timeout: { type: "string", default: "30" },
  },
});
const [url, video] = positionals;
const timeout = Number(options.timeout) * 1000;
if (!url || !video || !(timeout > 0)) {
  console.error("usage: node e2e/camera.mjs URL VIDEO [--name NAME] [--seconds N] [--screenshots DIR] [--timeout SECONDS]");
  process.exit(2);
}

const browser = await launch(["--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream", `--use-file-for-fake-video-capture=${video}`]);
const page = await browser.newPage({ viewport: { width: 412, height: 915 } });
page.on("pageerror", (error) => fail(error.message));
const seen = (selector) => page.waitForSelector(selector, { timeout });
const wait = (condition) => page.waitForFunction(condition, undefined, { timeout, polling: 100 });
const shoot = async (name) => options.screenshots && page.screenshot({ path: join(options.screenshots, `camera-${name}.png`) });
const joined = () => seen("[data-testid=link][data-condition=joined]");
const outlined = () => wait(() => Number(document.querySelector("[data-testid=outlines]").dataset.tags) > 0);

if (options.screenshots) await mkdir(options.screenshots, { recursive: true });
await page.goto(new URL("camera", url).href);
await check("it asks before it uses the camera", async () => {
  await seen("[data-testid=ask]");
  await shoot("asking");
  await page.fill("input[name=camera]", options.name);
  await page.selectOption("select[name=size]", { index: 0 });
  await page.check("input[name=pictures]");
  await page.click("[data-testid=start]");
});
await check("it joins the site", joined);
await check("tags are outlined", outlined);
await check("the clocks are compared", () => wait(() => document.querySelector("[data-fact=clock]")?.dataset.good === "true"));
await check("observations are sent", () => wait(() => Number(document.querySelector("[data-fact=sent] dd")?.textContent) > 10));
await shoot("live");
await check("axe finds nothing wrong", async () => {
  const found = await barriers(page);
  if (found.length > 0) throw new Error(found.join("; "));
});
await check("it rests in the background and comes back by itself", async () => {
  const hide = (hidden) =>
    page.evaluate((value) => {
      Object.defineProperty(document, "hidden", { configurable: true, get: () => value });
      document.dispatchEvent(new Event("visibilitychange"));
    }, hidden);
  await hide(true);
  await wait(() => document.querySelector("video").srcObject === null);
  await seen("[data-testid=link][data-condition=off]");
  await hide(false);
  await joined();
  await outlined();
});
await page.waitForTimeout(Number(options.seconds) * 1000);
await check("it stops when asked", async () => {
  await page.click("[data-testid=stop]");
  await seen("[data-stage=asking]");
});
await browser.close();
end();
