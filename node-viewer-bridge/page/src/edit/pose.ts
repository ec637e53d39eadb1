// The boxes of a pose: position, and orientation by angles or as a quaternion.

import type { Quaternion, Transform, Vec3 } from "../protocol.ts";
import { Wrong } from "../wizard/command.ts";
import { Boxes } from "./boxes.ts";
import { type Convention, keepUntouched, PARTS, readOrientation, readPosition } from "./values.ts";
import { writtenOrientation, writtenPosition } from "./values.ts";

/** Units of length, m. */
const SCALES = { m: 1, mm: 0.001 } as const;

export class PoseBoxes {
  readonly position: Boxes;
  readonly orientation: Boxes;
  private given: Transform | null = null;
  private convention: Convention = "angles";

  constructor(
    id: string,
    private readonly unit: keyof typeof SCALES,
    edited: () => void,
  ) {
    this.position = new Boxes(`${id}-position`, "Position", unit, edited);
    this.orientation = new Boxes(`${id}-orientation`, "Orientation", "", edited);
  }

  get isEdited(): boolean {
    return this.position.isEdited || this.orientation.isEdited;
  }

  show(given: Transform | null, convention: Convention): void {
    this.given = given;
    this.convention = convention;
    this.position.show(["x", "y", "z"], given ? writtenPosition(given.position, SCALES[this.unit]) : []);
    this.orientation.show(PARTS[convention], given ? writtenOrientation(given.orientation, convention) : []);
  }

  /** Writes the orientation in another way; what a person has written moves along if it can be read. */
  write(convention: Convention): void {
    if (convention === this.convention) return;
    const { isEdited } = this.orientation;
    let orientation: Quaternion | null = null;
    try {
      orientation = this.readOrientation();
    } catch (error) {
      if (!(error instanceof Wrong)) throw error;
    }
    this.convention = convention;
    this.orientation.show(PARTS[convention], this.given ? writtenOrientation(this.given.orientation, convention) : []);
    if (isEdited && orientation) this.orientation.write(writtenOrientation(orientation, convention));
  }

  /** The pose; none where all boxes are empty. What nobody has touched stays as it was given. @throws Wrong */
  read(): Transform | null {
    const [position, orientation] = [this.readPosition(), this.readOrientation()];
    if (position === null && orientation === null) return null;
    if (position === null) throw new Wrong("position", "Write the position too, or leave the orientation empty");
    if (orientation === null) throw new Wrong("orientation", "Write the orientation too, or leave the position empty");
    return { position, orientation };
  }

  private readPosition(): Vec3 | null {
    const { position: given = null } = this.given ?? {};
    if (!this.position.isEdited) return given;
    const read = readPosition(this.position.texts, SCALES[this.unit]);
    return read && keepUntouched(read, given ?? [], (at) => this.position.isBoxEdited(at));
  }

  private readOrientation(): Quaternion | null {
    const { orientation: given = null } = this.given ?? {};
    if (!this.orientation.isEdited) return given;
    const isTouched = (at: number): boolean => this.orientation.isBoxEdited(at);
    return readOrientation(this.orientation.texts, this.convention, given, isTouched);
  }
}
