// What a person should know before a wizard begins.

import type { WizardKind } from "../protocol.ts";
import { element, Text } from "../panels/dom.ts";

const WORDS: Record<WizardKind, { title: string; why: string; how: string[] }> = {
  lens: {
    title: "How a camera’s lens bends the picture",
    why: "Once for each camera, and again after its lens was turned.",
    how: [
      "Print a board with sextant print board and glue it onto something stiff and flat.",
      "Hold it before the camera, large, near every edge and corner, tilted by 30° and more in each direction.",
      "Parts of the board will do. Follow the words; they say where it is missing.",
    ],
  },
  rig: {
    title: "Where every camera stands",
    why: "After the lenses, and again whenever a camera was moved.",
    how: [
      "Take any object with tags and carry it slowly through the room.",
      "Let each camera see it near and far, and each camera together with another one.",
      "Cameras that never see it together are joined through others.",
    ],
  },
  learn: {
    title: "Where the tags sit on an object",
    why: "Once for each object, and again when a tag was moved or added.",
    how: [
      "Stick tags onto the object, neighbouring ones so that a camera sees two at once.",
      "Turn it slowly before a camera until every side was seen.",
      "The words say which turn is missing; the picture shows what is joined.",
    ],
  },
};

export class Introduction {
  private readonly title = new Text(element("h3"));
  private readonly why = new Text(element("p"));
  private readonly how = element("ul");
  readonly root = element("div", "introduction", this.title.element, this.why.element, this.how);

  show(kind: WizardKind): void {
    this.title.set(WORDS[kind].title);
    this.why.set(WORDS[kind].why);
    this.how.replaceChildren(...WORDS[kind].how.map((line) => element("li", "", line)));
  }
}
