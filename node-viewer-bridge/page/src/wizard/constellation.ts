// The constellation as a small 3-D picture that grows while tags are joined: drag or arrow keys turn it.

import { element, testId } from "../panels/dom.ts";
import { appear, type Drawn, type Orbit, type Patch } from "./solid.ts";

const MAX_PIXEL_RATIO = 2;
const START: Orbit = { turn: 0.6, tilt: 0.5 };
/** Radians a pixel of dragging, and a key. */
const DRAG = 0.01;
const KEY = 0.15;
/** Below this size on the screen a tag has no room for its number. */
const LEGIBLE_PX = 13;
/** How far a camera's name stands from it: names are wider than high. */
const NAME_PX = { across: 30, down: 16 };

export class ConstellationView {
  readonly canvas = testId(element("canvas", "constellation"), "wizard-constellation");
  private readonly orbit: Orbit = { ...START };
  private patches: Patch[] = [];
  private wanted = false;

  constructor() {
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) this.turn(event.movementX * DRAG, event.movementY * DRAG);
    });
    this.canvas.addEventListener("pointerdown", (event) => this.canvas.setPointerCapture(event.pointerId));
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
  }

  show(patches: Patch[], label: string): void {
    this.patches = patches;
    this.canvas.dataset["tags"] = String(patches.length);
    if (this.canvas.getAttribute("aria-label") !== label) this.canvas.setAttribute("aria-label", label);
    this.redraw();
  }

  private turn(turn: number, tilt: number): void {
    this.orbit.turn -= turn;
    this.orbit.tilt = Math.min(1.5, Math.max(-1.5, this.orbit.tilt + tilt));
    this.redraw();
  }

  private key(event: KeyboardEvent): void {
    const turns: Record<string, [number, number]> = {
      ArrowLeft: [-KEY, 0],
      ArrowRight: [KEY, 0],
      ArrowUp: [0, -KEY],
      ArrowDown: [0, KEY],
    };
    const turn = turns[event.key];
    if (!turn) return;
    event.preventDefault();
    this.turn(...turn);
  }

  private redraw(): void {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => {
      this.wanted = false;
      this.draw();
    });
  }

  private draw(): void {
    const context = this.canvas.getContext("2d");
    if (!context) return;
    const ratio = Math.min(window.devicePixelRatio, MAX_PIXEL_RATIO);
    const size: [number, number] = [this.canvas.clientWidth, this.canvas.clientHeight];
    this.canvas.width = Math.round(size[0] * ratio);
    this.canvas.height = Math.round(size[1] * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    for (const drawn of appear(this.patches, this.orbit, size)) drawPatch(context, drawn);
  }
}

function drawPatch(context: CanvasRenderingContext2D, drawn: Drawn): void {
  if (drawn.apex) return drawPyramid(context, drawn, drawn.apex);
  const { patch, corners, centre, faces } = drawn;
  context.beginPath();
  for (const [x, y] of corners) context.lineTo(x, y);
  context.closePath();
  context.lineJoin = "round";
  context.fillStyle = faces ? `color-mix(in srgb, ${patch.colour} 34%, #11151a)` : "#171c23";
  context.globalAlpha = faces ? 0.94 : 0.8;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = faces ? patch.colour : `color-mix(in srgb, ${patch.colour} 45%, #11151a)`;
  context.lineWidth = faces ? 1.8 : 1;
  context.stroke();
  if (!faces) return;
  const room = Math.sqrt(Math.abs(shoelace(corners)));
  if (room < LEGIBLE_PX) return;
  context.font = `600 ${Math.min(18, 0.42 * room)}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillStyle = "#f1f4f8";
  context.fillText(patch.name, centre[0], centre[1]);
}

/** Its name stands behind it, where it hides none of its lines. */
function drawPyramid(context: CanvasRenderingContext2D, { patch, corners, centre }: Drawn, apex: [number, number]): void {
  context.beginPath();
  for (const corner of corners) {
    context.moveTo(...apex);
    context.lineTo(...corner);
  }
  context.moveTo(...(corners.at(-1) ?? apex));
  for (const corner of corners) context.lineTo(...corner);
  context.lineJoin = "round";
  context.strokeStyle = patch.colour;
  context.lineWidth = 1.5;
  context.stroke();
  context.beginPath();
  context.arc(...apex, 3.5, 0, 2 * Math.PI);
  context.fillStyle = patch.colour;
  context.fill();
  context.font = "500 12.5px system-ui, sans-serif";
  context.textAlign = "center";
  context.fillStyle = "#e8ecf1";
  context.textBaseline = "middle";
  const [dx, dy] = [apex[0] - centre[0], apex[1] - centre[1]];
  const length = Math.max(1, Math.hypot(dx, dy));
  context.fillText(patch.name, apex[0] + (NAME_PX.across * dx) / length, apex[1] + (NAME_PX.down * dy) / length);
}

function shoelace(corners: [number, number][]): number {
  const sum = corners.reduce((sum, [x, y], at) => {
    const [nextX, nextY] = corners[(at + 1) % corners.length] as [number, number];
    return sum + x * nextY - nextX * y;
  }, 0);
  return sum / 2;
}
