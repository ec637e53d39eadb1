"""What can go wrong, each with cause and remedy. All are `SextantError`s."""

from __future__ import annotations

from typing import Iterable, Optional

from ._postcard import DecodeError, EncodeError


class SextantError(Exception):
    """Base of the errors of this package."""


class NoRouterError(SextantError, ConnectionError):
    """No router answers."""

    def __init__(self, endpoints: Iterable[str], cause: Optional[str]) -> None:
        because = f" ({cause})" if cause else ""
        super().__init__(
            f"no router answers at {', '.join(endpoints)}{because}: start the site (`sextant demo` or `sextant fusion`), "
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
                f"; this router serves {', '.join(others)}: check the site's name, and that this package and the site have the same version"
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


class FileError(SextantError, ValueError):
    """A file cannot be read as poses; names file and line."""


class MissingPackageError(SextantError, ImportError):
    """An optional package is needed here."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"{package} is needed for this: pip install 'sextant[{extra}]'")


__all__ = [
    "ClosedError",
    "DecodeError",
    "EncodeError",
    "FileError",
    "InvalidNameError",
    "MissingPackageError",
    "NoFusionError",
    "NoPoseError",
    "NoRouterError",
    "OptionsError",
    "SextantError",
    "UnknownNameError",
]
