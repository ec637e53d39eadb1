"""Against a running demo: what the guide shows, wrong inputs, the end of loops, and a site that comes back."""

import asyncio
import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy
import pytest
import sextant
import zenoh
from conftest import PATIENCE, free_port, guide, running, wait_for

GOLDEN = Path(__file__).parents[3] / "proto" / "golden"
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"


def at(endpoint, code):
    assert DEFAULT_ENDPOINT in code
    return code.replace(DEFAULT_ENDPOINT, endpoint)


def test_the_guide_has_what_is_tested_here():
    assert len(guide()) == 3


def test_the_first_lines_print_poses_until_ctrl_c(demo):
    command = [sys.executable, "-u", "-c", at(demo, guide()[0])]
    with running(*command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        lines = [process.stdout.readline() for _ in range(5)]
        for line in lines:
            t_ns, state, _ = line.split(maxsplit=2)
            assert int(t_ns) > 0 and state in list(sextant.State), line
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
        assert "KeyboardInterrupt" in errors
        assert process.returncode in (1, 130, -signal.SIGINT)


def test_ctrl_c_ends_a_loop_that_hears_nothing():
    code = "import sextant\nprint('ready', flush=True)\nfor _ in sextant.Subscription(None, None, None): pass"
    with running(sys.executable, "-c", code, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
        assert "KeyboardInterrupt" in errors


def test_the_second_example_runs(demo):
    exec(compile(at(demo, guide()[1]), "guide", "exec"), {})


def test_the_guide_to_everything_else_runs(demo, tmp_path, monkeypatch, capsys):
    blocks = [block for block in guide("python.md") if "sextant.lsl" not in block]
    assert len(blocks) == 6
    monkeypatch.chdir(tmp_path)
    for block in blocks:
        exec(compile(block.replace(DEFAULT_ENDPOINT, demo), "guide", "exec"), {})
    printed = capsys.readouterr().out
    assert "taken" in printed and "refused: the rig has no camera; nothing has changed" in printed


def test_the_third_example_reads_a_replay(recording, monkeypatch, capsys):
    monkeypatch.chdir(recording)
    exec(compile(guide()[2], "guide", "exec"), {})
    assert "30 [" in capsys.readouterr().out


def test_poses_are_what_they_say(demo):
    with sextant.connect(demo, site="demo") as site:
        pose = site.pose("cuboid", timeout=PATIENCE)
        assert pose.position.shape == (3,) and pose.orientation.shape == (4,) and pose.covariance.shape == (6, 6)
        assert numpy.linalg.norm(pose.orientation) == pytest.approx(1)
        assert (numpy.linalg.eigvalsh(pose.covariance) >= -1e-12).all()
        assert isinstance(pose.t_ns, int) and pose.state in sextant.State
        turn, shift = pose.matrix()[:3, :3], pose.matrix()[:3, 3]
        assert turn @ turn.T == pytest.approx(numpy.eye(3), abs=1e-9) and (shift == pose.position).all()
        there, back = site.transform("cuboid", "prism"), None
        back = site.transform("prism", "cuboid", t_ns=there.t_ns)
        assert there.matrix() @ back.matrix() == pytest.approx(numpy.eye(4), abs=1e-9)
        everything = site.poses(timeout=PATIENCE)
        seen = {next(everything).object for _ in range(60)}
        assert seen == set(site.objects()), "poses of all objects"


def test_asynchronous_programs_get_the_same(demo):
    async def first(site, name, count):
        found = []
        async for pose in site.poses(name, timeout=PATIENCE):
            found.append(pose)
            if len(found) == count:
                return found

    async def both(site):
        return await asyncio.gather(first(site, "cuboid", 5), first(site, "prism", 5))

    with sextant.connect(demo) as site:
        for poses in asyncio.run(both(site)):
            sequence = [pose.sequence for pose in poses]
            assert sequence == sorted(sequence)


def test_closing_a_site_ends_its_loops(demo):
    site = sextant.connect(demo)
    poses = site.poses("cuboid")
    next(poses)
    site.close()
    site.close()
    assert len(list(poses)) <= 256
    with pytest.raises(sextant.ClosedError):
        site.objects()


def test_what_does_not_exist_is_named_with_what_does(demo):
    with sextant.connect(demo) as site:
        with pytest.raises(sextant.UnknownNameError, match="no object 'sphere'; it has cuboid, frustum, prism"):
            site.poses("sphere")
        with pytest.raises(sextant.UnknownNameError, match="no camera 'attic'; it has"):
            site.observations("attic")
        with pytest.raises(sextant.InvalidNameError, match="a-z"):
            site.pose("No Name")
    with sextant.connect(demo, site="hall", timeout=0.5) as site:
        with pytest.raises(sextant.NoFusionError, match="this router serves demo"):
            site.pose("cuboid")
    nobody = f"tcp/127.0.0.1:{free_port()}"
    with pytest.raises(sextant.NoRouterError, match="refused.*start the site"):
        sextant.connect(nobody, timeout=0.5)
    for wrong in (
        {"endpoint": "nonsense"},
        {"endpoint": "quic/h:1"},
        {"user": "ann"},
        {"keys": "/nowhere"},
        {"endpoint": []},
    ):
        with pytest.raises(sextant.OptionsError):
            sextant.connect(**wrong)


class Router:
    """A fusion node of a rendered site as the router, which can go and come back."""

    def __init__(self, binary, site, folder, endpoint, security=""):
        self.file = folder / "fusion.toml"
        files = f'rig = "{site}/rig.toml"\nobjects = ["{site}/cuboid.toml"]\n'
        network = f'[network]\nmode = "router"\nlisten = ["{endpoint}"]\n'
        self.file.write_text('site = "lab"\n' + files + network + security)
        self.binary = binary

    def run(self):
        return running(self.binary, "fusion", "--config", self.file)


def test_subscriptions_go_on_when_the_site_comes_back(binary, recording, tmp_path):
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    router = Router(binary, recording / "site", tmp_path, endpoint)
    message = replace(sextant.decode((GOLDEN / "object_pose.bin").read_bytes()), object="cuboid")
    with router.run():
        site = wait_for(lambda: _connected(endpoint))
        poses = site.poses("cuboid", timeout=0.2)
        camera = zenoh.open(_client(endpoint))

        def heard(sequence):
            camera.put("sextant/v1/lab/object/cuboid/pose", sextant.encode(replace(message, sequence=sequence)))
            try:
                return next(poses).sequence == sequence
            except sextant.NoPoseError:
                return False

        wait_for(lambda: heard(1))
    wait_for(lambda: not site.is_connected)
    with pytest.raises(sextant.NoPoseError, match="out of reach"):
        while True:
            next(poses)
    with router.run():
        wait_for(lambda: heard(2))
        assert site.is_connected
        site.close()
        camera.close()


def _connected(endpoint):
    try:
        return sextant.connect(endpoint, site="lab", timeout=1)
    except sextant.NoRouterError:
        return None


def _client(endpoint):
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["{endpoint}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    return config


@pytest.mark.parametrize(("profile", "protocol"), [("lab", "tcp"), ("site", "quic")])
def test_keys_open_a_protected_site(binary, recording, tmp_path, profile, protocol):
    authority = tmp_path / "authority"
    subprocess.run([binary, "keys", "init", authority, "--site", "lab"], check=True)
    for name, role in (("fusion", "fusion"), ("screen", "viewer")):
        subprocess.run([binary, "keys", "add", authority, name, "--role", role], check=True)
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    security = f'[security]\nprofile = "{profile}"\nkeys = "{authority}/fusion"\n'
    router = Router(binary, recording / "site", tmp_path, endpoint, security)
    keys = authority / "screen"

    def member(**proof):
        try:
            return sextant.connect(endpoint, site="lab", timeout=2, **proof)
        except sextant.NoRouterError:
            return None

    with router.run():
        with wait_for(lambda: member(keys=keys)) as site:
            assert list(wait_for(site.objects)) == ["cuboid"]
        if profile == "lab":
            password = (keys / "password").read_text().strip()
            with member(user="screen.1", password=password) as site:
                assert list(site.objects()) == ["cuboid"]
                with pytest.raises(sextant.OptionsError, match="keys=DIR"):
                    site.record(tmp_path / "site.mcap")
            assert member(user="screen.1", password="wrong") is None
    with pytest.raises(sextant.OptionsError, match="of site lab, not of hall"):
        sextant.connect(endpoint, site="hall", keys=keys)
    with pytest.raises(sextant.NoRouterError, match="quic/127.0.0.1:7447"):
        sextant.connect(site="lab", keys=keys, timeout=0.5)
    os.chmod(keys / "key.pem", 0o644)
    with pytest.raises(sextant.OptionsError, match="chmod 600"):
        sextant.connect(endpoint, site="lab", keys=keys)


@pytest.mark.parametrize(
    "code",
    [
        "site.pose('cuboid')",
        "poses = site.poses('cuboid'); next(poses)",
        "poses = site.poses('cuboid'); next(poses); del poses",
        "site.pose('cuboid'); del site",
    ],
)
def test_a_program_that_closes_nothing_ends(demo, code):
    start = f"import sextant; site = sextant.connect({demo!r}); "
    subprocess.run([sys.executable, "-c", start + code], check=True, timeout=PATIENCE)
