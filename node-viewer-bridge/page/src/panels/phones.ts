// Links by which phones and laptops become cameras of the site, as QR codes.

import { send } from "../wizard/command.ts";
import { element, find, pressButton, testId } from "./dom.ts";

const PATH = "api/phones";
/** Light modules around a code, which readers need. */
const QUIET = 4;

interface Links {
  links: { camera: string | null; used: boolean; url: string; qr: string[] }[];
  caution: string | null;
}

export class PhonesDialog {
  private readonly dialog = testId(element("dialog", "phones"), "phones");

  constructor() {
    document.body.append(this.dialog);
    this.dialog.addEventListener("click", ({ target }) => target === this.dialog && this.dialog.close());
    find("[data-testid=phones-open]").addEventListener("click", () => void this.open());
  }

  private async open(): Promise<void> {
    const answer = await fetch(PATH, { cache: "no-store" }).catch(() => null);
    const { links, caution }: Links = answer?.ok ? await answer.json() : { links: [], caution: "The bridge does not answer." };
    const close = element("button", "press", "Close");
    close.addEventListener("click", () => this.dialog.close());
    this.dialog.replaceChildren(
      element("h2", "", "Use a phone or laptop as a camera"),
      element("p", "", "Scan the code, or open the link. The device finds tags itself and sends their corners; pictures only if its user switches them on."),
      ...(caution ? [testId(element("p", "caution", caution), "phones-caution")] : []),
      ...links.map(({ camera, used, url, qr }) => {
        const caption = camera ? [element("figcaption", "", camera)] : [];
        if (camera && used) return element("figure", "", ...caption, element("p", "", "A device uses this link; it is for no other one."), this.free(camera));
        const link = element("a", "", url.replace(/#token=.*/, ""));
        link.href = url;
        link.target = "_blank";
        return element("figure", "", ...caption, code(qr), link);
      }),
      close,
    );
    if (!this.dialog.open) this.dialog.showModal();
  }

  /** Lets another device use the link of a camera. */
  private free(camera: string): HTMLButtonElement {
    return pressButton("Let another device use it", `phone-free-${camera}`, () => {
      void send(PATH, { do: "free", camera }).then(() => this.open());
    });
  }
}

/** A QR code, dark on light whatever the page's colours are. */
function code(rows: string[]): SVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const size = rows.length + 2 * QUIET;
  svg.setAttribute("viewBox", `${-QUIET} ${-QUIET} ${size} ${size}`);
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", "QR code of the link");
  const path = document.createElementNS(svg.namespaceURI, "path");
  path.setAttribute("d", rows.flatMap((row, y) => [...row].map((module, x) => (module === "1" ? `M${x} ${y}h1v1h-1z` : ""))).join(""));
  svg.append(path);
  return svg as SVGElement;
}
