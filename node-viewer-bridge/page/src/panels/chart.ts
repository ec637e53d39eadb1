// One chart over time: lines, a cursor common to all charts, and its values in the legend.

import uPlot from "uplot";
import { fixed } from "../format.ts";
import { colour, onTheme } from "../theme.ts";
import { element, testId } from "./dom.ts";

export interface Line {
  label: string;
  colour: string;
}

/** Times, then the values of each line; null where missing. */
export type Table = [number[], ...(number | null)[][]];

const HEIGHT = 128;
const FONT = "11px system-ui, sans-serif";

export class Chart {
  readonly root: HTMLElement;
  private readonly area = element("div", "area");
  private plot: uPlot | null = null;
  private lines: Line[] = [];
  private shown = "";
  private range: [number, number] = [0, 1];
  /** Filled by the caller before it is shown; uPlot reads it until the next time. */
  readonly table: Table = [[]];
  private empty: HTMLElement;

  constructor(
    id: string,
    title: string,
    unit: string,
    about: string,
  ) {
    const heading = element("h3", "", title, element("span", "unit", ` ${unit}`));
    heading.title = about;
    this.empty = element("p", "empty", "no data yet");
    this.root = testId(element("figure", "chart", heading, this.area, this.empty), `chart-${id}`);
    new ResizeObserver(() => this.resize()).observe(this.area);
    onTheme(() => this.rebuild());
  }

  /** Empties the table, for so many lines. */
  blank(lines: number): void {
    while (this.table.length < lines + 1) this.table.push([]);
    this.table.length = lines + 1;
    for (const column of this.table) column.length = 0;
  }

  /** Shows the table over a range of time. */
  show(lines: Line[], range: [number, number]): void {
    const { table } = this;
    const shape = lines.map((line) => line.label + line.colour).join("\n");
    this.range = range;
    this.lines = lines;
    this.root.dataset["points"] = String(table[0].length);
    this.empty.hidden = lines.length > 0 && table[0].length > 0;
    if (shape !== this.shown || !this.plot) {
      this.shown = shape;
      this.rebuild();
    }
    this.plot?.setData(table, false);
    this.plot?.setScale("x", { min: range[0], max: range[1] });
    this.readOutLast(table[0].length - 1);
  }

  /** Without a cursor, the legend shows the newest values. */
  private readOutLast(last: number): void {
    if (this.plot && last >= 0 && (this.plot.cursor.left ?? -1) < 0) this.plot.setLegend({ idx: last }, false);
  }

  private rebuild(): void {
    this.plot?.destroy();
    this.plot = null;
    if (this.lines.length === 0 || this.area.clientWidth === 0) return;
    this.plot = new uPlot(this.options(), [[], ...this.lines.map(() => [])], this.area);
  }

  private resize(): void {
    const width = this.area.clientWidth;
    if (width === 0) return;
    if (this.plot) this.plot.setSize({ width, height: HEIGHT });
    else this.rebuild();
  }

  private options(): uPlot.Options {
    const [text, grid] = [colour("--faint"), colour("--line")];
    const axis = { stroke: text, font: FONT, grid: { stroke: grid, width: 1 }, ticks: { show: false } };
    return {
      width: this.area.clientWidth,
      height: HEIGHT,
      padding: [6, 24, 0, 0],
      legend: { live: true, markers: { width: 0, fill: (_, index) => this.lines[index - 1]?.colour ?? text } },
      cursor: { sync: { key: "sextant", setSeries: false }, drag: { x: false, y: false }, points: { size: 5 }, y: false },
      scales: { x: { time: false, range: () => this.range } },
      axes: [
        { ...axis, space: 70, size: 24, values: (_, splits) => splits.map((at) => clock(at)) },
        { ...axis, space: 28, size: 46, values: (_, splits) => splits.map(axisNumber) },
      ],
      series: [
        { label: "", value: (_, at) => (at == null ? "" : clock(at, 1)) },
        ...this.lines.map((line): uPlot.Series => ({
          label: line.label,
          stroke: line.colour,
          width: 1.4,
          points: { show: false },
          value: (_, value) => (value == null ? "–" : readOut(value)),
        })),
      ],
    };
  }
}

/** The time of day where the browser is. */
export function clock(at: number, digits = 0): string {
  const time = new Date(at * 1000);
  const part = (value: number): string => String(value).padStart(2, "0");
  const whole = `${part(time.getHours())}:${part(time.getMinutes())}:${part(time.getSeconds())}`;
  return digits > 0 ? `${whole}.${String(time.getMilliseconds()).padStart(3, "0").slice(0, digits)}` : whole;
}

/** Three significant digits, as far as that makes sense of millimetres and degrees. */
function readOut(value: number): string {
  const size = Math.abs(value);
  return fixed(value, size < 10 ? 2 : size < 1000 ? 1 : 0);
}

function axisNumber(value: number): string {
  return String(Number(value.toPrecision(6))).replace("-", "−");
}
