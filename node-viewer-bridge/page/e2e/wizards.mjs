// Calibrates a running site from its page, as a person would, in headless Chromium:
//
//     node e2e/wizards.mjs URL [--lens CAMERA --board COLUMNS,ROWS,MM,FIRST] [--carried OBJECT]
//                              [--learn OBJECT --tags TAGS --size MM] [--enough 0.9] [--screenshots DIR]
//                              [--timeout SECONDS]
//
// Each wizard that is named runs from its form to the kept result; what has to move is moved by somebody else. A second
// browser joins late and must see the same. Writes a line per check on stderr, one JSON line on stdout; exit code 1
// when a check failed, 2 for wrong usage.

import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { launch } from "./chromium.mjs";

const text = { type: "string" };
const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    lens: text,
    board: text,
    carried: text,
    learn: text,
    tags: text,
    size: text,
    enough: { type: "string", default: "0.9" },
    screenshots: text,
    timeout: { type: "string", default: "60" },
  },
});
const [url] = positionals;
const [timeout, enough] = [Number(options.timeout) * 1000, Number(options.enough)];
if (!url || !(timeout > 0) || !(enough > 0)) {
  console.error("usage: see the head of e2e/wizards.mjs");
  process.exit(2);
}

const results = {};

async function check(name, action) {
  const begun = Date.now();
  try {
    results[name] = (await action()) ?? true;
    console.error(`ok   ${name} (${Date.now() - begun} ms)`);
  } catch (error) {
    results[name] = false;
    console.error(`FAIL ${name}: ${error.message.split("\n")[0]}`);
    throw error;
  }
}

function assert(condition, message) {
  if (!condition) throw new Error(message);
}

const part = (page, name) => page.locator(`[data-testid=wizard-${name}]`);
const field = (page, name) => part(page, `field-${name}`);
const wait = (page, condition, argument) => page.waitForFunction(condition, argument, { timeout, polling: 50 });
const stage = (page, ...wanted) =>
  wait(page, (wanted) => wanted.includes(document.querySelector("[data-testid=wizard]").dataset.stage), wanted);
const textOf = async (page, name) => (await part(page, name).textContent()).trim();

/** Waits for a stage; a complaint that comes instead is the failure. */
async function becomes(page, wanted) {
  await wait(page, (wanted) => {
    const wizard = document.querySelector("[data-testid=wizard]");
    return wizard.dataset.stage === wanted || wizard.querySelector("[data-testid=wizard-cause]").textContent !== "";
  }, wanted);
  const cause = await textOf(page, "cause");
  assert(cause === "", `not ${wanted}: ${cause}`);
}

async function screenshot(page, name) {
  if (!options.screenshots) return;
  await mkdir(options.screenshots, { recursive: true });
  await page.screenshot({ path: join(options.screenshots, `${name}.png`) });
}

/** Chooses an option that comes when the site is known. */
async function choose(page, name, value) {
  await wait(page, ([name, value]) => [...document.querySelector(`[data-testid=wizard-field-${name}]`).options].some((o) => o.value === value), [name, value]);
  await field(page, name).selectOption(value);
}

/** Pixels were drawn on a canvas. */
const isDrawn = (page, selector) =>
  wait(page, (selector) => {
    const canvas = document.querySelector(selector);
    if (!canvas || canvas.width < 2) return false;
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.some((value, at) => at % 4 === 3 && value > 0);
  }, selector);

/** From the pressed start to what is kept; `look` checks what is shown on the way, `judge` the result. */
async function run(page, name, { look, judge }) {
  await part(page, "start").click();
  await stage(page, "collecting");
  await wait(page, (enough) => document.querySelector("[data-testid=wizard-progress]").value >= Math.min(0.4, enough), enough);
  assert((await textOf(page, "hint")).length > 10, "no hint");
  await look();
  await screenshot(page, `${name}-collecting`);
  await wait(page, (enough) => document.querySelector("[data-testid=wizard-progress]").value >= enough, enough);
  await part(page, "solve").click();
  await becomes(page, "solved");
  await judge();
  const verdict = await textOf(page, "verdict");
  await screenshot(page, `${name}-solved`);
  await part(page, "keep").click();
  await becomes(page, "kept");
  const kept = await page.locator("[data-testid=wizard-kept] li").allTextContents();
  assert(kept.length > 0, "nothing is said of where it was kept");
  await screenshot(page, `${name}-kept`);
  await part(page, "discard").click();
  await stage(page, "idle");
  return { verdict, kept };
}

async function lens(page) {
  await part(page, "choose-lens").click();
  const [columns, rows, size, first] = options.board.split(",");
  await choose(page, "camera", options.lens);
  await field(page, "columns").fill("0");
  await part(page, "start").click();
  await part(page, "complaint-columns").waitFor({ timeout });
  for (const [name, value] of Object.entries({ columns, rows, size_m: size, first })) await field(page, name).fill(value);
  return run(page, "lens", {
    look: () => isDrawn(page, "[data-testid=wizard-map]"),
    judge: async () => {
      assert((await page.locator("[data-testid=wizard-figure-fx]").count()) === 1, "no figures of the lens");
      for (const map of ["sigmas", "coverage", "residuals"]) {
        await part(page, `choose-${map}`).click();
        await isDrawn(page, `[data-testid=wizard-map][data-shows=${map}]`);
        await screenshot(page, `lens-${map}`);
      }
    },
  });
}

async function rig(page) {
  await part(page, "choose-rig").click();
  await choose(page, "object", options.carried);
  const cameras = await page.evaluate(() => [...window.sextant.site.cameras.keys()]);
  return run(page, "rig", {
    look: () => wait(page, (count) => document.querySelectorAll("[data-testid=wizard-graph] circle").length === count, cameras.length),
    judge: async () => {
      for (const camera of cameras) assert((await page.locator(`[data-testid=wizard-figure-${camera}]`).count()) === 1, `no figures of ${camera}`);
      await isDrawn(page, "[data-testid=wizard-constellation]");
    },
  });
}

async function learn(page) {
  await part(page, "choose-learn").click();
  await field(page, "id").fill("No Name");
  await field(page, "tags").fill("3, x");
  await part(page, "start").click();
  await part(page, "complaint-tags").waitFor({ timeout });
  await field(page, "tags").fill(options.tags);
  await field(page, "size_m").fill(options.size);
  await part(page, "start").click();
  await part(page, "complaint-id").waitFor({ timeout });
  await field(page, "id").fill(options.learn);
  return run(page, "learn", {
    look: async () => {
      await wait(page, () => Number(document.querySelector("[data-testid=wizard-constellation]").dataset.tags) >= 2);
      await isDrawn(page, "[data-testid=wizard-constellation]");
      await joinsLate(page);
    },
    judge: async () => assert((await page.locator("[data-testid=wizard-figures] tbody tr").count()) > 1, "no figures of the tags"),
  });
}

/** Another browser sees the wizard that is at work, and may not begin another. */
async function joinsLate(page) {
  const context = await page.context().browser().newContext({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const late = await context.newPage();
  await late.goto(url);
  await part(late, "open").click();
  await stage(late, "collecting");
  await wait(late, () => Number(document.querySelector("[data-testid=wizard-constellation]").dataset.tags) >= 2);
  const width = await late.evaluate(() => document.documentElement.scrollWidth);
  assert(width <= 390, `the wizard is ${width} px wide on a phone of 390 px`);
  const refused = await late.evaluate(async () => {
    const body = JSON.stringify({ do: "start", wizard: "rig", object: { known: "any" }, origin: "as_it_is" });
    const answer = await fetch("api/wizard", { method: "POST", headers: { "content-type": "application/json" }, body });
    return answer.status;
  });
  assert(refused === 409, `a second wizard was answered ${refused}`);
  if (options.screenshots) await late.screenshot({ path: join(options.screenshots, "learn-phone.png"), fullPage: true });
  await context.close();
}

const browser = await launch();
try {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  await check("the wizards open", async () => {
    await page.goto(url, { timeout });
    await part(page, "open").click();
    await screenshot(page, "open");
  });
  if (options.lens) await check("a lens is found and kept", () => lens(page));
  if (options.carried) await check("a rig is found and kept", () => rig(page));
  if (options.learn) await check("an object is learned and kept", () => learn(page));
  await check("no script failed", () => assert(errors.length === 0, errors.join("; ")));
} catch {
  // Said above.
} finally {
  await browser.close();
}
console.log(JSON.stringify(results));
process.exit(Object.values(results).every(Boolean) ? 0 : 1);
