// The lens wizard's picture: live and large, with coverage over it, and in the end residuals and uncertainty.

import { fixed } from "../../format.ts";
import { element, testId } from "../../panels/dom.ts";
import type { LensDetails, LensReport, Preview, Wizard } from "../../protocol.ts";
import type { Site } from "../../site.ts";
import { ERROR_GRADIENT } from "../colours.ts";
import { Segments } from "../fields.ts";
import { drawCoverage, drawResiduals, drawSigmas } from "../maps.ts";
import { MappedPicture, type View } from "./pictures.ts";

type LensMap = "residuals" | "sigmas" | "coverage";

/** The lens: its camera's picture, large. */
export class LensView implements View {
  private readonly frame = element("div", "frame");
  private readonly legend = testId(element("p", "legend"), "wizard-legend");
  private readonly tilts = element("ul", "tilts");
  private readonly choose: Segments<LensMap>;
  readonly root: HTMLElement;
  private picture: MappedPicture | null = null;
  private account: Wizard | null = null;

  constructor(private readonly site: Site) {
    const names = { residuals: "Residuals", sigmas: "Uncertainty", coverage: "Coverage" };
    this.choose = new Segments<LensMap>("The map shows", names, "residuals", () => this.draw());
    const below = element("div", "below", this.choose.root, this.legend, this.tilts);
    this.root = element("div", "view-lens", this.frame, below);
  }

  update(account: Wizard): void {
    this.account = account;
    const camera = account.subject ?? "";
    if (this.picture?.camera !== camera) {
      this.picture = new MappedPicture(this.site, camera, () => this.draw());
      testId(this.picture.map, "wizard-map");
      this.frame.replaceChildren(this.picture.root);
    }
    this.draw();
  }

  preview(preview: Preview): void {
    if (preview.camera === this.picture?.camera) this.picture.show(preview);
  }

  private draw(): void {
    const { account, picture } = this;
    if (!account || !picture) return;
    const report = account.result?.report as LensReport | undefined;
    this.choose.root.hidden = !report;
    this.tilts.hidden = report !== undefined;
    picture.map.dataset["shows"] = report ? this.choose.value : "coverage";
    if (report) this.drawResult(picture.map, report);
    else if (account.progress) this.drawProgress(picture.map, account.progress.details as LensDetails);
  }

  private drawProgress(map: HTMLCanvasElement, details: LensDetails): void {
    drawCoverage(map, details.coverage);
    const cells = details.coverage.flat();
    const covered = cells.filter((corners) => corners > 0).length / Math.max(1, cells.length);
    this.legend.textContent = `${fixed(100 * covered, 0)} % of the picture covered, ${details.views} views kept`;
    this.tilts.replaceChildren(
      ...["left", "right", "top", "bottom"].map((side, at) => tilt(side, details.tilted[at] ?? 0)),
    );
  }

  private drawResult(map: HTMLCanvasElement, report: LensReport): void {
    if (this.choose.value === "coverage") {
      drawCoverage(map, report.cells.map((row) => row.map((cell) => cell.corners)));
      this.legend.textContent = `${fixed(100 * report.coverage, 0)} % of the picture covered`;
    } else if (this.choose.value === "residuals") {
      const { end, arrow } = drawResiduals(map, report.cells);
      this.legend.replaceChildren(...scale(end, "px rms"), `, a whole arrow is a mean of ${arrow} px`);
    } else {
      const { end } = drawSigmas(map, report.cells);
      this.legend.replaceChildren(...scale(end, "px, one standard deviation of where the lens shows a ray"));
    }
  }
}

/** Views of a tilt that are enough. */
const TILTS = 3;

function tilt(side: string, count: number): HTMLElement {
  const dots = Array.from({ length: TILTS }, (_, at) => element("i", at < count ? "on" : ""));
  const item = element("li", count >= TILTS ? "done" : "", element("span", "", `${side} away`), ...dots);
  item.setAttribute("aria-label", `${side} side turned away in ${Math.min(count, TILTS)} of ${TILTS} views`);
  return item;
}

function scale(end: number, unit: string): HTMLElement[] {
  const bar = element("span", "scale");
  bar.style.background = ERROR_GRADIENT;
  return [element("span", "", "0 "), bar, element("span", "", ` ${end} ${unit}`)];
}
