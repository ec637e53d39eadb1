// How the stage is rendered: smooth edges where there is a graphics card; plain and cheap where the processor draws, as
// in virtual machines and on small boards.

import { WebGLRenderer } from "three";

const MAX_PIXEL_RATIO = 2;
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** Throws where the browser has no WebGL 2. */
export function createRenderer(canvas: HTMLCanvasElement): WebGLRenderer {
  const software = drawnBySoftware();
  const renderer = new WebGLRenderer({ canvas, antialias: !software, powerPreference: "low-power" });
  renderer.setPixelRatio(software ? 1 : Math.min(window.devicePixelRatio, MAX_PIXEL_RATIO));
  return renderer;
}

/** Smoothing is chosen before the renderer exists, so another context is asked what draws here. */
function drawnBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe) return false;
  const info = probe.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = info ? probe.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return typeof name === "string" && SOFTWARE.test(name);
}
