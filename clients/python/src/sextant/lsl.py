"""Poses as streams of the Lab Streaming Layer (LSL), for LabRecorder and what else reads LSL.

    python -m sextant.lsl --site demo

Each object is a stream of type `MoCap` with eight channels: position x, y, z in metres, quaternion x, y, z, w, and the
standard deviation of the position in metres (root of the sum of the variances along the three axes). The world is
Sextant's: right-handed, z up. Streams are irregular (nominal rate 0). The channels are described as in XDF's meta-data
for motion capture.

A sample is a pose that is tracked or coasting; a lost object falls silent. There is one sample per capture time, the
last estimate of it. Its time is the capture time, the middle of the exposure, mapped to LSL's clock by comparing that
clock with this machine's once a second (`LslClock`).
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from contextlib import ExitStack
from typing import Any, Callable, Iterator, Optional, Sequence

from ._messages import State
from ._pose import Pose
from ._site import Site, connect
from .errors import MissingPackageError, NoPoseError, OptionsError, SextantError

#: Streams of one program; each has threads and sockets of its own.
MAX_STREAMS = 64
#: How long the last estimate of a capture time waits for a better one, s.
HOLD_S = 0.05
#: Time between two comparisons of clocks, s.
COMPARE_S = 1.0
#: Pairs of readings of a comparison, of which the closest counts.
READINGS = 10
#: Seconds for which LSL keeps samples for a slow reader, at 100 samples a second.
BUFFER_S = 60
#: Capture times further ahead of this machine's clock are reported, s.
MAX_AHEAD_S = 0.005
#: Label, type and unit of each channel, as XDF's meta-data for motion capture names them.
CHANNELS = (
    ("X", "PositionX", "meters"),
    ("Y", "PositionY", "meters"),
    ("Z", "PositionZ", "meters"),
    ("quat_X", "OrientationX", "quaternion"),
    ("quat_Y", "OrientationY", "quaternion"),
    ("quat_Z", "OrientationZ", "quaternion"),
    ("quat_W", "OrientationW", "quaternion"),
    ("position_sigma", "PositionSigma", "meters"),
)


def _pylsl() -> Any:
    try:
        import pylsl
    except ImportError:
        raise MissingPackageError("pylsl", "lsl") from None
    except (OSError, RuntimeError) as cause:
        raise SextantError(
            f"pylsl finds no liblsl on this machine: install it, or set PYLSL_LIB to its file ({cause})"
        ) from None
    return pylsl


class LslClock:
    """Maps times of this machine's clock to LSL's clock.

    Both clocks are read in turn, `READINGS` times; the pair between whose readings the least time passed counts, which
    is right to about a microsecond. This is repeated when the last comparison is `COMPARE_S` old, so that steps and
    corrections of this machine's clock are followed. Capture times are by the clock of the cameras: the mapping is as
    good as this machine's clock agrees with theirs.
    """

    def __init__(self, local_clock: Callable[[], float], wall_ns: Callable[[], int] = time.time_ns) -> None:
        self._local_clock = local_clock
        self._wall_ns = wall_ns
        self._compare()

    def _compare(self) -> None:
        pairs = []
        for _ in range(READINGS):
            before = self._local_clock()
            wall_ns = self._wall_ns()
            after = self._local_clock()
            pairs.append((after - before, 0.5 * (before + after), wall_ns))
        _, self._local_s, self._wall = min(pairs)

    def at(self, t_ns: int) -> float:
        """The time of LSL's clock at a time of this machine's clock, ns since the Unix epoch; s."""
        if self._local_clock() - self._local_s > COMPARE_S:
            self._compare()
        # The difference first: seconds since the epoch as a float have steps of a quarter of a microsecond.
        return self._local_s + (t_ns - self._wall) * 1e-9

    def ahead_s(self, t_ns: int) -> float:
        """How far a time lies in the future of this machine, s."""
        return self.at(t_ns) - self._local_clock()


def sample_of(pose: Pose, former: Optional[Sequence[float]] = None) -> list[float]:
    """The eight channels of a pose. Of both quaternions of an attitude it has the one nearer to the former sample's."""
    quaternion = [float(part) for part in pose.orientation]
    if former is not None and sum(a * b for a, b in zip(quaternion, former[3:7])) < 0:
        quaternion = [-part for part in quaternion]
    variance = sum(float(pose.covariance[axis][axis]) for axis in range(3))
    return [*(float(part) for part in pose.position), *quaternion, math.sqrt(max(variance, 0.0))]


def latest_estimates(poses: Any, hold_s: float = HOLD_S) -> Iterator[Optional[Pose]]:
    """The last pose of each capture time, in order of time for each object; nothing while none is ready.

    A fusion node publishes an estimate after each image, so that several cameras with a common trigger give several
    poses of one instant. `poses` is a subscription that raises `NoPoseError` when none came for a while.
    """
    held: dict[str, tuple[float, Pose]] = {}
    sent: dict[str, int] = {}

    def ready(name: str) -> Pose:
        pose = held.pop(name)[1]
        sent[name] = pose.t_ns
        return pose

    while True:
        try:
            pose = next(poses)
        except StopIteration:
            break
        except NoPoseError:
            pose = None
        now = time.monotonic()
        if pose is not None and pose.t_ns > sent.get(pose.object, 0):
            waiting = held.get(pose.object)
            if waiting is not None and pose.t_ns > waiting[1].t_ns:
                yield ready(pose.object)
            if waiting is None or pose.t_ns > waiting[1].t_ns:
                held[pose.object] = (now, pose)
            elif pose.t_ns == waiting[1].t_ns:
                held[pose.object] = (waiting[0], pose)
        for name in [name for name, (since, _) in held.items() if now - since >= hold_s]:
            yield ready(name)
        yield None
    for name in list(held):
        yield ready(name)


class Outlets:
    """A stream of LSL for each object of a site, made at its first pose."""

    def __init__(self, site: str, report: Callable[[str], None] = lambda line: None) -> None:
        self._lsl = _pylsl()
        self._site = site
        self._report = report
        self._outlets: dict[str, Any] = {}
        self._former: dict[str, list[float]] = {}
        self._refused: set[str] = set()
        self._has_warned = False
        #: Clocks of this machine and of LSL.
        self.clock = LslClock(self._lsl.local_clock)
        #: Samples sent.
        self.sent = 0

    def push(self, pose: Pose) -> None:
        """Sends a pose, if it is tracked or coasting."""
        if pose.state not in (State.TRACKING, State.COASTING):
            return
        outlet = self._outlet(pose.object)
        if outlet is None:
            return
        self._check_clock(pose)
        sample = sample_of(pose, self._former.get(pose.object))
        self._former[pose.object] = sample
        outlet.push_sample(sample, self.clock.at(pose.t_ns))
        self.sent += 1

    def close(self) -> None:
        """Ends the streams."""
        self._outlets.clear()

    def _outlet(self, name: str) -> Any:
        known = self._outlets.get(name)
        if known is not None:
            return known
        if len(self._outlets) >= MAX_STREAMS:
            if not self._refused:
                self._report(
                    f"{name} and further objects are left out, {MAX_STREAMS} streams are there already: name "
                    "objects with --object"
                )
                self._refused.add(name)
            return None
        outlet = self._lsl.StreamOutlet(self._info(name), max_buffered=BUFFER_S)
        self._outlets[name] = outlet
        self._report(f"stream {self._site}/{name}")
        return outlet

    def _info(self, name: str) -> Any:
        lsl = self._lsl
        # With the same source id, readers take up a stream again after this program was restarted.
        info = lsl.StreamInfo(
            f"{self._site}/{name}",
            "MoCap",
            len(CHANNELS),
            lsl.IRREGULAR_RATE,
            lsl.cf_double64,
            f"sextant/{self._site}/{name}",
        )
        channels = info.desc().append_child("channels")
        for label, kind, unit in CHANNELS:
            channel = channels.append_child("channel")
            channel.append_child_value("label", f"{name}_{label}")
            channel.append_child_value("object", name)
            channel.append_child_value("type", kind)
            channel.append_child_value("unit", unit)
        setup = info.desc().append_child("setup")
        setup.append_child_value("name", self._site)
        setup.append_child_value("frame", "world: right-handed, z up")
        acquisition = info.desc().append_child("acquisition")
        acquisition.append_child_value("manufacturer", "Sextant")
        acquisition.append_child_value("timestamps", "middle of the exposure")
        return info

    def _check_clock(self, pose: Pose) -> None:
        ahead_s = self.clock.ahead_s(pose.t_ns)
        if ahead_s > MAX_AHEAD_S and not self._has_warned:
            self._has_warned = True
            self._report(
                f"a pose of {pose.object} lies {ahead_s:.3f} s in the future of this machine's clock: LSL gets "
                "wrong times; "
                "synchronise the clocks (deploy/clocks.md), or run this on the machine of the fusion node"
            )


def stream(
    site: Site,
    objects: Sequence[str] = (),
    *,
    duration: Optional[float] = None,
    report: Callable[[str], None] = lambda line: None,
) -> int:
    """Sends the poses of a site, or of these objects of it, until the site is closed or for `duration` seconds; the
    number of samples sent.
    """
    outlets = Outlets(site.name, report)
    end = math.inf if duration is None else time.monotonic() + duration
    wanted = set(objects)
    with ExitStack() as stack:
        stack.callback(outlets.close)
        poses = stack.enter_context(site.poses(timeout=HOLD_S))
        for pose in latest_estimates(poses):
            if pose is not None and (not wanted or pose.object in wanted):
                outlets.push(pose)
            if time.monotonic() >= end:
                break
        if poses.dropped:
            report(f"{poses.dropped} poses were dropped: this machine is too slow for them")
    return outlets.sent


def _seconds(text: str) -> float:
    seconds = float(text)
    if not (0 < seconds < math.inf):
        raise ValueError
    return seconds


def _arguments(words: Optional[Sequence[str]]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m sextant.lsl",
        description="Poses of a site as streams of the Lab Streaming Layer, one per object, until Ctrl-C.",
        epilog=(
            "Channels: x, y, z in metres, quaternion x, y, z, w, standard deviation of the position in metres. See "
            "docs/python.md."
        ),
    )
    parser.add_argument(
        "--connect",
        metavar="ENDPOINT",
        help="the site's router, such as tcp/fusion.lab:7447; by default port 7447 of this machine",
    )
    parser.add_argument("--site", default="demo", metavar="NAME", help="the site (default: demo)")
    parser.add_argument("--keys", metavar="DIR", help="keys of a viewer or an operator, where the site is protected")
    parser.add_argument(
        "--object", action="append", default=[], metavar="ID", help="send this object only; may be repeated"
    )
    parser.add_argument("--duration", type=_seconds, metavar="S", help="end after so many seconds")
    return parser.parse_args(words)


def main(words: Optional[Sequence[str]] = None) -> int:
    """Runs `python -m sextant.lsl`; the exit code."""

    def report(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    arguments = _arguments(words)
    try:
        _pylsl()
        with connect(arguments.connect, arguments.site, keys=arguments.keys) as site:
            for name in arguments.object:
                site._check_object(name)
            report(f"streaming poses of {site.name} by LSL, type MoCap; Ctrl-C ends it")
            sent = stream(site, arguments.object, duration=arguments.duration, report=report)
            report(f"{sent} samples sent")
    except KeyboardInterrupt:
        report("ended by Ctrl-C")
    except SextantError as error:
        report(f"error: {error}")
        return 2 if isinstance(error, OptionsError) else 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
