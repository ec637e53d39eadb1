// What the forms of the editor have in common: the panel shows them, and sends what they read.

import type { Complaint } from "../wizard/command.ts";
import type { Convention } from "./values.ts";

export interface EditForm {
  readonly root: HTMLElement;
  /** What it is about, such as "camera north". */
  readonly title: string;
  /** What is shown below the title. */
  readonly hint: string;
  /** The axes of what is placed, in words. */
  readonly axes: string;
  /** What can be removed, and how; none of what is being added. */
  readonly removal: object | null;
  /** Whether somebody has written in it. */
  readonly isEdited: boolean;
  /** The version that the form shows; none of what is being added. */
  readonly version: string | null;
  /** The version in force; none where it is gone. */
  inForce(): string | null;
  /** Shows what is in force. */
  load(): void;
  write(convention: Convention): void;
  /** The request. @throws Wrong */
  request(): object;
  /** Shows a complaint at its field; tells whether there is one. */
  complain(complaint: Complaint): boolean;
  /** Under which name to go on after the request was obeyed. */
  renamed(): string;
  /** Whether the last change, which can be taken back, is about this. */
  isRevertible(rig: boolean, objects: string[]): boolean;
}
