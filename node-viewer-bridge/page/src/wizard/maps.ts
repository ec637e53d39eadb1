// Heat maps that lie over a camera's live picture: where the board has been, what is left of the corners' errors, how
// well the lens is known.

import type { MapCell } from "../protocol.ts";
import { errorColour, scaleEnd } from "./colours.ts";

type Area = [x: number, y: number, width: number, height: number];
type Context = CanvasRenderingContext2D;

/** So many corners in a cell are plenty. */
const PLENTY = 12;
const MAX_PIXEL_RATIO = 2;
/** The longest arrow, as a part of a cell's width. */
const LONGEST_ARROW = 0.9;
const UNTOUCHED = "rgba(8, 11, 15, 0.62)";

/** Dark where the board has not been yet, brighter green where it has been more. */
export function drawCoverage(canvas: HTMLCanvasElement, cells: number[][]): void {
  draw(canvas, cells, (context, corners, area) => {
    const share = Math.min(1, corners / PLENTY);
    context.fillStyle = corners === 0 ? UNTOUCHED : `rgba(99, 207, 156, ${0.1 + 0.3 * share})`;
    context.fillRect(...inset(area));
  });
}

/**
 * Cells by their residuals, with the mean as an arrow; tells pixels at the end of the colours and of the longest arrow.
 */
export function drawResiduals(canvas: HTMLCanvasElement, cells: MapCell[][]): { end: number; arrow: number } {
  const seen = cells.flat().filter((cell) => cell.corners > 0);
  const end = scaleEnd(Math.max(...seen.map((cell) => cell.rms_px), 0.2));
  const arrow = scaleEnd(Math.max(...seen.map((cell) => Math.hypot(...cell.mean_px)), 0.01));
  draw(canvas, cells, (context, cell, area) => {
    if (cell.corners === 0) return fill(context, area, UNTOUCHED);
    fill(context, area, errorColour(cell.rms_px / end, 0.5));
  });
  draw(canvas, cells, (context, cell, area) => {
    if (cell.corners > 0) drawArrow(context, area, [cell.mean_px[0] / arrow, cell.mean_px[1] / arrow]);
  }, "keep");
  return { end, arrow };
}

/** Cells by the deviation of the lens; tells pixels at the end of the colours. */
export function drawSigmas(canvas: HTMLCanvasElement, cells: MapCell[][]): { end: number } {
  const end = scaleEnd(Math.max(...cells.flat().map((cell) => cell.sigma_px ?? 0), 0.02));
  draw(canvas, cells, (context, { sigma_px }, area) => {
    fill(context, area, sigma_px === null ? UNTOUCHED : errorColour(sigma_px / end, 0.55));
  });
  return { end };
}

/** The fields of a picture in which something was seen. */
export function drawFields(canvas: HTMLCanvasElement, fields: boolean[], columns: number): void {
  const rows = Array.from({ length: Math.ceil(fields.length / columns) }, (_, row) =>
    fields.slice(row * columns, (row + 1) * columns),
  );
  draw(canvas, rows, (context, seen, area) => {
    fill(context, area, seen ? "rgba(99, 207, 156, 0.26)" : "rgba(8, 11, 15, 0.5)");
  });
}

function draw<T>(
  canvas: HTMLCanvasElement,
  cells: T[][],
  paint: (context: Context, cell: T, area: Area) => void,
  before: "clear" | "keep" = "clear",
): void {
  const context = canvas.getContext("2d");
  const columns = cells[0]?.length ?? 0;
  if (!context || columns === 0) return;
  const ratio = Math.min(window.devicePixelRatio, MAX_PIXEL_RATIO);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (before === "clear") {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  const [across, down] = [width / columns, height / cells.length];
  cells.forEach((row, y) => row.forEach((cell, x) => paint(context, cell, [x * across, y * down, across, down])));
}

function fill(context: Context, area: Area, style: string): void {
  context.fillStyle = style;
  context.fillRect(...inset(area));
}

/** A hairline of picture between the cells. */
function inset([x, y, width, height]: Area): Area {
  return [x + 0.5, y + 0.5, width - 1, height - 1];
}

function drawArrow(context: Context, [x, y, width, height]: Area, [dx, dy]: [number, number]): void {
  const [fromX, fromY] = [x + width / 2, y + height / 2];
  const [toX, toY] = [fromX + LONGEST_ARROW * width * dx, fromY + LONGEST_ARROW * width * dy];
  const length = Math.hypot(toX - fromX, toY - fromY);
  context.strokeStyle = context.fillStyle = "#f4f7fa";
  context.lineWidth = 1.4;
  context.beginPath();
  context.arc(fromX, fromY, 1.3, 0, 2 * Math.PI);
  context.fill();
  if (length < 2) return;
  const [ux, uy] = [(toX - fromX) / length, (toY - fromY) / length];
  const head = Math.min(4, length / 2);
  context.beginPath();
  context.moveTo(fromX, fromY);
  context.lineTo(toX, toY);
  context.moveTo(toX - head * (ux - 0.6 * uy), toY - head * (uy + 0.6 * ux));
  context.lineTo(toX, toY);
  context.lineTo(toX - head * (ux + 0.6 * uy), toY - head * (uy - 0.6 * ux));
  context.stroke();
}
