"""Payloads: the header of four bytes, and the message behind it."""

from __future__ import annotations

from typing import Any, Optional

from ._messages import KINDS
from ._postcard import DecodeError, EncodeError, read_message, write_message

MAGIC = 0x53
VERSION = 1
HEADER_BYTES = 4
#: Longest payload of any kind.
MAX_BYTES = max(kind.max_bytes for kind in KINDS.values())

_KIND_OF = {kind.record: kind for kind in KINDS.values()}


def decode(payload: bytes, expected: Optional[type] = None) -> Any:
    """The message of a payload; of the class `expected`, if given.

    Takes any bytes: what is no message of the contract raises `DecodeError`. Numbers are finite and lists within their
    bounds afterwards.
    """
    kind_number = _check_header(payload)
    kind = KINDS.get(kind_number)
    if kind is None:
        raise DecodeError(
            f"messages of kind {kind_number} are not known here; a newer version of this package may know them"
        )
    if expected is not None and kind.record is not expected:
        raise DecodeError(f"a {kind.record.__name__} where a {expected.__name__} was expected")
    if len(payload) > kind.max_bytes:
        raise DecodeError(f"{len(payload)} bytes are more than the {kind.max_bytes} of a {kind.record.__name__}")
    return read_message(kind.record, payload, HEADER_BYTES)


def _check_header(payload: bytes) -> int:
    if len(payload) < HEADER_BYTES or payload[0] != MAGIC:
        raise DecodeError("not a Sextant payload: it does not begin with the magic byte")
    _, version, kind, flags = payload[:HEADER_BYTES]
    if version != VERSION:
        raise DecodeError(
            f"version {version} of the contract is not known here (this is version {VERSION}): "
            "install the version of this package that goes with the site"
        )
    if flags:
        raise DecodeError(f"flags {flags:#04x} are not known here")
    return kind


def encode(message: Any) -> bytes:
    """The payload of a message. Raises `EncodeError` where a value does not fit."""
    kind = _KIND_OF.get(type(message))
    if kind is None:
        raise EncodeError(f"{type(message).__name__} is no message")
    data = bytearray((MAGIC, VERSION, kind.number, 0))
    write_message(data, message)
    if len(data) > kind.max_bytes:
        raise EncodeError(f"{len(data)} bytes are more than the {kind.max_bytes} that a message of this kind may have")
    return bytes(data)
