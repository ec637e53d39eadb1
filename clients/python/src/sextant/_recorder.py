"""A recording that is being made: `sextant record` as a child process."""

from __future__ import annotations

from contextlib import suppress
from typing import Optional, TypedDict

from ._command import Command
from .errors import CommandError


class RecordedFigures(TypedDict):
    """What a recording has in it."""

    file: str
    seconds: float
    #: Messages in the file.
    messages: int
    #: Images of this host's cameras.
    images: int
    bytes: int
    #: Messages and images that were not written: the disk was too slow, or they were damaged.
    dropped: int
    #: Images that came faster than they could be compressed.
    missed_images: int


class Recording:
    """Records the site until the end of its `with` statement, or `close`."""

    def __init__(self, file: str, command: Command) -> None:
        #: The file. It is complete up to the last half second at any time.
        self.file = file
        #: What is in it, after the end.
        self.figures: Optional[RecordedFigures] = None
        self._command = command
        self._lines = command.lines()
        self._is_closed = False
        if next(self._lines, None) is None:
            self.close()

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is None:
            self.close()
        else:
            # The first error matters more.
            with suppress(CommandError):
                self.close()

    def close(self) -> None:
        """Ends the recording. Raises `CommandError` where it failed; what was written before is in the file."""
        if self._is_closed:
            return
        self._is_closed = True
        self._command.finish()
        with self._command:
            for line in self._lines:
                del line["event"]
                self.figures = line
            self._command.wait()
