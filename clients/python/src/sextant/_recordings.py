"""Poses and messages from files: recordings of a site (MCAP), `poses.jsonl` of `sextant replay`, and TUM."""

from __future__ import annotations

import json
import os
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterable, Iterator, Union

from ._messages import ObjectPose
from ._wire import decode
from .errors import DecodeError, FileError, MissingPackageError

MCAP_MAGIC = b"\x89MCAP"
#: Message encoding of payloads of the contract in MCAP; the topic is the key, as in the network.
MCAP_ENCODING = "sextant"
_NAN = float("nan")
_FINITE = json.JSONDecoder(parse_constant=lambda word: (_ for _ in ()).throw(ValueError(f"{word} is no number")))

PathLike = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class _Row:
    t_ns: int
    object: str
    position: Any
    orientation: Any
    covariance: Any = (_NAN,) * 36
    twist: Any = (_NAN,) * 6
    state: str = "unknown"
    cameras: int = 0
    tags: int = 0
    rms_px: float = _NAN


@dataclass(frozen=True, eq=False)
class PoseTable:
    """Poses of a file as arrays of numpy, in the order of their time; what a format does not tell is NaN, 0 or
    `unknown`.
    """

    #: Times, ns since the Unix epoch; shape (n,).
    t_ns: Any
    #: Names of the objects; shape (n,).
    object: Any
    #: Positions, m; shape (n, 3).
    position: Any
    #: Quaternions x, y, z, w; shape (n, 4).
    orientation: Any
    #: Covariances over (x, y, z, rx, ry, rz) in world axes, m and rad; shape (n, 6, 6).
    covariance: Any
    #: Velocities and angular velocities, world axes; shape (n, 6).
    twist: Any
    #: States; shape (n,).
    state: Any
    #: Cameras that saw the object; shape (n,).
    cameras: Any
    #: Tags that entered the estimate; shape (n,).
    tags: Any
    #: Reprojection errors, pixels; shape (n,).
    rms_px: Any

    def __len__(self) -> int:
        return len(self.t_ns)

    def __repr__(self) -> str:
        return f"PoseTable({len(self)} poses of {', '.join(self.objects()) or 'nothing'})"

    def objects(self) -> list[str]:
        """The objects that it has poses of."""
        return sorted({str(name) for name in self.object})

    def of(self, name: str) -> PoseTable:
        """The poses of one object."""
        chosen = self.object == name
        if not chosen.any():
            raise KeyError(f"no poses of {name!r}; there are some of {', '.join(self.objects())}")
        return PoseTable(**{column: values[chosen] for column, values in vars(self).items()})

    def to_pandas(self) -> Any:
        """A data frame with a row for each pose; sigmas are the roots of the variances."""
        try:
            import pandas
        except ImportError:
            raise MissingPackageError("pandas", "pandas") from None
        import numpy

        variances = numpy.diagonal(self.covariance, axis1=1, axis2=2)
        columns: dict[str, Any] = {"t_ns": self.t_ns, "object": self.object}
        columns.update(zip(("x", "y", "z"), self.position.T))
        columns.update(zip(("qx", "qy", "qz", "qw"), self.orientation.T))
        columns.update(zip(("vx", "vy", "vz", "wx", "wy", "wz"), self.twist.T))
        sigmas = ("sigma_x", "sigma_y", "sigma_z", "sigma_rx", "sigma_ry", "sigma_rz")
        columns.update(zip(sigmas, numpy.sqrt(variances).T))
        columns.update(state=self.state, cameras=self.cameras, tags=self.tags, rms_px=self.rms_px)
        index = pandas.to_datetime(self.t_ns, utc=True).rename("time")
        return pandas.DataFrame(columns, index=index)


def read_poses(path: PathLike) -> PoseTable:
    """The poses of a file: an MCAP recording, `poses.jsonl`, or TUM's `timestamp tx ty tz qx qy qz qw`.

    The content tells which it is. A recording that ends in the middle, because its program was killed, gives the poses
    before that. Poses of a TUM file are of an object named after the file. Raises `FileError` with file and line.
    """
    file = Path(path)
    with file.open("rb") as stream:
        start = stream.read(64)
    if start.startswith(MCAP_MAGIC):
        rows = _mcap_rows(file)
    elif start.lstrip().startswith(b"{"):
        rows = _rows_of_lines(file, _json_row)
    else:
        rows = _rows_of_lines(file, _tum_row)
    return _table(rows)


def read_messages(path: PathLike) -> Iterator[tuple[int, str, Any]]:
    """Time of arrival in ns, key and message of every payload in an MCAP recording, in the order of the file.

    Images and messages for viewers are passed over, and so are kinds of messages that this version does not know.
    """
    try:
        from mcap.exceptions import EndOfFile, McapError
        from mcap.stream_reader import StreamReader
        from mcap.records import Channel, Message
    except ImportError:
        raise MissingPackageError("mcap", "mcap") from None
    channels: dict[int, Any] = {}
    with Path(path).open("rb") as stream:
        try:
            for record in StreamReader(stream).records:
                if isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Message):
                    channel = channels.get(record.channel_id)
                    if channel is None or channel.message_encoding != MCAP_ENCODING:
                        continue
                    try:
                        message = decode(record.data)
                    except DecodeError:
                        continue
                    yield record.log_time, channel.topic, message
        except (EndOfFile, struct.error):
            # Its program was killed; what it wrote before is whole. Where the cut goes through a number, the reader
            # fails at that.
            return
        except McapError as cause:
            raise FileError(f"{path}: {cause!r}") from None


def _mcap_rows(file: Path) -> Iterator[_Row]:
    for _, _, message in read_messages(file):
        if isinstance(message, ObjectPose):
            yield _Row(
                message.capture_ns,
                message.object,
                message.position,
                message.orientation,
                message.covariance,
                message.twist,
                message.state.value,
                message.cameras,
                message.tags,
                message.rms_px,
            )


def _rows_of_lines(file: Path, read: Any) -> Iterator[_Row]:
    with file.open(encoding="utf-8") as lines:
        try:
            for number, line in enumerate(lines, 1):
                text = line.strip()
                if text and not text.startswith("#"):
                    try:
                        yield read(text, file.stem)
                    except (ValueError, KeyError, TypeError) as cause:
                        what = f"{cause} is missing" if isinstance(cause, KeyError) else str(cause)
                        raise FileError(f"{file}:{number}: {what}") from None
        except UnicodeDecodeError as cause:
            raise FileError(f"{file}: neither an MCAP recording nor text: {cause}") from None


def _json_row(text: str, _: str) -> _Row:
    line = _FINITE.decode(text)
    return _Row(
        int(line["t_ns"]),
        str(line["object"]),
        _numbers(line["position"], 3),
        _numbers(line["orientation"], 4),
        _numbers(line["covariance"], 36),
        _numbers(line["twist"], 6),
        str(line["state"]),
        int(line["cameras"]),
        int(line["tags"]),
        float(line["rms_px"]),
    )


def _tum_row(text: str, name: str) -> _Row:
    stamp, *rest = text.split()
    numbers = _numbers([float(part) for part in rest], 7)
    return _Row(_nanoseconds(stamp), name, numbers[:3], numbers[3:])


def _nanoseconds(stamp: str) -> int:
    """Seconds as text, to the nanosecond: a float has 240 ns at today's times."""
    seconds, _, fraction = stamp.partition(".")
    if not (seconds + fraction).isdecimal():
        return round(float(stamp) * 1e9)
    return int(seconds) * 1_000_000_000 + int(fraction[:9].ljust(9, "0"))


def _numbers(values: Any, count: int) -> tuple[float, ...]:
    numbers = tuple(float(value) for value in values)
    if len(numbers) != count:
        raise ValueError(f"{len(numbers)} numbers where {count} are expected")
    return numbers


def _table(rows: Iterable[_Row]) -> PoseTable:
    try:
        import numpy
    except ImportError:
        raise MissingPackageError("numpy", "numpy") from None
    ordered = sorted(rows, key=lambda row: row.t_ns)

    def column(name: str, kind: Any = float, shape: tuple[int, ...] = ()) -> Any:
        values = [getattr(row, name) for row in ordered]
        return numpy.array(values, dtype=kind).reshape(-1, *shape) if shape else numpy.array(values, dtype=kind)

    return PoseTable(
        t_ns=column("t_ns", numpy.int64),
        object=column("object", object),
        position=column("position", shape=(3,)),
        orientation=column("orientation", shape=(4,)),
        covariance=column("covariance", shape=(6, 6)),
        twist=column("twist", shape=(6,)),
        state=column("state", object),
        cameras=column("cameras", numpy.int64),
        tags=column("tags", numpy.int64),
        rms_px=column("rms_px"),
    )
