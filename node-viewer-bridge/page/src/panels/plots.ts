// Figures over time: of one object, of one camera's detector, and of all.

import { type Figures, type ObjectTrack, type Ring, TRACK } from "../history.ts";
import { cameraColour, STAGE, STAGE_TIME } from "../palette.ts";
import { STAGES } from "../protocol.ts";
import type { Selection } from "../selection.ts";
import type { Site } from "../site.ts";
import { Chart, type Line, type Table } from "./chart.ts";
import { csvOfFigures, csvOfTrack, download } from "./csv.ts";
import { Choice, element, pressButton } from "./dom.ts";

const WINDOWS: [string, number][] = [["10 s", 10], ["1 min", 60], ["10 min", 600]];
/** A turn from one sample to the next larger than this is the seam at ±180 degrees. */
const SEAM_DEG = 180;

/** Charts are wider. */
const NARROW_PX = 150;

/** A line of an object's track: a column and the factor to the shown unit. */
interface TrackLine extends Line {
  column: number;
  factor: number;
}

const [RED, GREEN, BLUE] = STAGE.axes;
const POSITION: TrackLine[] = [
  { label: "x", colour: RED, column: TRACK.x, factor: 1000 },
  { label: "y", colour: GREEN, column: TRACK.y, factor: 1000 },
  { label: "z", colour: BLUE, column: TRACK.z, factor: 1000 },
];
const ATTITUDE: TrackLine[] = [
  { label: "roll", colour: RED, column: TRACK.roll, factor: 1 },
  { label: "pitch", colour: GREEN, column: TRACK.pitch, factor: 1 },
  { label: "yaw", colour: BLUE, column: TRACK.yaw, factor: 1 },
];

/**
 * From the middle of the exposure: until the detector has the image, until its tags are found, until they are
 * published.
 */
const PATH = new Map([["received", BLUE], ["detected", GREEN], ["published", RED]]);

/** A chart of figures: those whose name begins with the prefix, a line each. */
interface FigureChart {
  chart: Chart;
  prefix(): string;
}

export class PlotsPanel {
  private window_s = 60;
  private pausedAt: number | null = null;
  private readonly object = new Choice("Object", "plots-object");
  private readonly camera = new Choice("Camera", "plots-camera");
  private readonly position = new Chart("position", "Position", "mm", "Origin of the object in the world");
  private readonly attitude = new Chart("attitude", "Attitude", "°", "Roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll)");
  private readonly charts: FigureChart[];

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
    selection: Selection,
  ) {
    const all = (id: string, title: string, unit: string, about: string): FigureChart => ({
      chart: new Chart(id, title, unit, about),
      prefix: () => `${id}/`,
    });
    this.charts = [
      all("sigma_mm", "Position sigma", "mm", "Expected length of the position's error"),
      all("sigma_deg", "Attitude sigma", "°", "Expected size of the attitude's error"),
      all("pose_ms", "Latency to the pose", "ms", "From the middle of the exposure to the published pose, median"),
      all("image_ms", "Latency to the tags", "ms", "From the middle of the exposure to the published observations, median"),
      {
        ...all("path_ms", "Path of an image", "ms", "From the middle of the exposure until the chosen camera's detector has the image, has found the tags, and they are published; medians"),
        prefix: () => `path_ms/${this.camera.value}/`,
      },
      { ...all("stage_ms", "Detector stages", "ms", "Time of each stage of the chosen camera's detector"), prefix: () => `stage_ms/${this.camera.value}/` },
      all("rate_hz", "Images", "/s", "Images a second of each camera"),
      all("residual_px", "Residual", "px", "Distance of seen from projected corners with the rig and objects as published, root mean square of an image"),
      all("clock_ms", "Clock offset", "ms", "How far each clock is off, as the images tell; corrected in the poses"),
    ];
    const grid = element("div", "charts", this.position.root, this.attitude.root, ...this.charts.map(({ chart }) => chart.root));
    root.append(this.toolbar(), grid);
    selection.changed(() => selection.object && this.object.choose(selection.object.split(".")[0] ?? selection.object));
  }

  update(now: number): void {
    if (this.root.hidden) return;
    this.object.offer([...this.site.objects.keys()].sort());
    this.camera.offer([...this.site.cameras.keys()].sort());
    const to = this.pausedAt ?? this.site.replayedAt ?? this.site.time(now);
    const range: [number, number] = [to - this.window_s, to];
    const track = this.site.objects.get(this.object.value)?.track;
    this.showTrack(this.position, POSITION, track, range);
    this.showTrack(this.attitude, ATTITUDE, track, range);
    for (const { chart, prefix } of this.charts) this.showFigures(chart, prefix(), range);
  }

  private toolbar(): HTMLElement {
    const windows = WINDOWS.map(([text, seconds]) => {
      const button = pressButton(text, `plots-window-${seconds}`, () => {
        this.window_s = seconds;
        for (const other of windows) other.setAttribute("aria-pressed", String(other === button));
      });
      button.setAttribute("aria-pressed", String(seconds === this.window_s));
      return button;
    });
    const pause = pressButton("Pause", "plots-pause", () => {
      this.pausedAt = this.pausedAt === null ? this.site.time(performance.now() / 1000) : null;
      pause.setAttribute("aria-pressed", String(this.pausedAt !== null));
    });
    pause.setAttribute("aria-pressed", "false");
    const objectCsv = pressButton("CSV of the object", "plots-csv-object", () => this.saveTrack());
    const siteCsv = pressButton("CSV of all figures", "plots-csv-figures", () => download("figures.csv", csvOfFigures(this.site.figures, this.from())));
    const group = (...items: HTMLElement[]): HTMLElement => element("div", "group", ...items);
    return element("div", "toolbar", group(...windows), group(pause), group(this.object.root, this.camera.root), group(objectCsv, siteCsv));
  }

  private from(): number {
    const to = this.pausedAt ?? this.site.time(performance.now() / 1000);
    return to - this.window_s;
  }

  private saveTrack(): void {
    const object = this.site.objects.get(this.object.value);
    if (object) download(`${object.id}.csv`, csvOfTrack(object.track.ring(this.from()), this.from()));
  }

  private showTrack(chart: Chart, lines: TrackLine[], track: ObjectTrack | undefined, range: [number, number]): void {
    const ring = track?.ring(range[0]);
    chart.blank(ring ? lines.length : 0);
    if (ring) fillTrack(chart.table, lines, ring, range);
    chart.show(ring ? lines : [], range);
  }

  private showFigures(chart: Chart, prefix: string, [from, to]: [number, number]): void {
    const { figures } = this.site;
    const names = figures.names(prefix);
    chart.blank(names.length);
    fillFigures(chart.table, figures, names, from, to);
    const lines = names.map((name): Line => ({ label: name.slice(prefix.length), colour: this.colour(name.slice(prefix.length)) }));
    chart.show(lines, [from, to]);
  }

  private colour(name: string): string {
    const stage = STAGES.find((stage) => stage === name);
    if (stage) return STAGE_TIME[stage];
    const camera = [...this.site.cameras.keys()].sort().indexOf(name);
    return this.site.objects.get(name)?.colour ?? (camera < 0 ? PATH.get(name) : undefined) ?? cameraColour(camera);
  }
}

function fillTrack(table: Table, lines: TrackLine[], ring: Ring, [from, to]: [number, number]): void {
  const [times] = table;
  const first = Math.max(0, ring.before(from));
  const perPixel = Math.ceil((ring.before(to) - first) / NARROW_PX);
  for (let row = first; row < ring.length && ring.time(row) <= to; row++) {
    times.push(ring.time(row));
    for (let k = 0; k < lines.length; k++) {
      const { column, factor } = lines[k] as TrackLine;
      const values = table[k + 1] as (number | null)[];
      const value = ring.value(column, row) * factor;
      const seam = column >= TRACK.roll && column <= TRACK.yaw && row > 0 && Math.abs(value - ring.value(column, row - 1)) > SEAM_DEG;
      // A pixel wide: within one pixel a line has no gaps.
      if (seam) for (let back = 1; back <= perPixel && back <= values.length; back++) values[values.length - back] = null;
      values.push(seam ? null : value);
    }
  }
}

function fillFigures(table: Table, figures: Figures, names: string[], from: number, to: number): void {
  const [times] = table;
  for (let row = 0; row < figures.length; row++) {
    const time = figures.time(row);
    if (time < from || time > to) continue;
    times.push(time);
    for (let k = 0; k < names.length; k++) {
      const value = figures.value(names[k] ?? "", row);
      (table[k + 1] as (number | null)[]).push(Number.isNaN(value) ? null : value);
    }
  }
}
