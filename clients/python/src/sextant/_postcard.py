"""Postcard, the byte format of the contract's messages: codecs made from the annotations of dataclasses, and the JSON
form.

Integers are varints, floats little-endian, strings and lists have their length in front, an enum is the number of its
variant. A codec is a pair of functions, made once for each type: one reads a value of any bytes, one writes it.
"""

from __future__ import annotations

import enum
import struct
from dataclasses import dataclass, fields
from functools import lru_cache
from math import isfinite
from typing import (
    Annotated,
    Any,
    Callable,
    ClassVar,
    NamedTuple,
    Sequence,
    Tuple,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

class DecodeError(ValueError):
    """A payload is not a message of this contract; says why."""


class EncodeError(ValueError):
    """A value does not fit into its message."""


@dataclass(frozen=True)
class Varint:
    """An integer of at most so many bits."""

    bits: int


@dataclass(frozen=True)
class Float:
    """A float of this form and size in bytes."""

    form: str
    size: int


@dataclass(frozen=True)
class Length:
    """Of an array: so many elements, without a length in front."""

    count: int


@dataclass(frozen=True)
class AtMost:
    """Of a list or of bytes: no more than so many elements."""

    count: int


U8 = Annotated[int, "u8"]
U16 = Annotated[int, Varint(16)]
U32 = Annotated[int, Varint(32)]
U64 = Annotated[int, Varint(64)]
F32 = Annotated[float, Float("f", 4)]
F64 = Annotated[float, Float("d", 8)]


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

    def __init_subclass__(cls, variant: str, form: str) -> None:
        cls.VARIANT, cls.FORM = variant, form


class Kind(NamedTuple):
    """A kind of message."""

    number: int
    max_bytes: int
    record: Any


def _json_of(value: Any) -> Any:
    if isinstance(value, Word):
        return value.value
    if isinstance(value, Record):
        own = fields(value)  # type: ignore[arg-type]
        content = {field.name: _json_of(getattr(value, field.name)) for field in own}
        if not isinstance(value, VariantRecord):
            return content
        if value.FORM == "unit":
            return value.VARIANT
        return {value.VARIANT: content["value"] if value.FORM == "value" else content}
    if isinstance(value, (tuple, list, bytes)):
        return [_json_of(item) for item in value]
    return value


#: The value at a place of the bytes, and the place behind it. Raises `IndexError` or `struct.error` where the bytes end
#: early.
Read = Callable[[bytes, int], Tuple[Any, int]]
#: Appends a value.
Write = Callable[[bytearray, Any], None]


class Codec(NamedTuple):
    """How values of a type are read and written."""

    read: Read
    write: Write


def read_message(record: Any, data: bytes, at: int) -> Any:
    """The message from there to the end of the bytes. Raises `DecodeError` for anything else."""
    try:
        message, at = codec(record).read(data, at)
    except (IndexError, struct.error):
        raise DecodeError("the payload ends early") from None
    if at != len(data):
        raise DecodeError(f"{len(data) - at} bytes behind the message")
    return message


def write_message(data: bytearray, message: Any) -> None:
    """Appends a message. Raises `EncodeError` where a value does not fit."""
    record: Any = type(message)
    codec(record).write(data, message)


@lru_cache(maxsize=None)
def codec(of: Any) -> Codec:
    """The codec of a type: of a class of the contract, or of an annotation in one."""
    origin, arguments = get_origin(of), get_args(of)
    if origin is Annotated:
        return _annotated(arguments[0], arguments[1])
    if origin is tuple:
        return _items(codec(arguments[0]), None)
    if origin is Union and arguments[-1] is type(None):
        return _optional(codec(Union[arguments[:-1]]))
    if origin is Union:
        return _variants(arguments)
    if of is str:
        return _STRING
    if of is bytes:
        return _blob(None)
    return _words(of) if issubclass(of, Word) else _record(of)


def _annotated(of: Any, form: Any) -> Codec:
    if form == "u8":
        return _U8
    if isinstance(form, Varint):
        return _varint(form.bits)
    if isinstance(form, Float):
        return _float(form)
    if of is bytes:
        return _blob(form.count)
    item = get_args(of)[0]
    if isinstance(form, AtMost):
        return _items(codec(item), None, form.count)
    if get_origin(item) is Annotated and isinstance(get_args(item)[1], Float):
        return _floats(get_args(item)[1], form.count)
    return _items(codec(item), form.count)


def _read_u8(data: bytes, at: int) -> tuple[int, int]:
    return data[at], at + 1


def _write_u8(out: bytearray, value: int) -> None:
    if not 0 <= value < 256:
        raise EncodeError(f"{value} does not fit into 8 bits")
    out.append(value)


_U8 = Codec(_read_u8, _write_u8)


@lru_cache(maxsize=None)
def _varint(bits: int) -> Codec:
    def read(data: bytes, at: int) -> tuple[int, int]:
        value = data[at]
        if value < 0x80:
            return value, at + 1
        value &= 0x7F
        for shift in range(7, bits, 7):
            at += 1
            byte = data[at]
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                if value >> bits:
                    break
                return value, at + 1
        raise DecodeError(f"an integer has more than {bits} bits")

    def write(out: bytearray, value: int) -> None:
        if value < 0 or value >> bits:
            raise EncodeError(f"{value} does not fit into {bits} bits")
        while value >= 0x80:
            out.append(value & 0x7F | 0x80)
            value >>= 7
        out.append(value)

    return Codec(read, write)


def _floats(form: Float, count: int) -> Codec:
    """Floats in a row."""
    layout = struct.Struct(f"<{count}{form.form}")
    size = layout.size

    def read(data: bytes, at: int) -> tuple[tuple[float, ...], int]:
        values = layout.unpack_from(data, at)
        if not all(map(isfinite, values)):
            raise DecodeError("a number is not finite")
        return values, at + size

    def write(out: bytearray, values: Sequence[float]) -> None:
        if not all(map(isfinite, values)):
            raise EncodeError("a number is not finite")
        try:
            out += layout.pack(*values)
        except (struct.error, OverflowError) as cause:
            raise EncodeError(f"{values}: {cause}") from None

    return Codec(read, write)


def _float(form: Float) -> Codec:
    floats = _floats(form, 1)

    def read(data: bytes, at: int) -> tuple[float, int]:
        (value,), at = floats.read(data, at)
        return value, at

    return Codec(read, lambda out, value: floats.write(out, (value,)))


_LENGTH = _varint(64)
_VARIANT = _varint(32)


def _read_length(data: bytes, at: int, most: int | None) -> tuple[int, int]:
    length, at = _LENGTH.read(data, at)
    # Every element takes a byte at least.
    if length > len(data) - at or (most is not None and length > most):
        raise DecodeError(f"a list has {length} elements, too many")
    return length, at


def _blob(most: int | None) -> Codec:
    def read(data: bytes, at: int) -> tuple[bytes, int]:
        length, at = _read_length(data, at, most)
        return data[at : at + length], at + length

    def write(out: bytearray, value: bytes) -> None:
        _LENGTH.write(out, len(value))
        out += value

    return Codec(read, write)


def _string() -> Codec:
    blob = _blob(None)

    def read(data: bytes, at: int) -> tuple[str, int]:
        text, at = blob.read(data, at)
        try:
            return text.decode("utf-8"), at
        except UnicodeDecodeError as cause:
            raise DecodeError(f"a text is not UTF-8: {cause}") from None

    return Codec(read, lambda out, value: blob.write(out, value.encode("utf-8")))


_STRING = _string()


def _items(item: Codec, count: int | None, most: int | None = None) -> Codec:
    """An array of so many elements, or a list, whose length stands in front."""
    read_item, write_item = item

    def read(data: bytes, at: int) -> tuple[tuple[Any, ...], int]:
        length, at = _read_length(data, at, most) if count is None else (count, at)
        values = []
        for _ in range(length):
            value, at = read_item(data, at)
            values.append(value)
        return tuple(values), at

    def write(out: bytearray, values: Sequence[Any]) -> None:
        if count is None:
            _LENGTH.write(out, len(values))
        elif len(values) != count:
            raise EncodeError(f"{len(values)} values where {count} are expected")
        for value in values:
            write_item(out, value)

    return Codec(read, write)


def _optional(item: Codec) -> Codec:
    def read(data: bytes, at: int) -> tuple[Any, int]:
        mark = data[at]
        if mark > 1:
            raise DecodeError(f"{mark} where 0 or 1 was expected")
        return item.read(data, at + 1) if mark else (None, at + 1)

    def write(out: bytearray, value: Any) -> None:
        out.append(value is not None)
        if value is not None:
            item.write(out, value)

    return Codec(read, write)


def _read_variant(data: bytes, at: int, count: int) -> tuple[int, int]:
    number, at = _VARIANT.read(data, at)
    if number >= count:
        raise DecodeError(f"variant {number} is not known here; a newer version of this package may know it")
    return number, at


def _words(of: type[Word]) -> Codec:
    words = tuple(of)

    def read(data: bytes, at: int) -> tuple[Word, int]:
        number, at = _read_variant(data, at, len(words))
        return words[number], at

    return Codec(read, lambda out, value: _VARIANT.write(out, words.index(value)))


def _variants(records: tuple[type, ...]) -> Codec:
    codecs = [_record(record) for record in records]
    numbers = {record: number for number, record in enumerate(records)}

    def read(data: bytes, at: int) -> tuple[Any, int]:
        number, at = _read_variant(data, at, len(codecs))
        return codecs[number].read(data, at)

    def write(out: bytearray, value: Any) -> None:
        number = numbers.get(type(value))
        if number is None:
            raise EncodeError(f"{type(value).__name__} is not a variant of this field")
        _VARIANT.write(out, number)
        codecs[number].write(out, value)

    return Codec(read, write)


def _record(of: type) -> Codec:
    hints = get_type_hints(of, include_extras=True)
    members = [(field.name, codec(hints[field.name])) for field in fields(of)]
    readers = [(name, member.read) for name, member in members]
    writers = [(name, member.write) for name, member in members]

    def read(data: bytes, at: int) -> tuple[Any, int]:
        # Frozen dataclasses set their fields one by one, which takes longer than reading them.
        record: Any = object.__new__(of)
        content = record.__dict__
        for name, read_member in readers:
            content[name], at = read_member(data, at)
        return record, at

    def write(out: bytearray, value: Any) -> None:
        for name, write_member in writers:
            write_member(out, getattr(value, name))

    return Codec(read, write)
