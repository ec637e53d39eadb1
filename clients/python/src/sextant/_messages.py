"""The messages of the wire contract. Written by `cargo xtask python` from proto/CONTRACT.md: do not edit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Optional, Union

from ._postcard import F32, F64, U8, U16, U32, U64, AtMost, Kind, Length, Record, VariantRecord, Word


@dataclass(frozen=True)
class ObservationsTiming(Record):
    """`timing` of Observations."""

    received_ns: U64
    detected_ns: U64
    published_ns: U64


@dataclass(frozen=True)
class Observations(Record):
    """Observations."""

    camera: str
    #: of the image since the camera started; gaps are images that were skipped
    sequence: U64
    capture_ns: U64
    #: 0: unknown
    exposure_ns: U32
    clock: Clock
    #: width, height; never 0
    resolution: Annotated[tuple[U16, ...], Length(2)]
    timing: ObservationsTiming
    #: at most 256
    tags: Annotated[tuple[Tag, ...], AtMost(256)]


class ClockSource(Word):
    """`source` of Clock."""

    UNKNOWN = "unknown"
    FREE_RUNNING = "free-running"
    NTP = "ntp"
    PTP = "ptp"
    RECORDED = "recorded"
    SIMULATED = "simulated"
    #: time of arrival, not of exposure
    ARRIVAL = "arrival"


@dataclass(frozen=True)
class Clock(Record):
    """Clock."""

    source: ClockSource
    #: one sigma; 0 where recorded or simulated
    error_ns: U64


@dataclass(frozen=True)
class Tag(Record):
    """Tag."""

    family: Family
    id: U32
    #: corrected bits
    hamming: U8
    #: decision margin, grey levels
    margin: F32
    #: x, y of top left, top right, bottom right, bottom left of the upright tag
    corners: Annotated[tuple[Annotated[tuple[F32, ...], Length(2)], ...], Length(4)]
    #: xx, xy, yy of each corner, px²
    corner_covariance: Annotated[tuple[Annotated[tuple[F32, ...], Length(3)], ...], Length(4)]
    #: between corners 0 1, 0 2, 0 3, 1 2, 1 3, 2 3: xx, xy, yx, yy, px²; 0 where the errors are independent or this is unknown
    corner_cross_covariance: Annotated[tuple[Annotated[tuple[F32, ...], Length(4)], ...], Length(6)]
    #: at most 2, the better first; empty where lens or size are unknown
    poses: Annotated[tuple[TagPose, ...], AtMost(2)]


@dataclass(frozen=True)
class TagPose(Record):
    """TagPose."""

    position: Annotated[tuple[F32, ...], Length(3)]
    #: camera_from_tag
    orientation: Annotated[tuple[F32, ...], Length(4)]
    #: reprojection error
    rms_px: F32


class Family(Word):
    """The corners of a charuco tag are those of the white square of the chessboard around the marker. A chessboard tag is a square of a plain chessboard between inner corners; its id is 64 times the row plus the column of its upper left corner."""

    TAG36H11 = "tag36h11"
    TAG25H9 = "tag25h9"
    TAG16H5 = "tag16h5"
    TAGSTANDARD41H12 = "tagStandard41h12"
    ARUCO4X4_50 = "aruco4x4-50"
    ARUCO4X4_100 = "aruco4x4-100"
    ARUCO4X4_250 = "aruco4x4-250"
    ARUCO4X4_1000 = "aruco4x4-1000"
    ARUCO5X5_50 = "aruco5x5-50"
    ARUCO5X5_100 = "aruco5x5-100"
    ARUCO5X5_250 = "aruco5x5-250"
    ARUCO5X5_1000 = "aruco5x5-1000"
    ARUCO6X6_50 = "aruco6x6-50"
    ARUCO6X6_100 = "aruco6x6-100"
    ARUCO6X6_250 = "aruco6x6-250"
    ARUCO6X6_1000 = "aruco6x6-1000"
    TAG36H11B2 = "tag36h11b2"
    ARUCO7X7_50 = "aruco7x7-50"
    ARUCO7X7_100 = "aruco7x7-100"
    ARUCO7X7_250 = "aruco7x7-250"
    ARUCO7X7_1000 = "aruco7x7-1000"
    CHARUCO4X4_50 = "charuco4x4-50"
    CHARUCO4X4_100 = "charuco4x4-100"
    CHARUCO4X4_250 = "charuco4x4-250"
    CHARUCO4X4_1000 = "charuco4x4-1000"
    CHARUCO5X5_50 = "charuco5x5-50"
    CHARUCO5X5_100 = "charuco5x5-100"
    CHARUCO5X5_250 = "charuco5x5-250"
    CHARUCO5X5_1000 = "charuco5x5-1000"
    CHARUCO6X6_50 = "charuco6x6-50"
    CHARUCO6X6_100 = "charuco6x6-100"
    CHARUCO6X6_250 = "charuco6x6-250"
    CHARUCO6X6_1000 = "charuco6x6-1000"
    CHARUCO7X7_50 = "charuco7x7-50"
    CHARUCO7X7_100 = "charuco7x7-100"
    CHARUCO7X7_250 = "charuco7x7-250"
    CHARUCO7X7_1000 = "charuco7x7-1000"
    ARUCO_ORIGINAL = "aruco-original"
    ARUCO_MIP_36H12 = "aruco-mip-36h12"
    TAG36H10 = "tag36h10"
    TAGCUSTOM48H12 = "tagCustom48h12"
    TAGSTANDARD52H13 = "tagStandard52h13"
    CHESSBOARD = "chessboard"
    TAGCIRCLE21H7 = "tagCircle21h7"
    TAGCIRCLE49H12 = "tagCircle49h12"
    ARUCO_MIP_16H3 = "aruco-mip-16h3"
    ARUCO_MIP_25H7 = "aruco-mip-25h7"


@dataclass(frozen=True)
class Preview(Record):
    """Preview."""

    camera: str
    #: as in its Observations
    sequence: U64
    capture_ns: U64
    #: of the captured image, to which corners refer; the JPEG may be smaller
    resolution: Annotated[tuple[U16, ...], Length(2)]
    #: at most 100 000
    jpeg: Annotated[bytes, AtMost(100000)]


@dataclass(frozen=True)
class DetectionReportStageMs(Record):
    """`stage_ms` of DetectionReport."""

    tiles: F32
    threshold: F32
    components: F32
    quads: F32
    decode: F32
    refine: F32


@dataclass(frozen=True)
class DetectionReportRejected(Record):
    """`rejected` of DetectionReport."""

    not_a_quad: U32
    shape: U32
    faint_border: U32
    no_code: U32
    small_margin: U32


@dataclass(frozen=True)
class DetectionReportExample(Record):
    """`examples` of DetectionReport."""

    cause: RejectionCause
    corners: Annotated[tuple[Annotated[tuple[F32, ...], Length(2)], ...], Length(4)]


@dataclass(frozen=True)
class DetectionReport(Record):
    """DetectionReport."""

    camera: str
    sequence: U64
    capture_ns: U64
    resolution: Annotated[tuple[U16, ...], Length(2)]
    #: share of the image, 0 to 1
    searched: F32
    stage_ms: DetectionReportStageMs
    #: grey levels
    noise_sigma: F32
    #: grey levels
    contrast_gate: U8
    components: U32
    candidates: U32
    #: candidates beyond the detector's memory
    dropped: U32
    tags: U32
    rejected: DetectionReportRejected
    #: at most 64
    examples: Annotated[tuple[DetectionReportExample, ...], AtMost(64)]


class RejectionCause(Word):
    """RejectionCause."""

    NOT_A_QUAD = "not_a_quad"
    SHAPE = "shape"
    FAINT_BORDER = "faint_border"
    NO_CODE = "no_code"
    SMALL_MARGIN = "small_margin"


@dataclass(frozen=True)
class CameraStatusControls(Record):
    """`controls` of CameraStatus."""

    exposure_us: Control
    gain: Control
    rate_hz: Control
    outcome: SettingsOutcome


@dataclass(frozen=True)
class CameraStatus(Record):
    """CameraStatus."""

    camera: str
    version: str
    host: str
    captured: U64
    detected: U64
    #: images since the start
    dropped: U64
    rate_hz: F32
    #: median, 99th percentile
    detect_ms: Annotated[tuple[F32, ...], Length(2)]
    clock: Clock
    uptime_s: U64
    published: U64
    #: images that the CPU made in place of an accelerator, since the camera was opened
    fallbacks: U64
    #: mean grey level of the last image, 0 to 255
    brightness: F32
    controls: CameraStatusControls
    #: at most 32
    notices: Annotated[tuple[CameraNotice, ...], AtMost(32)]


@dataclass(frozen=True)
class Control(Record):
    """Control."""

    #: by the site; none: up to the camera's own file
    wanted: Optional[F64]
    #: in force; none: unknown, or chosen by the camera for every image
    value: Optional[F64]
    #: none: unknown, or not adjustable
    range: Optional[Annotated[tuple[F64, ...], Length(2)]]


@dataclass(frozen=True)
class SettingsOutcomeNone(VariantRecord, variant="none", form="unit"):
    """The site wants nothing."""


@dataclass(frozen=True)
class SettingsOutcomePending(VariantRecord, variant="pending", form="unit"):
    """Not applied yet."""


@dataclass(frozen=True)
class SettingsOutcomeApplied(VariantRecord, variant="applied", form="unit"):
    """SettingsOutcomeApplied."""


@dataclass(frozen=True)
class SettingsOutcomeAdjusted(VariantRecord, variant="adjusted", form="fields"):
    """In force as far as the camera allows."""

    detail: str


@dataclass(frozen=True)
class SettingsOutcomeRefused(VariantRecord, variant="refused", form="fields"):
    """The camera keeps what it had."""

    detail: str


#: SettingsOutcome.
SettingsOutcome = Union[SettingsOutcomeNone, SettingsOutcomePending, SettingsOutcomeApplied, SettingsOutcomeAdjusted, SettingsOutcomeRefused]


@dataclass(frozen=True)
class ObjectPose(Record):
    """ObjectPose."""

    object: str
    #: of the fusion node, as below
    epoch: U64
    #: of this object's poses; gaps within an epoch are lost messages
    sequence: U64
    capture_ns: U64
    published_ns: U64
    state: State
    position: Annotated[tuple[F64, ...], Length(3)]
    #: world_from_object
    orientation: Annotated[tuple[F64, ...], Length(4)]
    covariance: Annotated[tuple[F64, ...], Length(36)]
    #: velocity of the origin, angular velocity; world axes, m/s, rad/s
    twist: Annotated[tuple[F64, ...], Length(6)]
    cameras: U16
    #: that entered the estimate
    tags: U16
    rms_px: F32


class State(Word):
    """State."""

    INITIALISING = "initialising"
    TRACKING = "tracking"
    COASTING = "coasting"
    LOST = "lost"


@dataclass(frozen=True)
class ObjectLinksLink(Record):
    """`links` of ObjectLinks."""

    link: str
    position: Annotated[tuple[F64, ...], Length(3)]
    #: world_from_link
    orientation: Annotated[tuple[F64, ...], Length(4)]
    covariance: Annotated[tuple[F64, ...], Length(36)]


@dataclass(frozen=True)
class ObjectLinksJoint(Record):
    """`joints` of ObjectLinks."""

    joint: str
    #: rad or m
    value: F64
    variance: F64
    velocity: F64
    velocity_variance: F64


@dataclass(frozen=True)
class ObjectLinks(Record):
    """ObjectLinks."""

    object: str
    epoch: U64
    sequence: U64
    capture_ns: U64
    published_ns: U64
    #: all as in the ObjectPose
    state: State
    #: at most 32
    links: Annotated[tuple[ObjectLinksLink, ...], AtMost(32)]
    #: at most 8; fixed joints are left out
    joints: Annotated[tuple[ObjectLinksJoint, ...], AtMost(8)]


@dataclass(frozen=True)
class ObjectTruth(Record):
    """ObjectTruth."""

    object: str
    capture_ns: U64
    position: Annotated[tuple[F64, ...], Length(3)]
    orientation: Annotated[tuple[F64, ...], Length(4)]
    position_error_m: F64
    attitude_error_rad: F64


@dataclass(frozen=True)
class FusionStatusObject(Record):
    """`objects` of FusionStatus."""

    object: str
    state: State
    rate_hz: F32


@dataclass(frozen=True)
class FusionStatus(Record):
    """FusionStatus."""

    node: str
    version: str
    uptime_s: U64
    #: the newest of its poses; none while it publishes none
    epoch: Optional[U64]
    #: at most 256
    cameras: Annotated[tuple[CameraIntake, ...], AtMost(256)]
    #: under keys of cameras that the rig lacks
    foreign: Rejections
    #: at most 1024
    objects: Annotated[tuple[FusionStatusObject, ...], AtMost(1024)]
    #: at most 64
    faults: Annotated[tuple[Fault, ...], AtMost(64)]
    #: further ones
    faults_left_out: U32
    #: at most 16
    imperfections: Annotated[tuple[Imperfection, ...], AtMost(16)]
    #: at most 32
    notices: Annotated[tuple[Notice, ...], AtMost(32)]


@dataclass(frozen=True)
class CameraIntake(Record):
    """CameraIntake."""

    camera: str
    received: U64
    rejected: Rejections
    unknown_tags: U64
    #: images
    late: U64
    #: tags rejected as outliers
    gated: U64
    last_capture_ns: U64
    rate_hz: F32


@dataclass(frozen=True)
class Rejections(Record):
    """Rejections."""

    #: payloads
    bad_magic: U64
    #: payloads
    foreign_version: U64
    #: payloads
    wrong_kind: U64
    #: payloads
    damaged: U64
    #: payloads
    too_long: U64
    #: payloads
    out_of_range: U64
    #: payloads
    wrong_camera: U64


@dataclass(frozen=True)
class ClockReportCamera(Record):
    """`cameras` of ClockReport."""

    camera: str
    #: the camera's clock minus the reference clock; poses allow for it
    offset_s: F64
    sigma_s: F64
    #: s/s
    drift: Optional[F64]


@dataclass(frozen=True)
class ClockReport(Record):
    """ClockReport."""

    node: str
    #: at most 256; cameras whose clock is not estimated are left out
    cameras: Annotated[tuple[ClockReportCamera, ...], AtMost(256)]


@dataclass(frozen=True)
class FusionInputsInput(Record):
    """`inputs` of FusionInputs."""

    #: time given to the estimator
    now_ns: U64
    source: InputSource


@dataclass(frozen=True)
class FusionInputs(Record):
    """FusionInputs."""

    node: str
    #: number of the first of these inputs since the node started, from 0; a gap is a lost message
    first: U64
    #: at most 256
    inputs: Annotated[tuple[FusionInputsInput, ...], AtMost(256)]


@dataclass(frozen=True)
class InputSourceImage(VariantRecord, variant="image", form="fields"):
    """InputSourceImage."""

    camera: str
    sequence: U64
    #: as in its Observations
    capture_ns: U64


@dataclass(frozen=True)
class InputSourceRig(VariantRecord, variant="rig", form="value"):
    """Fingerprint of its RigConfig."""

    value: U64


@dataclass(frozen=True)
class InputSourceObjects(VariantRecord, variant="objects", form="value"):
    """Fingerprints of their ObjectConfigs, at most 1024."""

    value: Annotated[tuple[U64, ...], AtMost(1024)]


@dataclass(frozen=True)
class InputSourceClockStep(VariantRecord, variant="clock-step", form="unit"):
    """InputSourceClockStep."""


@dataclass(frozen=True)
class InputSourceTick(VariantRecord, variant="tick", form="unit"):
    """InputSourceTick."""


@dataclass(frozen=True)
class InputSourceAdjusted(VariantRecord, variant="adjusted", form="unit"):
    """The adjustment of the files that was due."""


#: The first two inputs of a run are the rig and the objects before its first image.
InputSource = Union[InputSourceImage, InputSourceRig, InputSourceObjects, InputSourceClockStep, InputSourceTick, InputSourceAdjusted]


@dataclass(frozen=True)
class HeartbeatHeard(Record):
    """`heard` of Heartbeat."""

    node: str
    sent_ns: U64


@dataclass(frozen=True)
class HeartbeatSharingObjectPartPreparing(VariantRecord, variant="preparing", form="unit"):
    """Not seen for long enough."""


@dataclass(frozen=True)
class HeartbeatSharingObjectPartReady(VariantRecord, variant="ready", form="unit"):
    """To publish."""


@dataclass(frozen=True)
class HeartbeatSharingObjectPartPublishing(VariantRecord, variant="publishing", form="value"):
    """The epoch of its poses."""

    value: U64


#: `part` of HeartbeatSharingObject.
HeartbeatSharingObjectPart = Union[HeartbeatSharingObjectPartPreparing, HeartbeatSharingObjectPartReady, HeartbeatSharingObjectPartPublishing]


@dataclass(frozen=True)
class HeartbeatSharingObject(Record):
    """`objects` of HeartbeatSharing."""

    object: str
    part: HeartbeatSharingObjectPart


@dataclass(frozen=True)
class HeartbeatSharing(Record):
    """`sharing` of Heartbeat."""

    #: nodes besides the publisher that track an object; none: its file names its objects
    standbys: Optional[U32]
    #: those that the node tracks; at most 1024
    objects: Annotated[tuple[HeartbeatSharingObject, ...], AtMost(1024)]


@dataclass(frozen=True)
class HeartbeatModelsVersion(Record):
    """`version` of HeartbeatModels."""

    #: at most 2^62
    counter: U64
    t_ns: U64
    #: the fusion node that made it
    author: str


@dataclass(frozen=True)
class HeartbeatModels(Record):
    """`models` of Heartbeat."""

    #: none: files that were compared with no other node's
    version: Optional[HeartbeatModelsVersion]
    #: of the payloads that carry them
    fingerprint: U64


@dataclass(frozen=True)
class Heartbeat(Record):
    """Heartbeat."""

    node: str
    #: by a clock of the node that is never set
    sent_ns: U64
    #: of the poses that the node publishes; none while it stands by
    epoch: Optional[U64]
    #: the newest epoch that the node knows of
    newest: U64
    #: the last heartbeat received of each other node; at most 64
    heard: Annotated[tuple[HeartbeatHeard, ...], AtMost(64)]
    #: none: one node publishes all poses
    sharing: Optional[HeartbeatSharing]
    models: HeartbeatModels


@dataclass(frozen=True)
class ConfigAnswerOutcomeTaken(VariantRecord, variant="taken", form="unit"):
    """ConfigAnswerOutcomeTaken."""


@dataclass(frozen=True)
class ConfigAnswerOutcomeKept(VariantRecord, variant="kept", form="unit"):
    """ConfigAnswerOutcomeKept."""


@dataclass(frozen=True)
class ConfigAnswerOutcomeSame(VariantRecord, variant="same", form="unit"):
    """ConfigAnswerOutcomeSame."""


@dataclass(frozen=True)
class ConfigAnswerOutcomeRefused(VariantRecord, variant="refused", form="value"):
    """ConfigAnswerOutcomeRefused."""

    value: Refusal


#: `outcome` of ConfigAnswer.
ConfigAnswerOutcome = Union[ConfigAnswerOutcomeTaken, ConfigAnswerOutcomeKept, ConfigAnswerOutcomeSame, ConfigAnswerOutcomeRefused]


@dataclass(frozen=True)
class ConfigAnswer(Record):
    """ConfigAnswer."""

    node: str
    key: str
    fingerprint: U64
    outcome: ConfigAnswerOutcome
    #: the other fusion nodes that work from it too; at most 64
    followers: Annotated[tuple[str, ...], AtMost(64)]
    #: those that did not within a second; at most 64
    behind: Annotated[tuple[str, ...], AtMost(64)]


@dataclass(frozen=True)
class Proposal(Record):
    """Proposal."""

    node: str
    t_ns: U64
    #: payload of a RigConfig, header included
    rig: Optional[bytes]
    #: payload of an ObjectConfig each; at most 1024
    objects: Annotated[tuple[bytes, ...], AtMost(1024)]
    n_images: U32
    before_px: F64
    after_px: F64


@dataclass(frozen=True)
class RigConfig(Record):
    """RigConfig."""

    #: at most 256
    cameras: Annotated[tuple[Camera, ...], AtMost(256)]
    #: of the scale that all positions share, as a share of it
    scale_sigma: Optional[F64]


@dataclass(frozen=True)
class CameraLensSigma(Record):
    """`lens_sigma` of Camera."""

    focal_px: F64
    #: at the image's corners
    distortion_px: F64


@dataclass(frozen=True)
class CameraMount(Record):
    """`mount` of Camera."""

    #: the object that carries it
    carrier: str
    carrier_from_camera: Pose


class CameraExposureStamp(Word):
    """`stamp` of CameraExposure."""

    START = "start"
    MIDDLE = "middle"
    END = "end"


@dataclass(frozen=True)
class CameraExposure(Record):
    """`exposure` of Camera."""

    length_s: F64
    #: moment of the exposure that the camera's time stamps mark
    stamp: CameraExposureStamp


@dataclass(frozen=True)
class Camera(Record):
    """Camera."""

    id: str
    resolution: Annotated[tuple[U32, ...], Length(2)]
    lens: Lens
    lens_sigma: Optional[CameraLensSigma]
    #: none until calibrated, and where it is carried
    world_from_camera: Optional[Pose]
    #: none where it stands still
    mount: Optional[CameraMount]
    #: of either pose
    world_from_camera_sigma: Optional[Sigma]
    #: from a row to the next; negative where the bottom row is read first; none: global shutter
    line_delay_s: Optional[F64]
    exposure: Optional[CameraExposure]


@dataclass(frozen=True)
class LensPinhole(VariantRecord, variant="pinhole", form="fields"):
    """LensPinhole."""

    fx: F64
    fy: F64
    cx: F64
    cy: F64


@dataclass(frozen=True)
class LensBrownConrady(VariantRecord, variant="brown-conrady", form="fields"):
    """LensBrownConrady."""

    fx: F64
    fy: F64
    cx: F64
    cy: F64
    #: k1, k2, p1, p2, k3
    distortion: Annotated[tuple[F64, ...], Length(5)]


@dataclass(frozen=True)
class LensKannalaBrandt(VariantRecord, variant="kannala-brandt", form="fields"):
    """LensKannalaBrandt."""

    fx: F64
    fy: F64
    cx: F64
    cy: F64
    #: k1, k2, k3, k4
    distortion: Annotated[tuple[F64, ...], Length(4)]


#: Lens.
Lens = Union[LensPinhole, LensBrownConrady, LensKannalaBrandt]


@dataclass(frozen=True)
class Pose(Record):
    """Pose."""

    position: Annotated[tuple[F64, ...], Length(3)]
    orientation: Annotated[tuple[F64, ...], Length(4)]


@dataclass(frozen=True)
class Sigma(Record):
    """Sigma."""

    position_m: F64
    #: the same along each axis
    orientation_rad: F64


@dataclass(frozen=True)
class ObjectConfig(Record):
    """ObjectConfig."""

    id: str
    #: at most 32; empty for a rigid object
    links: Annotated[tuple[str, ...], AtMost(32)]
    #: at most 32
    joints: Annotated[tuple[Joint, ...], AtMost(32)]
    #: at most 1024; empty: the object is removed
    tags: Annotated[tuple[ObjectTag, ...], AtMost(1024)]
    #: of the object's frame in its tags
    frame_sigma: Optional[Sigma]
    #: of the scale that its tags share, as a share of it
    scale_sigma: Optional[F64]
    #: where it stands still as a landmark, by which carried cameras are localised
    world_from_object: Optional[Pose]


class JointKind(Word):
    """`kind` of Joint."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    FIXED = "fixed"


@dataclass(frozen=True)
class Joint(Record):
    """Joint."""

    id: str
    kind: JointKind
    parent: str
    #: links
    child: str
    #: unit vector in the joint's frame
    axis: Annotated[tuple[F64, ...], Length(3)]
    parent_from_joint: Pose
    limits: Optional[Annotated[tuple[F64, ...], Length(2)]]
    #: rad/s or m/s
    max_speed: Optional[F64]


@dataclass(frozen=True)
class ObjectTag(Record):
    """ObjectTag."""

    family: Family
    id: U32
    size_m: F64
    size_sigma_m: Optional[F64]
    #: index into links; none on a rigid object
    link: Optional[U8]
    #: link_from_tag on a link; none until learned
    object_from_tag: Optional[Pose]
    object_from_tag_sigma: Optional[Sigma]


@dataclass(frozen=True)
class CameraSettings(Record):
    """CameraSettings."""

    camera: str
    #: 1 to 1 000 000
    exposure_us: Optional[F64]
    #: in the driver's units, 0 to 1 000 000
    gain: Optional[F64]
    #: 0.1 to 1000
    rate_hz: Optional[F64]


@dataclass(frozen=True)
class TagId(Record):
    """TagId."""

    family: Family
    id: U32


@dataclass(frozen=True)
class FaultCameraMoved(VariantRecord, variant="camera_moved", form="fields"):
    """Not where the rig says: calibrate it again."""

    camera: str


@dataclass(frozen=True)
class FaultCamerasDisagree(VariantRecord, variant="cameras_disagree", form="fields"):
    """One of the two has moved, no third camera tells which: calibrate both again."""

    a: str
    b: str


@dataclass(frozen=True)
class FaultTagMisplaced(VariantRecord, variant="tag_misplaced", form="fields"):
    """Not where the object says: put it back, or learn the object again."""

    object: str
    tag: TagId


@dataclass(frozen=True)
class FaultTagSize(VariantRecord, variant="tag_size", form="fields"):
    """True size over the object's: measure the tag and correct its size."""

    object: str
    tag: TagId
    ratio: F64


@dataclass(frozen=True)
class FaultTagElsewhere(VariantRecord, variant="tag_elsewhere", form="fields"):
    """Seen where it cannot be: take it off there, or print another id."""

    object: str
    tag: TagId
    #: object
    on: Optional[str]


@dataclass(frozen=True)
class FaultClockOff(VariantRecord, variant="clock_off", form="fields"):
    """The camera's clock minus the reference clock; poses allow for it: set the clock."""

    camera: str
    offset_s: F64


@dataclass(frozen=True)
class FaultUntimely(VariantRecord, variant="untimely", form="fields"):
    """Images arrive so long after their stamps (negative: before) and are left out: set the clock, or check the network."""

    camera: str
    age_s: F64


@dataclass(frozen=True)
class FaultDuplicateTag(VariantRecord, variant="duplicate_tag", form="fields"):
    """Twice in one image: print another id for one of them."""

    camera: str
    tag: TagId


@dataclass(frozen=True)
class FaultHostClockOff(VariantRecord, variant="host_clock_off", form="fields"):
    """The fusion host's clock minus most cameras'; poses have the cameras' time: set the clock."""

    offset_s: F64


@dataclass(frozen=True)
class FaultCameraFrozen(VariantRecord, variant="camera_frozen", form="fields"):
    """Its picture has not changed for so long: restart its capture."""

    camera: str
    still_s: F64


@dataclass(frozen=True)
class FaultLensOff(VariantRecord, variant="lens_off", form="fields"):
    """Bends otherwise than the rig says: calibrate the lens."""

    camera: str


@dataclass(frozen=True)
class FaultObjectScaled(VariantRecord, variant="object_scaled", form="fields"):
    """True size of all its tags over the object's: measure them and correct the sizes."""

    object: str
    ratio: F64


@dataclass(frozen=True)
class FaultObjectContradicted(VariantRecord, variant="object_contradicted", form="fields"):
    """So large a share of its views contradicts any pose: check object and cameras."""

    object: str
    share: F64


@dataclass(frozen=True)
class FaultObjectUnplaced(VariantRecord, variant="object_unplaced", form="fields"):
    """No tag has a place on it: learn the object."""

    object: str


@dataclass(frozen=True)
class FaultImageSize(VariantRecord, variant="image_size", form="fields"):
    """Its images are of another size than the rig says and are left out: let it take images of the rig's size, or calibrate the lens at the other one."""

    camera: str
    size: Annotated[tuple[U32, ...], Length(2)]
    of_rig: Annotated[tuple[U32, ...], Length(2)]


@dataclass(frozen=True)
class FaultCameraTurned(VariantRecord, variant="camera_turned", form="fields"):
    """By right angles about its line of sight; poses allow for it: turn it back, or calibrate it again."""

    camera: str
    degrees: U16


@dataclass(frozen=True)
class FaultCamerasExchanged(VariantRecord, variant="cameras_exchanged", form="fields"):
    """Each has the other's name; poses allow for it: exchange the ids in the rig, or the cables."""

    a: str
    b: str


@dataclass(frozen=True)
class FaultLensChanged(VariantRecord, variant="lens_changed", form="fields"):
    """Focal length over the rig's, another lens or zoom: set it back, or calibrate the lens."""

    camera: str
    ratio: F64


@dataclass(frozen=True)
class FaultTagTurned(VariantRecord, variant="tag_turned", form="fields"):
    """Stuck on so; poses allow for it: turn its pose in the object by as much about z."""

    object: str
    tag: TagId
    degrees: U16


@dataclass(frozen=True)
class FaultTagsExchanged(VariantRecord, variant="tags_exchanged", form="fields"):
    """Each is where the other should be; poses allow for it: exchange their ids in the object."""

    object: str
    a: TagId
    b: TagId


@dataclass(frozen=True)
class FaultCameraBlind(VariantRecord, variant="camera_blind", form="fields"):
    """It has seen no tag for so long, though the object is in its picture by the rig: covered, moved, out of focus or another lens."""

    camera: str
    object: str
    blind_s: F64


#: Fault.
Fault = Union[FaultCameraMoved, FaultCamerasDisagree, FaultTagMisplaced, FaultTagSize, FaultTagElsewhere, FaultClockOff, FaultUntimely, FaultDuplicateTag, FaultHostClockOff, FaultCameraFrozen, FaultLensOff, FaultObjectScaled, FaultObjectContradicted, FaultObjectUnplaced, FaultImageSize, FaultCameraTurned, FaultCamerasExchanged, FaultLensChanged, FaultTagTurned, FaultTagsExchanged, FaultCameraBlind]


@dataclass(frozen=True)
class ImperfectionCamerasDisagree(VariantRecord, variant="cameras_disagree", form="fields"):
    """Calibrate the rig."""

    a: str
    b: str
    apart_m: F64


@dataclass(frozen=True)
class ImperfectionTagOff(VariantRecord, variant="tag_off", form="fields"):
    """The tag of the object that is off most: learn the object."""

    object: str
    tag: TagId
    position_m: F64
    orientation_rad: F64


@dataclass(frozen=True)
class ImperfectionSizeOff(VariantRecord, variant="size_off", form="fields"):
    """Estimated size over that in the file: measure the tag, or learn the object."""

    object: str
    tag: TagId
    ratio: F64


@dataclass(frozen=True)
class ImperfectionFocalLengthOff(VariantRecord, variant="focal_length_off", form="fields"):
    """Estimated over that in the file: calibrate the lens."""

    camera: str
    ratio: F64


@dataclass(frozen=True)
class ImperfectionScaleOff(VariantRecord, variant="scale_off", form="fields"):
    """All sizes and places over those in the file: measure a tag."""

    object: str
    ratio: F64


#: Numbers in the files that the images contradict; poses allow for it.
Imperfection = Union[ImperfectionCamerasDisagree, ImperfectionTagOff, ImperfectionSizeOff, ImperfectionFocalLengthOff, ImperfectionScaleOff]


@dataclass(frozen=True)
class NoticeCameraSilent(VariantRecord, variant="camera_silent", form="fields"):
    """While other cameras send."""

    camera: str
    silent_s: F64


@dataclass(frozen=True)
class NoticeLateObservations(VariantRecord, variant="late_observations", form="fields"):
    """Dropped because they arrived too late, since the node started."""

    camera: str
    total: U64


@dataclass(frozen=True)
class NoticeOverload(VariantRecord, variant="overload", form="fields"):
    """Observations and poses dropped as the node's machine is too slow, since the last status and since the node started."""

    dropped: U64
    total: U64


@dataclass(frozen=True)
class NoticeUnpublished(VariantRecord, variant="unpublished", form="fields"):
    """Messages with a value out of range, since the node started; cause of the last."""

    total: U64
    detail: str


@dataclass(frozen=True)
class NoticeClockStepped(VariantRecord, variant="clock_stepped", form="fields"):
    """The clock of the node's machine was set."""

    by_s: F64


@dataclass(frozen=True)
class NoticeChangeRefused(VariantRecord, variant="change_refused", form="fields"):
    """NoticeChangeRefused."""

    key: str
    sender: Optional[str]
    refusal: Refusal


@dataclass(frozen=True)
class NoticeNameTaken(VariantRecord, variant="name_taken", form="fields"):
    """Another fusion node of this name runs there."""

    host: str


@dataclass(frozen=True)
class NoticeRefinementProposed(VariantRecord, variant="refinement_proposed", form="fields"):
    """As in the Proposal."""

    n_images: U32
    before_px: F64
    after_px: F64


@dataclass(frozen=True)
class NoticeOldModels(VariantRecord, variant="old_models", form="fields"):
    """A node whose models are older than another one's: it publishes all objects as lost meanwhile, where it should publish."""

    node: str
    newer: str


@dataclass(frozen=True)
class NoticeNotKept(VariantRecord, variant="not_kept", form="fields"):
    """The models in force are not in the node's files."""

    detail: str


@dataclass(frozen=True)
class NoticeSetAside(VariantRecord, variant="set_aside", form="fields"):
    """Changes made at a node of a divided network are not in force, those of another node are: `sextant config revert --to` brings them back."""

    node: str
    by: str
    t_ns: U64
    detail: str


@dataclass(frozen=True)
class NoticeCamerasSlow(VariantRecord, variant="cameras_slow", form="fields"):
    """Dropped as too old: they left the camera's machine so long after the capture."""

    #: at most 16
    cameras: Annotated[tuple[str, ...], AtMost(16)]
    behind_s: F64


#: What happened to the node itself.
Notice = Union[NoticeCameraSilent, NoticeLateObservations, NoticeOverload, NoticeUnpublished, NoticeClockStepped, NoticeChangeRefused, NoticeNameTaken, NoticeRefinementProposed, NoticeOldModels, NoticeNotKept, NoticeSetAside, NoticeCamerasSlow]


@dataclass(frozen=True)
class CameraNoticeNoImage(VariantRecord, variant="no_image", form="fields"):
    """From the capturing part."""

    silent_s: F64


@dataclass(frozen=True)
class CameraNoticeNameTaken(VariantRecord, variant="name_taken", form="fields"):
    """Another camera node of this name runs there."""

    host: str


@dataclass(frozen=True)
class CameraNoticeImageRefused(VariantRecord, variant="image_refused", form="fields"):
    """Cause of the last image or message that could not be used."""

    detail: str


@dataclass(frozen=True)
class CameraNoticeNotInRig(VariantRecord, variant="not_in_rig", form="unit"):
    """The rig has no camera of this name: tags have no poses."""


@dataclass(frozen=True)
class CameraNoticeModelRefused(VariantRecord, variant="model_refused", form="fields"):
    """A rig or object of the site cannot be used."""

    key: str
    detail: str


@dataclass(frozen=True)
class CameraNoticeTooManyTags(VariantRecord, variant="too_many_tags", form="fields"):
    """No room for this object's tag sizes: its tags have no poses."""

    key: str


#: What is wrong with a camera node.
CameraNotice = Union[CameraNoticeNoImage, CameraNoticeNameTaken, CameraNoticeImageRefused, CameraNoticeNotInRig, CameraNoticeModelRefused, CameraNoticeTooManyTags]


@dataclass(frozen=True)
class RefusalUndecodable(VariantRecord, variant="undecodable", form="fields"):
    """Damaged, of another kind or version, or a value out of range."""

    detail: str


@dataclass(frozen=True)
class RefusalWrongId(VariantRecord, variant="wrong_id", form="fields"):
    """The payload describes another object than its key."""

    described: str


@dataclass(frozen=True)
class RefusalNoCamera(VariantRecord, variant="no_camera", form="unit"):
    """A rig without cameras."""


@dataclass(frozen=True)
class RefusalInvalidCamera(VariantRecord, variant="invalid_camera", form="fields"):
    """What no rig file may say."""

    camera: str
    detail: str


@dataclass(frozen=True)
class RefusalInvalidObject(VariantRecord, variant="invalid_object", form="fields"):
    """What no object file may say."""

    tag: Optional[TagId]
    detail: str


@dataclass(frozen=True)
class RefusalUnknownTag(VariantRecord, variant="unknown_tag", form="fields"):
    """Its family has the ids 0 to n_ids - 1."""

    tag: TagId
    n_ids: U32


@dataclass(frozen=True)
class RefusalSharedTag(VariantRecord, variant="shared_tag", form="fields"):
    """On two objects."""

    tag: TagId
    first: str
    second: str


@dataclass(frozen=True)
class RefusalTooManyObjects(VariantRecord, variant="too_many_objects", form="fields"):
    """RefusalTooManyObjects."""

    limit: U32


@dataclass(frozen=True)
class RefusalUnpublishable(VariantRecord, variant="unpublishable", form="fields"):
    """The models after the change do not fit into messages."""

    detail: str


@dataclass(frozen=True)
class RefusalNotStored(VariantRecord, variant="not_stored", form="fields"):
    """The node cannot write its files."""

    detail: str


@dataclass(frozen=True)
class RefusalOther(VariantRecord, variant="other", form="fields"):
    """RefusalOther."""

    detail: str


#: Why a change is refused; `detail` is English text.
Refusal = Union[RefusalUndecodable, RefusalWrongId, RefusalNoCamera, RefusalInvalidCamera, RefusalInvalidObject, RefusalUnknownTag, RefusalSharedTag, RefusalTooManyObjects, RefusalUnpublishable, RefusalNotStored, RefusalOther]


#: Every kind of message, by its number in the header.
KINDS: dict[int, Kind] = {
    1: Kind(1, 81920, Observations),
    2: Kind(2, 102400, Preview),
    3: Kind(3, 4096, DetectionReport),
    4: Kind(4, 8192, CameraStatus),
    5: Kind(5, 1024, ObjectPose),
    6: Kind(6, 16384, ObjectLinks),
    7: Kind(7, 1024, ObjectTruth),
    8: Kind(8, 131072, FusionStatus),
    9: Kind(9, 32768, ClockReport),
    10: Kind(10, 16384, ConfigAnswer),
    11: Kind(11, 131072, Proposal),
    12: Kind(12, 131072, RigConfig),
    13: Kind(13, 131072, ObjectConfig),
    14: Kind(14, 16384, FusionInputs),
    15: Kind(15, 1024, CameraSettings),
    16: Kind(16, 98304, Heartbeat),
}

__all__ = [
    "Observations",
    "ObservationsTiming",
    "Clock",
    "ClockSource",
    "Tag",
    "TagPose",
    "Family",
    "Preview",
    "DetectionReport",
    "DetectionReportStageMs",
    "DetectionReportRejected",
    "DetectionReportExample",
    "RejectionCause",
    "CameraStatus",
    "CameraStatusControls",
    "Control",
    "SettingsOutcome",
    "SettingsOutcomeNone",
    "SettingsOutcomePending",
    "SettingsOutcomeApplied",
    "SettingsOutcomeAdjusted",
    "SettingsOutcomeRefused",
    "ObjectPose",
    "State",
    "ObjectLinks",
    "ObjectLinksLink",
    "ObjectLinksJoint",
    "ObjectTruth",
    "FusionStatus",
    "FusionStatusObject",
    "CameraIntake",
    "Rejections",
    "ClockReport",
    "ClockReportCamera",
    "FusionInputs",
    "FusionInputsInput",
    "InputSource",
    "InputSourceImage",
    "InputSourceRig",
    "InputSourceObjects",
    "InputSourceClockStep",
    "InputSourceTick",
    "InputSourceAdjusted",
    "Heartbeat",
    "HeartbeatHeard",
    "HeartbeatSharing",
    "HeartbeatSharingObject",
    "HeartbeatSharingObjectPart",
    "HeartbeatSharingObjectPartPreparing",
    "HeartbeatSharingObjectPartReady",
    "HeartbeatSharingObjectPartPublishing",
    "HeartbeatModels",
    "HeartbeatModelsVersion",
    "ConfigAnswer",
    "ConfigAnswerOutcome",
    "ConfigAnswerOutcomeTaken",
    "ConfigAnswerOutcomeKept",
    "ConfigAnswerOutcomeSame",
    "ConfigAnswerOutcomeRefused",
    "Proposal",
    "RigConfig",
    "Camera",
    "CameraLensSigma",
    "CameraMount",
    "CameraExposure",
    "CameraExposureStamp",
    "Lens",
    "LensPinhole",
    "LensBrownConrady",
    "LensKannalaBrandt",
    "Pose",
    "Sigma",
    "ObjectConfig",
    "Joint",
    "JointKind",
    "ObjectTag",
    "CameraSettings",
    "TagId",
    "Fault",
    "FaultCameraMoved",
    "FaultCamerasDisagree",
    "FaultTagMisplaced",
    "FaultTagSize",
    "FaultTagElsewhere",
    "FaultClockOff",
    "FaultUntimely",
    "FaultDuplicateTag",
    "FaultHostClockOff",
    "FaultCameraFrozen",
    "FaultLensOff",
    "FaultObjectScaled",
    "FaultObjectContradicted",
    "FaultObjectUnplaced",
    "FaultImageSize",
    "FaultCameraTurned",
    "FaultCamerasExchanged",
    "FaultLensChanged",
    "FaultTagTurned",
    "FaultTagsExchanged",
    "FaultCameraBlind",
    "Imperfection",
    "ImperfectionCamerasDisagree",
    "ImperfectionTagOff",
    "ImperfectionSizeOff",
    "ImperfectionFocalLengthOff",
    "ImperfectionScaleOff",
    "Notice",
    "NoticeCameraSilent",
    "NoticeLateObservations",
    "NoticeOverload",
    "NoticeUnpublished",
    "NoticeClockStepped",
    "NoticeChangeRefused",
    "NoticeNameTaken",
    "NoticeRefinementProposed",
    "NoticeOldModels",
    "NoticeNotKept",
    "NoticeSetAside",
    "NoticeCamerasSlow",
    "CameraNotice",
    "CameraNoticeNoImage",
    "CameraNoticeNameTaken",
    "CameraNoticeImageRefused",
    "CameraNoticeNotInRig",
    "CameraNoticeModelRefused",
    "CameraNoticeTooManyTags",
    "Refusal",
    "RefusalUndecodable",
    "RefusalWrongId",
    "RefusalNoCamera",
    "RefusalInvalidCamera",
    "RefusalInvalidObject",
    "RefusalUnknownTag",
    "RefusalSharedTag",
    "RefusalTooManyObjects",
    "RefusalUnpublishable",
    "RefusalNotStored",
    "RefusalOther",
]
