"""A replay as a C3D file, read by ezc3d: points and rotations are the poses of the same replay as JSON lines."""

import json
import subprocess

import ezc3d
import numpy


def test_a_replay_is_read_as_points_and_rotations(binary, recording):
    site, file = recording / "site", recording / "poses.c3d"
    files = ["--rig", site / "rig.toml", "--object", site / "cuboid.toml"]
    subprocess.run([binary, "replay", site, *files, "--out", file], check=True)
    lines = (recording / "poses.jsonl").read_text(encoding="utf-8").splitlines()
    poses = {pose["t_ns"]: pose for pose in map(json.loads, lines) if pose["state"] == "tracking"}

    c3d = ezc3d.c3d(str(file))
    point, rotation = c3d["parameters"]["POINT"], c3d["parameters"]["ROTATION"]
    assert point["LABELS"]["value"] == rotation["LABELS"]["value"] == ["cuboid"] and point["UNITS"]["value"] == ["mm"]
    start_ns = int(c3d["parameters"]["MANUFACTURER"]["START_TIME_NS"]["value"][0])
    points, residuals, rotations = (
        c3d["data"]["points"],
        c3d["data"]["meta_points"]["residuals"],
        c3d["data"]["rotations"],
    )
    assert points.shape[2] == rotations.shape[3] == c3d["header"]["points"]["last_frame"] + 1
    times = start_ns + numpy.arange(points.shape[2]) / point["RATE"]["value"][0] * 1e9

    assert len(poses) > 20
    for t_ns, pose in poses.items():
        frame = numpy.argmin(abs(times - t_ns))
        assert abs(times[frame] - t_ns) < 2e6
        assert numpy.allclose(points[:3, 0, frame], numpy.multiply(pose["position"], 1000), rtol=1e-7)
        assert residuals[0, 0, frame] == 0
        x, y, z, w = pose["orientation"]
        first = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
        assert numpy.allclose(rotations[:3, 0, 0, frame], first, atol=1e-6)
        assert numpy.allclose(rotations[:, 3, 0, frame], [*points[:3, 0, frame], 1])
    untracked = [frame for frame, t in enumerate(times) if min(abs(t - t_ns) for t_ns in poses) > 2e7]
    assert all(residuals[0, 0, frame] == -1 for frame in untracked)
