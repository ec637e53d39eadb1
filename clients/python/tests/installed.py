"""What `pip install sextant` gives, tried in the environment that runs this: the command line, poses of its demo, a
change, a recording and a calibration. For `cargo xtask wheel`.
"""

import asyncio
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import sextant

#: For what takes a moment on any machine, s.
PATIENCE = 60


async def first_poses(endpoint: str) -> "list[sextant.Pose]":
    found = []
    async with sextant.aio.connect(endpoint, timeout=PATIENCE) as site:
        async for pose in site.poses("cuboid", timeout=PATIENCE):
            found.append(pose)
            if len(found) == 5:
                break
    return found


def main() -> None:
    version = subprocess.run(["sextant", "--version"], check=True, capture_output=True, text=True).stdout
    print(version.strip(), "and Python", sys.version.split()[0])
    folder = Path(tempfile.mkdtemp())
    command = ["sextant", "demo", "--no-browser", "--json", "--cameras", "2", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as demo:
        try:
            assert demo.stdout is not None
            endpoint = json.loads(demo.stdout.readline())["connect"]
            for pose in asyncio.run(first_poses(endpoint)):
                print(pose.t_ns, pose.state, *(f"{part:.3f}" for part in pose.position))
            with sextant.connect(endpoint) as site:
                print("set:", site.set(site.rig()).outcome.to_json())
                with site.record(folder / "site.mcap") as recording:
                    next(site.poses("cuboid", timeout=PATIENCE))
                print("recorded:", recording.figures)
        finally:
            demo.terminate()
    sextant.run("simulate", "--out", folder / "site", "--seconds", 3, "--cameras", 2, "--objects", 1)
    report = sextant.calibrate.rig(folder / "site", rig=folder / "site/rig.toml", object=folder / "site/cuboid.toml")
    print("calibrated:", report["verdict"])


if __name__ == "__main__":
    main()
