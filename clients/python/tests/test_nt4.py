"""`sextant nt4` on a running demo, at a server of WPILib's own ntcore: values are `struct:Pose3d` with their schema, at
the capture time by the server's clock; a server that restarts gets them again."""

import struct
import subprocess
import time

import ntcore
import numpy
from conftest import free_port, running, wait_for


def server(port):
    instance = ntcore.NetworkTableInstance.create()
    instance.startServer("", "127.0.0.1", 0, port)
    return instance


def newest(instance):
    subscriber = instance.getTopic("/Sextant/cuboid/pose").genericSubscribe()
    value = wait_for(lambda: subscriber.get() if subscriber.get().isValid() else None)
    topic = instance.getTopic("/Sextant/cuboid/pose")
    assert topic.getTypeString() == "struct:Pose3d"
    return value


def is_published(published, value):
    x, y, z, qw, qx, qy, qz = struct.unpack("<7d", value.getRaw())
    same = lambda pose: pose.object == "cuboid" and numpy.array_equal(
        [*pose.position, *pose.orientation], [x, y, z, qx, qy, qz, qw]
    )
    return published.find(same)


def test_a_robot_gets_poses_at_their_capture_time(binary, demo, published):
    port = free_port()
    instance = server(port)
    command = (binary, "nt4", "--connect", demo, "--site", "demo", "--to", f"127.0.0.1:{port}")
    with running(*command, stderr=subprocess.PIPE, text=True) as process:
        assert "publishing" in process.stderr.readline()
        value = newest(instance)
        pose = is_published(published, value)
        # This process has the server's clock.
        capture_us = value.server_time() + (time.time_ns() // 1000 - ntcore._now())
        assert abs(capture_us - pose.t_ns // 1000) < 20_000
        schema = instance.getTopic("/.schema/struct:Pose3d").genericSubscribe()
        fields = wait_for(lambda: schema.get().getRaw() if schema.get().isValid() else None)
        assert fields == b"Translation3d translation;Rotation3d rotation"

        instance.stopServer()
        ntcore.NetworkTableInstance.destroy(instance)
        assert "waiting for it" in process.stderr.readline()
        again = server(port)
        assert "is back" in process.stderr.readline()
        assert is_published(published, newest(again))
        ntcore.NetworkTableInstance.destroy(again)


def test_no_server_is_an_error(binary, demo):
    command = [binary, "nt4", "--connect", demo, "--site", "demo", "--to", f"127.0.0.1:{free_port()}"]
    failed = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert failed.returncode == 4 and "refused" in failed.stderr, failed.stderr
