"""`sextant convert --to wpilib`, read by WPILib's own `AprilTagFieldLayout`: tags look where the object file says."""

import subprocess

import numpy
import pytest

FIELD = """id = "field"

[[tag]]
family = "tag36h11"
id = 1
size = 0.1651
# Its face looks along -y of the field, upright.
object_from_tag = { position = [15.0, 8.0, 1.5], orientation = [0.7071067811865476, 0.0, 0.0, 0.7071067811865476] }

[[tag]]
family = "tag36h11"
id = 2
size = 0.1651
# Its face looks along x.
object_from_tag = { position = [0.0, 4.0, 1.25], orientation = [0.5, 0.5, 0.5, 0.5] }
"""


def test_wpilib_reads_a_layout(binary, tmp_path):
    robotpy_apriltag = pytest.importorskip("robotpy_apriltag")
    file, layout = tmp_path / "field.toml", tmp_path / "field.json"
    file.write_text(FIELD, encoding="utf-8")
    subprocess.run([binary, "convert", file, "--to", "wpilib", "--field", "16.541,8.069", "--out", layout], check=True)
    read = robotpy_apriltag.AprilTagFieldLayout(str(layout))
    assert read.getFieldLength() == pytest.approx(16.541) and read.getFieldWidth() == pytest.approx(8.069)
    assert sorted(tag.ID for tag in read.getTags()) == [1, 2]
    for number, place, faces in [(1, (15.0, 8.0, 1.5), (0, -1, 0)), (2, (0.0, 4.0, 1.25), (1, 0, 0))]:
        pose = read.getTagPose(number)
        assert numpy.allclose([pose.X(), pose.Y(), pose.Z()], place, atol=1e-12)
        # WPILib's tags look along their x, with z up.
        turned = matrix(pose.rotation().getQuaternion())
        assert numpy.allclose(turned[:, 0], faces, atol=1e-9)
        assert numpy.allclose(turned[:, 2], [0, 0, 1], atol=1e-9)


def matrix(quaternion):
    w, x, y, z = quaternion.W(), quaternion.X(), quaternion.Y(), quaternion.Z()
    return numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_a_layout_needs_the_size_of_the_field(binary, tmp_path):
    file = tmp_path / "field.toml"
    file.write_text(FIELD, encoding="utf-8")
    failed = subprocess.run([binary, "convert", file, "--to", "wpilib"], capture_output=True, text=True, check=False)
    assert failed.returncode == 2 and "--field 16.541,8.069" in failed.stderr
