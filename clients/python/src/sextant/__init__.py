"""A Sextant site from Python: six-degree-of-freedom poses of tagged objects, live, with covariance; its models,
calibrations and recordings.

>>> import sextant
>>> with sextant.connect("tcp/127.0.0.1:7447", site="demo") as site:   # doctest: +SKIP
...     for pose in site.poses("cuboid"):
...         print(pose.t_ns, pose.state, pose.position)

Metres, radians, nanoseconds since the Unix epoch by the clock of the cameras; quaternions x, y, z, w; `a_from_b` maps
points of b into a. Numbers are numpy arrays where numpy is installed, tuples otherwise.
"""

from . import aio, calibrate, messages
from ._messages import Observations, State
from ._pose import Pose, Transform
from ._recorder import RecordedFigures, Recording
from ._recordings import PoseTable, read_messages, read_poses
from ._run import run
from ._site import CameraInfo, Node, ObjectInfo, Site, connect
from ._subscription import Subscription
from ._wire import decode, encode
from .errors import (
    ClosedError,
    CommandError,
    DecodeError,
    EncodeError,
    FileError,
    InvalidNameError,
    MissingPackageError,
    NoAnswerError,
    NoFusionError,
    NoPoseError,
    NoProgramError,
    NoRouterError,
    OptionsError,
    RefusedError,
    SextantError,
    UnknownNameError,
)

__all__ = [
    "CameraInfo",
    "ClosedError",
    "CommandError",
    "DecodeError",
    "EncodeError",
    "FileError",
    "InvalidNameError",
    "MissingPackageError",
    "NoAnswerError",
    "NoFusionError",
    "NoPoseError",
    "NoProgramError",
    "NoRouterError",
    "Node",
    "ObjectInfo",
    "Observations",
    "OptionsError",
    "Pose",
    "PoseTable",
    "RecordedFigures",
    "Recording",
    "RefusedError",
    "SextantError",
    "Site",
    "State",
    "Subscription",
    "Transform",
    "UnknownNameError",
    "aio",
    "calibrate",
    "connect",
    "decode",
    "encode",
    "messages",
    "read_messages",
    "read_poses",
    "run",
]
