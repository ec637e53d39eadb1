// Makes the moving picture of the README: the page of a recording that is played slowly, frame by frame, in headless
// Chromium.
//
//     cargo demo --record site.mcap --images --duration 24
//     sextant play site.mcap --from 8 --speed 0.1 --no-browser
//     node dev/film.mjs http://127.0.0.1:8600 page.webp --speed 0.1
//
// It is played slowly, so that drawing by software keeps up. The film shows one turn of the demo's objects, and begins
// where it ends. Needs ffmpeg with libwebp.

import { spawnSync } from "node:child_process";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { launch } from "../e2e/chromium.mjs";

const text = (value) => ({ type: "string", default: value });
const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { speed: text("0.1"), seconds: text("7.5"), fps: text("10"), quality: text("50") },
});
const [url, file] = positionals;
if (!file) {
  console.error("usage: node dev/film.mjs URL FILE.webp [--speed 0.1] [--seconds 7.5] [--fps 10] [--quality 50]");
  process.exit(2);
}
const [speed, seconds, fps] = [options.speed, options.seconds, options.fps].map(Number);
const n_frames = Math.round(seconds * fps);
const VIEWPORT = { width: 1190, height: 720 };
const WIDTH = 900;
/** The film is this much faster than the site was, to be short. */
const HASTE = 1.25;
/** Trails reach back this far, in seconds of the site. */
const TRAIL_S = 4;
/** How far the view swings and back, pixels of a dragging mouse. */
const SWING = -24;
/** Clicks of a wheel by which the view comes closer. */
const ZOOM_STEPS = 3;

const folder = await mkdtemp(join(tmpdir(), "film-"));
const browser = await launch();
try {
  const page = await browser.newPage({ viewport: VIEWPORT, colorScheme: "dark", reducedMotion: "reduce" });
  // The page's clock is as slow as the recording, so that it counts the rates that were; it draws about once a frame of
  // the film.
  await page.addInitScript((speed) => {
    const now = performance.now.bind(performance);
    performance.now = () => now() * speed;
    const draw = requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (callback) =>
      setTimeout(() => draw((time) => callback(time * speed)), 200);
  }, speed);
  await page.goto(`${url}?kiosk`);
  await page.waitForFunction(() => Object.keys(window.sextant?.positions() ?? {}).length > 0, null, { timeout: 60_000 });
  const stage = await page.locator("canvas[data-testid=stage]").boundingBox();
  const [x, y] = [stage.x + stage.width * 0.5, stage.y + stage.height * 0.2];
  await page.mouse.move(stage.x + stage.width * 0.46, stage.y + stage.height * 0.6);
  for (let step = 0; step < ZOOM_STEPS; step++) await page.mouse.wheel(0, -100);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.waitForTimeout((1000 * TRAIL_S) / speed);
  const begun = Date.now();
  for (let frame = 0; frame < n_frames; frame++) {
    const due = begun + (frame * 1000) / fps / speed;
    await page.mouse.move(x + (SWING / 2) * (1 - Math.cos((2 * Math.PI * frame) / n_frames)), y);
    await page.waitForTimeout(Math.max(0, due - Date.now()));
    await page.screenshot({ path: join(folder, `${String(frame).padStart(4, "0")}.png`) });
    if (Date.now() > due + 1000 / fps / speed) console.error(`frame ${frame} is late: play more slowly`);
  }
  await page.mouse.up();
} finally {
  await browser.close();
}
const made = spawnSync(
  "ffmpeg",
  ["-y", "-v", "error", "-framerate", String(fps * HASTE), "-i", join(folder, "%04d.png"), "-vf", `scale=${WIDTH}:-2:flags=lanczos`]
    .concat(["-c:v", "libwebp_anim", "-loop", "0", "-quality", options.quality, "-compression_level", "6", file]),
  { stdio: "inherit" },
);
await rm(folder, { recursive: true });
process.exit(made.status ?? 1);
