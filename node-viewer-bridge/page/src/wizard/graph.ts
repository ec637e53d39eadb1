// The graph of which cameras have seen the object together: a ring of names, lines as thick as they are well joined.

import type { RigDetails } from "../protocol.ts";
import { groupColour } from "./colours.ts";

/** Shared sightings that join two cameras. */
export const JOINED = 15;
const SVG = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT] = [360, 220];

export class CameraGraph {
  readonly root = document.createElementNS(SVG, "svg");

  constructor() {
    this.root.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
    this.root.setAttribute("role", "img");
    this.root.classList.add("graph");
    this.root.dataset["testid"] = "wizard-graph";
  }

  show({ cameras, together }: RigDetails): void {
    const places = new Map(cameras.map(({ camera }, at) => [camera, ring(at, cameras.length)]));
    const lines = together.flatMap(([a, b, count]) => {
      const [from, to] = [places.get(a), places.get(b)];
      return from && to ? [line(from, to, count)] : [];
    });
    const nodes = cameras.map(({ camera, group, seeing }) => node(places.get(camera) ?? [0, 0], camera, group, seeing));
    this.root.replaceChildren(...lines, ...nodes);
    this.root.setAttribute("aria-label", inWords({ cameras, together }));
  }
}

/** The same for those who don't see it. */
export function inWords({ cameras, together }: RigDetails): string {
  const groups = new Map<number, string[]>();
  for (const { camera, group } of cameras) groups.set(group, [...(groups.get(group) ?? []), camera]);
  const parts = [...groups.values()].map((names) => (names.length > 1 ? `${names.join(", ")} are joined` : `${names[0]} stands alone`));
  return `${parts.join("; ")}. ${together.length} pairs have seen the object together.`;
}

function ring(at: number, count: number): [number, number] {
  const angle = (2 * Math.PI * at) / count - Math.PI / 2;
  const sideways = count === 2 ? Math.PI / 2 : 0;
  return [WIDTH / 2 + 120 * Math.cos(angle - sideways), HEIGHT / 2 + 74 * Math.sin(angle - sideways)];
}

function line(from: [number, number], to: [number, number], count: number): SVGElement {
  const joined = count >= JOINED;
  const made = svg("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1] });
  made.setAttribute("class", joined ? "joined" : "begun");
  made.setAttribute("stroke-width", String(joined ? Math.min(6, 1.5 + Math.log10(count)) : 1.5));
  const title = svg("title", {});
  title.textContent = `${count} times together`;
  made.append(title);
  return made;
}

function node([x, y]: [number, number], name: string, group: number, seeing: number): SVGElement {
  const made = svg("g", {});
  const circle = svg("circle", { cx: x, cy: y, r: 9 });
  circle.setAttribute("fill", seeing > 0 ? groupColour(group) : "#2a323d");
  const text = svg("text", { x, y: y + 25 });
  text.textContent = name;
  made.append(circle, text);
  return made;
}

function svg(name: string, attributes: Record<string, number>): SVGElement {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value.toFixed(1));
  return made;
}
