// The rig wizard's pictures: what each camera sees with the fields that are covered, the graph of who has seen the
// object together, and in the end the cameras in their places.

import { element, testId } from "../../panels/dom.ts";
import type { Preview, RigCamera, RigDetails, Wizard, WizardResult } from "../../protocol.ts";
import type { Site } from "../../site.ts";
import { errorColour, groupColour, LARGE_PX } from "../colours.ts";
import { ConstellationView } from "../constellation.ts";
import { CameraGraph } from "../graph.ts";
import { drawFields } from "../maps.ts";
import { type Patch, rotate } from "../solid.ts";
import { MappedPicture, type View } from "./pictures.ts";

const FIELD_COLUMNS = 4;

/** The rig: a picture a camera, and the graph of who has seen the object together. */
export class RigView implements View {
  private readonly pictures = new Map<string, { picture: MappedPicture; about: HTMLElement; root: HTMLElement }>();
  private readonly strip = element("div", "strip");
  private readonly graph = new CameraGraph();
  private readonly plan = new ConstellationView();
  private readonly side = element("div", "side");
  readonly root = element("div", "view-rig", this.side, this.strip);
  private details: RigDetails | null = null;

  constructor(private readonly site: Site) {}

  update({ progress, result }: Wizard): void {
    if (progress) this.details = progress.details as RigDetails;
    const { details } = this;
    if (result) {
      this.side.replaceChildren(this.plan.canvas);
      this.plan.show(cameraPatches(result), "The cameras where they were found; drag to turn");
    } else if (details) {
      this.side.replaceChildren(this.graph.root);
      this.graph.show(details);
    }
    this.strip.hidden = result !== undefined;
    for (const camera of details?.cameras ?? []) this.card(camera.camera);
    this.draw();
  }

  preview(preview: Preview): void {
    this.pictures.get(preview.camera)?.picture.show(preview);
  }

  private card(camera: string): void {
    if (this.pictures.has(camera)) return;
    const picture = new MappedPicture(this.site, camera, () => this.draw());
    const about = testId(element("p", "about-camera"), `wizard-camera-${camera}`);
    const root = element("figure", "", picture.root, element("figcaption", "", element("b", "", camera), about));
    this.pictures.set(camera, { picture, about, root });
    this.strip.append(root);
  }

  private draw(): void {
    for (const camera of this.details?.cameras ?? []) {
      const card = this.pictures.get(camera.camera);
      if (!card) continue;
      drawFields(card.picture.map, camera.fields, FIELD_COLUMNS);
      const fields = camera.fields.filter(Boolean).length;
      card.about.textContent = `${camera.seeing} images, ${fields} of ${camera.fields.length} fields, ${Math.min(3, camera.distances)} of 3 distances`;
      card.root.style.setProperty("--group", camera.seeing > 0 ? groupColour(camera.group) : "transparent");
    }
  }
}

/** Cameras as patches: each looks out of its face. */
function cameraPatches({ model, report }: WizardResult): Patch[] {
  const placed = (model.cameras ?? []).filter((camera): camera is RigCamera & { world_from_camera: object } => camera.world_from_camera !== null);
  const positions = placed.map((camera) => camera.world_from_camera.position);
  const spread = Math.max(0.1, ...positions.map((p) => Math.hypot(...p.map((v, i) => v - (positions[0]?.[i] ?? 0)))));
  const rms = new Map("reference" in report ? report.cameras.map((camera) => [camera.camera, camera.rms_px]) : []);
  return placed.map((camera) => {
    const { position, orientation } = camera.world_from_camera;
    const ahead = rotate(orientation, [0, 0, 0.17 * spread]);
    return {
      name: camera.id,
      apex: position,
      position: [position[0] + ahead[0], position[1] + ahead[1], position[2] + ahead[2]],
      orientation,
      size: 0.16 * spread,
      colour: errorColour((rms.get(camera.id) ?? 0) / LARGE_PX),
    };
  });
}
