// The bridge's messages: what each looks like. Written by `cargo xtask page-types` from proto/CONTRACT.md and PROTOCOL.md: do not edit.

import { anyOf, arrayOf, isFlag, isNumber, isText, listOf, oneOf, orNull, record, tuple, variants, type Checked } from "./shape.ts";

export const isHello = record({
  site: isText,
  version: isText,
  protocol: isNumber,
  now_ns: isNumber,
  /** what was not heard of for longer is silent; of slower messages as many are missed first */
  silence: record({
    seconds: isNumber,
    messages: isNumber,
  }),
  /** what this client may do */
  role: oneOf("viewer", "operator"),
});
export type Hello = Checked<typeof isHello>;

export const isLensModel = oneOf("pinhole", "brown-conrady", "kannala-brandt");
export type LensModel = Checked<typeof isLensModel>;

/** As in `rig.toml`. */
export const isRigLens = record({
  model: isLensModel,
  fx: isNumber,
  fy: isNumber,
  cx: isNumber,
  cy: isNumber,
}, {
  /** of the model's polynomial; missing of a pinhole */
  distortion: listOf(isNumber),
});
export type RigLens = Checked<typeof isRigLens>;

export const isTransform = record({
  position: arrayOf(isNumber, 3),
  orientation: arrayOf(isNumber, 4),
});
export type Transform = Checked<typeof isTransform>;

export const isMount = record({
  /** the object */
  carrier: isText,
  carrier_from_camera: isTransform,
});
export type Mount = Checked<typeof isMount>;

export const isPoseSigma = record({
  /** the same along each axis */
  position_m: isNumber,
  /** the same along each axis */
  orientation_rad: isNumber,
});
export type PoseSigma = Checked<typeof isPoseSigma>;

export const isRigCamera = record({
  id: isText,
  resolution: arrayOf(isNumber, 2),
  lens: isRigLens,
  /** none until calibrated */
  world_from_camera: orNull(isTransform),
  /** differs whenever this camera's part of the rig does */
  version: isText,
}, {
  /** only of a camera that an object carries; it has no world_from_camera */
  mount: isMount,
  /** of the pose, where the rig gives one */
  sigma: isPoseSigma,
});
export type RigCamera = Checked<typeof isRigCamera>;

export const isRig = record({
  cameras: listOf(isRigCamera),
});
export type Rig = Checked<typeof isRig>;

/** The corners of a charuco tag are those of the white square of the chessboard around the marker. A chessboard tag is a square of a plain chessboard between inner corners; its id is 64 times the row plus the column of its upper left corner. */
export const isFamily = oneOf("tag36h11", "tag25h9", "tag16h5", "tagStandard41h12", "aruco4x4-50", "aruco4x4-100", "aruco4x4-250", "aruco4x4-1000", "aruco5x5-50", "aruco5x5-100", "aruco5x5-250", "aruco5x5-1000", "aruco6x6-50", "aruco6x6-100", "aruco6x6-250", "aruco6x6-1000", "tag36h11b2", "aruco7x7-50", "aruco7x7-100", "aruco7x7-250", "aruco7x7-1000", "charuco4x4-50", "charuco4x4-100", "charuco4x4-250", "charuco4x4-1000", "charuco5x5-50", "charuco5x5-100", "charuco5x5-250", "charuco5x5-1000", "charuco6x6-50", "charuco6x6-100", "charuco6x6-250", "charuco6x6-1000", "charuco7x7-50", "charuco7x7-100", "charuco7x7-250", "charuco7x7-1000", "aruco-original", "aruco-mip-36h12", "tag36h10", "tagCustom48h12", "tagStandard52h13", "chessboard", "tagCircle21h7", "tagCircle49h12", "aruco-mip-16h3", "aruco-mip-25h7");
export type Family = Checked<typeof isFamily>;

export const isPrintedTag = record({
  family: isFamily,
  id: isNumber,
  /** edge of the black square */
  size_m: isNumber,
  /** edge of the whole print, white ring included */
  printed_size_m: isNumber,
  /** none until learned */
  object_from_tag: orNull(isTransform),
  /** rows of the printed tag, top first, white outer ring included; 1 is white, 0 black */
  modules: listOf(isText),
}, {
  size_sigma_m: isNumber,
  /** of size and pose, where the file gives them */
  sigma: isPoseSigma,
});
export type PrintedTag = Checked<typeof isPrintedTag>;

export const isObject = record({
  id: isText,
  tags: listOf(isPrintedTag),
  /** differs whenever the object does; the links of an object have the same */
  version: isText,
}, {
  /** only of a landmark, which stands there by its file */
  world_from_object: isTransform,
});
export type Object = Checked<typeof isObject>;

export const isObjectGone = record({
  id: isText,
});
export type ObjectGone = Checked<typeof isObjectGone>;

export const isState = oneOf("initialising", "tracking", "coasting", "lost");
export type State = Checked<typeof isState>;

export const isPose = record({
  object: isText,
  /** of the published poses of the object, so that skipped ones show */
  sequence: isNumber,
  t_ns: isNumber,
  position: arrayOf(isNumber, 3),
  orientation: arrayOf(isNumber, 4),
  /** 6x6 row-major over (x, y, z, rx, ry, rz) in world axes, rotation as left perturbation about the object's origin */
  covariance: arrayOf(isNumber, 36),
  /** linear then angular velocity in world axes, m/s and rad/s */
  twist: arrayOf(isNumber, 6),
  state: isState,
  /** how many took part */
  cameras: isNumber,
  /** how many took part */
  tags: isNumber,
  /** reprojection error */
  rms_px: isNumber,
  /** from capture to publication */
  latency_ms: isNumber,
});
export type Pose = Checked<typeof isPose>;

export const isJointValue = record({
  joint: isText,
  value: isNumber,
  sigma: isNumber,
  velocity: isNumber,
});
export type JointValue = Checked<typeof isJointValue>;

export const isJoints = record({
  object: isText,
  t_ns: isNumber,
  joints: listOf(isJointValue),
});
export type Joints = Checked<typeof isJoints>;

export const isTruth = record({
  object: isText,
  t_ns: isNumber,
  position: arrayOf(isNumber, 3),
  orientation: arrayOf(isNumber, 4),
  error_mm: isNumber,
  error_deg: isNumber,
});
export type Truth = Checked<typeof isTruth>;

export const isTagOutline = record({
  family: isFamily,
  id: isNumber,
  hamming: isNumber,
  margin: isNumber,
  /** top left, top right, bottom right, bottom left of the upright tag, in pixels of the resolution */
  corners: arrayOf(arrayOf(isNumber, 2), 4),
});
export type TagOutline = Checked<typeof isTagOutline>;

export const isObservations = record({
  camera: isText,
  sequence: isNumber,
  t_ns: isNumber,
  /** from capture until the detector had the image */
  received_ms: orNull(isNumber),
  /** until its tags were found */
  detected_ms: orNull(isNumber),
  /** until they were published */
  latency_ms: isNumber,
  resolution: arrayOf(isNumber, 2),
  tags: listOf(isTagOutline),
});
export type Observations = Checked<typeof isObservations>;

export const isRejectionCause = oneOf("not_a_quad", "shape", "faint_border", "no_code", "small_margin");
export type RejectionCause = Checked<typeof isRejectionCause>;

export const isDetectionReport = record({
  camera: isText,
  sequence: isNumber,
  capture_ns: isNumber,
  resolution: arrayOf(isNumber, 2),
  /** share of the image, 0 to 1 */
  searched: isNumber,
  stage_ms: record({
    tiles: isNumber,
    threshold: isNumber,
    components: isNumber,
    quads: isNumber,
    decode: isNumber,
    refine: isNumber,
  }),
  /** grey levels */
  noise_sigma: isNumber,
  /** grey levels */
  contrast_gate: isNumber,
  components: isNumber,
  candidates: isNumber,
  /** candidates beyond the detector's memory */
  dropped: isNumber,
  tags: isNumber,
  rejected: record({
    not_a_quad: isNumber,
    shape: isNumber,
    faint_border: isNumber,
    no_code: isNumber,
    small_margin: isNumber,
  }),
  /** at most 64 */
  examples: listOf(record({
    cause: isRejectionCause,
    corners: arrayOf(arrayOf(isNumber, 2), 4),
  })),
});
export type DetectionReport = Checked<typeof isDetectionReport>;

export const isClock = record({
  source: oneOf("unknown", "free-running", "ntp", "ptp", "recorded", "simulated", "arrival"),
  /** one sigma; 0 where recorded or simulated */
  error_ns: isNumber,
});
export type Clock = Checked<typeof isClock>;

export const isControl = record({
  /** by the site; none: up to the camera's own file */
  wanted: orNull(isNumber),
  /** in force; none: unknown, or chosen by the camera for every image */
  value: orNull(isNumber),
  /** none: unknown, or not adjustable */
  range: orNull(arrayOf(isNumber, 2)),
});
export type Control = Checked<typeof isControl>;

export const isSettingsOutcome = variants({
  /** the site wants nothing */
  none: null,
  /** not applied yet */
  pending: null,
  applied: null,
  /** in force as far as the camera allows */
  adjusted: record({
    detail: isText,
  }),
  /** the camera keeps what it had */
  refused: record({
    detail: isText,
  }),
});
export type SettingsOutcome = Checked<typeof isSettingsOutcome>;

/** what is wrong with a camera node */
export const isCameraNotice = variants({
  /** from the capturing part */
  no_image: record({
    silent_s: isNumber,
  }),
  /** another camera node of this name runs there */
  name_taken: record({
    host: isText,
  }),
  /** cause of the last image or message that could not be used */
  image_refused: record({
    detail: isText,
  }),
  /** the rig has no camera of this name: tags have no poses */
  not_in_rig: null,
  /** a rig or object of the site cannot be used */
  model_refused: record({
    key: isText,
    detail: isText,
  }),
  /** no room for this object's tag sizes: its tags have no poses */
  too_many_tags: record({
    key: isText,
  }),
});
export type CameraNotice = Checked<typeof isCameraNotice>;

export const isCameraStatus = record({
  camera: isText,
  version: isText,
  host: isText,
  captured: isNumber,
  detected: isNumber,
  /** images since the start */
  dropped: isNumber,
  rate_hz: isNumber,
  /** median, 99th percentile */
  detect_ms: arrayOf(isNumber, 2),
  clock: isClock,
  uptime_s: isNumber,
  published: isNumber,
  /** images that the CPU made in place of an accelerator, since the camera was opened */
  fallbacks: isNumber,
  /** mean grey level of the last image, 0 to 255 */
  brightness: isNumber,
  controls: record({
    exposure_us: isControl,
    gain: isControl,
    rate_hz: isControl,
    outcome: isSettingsOutcome,
  }),
  /** at most 32 */
  notices: listOf(isCameraNotice),
});
export type CameraStatus = Checked<typeof isCameraStatus>;

export const isRejections = record({
  /** payloads */
  bad_magic: isNumber,
  /** payloads */
  foreign_version: isNumber,
  /** payloads */
  wrong_kind: isNumber,
  /** payloads */
  damaged: isNumber,
  /** payloads */
  too_long: isNumber,
  /** payloads */
  out_of_range: isNumber,
  /** payloads */
  wrong_camera: isNumber,
});
export type Rejections = Checked<typeof isRejections>;

export const isCameraIntake = record({
  camera: isText,
  received: isNumber,
  rejected: isRejections,
  unknown_tags: isNumber,
  /** images */
  late: isNumber,
  /** tags rejected as outliers */
  gated: isNumber,
  last_capture_ns: isNumber,
  rate_hz: isNumber,
});
export type CameraIntake = Checked<typeof isCameraIntake>;

export const isTagId = record({
  family: isFamily,
  id: isNumber,
});
export type TagId = Checked<typeof isTagId>;

export const isFault = variants({
  /** not where the rig says: calibrate it again */
  camera_moved: record({
    camera: isText,
  }),
  /** one of the two has moved, no third camera tells which: calibrate both again */
  cameras_disagree: record({
    a: isText,
    b: isText,
  }),
  /** not where the object says: put it back, or learn the object again */
  tag_misplaced: record({
    object: isText,
    tag: isTagId,
  }),
  /** true size over the object's: measure the tag and correct its size */
  tag_size: record({
    object: isText,
    tag: isTagId,
    ratio: isNumber,
  }),
  /** seen where it cannot be: take it off there, or print another id */
  tag_elsewhere: record({
    object: isText,
    tag: isTagId,
    /** object */
    on: orNull(isText),
  }),
  /** the camera's clock minus the reference clock; poses allow for it: set the clock */
  clock_off: record({
    camera: isText,
    offset_s: isNumber,
  }),
  /** images arrive so long after their stamps (negative: before) and are left out: set the clock, or check the network */
  untimely: record({
    camera: isText,
    age_s: isNumber,
  }),
  /** twice in one image: print another id for one of them */
  duplicate_tag: record({
    camera: isText,
    tag: isTagId,
  }),
  /** the fusion host's clock minus most cameras'; poses have the cameras' time: set the clock */
  host_clock_off: record({
    offset_s: isNumber,
  }),
  /** its picture has not changed for so long: restart its capture */
  camera_frozen: record({
    camera: isText,
    still_s: isNumber,
  }),
  /** bends otherwise than the rig says: calibrate the lens */
  lens_off: record({
    camera: isText,
  }),
  /** true size of all its tags over the object's: measure them and correct the sizes */
  object_scaled: record({
    object: isText,
    ratio: isNumber,
  }),
  /** so large a share of its views contradicts any pose: check object and cameras */
  object_contradicted: record({
    object: isText,
    share: isNumber,
  }),
  /** no tag has a place on it: learn the object */
  object_unplaced: record({
    object: isText,
  }),
  /** its images are of another size than the rig says and are left out: let it take images of the rig's size, or calibrate the lens at the other one */
  image_size: record({
    camera: isText,
    size: arrayOf(isNumber, 2),
    of_rig: arrayOf(isNumber, 2),
  }),
  /** by right angles about its line of sight; poses allow for it: turn it back, or calibrate it again */
  camera_turned: record({
    camera: isText,
    degrees: isNumber,
  }),
  /** each has the other's name; poses allow for it: exchange the ids in the rig, or the cables */
  cameras_exchanged: record({
    a: isText,
    b: isText,
  }),
  /** focal length over the rig's, another lens or zoom: set it back, or calibrate the lens */
  lens_changed: record({
    camera: isText,
    ratio: isNumber,
  }),
  /** stuck on so; poses allow for it: turn its pose in the object by as much about z */
  tag_turned: record({
    object: isText,
    tag: isTagId,
    degrees: isNumber,
  }),
  /** each is where the other should be; poses allow for it: exchange their ids in the object */
  tags_exchanged: record({
    object: isText,
    a: isTagId,
    b: isTagId,
  }),
  /** it has seen no tag for so long, though the object is in its picture by the rig: covered, moved, out of focus or another lens */
  camera_blind: record({
    camera: isText,
    object: isText,
    blind_s: isNumber,
  }),
});
export type Fault = Checked<typeof isFault>;

/** numbers in the files that the images contradict; poses allow for it */
export const isImperfection = variants({
  /** calibrate the rig */
  cameras_disagree: record({
    a: isText,
    b: isText,
    apart_m: isNumber,
  }),
  /** the tag of the object that is off most: learn the object */
  tag_off: record({
    object: isText,
    tag: isTagId,
    position_m: isNumber,
    orientation_rad: isNumber,
  }),
  /** estimated size over that in the file: measure the tag, or learn the object */
  size_off: record({
    object: isText,
    tag: isTagId,
    ratio: isNumber,
  }),
  /** estimated over that in the file: calibrate the lens */
  focal_length_off: record({
    camera: isText,
    ratio: isNumber,
  }),
  /** all sizes and places over those in the file: measure a tag */
  scale_off: record({
    object: isText,
    ratio: isNumber,
  }),
});
export type Imperfection = Checked<typeof isImperfection>;

/** why a change is refused; `detail` is English text */
export const isRefusal = variants({
  /** damaged, of another kind or version, or a value out of range */
  undecodable: record({
    detail: isText,
  }),
  /** the payload describes another object than its key */
  wrong_id: record({
    described: isText,
  }),
  /** a rig without cameras */
  no_camera: null,
  /** what no rig file may say */
  invalid_camera: record({
    camera: isText,
    detail: isText,
  }),
  /** what no object file may say */
  invalid_object: record({
    tag: orNull(isTagId),
    detail: isText,
  }),
  /** its family has the ids 0 to n_ids - 1 */
  unknown_tag: record({
    tag: isTagId,
    n_ids: isNumber,
  }),
  /** on two objects */
  shared_tag: record({
    tag: isTagId,
    first: isText,
    second: isText,
  }),
  too_many_objects: record({
    limit: isNumber,
  }),
  /** the models after the change do not fit into messages */
  unpublishable: record({
    detail: isText,
  }),
  /** the node cannot write its files */
  not_stored: record({
    detail: isText,
  }),
  other: record({
    detail: isText,
  }),
});
export type Refusal = Checked<typeof isRefusal>;

/** what happened to the node itself */
export const isNotice = variants({
  /** while other cameras send */
  camera_silent: record({
    camera: isText,
    silent_s: isNumber,
  }),
  /** dropped because they arrived too late, since the node started */
  late_observations: record({
    camera: isText,
    total: isNumber,
  }),
  /** observations and poses dropped as the node's machine is too slow, since the last status and since the node started */
  overload: record({
    dropped: isNumber,
    total: isNumber,
  }),
  /** messages with a value out of range, since the node started; cause of the last */
  unpublished: record({
    total: isNumber,
    detail: isText,
  }),
  /** the clock of the node's machine was set */
  clock_stepped: record({
    by_s: isNumber,
  }),
  change_refused: record({
    key: isText,
    sender: orNull(isText),
    refusal: isRefusal,
  }),
  /** another fusion node of this name runs there */
  name_taken: record({
    host: isText,
  }),
  /** as in the Proposal */
  refinement_proposed: record({
    n_images: isNumber,
    before_px: isNumber,
    after_px: isNumber,
  }),
  /** a node whose models are older than another one's: it publishes all objects as lost meanwhile, where it should publish */
  old_models: record({
    node: isText,
    newer: isText,
  }),
  /** the models in force are not in the node's files */
  not_kept: record({
    detail: isText,
  }),
  /** changes made at a node of a divided network are not in force, those of another node are: `sextant config revert --to` brings them back */
  set_aside: record({
    node: isText,
    by: isText,
    t_ns: isNumber,
    detail: isText,
  }),
  /** dropped as too old: they left the camera's machine so long after the capture */
  cameras_slow: record({
    /** at most 16 */
    cameras: listOf(isText),
    behind_s: isNumber,
  }),
});
export type Notice = Checked<typeof isNotice>;

export const isFusionStatus = record({
  node: isText,
  version: isText,
  uptime_s: isNumber,
  /** the newest of its poses; none while it publishes none */
  epoch: orNull(isNumber),
  /** at most 256 */
  cameras: listOf(isCameraIntake),
  /** under keys of cameras that the rig lacks */
  foreign: isRejections,
  /** at most 1024 */
  objects: listOf(record({
    object: isText,
    state: isState,
    rate_hz: isNumber,
  })),
  /** at most 64 */
  faults: listOf(isFault),
  /** further ones */
  faults_left_out: isNumber,
  /** at most 16 */
  imperfections: listOf(isImperfection),
  /** at most 32 */
  notices: listOf(isNotice),
});
export type FusionStatus = Checked<typeof isFusionStatus>;

export const isClockReport = record({
  node: isText,
  /** at most 256; cameras whose clock is not estimated are left out */
  cameras: listOf(record({
    camera: isText,
    /** the camera's clock minus the reference clock; poses allow for it */
    offset_s: isNumber,
    sigma_s: isNumber,
    /** s/s */
    drift: orNull(isNumber),
  })),
});
export type ClockReport = Checked<typeof isClockReport>;

export const isOffer = record({
  node: isText,
  t_ns: isNumber,
  /** whether cameras are among them */
  rig: isFlag,
  objects: listOf(isText),
  n_images: isNumber,
  before_px: isNumber,
  after_px: isNumber,
});
export type Offer = Checked<typeof isOffer>;

export const isWizardKind = oneOf("lens", "rig", "learn");
export type WizardKind = Checked<typeof isWizardKind>;

export const isWizardStage = oneOf("idle", "collecting", "solving", "solved", "keeping", "kept");
export type WizardStage = Checked<typeof isWizardStage>;

export const isLensDetails = record({
  views: isNumber,
  /** corners in each cell of the picture, row by row from the top left */
  coverage: listOf(listOf(isNumber)),
  /** views in which the board's left, right, upper and lower side was turned away */
  tilted: arrayOf(isNumber, 4),
});
export type LensDetails = Checked<typeof isLensDetails>;

export const isCameraProgress = record({
  camera: isText,
  images: isNumber,
  seeing: isNumber,
  /** twelve of the picture, four by three, row by row */
  fields: listOf(isFlag),
  distances: isNumber,
  /** equal ones are joined */
  group: isNumber,
});
export type CameraProgress = Checked<typeof isCameraProgress>;

export const isRigDetails = record({
  cameras: listOf(isCameraProgress),
  /** common views */
  together: listOf(tuple(isText, isText, isNumber)),
});
export type RigDetails = Checked<typeof isRigDetails>;

export const isTagProgress = record({
  tag: isText,
  images: isNumber,
  directions: isNumber,
  group: isNumber,
});
export type TagProgress = Checked<typeof isTagProgress>;

export const isSketchedTag = record({
  tag: isText,
  size_m: isNumber,
  position: arrayOf(isNumber, 3),
  orientation: arrayOf(isNumber, 4),
});
export type SketchedTag = Checked<typeof isSketchedTag>;

export const isLearnDetails = record({
  joining: isNumber,
  tags: listOf(isTagProgress),
  /** the joined tags about where they are */
  sketch: listOf(isSketchedTag),
});
export type LearnDetails = Checked<typeof isLearnDetails>;

export const isProgressDetails = anyOf(isLensDetails, isRigDetails, isLearnDetails);
export type ProgressDetails = Checked<typeof isProgressDetails>;

export const isProgress = record({
  kind: isWizardKind,
  images: isNumber,
  /** 0 to 1 */
  fraction: isNumber,
  is_enough: isFlag,
  /** what to do next, in words */
  hint: isText,
  details: isProgressDetails,
});
export type Progress = Checked<typeof isProgress>;

export const isMapCell = record({
  corners: isNumber,
  mean_px: arrayOf(isNumber, 2),
  rms_px: isNumber,
  sigma_px: orNull(isNumber),
});
export type MapCell = Checked<typeof isMapCell>;

export const isVerdict = record({
  grade: oneOf("good", "usable", "poor"),
  because: listOf(isText),
});
export type Verdict = Checked<typeof isVerdict>;

export const isLensReport = record({
  camera: isText,
  lens: isRigLens,
  sigmas: listOf(isNumber),
  rms_px: isNumber,
  noise_px: isNumber,
  images: isNumber,
  views: isNumber,
  coverage: isNumber,
  models: listOf(record({
    model: isText,
    held_out_rms_px: isNumber,
  })),
  cells: listOf(listOf(isMapCell)),
  verdict: isVerdict,
});
export type LensReport = Checked<typeof isLensReport>;

export const isCalibratedCamera = record({
  camera: isText,
  images: isNumber,
  left_out: isNumber,
  sigma_mm: isNumber,
  sigma_deg: isNumber,
  rms_px: isNumber,
  /** its clock minus the reference's */
  clock_offset_ms: orNull(isNumber),
});
export type CalibratedCamera = Checked<typeof isCalibratedCamera>;

export const isRigReport = record({
  reference: isText,
  images: isNumber,
  images_used: isNumber,
  rms_px: isNumber,
  cameras: listOf(isCalibratedCamera),
  verdict: isVerdict,
});
export type RigReport = Checked<typeof isRigReport>;

export const isLearnedTag = record({
  tag: isText,
  images: isNumber,
  left_out: isNumber,
  sigma_mm: isNumber,
  sigma_deg: isNumber,
  rms_px: isNumber,
});
export type LearnedTag = Checked<typeof isLearnedTag>;

export const isLearnReport = record({
  object: isText,
  images: isNumber,
  images_used: isNumber,
  rms_px: isNumber,
  tags: listOf(isLearnedTag),
  kept: listOf(isText),
  verdict: isVerdict,
});
export type LearnReport = Checked<typeof isLearnReport>;

export const isWizardReport = anyOf(isLensReport, isRigReport, isLearnReport);
export type WizardReport = Checked<typeof isWizardReport>;

export const isWizardResult = record({
  /** what `sextant calibrate` and `learn` print with --json; more fields than these */
  report: isWizardReport,
  model: record({}, {
    cameras: listOf(isRigCamera),
    tags: listOf(isPrintedTag),
  }),
  file: isText,
  /** name and text of the file that keeps it */
  toml: isText,
  /** what became of it, a sentence each */
  kept: listOf(isText),
});
export type WizardResult = Checked<typeof isWizardResult>;

export const isWizard = record({
  wizard: orNull(isWizardKind),
  stage: isWizardStage,
}, {
  /** the camera or the object */
  subject: isText,
  /** what went wrong last, in words */
  cause: isText,
  /** images that came while the wizard had its hands full */
  missed: isNumber,
  /** while collecting and solving */
  progress: isProgress,
  /** from solved on */
  result: isWizardResult,
});
export type Wizard = Checked<typeof isWizard>;

export const isBoxZone = record({
  shape: oneOf("box"),
  name: isText,
  centre: arrayOf(isNumber, 3),
  size: arrayOf(isNumber, 3),
  /** turn about the vertical axis through the centre */
  yaw_deg: isNumber,
  inside: listOf(isText),
});
export type BoxZone = Checked<typeof isBoxZone>;

export const isSphereZone = record({
  shape: oneOf("sphere"),
  name: isText,
  centre: arrayOf(isNumber, 3),
  radius: isNumber,
  inside: listOf(isText),
});
export type SphereZone = Checked<typeof isSphereZone>;

export const isZone = anyOf(isBoxZone, isSphereZone);
export type Zone = Checked<typeof isZone>;

export const isZones = record({
  zones: listOf(isZone),
  /** whether the bridge has a `folder` with the file `zones.toml` that keeps them */
  kept: isFlag,
});
export type Zones = Checked<typeof isZones>;

export const isSiteEvent = record({
  sequence: isNumber,
  t_ns: isNumber,
  object: isText,
  event: oneOf("entered", "left", "fell"),
  position: arrayOf(isNumber, 3),
}, {
  zone: isText,
  cause: oneOf("drop", "tilt"),
});
export type SiteEvent = Checked<typeof isSiteEvent>;

export const isEvents = record({
  events: listOf(isSiteEvent),
  /** events that were not published on the network because 256 were waiting */
  dropped: isNumber,
});
export type Events = Checked<typeof isEvents>;

export const isAlive = record({
  /** camera, fusion or viewer */
  kind: isText,
  id: isText,
  up: isFlag,
});
export type Alive = Checked<typeof isAlive>;

export const isBridgeRejections = record({
  bad_magic: isNumber,
  foreign_version: isNumber,
  wrong_kind: isNumber,
  damaged: isNumber,
  too_long: isNumber,
  out_of_range: isNumber,
  wrong_camera: isNumber,
  /** names another camera, object or node than its key */
  wrong_id: isNumber,
  /** a rig or an object that makes no sense */
  invalid_model: isNumber,
  /** more cameras, objects or nodes than the bridge keeps */
  too_many: isNumber,
});
export type BridgeRejections = Checked<typeof isBridgeRejections>;

export const isBridgeStatus = record({
  now_ns: isNumber,
  uptime_s: isNumber,
  /** whether the bridge has its place on the site's network now */
  network: isFlag,
  clients: isNumber,
  /** messages that slow clients skipped */
  replaced: isNumber,
  rejected: isBridgeRejections,
  /** events since the start; none without a webhook */
  webhook: orNull(record({
    delivered: isNumber,
    failed: isNumber,
    dropped: isNumber,
  })),
});
export type BridgeStatus = Checked<typeof isBridgeStatus>;

/** By the `type` of each message. */
export const MESSAGES = {
  hello: isHello,
  rig: isRig,
  object: isObject,
  object_gone: isObjectGone,
  pose: isPose,
  joints: isJoints,
  truth: isTruth,
  observations: isObservations,
  detection_report: isDetectionReport,
  camera_status: isCameraStatus,
  fusion_status: isFusionStatus,
  clocks: isClockReport,
  proposal: isOffer,
  former: isOffer,
  wizard: isWizard,
  zones: isZones,
  events: isEvents,
  alive: isAlive,
  bridge_status: isBridgeStatus,
};
