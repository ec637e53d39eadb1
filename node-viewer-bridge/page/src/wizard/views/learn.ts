// The object wizard's pictures: the constellation as it grows, the coverage of each tag, and what the cameras see.

import { element, testId } from "../../panels/dom.ts";
import type { LearnDetails, Preview, Wizard, WizardResult } from "../../protocol.ts";
import type { Site } from "../../site.ts";
import { errorColour, groupColour, LARGE_PX } from "../colours.ts";
import { ConstellationView } from "../constellation.ts";
import { tagName } from "../figures.ts";
import type { Patch } from "../solid.ts";
import { PictureStrip, type View } from "./pictures.ts";

/** The object: its constellation as it grows, the coverage of each tag, and what the cameras see. */
export class LearnView implements View {
  private readonly constellation = new ConstellationView();
  private readonly waiting = element("p", "waiting", "The constellation grows here as tags are seen together.");
  private readonly tags = testId(element("ul", "tags"), "wizard-tags");
  private readonly strip: PictureStrip;
  readonly root: HTMLElement;

  constructor(site: Site) {
    this.strip = new PictureStrip(site);
    const space = element("div", "space", this.constellation.canvas, this.waiting);
    this.root = element("div", "view-learn", space, this.tags, this.strip.root);
  }

  update({ progress, result }: Wizard): void {
    if (result) {
      this.waiting.hidden = true;
      this.constellation.show(tagPatches(result), "The object's tags where they were found; drag to turn");
    } else if (progress) {
      const details = progress.details as LearnDetails;
      this.waiting.hidden = details.sketch.length > 0;
      this.constellation.show(sketched(details), `${details.sketch.length} of ${details.tags.length} tags are joined so far`);
      this.tags.replaceChildren(...details.tags.map((tag) => tagItem(tag)));
    }
    this.tags.hidden = this.strip.root.hidden = result !== undefined;
    this.strip.refresh();
  }

  preview(preview: Preview): void {
    this.strip.preview(preview);
  }
}

function sketched({ sketch, tags }: LearnDetails): Patch[] {
  const progress = new Map(tags.map((tag) => [tag.tag, tag]));
  return sketch.map(({ tag, size_m, position, orientation }) => {
    const known = progress.get(tag);
    return { name: tagName(tag), position, orientation, size: size_m, colour: coverageColour(known ? coverageOf(known) : 0) };
  });
}

/** Enough of a tag: images of it, and directions that it was seen from. */
const [ENOUGH_IMAGES, ENOUGH_DIRECTIONS] = [12, 3];

export function coverageOf({ images, directions }: { images: number; directions: number }): number {
  return 0.5 * Math.min(1, images / ENOUGH_IMAGES) + 0.5 * Math.min(1, directions / ENOUGH_DIRECTIONS);
}

function coverageColour(share: number): string {
  return errorColour(1 - share);
}

function tagItem(tag: LearnDetails["tags"][number]): HTMLElement {
  const share = coverageOf(tag);
  const bar = element("span", "bar-of");
  bar.style.width = `${100 * share}%`;
  bar.style.background = coverageColour(share);
  const about = `${tag.images} images, ${tag.directions} directions`;
  const name = element("b", "", tagName(tag.tag));
  name.style.setProperty("--group", tag.images > 0 ? groupColour(tag.group) : "var(--line)");
  const item = element("li", "", name, element("span", "track", bar), element("span", "note", about));
  return testId(item, `wizard-tag-${tagName(tag.tag)}`);
}

function tagPatches({ model, report }: WizardResult): Patch[] {
  const figures = new Map("object" in report ? report.tags.map((tag) => [tag.tag, tag.rms_px]) : []);
  return (model.tags ?? []).flatMap((tag) => {
    const rms = figures.get(`${tag.family}:${tag.id}`) ?? 0;
    const pose = tag.object_from_tag;
    return pose ? [{ ...pose, name: String(tag.id), size: tag.size_m, colour: errorColour(rms / LARGE_PX) }] : [];
  });
}
