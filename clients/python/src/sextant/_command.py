"""The command line of Sextant as a child process: its JSON lines, and its errors as exceptions."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, files
from typing import Any, Iterator, Optional, Sequence, Union

from .errors import ClosedError, CommandError, NoProgramError


#: A word of a command line.
Word = Union[str, int, float, "os.PathLike[str]"]
#: The value of an option: true for one without a value, a list where it is repeated, a tuple for several words.
Option = Union[None, bool, Word, "tuple[Word, ...]", Sequence[Union[Word, "tuple[Word, ...]"]]]

#: How long a command may take to clean up after SIGTERM before it is killed, s.
GRACE_S = 3.0
#: Commands that would compute a result at SIGTERM and write it.
_CALIBRATIONS = {"calibrate", "learn"}


def program() -> str:
    """The program that runs: `SEXTANT_BINARY`, the one that was installed with this package, or the first on the path.
    """
    named = os.environ.get("SEXTANT_BINARY")
    found = named or _installed() or shutil.which("sextant")
    if found is None:
        raise NoProgramError()
    return found


def _installed() -> Optional[str]:
    with suppress(PackageNotFoundError):
        for file in files("sextant") or ():
            if file.name == "sextant" and os.access(file.locate(), os.X_OK) and os.path.isfile(file.locate()):
                return os.path.normpath(file.locate())
    return None


def options(given: dict[str, Option]) -> list[str]:
    """`origin_size=0.04` as `--origin-size 0.04`."""
    words = []
    for name, value in given.items():
        repeated = value if isinstance(value, list) else [value]
        for item in repeated:
            if item is None or item is False:
                continue
            values = () if item is True else item if isinstance(item, tuple) else (item,)
            words += [f"--{name.replace('_', '-')}", *map(_text, values)]
    return words


def _text(word: Any) -> str:
    return os.fspath(word) if isinstance(word, os.PathLike) else str(word)


class Command:
    """A running command. Ctrl-C in a terminal does not reach it: this program decides, and ends it at the end of a
    `with` statement.

    Commands of a site end by themselves, as at Ctrl-C, when this program has ended or calls `finish`. Others outlive a
    program that is killed.
    """

    def __init__(self, arguments: Sequence[Word], access: Sequence[str] = ()) -> None:
        words = [program(), "--json", *map(_text, arguments), *access]
        self._is_calibration = not _CALIBRATIONS.isdisjoint(words)
        self._errors = tempfile.TemporaryFile()
        self._is_closed = False
        try:
            self._process = subprocess.Popen(
                words,
                stdin=subprocess.PIPE if access else subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                encoding="utf-8",
                start_new_session=True,
            )
        except OSError as cause:
            self._errors.close()
            raise NoProgramError(f"{words[0]}: {cause.strerror}") from None

    def __enter__(self) -> Command:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._errors):
            if pipe is not None:
                pipe.close()

    def lines(self) -> Iterator[Any]:
        """What it prints, as it comes."""
        output = self._process.stdout
        assert output is not None
        return map(_value, output)

    def finish(self) -> None:
        """Asks a command of a site to end with what it has."""
        if self._process.stdin is not None:
            self._process.stdin.close()
            # Processes that were forked from this one may keep its input open.
            self._process.terminate()

    def wait(self) -> None:
        """Waits for its end. Raises `CommandError` where it failed."""
        code = self._process.wait()
        if code:
            if self._is_closed:
                raise ClosedError("the site was closed")
            self._errors.seek(0)
            raise CommandError(code, self._errors.read().decode("utf-8", "replace"))

    def close(self) -> None:
        """Ends it, if it still runs: kills a calibration, so that it writes nothing, and others that take too long to
        end. From any thread.
        """
        self._is_closed = True
        try:
            if not self._is_calibration:
                self._process.terminate()
                self._process.wait(GRACE_S)
        except subprocess.TimeoutExpired:
            pass
        finally:
            self._process.kill()


def _value(line: str) -> Any:
    """A few commands print text in any case, such as `completions`."""
    try:
        return json.loads(line)
    except ValueError:
        return line.rstrip("\n")
