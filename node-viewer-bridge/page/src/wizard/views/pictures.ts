// Live pictures as the wizards show them, and what every wizard's main part can do.

import { element } from "../../panels/dom.ts";
import { Picture } from "../../panels/picture.ts";
import type { Preview, Wizard } from "../../protocol.ts";
import type { Site } from "../../site.ts";

/** The main part of a wizard. */
export interface View {
  root: HTMLElement;
  update(account: Wizard): void;
  preview(preview: Preview): void;
}

/** A live picture with a heat map over it. */
export class MappedPicture {
  readonly root: HTMLElement;
  readonly map = element("canvas", "map");
  private readonly picture: Picture;

  constructor(site: Site, readonly camera: string, changed: () => void) {
    this.picture = new Picture(site.camera(camera), site, () => {});
    this.picture.root.append(this.map);
    this.map.setAttribute("aria-hidden", "true");
    this.root = this.picture.root;
    new ResizeObserver(changed).observe(this.root);
  }

  show(preview: Preview): void {
    this.picture.show(preview);
  }
}

/** What every camera sees, small. */
export class PictureStrip {
  readonly root = element("div", "strip small");
  private readonly pictures = new Map<string, Picture>();

  constructor(private readonly site: Site) {}

  refresh(): void {
    for (const id of [...this.site.cameras.keys()].sort()) if (!this.pictures.has(id)) this.add(id);
  }

  preview(preview: Preview): void {
    this.pictures.get(preview.camera)?.show(preview);
  }

  private add(id: string): void {
    const picture = new Picture(this.site.camera(id), this.site, () => {});
    this.pictures.set(id, picture);
    this.root.append(element("figure", "", picture.root, element("figcaption", "", element("b", "", id))));
  }
}

/** Before a wizard begins: what the cameras see. */
export class PrepareView implements View {
  private readonly strip: PictureStrip;
  readonly root: HTMLElement;

  constructor(site: Site) {
    this.strip = new PictureStrip(site);
    this.root = element("div", "view-prepare", this.strip.root);
  }

  update(): void {
    this.strip.refresh();
  }

  preview(preview: Preview): void {
    this.strip.preview(preview);
  }
}
