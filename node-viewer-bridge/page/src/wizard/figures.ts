// A result's figures as a table, with bars for what should be small.

import type { LearnReport, LensReport, RigReport, WizardResult } from "../protocol.ts";
import { fixed, NONE } from "../format.ts";
import { element, testId } from "../panels/dom.ts";
import { errorColour, LARGE_PX, scaleEnd } from "./colours.ts";

interface Column<T> {
  title: string;
  unit?: string;
  about: string;
  text(row: T): string;
  /** Pixels, drawn as a bar in proportion to the largest. */
  bar?(row: T): number;
}

/** What a table of this report says. */
export function figuresOf({ report }: WizardResult): HTMLElement {
  if ("lens" in report) return lensFigures(report);
  return "reference" in report ? rigFigures(report) : learnFigures(report);
}

/** One line about the whole. */
export function summaryOf({ report }: WizardResult): string {
  if ("lens" in report)
    return `${report.lens.model} from ${report.views} of ${report.images} images · ${fixed(report.rms_px, 3)} px rms · ${fixed(100 * report.coverage, 0)} % of the picture covered`;
  return `${report.images_used} of ${report.images} images used · ${fixed(report.rms_px, 3)} px rms`;
}

function lensFigures(report: LensReport): HTMLElement {
  const { lens, sigmas } = report;
  const named: [string, number][] = [
    ["fx", lens.fx],
    ["fy", lens.fy],
    ["cx", lens.cx],
    ["cy", lens.cy],
    ...(lens.distortion ?? []).map((value, at): [string, number] => [distortionName(lens.model, at), value]),
  ];
  const rows = named.map(([name, value], at) => ({ name, value, sigma: sigmas[at] ?? null, digits: at < 4 ? 2 : 5 }));
  const table = tableOf("parameter", rows, (row) => row.name, [
    { title: "Value", about: "In pixels; the distortion's coefficients have no unit", text: (row) => fixed(row.value, row.digits) },
    { title: "±", about: "One standard deviation", text: (row) => (row.sigma === null ? NONE : fixed(row.sigma, row.digits + 1)) },
  ]);
  const tried = tableOf("model", report.models, (row) => row.model, [
    {
      title: "Held back",
      unit: "px",
      about: "How well each model foretells images that it was not fitted to, root mean square",
      text: (row) => fixed(row.held_out_rms_px, 3),
      bar: (row) => row.held_out_rms_px,
    },
  ]);
  return element("div", "figures", table, ...(report.models.length > 1 ? [tried] : []));
}

function distortionName(model: string, at: number): string {
  return model === "kannala-brandt" ? `k${at + 1}` : (["k1", "k2", "p1", "p2", "k3"][at] ?? `d${at + 1}`);
}

const UNCERTAINTY = {
  mm: { title: "±", unit: "mm", about: "One standard deviation of the position" },
  deg: { title: "±", unit: "°", about: "One standard deviation of the attitude" },
  rms: { title: "Residual", unit: "px", about: "Distance between model and seen corners, root mean square" },
};

function rigFigures(report: RigReport): HTMLElement {
  const clocks = report.cameras.some((camera) => camera.clock_offset_ms !== null);
  const table = tableOf("camera", report.cameras, (row) => row.camera, [
    { ...UNCERTAINTY.mm, text: (row) => (row.camera === report.reference ? "reference" : fixed(row.sigma_mm, 2)) },
    { ...UNCERTAINTY.deg, text: (row) => (row.camera === report.reference ? "" : fixed(row.sigma_deg, 3)) },
    { ...UNCERTAINTY.rms, text: (row) => fixed(row.rms_px, 3), bar: (row) => row.rms_px },
    { title: "Images", about: "Images used", text: (row) => String(row.images) },
    ...(clocks
      ? [{ title: "Clock", unit: "ms", about: "By how much its clock is ahead of the reference camera's", text: (row: RigReport["cameras"][number]) => fixed(row.clock_offset_ms, 2) }]
      : []),
  ]);
  return element("div", "figures", table);
}

function learnFigures(report: LearnReport): HTMLElement {
  const table = tableOf("tag", report.tags, (row) => tagName(row.tag), [
    { ...UNCERTAINTY.mm, text: (row) => fixed(row.sigma_mm, 3) },
    { ...UNCERTAINTY.deg, text: (row) => fixed(row.sigma_deg, 3) },
    { ...UNCERTAINTY.rms, text: (row) => fixed(row.rms_px, 3), bar: (row) => row.rms_px },
    { title: "Images", about: "Images that show it", text: (row) => String(row.images) },
    { title: "Left out", about: "Images in which it did not fit", text: (row) => String(row.left_out) },
  ]);
  return element("div", "figures", table);
}

/** A tag's number; its family only where that is not the usual one. */
export function tagName(tag: string): string {
  return tag.replace(/^tag36h11:/, "");
}

function tableOf<T>(what: string, rows: T[], name: (row: T) => string, columns: Column<T>[]): HTMLTableElement {
  const head = element("tr", "", heading(what, ""), ...columns.map((column) => heading(column.title, column.about, column.unit)));
  const ends = columns.map((column) => (column.bar ? scaleEnd(Math.max(0, ...rows.map(column.bar))) : 0));
  const body = rows.map((row) => {
    const first = element("th", "name", name(row));
    first.scope = "row";
    const cells = columns.map((column, at) => cell(column, row, ends[at] ?? 0));
    return testId(element("tr", "", first, ...cells), `wizard-figure-${name(row)}`);
  });
  return element("table", "", element("thead", "", head), element("tbody", "", ...body));
}

function heading(title: string, about: string, unit?: string): HTMLTableCellElement {
  const made = element("th", "", title, ...(unit ? [element("span", "unit", ` ${unit}`)] : []));
  made.scope = "col";
  if (about) made.title = about;
  return made;
}

function cell<T>(column: Column<T>, row: T, end: number): HTMLTableCellElement {
  const made = element("td", "", column.text(row));
  if (!column.bar) return made;
  const value = column.bar(row);
  const bar = element("span", "bar-of");
  bar.style.width = `${Math.max(2, 100 * Math.min(1, value / end))}%`;
  bar.style.background = errorColour(value / LARGE_PX);
  made.append(element("span", "track", bar));
  return made;
}
