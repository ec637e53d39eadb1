"""The messages of the wire contract: a class for each type of proto/CONTRACT.md."""

from ._messages import *  # noqa: F403
from ._messages import KINDS, __all__

__all__ = [*__all__, "KINDS"]
