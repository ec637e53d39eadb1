// What the bridge tells of a wizard (the message `wizard` in ../PROTOCOL.md) and how it is checked. Knows nothing of the page.

import type { ObjectTag, Point, Quaternion, RigCamera, Vec3 } from "../protocol.ts";
import { isFlag, isNumber, isText, listOf, numbers, optional, orNull, shaped, type Shape, type Test } from "../shape.ts";

export type Kind = "lens" | "rig" | "learn";
export type Stage = "idle" | "collecting" | "solving" | "solved" | "keeping" | "kept";

export interface LensDetails {
  views: number;
  /** Corners in each cell of the picture, row by row from the top left. */
  coverage: number[][];
  /** Views in which the left, right, upper and lower side was turned away. */
  tilted: number[];
}

export interface CameraProgress {
  camera: string;
  images: number;
  seeing: number;
  /** Twelve fields of the picture, four by three, row by row. */
  fields: boolean[];
  distances: number;
  /** Equal numbers are joined. */
  group: number;
}

export interface RigDetails {
  cameras: CameraProgress[];
  together: [string, string, number][];
}

export interface TagProgress {
  tag: string;
  images: number;
  directions: number;
  group: number;
}

export interface SketchedTag {
  tag: string;
  size_m: number;
  position: Vec3;
  orientation: Quaternion;
}

export interface LearnDetails {
  joining: number;
  tags: TagProgress[];
  sketch: SketchedTag[];
}

export interface Progress {
  images: number;
  fraction: number;
  is_enough: boolean;
  hint: string;
  details: LensDetails | RigDetails | LearnDetails;
}

export interface Verdict {
  grade: "good" | "usable" | "poor";
  because: string[];
}

export interface MapCell {
  corners: number;
  mean_px: Point;
  rms_px: number;
  sigma_px: number | null;
}

export interface LensReport {
  camera: string;
  lens: { model: string; fx: number; fy: number; cx: number; cy: number; distortion?: number[] };
  sigmas: number[];
  rms_px: number;
  noise_px: number;
  images: number;
  views: number;
  coverage: number;
  models: { model: string; held_out_rms_px: number }[];
  cells: MapCell[][];
  verdict: Verdict;
}

export interface CalibratedCamera {
  camera: string;
  images: number;
  left_out: number;
  sigma_mm: number;
  sigma_deg: number;
  rms_px: number;
  clock_offset_ms: number | null;
}

export interface RigReport {
  reference: string;
  images: number;
  images_used: number;
  rms_px: number;
  cameras: CalibratedCamera[];
  verdict: Verdict;
}

export interface LearnedTag {
  tag: string;
  images: number;
  left_out: number;
  sigma_mm: number;
  sigma_deg: number;
  rms_px: number;
}

export interface LearnReport {
  object: string;
  images: number;
  images_used: number;
  rms_px: number;
  tags: LearnedTag[];
  kept: string[];
  verdict: Verdict;
}

export interface Result {
  report: LensReport | RigReport | LearnReport;
  model: { cameras?: RigCamera[]; tags?: ObjectTag[] };
  file: string;
  toml: string;
  kept: string[];
}

export interface WizardAccount {
  type: "wizard";
  wizard: Kind | null;
  stage: Stage;
  /** A camera or an object. */
  subject?: string;
  /** What went wrong last. */
  cause?: string;
  missed?: number;
  progress?: Progress;
  result?: Result;
}

export const IDLE: WizardAccount = { type: "wizard", wizard: null, stage: "idle" };

const oneOf = (...words: string[]): Test => (value) => typeof value === "string" && words.includes(value);
const anyOf = (...tests: Test[]): Test => (value) => tests.some((test) => test(value));
const pair: Test = (value) =>
  Array.isArray(value) && value.length === 3 && isText(value[0]) && isText(value[1]) && isNumber(value[2]);

const lensDetails: Shape = { views: isNumber, coverage: listOf(listOf(isNumber)), tilted: numbers(4) };
const rigDetails: Shape = {
  cameras: listOf(
    shaped({ camera: isText, images: isNumber, seeing: isNumber, fields: listOf(isFlag), distances: isNumber, group: isNumber }),
  ),
  together: listOf(pair),
};
const learnDetails: Shape = {
  joining: isNumber,
  tags: listOf(shaped({ tag: isText, images: isNumber, directions: isNumber, group: isNumber })),
  sketch: listOf(shaped({ tag: isText, size_m: isNumber, position: numbers(3), orientation: numbers(4) })),
};
const progress: Shape = {
  images: isNumber,
  fraction: isNumber,
  is_enough: isFlag,
  hint: isText,
  details: anyOf(shaped(lensDetails), shaped(rigDetails), shaped(learnDetails)),
};

const verdict = shaped({ grade: oneOf("good", "usable", "poor"), because: listOf(isText) });
const cell: Shape = { corners: isNumber, mean_px: numbers(2), rms_px: isNumber, sigma_px: orNull(isNumber) };
const lensReport: Shape = {
  camera: isText,
  lens: shaped({ model: isText, fx: isNumber, fy: isNumber, cx: isNumber, cy: isNumber, distortion: optional(listOf(isNumber)) }),
  sigmas: listOf(isNumber),
  rms_px: isNumber,
  noise_px: isNumber,
  images: isNumber,
  views: isNumber,
  coverage: isNumber,
  models: listOf(shaped({ model: isText, held_out_rms_px: isNumber })),
  cells: listOf(listOf(shaped(cell))),
  verdict,
};
const figures: Shape = { images: isNumber, left_out: isNumber, sigma_mm: isNumber, sigma_deg: isNumber, rms_px: isNumber };
const rigReport: Shape = {
  reference: isText,
  images: isNumber,
  images_used: isNumber,
  rms_px: isNumber,
  cameras: listOf(shaped({ camera: isText, clock_offset_ms: orNull(isNumber), ...figures })),
  verdict,
};
const learnReport: Shape = {
  object: isText,
  images: isNumber,
  images_used: isNumber,
  rms_px: isNumber,
  tags: listOf(shaped({ tag: isText, ...figures })),
  kept: listOf(isText),
  verdict,
};

/** The fields of the message. The parts of the site's models in it are checked as those are. */
export function accountShape(camera: Test, tag: Test): Shape {
  const model = shaped({ cameras: optional(listOf(camera)), tags: optional(listOf(tag)) });
  return {
    wizard: orNull(oneOf("lens", "rig", "learn")),
    stage: oneOf("idle", "collecting", "solving", "solved", "keeping", "kept"),
    subject: optional(isText),
    cause: optional(isText),
    missed: optional(isNumber),
    progress: optional(shaped(progress)),
    result: optional(
      shaped({
        report: anyOf(shaped(lensReport), shaped(rigReport), shaped(learnReport)),
        model,
        file: isText,
        toml: isText,
        kept: listOf(isText),
      }),
    ),
  };
}
