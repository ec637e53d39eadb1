// Two devices and the link of one phone of a protected site, in headless Chromium: the first becomes the camera and may
// return, the second is told why it may not, and may once an operator has freed the link.
//
//     node e2e/phone-link.mjs LINK VIDEO OPERATOR [--timeout SECONDS]
//
// LINK is what `sextant phone` shows, VIDEO a y4m or mjpeg file, OPERATOR the token of an operator. CHROMIUM names the
// browser (default /usr/bin/chromium). Writes a line per check on stderr; exit code 1 when one failed, 2 for wrong
// usage.

import { parseArgs } from "node:util";
import { check, end } from "./checks.mjs";
import { launch } from "./chromium.mjs";

const { values: options, positionals } = parseArgs({ allowPositionals: true, options: { timeout: { type: "string", default: "30" } } });
const [link, video, operator] = positionals;
const timeout = Number(options.timeout) * 1000;
if (!link || !video || !operator || !(timeout > 0)) {
  console.error("usage: node e2e/phone-link.mjs LINK VIDEO OPERATOR [--timeout SECONDS]");
  process.exit(2);
}

const browser = await launch(["--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream", `--use-file-for-fake-video-capture=${video}`]);
/** A device: its page keeps cookies and keys apart from other ones'. */
const device = async (width) => (await browser.newContext({ viewport: { width, height: 844 } })).newPage();
const shows = (page, condition) => page.waitForSelector(`[data-testid=link][data-condition=${condition}]`, { timeout });

/** Why a page that is refused for good lets go of the camera and asks anew. */
async function refusal(page) {
  const trouble = page.locator("[data-testid=ask] [data-testid=trouble]:not(:empty)");
  await trouble.waitFor({ timeout });
  return trouble.textContent();
}

async function join(page, address) {
  // Another fragment alone would not load the page.
  await page.goto("about:blank");
  await page.goto(address);
  await page.click("[data-testid=start]");
}

const [first, second, desk] = await Promise.all([device(390), device(390), device(1280)]);
const camera = new URL(link).searchParams.get("name");
await check("the first device is the camera", async () => {
  await join(first, link);
  await shows(first, "joined");
});
await check("a second one is told why it is not", async () => {
  await join(second, link);
  const words = await refusal(second);
  if (!words.includes("another device's")) throw new Error(`it says "${words}"`);
});
await check("the first returns with its name, without the link", async () => {
  await join(first, new URL("camera", link).href);
  await shows(first, "joined");
  const name = await first.inputValue("input[name=camera]");
  if (name !== camera) throw new Error(`it is called ${name}`);
});
await check("an operator frees the link for the second", async () => {
  await desk.goto(`${new URL("/", link).href}#token=${operator}`);
  await desk.click("[data-testid=phones-open]", { timeout });
  await desk.click(`[data-testid=phone-free-${camera}]`, { timeout });
  await desk.locator(".phones svg").waitFor({ state: "visible", timeout });
  // The first is no camera any more, and does not come back by itself.
  const words = await refusal(first);
  if (!words.includes("freed for another")) throw new Error(`it says "${words}"`);
  await join(second, link);
  await shows(second, "joined");
});
await browser.close();
end();
