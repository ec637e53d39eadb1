// How far a camera's corners lie from where the poses and the rig put them: reprojection errors with the models as
// published. Fusion corrects for what it finds wrong in these models, so its own residuals are smaller.

import { projectWorld, tagCorners, transformed } from "./lens.ts";
import type { Observations, PrintedTag, Point, Pose, RigCamera } from "./protocol.ts";

/** An object as it was at the time of an image. */
export interface PlacedObject {
  tags: readonly PrintedTag[];
  pose: Pose;
}

/** A tag's corners as a camera should see them; none where one is out of its field. */
export function projectedTag(camera: RigCamera, pose: Pose, tag: PrintedTag): Point[] | null {
  const place = tag.object_from_tag;
  if (!place) return null;
  const corners: Point[] = [];
  for (const corner of tagCorners(tag.size_m)) {
    const pixel = projectWorld(camera, transformed(pose, transformed(place, corner)));
    if (!pixel) return null;
    corners.push(pixel);
  }
  return corners;
}

/** Whether a tag's face is turned to the camera: its corners then run clockwise in the image. */
export function facesCamera(corners: readonly Point[]): boolean {
  let area = 0;
  for (let k = 0; k < corners.length; k++) {
    const [[ax, ay], [bx, by]] = [corners[k] as Point, corners[(k + 1) % corners.length] as Point];
    area += ax * by - bx * ay;
  }
  return area > 0;
}

/**
 * Root mean square distance of an image's corners from their projections, pixels; none where no placed object is in it.
 */
export function rmsResidual(camera: RigCamera, image: Observations, owner: (family: string, id: number) => PlacedObject | null): number | null {
  let [sum, n] = [0, 0];
  for (const seen of image.tags) {
    const object = owner(seen.family, seen.id);
    const tag = object?.tags.find((tag) => tag.id === seen.id && tag.family === seen.family);
    const projected = object && tag ? projectedTag(camera, object.pose, tag) : null;
    if (!projected) continue;
    for (let k = 0; k < 4; k++) {
      const [[u, v], [x, y]] = [projected[k] as Point, seen.corners[k] as Point];
      sum += (u - x) ** 2 + (v - y) ** 2;
      n++;
    }
  }
  return n > 0 ? Math.sqrt(sum / n) : null;
}
