"""`sextant natnet` on a running demo, read by clients that people use: libmotioncapture (Crazyswarm2) by multicast, and
the client `natnet` by unicast and by multicast, at the same time. Their poses are those of the site to the resolution
of 32 bits."""

import socket
import struct
import subprocess

import motioncapture
import numpy
import pytest
from conftest import free_port, running, wait_for
from natnet import NatNetClient, Version
from natnet.data_frame import DataFrame
from natnet.packet_buffer import PacketBuffer


@pytest.fixture(scope="module", params=["3.1", "4.1"])
def server(request, binary, demo):
    """Port of the commands, port of the frames, and the version."""
    command, data = free_port(), free_port()
    options = ["--listen", f"127.0.0.1:{command}", "--multicast", f"239.255.42.99:{data}", "--protocol", request.param]
    arguments = (binary, "natnet", "--connect", demo, "--site", "demo", *options)
    with running(*arguments, stderr=subprocess.PIPE, text=True) as process:
        assert "rigid bodies" in process.stderr.readline()
        yield command, data, request.param


def client_of(server, use_multicast):
    command, data, _ = server
    client = NatNetClient(command_port=command, data_port=data, use_multicast=use_multicast)
    client.frames, client.models = [], []
    client.on_data_frame_received_event.handlers.append(client.frames.append)
    client.on_data_description_received_event.handlers.append(client.models.append)
    client.connect()
    return client


def frame_of(client, wanted):
    def found():
        client.update_sync()
        return next((frame for frame in client.frames if wanted(frame)), None)

    client.frames.clear()
    return wait_for(found)


def is_published(published, name, position, orientation):
    """The pose of the site that these numbers are."""
    numbers = numpy.float32([*position, *orientation])

    def same(pose):
        return pose.object == name and numpy.array_equal(numpy.float32([*pose.position, *pose.orientation]), numbers)

    return published.find(same)


def valid(frame):
    return next((body for body in frame.rigid_bodies if body.tracking_valid), None)


@pytest.mark.parametrize("use_multicast", [False, True])
def test_frames_have_the_poses_of_the_site(server, published, use_multicast):
    client = client_of(server, use_multicast)
    info = client.server_info
    assert info.application_name == "Sextant" and str(info.nat_net_protocol_version).startswith(server[2])
    client.request_modeldef()
    models = wait_for(lambda: client.update_sync() or client.models)[0]
    names = {body.id_num: body for body in models.rigid_bodies}
    assert set(names) == set(range(1, len(names) + 1))
    frame = frame_of(client, valid)
    body = valid(frame)
    model = names[body.id_num]
    assert len(model.markers) > 1 and model.pos == (0, 0, 0)
    pose = is_published(published, model.name, body.pos, body.rot)
    assert 0 < body.marker_error < 0.05
    stamps = frame.suffix
    assert abs(stamps.stamp_camera_mid_exposure - pose.t_ns) < 10**8
    assert stamps.stamp_camera_mid_exposure < stamps.stamp_data_received < stamps.stamp_transmit
    client.shutdown()


def test_libmotioncapture_reads_what_another_client_reads_too(server, published):
    other = client_of(server, use_multicast=False)
    options = {"hostname": "127.0.0.1", "interface_ip": "127.0.0.1", "port_command": str(server[0])}
    client = motioncapture.connect("optitrack", options)

    def bodies():
        client.waitForNextFrame()
        return dict(client.rigidBodies)

    for name, body in wait_for(bodies).items():
        rotation = body.rotation
        assert is_published(published, name, body.position, (rotation.x, rotation.y, rotation.z, rotation.w))
    assert frame_of(other, valid)
    other.shutdown()


def test_commands_are_answered_as_by_motive(server):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(60)
        client.connect(("127.0.0.1", server[0]))

        def answer(command):
            client.send(struct.pack("<HH", 2, len(command) + 1) + command + b"\0")
            data = client.recv(100)
            return struct.unpack("<HH", data[:4]) + (data[4:],)

        assert answer(b"FrameRate") == (3, 4, struct.pack("<f", 120))
        assert answer(b"UpAxis") == (3, 4, struct.pack("<i", 2))
        assert answer(b"Bitstream") == (3, 14, b"Bitstream," + server[2].encode() + b"\0")
        assert answer(b"StartRecording") == (100, 0, b"")


def test_a_unicast_client_may_have_another_version_than_others(server):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(60)
        client.connect(("127.0.0.1", server[0]))
        keep_alive = struct.pack("<HH", 10, 0)
        client.send(keep_alive)
        client.send(struct.pack("<HH", 2, 14) + b"Bitstream,3.0\0")
        while (data := client.recv(65536))[:2] != b"\x03\0":
            pass
        assert data[4:] == b"Bitstream,3.0\0"
        data = client.recv(65536)
        frame = DataFrame.read_from_buffer(PacketBuffer(data[4:]), Version(3, 0))
        assert frame.rigid_bodies and frame.suffix.stamp_transmit > frame.suffix.stamp_camera_mid_exposure > 1.7e18
