// The boxes of one tag of an object.

import { DEGREES } from "../attitude.ts";
import { isFamily } from "../messages.ts";
import { element, pressButton, testId } from "../panels/dom.ts";
import type { PrintedTag } from "../protocol.ts";
import { readWhole, Wrong } from "../wizard/command.ts";
import { choice, textBox } from "../wizard/fields.ts";
import { Boxes } from "./boxes.ts";
import { PoseBoxes } from "./pose.ts";
import { type Convention, readNumber, readSigma, writtenAngle, writtenLength } from "./values.ts";

const MM = 0.001;
const FAMILIES = isFamily.words.filter((family) => family !== "chessboard");
const MOST_TAGS = 100_000;

export class TagBoxes {
  readonly root: HTMLElement;
  private readonly family = choice(FAMILIES.map((family): [string, string] => [family, family]));
  private readonly id: HTMLInputElement;
  private readonly size: HTMLInputElement;
  private readonly pose: PoseBoxes;
  private readonly sigmas: Boxes;
  private readonly complaint = element("p", "complaint");

  /** `like` fills in a tag that is added. */
  constructor(
    key: string,
    private readonly given: PrintedTag | null,
    like: PrintedTag | null,
    convention: Convention,
    actions: { edited: () => void; remove: (tag: TagBoxes) => void },
  ) {
    const edited = (): void => {
      this.complain("");
      actions.edited();
    };
    this.id = testId(textBox(given ? String(given.id) : "", "numeric"), `${key}-id`);
    this.size = testId(textBox(writtenLength((given ?? like)?.size_m ?? 0.04, MM), "decimal"), `${key}-size`);
    this.family.value = (given ?? like)?.family ?? "tag36h11";
    testId(this.family, `${key}-family`);
    for (const control of [this.id, this.size, this.family]) control.addEventListener("input", edited);
    this.pose = new PoseBoxes(key, "mm", edited);
    this.pose.show(given?.object_from_tag ?? null, convention);
    this.sigmas = new Boxes(`${key}-sigma`, "Standard deviation", "", edited);
    this.sigmas.show(["edge mm", "place mm", "angle °"], this.writtenSigmas());
    const remove = pressButton("Remove", `${key}-remove`, () => actions.remove(this));
    const labels = [labelled("Tag", this.id), labelled("Edge mm", this.size), labelled("Family", this.family)];
    const head = element("div", "tag-head", ...labels, remove);
    const more = element("details", "", element("summary", "", "Standard deviations"), this.sigmas.root);
    more.open = given?.sigma !== undefined || given?.size_sigma_m !== undefined;
    const { position, orientation } = this.pose;
    this.root = testId(element("li", "tag", head, position.root, orientation.root, more, this.complaint), key);
  }

  get isEdited(): boolean {
    const { given } = this;
    if (!given) return true;
    const isOther = this.id.value.trim() !== String(given.id) || this.family.value !== given.family || this.isResized;
    return isOther || this.pose.isEdited || this.sigmas.isEdited;
  }

  write(convention: Convention): void {
    this.pose.write(convention);
  }

  /** @throws Wrong, whose complaint is shown here. */
  read(): object {
    try {
      return {
        family: this.family.value,
        id: readWhole(this.id.value, "tags", "The number of a tag", [0, MOST_TAGS]),
        size_m: this.readSize(),
        pose: this.pose.read(),
        ...this.readSigmas(),
      };
    } catch (error) {
      if (error instanceof Wrong) this.complain(error.message, error.field);
      throw error;
    }
  }

  /** Whether a text of the bridge names this tag. */
  isNamedIn(cause: string): boolean {
    return new RegExp(`\\b${this.family.value}:${this.id.value.trim()}\\b`).test(cause);
  }

  complain(cause: string, field = ""): void {
    const place = { position: this.pose.position, orientation: this.pose.orientation, sigma: this.sigmas }[field];
    if (cause !== "" && place) return place.complain(cause);
    this.complaint.textContent = cause;
  }

  private get isResized(): boolean {
    return this.size.value.trim() !== (this.given ? writtenLength(this.given.size_m, MM) : "");
  }

  private readSize(): number {
    if (this.given && !this.isResized) return this.given.size_m;
    const size = readNumber(this.size.value, "tags", "The edge of the black square");
    if (size === null) throw new Wrong("tags", "Write the edge of the black square, mm");
    return Number((size * MM).toPrecision(12));
  }

  private writtenSigmas(): string[] {
    const { size_sigma_m, sigma } = this.given ?? {};
    const edge = size_sigma_m === undefined ? "" : writtenLength(size_sigma_m, MM);
    if (!sigma) return [edge, "", ""];
    return [edge, writtenLength(sigma.position_m, MM), writtenAngle(sigma.orientation_rad * DEGREES)];
  }

  private readSigmas(): object {
    const { size_sigma_m = null, sigma = null } = this.given ?? {};
    if (!this.sigmas.isEdited) return { size_sigma_m, sigma };
    const [edge = "", place = "", angle = ""] = this.sigmas.texts;
    const [position_m, orientation_rad] = [readSigma(place, "sigma", MM), readSigma(angle, "sigma", 1 / DEGREES)];
    if ((position_m === null) !== (orientation_rad === null))
      throw new Wrong("sigma", "Write place and angle, or leave both empty");
    const written = position_m === null ? null : { position_m, orientation_rad };
    return { size_sigma_m: readSigma(edge, "sigma", MM), sigma: written };
  }
}

function labelled(text: string, control: HTMLElement): HTMLElement {
  return element("label", "", element("i", "", text), control);
}
