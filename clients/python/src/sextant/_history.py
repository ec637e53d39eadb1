"""The last poses of one object, in the order of their time, within bounds."""

from __future__ import annotations

import threading
from bisect import bisect_left
from time import monotonic
from typing import Optional

from ._estimates import interpolate
from ._messages import ObjectPose
from .errors import ClosedError, NoPoseError

#: How long poses are kept, by their own time, s.
KEPT_S = 10
#: Most poses of one object.
CAPACITY = 2048
#: Longest interval that is interpolated, ns: the motion in a longer one is unknown.
LONGEST_GAP_NS = 500_000_000
#: A newest pose that came longer ago than this is no longer where the object is, s.
FRESH_S = 1.0

_KEPT_NS = KEPT_S * 1_000_000_000
_GLANCE = 0.5


class History:
    """Filled by the network, read by anyone."""

    def __init__(self) -> None:
        self._poses: list[ObjectPose] = []
        self._times: list[int] = []
        self._last_arrival: Optional[float] = None
        self._closed = False
        self._arrival = threading.Condition()

    def insert(self, pose: ObjectPose) -> None:
        with self._arrival:
            self._insert(pose)
            self._last_arrival = monotonic()
            self._arrival.notify_all()

    def _insert(self, pose: ObjectPose) -> None:
        t_ns = pose.capture_ns
        if self._times and t_ns + _KEPT_NS < self._times[-1]:
            # A clock was set back, or another recording plays: what is kept belongs to another time.
            self._times.clear()
            self._poses.clear()
        place = bisect_left(self._times, t_ns)
        if place < len(self._times) and self._times[place] == t_ns:
            self._poses[place] = pose
            return
        self._times.insert(place, t_ns)
        self._poses.insert(place, pose)
        oldest = max(bisect_left(self._times, self._times[-1] - _KEPT_NS), len(self._times) - CAPACITY)
        del self._times[:oldest], self._poses[:oldest]

    def silent_s(self) -> Optional[float]:
        """How long ago the last pose came."""
        last = self._last_arrival
        return None if last is None else monotonic() - last

    def oldest_ns(self) -> int:
        """Time of the oldest pose in the history; 0 without one."""
        with self._arrival:
            return self._times[0] if self._times else 0

    def newest(self, deadline: float) -> Optional[ObjectPose]:
        """The newest pose, unless it is older than a second; waits for one until `deadline`."""
        with self._arrival:
            while True:
                silent = self.silent_s()
                if silent is not None and silent <= FRESH_S:
                    return self._poses[-1]
                if not self._wait(deadline):
                    return None

    def at(self, name: str, t_ns: int, deadline: float) -> ObjectPose:
        """The pose at a time, interpolated; waits until `deadline` for poses after that time."""
        with self._arrival:
            while not (self._times and self._times[-1] >= t_ns) and self._wait(deadline):
                pass
            return self._interpolated(name, t_ns)

    def close(self) -> None:
        """Ends whatever waits."""
        with self._arrival:
            self._closed = True
            self._arrival.notify_all()

    def _wait(self, deadline: float) -> bool:
        if self._closed:
            raise ClosedError("the site was closed")
        left = deadline - monotonic()
        if left > 0:
            self._arrival.wait(min(left, _GLANCE))
        return left > 0

    def _interpolated(self, name: str, t_ns: int) -> ObjectPose:
        place = bisect_left(self._times, t_ns)
        is_known = place < len(self._times)
        if is_known and self._times[place] == t_ns:
            return self._poses[place]
        if not is_known or place == 0:
            known = f"known from {self._times[0]} to {self._times[-1]}" if self._times else "none is known yet"
            raise NoPoseError(
                f"no pose of {name!r} at {t_ns}: {known}; poses are kept for {KEPT_S} s from the first request "
                "for this object"
            )
        before, after = self._poses[place - 1], self._poses[place]
        gap_ns = after.capture_ns - before.capture_ns
        if gap_ns > LONGEST_GAP_NS:
            raise NoPoseError(
                f"no pose of {name!r} at {t_ns}: its poses around that time are {gap_ns * 1e-9:.3f} s apart, "
                "too far to interpolate"
            )
        return interpolate(before, after, t_ns)
