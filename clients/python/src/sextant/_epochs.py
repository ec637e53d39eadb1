"""Which poses are used where a site has several fusion nodes: those of the newest epoch of their object."""

from __future__ import annotations

import threading
from time import monotonic
from typing import Callable

#: An epoch without a pose for so long, s, no longer keeps older ones out: its node may be in the other half of a
#: divided network.
_MEMORY_S = 2.0
#: Most objects: those of four fusion nodes. Poses of further ones are dropped.
_MOST = 4096


class EpochFilter:
    """Drops poses of epochs older than the newest one received of the same object."""

    def __init__(self, now: Callable[[], float] = monotonic) -> None:
        self._now = now
        self._newest: dict[str, tuple[int, float]] = {}
        self._lock = threading.Lock()

    def admits(self, name: str, epoch: int) -> bool:
        """Whether a pose of this epoch that arrives now is to be used."""
        now = self._now()
        with self._lock:
            newest, received = self._newest.get(name, (0, now - _MEMORY_S))
            if epoch < newest and now - received < _MEMORY_S:
                return False
            if name not in self._newest and len(self._newest) >= _MOST:
                kept = {key: value for key, value in self._newest.items() if now - value[1] < _MEMORY_S}
                self._newest = kept
                if len(kept) >= _MOST:
                    return False
            self._newest[name] = (epoch, now)
            return True
