// Exposure, gain and rate of a camera under its enlarged picture: what is in force, what is possible, and a form for
// operators.

import type { CameraStatus } from "../protocol.ts";
import { effect, inForce, isAnswered, type Key, KEYS, readSetting, SETTINGS, story, type Wanted, wantedBy, written } from "../settings.ts";
import { type Complaint, send, Wrong } from "../wizard/command.ts";
import { textBox } from "../wizard/fields.ts";
import { element, pressButton, testId, Text } from "./dom.ts";

/** A camera that has not taken its settings after this many seconds is not there. */
const PATIENCE_S = 10;

export class SettingsPanel {
  readonly root: HTMLFormElement;
  private readonly rows: Record<Key, SettingRow>;
  private readonly apply: HTMLButtonElement;
  private readonly outcome: Text;
  private readonly effect: Text;
  private status: CameraStatus | null = null;
  private sent: { wanted: Wanted; at: number } | null = null;
  private complaint = "";

  constructor(private readonly camera: string) {
    const row = (key: Key): SettingRow => new SettingRow(camera, key);
    this.rows = { exposure_us: row("exposure_us"), gain: row("gain"), rate_hz: row("rate_hz") };
    this.apply = pressButton("Apply", `camera-${camera}-apply`, () => {});
    this.apply.type = "submit";
    const outcome = testId(element("p", "outcome"), `camera-${camera}-outcome`);
    outcome.setAttribute("role", "status");
    this.outcome = new Text(outcome);
    this.effect = new Text(testId(element("p", "conditions"), `camera-${camera}-effect`));
    const rows = element("div", "rows", ...KEYS.map((key) => this.rows[key].root));
    this.root = testId(element("form", "settings", rows, this.apply, outcome, this.effect.element), `camera-${camera}-settings`);
    this.root.noValidate = true;
    this.root.hidden = true;
    this.root.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.submit();
    });
  }

  /** Shows a status; none hides the panel. */
  show(status: CameraStatus | null, now: number): void {
    this.root.hidden = status === null;
    if (status === null) return;
    if (this.sent && isAnswered(status.controls, this.sent.wanted)) this.settle();
    if (status !== this.status) {
      this.status = status;
      for (const key of KEYS) this.rows[key].show(status.controls[key], this.sent === null);
      this.effect.set(effect(status));
    }
    this.showOutcome(status, now);
  }

  private settle(): void {
    this.sent = null;
    for (const key of KEYS) this.rows[key].isEdited = false;
  }

  private showOutcome({ controls }: CameraStatus, now: number): void {
    let { text, isComplaint } = this.sent ? story({ ...controls, outcome: "pending" }) : story(controls);
    if (this.sent && now - this.sent.at > PATIENCE_S) {
      [text, isComplaint] = ["The camera has not answered. It takes the settings when it connects and has images.", true];
    }
    if (this.complaint) [text, isComplaint] = [this.complaint, true];
    this.outcome.set(text);
    this.outcome.element.classList.toggle("complaint", isComplaint);
  }

  private async submit(): Promise<void> {
    this.complaint = "";
    for (const key of KEYS) this.rows[key].complain("");
    try {
      const wanted = this.read();
      this.apply.disabled = true;
      const complaint = await send("api/wizard", { do: "set_camera", camera: this.camera, ...wanted });
      if (complaint) this.complain(complaint);
      else this.sent = { wanted, at: performance.now() / 1000 };
    } catch (error) {
      if (!(error instanceof Wrong)) throw error;
      this.complain({ field: error.field, cause: error.message });
    } finally {
      this.apply.disabled = false;
    }
  }

  /** What the rows say; those that nobody has touched stay as the site has them. */
  private read(): Wanted {
    const wanted: Wanted = this.status ? wantedBy(this.status.controls) : { exposure_us: null, gain: null, rate_hz: null };
    for (const key of KEYS) if (this.rows[key].isEdited) wanted[key] = readSetting(key, this.rows[key].text);
    return wanted;
  }

  private complain({ field, cause }: Complaint): void {
    const key = KEYS.find((each) => each === field);
    if (key) this.rows[key].complain(cause);
    else this.complaint = cause;
  }
}

/** One value: its box, its unit, what is in force. */
class SettingRow {
  readonly root: HTMLElement;
  isEdited = false;
  private readonly box = textBox("", "decimal");
  private readonly now: Text;
  private readonly complaint = element("p", "complaint");

  constructor(
    camera: string,
    private readonly key: Key,
  ) {
    const { name, unit } = SETTINGS[key];
    const id = `camera-${camera}-${key}`;
    this.box.id = id;
    this.box.placeholder = "camera's own";
    testId(this.box, id);
    this.box.addEventListener("input", () => {
      this.isEdited = true;
      this.complain("");
    });
    const title = element("label", "", unit ? `${name} (${unit})` : name);
    title.htmlFor = id;
    const now = testId(element("p", "note"), `${id}-now`);
    now.id = `${id}-now`;
    this.complaint.id = `${id}-complaint`;
    this.complaint.hidden = true;
    this.box.setAttribute("aria-describedby", `${this.complaint.id} ${now.id}`);
    this.now = new Text(now);
    this.root = element("div", "field", title, element("div", "control", this.box), now, this.complaint);
  }

  get text(): string {
    return this.box.value;
  }

  /** Shows what is in force; the box follows the site unless somebody writes in it, or waits for an answer. */
  show(control: CameraStatus["controls"][Key], follows: boolean): void {
    this.now.set(inForce(this.key, control));
    const text = written(this.key, control.wanted);
    if (follows && !this.isEdited && this.box.value !== text) this.box.value = text;
  }

  complain(cause: string): void {
    this.complaint.textContent = cause;
    this.complaint.hidden = cause === "";
    this.box.setAttribute("aria-invalid", String(cause !== ""));
  }
}
