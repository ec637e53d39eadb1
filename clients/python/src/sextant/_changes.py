"""Changes of a site: the key of each model, and the answer of the fusion node that decides."""

from __future__ import annotations

import getpass
import socket
from time import monotonic
from typing import Callable, Union

from ._messages import CameraSettings, ConfigAnswer, ObjectConfig, Proposal, RigConfig
from ._subscription import Subscription
from .errors import ClosedError, NoAnswerError

Model = Union[RigConfig, ObjectConfig, CameraSettings, Proposal]

#: How long the answer may take, s: the disk of the fusion node may be slow.
PATIENCE_S = 15.0
#: After so long the change is asked for again, s: the fusion node that decides may just have been replaced.
RETRY_S = 2.0
#: Silence after which the last answers are asked for, s: one that came early may have been missed.
POLL_S = 0.2


def key_of(model: Model) -> str:
    """The key below the site under which a change is asked for."""
    if isinstance(model, RigConfig):
        return "config/rig"
    if isinstance(model, ObjectConfig):
        return f"config/object/{model.id}"
    if isinstance(model, CameraSettings):
        return f"config/camera/{model.camera}"
    if isinstance(model, Proposal):
        return "config/models"
    raise TypeError(
        f"{type(model).__name__} is no model of a site: RigConfig, ObjectConfig, CameraSettings or Proposal is"
    )


def fnv1a(payload: bytes) -> int:
    """The 64-bit FNV-1a hash by which an answer names the payload that it answers."""
    value = 0xCBF29CE484222325
    for byte in payload:
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return value


def signature() -> str:
    """Who makes a change: what the fusion node's log and status name."""
    try:
        user = getpass.getuser()
    except (ImportError, KeyError, OSError):
        user = "somebody"
    return f"{user}@{socket.gethostname()}".encode()[:64].decode("utf-8", "ignore")


def answer_to(
    payload: bytes,
    ask: Callable[[], None],
    answers: Subscription[ConfigAnswer],
    latest: Callable[[], list[ConfigAnswer]],
) -> ConfigAnswer:
    """Asks for a change and waits for its answer, which comes by itself or, if it came too early, among the latest.

    `answers` raises `TimeoutError` when none came for `POLL_S`.
    """
    fingerprint, before = fnv1a(payload), latest()
    started, is_repeated = monotonic(), False
    ask()
    while True:
        try:
            found = [next(answers)]
        except TimeoutError:
            found = [answer for answer in latest() if answer not in before]
        except StopIteration:
            raise ClosedError("the site was closed") from None
        for answer in found:
            if answer.fingerprint == fingerprint:
                return answer
        waited = monotonic() - started
        if waited >= PATIENCE_S:
            raise NoAnswerError(waited)
        if waited >= RETRY_S and not is_repeated:
            is_repeated = True
            ask()
