// Through a camera's eye: its live picture, and over it what fusion and calibration say should be there, projected
// through the camera's own lens. The picture stays distorted as it is and the drawing is distorted like it, so that any
// gap between the two is an error.

import { projectWorld, rotate } from "../lens.ts";
import { onPicture } from "../matching.ts";
import { STAGE, STRANGER } from "../palette.ts";
import { element, testId, Text } from "../panels/dom.ts";
import { fixed, NONE } from "../format.ts";
import type { Point, Pose, RigCamera, Vec3 } from "../protocol.ts";
import { facesCamera, projectedTag, rmsResidual } from "../residuals.ts";
import { blankPose } from "../history.ts";
import { type CameraState, type ObjectState, poseAt, type Site } from "../site.ts";

const AXIS_M = 0.06;
const GRID_M = 0.25;
const GRID_LINES = 8;
/** Straight lines of the world are bent by the lens: they are drawn in pieces. */
const PIECES = 16;

/** A picture of a camera, and when it was taken. */
export interface EyePicture {
  readonly canvas: HTMLCanvasElement;
  readonly t_ns: number | null;
}

export class Eye {
  private readonly canvas = testId(element("canvas"), "eye");
  private readonly title = new Text(element("strong"));
  private readonly residual = new Text(testId(element("span"), "eye-residual"));
  private readonly pose = blankPose("");
  private camera: CameraState | null = null;
  private picture: EyePicture | null = null;
  /** Left, top and size of the picture on the canvas, pixels of the page. */
  private frame = { left: 0, top: 0, width: 1, height: 1 };

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
    leave: () => void,
  ) {
    const close = testId(element("button", "press", "Back to the stage"), "eye-close");
    close.type = "button";
    close.addEventListener("click", leave);
    const legend = element("p", "legend", element("i", "projected"), "where the poses put the tags", element("i", "detected"), "where the camera sees them");
    root.append(this.canvas, element("div", "caption", this.title.element, this.residual.element, legend, close));
    new ResizeObserver(() => this.draw()).observe(root);
  }

  /** Looks through a camera, or through none. */
  open(camera: CameraState | null, picture: EyePicture | null): void {
    this.camera = camera;
    this.picture = picture;
    this.root.hidden = camera === null;
    if (camera) this.title.set(camera.id);
    this.draw();
  }

  /** A new picture of this camera is there. */
  draw(): void {
    const context = this.canvas.getContext("2d");
    const { camera, picture } = this;
    if (!context || !camera || !picture || this.root.hidden) return;
    this.fit(context, camera);
    const { left, top, width, height } = this.frame;
    context.save();
    context.beginPath();
    context.rect(left, top, width, height);
    context.clip();
    if (picture.canvas.width > 1) context.drawImage(picture.canvas, left, top, width, height);
    this.drawModels(context, camera, picture);
    context.restore();
  }

  private drawModels(context: CanvasRenderingContext2D, camera: CameraState, picture: EyePicture): void {
    const time = (picture.t_ns ?? 0) / 1e9;
    const model = this.site.modelAt(camera, time);
    if (!model || !camera.resolution) return this.residual.set(camera.model?.mount ? "its carrier has no pose" : "not calibrated");
    this.drawWorld(context, model);
    let tags = 0;
    for (const object of this.site.objects.values()) if (poseAt(object, time, this.pose)) tags += this.drawObject(context, model, object);
    this.drawDetected(context, camera, picture.t_ns ?? 0);
    this.canvas.dataset["tags"] = String(tags);
    this.showResidual(model, camera, picture.t_ns ?? 0);
  }

  private fit(context: CanvasRenderingContext2D, camera: CameraState): void {
    const ratio = Math.min(2, window.devicePixelRatio);
    const [across, down] = [this.root.clientWidth, this.root.clientHeight];
    const [width, height] = [Math.round(across * ratio), Math.round(down * ratio)];
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    const image = camera.resolution ?? [4, 3];
    const scale = Math.min(across / image[0], down / image[1]);
    const size: [number, number] = [image[0] * scale, image[1] * scale];
    this.frame = { left: (across - size[0]) / 2, top: (down - size[1]) / 2, width: size[0], height: size[1] };
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, across, down);
    context.lineJoin = context.lineCap = "round";
  }

  /** A pixel of the image on the canvas. */
  private place(pixel: Point): Point {
    const { left, top, width, height } = this.frame;
    const [x, y] = onPicture(pixel, this.camera?.resolution ?? [1, 1], [width, height]);
    return [left + x, top + y];
  }

  private drawWorld(context: CanvasRenderingContext2D, camera: RigCamera): void {
    context.globalAlpha = 0.35;
    const reach = (GRID_LINES / 2) * GRID_M;
    for (let k = -GRID_LINES / 2; k <= GRID_LINES / 2; k++) {
      const at = k * GRID_M;
      this.line(context, camera, [at, -reach, 0], [at, reach, 0], "#ffffff", 0.8);
      this.line(context, camera, [-reach, at, 0], [reach, at, 0], "#ffffff", 0.8);
    }
    context.globalAlpha = 0.9;
    this.axes(context, camera, [0, 0, 0], [0, 0, 0, 1], 2 * AXIS_M);
    context.globalAlpha = 1;
  }

  /** Returns how many tags were drawn. */
  private drawObject(context: CanvasRenderingContext2D, camera: RigCamera, object: ObjectState): number {
    let drawn = 0;
    for (const tag of object.tags) {
      const corners = projectedTag(camera, this.pose, tag);
      if (!corners || !facesCamera(corners)) continue;
      drawn++;
      outline(context, corners.map((corner) => this.place(corner)), object.colour, 2);
    }
    this.axes(context, camera, this.pose.position, this.pose.orientation, AXIS_M);
    const name = projectWorld(camera, this.pose.position);
    if (name) write(context, object.id, this.place(name), object.colour);
    return drawn;
  }

  private drawDetected(context: CanvasRenderingContext2D, camera: CameraState, t_ns: number): void {
    for (const tag of camera.outlines.at(t_ns)) {
      const known = this.site.ownerOf(tag.family, tag.id) !== null;
      for (const corner of tag.corners) cross(context, this.place(corner), known ? "#ffffff" : STRANGER);
    }
  }

  private showResidual(camera: RigCamera, state: CameraState, t_ns: number): void {
    const image = state.outlines.before(t_ns);
    const at = image && Math.abs(image.t_ns - t_ns) < 1e6 ? image : null;
    const rms = at && rmsResidual(camera, at, (family, id) => {
      const object = this.site.ownerOf(family, id);
      return object && poseAt(object, t_ns / 1e9, this.pose) ? { tags: object.tags, pose: this.pose } : null;
    });
    this.residual.set(`residual ${rms === null ? NONE : fixed(rms, 2)} px`);
  }

  private axes(context: CanvasRenderingContext2D, camera: RigCamera, origin: Vec3, orientation: Pose["orientation"], length: number): void {
    const [ox, oy, oz] = origin;
    STAGE.axes.forEach((colour, axis) => {
      const [x, y, z] = rotate(orientation, [axis === 0 ? length : 0, axis === 1 ? length : 0, axis === 2 ? length : 0]);
      this.line(context, camera, origin, [ox + x, oy + y, oz + z], colour, 2);
    });
  }

  private line(context: CanvasRenderingContext2D, camera: RigCamera, from: Vec3, to: Vec3, colour: string, width: number): void {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    let connected = false;
    for (let k = 0; k <= PIECES; k++) {
      const share = k / PIECES;
      const mix = (axis: 0 | 1 | 2): number => from[axis] + (to[axis] - from[axis]) * share;
      const pixel = projectWorld(camera, [mix(0), mix(1), mix(2)]);
      if (pixel) {
        const [x, y] = this.place(pixel);
        if (connected) context.lineTo(x, y);
        else context.moveTo(x, y);
      }
      connected = pixel !== null;
    }
    context.stroke();
  }
}

function outline(context: CanvasRenderingContext2D, corners: Point[], colour: string, width: number): void {
  context.beginPath();
  for (const [x, y] of corners) context.lineTo(x, y);
  context.closePath();
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

function cross(context: CanvasRenderingContext2D, [x, y]: Point, colour: string): void {
  const arm = 4;
  context.strokeStyle = colour;
  context.lineWidth = 1.2;
  context.beginPath();
  context.moveTo(x - arm, y);
  context.lineTo(x + arm, y);
  context.moveTo(x, y - arm);
  context.lineTo(x, y + arm);
  context.stroke();
}

function write(context: CanvasRenderingContext2D, text: string, [x, y]: Point, colour: string): void {
  context.font = "600 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.strokeStyle = "rgba(8, 11, 15, 0.8)";
  context.lineWidth = 3;
  context.strokeText(text, x, y - 8);
  context.fillStyle = colour;
  context.fillText(text, x, y - 8);
}
