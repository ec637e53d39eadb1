"""A running demo and a small recording, for the tests that need them; `SEXTANT_BINARY` is the program, as
`cargo xtask python-test` sets it.
"""

import json
import os
import signal
import socket
import subprocess
import threading
import time
from collections import deque
from contextlib import contextmanager
from pathlib import Path

import pytest
import sextant

#: A limit that only a broken build reaches, s.
PATIENCE = 120


@pytest.fixture(scope="session")
def binary():
    path = os.environ.get("SEXTANT_BINARY")
    if path is None:
        pytest.skip("SEXTANT_BINARY names no program: run `cargo xtask python-test`")
    return path


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def heed_ctrl_c():
    """Shells start background jobs with SIGINT ignored, and children inherit that."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextmanager
def running(*command, **options):
    process = subprocess.Popen(command, preexec_fn=heed_ctrl_c, **options)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


@pytest.fixture(scope="session")
def ready(binary):
    """What a running demo says when it is ready: its endpoint `connect` and its `page`."""
    command = (binary, "demo", "--no-browser", "--json", "--cameras", "2", "--port", str(free_port()))
    with running(*command, stdout=subprocess.PIPE, text=True) as process:
        ready = json.loads(process.stdout.readline())
        assert ready["event"] == "ready"
        yield ready


@pytest.fixture(scope="session")
def demo(ready):
    """The endpoint of a running demo."""
    return ready["connect"]


@pytest.fixture(scope="session")
def recording(binary, tmp_path_factory):
    """A folder with `poses.jsonl` of a replayed recording, and its rig and object files."""
    folder = tmp_path_factory.mktemp("recording")
    site = folder / "site"
    subprocess.run(
        [binary, "simulate", "--seconds", "1", "--cameras", "2", "--objects", "1", "--out", site], check=True
    )
    files = ["--rig", site / "rig.toml", "--object", site / "cuboid.toml"]
    subprocess.run([binary, "replay", site, *files, "--out", folder / "poses.jsonl"], check=True)
    return folder


def wait_for(condition):
    """The first true answer; fails when there is none."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        found = condition()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError("this did not come true")


def guide(name="subscribe.md"):
    """The Python blocks of a guide."""
    page = Path(__file__).parents[3] / "docs" / name
    blocks = page.read_text(encoding="utf-8").split("```")[1::2]
    return [block.removeprefix("python\n") for block in blocks if block.startswith("python\n")]


class Published:
    """The newest poses that a site has published, of every object."""

    def __init__(self, site):
        self.poses = deque(maxlen=10_000)
        self.subscription = site.poses()
        threading.Thread(target=self._collect, daemon=True).start()

    def _collect(self):
        for pose in self.subscription:
            self.poses.append(pose)

    def find(self, condition):
        """The pose that fulfils a condition, as soon as it is there."""
        return wait_for(lambda: next((pose for pose in list(self.poses) if condition(pose)), None))


@pytest.fixture(scope="module")
def published(demo):
    with sextant.connect(demo, site="demo") as site:
        yield Published(site)
