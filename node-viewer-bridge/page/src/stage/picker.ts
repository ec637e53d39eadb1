// What a click on the stage means: an object is followed, a camera looked through; with the shift key two objects are
// measured. A drag is no click.

import { type Camera, type Object3D, Raycaster, Vector2 } from "three";
import type { Selection } from "../selection.ts";

/** Pixels that the pointer may wander during a click. */
const SLACK_PX = 5;
/** Pixels around the pointer that are tried, for what is small. */
const REACH_PX = [[0, 0], [8, 0], [-8, 0], [0, 8], [0, -8]] as const;

interface Pickable {
  objects: ReadonlyMap<string, { readonly group: Object3D; readonly visible: boolean }>;
  cameras: ReadonlyMap<string, { readonly group: Object3D }>;
}

interface Hit {
  kind: "object" | "camera";
  id: string;
}

export class Picker {
  private readonly ray = new Raycaster();
  private readonly point = new Vector2();
  private pressed: [number, number] | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly camera: Camera,
    private readonly things: Pickable,
    private readonly selection: Selection,
  ) {
    this.ray.params.Line.threshold = 0.012;
    canvas.addEventListener("pointerdown", (event) => (this.pressed = event.isPrimary && event.button === 0 ? [event.clientX, event.clientY] : null));
    canvas.addEventListener("pointerup", (event) => this.release(event));
  }

  private release(event: PointerEvent): void {
    const pressed = this.pressed;
    this.pressed = null;
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > SLACK_PX) return;
    const hit = this.at(event.clientX, event.clientY);
    if (hit?.kind === "camera") this.selection.lookThrough(hit.id);
    else if (hit && event.shiftKey && this.selection.object !== null && this.selection.object !== hit.id) this.selection.measure([this.selection.object, hit.id]);
    else this.selection.follow(hit?.id ?? null);
  }

  private at(x: number, y: number): Hit | null {
    for (const [dx, dy] of REACH_PX) {
      const hit = this.exactlyAt(x + dx, y + dy);
      if (hit) return hit;
    }
    return null;
  }

  private exactlyAt(x: number, y: number): Hit | null {
    const frame = this.canvas.getBoundingClientRect();
    this.point.set((2 * (x - frame.left)) / frame.width - 1, 1 - (2 * (y - frame.top)) / frame.height);
    this.ray.setFromCamera(this.point, this.camera);
    let [nearest, distance]: [Hit | null, number] = [null, Infinity];
    const offer = (kind: Hit["kind"], id: string, group: Object3D): void => {
      const [first] = this.ray.intersectObject(group, true);
      if (first && first.distance < distance) [nearest, distance] = [{ kind, id }, first.distance];
    };
    for (const [id, thing] of this.things.objects) if (thing.visible) offer("object", id, thing.group);
    for (const [id, thing] of this.things.cameras) if (thing.group.visible) offer("camera", id, thing.group);
    return nearest;
  }
}
