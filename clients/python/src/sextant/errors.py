"""What can go wrong, each with cause and remedy. All are `SextantError`s."""

from __future__ import annotations

from typing import Any, Iterable, Optional

from ._messages import (
    Refusal,
    RefusalNoCamera,
    RefusalNotStored,
    RefusalSharedTag,
    RefusalTooManyObjects,
    RefusalUnknownTag,
    RefusalWrongId,
)
from ._postcard import DecodeError, EncodeError


class SextantError(Exception):
    """Base of the errors of this package."""


class NoRouterError(SextantError, ConnectionError):
    """No router answers."""

    def __init__(self, endpoints: Iterable[str], cause: Optional[str]) -> None:
        because = f" ({cause})" if cause else ""
        super().__init__(
            f"no router answers at {', '.join(endpoints)}{because}: start the site (`sextant demo` or `sextant "
            "fusion`), "
            "or check the endpoint and the keys"
        )


class OptionsError(SextantError, ValueError):
    """Endpoint, keys or user name cannot be used, or not together."""


class InvalidNameError(SextantError, ValueError):
    """A name that no site, camera or object can have."""


class NoFusionError(SextantError, LookupError):
    """No fusion node of the site runs, so that there are no objects."""

    def __init__(self, site: str, others: list[str]) -> None:
        #: Sites of the same router, with the version of their contract where it is another: `demo`, `demo (v2)`.
        self.others = others
        if others:
            remedy = (
                f"; this router serves {', '.join(others)}: check the site's name, and that this package and the "
                "site have the same version"
            )
        else:
            remedy = ": start one (`sextant fusion`), or check the site's name"
        super().__init__(f"no fusion node runs at site {site!r}{remedy}")


class UnknownNameError(SextantError, LookupError):
    """The site has no object or camera of this name."""

    def __init__(self, what: str, name: str, site: str, known: Iterable[str]) -> None:
        #: Those that it has.
        self.known = sorted(known)
        super().__init__(f"site {site!r} has no {what} {name!r}; it has {', '.join(self.known) or 'none'}")


class NoPoseError(SextantError, TimeoutError):
    """No pose arrived in time, or none is known around a time."""


class ClosedError(SextantError):
    """The site was closed."""


class RefusedError(SextantError, ValueError):
    """The site refuses a change; nothing has changed."""

    def __init__(self, node: str, refusal: Refusal) -> None:
        #: The fusion node that decided.
        self.node = node
        #: The cause, as a message of the contract.
        self.refusal = refusal
        super().__init__(f"{node} refused: {_words(refusal)}; nothing has changed")


def _words(refusal: Refusal) -> str:
    """The words of the command line."""
    if isinstance(refusal, RefusalWrongId):
        return f"the payload describes object {refusal.described}, not that of its key"
    if isinstance(refusal, RefusalNoCamera):
        return "the rig has no camera"
    if isinstance(refusal, RefusalUnknownTag):
        return f"{refusal.tag.family} has no tag {refusal.tag.id}; its ids are 0 to {refusal.n_ids - 1}"
    if isinstance(refusal, RefusalSharedTag):
        tag = f"{refusal.tag.family}:{refusal.tag.id}"
        return (
            f"tag {tag} is on object {refusal.first} and on object {refusal.second}: print another id for one of them"
        )
    if isinstance(refusal, RefusalTooManyObjects):
        return f"a site has at most {refusal.limit} objects"
    if isinstance(refusal, RefusalNotStored):
        return f"the change cannot be written to the node's files: {refusal.detail}"
    return refusal.detail


class NoAnswerError(SextantError, TimeoutError):
    """No fusion node answers a change."""

    def __init__(self, waited: float) -> None:
        super().__init__(
            f"no fusion node has answered for {waited:.0f} s; what is in force shows whether the change was made. "
            "On a site with keys only operators may make one"
        )


class NoProgramError(SextantError, OSError):
    """The command line `sextant` is not installed, or cannot be started."""

    def __init__(self, cause: str = "there is none with this package and none on the path") -> None:
        super().__init__(
            f"the command line `sextant` cannot be started: {cause}; install a wheel that has it, or set "
            "SEXTANT_BINARY to the program"
        )


class CommandError(SextantError):
    """A command of `sextant` failed; the message is what it wrote to standard error."""

    def __init__(self, exit_code: int, words: str) -> None:
        #: As `sextant --help` lists them; negative where a signal ended it.
        self.exit_code = exit_code
        #: What `sextant.run` had received of its output.
        self.output: list[Any] = []
        words = words.strip().removeprefix("error: ")
        super().__init__(words or f"the command ended with exit code {exit_code}")


class FileError(SextantError, ValueError):
    """A file cannot be read as poses; names file and line."""


class MissingPackageError(SextantError, ImportError):
    """An optional package is needed here."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"{package} is needed for this: pip install 'sextant[{extra}]'")


__all__ = [
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
    "OptionsError",
    "RefusedError",
    "SextantError",
    "UnknownNameError",
]
