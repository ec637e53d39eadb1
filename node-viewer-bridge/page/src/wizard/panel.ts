// The calibration wizards: one place for lens, rig and object, from the form to the kept result. The bridge does the
// work; this sends a person's requests and shows how far it is, what to do next, and what came out.

import { fixed, plural } from "../format.ts";
import { element, find, testId, Text } from "../panels/dom.ts";
import type { Preview, Wizard, WizardKind, WizardStage } from "../protocol.ts";
import type { Site } from "../site.ts";
import { type Complaint, send, sentence, Wrong } from "./command.ts";
import { button, Segments } from "./fields.ts";
import { complainAt, createForms, type Form } from "./forms.ts";
import { Introduction } from "./introduction.ts";
import { Judgement } from "./judgement.ts";
import { LearnView } from "./views/learn.ts";
import { LensView } from "./views/lens.ts";
import { PrepareView, type View } from "./views/pictures.ts";
import { RigView } from "./views/rig.ts";

/** There is no wizard at work. */
export const IDLE: Wizard = { wizard: null, stage: "idle" };

const NAMES: Record<WizardKind, string> = { lens: "Lens", rig: "Rig", learn: "Object" };
const STEPS = ["Prepare", "Collect", "Judge", "Keep"];
const STEP_OF: Record<WizardStage, number> = { idle: 0, collecting: 1, solving: 1, solved: 2, keeping: 3, kept: 3 };
const REFRESH_MS = 500;
/** A solve that takes longer is worth a word. */
const LONG_SOLVE_S = 3;

export class WizardPanel {
  private account: Wizard = IDLE;
  private kind: WizardKind = "lens";
  private view: { of: string; view: View };
  private solvingSince = 0;
  private readonly forms: Record<WizardKind, Form>;
  private readonly opener = find<HTMLButtonElement>("[data-testid=wizard-open]");
  private readonly tabs: Segments<WizardKind>;
  private readonly steps = element("ol", "steps", ...STEPS.map((step) => element("li", "", step)));
  private readonly introduction = new Introduction();
  private readonly form = testId(element("form", "form"), "wizard-form");
  private readonly start = button("Start", "wizard-start", "primary");
  private readonly progress = new ProgressLine();
  private readonly hint = new Text(testId(element("p", "hint"), "wizard-hint"));
  private readonly complaint = new Text(testId(element("p", "complaint"), "wizard-cause"));
  private readonly judgement = new Judgement();
  private readonly requests: Record<string, HTMLButtonElement>;
  private readonly stage = element("div", "view-of");

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
  ) {
    this.forms = createForms(site);
    this.view = { of: "", view: new PrepareView(site) };
    this.tabs = new Segments<WizardKind>("What to calibrate", NAMES, this.kind, (kind) => this.choose(kind));
    this.requests = this.createRequests();
    this.start.type = "submit";
    this.form.noValidate = true;
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.begin();
    });
    this.hint.element.setAttribute("role", "status");
    this.complaint.element.setAttribute("role", "alert");
    this.build();
    this.opener.addEventListener("click", () => this.open(root.hidden !== false));
    setInterval(() => this.refresh(), REFRESH_MS);
    this.choose(this.kind);
    this.show();
  }

  take(account: Wizard): void {
    if (account.stage === "solving" && this.account.stage !== "solving") this.solvingSince = performance.now();
    const began = this.account.wizard === null && account.wizard !== null;
    this.account = account;
    if (account.wizard) this.tabs.choose(account.wizard);
    if (began) this.complaint.set("");
    this.show();
  }

  preview(preview: Preview): void {
    if (!this.root.hidden) this.view.view.preview(preview);
  }

  /** Opens with the form of a wizard about a camera or an object, unless one is at work. */
  prepare(kind: WizardKind, subject: string): void {
    if (this.account.wizard === null) {
      this.tabs.choose(kind);
      this.choose(kind);
      this.forms[kind].refresh();
      this.forms[kind].about(subject);
    }
    this.open(true);
  }

  private build(): void {
    const close = button("Close", "wizard-close", "quiet");
    close.addEventListener("click", () => this.open(false));
    const head = element("header", "", element("h2", "", "Calibrate"), this.tabs.root, this.steps, close);
    const actions = element("div", "actions", ...Object.values(this.requests));
    const words = element("div", "words", this.introduction.root, this.form, this.hint.element, this.progress.root);
    words.append(this.complaint.element, this.judgement.verdict, actions, this.judgement.kept);
    this.stage.append(this.view.view.root, this.judgement.figures);
    this.root.append(head, words, this.stage);
    this.root.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.open(false);
    });
  }

  private createRequests(): Record<string, HTMLButtonElement> {
    const request = (name: string, title: string, className = ""): HTMLButtonElement => {
      const made = button(title, `wizard-${name}`, className);
      made.addEventListener("click", () => void this.ask({ do: name }));
      return made;
    };
    const download = button("Download", "wizard-download");
    download.addEventListener("click", () => this.download());
    return {
      solve: request("solve", "Solve"),
      keep: request("keep", "Keep", "primary"),
      resume: request("resume", "Collect more"),
      download,
      discard: request("discard", "Discard", "quiet"),
    };
  }

  private open(wanted: boolean): void {
    this.root.hidden = !wanted;
    this.opener.setAttribute("aria-expanded", String(wanted));
    document.body.classList.toggle("calibrating", wanted);
    this.refresh();
    if (wanted) find<HTMLElement>("button[aria-pressed=true]", this.tabs.root).focus();
    else this.opener.focus();
  }

  private choose(kind: WizardKind): void {
    this.kind = kind;
    this.introduction.show(kind);
    this.form.replaceChildren(this.forms[kind].root, this.start);
    this.complaint.set("");
    this.refresh();
  }

  private refresh(): void {
    if (this.root.hidden) return;
    if (this.account.wizard === null) {
      this.forms[this.kind].refresh();
      this.view.view.update(this.account);
    }
    if (this.account.stage === "solving") this.showHint();
  }

  private async begin(): Promise<void> {
    const form = this.forms[this.kind];
    for (const field of form.fields) field.complain("");
    this.complaint.set("");
    try {
      const complaint = await send("api/wizard", await form.request());
      if (complaint) this.complain(complaint);
    } catch (error) {
      if (!(error instanceof Wrong)) throw error;
      this.complain({ field: error.field, cause: error.message });
    }
  }

  private complain(complaint: Complaint): void {
    if (!complainAt(this.forms[this.kind], complaint)) this.complaint.set(sentence(complaint.cause));
  }

  private async ask(request: object): Promise<void> {
    const complaint = await send("api/wizard", request);
    this.complaint.set(complaint ? sentence(complaint.cause) : "");
  }

  private download(): void {
    const { result } = this.account;
    if (!result) return;
    const link = element("a");
    link.href = `data:application/toml;charset=utf-8,${encodeURIComponent(result.toml)}`;
    link.download = result.file;
    link.click();
  }

  private show(): void {
    const { account } = this;
    const { stage } = account;
    const hadFocus = this.root.contains(document.activeElement);
    this.root.dataset["stage"] = stage;
    this.opener.dataset["stage"] = stage;
    this.opener.textContent = account.wizard ? `Calibrating ${account.subject ?? ""}` : "Calibrate";
    this.form.hidden = this.introduction.root.hidden = account.wizard !== null;
    this.tabs.root.inert = account.wizard !== null;
    [...this.steps.children].forEach((step, at) => {
      step.toggleAttribute("data-done", at < STEP_OF[stage]);
      if (at === STEP_OF[stage]) step.setAttribute("aria-current", "step");
      else step.removeAttribute("aria-current");
    });
    this.showHint();
    this.progress.show(account);
    if (account.cause) this.complaint.set(sentence(account.cause));
    this.judgement.show(account);
    this.showRequests();
    this.showView();
    if (hadFocus) this.keepFocus();
  }

  /** Whoever works with the keyboard goes on where the way goes on. */
  private keepFocus(): void {
    const focused = document.activeElement;
    if (focused instanceof HTMLElement && this.root.contains(focused) && focused.checkVisibility()) return;
    const next = Object.values(this.requests).find((request) => !request.hidden) ?? find<HTMLElement>("button[aria-pressed=true]", this.tabs.root);
    next.focus();
  }

  private showHint(): void {
    const { stage, progress } = this.account;
    const seconds = Math.round((performance.now() - this.solvingSince) / 1000);
    const solving = seconds < LONG_SOLVE_S ? "Solving…" : `Solving… ${seconds} s`;
    const hints: Record<WizardStage, string> = {
      idle: "",
      collecting: progress ? sentence(progress.hint) : "",
      solving,
      solved: "",
      keeping: "Waiting for the site to take it…",
      kept: "Kept.",
    };
    this.hint.element.hidden = hints[stage] === "";
    this.hint.element.classList.toggle("enough", stage === "collecting" && progress?.is_enough === true);
    this.hint.set(hints[stage]);
  }

  private showRequests(): void {
    const { stage, progress } = this.account;
    const useful: Record<string, WizardStage[]> = {
      solve: ["collecting"],
      keep: ["solved"],
      resume: ["solving", "solved"],
      download: ["solved", "kept"],
      discard: ["collecting", "solving", "solved", "kept"],
    };
    for (const [name, request] of Object.entries(this.requests)) request.hidden = !useful[name]?.includes(stage);
    this.requests["solve"]?.classList.toggle("primary", progress?.is_enough === true);
    if (this.requests["resume"]) this.requests["resume"].textContent = stage === "solving" ? "Stop solving" : "Collect more";
    if (this.requests["discard"]) this.requests["discard"].textContent = stage === "kept" ? "Done" : "Discard";
  }

  private showView(): void {
    const { account } = this;
    const wanted = account.wizard ? `${account.wizard} ${account.subject ?? ""}` : "";
    if (this.view.of !== wanted) {
      this.view.view.root.remove();
      this.view = { of: wanted, view: account.wizard ? createView(account.wizard, this.site) : new PrepareView(this.site) };
      this.stage.prepend(this.view.view.root);
    }
    this.view.view.update(account);
  }
}

function createView(kind: WizardKind, site: Site): View {
  switch (kind) {
    case "lens":
      return new LensView(site);
    case "rig":
      return new RigView(site);
    case "learn":
      return new LearnView(site);
  }
}

/** The bar, and the figures beside it. */
class ProgressLine {
  private readonly bar = testId(element("progress"), "wizard-progress");
  private readonly percent = new Text(element("span", "percent"));
  private readonly figures = new Text(testId(element("p", "note"), "wizard-images"));
  readonly root = element("div", "progress", element("div", "", this.bar, this.percent.element), this.figures.element);

  constructor() {
    this.bar.max = 1;
    this.bar.setAttribute("aria-label", "How much is collected");
  }

  show({ stage, progress, missed }: Wizard): void {
    this.root.hidden = !progress || (stage !== "collecting" && stage !== "solving");
    if (!progress) return;
    this.bar.value = progress.fraction;
    this.percent.set(`${fixed(100 * progress.fraction, 0)} %`);
    const lost = missed ? `, ${missed} missed` : "";
    this.figures.set(`${plural(progress.images, "image")} taken in${lost}`);
  }
}
