// The viewer's page: the bridge's messages go into the site's state; stage and panels show it.

import "./style.css";
import "./wizard/wizard.css";
import { Connection, socketUrl } from "./connection.ts";
import { Bar } from "./panels/bar.ts";
import { CamerasPanel } from "./panels/cameras.ts";
import { find } from "./panels/dom.ts";
import { ObjectsPanel } from "./panels/objects.ts";
import { createTools, rememberedOptions } from "./panels/tools.ts";
import type { Message } from "./protocol.ts";
import { enter, wantsToken } from "./session.ts";
import { Site } from "./site.ts";
import { Stage } from "./stage/stage.ts";
import { IDLE } from "./wizard/account.ts";
import { WizardPanel } from "./wizard/panel.ts";

/** The bridge sends newer figures at most this often: as often as the stage is drawn. */
const MAX_HZ = 30;
const FIGURES_MS = 100;
const CONDITIONS_MS = 500;

const seconds = (): number => performance.now() / 1000;
const site = new Site();
const stage = createStage();
const bar = new Bar(site);
const objects = new ObjectsPanel(find("[data-testid=objects]"), site);
const cameras = new CamerasPanel(find("[data-testid=cameras]"), site, (camera, canvas) => stage?.picture(camera, canvas));
const wizard = new WizardPanel(find("[data-testid=wizard]"), site);

function createStage(): Stage | null {
  const options = rememberedOptions();
  try {
    const stage = new Stage(find("canvas[data-testid=stage]"), find(".labels"), options);
    createTools(find(".tools"), options, () => stage.refresh(), () => stage.resetView());
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
      return stage?.pose(site.object(message.object), message);
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

function showFigures(): void {
  if (document.hidden) return;
  const now = seconds();
  bar.update(now);
  objects.update(now);
  cameras.update(now);
}

setInterval(showFigures, FIGURES_MS);
setInterval(() => stage?.conditions(site, seconds()), CONDITIONS_MS);
const connection = new Connection(socketUrl(location, MAX_HZ), {
  message: take,
  preview: (preview) => {
    if (document.hidden) return;
    cameras.preview(preview);
    wizard.preview(preview);
  },
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
    sextant: { positions(): Record<string, number[]>; frames(): number; site: Site };
  }
}
window.sextant = { positions: () => stage?.positions() ?? {}, frames: () => stage?.frames.count ?? 0, site };
