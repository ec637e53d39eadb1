"""Without numpy everything but files of poses works, with tuples."""

import subprocess
import sys

CODE = """
import sys
sys.modules["numpy"] = None
import sextant
with sextant.connect(sys.argv[1]) as site:
    pose = site.pose("cuboid", timeout=60)
    assert type(pose.position) is tuple and len(pose.covariance) == 6 and len(pose.matrix()[3]) == 4
    assert len(site.transform("cuboid", "prism").covariance[0]) == 6
try:
    sextant.read_poses(sys.argv[2])
except sextant.MissingPackageError as cause:
    print(cause)
"""


def test_without_numpy_there_are_tuples(demo, recording):
    command = [sys.executable, "-c", CODE, demo, recording / "poses.jsonl"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "pip install 'sextant[numpy]'" in output
