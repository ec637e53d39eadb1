// Plotted figures as files: comma-separated, a head line, times in seconds since the Unix epoch.

import { type Figures, type Ring, TRACK } from "../history.ts";

const COLUMNS: [string, number][] = [
  ["x_m", TRACK.x], ["y_m", TRACK.y], ["z_m", TRACK.z], ["qx", TRACK.qx], ["qy", TRACK.qy], ["qz", TRACK.qz], ["qw", TRACK.qw],
  ["roll_deg", TRACK.roll], ["pitch_deg", TRACK.pitch], ["yaw_deg", TRACK.yaw], ["sigma_mm", TRACK.sigma_mm], ["sigma_deg", TRACK.sigma_deg],
  ["latency_ms", TRACK.latency_ms],
];

/** An object's track from a time on. */
export function csvOfTrack(ring: Ring, from: number): string {
  const lines = [["t_s", ...COLUMNS.map(([name]) => name)].join(",")];
  for (let row = 0; row < ring.length; row++) {
    if (ring.time(row) < from) continue;
    lines.push([ring.time(row).toFixed(6), ...COLUMNS.map(([, column]) => number(ring.value(column, row)))].join(","));
  }
  return `${lines.join("\n")}\n`;
}

/** All figures from a time on, a column each; empty where one is missing. */
export function csvOfFigures(figures: Figures, from: number): string {
  const names = figures.names("");
  const lines = [["t_s", ...names].join(",")];
  for (let row = 0; row < figures.length; row++) {
    if (figures.time(row) < from) continue;
    lines.push([figures.time(row).toFixed(3), ...names.map((name) => number(figures.value(name, row)))].join(","));
  }
  return `${lines.join("\n")}\n`;
}

const number = (value: number): string => (Number.isNaN(value) ? "" : String(Number(value.toPrecision(7))));

/** Hands a text to the browser as a file. */
export function download(name: string, text: string): void {
  const url = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  URL.revokeObjectURL(url);
}
