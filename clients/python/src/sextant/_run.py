"""One command of `sextant`, on a site or without one."""

from __future__ import annotations

from typing import Any, Optional

from ._command import Command, Word
from ._site import Site
from .errors import CommandError


def run(*arguments: Word, site: Optional[Site] = None) -> list[Any]:
    """Runs `sextant` with these words and `--json` to its end and returns what it prints, a value a line; on a site, if
    one is given.

    Raises `CommandError` with the words and the exit code of a failure.

    >>> import sextant
    >>> sextant.run("detect", "image.png")   # doctest: +SKIP
    """
    with Command(arguments) if site is None else site._command(arguments) as command:
        lines = list(command.lines())
        try:
            command.wait()
        except CommandError as failure:
            failure.output = lines
            raise
    return lines
