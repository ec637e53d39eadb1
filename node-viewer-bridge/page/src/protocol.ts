// The bridge's messages (../PROTOCOL.md) and how they are read. Whatever does not look like a message becomes `null`.
// Knows nothing of the page.

import { isRejectionCause, MESSAGES, type CameraStatus, type ClockReport, type DetectionReport, type RejectionCause, type TagOutline } from "./messages.ts";
import { isObject, isText, type Checked } from "./shape.ts";

export type * from "./messages.ts";

export type Vec3 = [number, number, number];
/** x, y, z, w. */
export type Quaternion = [number, number, number, number];
export type Point = [number, number];
export type Corners = TagOutline["corners"];
export type RejectedCandidate = DetectionReport["examples"][number];
export type CameraControls = CameraStatus["controls"];
export type CameraClock = ClockReport["cameras"][number];

/** Why a candidate is no tag, in the order in which the detector asks. */
export type Cause = RejectionCause;
export const CAUSES = isRejectionCause.words;
export const STAGES = ["tiles", "threshold", "components", "quads", "decode", "refine"] as const satisfies (keyof DetectionReport["stage_ms"])[];
export type StageName = (typeof STAGES)[number];

type Type = keyof typeof MESSAGES;
export type Message = { [T in Type]: { type: T } & Checked<(typeof MESSAGES)[T]> }[Type];

export interface Preview {
  camera: string;
  t_ns: number;
  jpeg: Uint8Array<ArrayBuffer>;
}

/** One text frame as a message; `null` for a type that this page does not know and for anything malformed. */
export function parseMessage(text: string): Message | null {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return null;
  }
  if (!isObject(value) || !isText(value.type) || !Object.hasOwn(MESSAGES, value.type)) return null;
  return MESSAGES[value.type as Type](value) ? (value as Message) : null;
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
