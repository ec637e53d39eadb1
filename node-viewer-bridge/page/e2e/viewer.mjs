// Looks at a running bridge's page as a person would, in headless Chromium, and fails where something is missing:
//
//     node e2e/viewer.mjs URL [--restart COMMAND] [--screenshots DIR] [--timeout SECONDS]
//
// COMMAND (run by the shell) restarts the bridge; it may return before the bridge is back. CHROMIUM names the browser
// (default /usr/bin/chromium). Writes a line per check on stderr, one JSON line at the end on stdout; exit code 1 when
// a check failed, 2 for wrong usage.

import { spawn } from "node:child_process";
import { mkdir, readFile } from "node:fs/promises";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { barriers } from "./axe.mjs";
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

/** Waits until at least one entry of what `read` returns differs from before, or from now. */
async function changes(page, what, read, from) {
  const before = JSON.stringify(from ?? (await read(page)));
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

/**
 * Every card has a picture that is not one flat colour; somewhere tags are outlined, and where they are, pixels are
 * set.
 */
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

/**
 * Gain set on the page makes the pictures brighter; what the camera cannot do is told in words; emptied, all is as
 * before.
 */
async function checkSettings(page) {
  const card = page.locator("[data-testid^=camera-card-]").first();
  const camera = (await card.getAttribute("data-testid")).slice("camera-card-".length);
  await card.locator(".enlarge").click();
  const set = async (values) => {
    for (const [key, text] of Object.entries(values)) await page.fill(`[data-testid=camera-${camera}-${key}]`, text);
    await page.click(`[data-testid=camera-${camera}-apply]`);
  };
  const says = (part, words) => wait(page, ([id, words]) => document.querySelector(`[data-testid=${id}]`).textContent.includes(words), [`camera-${camera}-${part}`, words]);
  const brightness = async () => Number((await page.textContent(`[data-testid=camera-${camera}-effect]`)).match(/level (\d+)/)[1]);
  await says("effect", "images/s");
  const before = await brightness();
  await set({ gain: "none" });
  await card.locator(".settings .complaint", { hasText: "Gain is a number" }).waitFor({ state: "visible", timeout });
  await set({ gain: "1.9" });
  await says("outcome", "applied");
  await wait(page, ([id, before]) => Number(document.querySelector(`[data-testid=${id}]`).textContent.match(/level (\d+)/)[1]) > 1.3 * before, [`camera-${camera}-effect`, before]);
  await set({ exposure_us: "900" });
  await says("outcome", "keeps what it had: an exposure of 900 ms does not fit");
  await screenshot(page, "settings");
  await page.keyboard.press("l");
  await screenshot(page, "settings-light");
  await page.keyboard.press("l");
  await set({ exposure_us: "", gain: "" });
  await says("outcome", "the camera's own file");
  await card.locator(".enlarge").click();
}

const TABS = ["objects", "plots", "health", "measure", "zones"];
const tab = (page, key) => page.click(`[data-testid=tab-${key}]`);

/** Each chart of figures has points, the cursor reads them out, a held chart stands still, and files can be had. */
async function checkPlots(page) {
  await tab(page, "plots");
  const filled = ["position", "attitude", "sigma_mm", "sigma_deg", "pose_ms", "image_ms", "stage_ms", "rate_hz", "residual_px"];
  await wait(page, (ids) => ids.every((id) => Number(document.querySelector(`[data-testid=chart-${id}]`).dataset.points) > 5), filled);
  await page.click("[data-testid=plots-window-10]");
  await page.click("[data-testid=plots-pause]");
  const readOut = () => page.locator("[data-testid=chart-position] .u-legend").innerText();
  await page.waitForTimeout(300);
  const newest = await readOut();
  await page.locator("[data-testid=chart-position] .u-over").hover({ position: { x: 220, y: 40 } });
  assert((await readOut()) !== newest, `the cursor reads out nothing: ${newest}`);
  await screenshot(page, "plots");
  const [file] = await Promise.all([page.waitForEvent("download", { timeout }), page.click("[data-testid=plots-csv-object]")]);
  const [head, ...rows] = (await readFile(await file.path(), "utf8")).trim().split("\n");
  assert(head.startsWith("t_s,x_m,y_m,z_m,") && rows.length > 20, `the file has ${rows.length} rows below "${head}"`);
  assert(rows.every((row) => row.split(",").length === head.split(",").length), "the file's rows differ in length");
  await page.click("[data-testid=plots-pause]");
}

/** Held, the table stands still and shows another time; it runs on; live again, it is the present. */
async function checkTimeline(page) {
  await tab(page, "objects");
  await page.keyboard.press(",");
  await wait(page, () => document.body.dataset.replaying === "true");
  // The table follows the time a few times a second.
  await page.waitForTimeout(500);
  const held = await shownPositions(page);
  await page.waitForTimeout(500);
  assert(JSON.stringify(held) === JSON.stringify(await shownPositions(page)), "the table moves while the time is held");
  await page.keyboard.press("k");
  await changes(page, "the replayed table", shownPositions);
  await page.locator("[data-testid=timeline-slider]").focus();
  const shown = await drawnPositions(page);
  await page.keyboard.press("Home");
  await changes(page, "the replayed scene", drawnPositions, shown);
  await screenshot(page, "replay");
  await page.click("[data-testid=timeline-live]");
  await wait(page, () => document.body.dataset.replaying === "false");
  await changes(page, "the present table", shownPositions);
}

/** Arrows turn the view, + and - go nearer and away, whatever is drawn meanwhile. */
async function checkView(page) {
  await page.click("[data-testid=timeline] [data-moving]");
  try {
    await checkKeysOfView(page);
  } finally {
    await page.click("[data-testid=timeline-live]");
  }
}

async function checkKeysOfView(page) {
  const where = () => page.evaluate(() => window.sextant.screen(Object.keys(window.sextant.positions())[0]));
  await page.locator("canvas[data-testid=stage]").focus();
  await wait(page, () => document.body.dataset.replaying === "true");
  const eye = () => page.evaluate(() => window.sextant.eye());
  const far = (a, b) => Math.hypot(...a.map((value, index) => value - b[index]));
  // What was drawn last of the present gives way, on a busy machine after a while.
  let first = await where();
  for (const until = Date.now() + timeout; Date.now() < until; ) {
    await page.waitForTimeout(700);
    const now = await where();
    const isStill = far(first, now) < 0.01;
    first = now;
    if (isStill) break;
  }
  const from = await eye();
  for (const key of ["ArrowLeft", "ArrowUp"]) {
    const before = await eye();
    await page.keyboard.press(key);
    assert(far(before, await eye()) > 0.01, `${key} does not turn the view`);
  }
  for (const key of ["ArrowRight", "ArrowDown"]) await page.keyboard.press(key);
  const back = await eye();
  assert(far(from, back) < 0.01, `arrows turn back to ${back}, not ${from}`);
  await page.keyboard.press("+");
  const near = await where();
  await page.keyboard.press("-");
  assert(near[2] > 1.05 * first[2] && Math.abs((await where())[2] - first[2]) < 1, "+ and - do not zoom");
  await page.keyboard.press("r");
}

/**
 * A click on an object follows it: it fills the stage and stays where it is on the screen; Escape brings the view back.
 */
async function checkFollow(page) {
  // The object moves, and may pass behind a camera: a click that came too late is made again.
  const chosen = () => page.evaluate(() => window.sextant.selection.object);
  for (const until = Date.now() + timeout; (await chosen()) === null && Date.now() < until; ) {
    const place = await page.evaluate(() => window.sextant.screen(Object.keys(window.sextant.positions())[0]));
    await page.mouse.click(place[0], place[1]);
    await page.waitForTimeout(200);
    if (await page.evaluate(() => window.sextant.selection.camera !== null)) await page.keyboard.press("Escape");
  }
  const followed = await chosen();
  assert(followed !== null, "no click reaches the object");
  const where = () => page.evaluate((id) => window.sextant.screen(id), followed);
  const reaches = (least, most) =>
    wait(page, ([id, least, most]) => {
      const { width, height } = document.querySelector("canvas[data-testid=stage]").getBoundingClientRect();
      const share = (2 * window.sextant.screen(id)[2]) / Math.min(width, height);
      return share > least && share < most;
    }, [followed, least, most]);
  await reaches(0.45, 0.65);
  await page.waitForTimeout(1000);
  const before = await where();
  await changes(page, "the followed object", drawnPositions);
  await page.waitForTimeout(300);
  const after = await where();
  assert(Math.hypot(after[0] - before[0], after[1] - before[1]) < 3, `the followed object moved from ${before} to ${after}`);
  await page.click("[data-testid=tool-sigma]");
  await screenshot(page, "follow");
  await page.click("[data-testid=tool-sigma]");
  await page.keyboard.press("Escape");
  assert((await chosen()) === null, "Escape does not leave the object");
  await reaches(0, 0.3);
}

/** Through a camera's eye the tags lie where the poses put them. */
async function checkEye(page) {
  await page.locator("[data-testid$=-eye]").first().click();
  await wait(page, () => Number(document.querySelector("[data-testid=eye]").dataset.tags) > 0);
  await wait(page, () => /residual \d/.test(document.querySelector("[data-testid=eye-residual]").textContent));
  const residual = Number((await page.textContent("[data-testid=eye-residual]")).match(/[\d.]+/)[0]);
  assert(residual < 15, `the projected tags lie ${residual} px off`);
  await screenshot(page, "eye");
  await page.click("[data-testid=eye-close]");
}

async function checkMeasure(page) {
  await tab(page, "measure");
  await page.click("[data-testid=measure-toggle]");
  await wait(page, () => /^[\d.]+ ± [\d.]+ mm$/.test(document.querySelector("[data-testid=measure-distance]").textContent));
  await changes(page, "the distance", (page) => page.textContent("[data-testid=measure-distance]"));
  await page.locator(".label-ruler").waitFor({ state: "visible", timeout });
  await screenshot(page, "measure");
  await page.click("[data-testid=measure-toggle]");
}

/**
 * A zone where the objects are fills; one around an object is left by it, and drawn; nonsense is complained about;
 * zones go again.
 */
async function checkZones(page) {
  await tab(page, "zones");
  const fill = async (name, size, centre = "0, 0, 0.2") => {
    await page.fill("[data-testid=wizard-field-name]", name);
    await page.fill("[data-testid=wizard-field-centre]", centre);
    await page.fill("[data-testid=wizard-field-size]", size);
    await page.click("[data-testid=zone-set]");
  };
  await fill("room", "-1");
  await wait(page, () => document.querySelector("[data-testid=wizard-complaint-size]").textContent !== "");
  await fill("room", "3");
  await wait(page, () => document.querySelector("[data-testid=zone-room]")?.dataset.inside !== "");
  const [object] = await page.evaluate(() => Object.values(window.sextant.positions()));
  await fill("middle", "0.12, 0.12, 0.12", object.map((value) => value.toFixed(3)).join(", "));
  await wait(page, () => document.querySelector("[data-testid=zones-events] [data-event]") !== null);
  await wait(page, () => [...document.querySelectorAll(".label-zone")].some((label) => label.textContent === "middle"));
  await screenshot(page, "zones");
  for (const name of ["room", "middle"]) {
    await page.click(`[data-testid=zone-${name}] [data-testid=zone-remove]`);
    await page.locator(`[data-testid=zone-${name}]`).waitFor({ state: "detached", timeout });
  }
}

/**
 * A site that works is called healthy; what may be improved opens its wizard with the form filled in; faults can be
 * noted.
 */
async function checkHealth(page) {
  await page.locator("[data-testid=notices-open][data-condition=healthy]").waitFor({ state: "visible", timeout });
  await page.click("[data-testid=notices-open]");
  await page.locator("[data-testid=health-well]").waitFor({ state: "visible", timeout });
  await screenshot(page, "health");
  const learn = page.locator("[data-testid=health-learn]").first();
  await learn.waitFor({ state: "visible", timeout });
  const object = await learn.locator("xpath=ancestor::section/h3").textContent();
  await learn.click();
  const name = await page.inputValue("[data-testid=wizard-field-id]");
  assert(object === `object ${name}`, `the wizard about ${object} is about ${name}`);
  assert(/^\d/.test(await page.inputValue("[data-testid=wizard-field-tags]")), "the wizard knows none of the object's tags");
  await page.click("[data-testid=wizard-close]");
  const fault = { key: "made-up", severity: "fault", subject: { kind: "node", id: "test" }, cause: "made up", remedy: "", action: null };
  const open = (fault) => page.evaluate((fault) => (window.sextant.site.health.take([fault], Date.now() / 1000), window.sextant.site.health.open), fault);
  assert((await open(fault)) === 1, "a fault does not count");
  await page.locator("[data-testid=health-acknowledge]").first().click();
  assert((await open(fault)) === 0, "a noted fault still wants attention");
}

async function checkAxe(page, what) {
  const found = await barriers(page);
  assert(found.length === 0, `${what}: ${found.join("; ")}`);
}

/** Contrast and names of everything, light and dark, by axe. */
async function checkAccessible(page, keys) {
  for (const theme of ["light", "dark"]) {
    await page.evaluate((theme) => document.documentElement.dataset.theme !== theme && document.querySelector("[data-testid=theme]").click(), theme);
    for (const key of keys) {
      await tab(page, key);
      await checkAxe(page, `${key}, ${theme}`);
    }
    await page.click("[data-testid=wizard-open]");
    await checkAxe(page, `wizard, ${theme}`);
    await page.click("[data-testid=wizard-close]");
  }
}

/** Keys, the list of them, and light and dark. */
async function checkKeys(page) {
  await page.keyboard.press("?");
  await page.locator("[data-testid=shortcuts]").waitFor({ state: "visible", timeout });
  await screenshot(page, "keys");
  await page.keyboard.press("Escape");
  const theme = () => page.evaluate(() => [document.documentElement.dataset.theme, getComputedStyle(document.body).backgroundColor].join());
  const before = await theme();
  await page.keyboard.press("l");
  assert((await theme()) !== before, `the theme stays ${before}`);
  await page.keyboard.press("1");
  await screenshot(page, "light");
  await page.keyboard.press("l");
  assert((await theme()) === before, "the theme does not come back");
}

/** On a wall nothing can be pressed, and everything is seen. */
async function checkKiosk(browser) {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  await page.goto(`${url}?kiosk`);
  await checkObjects(page);
  const buttons = await page.$$eval("button", (buttons) => buttons.filter((button) => button.checkVisibility() && !button.classList.contains("enlarge") && !button.closest("tbody")).map((button) => button.textContent));
  assert(buttons.length === 0, `buttons are left: ${buttons.join(", ")}`);
  await screenshot(page, "kiosk");
  await page.close();
}

/** The stage is as large whatever is shown below it. */
async function checkTabs(page) {
  const heights = [];
  for (const key of TABS) {
    await tab(page, key);
    heights.push((await page.locator("canvas[data-testid=stage]").boundingBox()).height);
  }
  assert(new Set(heights).size === 1, `the stage's heights are ${heights}`);
}

/** No label lies over another, and each of an object lies at it, however often one looks. */
async function checkLabels(page) {
  for (let look = 0; look < 20; look++) {
    const overlaps = await page.evaluate(() => {
      const boxes = [...document.querySelectorAll(".label")].filter((label) => !label.hidden).map((label) => ({ text: label.textContent, ...label.getBoundingClientRect().toJSON() }));
      const over = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
      return boxes.flatMap((a, at) => boxes.slice(at + 1).filter((b) => over(a, b)).map((b) => `${a.text} and ${b.text}`));
    });
    assert(overlaps.length === 0, `labels overlap: ${overlaps.join(", ")}`);
    const astray = await page.evaluate(() =>
      [...document.querySelectorAll(".label-object")].filter((label) => !label.hidden).flatMap((label) => {
        const { left, right, top, bottom } = label.getBoundingClientRect();
        const [x, y, reach] = window.sextant.screen(label.textContent.split(" ")[0]);
        const away = Math.hypot(Math.max(left - x, 0, x - right), Math.max(top - y, 0, y - bottom));
        return away > reach + 30 ? [`${label.textContent} by ${Math.round(away)} px`] : [];
      }),
    );
    assert(astray.length === 0, `labels lie away from their objects: ${astray.join(", ")}`);
    await page.waitForTimeout(100);
  }
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
  await checkLabels(page);
  for (const key of TABS) {
    await tab(page, key);
    await page.waitForTimeout(300);
    const wide = await page.evaluate(() => {
      const beyond = [...document.querySelectorAll("body *")].filter((each) => each.checkVisibility() && !each.closest(".labels, .tabs, svg, .uplot, thead") && each.getBoundingClientRect().right > 391);
      return [document.documentElement.scrollWidth, ...beyond.map((each) => `${each.tagName}.${each.className}`)];
    });
    assert(wide[0] <= 390 && wide.length === 1, `on a phone of 390 px, ${key} reaches to ${wide.join(", ")}`);
    await screenshot(page, `phone-${key}`);
  }
  await checkAxe(page, "a phone");
  await page.locator(".enlarge").first().click();
  await page.locator(".settings").first().waitFor({ state: "visible", timeout });
  assert((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390, "on a phone the settings of a camera are too wide");
  await screenshot(page, "phone-settings");
  await context.close();
}

async function screenshot(page, name) {
  if (!options.screenshots) return;
  await mkdir(options.screenshots, { recursive: true });
  await page.screenshot({ path: join(options.screenshots, `${name}.png`), fullPage: name.startsWith("phone") });
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
  await check("a camera's gain is set, and refused where it cannot be", () => checkSettings(page));
  await check("labels never overlap and lie at their objects", () => checkLabels(page));
  await check("the stage does not jump between tabs", () => checkTabs(page));
  await check("figures are plotted over time and saved", () => checkPlots(page));
  await check("the time line goes back and forth", () => checkTimeline(page));
  await check("keys turn the view and go nearer", () => checkView(page));
  await check("a clicked object is followed", () => checkFollow(page));
  await check("a camera can be looked through", () => checkEye(page));
  await check("objects are measured", () => checkMeasure(page));
  await check("zones are set, filled and removed", () => checkZones(page));
  await check("a site that works is called healthy, and its notices open their wizards", () => checkHealth(page));
  await check("axe finds nothing wrong, light and dark", () => checkAccessible(page, TABS));
  await check("keys do what they say", () => checkKeys(page));
  await check("a kiosk has no buttons", () => checkKiosk(browser));
  if (options.restart) await check("it reconnects after the bridge restarts", () => checkReconnect(page));
  await check("a phone shows it all without scrolling sideways", () => checkPhone(browser));
  await check("no script failed", () => assert(errors.length === 0, errors.join("; ")));
  await check("nothing was asked of another host", () => assert(elsewhere.length === 0, elsewhere.join(" ")));
} finally {
  await browser.close();
}
console.log(JSON.stringify(results));
process.exit(Object.values(results).every(Boolean) ? 0 : 1);
