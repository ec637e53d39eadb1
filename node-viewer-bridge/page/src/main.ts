// The viewer's page: the bridge's messages go into the site's state; stage and panels show it.

import "uplot/dist/uPlot.min.css";
import "./style.css";
import "./panels/dock.css";
import "./wizard/wizard.css";
import "./edit/edit.css";
import { PictureArchive } from "./archive.ts";
import { Connection, socketUrl } from "./connection.ts";
import { EditorPanel } from "./edit/panel.ts";
import { useStageColours } from "./palette.ts";
import { Bar } from "./panels/bar.ts";
import { CamerasPanel } from "./panels/cameras.ts";
import { DistancesPanel } from "./panels/distances.ts";
import { Dock } from "./panels/dock.ts";
import { find } from "./panels/dom.ts";
import { HealthPanel } from "./panels/health.ts";
import { Shortcuts } from "./panels/keys.ts";
import { ObjectsPanel } from "./panels/objects.ts";
import { PhonesDialog } from "./panels/phones.ts";
import { PlotsPanel } from "./panels/plots.ts";
import { Timeline } from "./panels/timeline.ts";
import { rememberedOptions, StageTools } from "./panels/tools.ts";
import { ZonesPanel } from "./panels/zones.ts";
import { Playback } from "./playback.ts";
import type { Message, Preview } from "./protocol.ts";
import { Selection } from "./selection.ts";
import { enter, wantsToken } from "./session.ts";
import { type CameraState, Site } from "./site.ts";
import { Eye } from "./stage/eye.ts";
import { Stage } from "./stage/stage.ts";
import { onTheme, theme, toggleTheme } from "./theme.ts";
import { IDLE, WizardPanel } from "./wizard/panel.ts";

/** The bridge sends newer figures at most this often: as often as the stage is drawn. */
const MAX_HZ = 60;
const FIGURES_MS = 100;
const SAMPLE_MS = 200;
const CONDITIONS_MS = 500;

const seconds = (): number => performance.now() / 1000;
useStageColours(theme());
if (new URLSearchParams(location.search).has("kiosk")) document.body.dataset["kiosk"] = "";

const site = new Site();
const selection = new Selection();
const archive = new PictureArchive();
const playback = new Playback(site, showTime);
const tools = new StageTools(find(".tools"), rememberedOptions());
const stage = createStage();
const eye = new Eye(find("[data-testid=eye-view]"), site, () => selection.back());
const editor = new EditorPanel(find("[data-testid=editor]"), site, (camera) => stage?.preview(camera));
const objects = new ObjectsPanel(find("[data-testid=objects]"), site, selection, (object) => editor.object(object));
const editCamera = (camera: string): void => editor.camera(camera);
const cameras = new CamerasPanel(find("[data-testid=cameras]"), site, selection, showPicture, editCamera);
const plots = new PlotsPanel(find("[data-testid=plots]"), site, selection);
const health = new HealthPanel(find("[data-testid=health]"), site, (kind, subject) => wizard.prepare(kind, subject));
const distances = new DistancesPanel(find("[data-testid=measure]"), site, selection);
const zones = new ZonesPanel(find("[data-testid=zones]"), site);
const timeline = new Timeline(find("[data-testid=timeline]"), site, playback);
const dock = new Dock(find(".dock"), [
  { key: "objects", title: "Objects", panel: find("[data-testid=objects]") },
  { key: "plots", title: "Plots", panel: find("[data-testid=plots]") },
  { key: "health", title: "Health", panel: find("[data-testid=health]") },
  { key: "measure", title: "Measure", panel: find("[data-testid=measure]") },
  { key: "zones", title: "Zones", panel: find("[data-testid=zones]") },
]);
const bar = new Bar(site, () => dock.show("health"));
new PhonesDialog();
const wizard = new WizardPanel(find("[data-testid=wizard]"), site);

function createStage(): Stage | null {
  try {
    const stage = new Stage(find("canvas[data-testid=stage]"), find(".labels"), tools.options, selection);
    tools.connect(() => stage.refresh(), () => stage.resetView());
    stage.refresh();
    return stage;
  } catch (error) {
    const note = find<HTMLElement>("[data-testid=stage-note]");
    note.textContent = "No 3-D view: this browser has no WebGL 2. Tables and pictures work.";
    note.hidden = false;
    console.warn(error);
    return null;
  }
}

function showPicture(camera: CameraState, canvas: HTMLCanvasElement): void {
  stage?.picture(camera, canvas);
  if (selection.camera === camera.id) eye.draw();
}

selection.changed(() => {
  const camera = selection.camera === null ? null : (site.cameras.get(selection.camera) ?? null);
  eye.open(camera, camera && cameras.picture(camera));
});

onTheme((theme) => {
  useStageColours(theme);
  stage?.recolour(site);
});

function take(message: Message): void {
  site.take(message, seconds());
  switch (message.type) {
    case "rig":
      return stage?.rig(message.cameras);
    case "object":
      return stage?.objectTags(site.object(message.id));
    case "object_gone":
      return stage?.forget(message.id);
    case "pose":
      if (playback.at === null) stage?.pose(site.object(message.object), message);
      return;
    case "zones":
      return stage?.zones(message.zones);
    case "observations":
      return cameras.outlines(site.camera(message.camera), message.t_ns);
    case "detection_report":
      return cameras.outlines(site.camera(message.camera), message.capture_ns);
    case "hello":
      document.title = `${message.site} · Sextant`;
      document.body.dataset["role"] = message.role;
      // The bridge tells of its wizard, if there is one, right after.
      return wizard.take(IDLE);
    case "wizard":
      return wizard.take(message);
    default:
      return;
  }
}

function takePreview(preview: Preview): void {
  archive.add(preview);
  if (document.hidden) return;
  if (playback.at === null) cameras.preview(preview);
  wizard.preview(preview);
}

/** The time that is shown has changed. */
let shownAt: number | null = null;
function showTime(): void {
  const { at } = playback;
  document.body.dataset["replaying"] = String(at !== null);
  const jumped = at === null || shownAt === null || Math.abs(at - shownAt) > 0.5;
  shownAt = at;
  stage?.replay(site, jumped);
  if (at !== null) for (const id of site.cameras.keys()) cameras.recall(id, archive.near(id, at * 1e9));
}

let advancedAt = seconds();
function advance(): void {
  const now = seconds();
  playback.advance(now - advancedAt);
  advancedAt = now;
}

function showFigures(): void {
  if (document.hidden) return;
  const now = seconds();
  bar.update(now);
  objects.update(now);
  cameras.update(now);
  plots.update(now);
  health.update(now);
  distances.update();
  zones.update(now);
  timeline.update();
  dock.badge("health", site.health.open);
}

new Shortcuts([
  { key: "k", about: "Hold the time, or let it run", action: () => playback.toggle() },
  { key: ",", about: "One second back", action: () => playback.step(-1) },
  { key: ".", about: "One second forward", action: () => playback.step(1) },
  { key: "End", about: "Back to the present", action: () => playback.live() },
  { key: "o", about: "Follow the next object", action: () => selection.follow(next([...site.objects.keys()], selection.object)) },
  { key: "c", about: "Look through the next camera", action: () => selection.lookThrough(next([...site.cameras.keys()], selection.camera)) },
  { key: "Escape", label: "Esc", about: "Back to the whole stage", action: () => selection.back() },
  { key: "ArrowLeft", label: "←", about: "Turn the stage left", onStage: true, action: () => stage?.turn(-1, 0) },
  { key: "ArrowRight", label: "→", about: "Turn the stage right", onStage: true, action: () => stage?.turn(1, 0) },
  { key: "ArrowUp", label: "↑", about: "Look from higher up", onStage: true, action: () => stage?.turn(0, 1) },
  { key: "ArrowDown", label: "↓", about: "Look from lower down", onStage: true, action: () => stage?.turn(0, -1) },
  { key: "+", about: "Nearer", action: () => stage?.zoom(1) },
  { key: "-", about: "Farther away", action: () => stage?.zoom(-1) },
  { key: "r", about: "Reset the view", action: () => stage?.resetView() },
  { key: "t", about: "Trails", action: () => tools.toggle("trails") },
  { key: "p", about: "Pictures on the stage", action: () => tools.toggle("pictures") },
  { key: "s", about: "Uncertainty", action: () => tools.toggle("sigma") },
  { key: "n", about: "Names", action: () => tools.toggle("labels") },
  { key: "l", about: "Light or dark", action: toggleTheme },
  ...["objects", "plots", "health", "measure", "zones"].map((tab, at) => ({
    key: String(at + 1),
    about: `Panel ${at + 1}: ${tab}`,
    action: () => dock.show(tab),
  })),
]);
find("[data-testid=theme]").addEventListener("click", toggleTheme);

/** The one after the current, in order of names; after the last none. */
function next(ids: string[], current: string | null): string | null {
  const sorted = ids.sort();
  return sorted[current === null ? 0 : sorted.indexOf(current) + 1] ?? null;
}

setInterval(advance, 1000 / 30);
setInterval(showFigures, FIGURES_MS);
setInterval(() => site.sample(seconds()), SAMPLE_MS);
setInterval(() => stage?.conditions(site, seconds()), CONDITIONS_MS);
const connection = new Connection(socketUrl(location, MAX_HZ), {
  message: take,
  preview: takePreview,
  connected: (up) => {
    bar.connected(up);
    // The token may have been withdrawn meanwhile: then the page begins anew, and asks for another.
    if (!up) void wantsToken().then((wanted) => wanted && location.reload());
  },
});
void enter().then(() => connection.open());

declare global {
  interface Window {
    /** For tests and the curious: what is drawn, from the browser's console. */
    sextant: { positions(): Record<string, number[]>; screen(id: string): number[] | null; eye(): number[] | null; frames(): number; drawMs(): number; site: Site; selection: Selection; playback: Playback };
  }
}
window.sextant = { positions: () => stage?.positions() ?? {}, screen: (id) => stage?.screen(id) ?? null, eye: () => stage?.eye() ?? null, frames: () => stage?.frames.count ?? 0, drawMs: () => stage?.frames.scriptMs ?? 0, site, selection, playback };
