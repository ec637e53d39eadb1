// The bridge's messages (../PROTOCOL.md) and how they are read. Whatever does not look like a message becomes `null`.
// Knows nothing of the page.

import { isFinding, type CameraFindings, type Findings } from "./findings.ts";
import { fits, isFlag, isNumber, isText, listOf, numbers, optional, orNull, shaped, type Shape, type Test } from "./shape.ts";
import { accountShape, type WizardAccount } from "./wizard/account.ts";

export type Vec3 = [number, number, number];
/** x, y, z, w. */
export type Quaternion = [number, number, number, number];
export type Point = [number, number];

export interface Transform {
  position: Vec3;
  orientation: Quaternion;
}

export interface Lens {
  model: string;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  /** Of the model's polynomial; none of a pinhole. */
  distortion?: number[];
}

export interface RigCamera {
  id: string;
  resolution: [number, number];
  lens: Lens;
  world_from_camera: Transform | null;
}

export interface ObjectTag {
  family: string;
  id: number;
  size_m: number;
  /** Edge of the whole print, white ring included. */
  printed_size_m: number;
  object_from_tag: Transform | null;
  /** Rows of the printed tag, top first; "1" is white. */
  modules: string[];
}

export type State = "initialising" | "tracking" | "coasting" | "lost";

export interface Pose extends Transform {
  type: "pose";
  object: string;
  sequence: number;
  t_ns: number;
  covariance: number[];
  twist: number[];
  state: State;
  cameras: number;
  tags: number;
  rms_px: number;
  latency_ms: number;
}

export interface TagOutline {
  family: string;
  id: number;
  corners: [Point, Point, Point, Point];
}

export interface Observations {
  type: "observations";
  camera: string;
  sequence: number;
  t_ns: number;
  latency_ms: number;
  resolution: [number, number];
  tags: TagOutline[];
}

/** One setting of a camera: what the site wants, what is in force, what is possible. */
export interface Control {
  wanted: number | null;
  value: number | null;
  range: [number, number] | null;
}

export interface CameraControls {
  exposure_us: Control;
  gain: Control;
  rate_hz: Control;
  outcome: "none" | "pending" | "applied" | { adjusted: { detail: string } } | { refused: { detail: string } };
}

export interface CameraStatus extends CameraFindings {
  type: "camera_status";
  camera: string;
  captured: number;
  detected: number;
  dropped: number;
  rate_hz: number;
  clock: { source: string; error_ns: number };
  brightness: number;
  controls: CameraControls;
}

/** Why a candidate is no tag, in the order in which the detector asks. */
export const CAUSES = ["not_a_quad", "shape", "faint_border", "no_code", "small_margin"] as const;
export type Cause = (typeof CAUSES)[number];

export const STAGES = ["tiles", "threshold", "components", "quads", "decode", "refine"] as const;
export type StageName = (typeof STAGES)[number];

export interface RejectedCandidate {
  cause: Cause;
  corners: [Point, Point, Point, Point];
}

/** What a detector made of one image. */
export interface DetectionReport {
  type: "detection_report";
  camera: string;
  capture_ns: number;
  searched: number;
  stage_ms: Record<StageName, number>;
  noise_sigma: number;
  contrast_gate: number;
  candidates: number;
  tags: number;
  rejected: Record<Cause, number>;
  examples: RejectedCandidate[];
}

/** A joint of an articulated object: rad where it turns, m where it slides. */
export interface JointValue {
  joint: string;
  value: number;
  sigma: number;
  velocity: number;
}

export interface Joints {
  type: "joints";
  object: string;
  t_ns: number;
  joints: JointValue[];
}

/** A part of the world with a name, and the objects in it. */
export interface Zone {
  name: string;
  shape: "box" | "sphere";
  centre: Vec3;
  /** Of a box: its edges, and how it is turned about z. */
  size?: Vec3;
  yaw_deg?: number;
  /** Of a sphere. */
  radius?: number;
  inside: string[];
}

/** What an object did. */
export interface SiteEvent {
  sequence: number;
  t_ns: number;
  object: string;
  event: string;
  zone?: string;
  cause?: string;
}

/** One camera's clock, as its images tell. */
export interface CameraClock {
  camera: string;
  offset_s: number;
  sigma_s: number;
  /** Seconds a second. */
  drift: number | null;
}

export interface FusionStatus extends Findings {
  type: "fusion_status";
  node: string;
  /** Of the poses that it publishes; none while it stands by. */
  epoch: number | null;
}

/** Models that a fusion node offers to be put in force; without rig and objects there is nothing. */
export interface Offer {
  node: string;
  /** Whether cameras are among them. */
  rig: boolean;
  objects: string[];
}

export type Message =
  | { type: "hello"; site: string; version: string; protocol: number; now_ns: number; role: string }
  | { type: "rig"; cameras: RigCamera[] }
  | { type: "object"; id: string; tags: ObjectTag[] }
  | { type: "object_gone"; id: string }
  | Pose
  | ({ type: "truth"; object: string; t_ns: number; error_mm: number; error_deg: number } & Transform)
  | Observations
  | CameraStatus
  | DetectionReport
  | FusionStatus
  | ({ type: "proposal" | "former" } & Offer)
  | Joints
  | { type: "zones"; zones: Zone[]; kept: boolean }
  | { type: "events"; events: SiteEvent[]; dropped: number }
  | { type: "clocks"; node: string; cameras: CameraClock[] }
  | WizardAccount
  | { type: "alive"; kind: string; id: string; up: boolean }
  | { type: "bridge_status"; now_ns: number; network: boolean; replaced: number };

export interface Preview {
  camera: string;
  t_ns: number;
  jpeg: Uint8Array<ArrayBuffer>;
}

const isState = (value: unknown): boolean =>
  value === "initialising" || value === "tracking" || value === "coasting" || value === "lost";

const transform: Shape = { position: numbers(3), orientation: numbers(4) };
const lens: Shape = { model: isText, fx: isNumber, fy: isNumber, cx: isNumber, cy: isNumber, distortion: optional(listOf(isNumber)) };
const rigCamera = shaped({
  id: isText,
  resolution: numbers(2),
  lens: shaped(lens),
  world_from_camera: orNull(shaped(transform)),
});
const objectTag = shaped({
  family: isText,
  id: isNumber,
  size_m: isNumber,
  printed_size_m: isNumber,
  object_from_tag: orNull(shaped(transform)),
  modules: listOf(isText),
});
const isQuad = (value: unknown): boolean => Array.isArray(value) && value.length === 4 && value.every(numbers(2));
const outline: Shape = { family: isText, id: isNumber, corners: isQuad };
const isCause = (value: unknown): boolean => CAUSES.some((cause) => cause === value);
const numberOfEach = (names: readonly string[]): ((value: unknown) => boolean) =>
  shaped(Object.fromEntries(names.map((name) => [name, isNumber])));

const inZone: Shape = { name: isText, centre: numbers(3), inside: listOf(isText) };
const isZone: Test = (value) =>
  fits(value, { ...inZone, shape: (shape) => shape === "box", size: numbers(3), yaw_deg: isNumber }) ||
  fits(value, { ...inZone, shape: (shape) => shape === "sphere", radius: isNumber });
const offer: Shape = { node: isText, rig: isFlag, objects: listOf(isText) };

const control = shaped({ wanted: orNull(isNumber), value: orNull(isNumber), range: orNull(numbers(2)) });
const detailed = shaped({ detail: isText });
const isOutcome: Test = (value) =>
  value === "none" || value === "pending" || value === "applied" || fits(value, { adjusted: detailed }) || fits(value, { refused: detailed });

const shapes: Record<Message["type"], Shape> = {
  hello: { site: isText, version: isText, protocol: isNumber, now_ns: isNumber, role: isText },
  rig: {
    cameras: listOf(rigCamera),
  },
  object: {
    id: isText,
    tags: listOf(objectTag),
  },
  object_gone: { id: isText },
  pose: {
    ...transform,
    object: isText,
    sequence: isNumber,
    t_ns: isNumber,
    covariance: numbers(36),
    twist: numbers(6),
    state: isState,
    cameras: isNumber,
    tags: isNumber,
    rms_px: isNumber,
    latency_ms: isNumber,
  },
  truth: { ...transform, object: isText, t_ns: isNumber, error_mm: isNumber, error_deg: isNumber },
  observations: {
    camera: isText,
    sequence: isNumber,
    t_ns: isNumber,
    latency_ms: isNumber,
    resolution: numbers(2),
    tags: listOf(shaped(outline)),
  },
  camera_status: {
    camera: isText,
    captured: isNumber,
    detected: isNumber,
    dropped: isNumber,
    rate_hz: isNumber,
    clock: shaped({ source: isText, error_ns: isNumber }),
    brightness: isNumber,
    controls: shaped({ exposure_us: control, gain: control, rate_hz: control, outcome: isOutcome }),
    fallbacks: isNumber,
    notices: listOf(isFinding),
  },
  detection_report: {
    camera: isText,
    capture_ns: isNumber,
    searched: isNumber,
    stage_ms: numberOfEach(STAGES),
    noise_sigma: isNumber,
    contrast_gate: isNumber,
    candidates: isNumber,
    tags: isNumber,
    rejected: numberOfEach(CAUSES),
    examples: listOf(shaped({ cause: isCause, corners: isQuad })),
  },
  fusion_status: {
    node: isText,
    epoch: orNull(isNumber),
    faults: listOf(isFinding),
    faults_left_out: isNumber,
    imperfections: listOf(isFinding),
    notices: listOf(isFinding),
  },
  joints: {
    object: isText,
    t_ns: isNumber,
    joints: listOf(shaped({ joint: isText, value: isNumber, sigma: isNumber, velocity: isNumber })),
  },
  zones: { zones: listOf(isZone), kept: isFlag },
  events: {
    events: listOf(shaped({ sequence: isNumber, t_ns: isNumber, object: isText, event: isText, zone: optional(isText), cause: optional(isText) })),
    dropped: isNumber,
  },
  proposal: offer,
  former: offer,
  clocks: {
    node: isText,
    cameras: listOf(shaped({ camera: isText, offset_s: isNumber, sigma_s: isNumber, drift: orNull(isNumber) })),
  },
  wizard: accountShape(rigCamera, objectTag),
  alive: { kind: isText, id: isText, up: isFlag },
  bridge_status: { now_ns: isNumber, network: isFlag, replaced: isNumber },
};

/** One text frame as a message; `null` for a type that this page does not know and for anything malformed. */
export function parseMessage(text: string): Message | null {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return null;
  }
  if (typeof value !== "object" || value === null) return null;
  const type = (value as { type?: unknown }).type;
  if (typeof type !== "string" || !Object.hasOwn(shapes, type)) return null;
  return fits(value, shapes[type as Message["type"]]) ? (value as Message) : null;
}

const JPEG_PREVIEW = 1;

/** One binary frame as a preview picture; `null` for another kind or a truncated frame. */
export function parsePreview(frame: ArrayBuffer): Preview | null {
  if (frame.byteLength < 2) return null;
  const view = new DataView(frame);
  const pictureAt = 2 + view.getUint8(1) + 8;
  if (view.getUint8(0) !== JPEG_PREVIEW || frame.byteLength <= pictureAt) return null;
  const camera = new TextDecoder("ascii").decode(new Uint8Array(frame, 2, pictureAt - 10));
  const t_ns = Number(view.getBigUint64(pictureAt - 8, true));
  return { camera, t_ns, jpeg: new Uint8Array(frame, pictureAt) };
}
