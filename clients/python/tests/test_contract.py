"""The bytes of the contract: the files that the Rust code is tested with."""

import json
import math
import struct
from dataclasses import replace
from pathlib import Path

import pytest
import sextant

GOLDEN = Path(__file__).parents[3] / "proto" / "golden"
NAMES = sorted(file.stem for file in GOLDEN.glob("*.bin"))


def single(number):
    return struct.unpack("<f", struct.pack("<f", number))[0]


def same(ours, theirs):
    """Whether the JSON forms are the same; an f32 is written with fewer digits there."""
    if isinstance(theirs, dict):
        return list(ours) == list(theirs) and all(same(ours[key], theirs[key]) for key in theirs)
    if isinstance(theirs, list):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    if isinstance(theirs, float):
        return ours == theirs or ours == single(theirs)
    return ours == theirs


def test_there_is_a_file_of_every_kind():
    kinds = {(GOLDEN / f"{name}.bin").read_bytes()[2] for name in NAMES}
    assert kinds == set(sextant.messages.KINDS)


@pytest.mark.parametrize("name", NAMES)
def test_the_bytes_are_the_message_and_the_message_the_bytes(name):
    payload = (GOLDEN / f"{name}.bin").read_bytes()
    message = sextant.decode(payload)
    expected = json.loads((GOLDEN / f"{name}.json").read_text())
    assert same(message.to_json(), expected)
    assert sextant.encode(message) == payload


@pytest.mark.parametrize("name", NAMES)
def test_any_change_gives_a_message_or_an_error(name):
    payload = (GOLDEN / f"{name}.bin").read_bytes()
    step = max(1, len(payload) // 200)
    for at in range(0, len(payload), step):
        for changed in (payload[:at], payload[:at] + bytes([payload[at] ^ 0xFF]) + payload[at + 1 :]):
            try:
                message = sextant.decode(changed)
            except sextant.DecodeError:
                continue
            assert sextant.encode(message)
    with pytest.raises(sextant.DecodeError, match="behind"):
        sextant.decode(payload + b"\0")


def test_a_foreign_version_says_what_to_do():
    payload = bytearray((GOLDEN / "object_pose.bin").read_bytes())
    payload[1] = 2
    with pytest.raises(sextant.DecodeError, match="version 2 .* install"):
        sextant.decode(bytes(payload))


def test_a_long_list_is_refused_before_it_is_read():
    header = bytes([0x53, 1, 8, 0])
    # A FusionStatus whose node has a name of 2^63 bytes.
    with pytest.raises(sextant.DecodeError, match="too many"):
        sextant.decode(header + b"\xff\xff\xff\xff\xff\xff\xff\xff\x7f")


def test_what_does_not_fit_is_not_encoded():
    pose = sextant.decode((GOLDEN / "object_pose.bin").read_bytes())
    for wrong in ({"cameras": 70000}, {"position": (0.0, 0.0)}, {"rms_px": math.nan}, {"sequence": -1}):
        with pytest.raises(sextant.EncodeError):
            sextant.encode(replace(pose, **wrong))
    with pytest.raises(sextant.EncodeError):
        sextant.encode("pose")


def test_words_are_their_names():
    pose = sextant.decode((GOLDEN / "object_pose.bin").read_bytes())
    assert pose.state == str(pose.state) == f"{pose.state}" == pose.state.value
    assert pose.state in sextant.State
