"""`sextant foxglove` on a running demo, read by a WebSocket client that shares nothing with it. Every topic of the
guide appears; a message of each is decoded by the schema that was announced for it."""

import base64
import json
import struct
import subprocess

from conftest import running
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.unknown_fields import UnknownFieldSet
from websockets.sync.client import connect

TOPICS = {
    "/rig": "foxglove.FrameTransforms",
    "/camera/north/calibration": "foxglove.CameraCalibration",
    "/camera/north/preview": "sensor_msgs/msg/CompressedImage",
    "/camera/north/annotations": "foxglove.ImageAnnotations",
    "/object/cuboid/transform": "foxglove.FrameTransforms",
    "/object/cuboid/pose": "foxglove.PoseInFrame",
    "/object/cuboid/quality": "std_msgs/msg/Float64MultiArray",
    "/object/cuboid/tags": "foxglove.SceneUpdate",
    "/object/cuboid/ellipsoid": "foxglove.SceneUpdate",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}


def decoded(channel, data):
    """The message, by nothing but the descriptors that were announced; no field is unknown to them."""
    pool = descriptor_pool.DescriptorPool()
    for file in FileDescriptorSet.FromString(base64.b64decode(channel["schema"])).file:
        pool.Add(file)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"]))
    message = kind.FromString(data)
    assert len(UnknownFieldSet(message)) == 0 and message.ListFields()
    return message


def jpeg_of(cdr):
    """The picture in a CompressedImage in CDR: stamp, frame, format, data, each length at a multiple of four."""
    at, texts = 4 + 8, []
    for _ in range(2):
        (length,) = struct.unpack_from("<I", cdr, at)
        texts.append(cdr[at + 4 : at + 3 + length].decode())
        at += (4 + length + 3) // 4 * 4
    (length,) = struct.unpack_from("<I", cdr, at)
    assert texts == ["camera/north", "jpeg"] and at + 4 + length == len(cdr)
    return cdr[at + 4 :]


def test_every_topic_has_messages_that_agree_with_their_schema(binary, demo):
    command = (binary, "foxglove", "--connect", demo, "--site", "demo", "--listen", "127.0.0.1:0")
    with running(*command, stderr=subprocess.PIPE, text=True) as process:
        address = process.stderr.readline().split()[1]
        with connect(address, subprotocols=["foxglove.sdk.v1"], max_size=None) as socket:
            channels, seen = {}, set()
            while seen != set(TOPICS):
                frame = socket.recv(timeout=120)
                if isinstance(frame, str):
                    message = json.loads(frame)
                    new = [c for c in message.get("channels", []) if c["topic"] in TOPICS]
                    channels.update((c["id"], c) for c in new)
                    wishes = [{"id": 1000 + c["id"], "channelId": c["id"]} for c in new]
                    socket.send(json.dumps({"op": "subscribe", "subscriptions": wishes}))
                    continue
                opcode, subscription, t_ns = struct.unpack_from("<BIQ", frame)
                channel, data = channels[subscription - 1000], frame[13:]
                assert opcode == 1 and t_ns > 1.7e18 and channel["schemaName"] == TOPICS[channel["topic"]]
                if channel["encoding"] == "protobuf":
                    decoded(channel, data)
                elif channel["topic"].endswith("/preview"):
                    assert jpeg_of(data).startswith(b"\xff\xd8")
                else:
                    assert channel["encoding"] == "cdr" and channel["schemaEncoding"] == "ros2msg"
                    assert data.startswith(b"\0\1\0\0")
                seen.add(channel["topic"])
