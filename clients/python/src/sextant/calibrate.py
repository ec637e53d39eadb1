"""Calibrations, by the command line: `sextant calibrate` and `sextant learn`.

Each takes a recording (a folder, or an MCAP file), or a connected site, whose images it then uses until there are
enough. Files are read and written as the command line does; options of `sextant calibrate rig --help` are arguments
(`origin="tag:3"`, `strict=True`; a list repeats an option). What could not be placed is named in the report
(`unsolved`, `undetermined`). A calibration without a result raises `CommandError`, and writes nothing.

>>> import sextant
>>> report = sextant.calibrate.rig("recording", rig="rig.toml", object="wand.toml")   # doctest: +SKIP
>>> print(report["verdict"]["grade"], report["rms_px"])   # doctest: +SKIP
"""

from __future__ import annotations

import os
from typing import Any, Callable, Optional, Sequence, TypedDict, Union

from ._command import Command, Option, Word, options
from ._site import Site
from .errors import CommandError

Path = Union[str, "os.PathLike[str]"]
#: A recording, or a connected site.
Images = Union[Path, Site]

#: Exit code of a partial result.
_PARTIAL = 4


class Verdict(TypedDict):
    """Whether a result can be used."""

    #: `good`, `usable` or `poor`.
    grade: str
    #: What limits the result, in words.
    because: list[str]


class Progress(TypedDict):
    """How far a calibration of a running site is."""

    #: `lens`, `rig` or `learn`.
    kind: str
    #: Images received.
    images: int
    #: From 0 to 1; 1 is enough.
    fraction: float
    is_enough: bool
    #: What to do next, in words.
    hint: str
    #: What this procedure alone has to show.
    details: dict[str, Any]


#: Called with progress, about once a second; where it returns true, the result is computed from the images so far.
OnProgress = Callable[[Progress], Optional[bool]]


class HeldOutModel(TypedDict):
    """Error of a lens model in images to which it was not fitted."""

    model: str
    held_out_rms_px: float


class LensUncertainty(TypedDict):
    """Standard deviation of projected rays over the image."""

    mean: float
    largest: float


class TagId(TypedDict):
    """A tag."""

    family: str
    id: int


class LensReport(TypedDict):
    """A lens."""

    camera: str
    #: Width and height of its images.
    resolution: list[int]
    #: Its model and parameters, as in the rig file.
    lens: dict[str, Any]
    #: One standard deviation each of fx, fy, cx, cy and the distortion.
    sigmas: list[float]
    rms_px: float
    #: Standard deviation of the corners, as the fit has it.
    noise_px: float
    images: int
    #: Images that were used.
    views: int
    #: Images that differ too little from those that were used.
    alike: int
    without_board: int
    tags: int
    #: Tags that are not where the board has them.
    wrong_tags: int
    #: Tags that were mostly outliers.
    suspicious: list[TagId]
    #: Simplest first.
    models: list[HeldOutModel]
    #: Share of the image's cells with a corner.
    coverage: float
    uncertainty_px: LensUncertainty
    #: Remaining errors over the image, by rows.
    cells: list[list[dict[str, Any]]]
    verdict: Verdict


class RigCamera(TypedDict):
    """A camera of a rig; standard deviations are relative to the reference camera."""

    camera: str
    images: int
    tags: int
    #: Tags left out as outliers.
    left_out: int
    sigma_mm: float
    sigma_deg: float
    sigma_axes_mm: list[float]
    sigma_axes_deg: list[float]
    rms_px: float
    #: Its clock minus the reference's; none where it was not estimated.
    clock_offset_ms: Optional[float]
    clock_sigma_ms: Optional[float]
    #: Of a rolling shutter, from a row to the next.
    line_delay_us: Optional[float]
    line_delay_sigma_us: Optional[float]


class HeldOutImages(TypedDict):
    """Residuals of images that had no part in a solution."""

    images: int
    rms_px: float
    #: The same where they had a part.
    used_rms_px: float


class RigReport(TypedDict):
    """Where the cameras are."""

    #: The camera to which standard deviations are relative.
    reference: str
    images: int
    images_used: int
    instants: int
    #: Whether cameras expose at the same time.
    synchronised: bool
    rms_px: float
    #: Corner noise as a multiple of the detector's; 1 is expected.
    noise_ratio: float
    held_out: Optional[HeldOutImages]
    cameras: list[RigCamera]
    #: Tag, images, outliers.
    tags_left_out: list[Any]
    weak: list[str]
    #: Cameras that could not be placed, with cause and remedy.
    unsolved: list[str]
    #: Where the scale comes from, in words.
    scale: str
    verdict: Verdict


class SiteCamera(TypedDict):
    """A camera of a site."""

    camera: str
    placed: bool
    images: int
    sigma_mm: float
    sigma_deg: float
    focal_px: float
    focal_sigma_px: float
    distortion_sigma_px: float
    corners_covered: float
    rms_px: float
    clock_offset_ms: Optional[float]
    clock_sigma_ms: Optional[float]
    line_delay_us: Optional[float]
    line_delay_sigma_us: Optional[float]


class SiteObject(TypedDict):
    """An object that moved."""

    object: str
    tags: list[str]
    sigma_mm: float
    sigma_deg: float
    images: int
    #: Images in which several cameras saw it.
    shared: int


class SiteReport(TypedDict):
    """Lenses, cameras, objects and clocks."""

    #: The frame of the result, in words.
    world: str
    reference: str
    images: int
    synchronised: bool
    rms_px: float
    noise_ratio: float
    held_out: Optional[HeldOutImages]
    cameras: list[SiteCamera]
    objects: list[SiteObject]
    #: Tags that never moved.
    still: list[str]
    #: Tags that move with nothing else.
    unassigned: list[str]
    #: By which measured distances corrected the given sizes.
    scale_factor: float
    scale_sigma: float
    unsolved: list[str]
    verdict: Verdict


class Parts(TypedDict):
    """A rigid motion."""

    position: list[float]
    orientation: list[float]


class HeldOutPoses(TypedDict):
    """Errors of robot poses that were predicted from the others."""

    poses: int
    rms_mm: float
    rms_deg: float
    rms_px: float
    median_mm: float
    median_deg: float


class RobotReport(TypedDict):
    """Where a robot's base is and what its hand carries."""

    images: int
    poses: int
    #: Numbers of poses that contradict the others.
    outliers: list[int]
    base_from_world: Parts
    hand_from_carried: Parts
    base_sigma_mm: float
    base_sigma_deg: float
    hand_sigma_mm: float
    hand_sigma_deg: float
    robot_sigma_mm: float
    robot_sigma_deg: float
    held_out: Optional[HeldOutPoses]
    #: The robot's clock minus that of the images.
    clock_offset_ms: Optional[float]
    clock_sigma_ms: Optional[float]
    rms_px: float
    #: What the motions leave open, with the remedy.
    undetermined: list[str]
    verdict: Verdict


class LearnedTag(TypedDict):
    """A tag of an object."""

    tag: str
    images: int
    left_out: int
    #: Images that place it elsewhere on the object.
    elsewhere: int
    sigma_mm: float
    sigma_deg: float
    sigma_axes_mm: list[float]
    sigma_axes_deg: list[float]
    rms_px: float
    #: Its size over the given one.
    size_ratio: float
    size_ratio_sigma: float


class FoundTags(TypedDict):
    """Tags that were found to move together."""

    object: list[str]
    others: list[list[str]]
    loose: list[str]
    still: list[str]


class _Learned(TypedDict):
    object: str
    images: int
    images_used: int
    rms_px: float
    noise_ratio: float
    held_out: Optional[HeldOutImages]
    tags: list[LearnedTag]
    #: Tags that kept their poses.
    kept: list[str]
    weak: list[str]
    unsolved: list[str]
    verdict: Verdict


class LearnReport(_Learned, total=False):
    """Where the tags of an object are."""

    #: Where no tags were given: tag and size, m.
    solved_sizes: list[Any]
    found: FoundTags


def lens(
    images: Images,
    *,
    board: Path,
    camera: str,
    rig: Path,
    progress: Optional[OnProgress] = None,
    **more: Option,
) -> LensReport:
    """The lens of a camera, from images of a board of tags; written into the rig file."""
    given: dict[str, Option] = {"board": board, "camera": camera, "rig": rig}
    report: LensReport = _report(["calibrate", "lens"], images, {**given, **more}, progress)
    return report


def rig(
    images: Images,
    *,
    rig: Path,
    object: Path,
    progress: Optional[OnProgress] = None,
    **more: Option,
) -> RigReport:
    """The pose of every camera, from an object that is carried about; written into the rig file, which has the lenses.
    """
    given: dict[str, Option] = {"rig": rig, "object": object}
    report: RigReport = _report(["calibrate", "rig"], images, {**given, **more}, progress)
    return report


def site(recording: Path, *, size: Union[float, Sequence[Word]], out: Path, **more: Option) -> SiteReport:
    """Lenses, camera poses, objects and clocks at once, from the sizes of tags, m; written as files into the folder
    `out`.
    """
    given: dict[str, Option] = {"size": size, "out": out}
    report: SiteReport = _report(["calibrate", "site"], recording, {**given, **more}, None)
    return report


def robot(recording: Path, *, poses: Path, rig: Path, object: Path, out: Path, **more: Option) -> RobotReport:
    """A robot's base and what its hand carries, from its poses and images; written into the file `out`."""
    given: dict[str, Option] = {"poses": poses, "rig": rig, "object": object, "out": out}
    report: RobotReport = _report(["calibrate", "robot"], recording, {**given, **more}, None)
    return report


def learn(
    images: Images,
    *,
    rig: Path,
    id: str,
    out: Path,
    progress: Optional[OnProgress] = None,
    **more: Option,
) -> LearnReport:
    """The tags of an object that is turned before a camera; written into the object file `out`."""
    given: dict[str, Option] = {"rig": rig, "id": id, "out": out}
    report: LearnReport = _report(["learn"], images, {**given, **more}, progress)
    return report


def _report(words: Sequence[Word], images: Images, given: dict[str, Option], progress: Optional[OnProgress]) -> Any:
    report = None
    source: list[Word] = ["--live"] if isinstance(images, Site) else [images]
    arguments = [*words, *source, *options(given)]
    with images._command(arguments) if isinstance(images, Site) else Command(arguments) as command:
        for line in command.lines():
            if "is_enough" not in line:
                report = line
            elif progress is not None and progress(line):
                command.finish()
        try:
            command.wait()
        except CommandError as failure:
            if report is None or failure.exit_code != _PARTIAL:
                raise
    return report


__all__ = [
    "FoundTags",
    "HeldOutModel",
    "HeldOutImages",
    "HeldOutPoses",
    "Images",
    "LearnReport",
    "LearnedTag",
    "LensReport",
    "LensUncertainty",
    "OnProgress",
    "Parts",
    "Progress",
    "RigCamera",
    "RigReport",
    "RobotReport",
    "SiteCamera",
    "SiteObject",
    "SiteReport",
    "TagId",
    "Verdict",
    "learn",
    "lens",
    "rig",
    "robot",
    "site",
]
