"""Files of poses."""

import json
from pathlib import Path

import numpy
import pytest
import sextant
from mcap.writer import Writer

GOLDEN = Path(__file__).parents[3] / "proto" / "golden"
START = 1_800_000_000_123_456_789


def line(t_ns, **changes):
    pose = {
        "t_ns": t_ns,
        "object": "cube",
        "position": [1.0, 2.0, 3.0],
        "orientation": [0.0, 0.0, 0.0, 1.0],
        "covariance": list((numpy.eye(6) * 4e-6).ravel()),
        "twist": [0.0] * 6,
        "state": "tracking",
        "cameras": 2,
        "tags": 3,
        "rms_px": 0.125,
    }
    return json.dumps({**pose, **changes})


def test_poses_as_lines_of_json(tmp_path):
    file = tmp_path / "poses.jsonl"
    file.write_text("\n".join([line(START + 2), line(START, object="box"), ""]))
    poses = sextant.read_poses(file)
    assert list(poses.t_ns) == [START, START + 2]
    assert poses.covariance.shape == (2, 6, 6)
    assert poses.objects() == ["box", "cube"]
    assert len(poses.of("cube")) == 1
    with pytest.raises(KeyError, match="box, cube"):
        poses.of("ball")
    table = poses.to_pandas()
    assert table["sigma_x"].iloc[0] == pytest.approx(2e-3)
    assert table.index[0].value == START and list(table["z"]) == [3.0, 3.0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (line(START, position=[1, 2]), "2 numbers where 3"),
        (line(START).replace("1.0", "NaN", 1), "NaN is no number"),
        (line(START).replace("t_ns", "time"), "'t_ns' is missing"),
        (line(START)[:40], "poses.jsonl:2"),
    ],
)
def test_a_wrong_line_is_named(tmp_path, text, words):
    file = tmp_path / "poses.jsonl"
    file.write_text(line(START) + "\n" + text + "\n")
    with pytest.raises(sextant.FileError, match="poses.jsonl:2") as raised:
        sextant.read_poses(file)
    assert words in str(raised.value)


def test_poses_of_tum_keep_their_nanoseconds(tmp_path):
    file = tmp_path / "cube.tum"
    file.write_text("# timestamp tx ty tz qx qy qz qw\n1800000000.123456789 1 2 3 0 0 0 1\n1.8e9 1 2 3 0 0 0 1\n")
    poses = sextant.read_poses(file)
    assert list(poses.t_ns) == [1_800_000_000_000_000_000, START]
    assert poses.objects() == ["cube"]
    assert numpy.isnan(poses.covariance).all()
    file.write_text("1.0 2.0\n")
    with pytest.raises(sextant.FileError, match="cube.tum:1: 1 numbers where 7"):
        sextant.read_poses(file)


def record(file, payloads):
    with file.open("wb") as stream:
        writer = Writer(stream, chunk_size=4096)
        writer.start()
        schema = writer.register_schema("ObjectPose", "", b"")
        channel = writer.register_channel("sextant/v1/demo/object/cube/pose", "sextant", schema)
        other = writer.register_channel("/tf", "json", schema)
        for number, payload in enumerate(payloads):
            writer.add_message(other, number, b"{}", number)
            writer.add_message(channel, number, payload, number)
        writer.finish()


def test_poses_of_a_recording_whole_and_cut_off(tmp_path):
    pose = sextant.decode((GOLDEN / "object_pose.bin").read_bytes())
    payloads = [sextant.encode(pose), b"damaged"] * 200
    file = tmp_path / "site.mcap"
    record(file, payloads)
    whole = sextant.read_poses(file)
    assert len(whole) == 200 and whole.objects() == [pose.object]
    assert tuple(whole.position[0]) == pose.position
    times, keys, _ = zip(*sextant.read_messages(file))
    assert times[1] == 2 and set(keys) == {"sextant/v1/demo/object/cube/pose"}
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    assert 0 < len(sextant.read_poses(file)) < 200


def test_what_is_neither_is_refused(tmp_path):
    file = tmp_path / "picture.png"
    file.write_bytes(b"\x89PNG\r\n\x1a\n\x00\xff\xfe")
    with pytest.raises(sextant.FileError, match="neither"):
        sextant.read_poses(file)
    file.write_bytes(b"\x89MCAP0\r\n" + b"\xff" * 100)
    with pytest.raises((sextant.FileError, ValueError)):
        list(sextant.read_messages(file))
