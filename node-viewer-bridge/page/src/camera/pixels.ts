// Grey pixels of an image in the detector's memory: the first plane of a camera's own format without a copy in between,
// else by a canvas.

import type { Detector, Tag } from "../../../../clients/web/dist/sextant.js";

/** Formats whose first plane is grey. */
const PLANAR = new Set(["I420", "I420A", "I422", "I444", "NV12"]);
const COLOURS = new Set(["RGBA", "RGBX", "BGRA", "BGRX"]);

let canvas: OffscreenCanvas | null = null;

export type Image = VideoFrame | ImageBitmap;

export const sizeOf = (image: Image): [number, number] => ("displayWidth" in image ? [image.displayWidth, image.displayHeight] : [image.width, image.height]);

/** The image on a canvas, so many times as large. */
export function drawn(image: Image, scale: number): OffscreenCanvas {
  const [width, height] = sizeOf(image).map((n) => Math.max(1, Math.round(n * scale))) as [number, number];
  canvas ??= new OffscreenCanvas(width, height);
  [canvas.width, canvas.height] = [width, height];
  canvas.getContext("2d", { willReadFrequently: true })?.drawImage(image, 0, 0, width, height);
  return canvas;
}

export async function detect(detector: Detector, image: Image): Promise<Tag[]> {
  const [width, height] = sizeOf(image);
  if ("copyTo" in image && image.format && image.visibleRect?.width === width && image.visibleRect.height === height) {
    const isPlanar = PLANAR.has(image.format);
    if (isPlanar || COLOURS.has(image.format)) {
      const [plane] = await image.copyTo(detector.pixels(image.allocationSize()));
      if (plane?.offset === 0 && (isPlanar || plane.stride === 4 * width)) return detector.detectPixels(width, height, plane.stride, isPlanar ? 1 : 4);
    }
  }
  const data = drawn(image, 1).getContext("2d")?.getImageData(0, 0, width, height);
  return data ? detector.detect(data) : [];
}
