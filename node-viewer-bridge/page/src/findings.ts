// What nodes report, in words: faults of the site, imperfections of its files, notices of the nodes themselves. The variants and their fields are
// those of proto/CONTRACT.md.

import type { CameraControls, FusionStatus } from "./protocol.ts";
import { story as outcomeOf } from "./settings.ts";
import { isText, type Test } from "./shape.ts";

type Fields = Record<string, unknown>;
/** A variant's name, or its name with its fields. */
export type Finding = string | Record<string, Fields>;
export type Level = "fault" | "imperfection" | "notice";

/** What is wrong, and what to do about it. */
interface Story {
  cause: string;
  /** Empty where there is nothing to do. */
  remedy: string;
}

/** A finding as people read it. */
export interface Report extends Story {
  /** Stays the same while amounts change. */
  key: string;
  level: Level;
  subject: Subject;
}

/** What a report is about: a camera, an object, or the node that reports. */
export interface Subject {
  kind: "camera" | "object" | "node";
  id: string;
}

type Stories = Record<string, (fields: Fields) => Story>;

export interface Findings {
  faults: Finding[];
  faults_left_out: number;
  imperfections: Finding[];
  notices: Finding[];
}

const isFields = (value: unknown): boolean => typeof value === "object" && value !== null;

export const isFinding: Test = (value) =>
  isText(value) || (isFields(value) && Object.keys(value as Fields).length === 1 && Object.values(value as Fields).every(isFields));

const story = (cause: string, remedy = ""): Story => ({ cause, remedy });
const number = (value: unknown): number => (typeof value === "number" ? value : 0);
const fixed = (value: unknown, digits: number): string => number(value).toFixed(digits);
const signed = (value: number, digits: number): string => (value < 0 ? "" : "+") + value.toFixed(digits);
const percent = (ratio: unknown, digits: number): string => `${signed((number(ratio) - 1) * 100, digits)} %`;

function tag(value: unknown): string {
  const { family, id } = (isFields(value) ? value : {}) as Fields;
  return `tag ${String(family)}:${String(id)}`;
}

const sides = (size: unknown): string => (Array.isArray(size) ? size.map(String).join("x") : "");
const tagOf = (fields: Fields): string => `${tag(fields.tag)} of object ${String(fields.object)}`;

/** A span of time. */
function span(seconds: number): string {
  const day = 86_400;
  if (seconds < 120) return `${seconds.toFixed(2)} s`;
  if (seconds < 2 * day) return `${(seconds / 3600).toFixed(1)} h`;
  if (seconds < 700 * day) return `${(seconds / day).toFixed(0)} days`;
  return `${(seconds / (365.25 * day)).toFixed(1)} years`;
}

function clockOff({ camera, offset_s }: Fields): Story {
  const offset = number(offset_s);
  const by =
    Math.abs(offset) < 0.1
      ? `off by ${signed(offset * 1e3, 1)} ms`
      : `${span(Math.abs(offset))} ${offset > 0 ? "ahead" : "behind"}`;
  return story(`the clock of camera ${String(camera)} is ${by}`, "set its clock; poses allow for it");
}

function untimely({ camera, age_s }: Fields): Story {
  const age = number(age_s);
  return age < 0
    ? story(`images of camera ${String(camera)} are stamped ${span(-age)} ahead of their arrival and left out`, "set its clock")
    : story(`images of camera ${String(camera)} arrive ${span(age)} after their stamps and are left out`, "set its clock, or check its network");
}

function tagSize(fields: Fields): Story {
  const larger = (number(fields.ratio) - 1) * 100;
  const how = larger > 0 ? "larger" : "smaller";
  return story(`${tagOf(fields)} is ${Math.abs(larger).toFixed(1)} % ${how} than the model says`, "measure it and correct its size");
}

const FAULTS: Stories = {
  camera_moved: ({ camera }) => story(`camera ${String(camera)} is not where the rig says`, "calibrate it again"),
  cameras_disagree: ({ a, b }) =>
    story(`cameras ${String(a)} and ${String(b)} contradict each other, one is not where the rig says`, "calibrate both again, or let a third see the same"),
  tag_misplaced: (fields) =>
    story(`${tagOf(fields)} is loose or not where the model says`, "stick it back, or learn the object again"),
  tag_size: tagSize,
  tag_elsewhere: (fields) => {
    const where = fields.on === null ? "" : `, on object ${String(fields.on)}`;
    return story(`${tagOf(fields)} is seen where it cannot be${where}`, "take it off there, or print another id for one of them");
  },
  clock_off: clockOff,
  untimely,
  duplicate_tag: (fields) =>
    story(`camera ${String(fields.camera)} sees ${tag(fields.tag)} twice`, "print another id for one of them"),
  host_clock_off: ({ offset_s }) => {
    const where = number(offset_s) > 0 ? "ahead of" : "behind";
    return story(`the clock of the fusion host is ${span(Math.abs(number(offset_s)))} ${where} those of the cameras`, "set it; poses have the cameras' time");
  },
  camera_frozen: ({ camera, still_s }) =>
    story(`the picture of camera ${String(camera)} has stood still for ${fixed(still_s, 0)} s, corner for corner`, "restart its capture"),
  lens_off: ({ camera }) =>
    story(`camera ${String(camera)} bends what it sees otherwise than its lens in the rig file says`, "run `sextant calibrate lens`"),
  object_scaled: ({ object, ratio }) =>
    story(`the tags of object ${String(object)} are ${fixed(number(ratio) * 100, 0)} % as large as the model says, all of them`, "measure one and correct the sizes"),
  object_contradicted: ({ object, share }) =>
    story(
      `${fixed(number(share) * 100, 0)} % of the views of object ${String(object)} contradict any pose of it`,
      "check which tags are where, their sizes and the cameras' poses, or learn the object again",
    ),
  object_unplaced: ({ object }) =>
    story(`no tag of object ${String(object)} has a place on it, it cannot be tracked`, "run `sextant learn`, or give object_from_tag in its file"),
  image_size: ({ camera, size, of_rig }) =>
    story(
      `images of camera ${String(camera)} are ${sides(size)}, its lens in the rig is of ${sides(of_rig)}, so that they are left out`,
      "let it take images of that size, or calibrate the lens at the other one",
    ),
};

const IMPERFECTIONS: Stories = {
  cameras_disagree: ({ a, b, apart_m }) =>
    story(`cameras ${String(a)} and ${String(b)} disagree by ${fixed(number(apart_m) * 1e3, 1)} mm`, "run `sextant calibrate rig`; poses allow for it"),
  tag_off: (fields) => {
    const by = `${fixed(number(fields.position_m) * 1e3, 1)} mm and ${fixed((number(fields.orientation_rad) * 180) / Math.PI, 1)} degrees`;
    return story(`${tagOf(fields)} is ${by} off its place in the file`, "run `sextant learn`; poses allow for it");
  },
  size_off: (fields) =>
    story(`${tagOf(fields)} is ${percent(fields.ratio, 1)} off its size in the file`, "measure it, or run `sextant learn`; poses allow for it"),
  focal_length_off: ({ camera, ratio }) =>
    story(`the focal length of camera ${String(camera)} is ${percent(ratio, 2)} off that in the rig file`, "run `sextant calibrate lens`; poses allow for it"),
};

const detail = (fields: Fields): Story => story(String(fields.detail));

const REFUSALS: Stories = {
  undecodable: detail,
  wrong_id: ({ described }) => story(`the payload describes object ${String(described)}, not that of its key`),
  no_camera: () => story("the rig has no camera"),
  invalid_camera: detail,
  invalid_object: detail,
  unknown_tag: (fields) => story(`there is no ${tag(fields.tag)}; ids are 0 to ${number(fields.n_ids) - 1}`),
  shared_tag: (fields) =>
    story(`${tag(fields.tag)} is on object ${String(fields.first)} and on object ${String(fields.second)}`, "print another id for one of them"),
  too_many_objects: ({ limit }) => story(`a site has at most ${number(limit)} objects`),
  unpublishable: detail,
  not_stored: (fields) => story(`the change cannot be written to the node's files: ${detail(fields).cause}`),
  other: detail,
};

const NOTICES: Stories = {
  camera_silent: ({ camera, silent_s }) =>
    story(`camera ${String(camera)} has sent nothing for ${fixed(silent_s, 0)} s`, "check its power and its network"),
  late_observations: ({ camera, total }) =>
    story(`observations of camera ${String(camera)} arrive too late (${number(total)} dropped since the start)`, "check its network and its clock"),
  overload: ({ dropped, total }) =>
    story(`overload: ${number(dropped)} observations dropped unread (${number(total)} since the start)`, "use fewer images a second, fewer cameras or a faster machine"),
  unpublished: (fields) => story(`${number(fields.total)} messages not published since the start; last: ${detail(fields).cause}`),
  clock_stepped: ({ by_s }) => {
    const by = number(by_s);
    const way = by < 0 ? "back" : "forward";
    return story(`the clock of the fusion node's machine was set ${way} by ${fixed(Math.abs(by), 3)} s: tracking begins anew`);
  },
  change_refused: ({ key, sender, refusal }) => {
    const by = isText(sender) ? ` by ${String(sender)}` : "";
    const why = isFinding(refusal) ? storyOf(REFUSALS, refusal as Finding) : story("");
    return story(`change of ${String(key)}${by} refused: ${why.cause}`, why.remedy);
  },
  name_taken: ({ host }) => story(`another fusion node of this name runs on ${String(host)}`, "stop one of them"),
  refinement_proposed: ({ n_images, before_px, after_px }) =>
    story(`a refined calibration explains the images better (${fixed(before_px, 2)} px to ${fixed(after_px, 2)} px on ${number(n_images)} held-back images)`, "apply it here, or run `sextant config apply-refinement`"),
};

const CAMERA_NOTICES: Stories = {
  no_image: ({ silent_s }) => story(`no image from the capturing part for ${fixed(silent_s, 0)} s`, "see its log"),
  name_taken: ({ host }) => story(`a camera of this name also runs on ${String(host)}`, "stop one of them"),
  image_refused: (fields) => story(`an image was refused: ${detail(fields).cause}`),
  not_in_rig: () => story("the rig has no camera of this name", "add it to the rig"),
  model_refused: (fields) => story(`${String(fields.key)} cannot be used: ${detail(fields).cause}`),
  too_many_tags: ({ key }) =>
    story(`too many objects or tags: the tags of ${String(key)} have no poses in the observations; fusion needs none`),
};

/** Cause and remedy of a finding; an unknown one of a newer node by its name. */
function storyOf(stories: Stories, finding: Finding): Story {
  const [name, fields] = parts(finding);
  const write = Object.hasOwn(stories, name) ? stories[name] : undefined;
  return write ? write(fields) : story(name.replaceAll("_", " "));
}

function parts(finding: Finding): [string, Fields] {
  return typeof finding === "string" ? [finding, {}] : (Object.entries(finding)[0] ?? ["", {}]);
}

/** Notices about the node itself, not about the site. */
const OWN_NOTICES = ["overload", "unpublished", "clock_stepped", "name_taken"];

/** Everything that fusion nodes report. What several report about the site is there once, from the one that published last. */
export function siteReports(statuses: readonly FusionStatus[]): Report[] {
  const newestFirst = [...statuses].sort((a, b) => (b.epoch ?? 0) - (a.epoch ?? 0));
  const byKey = new Map<string, Report>();
  for (const status of newestFirst)
    for (const report of reports(status.node, status)) if (!byKey.has(report.key)) byKey.set(report.key, report);
  return [...byKey.values()];
}

/** Everything that a fusion node reports. Keys of what it reports about the site are those of other nodes, too. */
export function reports(node: string, findings: Findings): Report[] {
  const { faults, faults_left_out, imperfections, notices } = findings;
  const of = (level: Level, stories: Stories, list: Finding[]): Report[] =>
    list.map((finding) => ({ ...storyOf(stories, finding), key: `${ownerOf(node, finding)}/${level}/${keyOf(finding)}`, level, subject: subjectOf(node, finding) }));
  const left: Report = { ...story(`and ${faults_left_out} more faults`), key: "site/left-out", level: "fault", subject: subjectOf(node, "") };
  return [
    ...of("fault", FAULTS, faults),
    ...(faults_left_out > 0 ? [left] : []),
    ...of("imperfection", IMPERFECTIONS, imperfections),
    ...of("notice", NOTICES, notices),
  ];
}

const ownerOf = (node: string, finding: Finding): string => (OWN_NOTICES.includes(parts(finding)[0]) ? node : "site");

/** The variant and who it is about, without amounts. */
function keyOf(finding: Finding): string {
  const [name, { camera, a, b, object, on, tag: about, key, refusal }] = parts(finding);
  const why = isFinding(refusal) ? parts(refusal as Finding)[0] : undefined;
  return [name, camera, a, b, object, on, isFields(about) ? tag(about) : undefined, key, why].filter((part) => part != null).join(" ");
}

function subjectOf(node: string, finding: Finding): Subject {
  const [, { camera, a, object }] = parts(finding);
  if (isText(camera)) return { kind: "camera", id: String(camera) };
  if (isText(object)) return { kind: "object", id: String(object) };
  return isText(a) ? { kind: "camera", id: String(a) } : { kind: "node", id: node };
}

export interface CameraFindings {
  fallbacks: number;
  controls: Pick<CameraControls, "outcome">;
  notices: Finding[];
}

/** Everything that a camera node reports. */
export function cameraReports(camera: string, { fallbacks, controls, notices }: CameraFindings): Report[] {
  const subject: Subject = { kind: "camera", id: camera };
  const images = fallbacks === 1 ? "1 image" : `${fallbacks} images`;
  const fallback: Report = {
    ...story(`the CPU made ${images} in place of the accelerator`, "see the log of the capturing part"),
    key: `${camera}/status/fallbacks`,
    level: "notice",
    subject,
  };
  const settings = outcomeOf(controls);
  const refusal: Report = { ...story(settings.text.replace(/\.$/, "")), key: `${camera}/status/settings`, level: "notice", subject };
  const told = notices.map(
    (notice): Report => ({ ...storyOf(CAMERA_NOTICES, notice), key: `${camera}/status/${keyOf(notice)}`, level: "notice", subject }),
  );
  return [...(fallbacks > 0 ? [fallback] : []), ...(settings.isComplaint ? [refusal] : []), ...told];
}
