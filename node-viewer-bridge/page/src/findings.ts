// What nodes report, in words: faults of the site, imperfections of its files, notices of the nodes themselves. The
// variants and their fields are those of proto/CONTRACT.md, their severities those of the network
// (proto/golden/severities.json).

import type { CameraNotice, CameraStatus, Fault, FusionStatus, Imperfection, Notice, Refusal, TagId, WizardKind } from "./protocol.ts";
import { story as outcomeOf } from "./settings.ts";
import { isText } from "./shape.ts";

/** A variant's name, or its name with its fields. */
type Finding = string | object;
/** Whether somebody has to act, or may. */
export type Severity = "fault" | "information";

/** What is wrong, and what to do about it. */
interface Story {
  cause: string;
  /** Empty where there is nothing to do. */
  remedy: string;
  severity: Severity;
  /** What the page can do about it: a wizard, or the calibration that the node proposes. */
  action: WizardKind | "apply" | null;
}

/** A finding as people read it. */
export interface Report extends Story {
  /** Stays the same while amounts change. */
  key: string;
  subject: Subject;
}

/** What a report is about: a camera, an object, or the node that reports. */
export interface Subject {
  kind: "camera" | "object" | "node";
  id: string;
}

export type Findings = Pick<FusionStatus, "faults" | "faults_left_out" | "imperfections" | "notices">;
export type CameraFindings = Pick<CameraStatus, "fallbacks" | "notices"> & { controls: Pick<CameraStatus["controls"], "outcome"> };

/** The names of an enum's variants. */
type Name<F> = F extends string ? F : keyof F;
/** What the variant of that name holds. */
type Fields<F, N extends PropertyKey> = Extract<F, Record<N, unknown>> extends Record<N, infer V> ? V : never;
/** A sentence for each variant. */
type Stories<F> = { [N in Name<F>]: (fields: Fields<F, N>) => Story };

const story = (cause: string, remedy = "", action: Story["action"] = null): Story => ({ cause, remedy, severity: "fault", action });
const information = (cause: string, remedy = "", action: Story["action"] = null): Story => ({ ...story(cause, remedy, action), severity: "information" });
const fixed = (value: number, digits: number): string => value.toFixed(digits);
const signed = (value: number, digits: number): string => (value < 0 ? "" : "+") + value.toFixed(digits);
const percent = (ratio: number, digits: number): string => `${signed((ratio - 1) * 100, digits)} %`;

const tag = ({ family, id }: TagId): string => `tag ${family}:${id}`;
const tagOf = (about: { object: string; tag: TagId }): string => `${tag(about.tag)} of object ${about.object}`;

/** A span of time. */
function span(seconds: number): string {
  const day = 86_400;
  if (seconds < 120) return `${seconds.toFixed(2)} s`;
  if (seconds < 2 * day) return `${(seconds / 3600).toFixed(1)} h`;
  if (seconds < 700 * day) return `${(seconds / day).toFixed(0)} days`;
  return `${(seconds / (365.25 * day)).toFixed(1)} years`;
}

/** Which mistake makes a clock differ by so many seconds (positive: ahead), in the words of sextant-site-report. */
function clockCause(offset: number): string {
  const size = Math.abs(offset);
  const is = (seconds: number): boolean => Math.abs(offset - seconds) < 0.2;
  const quarters = size / 900;
  const year = 365.25 * 86_400;
  if (is(37)) return "TAI in place of UTC, PTP without its UTC offset";
  if (is(-37)) return "37 s were taken off twice: UTC in place of TAI";
  if (is(18)) return "GPS time in place of UTC";
  if (is(19) || is(-19)) return "GPS time in place of TAI";
  if (Math.abs(size - 1) < 0.02) return "a leap second, perhaps";
  if (quarters > 1.5 && quarters < 57 && Math.abs(quarters - Math.round(quarters)) * 15 < 1) return "the time of a time zone in place of UTC";
  if (Math.abs(size - 2_208_988_800) < year / 12) return "seconds since 1900 in place of 1970";
  return offset < -40 * year ? "it counts from 1970: no battery, and never set" : "";
}

/** The cause in brackets; nothing where none is known. */
const causeOf = (offset: number): string => {
  const cause = clockCause(offset);
  return cause && ` (${cause})`;
};

function hostClockOff({ offset_s: offset }: Fields<Fault, "host_clock_off">): Story {
  const by = span(Math.abs(offset));
  if (offset >= -40 && offset < -10 && clockCause(-offset))
    return story(
      `the clocks of the cameras are ${by} ahead of that of the fusion host${causeOf(-offset)}`,
      "have them told the offset (ptp4l's utc_offset, phc2sys -O); until then poses have their time",
    );
  const where = offset > 0 ? "ahead of" : "behind";
  return story(`the clock of the fusion host is ${by} ${where} those of the cameras${causeOf(offset)}`, "set it; poses have the cameras' time");
}

function clockOff({ camera, offset_s: offset }: Fields<Fault, "clock_off">): Story {
  const by =
    Math.abs(offset) < 0.1
      ? `off by ${signed(offset * 1e3, 1)} ms`
      : `${span(Math.abs(offset))} ${offset > 0 ? "ahead" : "behind"}${causeOf(offset)}`;
  return story(`the clock of camera ${camera} is ${by}`, "set its clock; poses allow for it");
}

function untimely({ camera, age_s: age }: Fields<Fault, "untimely">): Story {
  return age < 0
    ? story(`images of camera ${camera} are stamped ${span(-age)} ahead of their arrival${causeOf(-age)} and left out`, "set its clock")
    : story(`images of camera ${camera} arrive ${span(age)} after their stamps${causeOf(-age)} and are left out`, "set its clock, or check its network");
}

function tagSize(fields: Fields<Fault, "tag_size">): Story {
  const larger = (fields.ratio - 1) * 100;
  const how = larger > 0 ? "larger" : "smaller";
  return story(`${tagOf(fields)} is ${Math.abs(larger).toFixed(1)} % ${how} than the model says`, "measure it and correct its size", "learn");
}

const FAULTS: Stories<Fault> = {
  camera_moved: ({ camera }) => story(`camera ${camera} is not where the rig says`, "calibrate it again", "rig"),
  cameras_disagree: ({ a, b }) =>
    story(`cameras ${a} and ${b} contradict each other, one is not where the rig says`, "calibrate both again, or let a third see the same", "rig"),
  tag_misplaced: (fields) =>
    story(`${tagOf(fields)} is loose or not where the model says`, "stick it back, or learn the object again", "learn"),
  tag_size: tagSize,
  tag_elsewhere: (fields) => {
    const where = fields.on === null ? "" : `, on object ${fields.on}`;
    return story(`${tagOf(fields)} is seen where it cannot be${where}`, "take it off there, or print another id for one of them");
  },
  clock_off: clockOff,
  untimely,
  duplicate_tag: (fields) =>
    story(`camera ${fields.camera} sees ${tag(fields.tag)} twice`, "print another id for one of them"),
  host_clock_off: hostClockOff,
  camera_frozen: ({ camera, still_s }) =>
    story(`the picture of camera ${camera} has stood still for ${fixed(still_s, 0)} s, corner for corner`, "restart its capture"),
  lens_off: ({ camera }) =>
    story(`camera ${camera} bends what it sees otherwise than its lens in the rig file says`, "run `sextant calibrate lens`", "lens"),
  object_scaled: ({ object, ratio }) =>
    story(`the tags of object ${object} are ${fixed(ratio * 100, 0)} % as large as the model says, all of them`, "measure one and correct the sizes"),
  object_contradicted: ({ object, share }) =>
    story(
      `${fixed(share * 100, 0)} % of the views of object ${object} contradict any pose of it`,
      "check which tags are where, their sizes and the cameras' poses, or learn the object again",
      "learn",
    ),
  object_unplaced: ({ object }) =>
    story(`no tag of object ${object} has a place on it, it cannot be tracked`, "run `sextant learn`, or give object_from_tag in its file", "learn"),
  image_size: ({ camera, size, of_rig }) =>
    story(
      `images of camera ${camera} are ${size.join("x")}, its lens in the rig is of ${of_rig.join("x")}, so that they are left out`,
      "let it take images of that size, or calibrate the lens at the other one",
      "lens",
    ),
  camera_turned: ({ camera, degrees }) =>
    story(
      `camera ${camera} is turned by ${degrees} degrees about its line of sight, poses allow for it`,
      "turn it back, or calibrate it again",
      "rig",
    ),
  cameras_exchanged: ({ a, b }) =>
    story(
      `cameras ${a} and ${b} have exchanged their names, poses allow for it`,
      "exchange the two ids in the rig file, or the two cables",
    ),
  lens_changed: ({ camera, ratio }) =>
    story(
      `the focal length of camera ${camera} is ${fixed(ratio * 100, 0)} % of that in the rig file, another lens or zoom`,
      "set the zoom back, or run `sextant calibrate lens`",
      "lens",
    ),
  tag_turned: (fields) => {
    const by = fields.degrees === 180 ? "upside down" : `turned by ${fields.degrees} degrees`;
    return story(
      `${tagOf(fields)} is stuck on ${by}, poses allow for it`,
      `turn its pose in the object's file by ${fields.degrees} degrees about z`,
    );
  },
  tags_exchanged: ({ object, a, b }) =>
    story(
      `tags ${tag(a)} and ${tag(b)} of object ${object} are exchanged, poses allow for it`,
      "exchange their ids in the object's file",
    ),
  camera_blind: ({ camera, object, blind_s }) =>
    story(
      `camera ${camera} has seen no tag for ${fixed(blind_s, 0)} s, though object ${object} is in its picture by the rig: it is covered or out of focus, was moved, or has another lens`,
      "look at its picture; put it back, or calibrate it again",
      "rig",
    ),
};

const IMPERFECTIONS: Stories<Imperfection> = {
  cameras_disagree: ({ a, b, apart_m }) =>
    information(`cameras ${a} and ${b} disagree by ${fixed(apart_m * 1e3, 1)} mm`, "run `sextant calibrate rig`; poses allow for it", "rig"),
  tag_off: (fields) => {
    const by = `${fixed(fields.position_m * 1e3, 1)} mm and ${fixed((fields.orientation_rad * 180) / Math.PI, 1)} degrees`;
    return information(`${tagOf(fields)} is ${by} off its place in the file`, "run `sextant learn`; poses allow for it", "learn");
  },
  size_off: (fields) =>
    information(`${tagOf(fields)} is ${percent(fields.ratio, 1)} off its size in the file`, "measure it, or run `sextant learn`; poses allow for it", "learn"),
  focal_length_off: ({ camera, ratio }) =>
    information(`the focal length of camera ${camera} is ${percent(ratio, 2)} off that in the rig file`, "run `sextant calibrate lens`; poses allow for it", "lens"),
  scale_off: ({ object, ratio }) =>
    information(`object ${object} is ${fixed(ratio * 100, 1)} % as large as its file says`, "measure a tag and correct the file; poses allow for it"),
};

const detail = (fields: { detail: string }): Story => story(fields.detail);

const REFUSALS: Stories<Refusal> = {
  undecodable: detail,
  wrong_id: ({ described }) => story(`the payload describes object ${described}, not that of its key`),
  no_camera: () => story("the rig has no camera"),
  invalid_camera: detail,
  invalid_object: detail,
  unknown_tag: (fields) => story(`there is no ${tag(fields.tag)}; ids are 0 to ${fields.n_ids - 1}`),
  shared_tag: (fields) =>
    story(`${tag(fields.tag)} is on object ${fields.first} and on object ${fields.second}`, "print another id for one of them"),
  too_many_objects: ({ limit }) => story(`a site has at most ${limit} objects`),
  unpublishable: detail,
  not_stored: (fields) => story(`the change cannot be written to the node's files: ${detail(fields).cause}`),
  other: detail,
};

const NOTICES: Stories<Notice> = {
  camera_silent: ({ camera, silent_s }) =>
    story(`camera ${camera} has sent nothing for ${fixed(silent_s, 0)} s`, "check its power and its network"),
  late_observations: ({ camera, total }) =>
    story(`observations of camera ${camera} arrive too late (${total} dropped since the start)`, "check its network and its clock"),
  overload: ({ dropped, total }) =>
    story(
      `the fusion node's machine is too slow, or stood still: ${dropped} observations dropped (${total} since the start)`,
      "use fewer images a second, fewer cameras or a faster machine",
    ),
  unpublished: (fields) => story(`${fields.total} messages not published since the start; last: ${detail(fields).cause}`),
  clock_stepped: ({ by_s: by }) => {
    const way = by < 0 ? "back" : "forward";
    return information(`the clock of the fusion node's machine was set ${way} by ${fixed(Math.abs(by), 3)} s: tracking begins anew`);
  },
  change_refused: ({ key, sender, refusal }) => {
    const by = sender === null ? "" : ` by ${sender}`;
    const why = storyOf(REFUSALS, refusal);
    return story(`change of ${key}${by} refused: ${why.cause}`, why.remedy);
  },
  name_taken: ({ host }) => story(`another fusion node of this name runs on ${host}`, "stop one of them"),
  refinement_proposed: ({ n_images, before_px, after_px }) =>
    information(`a refined calibration explains the images better (${fixed(before_px, 2)} px to ${fixed(after_px, 2)} px on ${n_images} held-back images)`, "apply it here, or run `sextant config apply-refinement`", "apply"),
  old_models: ({ node, newer }) =>
    story(
      `fusion node ${node} has an older rig or objects than ${newer} and publishes all objects as lost until it has taken these over`,
      `check the network between the two; where ${newer} is gone for good, set the rig again, the present one too (\`sextant config set rig RIG.toml\`)`,
    ),
  not_kept: (fields) => story(`the rig and the objects in force are not in the files that this node would start from: ${detail(fields).cause}`),
  set_aside: ({ node, by, detail: what }) =>
    story(
      `a change that was made at fusion node ${node} while the network was divided is set aside, those of ${by} are in force: ${what}`,
      `bring rig and objects back by \`sextant config revert --to ${node}\``,
    ),
  cameras_slow: ({ cameras, behind_s }) =>
    story(
      `${cameras.length === 1 ? "camera" : "cameras"} ${cameras.join(", ")}: images leave the camera's machine up to ${fixed(behind_s, 1)} s after they were taken, too late`,
      "use fewer images a second, smaller ones or a faster machine",
    ),
};

const CAMERA_NOTICES: Stories<CameraNotice> = {
  no_image: ({ silent_s }) => story(`no image from the capturing part for ${fixed(silent_s, 0)} s`, "see its log"),
  name_taken: ({ host }) => story(`a camera of this name also runs on ${host}`, "stop one of them"),
  image_refused: (fields) => story(`an image was refused: ${detail(fields).cause}`),
  not_in_rig: () => story("the rig has no camera of this name", "add it to the rig"),
  model_refused: (fields) => story(`${fields.key} cannot be used: ${detail(fields).cause}`),
  too_many_tags: ({ key }) =>
    information(`too many objects or tags: the tags of ${key} have no poses in the observations; fusion needs none`),
};

/** Cause and remedy of a finding; an unknown one of a newer node by its name. */
function storyOf<F extends Finding>(stories: Stories<F>, finding: F): Story {
  const [name, fields] = parts(finding);
  const write = (stories as Record<string, (fields: unknown) => Story>)[name];
  return write ? write(fields) : story(name.replaceAll("_", " "));
}

/** What findings are about, in those that have it. */
interface About {
  camera?: string;
  a?: string;
  b?: string;
  object?: string;
  on?: string | null;
  tag?: TagId;
  key?: string;
  refusal?: Refusal;
}

const parts = (finding: Finding): [string, About] => (isText(finding) ? [finding, {}] : (Object.entries(finding)[0] ?? ["", {}]));

/** Notices about the node itself, not about the site. */
const OWN_NOTICES = ["overload", "unpublished", "clock_stepped", "name_taken", "not_kept"];

/**
 * Everything that fusion nodes report. What several report about the site is there once, from the one that published
 * last.
 */
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
  const of = <F extends Finding>(kind: string, stories: Stories<F>, list: F[]): Report[] =>
    list.map((finding) => ({ ...storyOf(stories, finding), key: `${ownerOf(node, finding)}/${kind}/${keyOf(finding)}`, subject: subjectOf(node, finding) }));
  const left: Report = { ...story(`and ${faults_left_out} more faults`), key: "site/left-out", subject: subjectOf(node, "") };
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
  const why = refusal && parts(refusal)[0];
  return [name, camera, a, b, object, on, about && tag(about), key, why].filter((part) => part != null).join(" ");
}

function subjectOf(node: string, finding: Finding): Subject {
  const [, { camera, a, object }] = parts(finding);
  if (camera) return { kind: "camera", id: camera };
  if (object) return { kind: "object", id: object };
  return a ? { kind: "camera", id: a } : { kind: "node", id: node };
}

/** What nobody reports: that the site cannot be heard. */
export function silence(id: string, kind: Subject["kind"], cause: string, remedy: string): Report {
  return { ...story(cause, remedy), key: `silence/${kind}/${id}`, subject: { kind, id } };
}

/** Everything that a camera node reports. */
export function cameraReports(camera: string, { fallbacks, controls, notices }: CameraFindings): Report[] {
  const subject: Subject = { kind: "camera", id: camera };
  const images = fallbacks === 1 ? "1 image" : `${fallbacks} images`;
  const fallback: Report = {
    ...story(`the CPU made ${images} in place of the accelerator`, "see the log of the capturing part"),
    key: `${camera}/status/fallbacks`,
    subject,
  };
  const settings = outcomeOf(controls);
  const refusal: Report = { ...story(settings.text.replace(/\.$/, "")), key: `${camera}/status/settings`, subject };
  const told = notices.map(
    (notice): Report => ({ ...storyOf(CAMERA_NOTICES, notice), key: `${camera}/status/${keyOf(notice)}`, subject }),
  );
  return [...(fallbacks > 0 ? [fallback] : []), ...(settings.isComplaint ? [refusal] : []), ...told];
}
