// What a camera's detector made of its last image: where the time went, how many candidates there were, why some were
// turned down. Shown under the enlarged picture, over which the candidates are drawn in the same colours.

import { fixed, magnitude, plural } from "../format.ts";
import { CAUSE, STAGE_TIME } from "../palette.ts";
import { CAUSES, STAGES, type Cause, type DetectionReport, type StageName } from "../protocol.ts";
import { element, testId, Text } from "./dom.ts";

const CAUSE_WORDS: Record<Cause, string> = {
  not_a_quad: "no quadrilateral",
  shape: "too small or skewed",
  faint_border: "faint border",
  no_code: "no code word",
  small_margin: "hardly legible",
};
const STAGE_WORDS: Record<StageName, string> = {
  tiles: "contrast of tiles",
  threshold: "black and white",
  components: "connected areas",
  quads: "quadrilaterals",
  decode: "code words",
  refine: "corners below the pixel",
};

export class DetectorPanel {
  readonly root: HTMLElement;
  private readonly summary = new Text(element("p"));
  private readonly conditions = new Text(element("p", "conditions"));
  private readonly total = new Text(element("span", "total"));
  private readonly stages = new Map<StageName, HTMLElement>();
  private readonly counts = new Map<Cause, Text>();
  private shown: DetectionReport | null = null;

  constructor(camera: string) {
    const bar = element("div", "stages");
    for (const stage of STAGES) bar.append(this.stage(stage));
    const causes = element("dl", "causes");
    for (const cause of CAUSES) causes.append(this.cause(camera, cause));
    const time = element("div", "time", bar, this.total.element);
    this.root = testId(element("section", "detector", this.summary.element, time, causes, this.conditions.element), `camera-${camera}-detector`);
    this.root.hidden = true;
  }

  show(report: DetectionReport | null): void {
    if (report === this.shown) return;
    this.shown = report;
    this.root.hidden = report === null;
    if (!report) return;
    this.summary.set(`${plural(report.tags, "tag")} of ${plural(report.candidates, "candidate")}${part(report.searched)}`);
    this.showTimes(report);
    for (const [cause, text] of this.counts) text.set(String(report.rejected[cause]));
    this.conditions.set(`Pixel noise ${fixed(report.noise_sigma, 1)}, contrast from ${report.contrast_gate} grey levels`);
  }

  private showTimes({ stage_ms }: DetectionReport): void {
    const total = STAGES.reduce((sum, stage) => sum + stage_ms[stage], 0);
    this.total.set(`${magnitude(total)} ms`);
    for (const [stage, segment] of this.stages) {
      segment.style.flexGrow = String((100 * stage_ms[stage]) / (total || 1));
      segment.title = `${STAGE_WORDS[stage]}: ${fixed(stage_ms[stage], 3)} ms`;
    }
  }

  private stage(stage: StageName): HTMLElement {
    const segment = element("span");
    segment.style.background = STAGE_TIME[stage];
    this.stages.set(stage, segment);
    return segment;
  }

  private cause(camera: string, cause: Cause): HTMLElement {
    const count = new Text(testId(element("dd"), `camera-${camera}-rejected-${cause}`));
    this.counts.set(cause, count);
    const swatch = element("i");
    swatch.style.borderColor = CAUSE[cause];
    return element("div", "", element("dt", "", swatch, CAUSE_WORDS[cause]), count.element);
  }
}

function part(searched: number): string {
  return searched < 1 ? `, ${fixed(100 * searched, 0)} % of the image searched` : "";
}
