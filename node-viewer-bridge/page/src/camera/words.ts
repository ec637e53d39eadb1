// What the camera's page and its worker say to each other.

import type { Light, Point } from "../../../../clients/web/dist/sextant.js";

export interface StartMessage {
  type: "begin";
  /** The bridge's WebSocket, with name and key. */
  url: string;
  camera: string;
  /** The device's name. */
  host: string;
  pictures: boolean;
}

/** An image: it is the worker's to close. */
export interface FrameMessage {
  type: "taken";
  image: VideoFrame | ImageBitmap;
  /** ms since the Unix epoch by this device's clock. */
  captureMs: number;
  isArrival: boolean;
  /** When the page sent it, by the page's clock. */
  sentMs: number;
  /** Images that the camera has delivered so far. */
  captured: number;
}

/** The camera has delivered no image for a while. */
export interface Silence {
  type: "silent";
}

export type ToWorker = StartMessage | FrameMessage | Silence | { type: "end" };

export interface DetectionResult {
  type: "seen";
  outlines: { id: number; corners: Point[] }[];
  size: [number, number];
  light: Light;
  rateHz: number;
  detectMs: number;
}

/** How the bridge finds this camera. */
export interface Report {
  type: "report";
  clock_error_ms: number | null;
  published: number;
  refused: number;
  cause: string | null;
  watched: boolean;
  in_rig: boolean;
  /** What the site finds wrong with this camera, in words. */
  faults: string[];
  /** Those of the site's tags. */
  families: string[];
}

export type Link = { type: "link"; condition: "connecting" | "joined" | "lost" | "refused" | "ended"; words: string };
/** Families of the site's tags that this detector does not read. */
export interface Unread {
  type: "unread";
  families: string[];
}

export type FromWorker = DetectionResult | Report | Link | Unread | { type: "ready" } | { type: "failed"; cause: string };

/**
 * Now, ms since the Unix epoch by a clock that does not step. The page's and a worker's may differ by how the device's
 * was set between their beginnings.
 */
export const nowMs = () => performance.timeOrigin + performance.now();
