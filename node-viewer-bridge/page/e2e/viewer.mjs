// Looks at a running bridge's page as a person would, in headless Chromium, and fails where something is missing:
//
//     node e2e/viewer.mjs URL [--restart COMMAND] [--screenshots DIR] [--timeout SECONDS]
//
// COMMAND (run by the shell) restarts the bridge; it may return before the bridge is back. CHROMIUM names the browser
// (default /usr/bin/chromium). Writes a line per check on stderr, one JSON line at the end on stdout; exit code 1 when a
// check failed, 2 for wrong usage.

import { spawn } from "node:child_process";
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { launch } from "./chromium.mjs";

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { restart: { type: "string" }, screenshots: { type: "string" }, timeout: { type: "string", default: "30" } },
});
const [url] = positionals;
const timeout = Number(options.timeout) * 1000;
if (!url || !(timeout > 0)) {
  console.error("usage: node e2e/viewer.mjs URL [--restart COMMAND] [--screenshots DIR] [--timeout SECONDS]");
  process.exit(2);
}

const results = {};

async function check(name, action) {
  const begun = Date.now();
  try {
    await action();
    results[name] = true;
    console.error(`ok   ${name} (${Date.now() - begun} ms)`);
  } catch (error) {
    results[name] = false;
    console.error(`FAIL ${name}: ${error.message.split("\n")[0]}`);
  }
}

function assert(condition, message) {
  if (!condition) throw new Error(message);
}

const wait = (page, condition, argument) => page.waitForFunction(condition, argument, { timeout, polling: 100 });

/** Positions as the table shows them, by object. */
const shownPositions = (page) =>
  page.$$eval("[data-testid^=object-row-]", (rows) =>
    Object.fromEntries(rows.map((row) => [row.dataset.testid.slice("object-row-".length), row.querySelector(".position").textContent])),
  );

const drawnPositions = (page) => page.evaluate(() => window.sextant.positions());

/** Waits until at least one entry of what `read` returns differs from now. */
async function changes(page, what, read) {
  const before = JSON.stringify(await read(page));
  const end = Date.now() + timeout;
  while (Date.now() < end) {
    if (JSON.stringify(await read(page)) !== before) return;
    await page.waitForTimeout(100);
  }
  throw new Error(`${what} stood still for ${options.timeout} s at ${before}`);
}

async function checkObjects(page) {
  await wait(page, () => document.querySelector("[data-testid^=object-row-][data-condition=tracking]") !== null);
  await changes(page, "the table", shownPositions);
  await changes(page, "the scene", drawnPositions);
}

async function checkStagePixels(page) {
  const stage = page.locator("canvas[data-testid=stage]");
  const [first, frames] = [await stage.screenshot(), await page.evaluate(() => window.sextant.frames())];
  await wait(page, (drawn) => window.sextant.frames() > drawn + 10, frames);
  assert(!first.equals(await stage.screenshot()), "the stage shows the same pixels after ten frames");
}

/** Every card has a picture that is not one flat colour; somewhere tags are outlined, and where they are, pixels are set. */
async function checkPictures(page) {
  await wait(page, () => {
    const cards = [...document.querySelectorAll("[data-testid^=camera-card-]")];
    const pixels = (canvas) => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    const lively = (canvas) => canvas.width > 1 && new Set(pixels(canvas).filter((_, i) => i % 4 === 0)).size > 8;
    return cards.length > 0 && cards.every((card) => lively(card.querySelector("canvas.picture")));
  });
  await wait(page, () => {
    const overlays = [...document.querySelectorAll("canvas.overlay")].filter((overlay) => Number(overlay.dataset.tags) > 0);
    const drawn = (canvas) => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some((value, i) => i % 4 === 3 && value > 0);
    return overlays.length > 0 && overlays.every(drawn);
  });
}

/** Enlarged, a picture tells what the detector did with it; small again, it keeps quiet. */
async function checkDetector(page) {
  const card = page.locator("[data-testid^=camera-card-]").first();
  const [enlarge, detector] = [card.locator(".enlarge"), card.locator(".detector")];
  await enlarge.click();
  await detector.waitFor({ state: "visible", timeout });
  const told = await detector.innerText();
  assert(/\d+ tags? of \d+ candidates?/.test(told), `the detector's story is "${told}"`);
  const shares = await detector.locator(".stages span").evaluateAll((spans) => spans.map((span) => Number(span.style.flexGrow)));
  assert(shares.length === 6 && shares.some((ms) => ms > 0), `the stages' times are ${shares}`);
  await wait(page, (overlay) => Number(document.querySelector(overlay).dataset.rejected) > 0, ".camera.large canvas.overlay");
  await screenshot(page, "detector");
  await enlarge.click();
  await detector.waitFor({ state: "hidden", timeout });
}

async function checkReconnect(page) {
  await page.evaluate(() => {
    const banner = document.querySelector("[data-testid=connection-banner]");
    new MutationObserver(() => (window.bannerSeen ||= !banner.hidden)).observe(banner, { attributes: true });
  });
  const restart = spawn(options.restart, { shell: true, stdio: ["ignore", "ignore", "inherit"] });
  await wait(page, () => window.bannerSeen === true);
  await wait(page, () => document.querySelector("[data-testid=connection-banner]").hidden);
  assert((await page.textContent("[data-testid=link]")) === "connected", "the link is not called connected");
  await changes(page, "after the restart the scene", drawnPositions);
  await changes(page, "after the restart the table", shownPositions);
  restart.unref();
}

async function checkPhone(browser) {
  const context = await browser.newContext({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true });
  const page = await context.newPage();
  await page.goto(url);
  await checkObjects(page);
  await checkPictures(page);
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert(width <= 390, `the page is ${width} px wide on a phone of 390 px`);
  await screenshot(page, "phone");
  await context.close();
}

async function screenshot(page, name) {
  if (!options.screenshots) return;
  await mkdir(options.screenshots, { recursive: true });
  await page.screenshot({ path: join(options.screenshots, `${name}.png`), fullPage: name === "phone" });
}

const browser = await launch();
try {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  const [errors, elsewhere] = [[], []];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("request", (request) => {
    const target = new URL(request.url());
    if (/^(https?|wss?):$/.test(target.protocol) && target.host !== new URL(url).host) elsewhere.push(request.url());
  });
  await check("the page opens", () => page.goto(url, { timeout }));
  await check("objects move in the table and on the stage", () => checkObjects(page));
  await check("the stage is drawn anew", () => checkStagePixels(page));
  await check("pictures come with outlines", () => checkPictures(page));
  await screenshot(page, "desktop");
  await check("an enlarged picture tells what the detector did", () => checkDetector(page));
  if (options.restart) await check("it reconnects after the bridge restarts", () => checkReconnect(page));
  await check("a phone shows it all without scrolling sideways", () => checkPhone(browser));
  await check("no script failed", () => assert(errors.length === 0, errors.join("; ")));
  await check("nothing was asked of another host", () => assert(elsewhere.length === 0, elsewhere.join(" ")));
} finally {
  await browser.close();
}
console.log(JSON.stringify(results));
process.exit(Object.values(results).every(Boolean) ? 0 : 1);
