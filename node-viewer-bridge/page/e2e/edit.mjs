// Edits a running site on its page, as a person would, in headless Chromium:
//
//     node e2e/edit.mjs URL --camera CAMERA --object OBJECT --taken TAG [--screenshots DIR] [--timeout SECONDS]
//
// Moves the camera by 5 cm along x, is refused a wrong one, takes the move back and makes it again; gives the object's
// first tag a size of 55 mm, and is refused TAG, which another object has; a second browser that edits the same camera
// hears that its version is old. Writes a line per check on stderr; exit code 1 when a check failed, 2 for wrong usage.

import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { barriers } from "./axe.mjs";
import { check, end } from "./checks.mjs";
import { launch } from "./chromium.mjs";

const text = { type: "string" };
const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { camera: text, object: text, taken: text, screenshots: text, timeout: { type: "string", default: "30" } },
});
const [url] = positionals;
const timeout = Number(options.timeout) * 1000;
const { camera, object, taken, screenshots } = options;
if (!url || !camera || !object || !taken || !(timeout > 0)) {
  console.error("usage: see the head of e2e/edit.mjs");
  process.exit(2);
}

function assert(condition, message) {
  if (!condition) throw new Error(message);
}

const box = (page, name) => page.locator(`[data-testid=edit-${name}]`);
const visible = (locator) => locator.waitFor({ state: "visible", timeout });

async function says(page, part, words) {
  const found = box(page, part).filter({ hasText: words });
  await visible(found).catch(async () => {
    const cause = await box(page, "cause").innerText();
    throw new Error(`${part} says "${await box(page, part).innerText()}", not "${words}"; ${cause}`);
  });
}

async function screenshot(page, name) {
  if (screenshots) await page.screenshot({ path: join(screenshots, `${name}.png`) });
}

async function openCamera(page) {
  await page.click(`[data-testid=camera-${camera}-edit]`, { timeout });
  await visible(box(page, "position-x"));
}

const shownX = async (page) => Number(await box(page, "position-x").inputValue());
const inForce = (page) => {
  const x = (camera) => window.sextant.site.cameras.get(camera).model.world_from_camera.position[0];
  return page.evaluate(x, camera);
};

async function waitForX(page, expected) {
  const end = Date.now() + timeout;
  while (Math.abs((await inForce(page)) - expected) > 1e-6) {
    assert(Date.now() < end, `the camera stands at x = ${await inForce(page)}, not ${expected}`);
    await page.waitForTimeout(100);
  }
}

async function move(page, by) {
  const x = (await shownX(page)) + by;
  await box(page, "position-x").fill(String(x));
  await box(page, "apply").click();
  await says(page, "outcome", "In force on fusion node");
  await waitForX(page, x);
}

const browser = await launch();
if (screenshots) await mkdir(screenshots, { recursive: true });
const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
await page.goto(url);

let before = 0;
await check("a camera's pose is applied", async () => {
  await openCamera(page);
  before = await inForce(page);
  await move(page, 0.05);
  assert(Math.abs((await shownX(page)) - before - 0.05) < 1e-5, "the form does not show the pose in force");
  await screenshot(page, "camera-applied");
});

await check("the editor has no barriers", async () => {
  const found = await barriers(page);
  assert(found.length === 0, found.join("; "));
});

await check("a wrong value is refused with its cause", async () => {
  await box(page, "position-x").fill("wide");
  await box(page, "apply").click();
  await says(page, "position", "is a number, not “wide”");
  await box(page, "position-x").fill("1e9");
  await box(page, "apply").click();
  await says(page, "position", "coordinates are numbers up to");
  await box(page, "close").click();
  await openCamera(page);
});

await check("the change is taken back and made again", async () => {
  await visible(box(page, "revert"));
  await box(page, "revert").click();
  await waitForX(page, before);
  await says(page, "outcome", "taken back");
  await move(page, 0.05);
});

await check("an edit of an old version says so", async () => {
  const other = await browser.newPage({ viewport: { width: 390, height: 844 } });
  await other.goto(url);
  await openCamera(other);
  await box(other, "position-y").fill("0.123");
  await box(page, "sigma-position").fill("2");
  await box(page, "sigma-angle").fill("0.1");
  await box(page, "apply").click();
  await says(page, "outcome", "In force on fusion node");
  await says(other, "newer", "a newer version is in force");
  await box(other, "apply").click();
  await says(other, "cause", "A newer version of camera");
  await screenshot(other, "camera-newer");
  await box(other, "load").click();
  assert((await box(other, "sigma-position").inputValue()) === "2", "the newer version is not loaded");
  await other.close();
});

await check("an object's tag is edited, and a tag of another object is refused", async () => {
  await box(page, "close").click();
  await page.click(`[data-testid=object-${object}-edit]`);
  await box(page, "tags").locator("[data-testid$=-size]").first().fill("55");
  await box(page, "apply").click();
  await says(page, "outcome", "In force on fusion node");
  await box(page, "add-tag").click();
  await box(page, "tags").locator("[data-testid$=-id]").last().fill(taken);
  await box(page, "apply").click();
  await says(page, "tags", "print another id");
  await screenshot(page, "object-refused");
});

await browser.close();
end();
