// Makes headless Chromiums cameras of a running bridge's site, each with a film in the place of a webcam, and reports
// what they cost:
//
//     node e2e/phones.mjs URL FILM... [--seconds N] [--size WxH] [--apart MS] [--timeout SECONDS]
//
// A camera is named after its film (`sextant-examine phones film` renders some). Films begin at random times at most
// --apart apart (default 50), by what the browsers say of their first images. Writes a row per camera at the start,
// each minute and at the end: JavaScript heap after a collection and resident memory of the page's process in MB, and
// what the page says. CHROMIUM names the browser (default /usr/bin/chromium).
//
// Chromium shows every image of a film: one that is played late stays late, and its camera's clock goes wrong. So keep
// films in memory (/dev/shm). The processes that play them (a twentieth of a core each) get a real-time priority where
// the user may give one; `sextant-examine phones clocks` says whether films kept pace.

import { spawnSync } from "node:child_process";
import { readFile } from "node:fs/promises";
import { basename, resolve } from "node:path";
import { parseArgs } from "node:util";
import { launch } from "./chromium.mjs";

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    seconds: { type: "string", default: "60" },
    size: { type: "string", default: "1280x720" },
    apart: { type: "string", default: "50" },
    timeout: { type: "string", default: "60" },
  },
});
const [url, ...films] = positionals;
const [seconds, apartMs, timeoutS] = [options.seconds, options.apart, options.timeout].map(Number);
if (!url || films.length === 0 || !(seconds > 0 && apartMs >= 0 && timeoutS > 0)) {
  console.error("usage: node e2e/phones.mjs URL FILM... [--seconds N] [--size WxH] [--apart MS] [--timeout SECONDS]");
  process.exit(2);
}
const ATTEMPTS = 20;
const FILM_PLAYER = "video_capture.mojom.VideoCaptureService";
const FACTS = ["rate", "detection", "clock", "sent"];
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

async function open(film) {
  const browser = await launch(["--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream", `--use-file-for-fake-video-capture=${resolve(film)}`]);
  const page = await browser.newPage({ viewport: { width: 412, height: 915 } });
  page.setDefaultTimeout(timeoutS * 1000);
  page.on("pageerror", (error) => console.error(error.message));
  await page.goto(new URL("camera", url).href);
  const name = basename(film).split(".")[0];
  await page.fill("input[name=camera]", name);
  await page.selectOption("select[name=size]", options.size.replace("x", " × "));
  return { name, browser, page, delayMs: 0 };
}

/** Starts the camera at a time in ms since the epoch; when its film began, by the same clock. */
const start = (phone, atMs) =>
  phone.page.evaluate(async (atMs) => {
    const now = () => performance.timeOrigin + performance.now();
    await new Promise((done) => setTimeout(done, atMs - now()));
    document.querySelector("[data-testid=start]").click();
    const video = document.querySelector("video");
    const { captureTime, mediaTime } = await new Promise((done) => video.requestVideoFrameCallback((_, metadata) => done(metadata)));
    return performance.timeOrigin + captureTime - mediaTime * 1000;
  }, atMs);

async function startAll(phones) {
  for (let attempt = 0; attempt < ATTEMPTS; attempt++) {
    const wantedMs = Date.now() + 3000;
    const offsets = phones.map(() => apartMs * Math.random());
    const began = await Promise.all(phones.map((phone, k) => start(phone, wantedMs + offsets[k] - phone.delayMs)));
    await Promise.all(phones.map(keepPace));
    const spreadMs = Math.max(...began) - Math.min(...began);
    // The first attempt tells how long each browser takes to open its camera.
    if (attempt > 0 && spreadMs <= apartMs) return began;
    phones.forEach((phone, k) => (phone.delayMs += began[k] - wantedMs - offsets[k]));
    await Promise.all(phones.map(({ page }) => page.click("[data-testid=stop]")));
    await sleep(1000);
  }
  throw new Error(`films do not begin within ${apartMs} ms of each other`);
}

/** Processes of a browser of a type, the busiest first. */
async function processes({ browser }, wanted) {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  await session.detach();
  const found = processInfo.filter(({ type }) => type === wanted).sort((a, b) => b.cpuTime - a.cpuTime);
  return found.map(({ id }) => id);
}

/** Films keep their pace on a busy machine. Threads that these processes make later have the same priority. */
async function keepPace(phone) {
  for (const id of await processes(phone, FILM_PLAYER)) spawnSync("chrt", ["--all-tasks", "--rr", "--pid", "1", String(id)]);
}

/** Megabytes of the process that runs the page. */
async function residentMb(phone) {
  const [renderer] = await processes(phone, "renderer");
  const status = await readFile(`/proc/${renderer}/status`, "utf8");
  return Number(/VmRSS:\s+(\d+)/.exec(status)[1]) / 1024;
}

async function heapMb({ page }) {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize } = await session.send("Runtime.getHeapUsage");
  await session.detach();
  return usedSize / 2 ** 20;
}

const facts = ({ page }) => page.evaluate((names) => names.map((name) => document.querySelector(`[data-fact=${name}] dd`)?.textContent ?? "-"), FACTS);

async function report(phones, afterS) {
  for (const phone of phones) {
    const figures = [await heapMb(phone), await residentMb(phone)].map((mb) => mb.toFixed(2));
    console.log([String(afterS).padStart(5), phone.name, ...figures, ...(await facts(phone))].join("\t"));
  }
}

const phones = await Promise.all(films.map(open));
const began = await startAll(phones);
const first = Math.min(...began);
console.log(`films began after ${began.map((at, k) => `${phones[k].name} ${(at - first).toFixed(1)}`).join(", ")} ms`);
await Promise.all(phones.map(({ page }) => page.waitForSelector("[data-testid=link][data-condition=joined]")));
console.log(["    s", "camera", "heap", "resident", ...FACTS].join("\t"));
const startedMs = Date.now();
for (let afterS = Math.min(5, seconds); ; afterS = Math.min(seconds, afterS < 60 ? 60 : afterS + 60)) {
  await sleep(startedMs + afterS * 1000 - Date.now());
  await report(phones, afterS);
  if (afterS >= seconds) break;
}
await Promise.all(phones.map(({ browser }) => browser.close()));
