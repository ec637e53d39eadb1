"""Postcard, the byte format of the contract's messages: a reader that takes any bytes, a writer, and the JSON form.

Integers are varints, floats little-endian, strings and lists have their length in front, an enum is the number of its variant.
"""

from __future__ import annotations

import enum
import struct
from dataclasses import fields
from math import isfinite
from typing import Any, Callable, ClassVar, NamedTuple, Optional, Sequence, TypeVar

T = TypeVar("T")
W = TypeVar("W", bound="Word")


class DecodeError(ValueError):
    """A payload is not a message of this contract; says why."""


class EncodeError(ValueError):
    """A value does not fit into its message."""


class Word(str, enum.Enum):
    """An enum of names: equal to its name, and printed as it."""

    def __str__(self) -> str:
        return str(self.value)


class Record:
    """A struct of the contract."""

    def to_json(self) -> Any:
        """The message in the JSON form of the contract: dicts, lists, numbers and strings."""
        return _json_of(self)


class VariantRecord(Record):
    """A variant of an enum that holds something, or whose siblings do."""

    #: Its name in the contract.
    VARIANT: ClassVar[str]
    #: What it holds: `unit`, `value` or `fields`.
    FORM: ClassVar[str]


class Kind(NamedTuple):
    """A kind of message."""

    number: int
    max_bytes: int
    record: Any
    read: Callable[[Reader], Any]
    write: Callable[[Writer, Any], None]


class Alternative(NamedTuple):
    """A variant of an enum, by its place the number in the bytes."""

    record: Any
    read: Callable[[Reader], Any]
    write: Callable[[Writer, Any], None]


def _json_of(value: Any) -> Any:
    if isinstance(value, Word):
        return value.value
    if isinstance(value, Record):
        content = {field.name: _json_of(getattr(value, field.name)) for field in fields(value)}  # type: ignore[arg-type]
        if not isinstance(value, VariantRecord):
            return content
        if value.FORM == "unit":
            return value.VARIANT
        return {value.VARIANT: content["value"] if value.FORM == "value" else content}
    if isinstance(value, (tuple, list, bytes)):
        return [_json_of(item) for item in value]
    return value


class Reader:
    """Reads values one after the other; raises `DecodeError` at the end of the bytes and at values out of range."""

    def __init__(self, data: bytes, start: int = 0) -> None:
        self._data = data
        self._at = start

    @property
    def left(self) -> int:
        """Bytes that were not read yet."""
        return len(self._data) - self._at

    def _take(self, count: int) -> bytes:
        end = self._at + count
        if end > len(self._data):
            raise DecodeError("the payload ends early")
        taken = self._data[self._at : end]
        self._at = end
        return taken

    def u8(self) -> int:
        return self._take(1)[0]

    def _varint(self, bits: int) -> int:
        value = shift = 0
        while shift < bits:
            byte = self.u8()
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                if value >> bits:
                    break
                return value
            shift += 7
        raise DecodeError(f"an integer has more than {bits} bits")

    def u16(self) -> int:
        return self._varint(16)

    def u32(self) -> int:
        return self._varint(32)

    def u64(self) -> int:
        return self._varint(64)

    def _floats(self, form: str, size: int) -> tuple[float, ...]:
        values = struct.unpack(form, self._take(size))
        if not all(map(isfinite, values)):
            raise DecodeError("a number is not finite")
        return values

    def f32(self) -> float:
        return self._floats("<f", 4)[0]

    def f64(self) -> float:
        return self._floats("<d", 8)[0]

    def f32s(self, count: int) -> tuple[float, ...]:
        return self._floats(f"<{count}f", 4 * count)

    def f64s(self, count: int) -> tuple[float, ...]:
        return self._floats(f"<{count}d", 8 * count)

    def _length(self, most: Optional[int]) -> int:
        length = self._varint(64)
        # Every element takes a byte at least.
        if length > self.left or (most is not None and length > most):
            raise DecodeError(f"a list has {length} elements, too many")
        return length

    def blob(self, most: Optional[int] = None) -> bytes:
        return self._take(self._length(most))

    def string(self) -> str:
        try:
            return self.blob().decode("utf-8")
        except UnicodeDecodeError as cause:
            raise DecodeError(f"a text is not UTF-8: {cause}") from None

    def list(self, item: Callable[[Reader], T], most: Optional[int]) -> tuple[T, ...]:
        return self.array(item, self._length(most))

    def array(self, item: Callable[[Reader], T], count: int) -> tuple[T, ...]:
        return tuple([item(self) for _ in range(count)])

    def optional(self, item: Callable[[Reader], T]) -> Optional[T]:
        mark = self.u8()
        if mark > 1:
            raise DecodeError(f"{mark} where 0 or 1 was expected")
        return item(self) if mark else None

    def word(self, words: Sequence[W]) -> W:
        return words[self._variant(len(words))]

    def alternative(self, alternatives: Sequence[Alternative]) -> Any:
        return alternatives[self._variant(len(alternatives))].read(self)

    def _variant(self, count: int) -> int:
        number = self._varint(32)
        if number >= count:
            raise DecodeError(f"variant {number} is not known here; a newer version of this package may know it")
        return number


class Writer:
    """Writes values one after the other into `data`."""

    def __init__(self, data: bytes = b"") -> None:
        self.data = bytearray(data)

    def u8(self, value: int) -> None:
        if not 0 <= value < 256:
            raise EncodeError(f"{value} does not fit into 8 bits")
        self.data.append(value)

    def _varint(self, value: int, bits: int) -> None:
        if value < 0 or value >> bits:
            raise EncodeError(f"{value} does not fit into {bits} bits")
        while value >= 0x80:
            self.data.append(value & 0x7F | 0x80)
            value >>= 7
        self.data.append(value)

    def u16(self, value: int) -> None:
        self._varint(value, 16)

    def u32(self, value: int) -> None:
        self._varint(value, 32)

    def u64(self, value: int) -> None:
        self._varint(value, 64)

    def _floats(self, form: str, values: Sequence[float]) -> None:
        if not all(map(isfinite, values)):
            raise EncodeError("a number is not finite")
        try:
            self.data += struct.pack(form, *values)
        except (struct.error, OverflowError) as cause:
            raise EncodeError(f"{values}: {cause}") from None

    def f32(self, value: float) -> None:
        self._floats("<f", (value,))

    def f64(self, value: float) -> None:
        self._floats("<d", (value,))

    def f32s(self, values: Sequence[float], count: int) -> None:
        self._floats(f"<{count}f", values)

    def f64s(self, values: Sequence[float], count: int) -> None:
        self._floats(f"<{count}d", values)

    def blob(self, value: bytes) -> None:
        self._varint(len(value), 64)
        self.data += value

    def string(self, value: str) -> None:
        self.blob(value.encode("utf-8"))

    def list(self, item: Callable[[Writer, T], None], values: Sequence[T]) -> None:
        self._varint(len(values), 64)
        self.array(item, values, len(values))

    def array(self, item: Callable[[Writer, T], None], values: Sequence[T], count: int) -> None:
        if len(values) != count:
            raise EncodeError(f"{len(values)} values where {count} are expected")
        for value in values:
            item(self, value)

    def optional(self, item: Callable[[Writer, T], None], value: Optional[T]) -> None:
        self.data.append(value is not None)
        if value is not None:
            item(self, value)

    def word(self, words: Sequence[W], value: W) -> None:
        self._varint(words.index(value), 32)

    def alternative(self, alternatives: Sequence[Alternative], value: Any) -> None:
        for number, alternative in enumerate(alternatives):
            if type(value) is alternative.record:
                self._varint(number, 32)
                alternative.write(self, value)
                return
        raise EncodeError(f"{type(value).__name__} is not a variant of this field")
