// The page that makes a browser a camera of the site: asks, shows what the camera sees, stops in the background and
// comes back by itself.

import "../theme.ts";
import "../style.css";
import "./camera.css";
import { find } from "../panels/dom.ts";
import { enter } from "../session.ts";
import { remember, remembered } from "../storage.ts";
import { Source, type Wanted } from "./source.ts";
import { nowMs, type FromWorker, type Report, type DetectionResult, type ToWorker } from "./words.ts";

const SIZES: [number, number][] = [
  [640, 480],
  [1280, 720],
  [1920, 1080],
];
const RATES = [15, 30, 60];
const RETRY_MS = 2000;
const TOO_OLD = "This browser is too old to be a camera: use one from 2024 or later.";
const LEAST_SHARPNESS = 0.3;
/** A camera that delivers nothing for so long is reported, and how often that is looked at. */
const SILENT_MS = 2000;
const LOOK_MS = 500;
const LIGHT = [40, 215] as const;

interface Settings {
  camera: string;
  size: string;
  rate: string;
  pictures: boolean;
}

const body = document.body;
const ask = find<HTMLFormElement>("form[data-testid=ask]");
const live = find<HTMLElement>("section.live");
const video = find<HTMLVideoElement>("video");
const outlines = find<HTMLCanvasElement>("canvas[data-testid=outlines]");
const facts = find<HTMLElement>("dl.facts");
const link = find<HTMLElement>("[data-testid=link]");
const trouble = find<HTMLElement>("[data-testid=trouble]");
const notice = find<HTMLElement>("[data-testid=notice]");
const fixButton = find<HTMLButtonElement>("button[data-testid=fix]");
const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
const say = (message: ToWorker, owned: Transferable[] = []) => worker.postMessage(message, owned);

/** The link's token is said before the camera joins. */
const entered = enter();
let source: Source | null = null;
/** Whether a person wants the camera to run; it rests while the page is in the background. */
let wanted = false;
let idle = false;
let opening = false;
let fixed = false;
let retry = 0;
let report: Report | null = null;
/** Families of the site's tags that this browser does not find. */
let unread: string[] = [];
let wakeLock: WakeLockSentinel | null = null;
/** Whether the camera delivers images. */
let silent = false;

/** By which the bridge knows this browser again. */
function deviceKey(): string {
  const known = remembered("camera-key");
  if (typeof known === "string" && /^[a-z0-9]{8,64}$/.test(known)) return known;
  const key = [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  remember("camera-key", key);
  return key;
}

function settings(): Settings {
  const fields = new FormData(ask);
  const text = (name: string) => String(fields.get(name) ?? "");
  return { camera: text("camera").trim(), size: text("size"), rate: text("rate"), pictures: fields.get("pictures") !== null };
}

function fill(): void {
  const field = (name: string) => find<HTMLInputElement | HTMLSelectElement>(`[name=${name}]`, ask);
  const option = (text: string) => new Option(text, text);
  field("size").append(...SIZES.map((size) => option(size.join(" × "))));
  field("rate").append(...RATES.map((rate) => option(String(rate))));
  const known = (remembered("camera") ?? {}) as Partial<Settings>;
  const given = new URLSearchParams(location.search).get("name");
  field("camera").value = given ?? known.camera ?? `phone-${deviceKey().slice(0, 4)}`;
  field("size").value = known.size ?? SIZES[1]!.join(" × ");
  field("rate").value = known.rate ?? "30";
  (field("pictures") as HTMLInputElement).checked = known.pictures ?? false;
}

/** The device, as the status of the camera names it. */
function deviceName(): string {
  const data = (navigator as { userAgentData?: { platform?: string; brands?: { brand: string }[] } }).userAgentData;
  const browser = data?.brands?.find(({ brand }) => !/not.?a.?brand/i.test(brand))?.brand;
  return [data?.platform ?? navigator.platform, browser].filter(Boolean).join(" ") || "browser";
}

function socketUrl(camera: string): string {
  const url = new URL("ws/camera", location.href);
  url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  url.search = new URLSearchParams({ name: camera, key: deviceKey() }).toString();
  url.hash = "";
  return url.href;
}

async function start(): Promise<void> {
  if (!wanted || source || opening || document.hidden) return;
  opening = true;
  try {
    await entered;
    const { camera, size, rate, pictures } = settings();
    const [width, height] = size.split(" × ").map(Number) as [number, number];
    const options: Wanted = { width, height, rate: Number(rate) };
    source = await Source.open(video, options, rest);
    if (!wanted || document.hidden) return rest();
    show("live");
    idle = false;
    say({ type: "begin", url: socketUrl(camera), camera, host: deviceName(), pictures });
    source.watch(
      () => idle,
      (shot) => {
        idle = false;
        say({ type: "taken", ...shot, sentMs: nowMs(), captured: source?.captured ?? 0 }, [shot.image]);
      },
    );
    fixButton.hidden = !source.canFix;
    if (fixed) void source.fix(true).catch(() => undefined);
    wakeLock = await navigator.wakeLock?.request("screen").catch(() => null);
  } catch (cause) {
    failed(cause);
  } finally {
    opening = false;
  }
}

/** Why there is no camera, and what helps. */
function failed(cause: unknown): void {
  const name = cause instanceof DOMException ? cause.name : "";
  const words: Record<string, string> = {
    NotAllowedError: "The browser may not use the camera. Allow it in the browser's settings of this page, then start again.",
    NotFoundError: "This device has no camera.",
    NotReadableError: "Another program uses the camera. Close it; this page tries again by itself.",
  };
  const text = words[name] ?? `The camera does not start: ${cause instanceof Error ? cause.message : String(cause)}`;
  trouble.textContent = notice.textContent = text;
  rest();
  if (name === "NotAllowedError" || name === "NotFoundError") stop(text);
}

/** Lets go of the camera and the connection, and tries again where the camera is still wanted. */
function rest(): void {
  source?.close();
  source = null;
  say({ type: "end" });
  void wakeLock?.release().catch(() => undefined);
  wakeLock = null;
  showLink("off", "paused");
  clearTimeout(retry);
  if (wanted) retry = window.setTimeout(() => void start(), RETRY_MS);
}

function stop(words = ""): void {
  wanted = false;
  rest();
  show("asking");
  showLink("off", "not connected");
  trouble.textContent = words;
}

function show(stage: "asking" | "live"): void {
  body.dataset["stage"] = stage;
  ask.hidden = stage !== "asking";
  live.hidden = stage !== "live";
  if (stage === "live") trouble.textContent = notice.textContent = "";
}

function showLink(condition: string, words: string): void {
  link.dataset["condition"] = condition;
  link.textContent = words;
}

function draw({ outlines: tags, size: [width, height] }: DetectionResult): void {
  const pen = outlines.getContext("2d");
  if (!pen) return;
  [outlines.width, outlines.height] = [width, height];
  outlines.dataset["tags"] = String(tags.length);
  pen.lineWidth = Math.max(2, width / 300);
  pen.font = `${Math.round(width / 32)}px system-ui`;
  pen.strokeStyle = pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--good");
  for (const { id, corners } of tags) {
    // (0, 0) is the centre of the first pixel, and a corner of the canvas.
    const path = corners.map(([x, y]) => `${x + 0.5},${y + 0.5}`).join("L");
    pen.stroke(new Path2D(`M${path}Z`));
    const [x, y] = [0, 1].map((axis) => corners.reduce((sum, corner) => sum + corner[axis as 0 | 1] / 4, 0)) as [number, number];
    pen.textAlign = "center";
    pen.fillText(String(id), x, y);
  }
}

function showFacts(seen: DetectionResult): void {
  const { brightness, sharpness } = seen.light;
  const light = brightness < LIGHT[0] ? "too dark" : brightness > LIGHT[1] ? "too bright" : "good";
  const focus = sharpness === 0 ? "no edges" : sharpness < LEAST_SHARPNESS ? "blurred" : "sharp";
  const clock = report?.clock_error_ms;
  const rows: [string, string, boolean][] = [
    ["Tags", String(seen.outlines.length), true],
    ["Rate", `${seen.rateHz.toFixed(0)} Hz`, true],
    ["Image", seen.size.join(" × "), true],
    ["Detection", `${seen.detectMs.toFixed(1)} ms`, true],
    ["Light", light, light === "good"],
    ["Sharpness", focus, focus !== "blurred"],
    ["Clock", clock == null ? "comparing" : `± ${clock.toFixed(1)} ms`, clock != null],
    ["Sent", String(report?.published ?? 0), true],
  ];
  facts.replaceChildren(
    ...rows.map(([name, value, good]) => {
      const row = document.createElement("div");
      const [term, description] = [document.createElement("dt"), document.createElement("dd")];
      [term.textContent, description.textContent] = [name, value];
      row.dataset["fact"] = name.toLowerCase();
      row.dataset["good"] = String(good);
      row.append(term, description);
      return row;
    }),
  );
}

const sentence = (words: string): string => `${words.charAt(0).toUpperCase()}${words.slice(1)}.`;

function takeReport(message: Report): void {
  report = message;
  const notices = [
    ...(silent ? ["The camera delivers no images: a call, another app or a screen lock may have it. Close that, or stop here and start again."] : []),
    ...message.faults.map(sentence),
    ...(message.cause ? [`${message.refused} messages refused, the last: ${message.cause}.`] : []),
    ...(unread.length > 0 ? [`Browsers do not read tags of ${unread.join(" and ")}: objects that carry only those need another kind of camera.`] : []),
    ...(message.in_rig ? [] : ["The site's rig has no camera of this name yet: tags are published without poses until it is calibrated."]),
  ];
  notice.textContent = notices.join(" ");
}

/** What was seen last says nothing about now. */
function look(): void {
  const isSilent = source !== null && source.silentMs > SILENT_MS;
  if (isSilent) {
    say({ type: "silent" });
    outlines.getContext("2d")?.clearRect(0, 0, outlines.width, outlines.height);
    outlines.dataset["tags"] = "0";
    for (const row of facts.querySelectorAll<HTMLElement>("[data-fact]")) {
      const value = row.querySelector("dd");
      const isOfImage = ["tags", "rate", "light", "sharpness", "detection"].includes(row.dataset["fact"] ?? "");
      if (!value || !isOfImage) continue;
      value.textContent = row.dataset["fact"] === "rate" ? "no images" : "–";
      row.dataset["good"] = String(row.dataset["fact"] !== "rate");
    }
  }
  if (isSilent !== silent) {
    silent = isSilent;
    if (report) takeReport(report);
  }
}

worker.addEventListener("message", ({ data }: MessageEvent<FromWorker>) => {
  if (!source) return;
  switch (data.type) {
    case "ready":
      idle = true;
      return;
    case "seen":
      draw(data);
      return showFacts(data);
    case "report":
      return takeReport(data);
    case "unread":
      unread = data.families;
      return;
    case "link":
      // Whoever is refused for good asks for another name or link, and lets go of the camera.
      if (data.condition === "ended") return stop(sentence(data.words));
      showLink(data.condition, data.words);
      if (data.condition === "refused") notice.textContent = data.words;
      return;
    case "failed":
      notice.textContent = data.cause;
  }
});
worker.addEventListener("error", () => stop(TOO_OLD));

ask.addEventListener("submit", (event) => {
  event.preventDefault();
  remember("camera", settings());
  wanted = true;
  void start();
});
find<HTMLButtonElement>("button[data-testid=stop]").addEventListener("click", () => stop());
fixButton.addEventListener("click", () => {
  fixed = !fixed;
  fixButton.textContent = fixed ? "Let focus and exposure adapt" : "Fix focus and exposure";
  void source?.fix(fixed).catch(() => undefined);
});
document.addEventListener("visibilitychange", () => {
  if (document.hidden) rest();
  else void start();
});
addEventListener("pagehide", rest);
setInterval(look, LOOK_MS);

fill();
const isSecure = isSecureContext && navigator.mediaDevices !== undefined;
const isNew = "requestVideoFrameCallback" in HTMLVideoElement.prototype && "OffscreenCanvas" in window;
find<HTMLElement>("[data-testid=insecure]").hidden = isSecure;
if (!isNew) trouble.textContent = TOO_OLD;
find<HTMLButtonElement>("button[data-testid=start]").disabled = !isSecure || !isNew;
