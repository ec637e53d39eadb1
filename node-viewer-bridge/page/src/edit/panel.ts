// The editor: a camera or an object as it is in force, to be changed by whoever may change the site. The bridge makes
// the change and says what became of it.

import { element, find, pressButton, testId, Text } from "../panels/dom.ts";
import type { RigCamera } from "../protocol.ts";
import type { Site } from "../site.ts";
import { post, send, sentence, Wrong } from "../wizard/command.ts";
import { button, Segments } from "../wizard/fields.ts";
import { CameraForm } from "./camera.ts";
import type { EditForm } from "./form.ts";
import { ObjectForm } from "./object.ts";
import type { Convention } from "./values.ts";

const PATH = "api/models";
const REFRESH_MS = 300;
const CONVENTIONS: Record<Convention, string> = { angles: "Roll, pitch, yaw", quaternion: "Quaternion" };
const ABOUT: Record<Convention, string> = {
  angles: "In degrees: turned by roll about the outer frame's x, then by pitch about its y, then by yaw about its z.",
  quaternion: "x, y, z, w, of length 1, as in the files.",
};

export class EditorPanel {
  private form: EditForm | null = null;
  private convention: Convention = "angles";
  private isSending = false;
  private opener: HTMLElement | null = null;
  private readonly title = new Text(testId(element("h2"), "edit-title"));
  private readonly hint = new Text(element("p", "note"));
  private readonly about = new Text(element("p", "note"));
  private readonly conventions: Segments<Convention>;
  private readonly newer: HTMLElement;
  private readonly why = new Text(element("span"));
  private readonly said = element("ul", "kept");
  private readonly outcome = testId(element("div", "", this.said), "edit-outcome");
  private readonly complaint = testId(element("p", "complaint"), "edit-cause");
  private readonly apply = button("Apply", "edit-apply", "primary");
  private readonly revert: HTMLButtonElement;
  private readonly remove: HTMLButtonElement;
  private readonly body = element("form", "edit-body");

  constructor(
    private readonly root: HTMLElement,
    private readonly site: Site,
    private readonly preview: (camera: RigCamera | null) => void,
  ) {
    const write = (convention: Convention): void => this.write(convention);
    this.conventions = new Segments<Convention>("Orientations as", CONVENTIONS, this.convention, write);
    const load = pressButton("Load it", "edit-load", () => this.load());
    this.newer = testId(element("p", "caution", this.why.element, " ", load), "edit-newer");
    this.newer.setAttribute("role", "status");
    this.outcome.setAttribute("role", "status");
    this.complaint.setAttribute("role", "alert");
    this.revert = button("Revert", "edit-revert", "quiet");
    this.revert.title = "Takes the last change back";
    this.revert.addEventListener("click", () => void this.takeBack());
    this.remove = button("Remove", "edit-remove", "quiet");
    this.remove.addEventListener("click", () => void this.removeIt());
    this.remove.addEventListener("blur", () => this.disarm());
    this.build();
    setInterval(() => this.refresh(), REFRESH_MS);
  }

  camera(id: string): void {
    this.open(new CameraForm(id, this.site, this.preview));
  }

  /** An object, `<object>.<link>`, or null for a new one. */
  object(id: string | null): void {
    this.open(new ObjectForm(id, this.site));
  }

  private build(): void {
    const close = button("Close", "edit-close", "quiet");
    close.addEventListener("click", () => this.close());
    const head = element("header", "", this.title.element, close);
    this.apply.type = "submit";
    this.body.noValidate = true;
    this.body.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.submit();
    });
    const actions = element("div", "actions", this.apply, this.revert, this.remove);
    const foot = element("footer", "", this.newer, this.outcome, this.complaint, actions);
    this.root.append(head, this.body, foot);
    this.body.id = "edit-form";
    this.apply.setAttribute("form", this.body.id);
    this.root.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.close();
    });
  }

  private open(form: EditForm): void {
    if (this.root.hidden) this.opener = document.activeElement instanceof HTMLElement ? document.activeElement : null;
    this.preview(null);
    this.form = form;
    form.write(this.convention);
    this.body.replaceChildren(this.hint.element, this.conventions.root, this.about.element, form.root);
    this.root.hidden = false;
    document.body.classList.add("editing");
    this.say([]);
    this.complain("");
    this.show();
    this.body.scrollTop = 0;
    find<HTMLElement>("input", form.root).focus();
  }

  private close(): void {
    this.root.hidden = true;
    this.form = null;
    document.body.classList.remove("editing");
    this.preview(null);
    this.opener?.focus();
  }

  private write(convention: Convention): void {
    this.convention = convention;
    this.form?.write(convention);
    this.show();
  }

  private load(): void {
    this.form?.load();
    this.complain("");
    this.show();
  }

  private show(): void {
    const { form } = this;
    if (!form) return;
    this.title.set(form.title);
    this.hint.set(form.hint);
    this.about.set(`${ABOUT[this.convention]} ${form.axes}`);
    this.remove.hidden = form.removal === null;
    const formers = [...this.site.formers.values()];
    this.revert.hidden = !formers.some(({ rig, objects }) => form.isRevertible(rig, objects));
    const inForce = form.inForce();
    const isNewer = form.version !== inForce;
    if (isNewer && !form.isEdited && inForce !== null) return this.load();
    const changed = "It has been changed meanwhile: a newer version is in force.";
    this.why.set(inForce === null ? "It is not there any more." : changed);
    find<HTMLElement>("button", this.newer).hidden = inForce === null;
    this.newer.hidden = !isNewer || this.isSending;
  }

  private refresh(): void {
    if (!this.root.hidden && !this.isSending) this.show();
  }

  private async submit(): Promise<void> {
    const { form } = this;
    if (!form || this.isSending) return;
    this.complain("");
    this.say([]);
    try {
      const before = form.inForce();
      if (await this.send(form.request(), form)) {
        form.renamed();
        await this.heard(() => ![before, null].includes(form.inForce()));
        form.load();
      }
    } catch (error) {
      if (!(error instanceof Wrong)) throw error;
      if (!form.complain({ field: error.field, cause: error.message })) this.complain(error.message);
    }
    this.show();
  }

  /** Sends a request; tells whether the site has taken it. */
  private async send(request: object, form: EditForm): Promise<boolean> {
    this.busy(true);
    try {
      const answer = await post(PATH, request);
      if ("said" in answer) {
        this.say(answer.said);
        return true;
      }
      const complaint = { field: answer.field, cause: sentence(answer.cause) };
      if (!form.complain(complaint)) this.complain(complaint.cause);
      return false;
    } finally {
      this.busy(false);
    }
  }

  /** The change reaches the page by the site's own messages, a moment before or after the answer. */
  private async heard(condition: () => boolean): Promise<void> {
    for (let waited = 0; waited < 10 && !condition(); waited++) await new Promise((done) => setTimeout(done, 100));
  }

  private busy(isSending: boolean): void {
    this.isSending = isSending;
    for (const each of [this.apply, this.revert, this.remove]) each.disabled = isSending;
    this.apply.textContent = isSending ? "Applying…" : "Apply";
  }

  private async takeBack(): Promise<void> {
    const { form } = this;
    const former = [...this.site.formers.values()].find(({ rig, objects }) => form?.isRevertible(rig, objects));
    if (!form || !former) return;
    this.complain("");
    this.say([]);
    const before = form.inForce();
    const complaint = await send("api/wizard", { do: "revert", node: former.node });
    if (complaint) return this.complain(sentence(complaint.cause));
    await this.heard(() => form.inForce() !== before);
    this.load();
    this.say(["the last change is taken back"]);
  }

  /** Asks once more by its own text. */
  private async removeIt(): Promise<void> {
    const { form } = this;
    if (!form?.removal) return;
    if (this.remove.dataset["armed"] === undefined) {
      this.remove.dataset["armed"] = "";
      this.remove.textContent = `Really remove ${form.title.toLowerCase()}?`;
      return;
    }
    this.disarm();
    this.complain("");
    const { removal } = form;
    if (await this.send(removal, form)) this.close();
  }

  private disarm(): void {
    delete this.remove.dataset["armed"];
    this.remove.textContent = "Remove";
  }

  private say(said: string[]): void {
    this.said.replaceChildren(...said.map((each) => element("li", "", sentence(each))));
  }

  private complain(cause: string): void {
    this.complaint.textContent = cause;
  }
}
