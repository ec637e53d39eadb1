// The form of an object, or of a link of one: its name, its place if it stands still, and its tags.

import { element, pressButton, testId } from "../panels/dom.ts";
import type { PrintedTag } from "../protocol.ts";
import type { ObjectState, Site } from "../site.ts";
import { type Complaint, readName, Wrong } from "../wizard/command.ts";
import { Field, textBox } from "../wizard/fields.ts";
import type { EditForm } from "./form.ts";
import { PoseBoxes } from "./pose.ts";
import { TagBoxes } from "./tag.ts";
import type { Convention } from "./values.ts";

export class ObjectForm implements EditForm {
  readonly root = element("div", "fields");
  version: string | null = null;
  readonly axes = "A tag's x points to the right of its print, y up and z out of it.";
  private readonly name: Field;
  private readonly place: PoseBoxes;
  private readonly placed: HTMLElement;
  private readonly list = testId(element("ol", "tag-list"), "edit-tags");
  private readonly complaint = testId(element("p", "complaint"), "edit-tags-complaint");
  private tags: TagBoxes[] = [];
  private isListEdited = false;
  private convention: Convention = "angles";
  private counted = 0;

  /** `id` is null for an object that is added; `<object>.<link>` is a link of one. */
  constructor(
    private id: string | null,
    private readonly site: Site,
  ) {
    this.name = new Field("edit-id", "Name", textBox(""));
    this.place = new PoseBoxes("edit-place", "m", () => {});
    const { position, orientation } = this.place;
    this.placed = element("div", "fields", element("h3", "", "Place in the world"), position.root, orientation.root);
    const add = pressButton("Add a tag", "edit-add-tag", () => this.add());
    this.root.append(this.name.root, this.placed, element("h3", "", "Tags"), this.list, this.complaint, add);
    this.load();
  }

  get title(): string {
    return this.id === null ? "New object" : `Object ${this.id}`;
  }

  get hint(): string {
    return (
      "Positions are those of the tags' centres in the frame of the object. " +
      "Leave all boxes of a tag empty where its place is not known: fusion does not use it until it is learned."
    );
  }

  get removal(): object | null {
    return this.id === null ? null : { do: "remove_object", id: this.names.object, version: this.version };
  }

  get isEdited(): boolean {
    const isOther = this.name.text.trim() !== (this.names.object ?? "");
    return isOther || this.isListEdited || this.place.isEdited || this.tags.some((tag) => tag.isEdited);
  }

  inForce(): string | null {
    return this.known?.version || null;
  }

  load(): void {
    const { known } = this;
    this.version = this.inForce();
    this.name.control.value = this.names.object ?? "";
    this.name.complain("");
    this.complaint.textContent = "";
    this.placed.hidden = !known?.place;
    this.place.show(known?.place ?? null, this.convention);
    this.isListEdited = false;
    this.tags = (known?.tags ?? []).map((tag) => this.boxes(tag, null));
    if (this.id === null) this.tags = [this.boxes(null, null)];
    this.list.replaceChildren(...this.tags.map((tag) => tag.root));
  }

  write(convention: Convention): void {
    this.convention = convention;
    this.place.write(convention);
    for (const tag of this.tags) tag.write(convention);
  }

  request(): object {
    const { object, link } = this.names;
    return {
      do: "edit_object",
      object,
      link,
      version: this.version,
      id: readName(this.name.text, "id"),
      place: this.placed.hidden ? null : this.readPlace(),
      tags: this.tags.map((tag) => tag.read()),
    };
  }

  complain({ field, cause }: Complaint): boolean {
    if (field === "id") this.name.complain(cause);
    else if (field === "place") this.place.position.complain(cause);
    else if (field === "tags") this.complainOfTags(cause);
    // Those of a tag stand at the tag already.
    else return field === "position" || field === "orientation" || field === "sigma";
    return true;
  }

  renamed(): string {
    const { link } = this.names;
    const name = this.name.text.trim();
    this.id = link === null ? name : `${name}.${link}`;
    return this.id;
  }

  isRevertible(_rig: boolean, objects: string[]): boolean {
    return this.names.object !== null && objects.includes(this.names.object);
  }

  private get known(): ObjectState | undefined {
    return this.id === null ? undefined : this.site.objects.get(this.id);
  }

  private get names(): { object: string | null; link: string | null } {
    const [object, link] = this.id?.split(".") ?? [];
    return { object: object ?? null, link: link ?? null };
  }

  private readPlace(): object {
    try {
      const place = this.place.read();
      if (place) return place;
    } catch (error) {
      if (error instanceof Wrong) throw new Wrong("place", error.message);
      throw error;
    }
    throw new Wrong("place", "This object stands still: write where");
  }

  private complainOfTags(cause: string): void {
    const named = this.tags.filter((tag) => tag.isNamedIn(cause));
    this.complaint.textContent = named.length === 0 ? cause : "";
    for (const tag of named) tag.complain(cause);
    named[0]?.root.scrollIntoView({ block: "nearest" });
  }

  private boxes(given: PrintedTag | null, like: PrintedTag | null): TagBoxes {
    const actions = { edited: () => (this.complaint.textContent = ""), remove: (tag: TagBoxes) => this.remove(tag) };
    return new TagBoxes(`edit-tag-${this.counted++}`, given, like, this.convention, actions);
  }

  private add(): void {
    const added = this.boxes(null, this.known?.tags.at(-1) ?? null);
    this.tags.push(added);
    this.isListEdited = true;
    this.list.append(added.root);
    added.root.scrollIntoView({ block: "nearest" });
    added.root.querySelector<HTMLElement>("input")?.focus();
  }

  private remove(tag: TagBoxes): void {
    this.tags = this.tags.filter((other) => other !== tag);
    this.isListEdited = true;
    tag.root.remove();
    this.complaint.textContent = "";
  }
}
