// The form of a camera: its name, where it is, and how well that is known.

import { element } from "../panels/dom.ts";
import type { RigCamera, Transform } from "../protocol.ts";
import type { Site } from "../site.ts";
import { DEGREES } from "../attitude.ts";
import { type Complaint, readName, Wrong } from "../wizard/command.ts";
import { Field, textBox } from "../wizard/fields.ts";
import { Boxes } from "./boxes.ts";
import type { EditForm } from "./form.ts";
import { PoseBoxes } from "./pose.ts";
import { readSigma, writtenAngle, writtenLength, type Convention } from "./values.ts";

const MM = 0.001;

export class CameraForm implements EditForm {
  readonly root = element("div", "fields");
  version: string | null = null;
  hint = "";
  readonly axes = "A camera's x points to the right of its picture, y down and z forward.";
  private readonly name: Field;
  private readonly pose: PoseBoxes;
  private readonly sigma: Boxes;
  private readonly note = element("p", "note", "Its node has to have this name too: `camera` in its camera.toml.");
  private model: RigCamera | null = null;
  private convention: Convention = "angles";

  constructor(
    private id: string,
    private readonly site: Site,
    private readonly preview: (camera: RigCamera | null) => void,
  ) {
    const edited = (): void => this.edited();
    this.name = new Field("edit-id", "Name", textBox(""));
    this.name.control.addEventListener("input", edited);
    this.pose = new PoseBoxes("edit", "m", edited);
    this.sigma = new Boxes("edit-sigma", "Standard deviation", "", edited);
    this.root.append(this.name.root, this.note, this.pose.position.root, this.pose.orientation.root, this.sigma.root);
    this.load();
  }

  get title(): string {
    return `Camera ${this.id}`;
  }

  get removal(): object {
    return { do: "remove_camera", id: this.id, version: this.version };
  }

  get isEdited(): boolean {
    return this.name.text.trim() !== this.id || this.pose.isEdited || this.sigma.isEdited;
  }

  inForce(): string | null {
    return this.site.cameras.get(this.id)?.model?.version ?? null;
  }

  load(): void {
    this.model = this.site.cameras.get(this.id)?.model ?? null;
    this.version = this.model?.version ?? null;
    const mount = this.model?.mount;
    this.hint = mount
      ? `Carried by ${mount.carrier}: the pose is that on the carrier.`
      : "Its pose in the world. Leave all boxes empty where it is not calibrated.";
    this.name.control.value = this.id;
    this.name.complain("");
    this.note.hidden = true;
    this.pose.show(mount?.carrier_from_camera ?? this.model?.world_from_camera ?? null, this.convention);
    const sigma = this.model?.sigma;
    const written = sigma ? [writtenLength(sigma.position_m, MM), writtenAngle(sigma.orientation_rad * DEGREES)] : [];
    this.sigma.show(["position mm", "angle °"], written);
    this.preview(null);
  }

  write(convention: Convention): void {
    this.convention = convention;
    this.pose.write(convention);
  }

  request(): object {
    const id = readName(this.name.text, "id");
    const [pose, sigma] = [this.pose.read(), this.readSigma()];
    return { do: "edit_camera", camera: this.id, version: this.version, id, pose, sigma };
  }

  complain({ field, cause }: Complaint): boolean {
    const { position, orientation } = this.pose;
    const places = { id: this.name, position, orientation, sigma: this.sigma };
    const place = places[field as keyof typeof places];
    place?.complain(cause);
    return place !== undefined;
  }

  renamed(): string {
    this.id = this.name.text.trim();
    return this.id;
  }

  isRevertible(rig: boolean): boolean {
    return rig;
  }

  private readSigma(): object | null {
    if (!this.sigma.isEdited) return this.model?.sigma ?? null;
    const [position = "", angle = ""] = this.sigma.texts;
    const [position_m, orientation_rad] = [readSigma(position, "sigma", MM), readSigma(angle, "sigma", 1 / DEGREES)];
    if (position_m === null && orientation_rad === null) return null;
    if (position_m === null || orientation_rad === null)
      throw new Wrong("sigma", "Write both, or leave both empty: then the defaults apply");
    return { position_m, orientation_rad };
  }

  /** Draws the camera where the boxes have it. */
  private edited(): void {
    this.note.hidden = this.name.text.trim() === this.id;
    if (this.model === null || this.model.mount) return;
    let pose: Transform | null;
    try {
      pose = this.pose.read();
    } catch (error) {
      if (!(error instanceof Wrong)) throw error;
      return;
    }
    if (pose) this.preview({ ...this.model, world_from_camera: pose });
  }
}
