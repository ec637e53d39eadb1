// Zones on the stage: thin edges and a name, brighter while something is inside.

import { BoxGeometry, BufferGeometry, EdgesGeometry, EllipseCurve, Group, LineBasicMaterial, LineLoop, LineSegments } from "three";
import { STAGE } from "../palette.ts";
import type { BoxZone, SphereZone, Zone } from "../protocol.ts";
import { dispose } from "./dispose.ts";
import type { Label, LabelLayer } from "./labels.ts";

const OCCUPIED = 0.95;
const EMPTY = 0.4;

export class ZoneWires {
  readonly group = new Group();
  private readonly labels: Label[] = [];
  private shown = "";

  constructor(private readonly layer: LabelLayer) {}

  /** Tells whether that is news. */
  show(zones: Zone[]): boolean {
    const key = JSON.stringify(zones) + STAGE.zone;
    if (key === this.shown) return false;
    this.shown = key;
    dispose(this.group);
    for (const label of this.labels.splice(0)) this.layer.remove(label);
    for (const zone of zones) this.add(zone);
    return true;
  }

  private add(zone: Zone): void {
    const opacity = zone.inside.length > 0 ? OCCUPIED : EMPTY;
    const material = new LineBasicMaterial({ color: STAGE.zone, transparent: true, opacity });
    const shape = zone.shape === "box" ? boxOf(zone, material) : sphereOf(zone, material);
    shape.position.fromArray(zone.centre);
    this.group.add(shape);
    const label = this.layer.create("zone", zone.name);
    const height = zone.shape === "box" ? (zone.size?.[2] ?? 0) / 2 : (zone.radius ?? 0);
    label.at.fromArray(zone.centre).setZ(zone.centre[2] + height);
    label.element.dataset["occupied"] = String(zone.inside.length > 0);
    this.labels.push(label);
  }
}

function boxOf(zone: BoxZone, material: LineBasicMaterial): Group {
  const box = new BoxGeometry(...zone.size);
  const wires = new LineSegments(new EdgesGeometry(box), material);
  box.dispose();
  wires.rotation.z = (zone.yaw_deg * Math.PI) / 180;
  return new Group().add(wires);
}

/** Three great circles. */
function sphereOf({ radius }: SphereZone, material: LineBasicMaterial): Group {
  const points = new EllipseCurve(0, 0, radius, radius, 0, 2 * Math.PI).getPoints(64).slice(0, -1);
  const circle = (): LineLoop => new LineLoop(new BufferGeometry().setFromPoints(points), material);
  const [flat, side, front] = [circle(), circle(), circle()];
  side.rotation.x = Math.PI / 2;
  front.rotation.y = Math.PI / 2;
  return new Group().add(flat, side, front);
}
