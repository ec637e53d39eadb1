"""The pose of an object, and where one object is as seen from another."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ._arrays import matrix, vector
from ._messages import ObjectPose, State
from ._rotations import Numbers, rotation_matrix


def _motion(position: Numbers, orientation: Numbers) -> Any:
    rows = [[*row, shift] for row, shift in zip(rotation_matrix([float(part) for part in orientation]), position)]
    return matrix([*rows[0], *rows[1], *rows[2], 0.0, 0.0, 0.0, 1.0], 4)


@dataclass(frozen=True, eq=False)
class Pose:
    """Pose of an object in the world at one instant, `world_from_object`. Metres and radians; arrays of numpy where it
    is installed.
    """

    #: The object.
    object: str
    #: The instant, ns since the Unix epoch: the middle of an exposure, by the clock of the cameras.
    t_ns: int
    #: How much it can be trusted: initialising, tracking, coasting or lost. Of a lost object this is the last
    #: prediction.
    state: State
    #: The object's origin in the world, m; shape (3,).
    position: Any
    #: The object's axes in the world, quaternion x, y, z, w; shape (4,).
    orientation: Any
    #: Over (x, y, z, rx, ry, rz) in world axes about the object's origin, m and rad; shape (6, 6).
    covariance: Any = field(repr=False)
    #: Velocity of the origin and angular velocity, world axes, m/s and rad/s; shape (6,).
    twist: Any = field(repr=False)
    #: Cameras that saw the object at or shortly before this instant.
    cameras: int
    #: Tags that entered the estimate.
    tags: int
    #: Root mean square reprojection error of their corners, pixels.
    rms_px: float
    #: Which fusion node published it, of those that a site has in turn: each has a greater epoch than those before it.
    epoch: int
    #: Number of this pose since the fusion node started; gaps within an epoch are messages that were lost.
    sequence: int
    #: When the fusion node published it, ns since the Unix epoch by its own clock.
    published_ns: int

    def matrix(self) -> Any:
        """The rigid motion that maps points of the object into the world; shape (4, 4)."""
        return _motion(self.position, self.orientation)

    @classmethod
    def from_message(cls, message: ObjectPose) -> Pose:
        """The pose of a message."""
        return cls(
            object=message.object,
            t_ns=message.capture_ns,
            state=message.state,
            position=vector(message.position),
            orientation=vector(message.orientation),
            covariance=matrix(message.covariance, 6),
            twist=vector(message.twist),
            cameras=message.cameras,
            tags=message.tags,
            rms_px=message.rms_px,
            epoch=message.epoch,
            sequence=message.sequence,
            published_ns=message.published_ns,
        )


@dataclass(frozen=True, eq=False)
class Transform:
    """Pose of object b in the frame of object a at one instant, `a_from_b`."""

    #: The object whose frame it is in.
    a: str
    #: The object that is described.
    b: str
    #: The instant, ns since the Unix epoch.
    t_ns: int
    #: The state that promises less of the two.
    state: State
    #: The origin of b in a, m; shape (3,).
    position: Any
    #: The axes of b in a, quaternion x, y, z, w; shape (4,).
    orientation: Any
    #: Over (x, y, z, rx, ry, rz) in the axes of a about the origin of b; shape (6, 6). It takes the errors of both
    #: objects for independent; errors that the cameras have in common cancel in part, so that it is rather too large.
    covariance: Any = field(repr=False)

    def matrix(self) -> Any:
        """The rigid motion that maps points of b into a; shape (4, 4)."""
        return _motion(self.position, self.orientation)
