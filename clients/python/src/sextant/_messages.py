"""The messages of the wire contract. Written by `cargo xtask python` from proto/CONTRACT.md: do not edit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Optional, Union

from ._postcard import Alternative, Kind, Reader, Record, VariantRecord, Word, Writer


@dataclass(frozen=True)
class ObservationsTiming(Record):
    """`timing` of Observations."""

    received_ns: int
    detected_ns: int
    published_ns: int


@dataclass(frozen=True)
class Observations(Record):
    """Observations."""

    camera: str
    #: of the image since the camera started; gaps are images that were skipped
    sequence: int
    capture_ns: int
    #: 0: unknown
    exposure_ns: int
    clock: Clock
    #: shape (2); width, height; never 0
    resolution: tuple[int, ...]
    timing: ObservationsTiming
    #: at most 256
    tags: tuple[Tag, ...]


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
    error_ns: int


@dataclass(frozen=True)
class Tag(Record):
    """Tag."""

    family: Family
    id: int
    #: corrected bits
    hamming: int
    #: decision margin, grey levels
    margin: float
    #: shape (4, 2); x, y of top left, top right, bottom right, bottom left of the upright tag
    corners: tuple[tuple[float, ...], ...]
    #: shape (4, 3); xx, xy, yy of each corner, px²
    corner_covariance: tuple[tuple[float, ...], ...]
    #: shape (6, 4); between corners 0 1, 0 2, 0 3, 1 2, 1 3, 2 3: xx, xy, yx, yy, px²; 0 where the errors are independent or this is unknown
    corner_cross_covariance: tuple[tuple[float, ...], ...]
    #: at most 2, the better first; empty where lens or size are unknown
    poses: tuple[TagPose, ...]


@dataclass(frozen=True)
class TagPose(Record):
    """TagPose."""

    #: shape (3)
    position: tuple[float, ...]
    #: shape (4); camera_from_tag
    orientation: tuple[float, ...]
    #: reprojection error
    rms_px: float


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


@dataclass(frozen=True)
class Preview(Record):
    """Preview."""

    camera: str
    #: as in its Observations
    sequence: int
    capture_ns: int
    #: shape (2); of the captured image, to which corners refer; the JPEG may be smaller
    resolution: tuple[int, ...]
    #: at most 100 000
    jpeg: bytes


@dataclass(frozen=True)
class DetectionReportStageMs(Record):
    """`stage_ms` of DetectionReport."""

    tiles: float
    threshold: float
    components: float
    quads: float
    decode: float
    refine: float


@dataclass(frozen=True)
class DetectionReportRejected(Record):
    """`rejected` of DetectionReport."""

    not_a_quad: int
    shape: int
    faint_border: int
    no_code: int
    small_margin: int


@dataclass(frozen=True)
class DetectionReportExample(Record):
    """`examples` of DetectionReport."""

    cause: RejectionCause
    #: shape (4, 2)
    corners: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class DetectionReport(Record):
    """DetectionReport."""

    camera: str
    sequence: int
    capture_ns: int
    #: shape (2)
    resolution: tuple[int, ...]
    #: share of the image, 0 to 1
    searched: float
    stage_ms: DetectionReportStageMs
    #: grey levels
    noise_sigma: float
    #: grey levels
    contrast_gate: int
    components: int
    candidates: int
    #: candidates beyond the detector's memory
    dropped: int
    tags: int
    rejected: DetectionReportRejected
    #: at most 64
    examples: tuple[DetectionReportExample, ...]


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
    captured: int
    detected: int
    #: images since the start
    dropped: int
    rate_hz: float
    #: shape (2); median, 99th percentile
    detect_ms: tuple[float, ...]
    clock: Clock
    uptime_s: int
    published: int
    #: images that the CPU made in place of an accelerator, since the camera was opened
    fallbacks: int
    #: mean grey level of the last image, 0 to 255
    brightness: float
    controls: CameraStatusControls
    #: at most 32
    notices: tuple[CameraNotice, ...]


@dataclass(frozen=True)
class Control(Record):
    """Control."""

    #: by the site; none: up to the camera's own file
    wanted: Optional[float]
    #: in force; none: unknown, or chosen by the camera for every image
    value: Optional[float]
    #: shape (2); none: unknown, or not adjustable
    range: Optional[tuple[float, ...]]


@dataclass(frozen=True)
class SettingsOutcomeNone(VariantRecord):
    """The site wants nothing."""

    VARIANT: ClassVar[str] = "none"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class SettingsOutcomePending(VariantRecord):
    """Not applied yet."""

    VARIANT: ClassVar[str] = "pending"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class SettingsOutcomeApplied(VariantRecord):
    """SettingsOutcomeApplied."""

    VARIANT: ClassVar[str] = "applied"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class SettingsOutcomeAdjusted(VariantRecord):
    """In force as far as the camera allows."""

    VARIANT: ClassVar[str] = "adjusted"
    FORM: ClassVar[str] = "fields"
    detail: str


@dataclass(frozen=True)
class SettingsOutcomeRefused(VariantRecord):
    """The camera keeps what it had."""

    VARIANT: ClassVar[str] = "refused"
    FORM: ClassVar[str] = "fields"
    detail: str


#: SettingsOutcome.
SettingsOutcome = Union[SettingsOutcomeNone, SettingsOutcomePending, SettingsOutcomeApplied, SettingsOutcomeAdjusted, SettingsOutcomeRefused]


@dataclass(frozen=True)
class ObjectPose(Record):
    """ObjectPose."""

    object: str
    #: of the fusion node, as below
    epoch: int
    #: of this object's poses; gaps within an epoch are lost messages
    sequence: int
    capture_ns: int
    published_ns: int
    state: State
    #: shape (3)
    position: tuple[float, ...]
    #: shape (4); world_from_object
    orientation: tuple[float, ...]
    #: shape (36)
    covariance: tuple[float, ...]
    #: shape (6); velocity of the origin, angular velocity; world axes, m/s, rad/s
    twist: tuple[float, ...]
    cameras: int
    #: that entered the estimate
    tags: int
    rms_px: float


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
    #: shape (3)
    position: tuple[float, ...]
    #: shape (4); world_from_link
    orientation: tuple[float, ...]
    #: shape (36)
    covariance: tuple[float, ...]


@dataclass(frozen=True)
class ObjectLinksJoint(Record):
    """`joints` of ObjectLinks."""

    joint: str
    #: rad or m
    value: float
    variance: float
    velocity: float
    velocity_variance: float


@dataclass(frozen=True)
class ObjectLinks(Record):
    """ObjectLinks."""

    object: str
    epoch: int
    sequence: int
    capture_ns: int
    published_ns: int
    #: all as in the ObjectPose
    state: State
    #: at most 32
    links: tuple[ObjectLinksLink, ...]
    #: at most 8; fixed joints are left out
    joints: tuple[ObjectLinksJoint, ...]


@dataclass(frozen=True)
class ObjectTruth(Record):
    """ObjectTruth."""

    object: str
    capture_ns: int
    #: shape (3)
    position: tuple[float, ...]
    #: shape (4)
    orientation: tuple[float, ...]
    position_error_m: float
    attitude_error_rad: float


@dataclass(frozen=True)
class FusionStatusObject(Record):
    """`objects` of FusionStatus."""

    object: str
    state: State
    rate_hz: float


@dataclass(frozen=True)
class FusionStatus(Record):
    """FusionStatus."""

    node: str
    version: str
    uptime_s: int
    #: the newest of its poses; none while it publishes none
    epoch: Optional[int]
    #: at most 256
    cameras: tuple[CameraIntake, ...]
    #: under keys of cameras that the rig lacks
    foreign: Rejections
    #: at most 1024
    objects: tuple[FusionStatusObject, ...]
    #: at most 64
    faults: tuple[Fault, ...]
    #: further ones
    faults_left_out: int
    #: at most 16
    imperfections: tuple[Imperfection, ...]
    #: at most 32
    notices: tuple[Notice, ...]


@dataclass(frozen=True)
class CameraIntake(Record):
    """CameraIntake."""

    camera: str
    received: int
    rejected: Rejections
    unknown_tags: int
    #: images
    late: int
    #: tags rejected as outliers
    gated: int
    last_capture_ns: int
    rate_hz: float


@dataclass(frozen=True)
class Rejections(Record):
    """Rejections."""

    #: payloads
    bad_magic: int
    #: payloads
    foreign_version: int
    #: payloads
    wrong_kind: int
    #: payloads
    damaged: int
    #: payloads
    too_long: int
    #: payloads
    out_of_range: int
    #: payloads
    wrong_camera: int


@dataclass(frozen=True)
class ClockReportCamera(Record):
    """`cameras` of ClockReport."""

    camera: str
    #: the camera's clock minus the reference clock; poses allow for it
    offset_s: float
    sigma_s: float
    #: s/s
    drift: Optional[float]


@dataclass(frozen=True)
class ClockReport(Record):
    """ClockReport."""

    node: str
    #: at most 256; cameras whose clock is not estimated are left out
    cameras: tuple[ClockReportCamera, ...]


@dataclass(frozen=True)
class FusionInputsInput(Record):
    """`inputs` of FusionInputs."""

    #: time given to the estimator
    now_ns: int
    source: InputSource


@dataclass(frozen=True)
class FusionInputs(Record):
    """FusionInputs."""

    node: str
    #: number of the first of these inputs since the node started, from 0; a gap is a lost message
    first: int
    #: at most 256
    inputs: tuple[FusionInputsInput, ...]


@dataclass(frozen=True)
class InputSourceImage(VariantRecord):
    """InputSourceImage."""

    VARIANT: ClassVar[str] = "image"
    FORM: ClassVar[str] = "fields"
    camera: str
    sequence: int
    #: as in its Observations
    capture_ns: int


@dataclass(frozen=True)
class InputSourceRig(VariantRecord):
    """Fingerprint of its RigConfig."""

    VARIANT: ClassVar[str] = "rig"
    FORM: ClassVar[str] = "value"
    value: int


@dataclass(frozen=True)
class InputSourceObjects(VariantRecord):
    """Fingerprints of their ObjectConfigs, at most 1024."""

    VARIANT: ClassVar[str] = "objects"
    FORM: ClassVar[str] = "value"
    value: tuple[int, ...]


@dataclass(frozen=True)
class InputSourceClockStep(VariantRecord):
    """InputSourceClockStep."""

    VARIANT: ClassVar[str] = "clock-step"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class InputSourceTick(VariantRecord):
    """InputSourceTick."""

    VARIANT: ClassVar[str] = "tick"
    FORM: ClassVar[str] = "unit"


#: The first two inputs of a run are the rig and the objects before its first image.
InputSource = Union[InputSourceImage, InputSourceRig, InputSourceObjects, InputSourceClockStep, InputSourceTick]


@dataclass(frozen=True)
class HeartbeatHeard(Record):
    """`heard` of Heartbeat."""

    node: str
    sent_ns: int


@dataclass(frozen=True)
class HeartbeatSharingObjectPartPreparing(VariantRecord):
    """Not seen for long enough."""

    VARIANT: ClassVar[str] = "preparing"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class HeartbeatSharingObjectPartReady(VariantRecord):
    """To publish."""

    VARIANT: ClassVar[str] = "ready"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class HeartbeatSharingObjectPartPublishing(VariantRecord):
    """The epoch of its poses."""

    VARIANT: ClassVar[str] = "publishing"
    FORM: ClassVar[str] = "value"
    value: int


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
    standbys: Optional[int]
    #: those that the node tracks; at most 1024
    objects: tuple[HeartbeatSharingObject, ...]


@dataclass(frozen=True)
class Heartbeat(Record):
    """Heartbeat."""

    node: str
    #: by a clock of the node that is never set
    sent_ns: int
    #: of the poses that the node publishes; none while it stands by
    epoch: Optional[int]
    #: the newest epoch that the node knows of
    newest: int
    #: the last heartbeat received of each other node; at most 16
    heard: tuple[HeartbeatHeard, ...]
    #: none: one node publishes all poses
    sharing: Optional[HeartbeatSharing]


@dataclass(frozen=True)
class ConfigAnswerOutcomeTaken(VariantRecord):
    """ConfigAnswerOutcomeTaken."""

    VARIANT: ClassVar[str] = "taken"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class ConfigAnswerOutcomeKept(VariantRecord):
    """ConfigAnswerOutcomeKept."""

    VARIANT: ClassVar[str] = "kept"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class ConfigAnswerOutcomeSame(VariantRecord):
    """ConfigAnswerOutcomeSame."""

    VARIANT: ClassVar[str] = "same"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class ConfigAnswerOutcomeRefused(VariantRecord):
    """ConfigAnswerOutcomeRefused."""

    VARIANT: ClassVar[str] = "refused"
    FORM: ClassVar[str] = "value"
    value: Refusal


#: `outcome` of ConfigAnswer.
ConfigAnswerOutcome = Union[ConfigAnswerOutcomeTaken, ConfigAnswerOutcomeKept, ConfigAnswerOutcomeSame, ConfigAnswerOutcomeRefused]


@dataclass(frozen=True)
class ConfigAnswer(Record):
    """ConfigAnswer."""

    node: str
    key: str
    fingerprint: int
    outcome: ConfigAnswerOutcome


@dataclass(frozen=True)
class Proposal(Record):
    """Proposal."""

    node: str
    t_ns: int
    #: payload of a RigConfig, header included
    rig: Optional[bytes]
    #: payload of an ObjectConfig each; at most 1024
    objects: tuple[bytes, ...]
    n_images: int
    before_px: float
    after_px: float


@dataclass(frozen=True)
class RigConfig(Record):
    """RigConfig."""

    #: at most 256
    cameras: tuple[Camera, ...]
    #: of the scale that all positions share, as a share of it
    scale_sigma: Optional[float]


@dataclass(frozen=True)
class CameraLensSigma(Record):
    """`lens_sigma` of Camera."""

    focal_px: float
    #: at the image's corners
    distortion_px: float


class CameraExposureStamp(Word):
    """`stamp` of CameraExposure."""

    START = "start"
    MIDDLE = "middle"
    END = "end"


@dataclass(frozen=True)
class CameraExposure(Record):
    """`exposure` of Camera."""

    length_s: float
    #: moment of the exposure that the camera's time stamps mark
    stamp: CameraExposureStamp


@dataclass(frozen=True)
class Camera(Record):
    """Camera."""

    id: str
    #: shape (2)
    resolution: tuple[int, ...]
    lens: Lens
    lens_sigma: Optional[CameraLensSigma]
    #: none until calibrated
    world_from_camera: Optional[Pose]
    world_from_camera_sigma: Optional[Sigma]
    #: from a row to the next; negative where the bottom row is read first; none: global shutter
    line_delay_s: Optional[float]
    exposure: Optional[CameraExposure]


@dataclass(frozen=True)
class LensPinhole(VariantRecord):
    """LensPinhole."""

    VARIANT: ClassVar[str] = "pinhole"
    FORM: ClassVar[str] = "fields"
    fx: float
    fy: float
    cx: float
    cy: float


@dataclass(frozen=True)
class LensBrownConrady(VariantRecord):
    """LensBrownConrady."""

    VARIANT: ClassVar[str] = "brown-conrady"
    FORM: ClassVar[str] = "fields"
    fx: float
    fy: float
    cx: float
    cy: float
    #: shape (5); k1, k2, p1, p2, k3
    distortion: tuple[float, ...]


@dataclass(frozen=True)
class LensKannalaBrandt(VariantRecord):
    """LensKannalaBrandt."""

    VARIANT: ClassVar[str] = "kannala-brandt"
    FORM: ClassVar[str] = "fields"
    fx: float
    fy: float
    cx: float
    cy: float
    #: shape (4); k1, k2, k3, k4
    distortion: tuple[float, ...]


#: Lens.
Lens = Union[LensPinhole, LensBrownConrady, LensKannalaBrandt]


@dataclass(frozen=True)
class Pose(Record):
    """Pose."""

    #: shape (3)
    position: tuple[float, ...]
    #: shape (4)
    orientation: tuple[float, ...]


@dataclass(frozen=True)
class Sigma(Record):
    """Sigma."""

    position_m: float
    #: the same along each axis
    orientation_rad: float


@dataclass(frozen=True)
class ObjectConfig(Record):
    """ObjectConfig."""

    id: str
    #: at most 32; empty for a rigid object
    links: tuple[str, ...]
    #: at most 32
    joints: tuple[Joint, ...]
    #: at most 1024; empty: the object is removed
    tags: tuple[ObjectTag, ...]
    #: of the object's frame in its tags
    frame_sigma: Optional[Sigma]
    #: of the scale that its tags share, as a share of it
    scale_sigma: Optional[float]


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
    #: shape (3); unit vector in the joint's frame
    axis: tuple[float, ...]
    parent_from_joint: Pose
    #: shape (2)
    limits: Optional[tuple[float, ...]]
    #: rad/s or m/s
    max_speed: Optional[float]


@dataclass(frozen=True)
class ObjectTag(Record):
    """ObjectTag."""

    family: Family
    id: int
    size_m: float
    size_sigma_m: Optional[float]
    #: index into links; none on a rigid object
    link: Optional[int]
    #: link_from_tag on a link; none until learned
    object_from_tag: Optional[Pose]
    object_from_tag_sigma: Optional[Sigma]


@dataclass(frozen=True)
class CameraSettings(Record):
    """CameraSettings."""

    camera: str
    #: 1 to 1 000 000
    exposure_us: Optional[float]
    #: in the driver's units, 0 to 1 000 000
    gain: Optional[float]
    #: 0.1 to 1000
    rate_hz: Optional[float]


@dataclass(frozen=True)
class TagId(Record):
    """TagId."""

    family: Family
    id: int


@dataclass(frozen=True)
class FaultCameraMoved(VariantRecord):
    """Not where the rig says: calibrate it again."""

    VARIANT: ClassVar[str] = "camera_moved"
    FORM: ClassVar[str] = "fields"
    camera: str


@dataclass(frozen=True)
class FaultCamerasDisagree(VariantRecord):
    """One of the two has moved, no third camera tells which: calibrate both again."""

    VARIANT: ClassVar[str] = "cameras_disagree"
    FORM: ClassVar[str] = "fields"
    a: str
    b: str


@dataclass(frozen=True)
class FaultTagMisplaced(VariantRecord):
    """Not where the object says: put it back, or learn the object again."""

    VARIANT: ClassVar[str] = "tag_misplaced"
    FORM: ClassVar[str] = "fields"
    object: str
    tag: TagId


@dataclass(frozen=True)
class FaultTagSize(VariantRecord):
    """True size over the object's: measure the tag and correct its size."""

    VARIANT: ClassVar[str] = "tag_size"
    FORM: ClassVar[str] = "fields"
    object: str
    tag: TagId
    ratio: float


@dataclass(frozen=True)
class FaultTagElsewhere(VariantRecord):
    """Seen where it cannot be: take it off there, or print another id."""

    VARIANT: ClassVar[str] = "tag_elsewhere"
    FORM: ClassVar[str] = "fields"
    object: str
    tag: TagId
    #: object
    on: Optional[str]


@dataclass(frozen=True)
class FaultClockOff(VariantRecord):
    """The camera's clock minus the reference clock; poses allow for it: set the clock."""

    VARIANT: ClassVar[str] = "clock_off"
    FORM: ClassVar[str] = "fields"
    camera: str
    offset_s: float


@dataclass(frozen=True)
class FaultUntimely(VariantRecord):
    """Images arrive so long after their stamps (negative: before) and are left out: set the clock, or check the network."""

    VARIANT: ClassVar[str] = "untimely"
    FORM: ClassVar[str] = "fields"
    camera: str
    age_s: float


@dataclass(frozen=True)
class FaultDuplicateTag(VariantRecord):
    """Twice in one image: print another id for one of them."""

    VARIANT: ClassVar[str] = "duplicate_tag"
    FORM: ClassVar[str] = "fields"
    camera: str
    tag: TagId


@dataclass(frozen=True)
class FaultHostClockOff(VariantRecord):
    """The fusion host's clock minus most cameras'; poses have the cameras' time: set the clock."""

    VARIANT: ClassVar[str] = "host_clock_off"
    FORM: ClassVar[str] = "fields"
    offset_s: float


@dataclass(frozen=True)
class FaultCameraFrozen(VariantRecord):
    """Its picture has not changed for so long: restart its capture."""

    VARIANT: ClassVar[str] = "camera_frozen"
    FORM: ClassVar[str] = "fields"
    camera: str
    still_s: float


@dataclass(frozen=True)
class FaultLensOff(VariantRecord):
    """Bends otherwise than the rig says: calibrate the lens."""

    VARIANT: ClassVar[str] = "lens_off"
    FORM: ClassVar[str] = "fields"
    camera: str


@dataclass(frozen=True)
class FaultObjectScaled(VariantRecord):
    """True size of all its tags over the object's: measure them and correct the sizes."""

    VARIANT: ClassVar[str] = "object_scaled"
    FORM: ClassVar[str] = "fields"
    object: str
    ratio: float


@dataclass(frozen=True)
class FaultObjectContradicted(VariantRecord):
    """So large a share of its views contradicts any pose: check object and cameras."""

    VARIANT: ClassVar[str] = "object_contradicted"
    FORM: ClassVar[str] = "fields"
    object: str
    share: float


@dataclass(frozen=True)
class FaultObjectUnplaced(VariantRecord):
    """No tag has a place on it: learn the object."""

    VARIANT: ClassVar[str] = "object_unplaced"
    FORM: ClassVar[str] = "fields"
    object: str


#: Fault.
Fault = Union[FaultCameraMoved, FaultCamerasDisagree, FaultTagMisplaced, FaultTagSize, FaultTagElsewhere, FaultClockOff, FaultUntimely, FaultDuplicateTag, FaultHostClockOff, FaultCameraFrozen, FaultLensOff, FaultObjectScaled, FaultObjectContradicted, FaultObjectUnplaced]


@dataclass(frozen=True)
class ImperfectionCamerasDisagree(VariantRecord):
    """Calibrate the rig."""

    VARIANT: ClassVar[str] = "cameras_disagree"
    FORM: ClassVar[str] = "fields"
    a: str
    b: str
    apart_m: float


@dataclass(frozen=True)
class ImperfectionTagOff(VariantRecord):
    """The tag of the object that is off most: learn the object."""

    VARIANT: ClassVar[str] = "tag_off"
    FORM: ClassVar[str] = "fields"
    object: str
    tag: TagId
    position_m: float
    orientation_rad: float


@dataclass(frozen=True)
class ImperfectionSizeOff(VariantRecord):
    """Estimated size over that in the file: measure the tag, or learn the object."""

    VARIANT: ClassVar[str] = "size_off"
    FORM: ClassVar[str] = "fields"
    object: str
    tag: TagId
    ratio: float


@dataclass(frozen=True)
class ImperfectionFocalLengthOff(VariantRecord):
    """Estimated over that in the file: calibrate the lens."""

    VARIANT: ClassVar[str] = "focal_length_off"
    FORM: ClassVar[str] = "fields"
    camera: str
    ratio: float


#: Numbers in the files that the images contradict; poses allow for it.
Imperfection = Union[ImperfectionCamerasDisagree, ImperfectionTagOff, ImperfectionSizeOff, ImperfectionFocalLengthOff]


@dataclass(frozen=True)
class NoticeCameraSilent(VariantRecord):
    """While other cameras send."""

    VARIANT: ClassVar[str] = "camera_silent"
    FORM: ClassVar[str] = "fields"
    camera: str
    silent_s: float


@dataclass(frozen=True)
class NoticeLateObservations(VariantRecord):
    """Dropped because they arrived too late, since the node started."""

    VARIANT: ClassVar[str] = "late_observations"
    FORM: ClassVar[str] = "fields"
    camera: str
    total: int


@dataclass(frozen=True)
class NoticeOverload(VariantRecord):
    """Observations dropped unread, since the last status and since the node started."""

    VARIANT: ClassVar[str] = "overload"
    FORM: ClassVar[str] = "fields"
    dropped: int
    total: int


@dataclass(frozen=True)
class NoticeUnpublished(VariantRecord):
    """Messages with a value out of range, since the node started; cause of the last."""

    VARIANT: ClassVar[str] = "unpublished"
    FORM: ClassVar[str] = "fields"
    total: int
    detail: str


@dataclass(frozen=True)
class NoticeClockStepped(VariantRecord):
    """The clock of the node's machine was set."""

    VARIANT: ClassVar[str] = "clock_stepped"
    FORM: ClassVar[str] = "fields"
    by_s: float


@dataclass(frozen=True)
class NoticeChangeRefused(VariantRecord):
    """NoticeChangeRefused."""

    VARIANT: ClassVar[str] = "change_refused"
    FORM: ClassVar[str] = "fields"
    key: str
    sender: Optional[str]
    refusal: Refusal


@dataclass(frozen=True)
class NoticeNameTaken(VariantRecord):
    """Another fusion node of this name runs there."""

    VARIANT: ClassVar[str] = "name_taken"
    FORM: ClassVar[str] = "fields"
    host: str


@dataclass(frozen=True)
class NoticeRefinementProposed(VariantRecord):
    """As in the Proposal."""

    VARIANT: ClassVar[str] = "refinement_proposed"
    FORM: ClassVar[str] = "fields"
    n_images: int
    before_px: float
    after_px: float


#: What happened to the node itself.
Notice = Union[NoticeCameraSilent, NoticeLateObservations, NoticeOverload, NoticeUnpublished, NoticeClockStepped, NoticeChangeRefused, NoticeNameTaken, NoticeRefinementProposed]


@dataclass(frozen=True)
class CameraNoticeNoImage(VariantRecord):
    """From the capturing part."""

    VARIANT: ClassVar[str] = "no_image"
    FORM: ClassVar[str] = "fields"
    silent_s: float


@dataclass(frozen=True)
class CameraNoticeNameTaken(VariantRecord):
    """Another camera node of this name runs there."""

    VARIANT: ClassVar[str] = "name_taken"
    FORM: ClassVar[str] = "fields"
    host: str


@dataclass(frozen=True)
class CameraNoticeImageRefused(VariantRecord):
    """Cause of the last image or message that could not be used."""

    VARIANT: ClassVar[str] = "image_refused"
    FORM: ClassVar[str] = "fields"
    detail: str


@dataclass(frozen=True)
class CameraNoticeNotInRig(VariantRecord):
    """The rig has no camera of this name: tags have no poses."""

    VARIANT: ClassVar[str] = "not_in_rig"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class CameraNoticeModelRefused(VariantRecord):
    """A rig or object of the site cannot be used."""

    VARIANT: ClassVar[str] = "model_refused"
    FORM: ClassVar[str] = "fields"
    key: str
    detail: str


@dataclass(frozen=True)
class CameraNoticeTooManyTags(VariantRecord):
    """No room for this object's tag sizes: its tags have no poses."""

    VARIANT: ClassVar[str] = "too_many_tags"
    FORM: ClassVar[str] = "fields"
    key: str


#: What is wrong with a camera node.
CameraNotice = Union[CameraNoticeNoImage, CameraNoticeNameTaken, CameraNoticeImageRefused, CameraNoticeNotInRig, CameraNoticeModelRefused, CameraNoticeTooManyTags]


@dataclass(frozen=True)
class RefusalUndecodable(VariantRecord):
    """Damaged, of another kind or version, or a value out of range."""

    VARIANT: ClassVar[str] = "undecodable"
    FORM: ClassVar[str] = "fields"
    detail: str


@dataclass(frozen=True)
class RefusalWrongId(VariantRecord):
    """The payload describes another object than its key."""

    VARIANT: ClassVar[str] = "wrong_id"
    FORM: ClassVar[str] = "fields"
    described: str


@dataclass(frozen=True)
class RefusalNoCamera(VariantRecord):
    """A rig without cameras."""

    VARIANT: ClassVar[str] = "no_camera"
    FORM: ClassVar[str] = "unit"


@dataclass(frozen=True)
class RefusalInvalidCamera(VariantRecord):
    """What no rig file may say."""

    VARIANT: ClassVar[str] = "invalid_camera"
    FORM: ClassVar[str] = "fields"
    camera: str
    detail: str


@dataclass(frozen=True)
class RefusalInvalidObject(VariantRecord):
    """What no object file may say."""

    VARIANT: ClassVar[str] = "invalid_object"
    FORM: ClassVar[str] = "fields"
    tag: Optional[TagId]
    detail: str


@dataclass(frozen=True)
class RefusalUnknownTag(VariantRecord):
    """Its family has the ids 0 to n_ids - 1."""

    VARIANT: ClassVar[str] = "unknown_tag"
    FORM: ClassVar[str] = "fields"
    tag: TagId
    n_ids: int


@dataclass(frozen=True)
class RefusalSharedTag(VariantRecord):
    """On two objects."""

    VARIANT: ClassVar[str] = "shared_tag"
    FORM: ClassVar[str] = "fields"
    tag: TagId
    first: str
    second: str


@dataclass(frozen=True)
class RefusalTooManyObjects(VariantRecord):
    """RefusalTooManyObjects."""

    VARIANT: ClassVar[str] = "too_many_objects"
    FORM: ClassVar[str] = "fields"
    limit: int


@dataclass(frozen=True)
class RefusalUnpublishable(VariantRecord):
    """The models after the change do not fit into messages."""

    VARIANT: ClassVar[str] = "unpublishable"
    FORM: ClassVar[str] = "fields"
    detail: str


@dataclass(frozen=True)
class RefusalNotStored(VariantRecord):
    """The node cannot write its files."""

    VARIANT: ClassVar[str] = "not_stored"
    FORM: ClassVar[str] = "fields"
    detail: str


@dataclass(frozen=True)
class RefusalOther(VariantRecord):
    """RefusalOther."""

    VARIANT: ClassVar[str] = "other"
    FORM: ClassVar[str] = "fields"
    detail: str


#: Why a change is refused; `detail` is English text.
Refusal = Union[RefusalUndecodable, RefusalWrongId, RefusalNoCamera, RefusalInvalidCamera, RefusalInvalidObject, RefusalUnknownTag, RefusalSharedTag, RefusalTooManyObjects, RefusalUnpublishable, RefusalNotStored, RefusalOther]



def _read_ObservationsTiming(r: Reader) -> ObservationsTiming:
    return ObservationsTiming(
        r.u64(),
        r.u64(),
        r.u64(),
    )


def _write_ObservationsTiming(w: Writer, value: ObservationsTiming) -> None:
    w.u64(value.received_ns)
    w.u64(value.detected_ns)
    w.u64(value.published_ns)


def _read_Observations(r: Reader) -> Observations:
    return Observations(
        r.string(),
        r.u64(),
        r.u64(),
        r.u32(),
        _read_Clock(r),
        r.array(Reader.u16, 2),
        _read_ObservationsTiming(r),
        r.list(_read_Tag, 256),
    )


def _write_Observations(w: Writer, value: Observations) -> None:
    w.string(value.camera)
    w.u64(value.sequence)
    w.u64(value.capture_ns)
    w.u32(value.exposure_ns)
    _write_Clock(w, value.clock)
    w.array(Writer.u16, value.resolution, 2)
    _write_ObservationsTiming(w, value.timing)
    w.list(_write_Tag, value.tags)


def _read_ClockSource(r: Reader) -> ClockSource:
    return r.word(_ALL_ClockSource)


def _write_ClockSource(w: Writer, value: ClockSource) -> None:
    w.word(_ALL_ClockSource, value)


def _read_Clock(r: Reader) -> Clock:
    return Clock(
        _read_ClockSource(r),
        r.u64(),
    )


def _write_Clock(w: Writer, value: Clock) -> None:
    _write_ClockSource(w, value.source)
    w.u64(value.error_ns)


def _read_Tag(r: Reader) -> Tag:
    return Tag(
        _read_Family(r),
        r.u32(),
        r.u8(),
        r.f32(),
        r.array(lambda r: r.f32s(2), 4),
        r.array(lambda r: r.f32s(3), 4),
        r.array(lambda r: r.f32s(4), 6),
        r.list(_read_TagPose, 2),
    )


def _write_Tag(w: Writer, value: Tag) -> None:
    _write_Family(w, value.family)
    w.u32(value.id)
    w.u8(value.hamming)
    w.f32(value.margin)
    w.array(lambda w, v: w.f32s(v, 2), value.corners, 4)
    w.array(lambda w, v: w.f32s(v, 3), value.corner_covariance, 4)
    w.array(lambda w, v: w.f32s(v, 4), value.corner_cross_covariance, 6)
    w.list(_write_TagPose, value.poses)


def _read_TagPose(r: Reader) -> TagPose:
    return TagPose(
        r.f32s(3),
        r.f32s(4),
        r.f32(),
    )


def _write_TagPose(w: Writer, value: TagPose) -> None:
    w.f32s(value.position, 3)
    w.f32s(value.orientation, 4)
    w.f32(value.rms_px)


def _read_Family(r: Reader) -> Family:
    return r.word(_ALL_Family)


def _write_Family(w: Writer, value: Family) -> None:
    w.word(_ALL_Family, value)


def _read_Preview(r: Reader) -> Preview:
    return Preview(
        r.string(),
        r.u64(),
        r.u64(),
        r.array(Reader.u16, 2),
        r.blob(100000),
    )


def _write_Preview(w: Writer, value: Preview) -> None:
    w.string(value.camera)
    w.u64(value.sequence)
    w.u64(value.capture_ns)
    w.array(Writer.u16, value.resolution, 2)
    w.blob(value.jpeg)


def _read_DetectionReportStageMs(r: Reader) -> DetectionReportStageMs:
    return DetectionReportStageMs(
        r.f32(),
        r.f32(),
        r.f32(),
        r.f32(),
        r.f32(),
        r.f32(),
    )


def _write_DetectionReportStageMs(w: Writer, value: DetectionReportStageMs) -> None:
    w.f32(value.tiles)
    w.f32(value.threshold)
    w.f32(value.components)
    w.f32(value.quads)
    w.f32(value.decode)
    w.f32(value.refine)


def _read_DetectionReportRejected(r: Reader) -> DetectionReportRejected:
    return DetectionReportRejected(
        r.u32(),
        r.u32(),
        r.u32(),
        r.u32(),
        r.u32(),
    )


def _write_DetectionReportRejected(w: Writer, value: DetectionReportRejected) -> None:
    w.u32(value.not_a_quad)
    w.u32(value.shape)
    w.u32(value.faint_border)
    w.u32(value.no_code)
    w.u32(value.small_margin)


def _read_DetectionReportExample(r: Reader) -> DetectionReportExample:
    return DetectionReportExample(
        _read_RejectionCause(r),
        r.array(lambda r: r.f32s(2), 4),
    )


def _write_DetectionReportExample(w: Writer, value: DetectionReportExample) -> None:
    _write_RejectionCause(w, value.cause)
    w.array(lambda w, v: w.f32s(v, 2), value.corners, 4)


def _read_DetectionReport(r: Reader) -> DetectionReport:
    return DetectionReport(
        r.string(),
        r.u64(),
        r.u64(),
        r.array(Reader.u16, 2),
        r.f32(),
        _read_DetectionReportStageMs(r),
        r.f32(),
        r.u8(),
        r.u32(),
        r.u32(),
        r.u32(),
        r.u32(),
        _read_DetectionReportRejected(r),
        r.list(_read_DetectionReportExample, 64),
    )


def _write_DetectionReport(w: Writer, value: DetectionReport) -> None:
    w.string(value.camera)
    w.u64(value.sequence)
    w.u64(value.capture_ns)
    w.array(Writer.u16, value.resolution, 2)
    w.f32(value.searched)
    _write_DetectionReportStageMs(w, value.stage_ms)
    w.f32(value.noise_sigma)
    w.u8(value.contrast_gate)
    w.u32(value.components)
    w.u32(value.candidates)
    w.u32(value.dropped)
    w.u32(value.tags)
    _write_DetectionReportRejected(w, value.rejected)
    w.list(_write_DetectionReportExample, value.examples)


def _read_RejectionCause(r: Reader) -> RejectionCause:
    return r.word(_ALL_RejectionCause)


def _write_RejectionCause(w: Writer, value: RejectionCause) -> None:
    w.word(_ALL_RejectionCause, value)


def _read_CameraStatusControls(r: Reader) -> CameraStatusControls:
    return CameraStatusControls(
        _read_Control(r),
        _read_Control(r),
        _read_Control(r),
        _read_SettingsOutcome(r),
    )


def _write_CameraStatusControls(w: Writer, value: CameraStatusControls) -> None:
    _write_Control(w, value.exposure_us)
    _write_Control(w, value.gain)
    _write_Control(w, value.rate_hz)
    _write_SettingsOutcome(w, value.outcome)


def _read_CameraStatus(r: Reader) -> CameraStatus:
    return CameraStatus(
        r.string(),
        r.string(),
        r.string(),
        r.u64(),
        r.u64(),
        r.u64(),
        r.f32(),
        r.f32s(2),
        _read_Clock(r),
        r.u64(),
        r.u64(),
        r.u64(),
        r.f32(),
        _read_CameraStatusControls(r),
        r.list(_read_CameraNotice, 32),
    )


def _write_CameraStatus(w: Writer, value: CameraStatus) -> None:
    w.string(value.camera)
    w.string(value.version)
    w.string(value.host)
    w.u64(value.captured)
    w.u64(value.detected)
    w.u64(value.dropped)
    w.f32(value.rate_hz)
    w.f32s(value.detect_ms, 2)
    _write_Clock(w, value.clock)
    w.u64(value.uptime_s)
    w.u64(value.published)
    w.u64(value.fallbacks)
    w.f32(value.brightness)
    _write_CameraStatusControls(w, value.controls)
    w.list(_write_CameraNotice, value.notices)


def _read_Control(r: Reader) -> Control:
    return Control(
        r.optional(Reader.f64),
        r.optional(Reader.f64),
        r.optional(lambda r: r.f64s(2)),
    )


def _write_Control(w: Writer, value: Control) -> None:
    w.optional(Writer.f64, value.wanted)
    w.optional(Writer.f64, value.value)
    w.optional(lambda w, v: w.f64s(v, 2), value.range)


def _read_SettingsOutcomeNone(r: Reader) -> SettingsOutcomeNone:
    return SettingsOutcomeNone()


def _write_SettingsOutcomeNone(w: Writer, value: SettingsOutcomeNone) -> None:
    pass


def _read_SettingsOutcomePending(r: Reader) -> SettingsOutcomePending:
    return SettingsOutcomePending()


def _write_SettingsOutcomePending(w: Writer, value: SettingsOutcomePending) -> None:
    pass


def _read_SettingsOutcomeApplied(r: Reader) -> SettingsOutcomeApplied:
    return SettingsOutcomeApplied()


def _write_SettingsOutcomeApplied(w: Writer, value: SettingsOutcomeApplied) -> None:
    pass


def _read_SettingsOutcomeAdjusted(r: Reader) -> SettingsOutcomeAdjusted:
    return SettingsOutcomeAdjusted(
        r.string(),
    )


def _write_SettingsOutcomeAdjusted(w: Writer, value: SettingsOutcomeAdjusted) -> None:
    w.string(value.detail)


def _read_SettingsOutcomeRefused(r: Reader) -> SettingsOutcomeRefused:
    return SettingsOutcomeRefused(
        r.string(),
    )


def _write_SettingsOutcomeRefused(w: Writer, value: SettingsOutcomeRefused) -> None:
    w.string(value.detail)


def _read_SettingsOutcome(r: Reader) -> SettingsOutcome:
    value: SettingsOutcome = r.alternative(_ALL_SettingsOutcome)
    return value


def _write_SettingsOutcome(w: Writer, value: SettingsOutcome) -> None:
    w.alternative(_ALL_SettingsOutcome, value)


def _read_ObjectPose(r: Reader) -> ObjectPose:
    return ObjectPose(
        r.string(),
        r.u64(),
        r.u64(),
        r.u64(),
        r.u64(),
        _read_State(r),
        r.f64s(3),
        r.f64s(4),
        r.f64s(36),
        r.f64s(6),
        r.u16(),
        r.u16(),
        r.f32(),
    )


def _write_ObjectPose(w: Writer, value: ObjectPose) -> None:
    w.string(value.object)
    w.u64(value.epoch)
    w.u64(value.sequence)
    w.u64(value.capture_ns)
    w.u64(value.published_ns)
    _write_State(w, value.state)
    w.f64s(value.position, 3)
    w.f64s(value.orientation, 4)
    w.f64s(value.covariance, 36)
    w.f64s(value.twist, 6)
    w.u16(value.cameras)
    w.u16(value.tags)
    w.f32(value.rms_px)


def _read_State(r: Reader) -> State:
    return r.word(_ALL_State)


def _write_State(w: Writer, value: State) -> None:
    w.word(_ALL_State, value)


def _read_ObjectLinksLink(r: Reader) -> ObjectLinksLink:
    return ObjectLinksLink(
        r.string(),
        r.f64s(3),
        r.f64s(4),
        r.f64s(36),
    )


def _write_ObjectLinksLink(w: Writer, value: ObjectLinksLink) -> None:
    w.string(value.link)
    w.f64s(value.position, 3)
    w.f64s(value.orientation, 4)
    w.f64s(value.covariance, 36)


def _read_ObjectLinksJoint(r: Reader) -> ObjectLinksJoint:
    return ObjectLinksJoint(
        r.string(),
        r.f64(),
        r.f64(),
        r.f64(),
        r.f64(),
    )


def _write_ObjectLinksJoint(w: Writer, value: ObjectLinksJoint) -> None:
    w.string(value.joint)
    w.f64(value.value)
    w.f64(value.variance)
    w.f64(value.velocity)
    w.f64(value.velocity_variance)


def _read_ObjectLinks(r: Reader) -> ObjectLinks:
    return ObjectLinks(
        r.string(),
        r.u64(),
        r.u64(),
        r.u64(),
        r.u64(),
        _read_State(r),
        r.list(_read_ObjectLinksLink, 32),
        r.list(_read_ObjectLinksJoint, 8),
    )


def _write_ObjectLinks(w: Writer, value: ObjectLinks) -> None:
    w.string(value.object)
    w.u64(value.epoch)
    w.u64(value.sequence)
    w.u64(value.capture_ns)
    w.u64(value.published_ns)
    _write_State(w, value.state)
    w.list(_write_ObjectLinksLink, value.links)
    w.list(_write_ObjectLinksJoint, value.joints)


def _read_ObjectTruth(r: Reader) -> ObjectTruth:
    return ObjectTruth(
        r.string(),
        r.u64(),
        r.f64s(3),
        r.f64s(4),
        r.f64(),
        r.f64(),
    )


def _write_ObjectTruth(w: Writer, value: ObjectTruth) -> None:
    w.string(value.object)
    w.u64(value.capture_ns)
    w.f64s(value.position, 3)
    w.f64s(value.orientation, 4)
    w.f64(value.position_error_m)
    w.f64(value.attitude_error_rad)


def _read_FusionStatusObject(r: Reader) -> FusionStatusObject:
    return FusionStatusObject(
        r.string(),
        _read_State(r),
        r.f32(),
    )


def _write_FusionStatusObject(w: Writer, value: FusionStatusObject) -> None:
    w.string(value.object)
    _write_State(w, value.state)
    w.f32(value.rate_hz)


def _read_FusionStatus(r: Reader) -> FusionStatus:
    return FusionStatus(
        r.string(),
        r.string(),
        r.u64(),
        r.optional(Reader.u64),
        r.list(_read_CameraIntake, 256),
        _read_Rejections(r),
        r.list(_read_FusionStatusObject, 1024),
        r.list(_read_Fault, 64),
        r.u32(),
        r.list(_read_Imperfection, 16),
        r.list(_read_Notice, 32),
    )


def _write_FusionStatus(w: Writer, value: FusionStatus) -> None:
    w.string(value.node)
    w.string(value.version)
    w.u64(value.uptime_s)
    w.optional(Writer.u64, value.epoch)
    w.list(_write_CameraIntake, value.cameras)
    _write_Rejections(w, value.foreign)
    w.list(_write_FusionStatusObject, value.objects)
    w.list(_write_Fault, value.faults)
    w.u32(value.faults_left_out)
    w.list(_write_Imperfection, value.imperfections)
    w.list(_write_Notice, value.notices)


def _read_CameraIntake(r: Reader) -> CameraIntake:
    return CameraIntake(
        r.string(),
        r.u64(),
        _read_Rejections(r),
        r.u64(),
        r.u64(),
        r.u64(),
        r.u64(),
        r.f32(),
    )


def _write_CameraIntake(w: Writer, value: CameraIntake) -> None:
    w.string(value.camera)
    w.u64(value.received)
    _write_Rejections(w, value.rejected)
    w.u64(value.unknown_tags)
    w.u64(value.late)
    w.u64(value.gated)
    w.u64(value.last_capture_ns)
    w.f32(value.rate_hz)


def _read_Rejections(r: Reader) -> Rejections:
    return Rejections(
        r.u64(),
        r.u64(),
        r.u64(),
        r.u64(),
        r.u64(),
        r.u64(),
        r.u64(),
    )


def _write_Rejections(w: Writer, value: Rejections) -> None:
    w.u64(value.bad_magic)
    w.u64(value.foreign_version)
    w.u64(value.wrong_kind)
    w.u64(value.damaged)
    w.u64(value.too_long)
    w.u64(value.out_of_range)
    w.u64(value.wrong_camera)


def _read_ClockReportCamera(r: Reader) -> ClockReportCamera:
    return ClockReportCamera(
        r.string(),
        r.f64(),
        r.f64(),
        r.optional(Reader.f64),
    )


def _write_ClockReportCamera(w: Writer, value: ClockReportCamera) -> None:
    w.string(value.camera)
    w.f64(value.offset_s)
    w.f64(value.sigma_s)
    w.optional(Writer.f64, value.drift)


def _read_ClockReport(r: Reader) -> ClockReport:
    return ClockReport(
        r.string(),
        r.list(_read_ClockReportCamera, 256),
    )


def _write_ClockReport(w: Writer, value: ClockReport) -> None:
    w.string(value.node)
    w.list(_write_ClockReportCamera, value.cameras)


def _read_FusionInputsInput(r: Reader) -> FusionInputsInput:
    return FusionInputsInput(
        r.u64(),
        _read_InputSource(r),
    )


def _write_FusionInputsInput(w: Writer, value: FusionInputsInput) -> None:
    w.u64(value.now_ns)
    _write_InputSource(w, value.source)


def _read_FusionInputs(r: Reader) -> FusionInputs:
    return FusionInputs(
        r.string(),
        r.u64(),
        r.list(_read_FusionInputsInput, 256),
    )


def _write_FusionInputs(w: Writer, value: FusionInputs) -> None:
    w.string(value.node)
    w.u64(value.first)
    w.list(_write_FusionInputsInput, value.inputs)


def _read_InputSourceImage(r: Reader) -> InputSourceImage:
    return InputSourceImage(
        r.string(),
        r.u64(),
        r.u64(),
    )


def _write_InputSourceImage(w: Writer, value: InputSourceImage) -> None:
    w.string(value.camera)
    w.u64(value.sequence)
    w.u64(value.capture_ns)


def _read_InputSourceRig(r: Reader) -> InputSourceRig:
    return InputSourceRig(
        r.u64(),
    )


def _write_InputSourceRig(w: Writer, value: InputSourceRig) -> None:
    w.u64(value.value)


def _read_InputSourceObjects(r: Reader) -> InputSourceObjects:
    return InputSourceObjects(
        r.list(Reader.u64, 1024),
    )


def _write_InputSourceObjects(w: Writer, value: InputSourceObjects) -> None:
    w.list(Writer.u64, value.value)


def _read_InputSourceClockStep(r: Reader) -> InputSourceClockStep:
    return InputSourceClockStep()


def _write_InputSourceClockStep(w: Writer, value: InputSourceClockStep) -> None:
    pass


def _read_InputSourceTick(r: Reader) -> InputSourceTick:
    return InputSourceTick()


def _write_InputSourceTick(w: Writer, value: InputSourceTick) -> None:
    pass


def _read_InputSource(r: Reader) -> InputSource:
    value: InputSource = r.alternative(_ALL_InputSource)
    return value


def _write_InputSource(w: Writer, value: InputSource) -> None:
    w.alternative(_ALL_InputSource, value)


def _read_HeartbeatHeard(r: Reader) -> HeartbeatHeard:
    return HeartbeatHeard(
        r.string(),
        r.u64(),
    )


def _write_HeartbeatHeard(w: Writer, value: HeartbeatHeard) -> None:
    w.string(value.node)
    w.u64(value.sent_ns)


def _read_HeartbeatSharingObjectPartPreparing(r: Reader) -> HeartbeatSharingObjectPartPreparing:
    return HeartbeatSharingObjectPartPreparing()


def _write_HeartbeatSharingObjectPartPreparing(w: Writer, value: HeartbeatSharingObjectPartPreparing) -> None:
    pass


def _read_HeartbeatSharingObjectPartReady(r: Reader) -> HeartbeatSharingObjectPartReady:
    return HeartbeatSharingObjectPartReady()


def _write_HeartbeatSharingObjectPartReady(w: Writer, value: HeartbeatSharingObjectPartReady) -> None:
    pass


def _read_HeartbeatSharingObjectPartPublishing(r: Reader) -> HeartbeatSharingObjectPartPublishing:
    return HeartbeatSharingObjectPartPublishing(
        r.u64(),
    )


def _write_HeartbeatSharingObjectPartPublishing(w: Writer, value: HeartbeatSharingObjectPartPublishing) -> None:
    w.u64(value.value)


def _read_HeartbeatSharingObjectPart(r: Reader) -> HeartbeatSharingObjectPart:
    value: HeartbeatSharingObjectPart = r.alternative(_ALL_HeartbeatSharingObjectPart)
    return value


def _write_HeartbeatSharingObjectPart(w: Writer, value: HeartbeatSharingObjectPart) -> None:
    w.alternative(_ALL_HeartbeatSharingObjectPart, value)


def _read_HeartbeatSharingObject(r: Reader) -> HeartbeatSharingObject:
    return HeartbeatSharingObject(
        r.string(),
        _read_HeartbeatSharingObjectPart(r),
    )


def _write_HeartbeatSharingObject(w: Writer, value: HeartbeatSharingObject) -> None:
    w.string(value.object)
    _write_HeartbeatSharingObjectPart(w, value.part)


def _read_HeartbeatSharing(r: Reader) -> HeartbeatSharing:
    return HeartbeatSharing(
        r.optional(Reader.u32),
        r.list(_read_HeartbeatSharingObject, 1024),
    )


def _write_HeartbeatSharing(w: Writer, value: HeartbeatSharing) -> None:
    w.optional(Writer.u32, value.standbys)
    w.list(_write_HeartbeatSharingObject, value.objects)


def _read_Heartbeat(r: Reader) -> Heartbeat:
    return Heartbeat(
        r.string(),
        r.u64(),
        r.optional(Reader.u64),
        r.u64(),
        r.list(_read_HeartbeatHeard, 16),
        r.optional(_read_HeartbeatSharing),
    )


def _write_Heartbeat(w: Writer, value: Heartbeat) -> None:
    w.string(value.node)
    w.u64(value.sent_ns)
    w.optional(Writer.u64, value.epoch)
    w.u64(value.newest)
    w.list(_write_HeartbeatHeard, value.heard)
    w.optional(_write_HeartbeatSharing, value.sharing)


def _read_ConfigAnswerOutcomeTaken(r: Reader) -> ConfigAnswerOutcomeTaken:
    return ConfigAnswerOutcomeTaken()


def _write_ConfigAnswerOutcomeTaken(w: Writer, value: ConfigAnswerOutcomeTaken) -> None:
    pass


def _read_ConfigAnswerOutcomeKept(r: Reader) -> ConfigAnswerOutcomeKept:
    return ConfigAnswerOutcomeKept()


def _write_ConfigAnswerOutcomeKept(w: Writer, value: ConfigAnswerOutcomeKept) -> None:
    pass


def _read_ConfigAnswerOutcomeSame(r: Reader) -> ConfigAnswerOutcomeSame:
    return ConfigAnswerOutcomeSame()


def _write_ConfigAnswerOutcomeSame(w: Writer, value: ConfigAnswerOutcomeSame) -> None:
    pass


def _read_ConfigAnswerOutcomeRefused(r: Reader) -> ConfigAnswerOutcomeRefused:
    return ConfigAnswerOutcomeRefused(
        _read_Refusal(r),
    )


def _write_ConfigAnswerOutcomeRefused(w: Writer, value: ConfigAnswerOutcomeRefused) -> None:
    _write_Refusal(w, value.value)


def _read_ConfigAnswerOutcome(r: Reader) -> ConfigAnswerOutcome:
    value: ConfigAnswerOutcome = r.alternative(_ALL_ConfigAnswerOutcome)
    return value


def _write_ConfigAnswerOutcome(w: Writer, value: ConfigAnswerOutcome) -> None:
    w.alternative(_ALL_ConfigAnswerOutcome, value)


def _read_ConfigAnswer(r: Reader) -> ConfigAnswer:
    return ConfigAnswer(
        r.string(),
        r.string(),
        r.u64(),
        _read_ConfigAnswerOutcome(r),
    )


def _write_ConfigAnswer(w: Writer, value: ConfigAnswer) -> None:
    w.string(value.node)
    w.string(value.key)
    w.u64(value.fingerprint)
    _write_ConfigAnswerOutcome(w, value.outcome)


def _read_Proposal(r: Reader) -> Proposal:
    return Proposal(
        r.string(),
        r.u64(),
        r.optional(lambda r: r.blob(None)),
        r.list(lambda r: r.blob(None), 1024),
        r.u32(),
        r.f64(),
        r.f64(),
    )


def _write_Proposal(w: Writer, value: Proposal) -> None:
    w.string(value.node)
    w.u64(value.t_ns)
    w.optional(lambda w, v: w.blob(v), value.rig)
    w.list(lambda w, v: w.blob(v), value.objects)
    w.u32(value.n_images)
    w.f64(value.before_px)
    w.f64(value.after_px)


def _read_RigConfig(r: Reader) -> RigConfig:
    return RigConfig(
        r.list(_read_Camera, 256),
        r.optional(Reader.f64),
    )


def _write_RigConfig(w: Writer, value: RigConfig) -> None:
    w.list(_write_Camera, value.cameras)
    w.optional(Writer.f64, value.scale_sigma)


def _read_CameraLensSigma(r: Reader) -> CameraLensSigma:
    return CameraLensSigma(
        r.f64(),
        r.f64(),
    )


def _write_CameraLensSigma(w: Writer, value: CameraLensSigma) -> None:
    w.f64(value.focal_px)
    w.f64(value.distortion_px)


def _read_CameraExposureStamp(r: Reader) -> CameraExposureStamp:
    return r.word(_ALL_CameraExposureStamp)


def _write_CameraExposureStamp(w: Writer, value: CameraExposureStamp) -> None:
    w.word(_ALL_CameraExposureStamp, value)


def _read_CameraExposure(r: Reader) -> CameraExposure:
    return CameraExposure(
        r.f64(),
        _read_CameraExposureStamp(r),
    )


def _write_CameraExposure(w: Writer, value: CameraExposure) -> None:
    w.f64(value.length_s)
    _write_CameraExposureStamp(w, value.stamp)


def _read_Camera(r: Reader) -> Camera:
    return Camera(
        r.string(),
        r.array(Reader.u32, 2),
        _read_Lens(r),
        r.optional(_read_CameraLensSigma),
        r.optional(_read_Pose),
        r.optional(_read_Sigma),
        r.optional(Reader.f64),
        r.optional(_read_CameraExposure),
    )


def _write_Camera(w: Writer, value: Camera) -> None:
    w.string(value.id)
    w.array(Writer.u32, value.resolution, 2)
    _write_Lens(w, value.lens)
    w.optional(_write_CameraLensSigma, value.lens_sigma)
    w.optional(_write_Pose, value.world_from_camera)
    w.optional(_write_Sigma, value.world_from_camera_sigma)
    w.optional(Writer.f64, value.line_delay_s)
    w.optional(_write_CameraExposure, value.exposure)


def _read_LensPinhole(r: Reader) -> LensPinhole:
    return LensPinhole(
        r.f64(),
        r.f64(),
        r.f64(),
        r.f64(),
    )


def _write_LensPinhole(w: Writer, value: LensPinhole) -> None:
    w.f64(value.fx)
    w.f64(value.fy)
    w.f64(value.cx)
    w.f64(value.cy)


def _read_LensBrownConrady(r: Reader) -> LensBrownConrady:
    return LensBrownConrady(
        r.f64(),
        r.f64(),
        r.f64(),
        r.f64(),
        r.f64s(5),
    )


def _write_LensBrownConrady(w: Writer, value: LensBrownConrady) -> None:
    w.f64(value.fx)
    w.f64(value.fy)
    w.f64(value.cx)
    w.f64(value.cy)
    w.f64s(value.distortion, 5)


def _read_LensKannalaBrandt(r: Reader) -> LensKannalaBrandt:
    return LensKannalaBrandt(
        r.f64(),
        r.f64(),
        r.f64(),
        r.f64(),
        r.f64s(4),
    )


def _write_LensKannalaBrandt(w: Writer, value: LensKannalaBrandt) -> None:
    w.f64(value.fx)
    w.f64(value.fy)
    w.f64(value.cx)
    w.f64(value.cy)
    w.f64s(value.distortion, 4)


def _read_Lens(r: Reader) -> Lens:
    value: Lens = r.alternative(_ALL_Lens)
    return value


def _write_Lens(w: Writer, value: Lens) -> None:
    w.alternative(_ALL_Lens, value)


def _read_Pose(r: Reader) -> Pose:
    return Pose(
        r.f64s(3),
        r.f64s(4),
    )


def _write_Pose(w: Writer, value: Pose) -> None:
    w.f64s(value.position, 3)
    w.f64s(value.orientation, 4)


def _read_Sigma(r: Reader) -> Sigma:
    return Sigma(
        r.f64(),
        r.f64(),
    )


def _write_Sigma(w: Writer, value: Sigma) -> None:
    w.f64(value.position_m)
    w.f64(value.orientation_rad)


def _read_ObjectConfig(r: Reader) -> ObjectConfig:
    return ObjectConfig(
        r.string(),
        r.list(Reader.string, 32),
        r.list(_read_Joint, 32),
        r.list(_read_ObjectTag, 1024),
        r.optional(_read_Sigma),
        r.optional(Reader.f64),
    )


def _write_ObjectConfig(w: Writer, value: ObjectConfig) -> None:
    w.string(value.id)
    w.list(Writer.string, value.links)
    w.list(_write_Joint, value.joints)
    w.list(_write_ObjectTag, value.tags)
    w.optional(_write_Sigma, value.frame_sigma)
    w.optional(Writer.f64, value.scale_sigma)


def _read_JointKind(r: Reader) -> JointKind:
    return r.word(_ALL_JointKind)


def _write_JointKind(w: Writer, value: JointKind) -> None:
    w.word(_ALL_JointKind, value)


def _read_Joint(r: Reader) -> Joint:
    return Joint(
        r.string(),
        _read_JointKind(r),
        r.string(),
        r.string(),
        r.f64s(3),
        _read_Pose(r),
        r.optional(lambda r: r.f64s(2)),
        r.optional(Reader.f64),
    )


def _write_Joint(w: Writer, value: Joint) -> None:
    w.string(value.id)
    _write_JointKind(w, value.kind)
    w.string(value.parent)
    w.string(value.child)
    w.f64s(value.axis, 3)
    _write_Pose(w, value.parent_from_joint)
    w.optional(lambda w, v: w.f64s(v, 2), value.limits)
    w.optional(Writer.f64, value.max_speed)


def _read_ObjectTag(r: Reader) -> ObjectTag:
    return ObjectTag(
        _read_Family(r),
        r.u32(),
        r.f64(),
        r.optional(Reader.f64),
        r.optional(Reader.u8),
        r.optional(_read_Pose),
        r.optional(_read_Sigma),
    )


def _write_ObjectTag(w: Writer, value: ObjectTag) -> None:
    _write_Family(w, value.family)
    w.u32(value.id)
    w.f64(value.size_m)
    w.optional(Writer.f64, value.size_sigma_m)
    w.optional(Writer.u8, value.link)
    w.optional(_write_Pose, value.object_from_tag)
    w.optional(_write_Sigma, value.object_from_tag_sigma)


def _read_CameraSettings(r: Reader) -> CameraSettings:
    return CameraSettings(
        r.string(),
        r.optional(Reader.f64),
        r.optional(Reader.f64),
        r.optional(Reader.f64),
    )


def _write_CameraSettings(w: Writer, value: CameraSettings) -> None:
    w.string(value.camera)
    w.optional(Writer.f64, value.exposure_us)
    w.optional(Writer.f64, value.gain)
    w.optional(Writer.f64, value.rate_hz)


def _read_TagId(r: Reader) -> TagId:
    return TagId(
        _read_Family(r),
        r.u32(),
    )


def _write_TagId(w: Writer, value: TagId) -> None:
    _write_Family(w, value.family)
    w.u32(value.id)


def _read_FaultCameraMoved(r: Reader) -> FaultCameraMoved:
    return FaultCameraMoved(
        r.string(),
    )


def _write_FaultCameraMoved(w: Writer, value: FaultCameraMoved) -> None:
    w.string(value.camera)


def _read_FaultCamerasDisagree(r: Reader) -> FaultCamerasDisagree:
    return FaultCamerasDisagree(
        r.string(),
        r.string(),
    )


def _write_FaultCamerasDisagree(w: Writer, value: FaultCamerasDisagree) -> None:
    w.string(value.a)
    w.string(value.b)


def _read_FaultTagMisplaced(r: Reader) -> FaultTagMisplaced:
    return FaultTagMisplaced(
        r.string(),
        _read_TagId(r),
    )


def _write_FaultTagMisplaced(w: Writer, value: FaultTagMisplaced) -> None:
    w.string(value.object)
    _write_TagId(w, value.tag)


def _read_FaultTagSize(r: Reader) -> FaultTagSize:
    return FaultTagSize(
        r.string(),
        _read_TagId(r),
        r.f64(),
    )


def _write_FaultTagSize(w: Writer, value: FaultTagSize) -> None:
    w.string(value.object)
    _write_TagId(w, value.tag)
    w.f64(value.ratio)


def _read_FaultTagElsewhere(r: Reader) -> FaultTagElsewhere:
    return FaultTagElsewhere(
        r.string(),
        _read_TagId(r),
        r.optional(Reader.string),
    )


def _write_FaultTagElsewhere(w: Writer, value: FaultTagElsewhere) -> None:
    w.string(value.object)
    _write_TagId(w, value.tag)
    w.optional(Writer.string, value.on)


def _read_FaultClockOff(r: Reader) -> FaultClockOff:
    return FaultClockOff(
        r.string(),
        r.f64(),
    )


def _write_FaultClockOff(w: Writer, value: FaultClockOff) -> None:
    w.string(value.camera)
    w.f64(value.offset_s)


def _read_FaultUntimely(r: Reader) -> FaultUntimely:
    return FaultUntimely(
        r.string(),
        r.f64(),
    )


def _write_FaultUntimely(w: Writer, value: FaultUntimely) -> None:
    w.string(value.camera)
    w.f64(value.age_s)


def _read_FaultDuplicateTag(r: Reader) -> FaultDuplicateTag:
    return FaultDuplicateTag(
        r.string(),
        _read_TagId(r),
    )


def _write_FaultDuplicateTag(w: Writer, value: FaultDuplicateTag) -> None:
    w.string(value.camera)
    _write_TagId(w, value.tag)


def _read_FaultHostClockOff(r: Reader) -> FaultHostClockOff:
    return FaultHostClockOff(
        r.f64(),
    )


def _write_FaultHostClockOff(w: Writer, value: FaultHostClockOff) -> None:
    w.f64(value.offset_s)


def _read_FaultCameraFrozen(r: Reader) -> FaultCameraFrozen:
    return FaultCameraFrozen(
        r.string(),
        r.f64(),
    )


def _write_FaultCameraFrozen(w: Writer, value: FaultCameraFrozen) -> None:
    w.string(value.camera)
    w.f64(value.still_s)


def _read_FaultLensOff(r: Reader) -> FaultLensOff:
    return FaultLensOff(
        r.string(),
    )


def _write_FaultLensOff(w: Writer, value: FaultLensOff) -> None:
    w.string(value.camera)


def _read_FaultObjectScaled(r: Reader) -> FaultObjectScaled:
    return FaultObjectScaled(
        r.string(),
        r.f64(),
    )


def _write_FaultObjectScaled(w: Writer, value: FaultObjectScaled) -> None:
    w.string(value.object)
    w.f64(value.ratio)


def _read_FaultObjectContradicted(r: Reader) -> FaultObjectContradicted:
    return FaultObjectContradicted(
        r.string(),
        r.f64(),
    )


def _write_FaultObjectContradicted(w: Writer, value: FaultObjectContradicted) -> None:
    w.string(value.object)
    w.f64(value.share)


def _read_FaultObjectUnplaced(r: Reader) -> FaultObjectUnplaced:
    return FaultObjectUnplaced(
        r.string(),
    )


def _write_FaultObjectUnplaced(w: Writer, value: FaultObjectUnplaced) -> None:
    w.string(value.object)


def _read_Fault(r: Reader) -> Fault:
    value: Fault = r.alternative(_ALL_Fault)
    return value


def _write_Fault(w: Writer, value: Fault) -> None:
    w.alternative(_ALL_Fault, value)


def _read_ImperfectionCamerasDisagree(r: Reader) -> ImperfectionCamerasDisagree:
    return ImperfectionCamerasDisagree(
        r.string(),
        r.string(),
        r.f64(),
    )


def _write_ImperfectionCamerasDisagree(w: Writer, value: ImperfectionCamerasDisagree) -> None:
    w.string(value.a)
    w.string(value.b)
    w.f64(value.apart_m)


def _read_ImperfectionTagOff(r: Reader) -> ImperfectionTagOff:
    return ImperfectionTagOff(
        r.string(),
        _read_TagId(r),
        r.f64(),
        r.f64(),
    )


def _write_ImperfectionTagOff(w: Writer, value: ImperfectionTagOff) -> None:
    w.string(value.object)
    _write_TagId(w, value.tag)
    w.f64(value.position_m)
    w.f64(value.orientation_rad)


def _read_ImperfectionSizeOff(r: Reader) -> ImperfectionSizeOff:
    return ImperfectionSizeOff(
        r.string(),
        _read_TagId(r),
        r.f64(),
    )


def _write_ImperfectionSizeOff(w: Writer, value: ImperfectionSizeOff) -> None:
    w.string(value.object)
    _write_TagId(w, value.tag)
    w.f64(value.ratio)


def _read_ImperfectionFocalLengthOff(r: Reader) -> ImperfectionFocalLengthOff:
    return ImperfectionFocalLengthOff(
        r.string(),
        r.f64(),
    )


def _write_ImperfectionFocalLengthOff(w: Writer, value: ImperfectionFocalLengthOff) -> None:
    w.string(value.camera)
    w.f64(value.ratio)


def _read_Imperfection(r: Reader) -> Imperfection:
    value: Imperfection = r.alternative(_ALL_Imperfection)
    return value


def _write_Imperfection(w: Writer, value: Imperfection) -> None:
    w.alternative(_ALL_Imperfection, value)


def _read_NoticeCameraSilent(r: Reader) -> NoticeCameraSilent:
    return NoticeCameraSilent(
        r.string(),
        r.f64(),
    )


def _write_NoticeCameraSilent(w: Writer, value: NoticeCameraSilent) -> None:
    w.string(value.camera)
    w.f64(value.silent_s)


def _read_NoticeLateObservations(r: Reader) -> NoticeLateObservations:
    return NoticeLateObservations(
        r.string(),
        r.u64(),
    )


def _write_NoticeLateObservations(w: Writer, value: NoticeLateObservations) -> None:
    w.string(value.camera)
    w.u64(value.total)


def _read_NoticeOverload(r: Reader) -> NoticeOverload:
    return NoticeOverload(
        r.u64(),
        r.u64(),
    )


def _write_NoticeOverload(w: Writer, value: NoticeOverload) -> None:
    w.u64(value.dropped)
    w.u64(value.total)


def _read_NoticeUnpublished(r: Reader) -> NoticeUnpublished:
    return NoticeUnpublished(
        r.u64(),
        r.string(),
    )


def _write_NoticeUnpublished(w: Writer, value: NoticeUnpublished) -> None:
    w.u64(value.total)
    w.string(value.detail)


def _read_NoticeClockStepped(r: Reader) -> NoticeClockStepped:
    return NoticeClockStepped(
        r.f64(),
    )


def _write_NoticeClockStepped(w: Writer, value: NoticeClockStepped) -> None:
    w.f64(value.by_s)


def _read_NoticeChangeRefused(r: Reader) -> NoticeChangeRefused:
    return NoticeChangeRefused(
        r.string(),
        r.optional(Reader.string),
        _read_Refusal(r),
    )


def _write_NoticeChangeRefused(w: Writer, value: NoticeChangeRefused) -> None:
    w.string(value.key)
    w.optional(Writer.string, value.sender)
    _write_Refusal(w, value.refusal)


def _read_NoticeNameTaken(r: Reader) -> NoticeNameTaken:
    return NoticeNameTaken(
        r.string(),
    )


def _write_NoticeNameTaken(w: Writer, value: NoticeNameTaken) -> None:
    w.string(value.host)


def _read_NoticeRefinementProposed(r: Reader) -> NoticeRefinementProposed:
    return NoticeRefinementProposed(
        r.u32(),
        r.f64(),
        r.f64(),
    )


def _write_NoticeRefinementProposed(w: Writer, value: NoticeRefinementProposed) -> None:
    w.u32(value.n_images)
    w.f64(value.before_px)
    w.f64(value.after_px)


def _read_Notice(r: Reader) -> Notice:
    value: Notice = r.alternative(_ALL_Notice)
    return value


def _write_Notice(w: Writer, value: Notice) -> None:
    w.alternative(_ALL_Notice, value)


def _read_CameraNoticeNoImage(r: Reader) -> CameraNoticeNoImage:
    return CameraNoticeNoImage(
        r.f64(),
    )


def _write_CameraNoticeNoImage(w: Writer, value: CameraNoticeNoImage) -> None:
    w.f64(value.silent_s)


def _read_CameraNoticeNameTaken(r: Reader) -> CameraNoticeNameTaken:
    return CameraNoticeNameTaken(
        r.string(),
    )


def _write_CameraNoticeNameTaken(w: Writer, value: CameraNoticeNameTaken) -> None:
    w.string(value.host)


def _read_CameraNoticeImageRefused(r: Reader) -> CameraNoticeImageRefused:
    return CameraNoticeImageRefused(
        r.string(),
    )


def _write_CameraNoticeImageRefused(w: Writer, value: CameraNoticeImageRefused) -> None:
    w.string(value.detail)


def _read_CameraNoticeNotInRig(r: Reader) -> CameraNoticeNotInRig:
    return CameraNoticeNotInRig()


def _write_CameraNoticeNotInRig(w: Writer, value: CameraNoticeNotInRig) -> None:
    pass


def _read_CameraNoticeModelRefused(r: Reader) -> CameraNoticeModelRefused:
    return CameraNoticeModelRefused(
        r.string(),
        r.string(),
    )


def _write_CameraNoticeModelRefused(w: Writer, value: CameraNoticeModelRefused) -> None:
    w.string(value.key)
    w.string(value.detail)


def _read_CameraNoticeTooManyTags(r: Reader) -> CameraNoticeTooManyTags:
    return CameraNoticeTooManyTags(
        r.string(),
    )


def _write_CameraNoticeTooManyTags(w: Writer, value: CameraNoticeTooManyTags) -> None:
    w.string(value.key)


def _read_CameraNotice(r: Reader) -> CameraNotice:
    value: CameraNotice = r.alternative(_ALL_CameraNotice)
    return value


def _write_CameraNotice(w: Writer, value: CameraNotice) -> None:
    w.alternative(_ALL_CameraNotice, value)


def _read_RefusalUndecodable(r: Reader) -> RefusalUndecodable:
    return RefusalUndecodable(
        r.string(),
    )


def _write_RefusalUndecodable(w: Writer, value: RefusalUndecodable) -> None:
    w.string(value.detail)


def _read_RefusalWrongId(r: Reader) -> RefusalWrongId:
    return RefusalWrongId(
        r.string(),
    )


def _write_RefusalWrongId(w: Writer, value: RefusalWrongId) -> None:
    w.string(value.described)


def _read_RefusalNoCamera(r: Reader) -> RefusalNoCamera:
    return RefusalNoCamera()


def _write_RefusalNoCamera(w: Writer, value: RefusalNoCamera) -> None:
    pass


def _read_RefusalInvalidCamera(r: Reader) -> RefusalInvalidCamera:
    return RefusalInvalidCamera(
        r.string(),
        r.string(),
    )


def _write_RefusalInvalidCamera(w: Writer, value: RefusalInvalidCamera) -> None:
    w.string(value.camera)
    w.string(value.detail)


def _read_RefusalInvalidObject(r: Reader) -> RefusalInvalidObject:
    return RefusalInvalidObject(
        r.optional(_read_TagId),
        r.string(),
    )


def _write_RefusalInvalidObject(w: Writer, value: RefusalInvalidObject) -> None:
    w.optional(_write_TagId, value.tag)
    w.string(value.detail)


def _read_RefusalUnknownTag(r: Reader) -> RefusalUnknownTag:
    return RefusalUnknownTag(
        _read_TagId(r),
        r.u32(),
    )


def _write_RefusalUnknownTag(w: Writer, value: RefusalUnknownTag) -> None:
    _write_TagId(w, value.tag)
    w.u32(value.n_ids)


def _read_RefusalSharedTag(r: Reader) -> RefusalSharedTag:
    return RefusalSharedTag(
        _read_TagId(r),
        r.string(),
        r.string(),
    )


def _write_RefusalSharedTag(w: Writer, value: RefusalSharedTag) -> None:
    _write_TagId(w, value.tag)
    w.string(value.first)
    w.string(value.second)


def _read_RefusalTooManyObjects(r: Reader) -> RefusalTooManyObjects:
    return RefusalTooManyObjects(
        r.u32(),
    )


def _write_RefusalTooManyObjects(w: Writer, value: RefusalTooManyObjects) -> None:
    w.u32(value.limit)


def _read_RefusalUnpublishable(r: Reader) -> RefusalUnpublishable:
    return RefusalUnpublishable(
        r.string(),
    )


def _write_RefusalUnpublishable(w: Writer, value: RefusalUnpublishable) -> None:
    w.string(value.detail)


def _read_RefusalNotStored(r: Reader) -> RefusalNotStored:
    return RefusalNotStored(
        r.string(),
    )


def _write_RefusalNotStored(w: Writer, value: RefusalNotStored) -> None:
    w.string(value.detail)


def _read_RefusalOther(r: Reader) -> RefusalOther:
    return RefusalOther(
        r.string(),
    )


def _write_RefusalOther(w: Writer, value: RefusalOther) -> None:
    w.string(value.detail)


def _read_Refusal(r: Reader) -> Refusal:
    value: Refusal = r.alternative(_ALL_Refusal)
    return value


def _write_Refusal(w: Writer, value: Refusal) -> None:
    w.alternative(_ALL_Refusal, value)



_ALL_ClockSource = tuple(ClockSource)
_ALL_Family = tuple(Family)
_ALL_RejectionCause = tuple(RejectionCause)
_ALL_SettingsOutcome = (
    Alternative(SettingsOutcomeNone, _read_SettingsOutcomeNone, _write_SettingsOutcomeNone),
    Alternative(SettingsOutcomePending, _read_SettingsOutcomePending, _write_SettingsOutcomePending),
    Alternative(SettingsOutcomeApplied, _read_SettingsOutcomeApplied, _write_SettingsOutcomeApplied),
    Alternative(SettingsOutcomeAdjusted, _read_SettingsOutcomeAdjusted, _write_SettingsOutcomeAdjusted),
    Alternative(SettingsOutcomeRefused, _read_SettingsOutcomeRefused, _write_SettingsOutcomeRefused),
)
_ALL_State = tuple(State)
_ALL_InputSource = (
    Alternative(InputSourceImage, _read_InputSourceImage, _write_InputSourceImage),
    Alternative(InputSourceRig, _read_InputSourceRig, _write_InputSourceRig),
    Alternative(InputSourceObjects, _read_InputSourceObjects, _write_InputSourceObjects),
    Alternative(InputSourceClockStep, _read_InputSourceClockStep, _write_InputSourceClockStep),
    Alternative(InputSourceTick, _read_InputSourceTick, _write_InputSourceTick),
)
_ALL_HeartbeatSharingObjectPart = (
    Alternative(HeartbeatSharingObjectPartPreparing, _read_HeartbeatSharingObjectPartPreparing, _write_HeartbeatSharingObjectPartPreparing),
    Alternative(HeartbeatSharingObjectPartReady, _read_HeartbeatSharingObjectPartReady, _write_HeartbeatSharingObjectPartReady),
    Alternative(HeartbeatSharingObjectPartPublishing, _read_HeartbeatSharingObjectPartPublishing, _write_HeartbeatSharingObjectPartPublishing),
)
_ALL_ConfigAnswerOutcome = (
    Alternative(ConfigAnswerOutcomeTaken, _read_ConfigAnswerOutcomeTaken, _write_ConfigAnswerOutcomeTaken),
    Alternative(ConfigAnswerOutcomeKept, _read_ConfigAnswerOutcomeKept, _write_ConfigAnswerOutcomeKept),
    Alternative(ConfigAnswerOutcomeSame, _read_ConfigAnswerOutcomeSame, _write_ConfigAnswerOutcomeSame),
    Alternative(ConfigAnswerOutcomeRefused, _read_ConfigAnswerOutcomeRefused, _write_ConfigAnswerOutcomeRefused),
)
_ALL_CameraExposureStamp = tuple(CameraExposureStamp)
_ALL_Lens = (
    Alternative(LensPinhole, _read_LensPinhole, _write_LensPinhole),
    Alternative(LensBrownConrady, _read_LensBrownConrady, _write_LensBrownConrady),
    Alternative(LensKannalaBrandt, _read_LensKannalaBrandt, _write_LensKannalaBrandt),
)
_ALL_JointKind = tuple(JointKind)
_ALL_Fault = (
    Alternative(FaultCameraMoved, _read_FaultCameraMoved, _write_FaultCameraMoved),
    Alternative(FaultCamerasDisagree, _read_FaultCamerasDisagree, _write_FaultCamerasDisagree),
    Alternative(FaultTagMisplaced, _read_FaultTagMisplaced, _write_FaultTagMisplaced),
    Alternative(FaultTagSize, _read_FaultTagSize, _write_FaultTagSize),
    Alternative(FaultTagElsewhere, _read_FaultTagElsewhere, _write_FaultTagElsewhere),
    Alternative(FaultClockOff, _read_FaultClockOff, _write_FaultClockOff),
    Alternative(FaultUntimely, _read_FaultUntimely, _write_FaultUntimely),
    Alternative(FaultDuplicateTag, _read_FaultDuplicateTag, _write_FaultDuplicateTag),
    Alternative(FaultHostClockOff, _read_FaultHostClockOff, _write_FaultHostClockOff),
    Alternative(FaultCameraFrozen, _read_FaultCameraFrozen, _write_FaultCameraFrozen),
    Alternative(FaultLensOff, _read_FaultLensOff, _write_FaultLensOff),
    Alternative(FaultObjectScaled, _read_FaultObjectScaled, _write_FaultObjectScaled),
    Alternative(FaultObjectContradicted, _read_FaultObjectContradicted, _write_FaultObjectContradicted),
    Alternative(FaultObjectUnplaced, _read_FaultObjectUnplaced, _write_FaultObjectUnplaced),
)
_ALL_Imperfection = (
    Alternative(ImperfectionCamerasDisagree, _read_ImperfectionCamerasDisagree, _write_ImperfectionCamerasDisagree),
    Alternative(ImperfectionTagOff, _read_ImperfectionTagOff, _write_ImperfectionTagOff),
    Alternative(ImperfectionSizeOff, _read_ImperfectionSizeOff, _write_ImperfectionSizeOff),
    Alternative(ImperfectionFocalLengthOff, _read_ImperfectionFocalLengthOff, _write_ImperfectionFocalLengthOff),
)
_ALL_Notice = (
    Alternative(NoticeCameraSilent, _read_NoticeCameraSilent, _write_NoticeCameraSilent),
    Alternative(NoticeLateObservations, _read_NoticeLateObservations, _write_NoticeLateObservations),
    Alternative(NoticeOverload, _read_NoticeOverload, _write_NoticeOverload),
    Alternative(NoticeUnpublished, _read_NoticeUnpublished, _write_NoticeUnpublished),
    Alternative(NoticeClockStepped, _read_NoticeClockStepped, _write_NoticeClockStepped),
    Alternative(NoticeChangeRefused, _read_NoticeChangeRefused, _write_NoticeChangeRefused),
    Alternative(NoticeNameTaken, _read_NoticeNameTaken, _write_NoticeNameTaken),
    Alternative(NoticeRefinementProposed, _read_NoticeRefinementProposed, _write_NoticeRefinementProposed),
)
_ALL_CameraNotice = (
    Alternative(CameraNoticeNoImage, _read_CameraNoticeNoImage, _write_CameraNoticeNoImage),
    Alternative(CameraNoticeNameTaken, _read_CameraNoticeNameTaken, _write_CameraNoticeNameTaken),
    Alternative(CameraNoticeImageRefused, _read_CameraNoticeImageRefused, _write_CameraNoticeImageRefused),
    Alternative(CameraNoticeNotInRig, _read_CameraNoticeNotInRig, _write_CameraNoticeNotInRig),
    Alternative(CameraNoticeModelRefused, _read_CameraNoticeModelRefused, _write_CameraNoticeModelRefused),
    Alternative(CameraNoticeTooManyTags, _read_CameraNoticeTooManyTags, _write_CameraNoticeTooManyTags),
)
_ALL_Refusal = (
    Alternative(RefusalUndecodable, _read_RefusalUndecodable, _write_RefusalUndecodable),
    Alternative(RefusalWrongId, _read_RefusalWrongId, _write_RefusalWrongId),
    Alternative(RefusalNoCamera, _read_RefusalNoCamera, _write_RefusalNoCamera),
    Alternative(RefusalInvalidCamera, _read_RefusalInvalidCamera, _write_RefusalInvalidCamera),
    Alternative(RefusalInvalidObject, _read_RefusalInvalidObject, _write_RefusalInvalidObject),
    Alternative(RefusalUnknownTag, _read_RefusalUnknownTag, _write_RefusalUnknownTag),
    Alternative(RefusalSharedTag, _read_RefusalSharedTag, _write_RefusalSharedTag),
    Alternative(RefusalTooManyObjects, _read_RefusalTooManyObjects, _write_RefusalTooManyObjects),
    Alternative(RefusalUnpublishable, _read_RefusalUnpublishable, _write_RefusalUnpublishable),
    Alternative(RefusalNotStored, _read_RefusalNotStored, _write_RefusalNotStored),
    Alternative(RefusalOther, _read_RefusalOther, _write_RefusalOther),
)

#: Every kind of message, by its number in the header.
KINDS: dict[int, Kind] = {
    1: Kind(1, 81920, Observations, _read_Observations, _write_Observations),
    2: Kind(2, 102400, Preview, _read_Preview, _write_Preview),
    3: Kind(3, 4096, DetectionReport, _read_DetectionReport, _write_DetectionReport),
    4: Kind(4, 8192, CameraStatus, _read_CameraStatus, _write_CameraStatus),
    5: Kind(5, 1024, ObjectPose, _read_ObjectPose, _write_ObjectPose),
    6: Kind(6, 16384, ObjectLinks, _read_ObjectLinks, _write_ObjectLinks),
    7: Kind(7, 1024, ObjectTruth, _read_ObjectTruth, _write_ObjectTruth),
    8: Kind(8, 131072, FusionStatus, _read_FusionStatus, _write_FusionStatus),
    9: Kind(9, 32768, ClockReport, _read_ClockReport, _write_ClockReport),
    10: Kind(10, 1024, ConfigAnswer, _read_ConfigAnswer, _write_ConfigAnswer),
    11: Kind(11, 131072, Proposal, _read_Proposal, _write_Proposal),
    12: Kind(12, 131072, RigConfig, _read_RigConfig, _write_RigConfig),
    13: Kind(13, 131072, ObjectConfig, _read_ObjectConfig, _write_ObjectConfig),
    14: Kind(14, 16384, FusionInputs, _read_FusionInputs, _write_FusionInputs),
    15: Kind(15, 1024, CameraSettings, _read_CameraSettings, _write_CameraSettings),
    16: Kind(16, 81920, Heartbeat, _read_Heartbeat, _write_Heartbeat),
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
    "Heartbeat",
    "HeartbeatHeard",
    "HeartbeatSharing",
    "HeartbeatSharingObject",
    "HeartbeatSharingObjectPart",
    "HeartbeatSharingObjectPartPreparing",
    "HeartbeatSharingObjectPartReady",
    "HeartbeatSharingObjectPartPublishing",
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
    "Imperfection",
    "ImperfectionCamerasDisagree",
    "ImperfectionTagOff",
    "ImperfectionSizeOff",
    "ImperfectionFocalLengthOff",
    "Notice",
    "NoticeCameraSilent",
    "NoticeLateObservations",
    "NoticeOverload",
    "NoticeUnpublished",
    "NoticeClockStepped",
    "NoticeChangeRefused",
    "NoticeNameTaken",
    "NoticeRefinementProposed",
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
