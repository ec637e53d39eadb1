"""`python -m sextant.lsl` on a running demo, read by pylsl's inlets: samples are the poses of the site's objects at
their capture times by LSL's clock.
"""

import subprocess
import sys
import time

import numpy
import pytest
import sextant
from conftest import guide, running, wait_for
from sextant import lsl


def pose(t_ns, orientation=(0.0, 0.0, 0.0, 1.0), name="cube", x=0.0):
    state = sextant.State.TRACKING
    rest = dict(cameras=1, tags=1, rms_px=0.1, epoch=1, sequence=1, published_ns=t_ns)
    covariance = numpy.diag([1.0, 4.0, 4.0, 1.0, 1.0, 1.0]) * 1e-6
    return sextant.Pose(name, t_ns, state, (x, 2.0, 3.0), orientation, covariance, (0.0,) * 6, **rest)


def pylsl():
    try:
        import pylsl
    except (ImportError, OSError, RuntimeError) as cause:
        pytest.skip(f"pylsl is not there: {cause}")
    return pylsl


class Fake:
    """Two clocks that run alike; reading the wall clock takes long now and then."""

    def __init__(self):
        self.local_s, self.wall_ns, self.reads = 100.0, 1_800_000_000_000_000_000, 0

    def local(self):
        return self.local_s

    def wall(self):
        self.reads += 1
        self.pass_s(0.01 if self.reads % 3 else 1e-6)
        now = self.wall_ns
        self.pass_s(1e-6)
        return now

    def pass_s(self, seconds):
        self.local_s += seconds
        self.wall_ns += round(seconds * 1e9)


def test_the_clock_follows_this_machines_clock_and_its_steps():
    fake = Fake()
    clock = lsl.LslClock(fake.local, fake.wall)

    def difference():
        # It may compare clocks, which takes time.
        clock.at(fake.wall_ns)
        return clock.at(fake.wall_ns) - fake.local_s

    assert abs(difference()) < 2e-6
    fake.wall_ns += 5_000_000_000
    assert abs(difference() - 5) < 2e-6
    fake.pass_s(1.5)
    assert abs(difference()) < 2e-6
    assert abs(clock.ahead_s(fake.wall_ns + 20_000_000) - 0.02) < 2e-6


def test_the_last_estimate_of_each_capture_time_is_given_once():
    poses = [
        pose(10, x=1.0),
        pose(10, x=2.0),
        pose(5),
        pose(20, x=3.0),
        pose(10),
        pose(20, x=4.0),
        pose(15, name="ball"),
    ]
    found = [(p.object, p.t_ns, p.position[0]) for p in lsl.latest_estimates(iter(poses), hold_s=60) if p is not None]
    assert found == [("cube", 10, 2.0), ("cube", 20, 4.0), ("ball", 15, 0.0)]


def test_an_estimate_does_not_wait_for_the_next_one():
    class Silent:
        def __init__(self):
            self.poses = [pose(10)]

        def __next__(self):
            if self.poses:
                return self.poses.pop()
            raise sextant.NoPoseError

    given = lsl.latest_estimates(Silent(), hold_s=0.0)
    assert next(given).t_ns == 10
    given = lsl.latest_estimates(Silent(), hold_s=0.01)
    assert wait_for(lambda: next(given)).t_ns == 10


def test_quaternions_do_not_change_their_sign():
    first = lsl.sample_of(pose(1))
    assert first == pytest.approx([0, 2, 3, 0, 0, 0, 1, 3e-3])
    second = lsl.sample_of(pose(2, (0.0, 0.0, -0.1, -0.99)), first)
    assert second[5:7] == [0.1, 0.99]


def inlet(pylsl, name):
    found = wait_for(lambda: pylsl.resolve_byprop("name", name, timeout=5))
    inlet = pylsl.StreamInlet(found[0])
    inlet.open_stream(timeout=30)
    return inlet


def test_an_inlet_gets_poses_at_their_capture_time(demo, published):
    module = pylsl()
    command = [sys.executable, "-m", "sextant.lsl", "--connect", demo, "--site", "demo", "--object", "cuboid"]
    with running(*command, stderr=subprocess.PIPE, text=True) as process:
        assert "streaming poses of demo" in process.stderr.readline()
        # liblsl writes there, too.
        assert any(line == "stream demo/cuboid\n" for line in process.stderr)
        stream = inlet(module, "demo/cuboid")
        info = stream.info(timeout=30)
        assert (info.type(), info.nominal_srate(), info.channel_count()) == ("MoCap", 0.0, 8)
        assert info.source_id() == "sextant/demo/cuboid"
        channels = info.desc().child("channels").child("channel")
        described = []
        while not channels.empty():
            described.append(tuple(channels.child_value(key) for key in ("label", "object", "type", "unit")))
            channels = channels.next_sibling("channel")
        assert described == [(f"cuboid_{label}", "cuboid", kind, unit) for label, kind, unit in lsl.CHANNELS]

        samples = [stream.pull_sample(timeout=30) for _ in range(30)]
        times = [t for _, t in samples]
        assert all(b > a for a, b in zip(times, times[1:]))
        # All run on this machine, so that inlets need no correction.
        wall_s, local_s = time.time_ns(), module.local_clock()
        for values, t in samples:
            t_ns = wall_s + round((t - local_s) * 1e9)

            def same(pose):
                is_there = pose.object == "cuboid" and abs(pose.t_ns - t_ns) < 100_000
                return is_there and numpy.array_equal(pose.position, values[:3])

            found = published.find(same)
            assert abs(numpy.dot(found.orientation, values[3:7])) == pytest.approx(1, abs=1e-12)
            assert values[7] == pytest.approx(numpy.sqrt(numpy.trace(found.covariance[:3, :3])))


def test_the_guide_runs(demo, capsys):
    pylsl()
    (block,) = [block for block in guide("python.md") if "sextant.lsl" in block]
    exec(compile(block.replace("tcp/127.0.0.1:7447", demo), "guide", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "stream demo/cuboid" and int(lines[-1]) > 20
    command = [sys.executable, "-m", "sextant.lsl", "--site", "demo", "--duration", "5", "--connect", demo]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert "samples sent" in ended.stderr and "stream demo/cuboid" in ended.stderr


def test_wrong_options_say_what_to_do(demo):
    command = [sys.executable, "-m", "sextant.lsl", "--connect", demo, "--object"]
    pylsl()
    failed = subprocess.run([*command, "teapot"], capture_output=True, text=True, timeout=60, check=False)
    assert failed.returncode == 1 and "no object 'teapot'; it has" in failed.stderr, failed.stderr
    failed = subprocess.run(
        [*command, "cuboid", "--duration", "-1"], capture_output=True, text=True, timeout=60, check=False
    )
    assert failed.returncode == 2 and "--duration" in failed.stderr, failed.stderr


def test_without_pylsl_the_extra_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pylsl", None)
    assert lsl.main([]) == 1
    assert "pip install 'sextant[lsl]'" in capsys.readouterr().err
