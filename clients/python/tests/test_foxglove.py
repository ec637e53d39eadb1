"""`sextant foxglove` on a running demo, read by a WebSocket client that shares nothing with it. Every topic of the guide appears; a message
of each agrees with the schema that was announced for it."""

import json
import struct
import subprocess

from conftest import running
from websockets.sync.client import connect

TOPICS = {
    "/rig": "foxglove.FrameTransforms",
    "/camera/north/calibration": "foxglove.CameraCalibration",
    "/camera/north/preview": "sensor_msgs/msg/CompressedImage",
    "/camera/north/annotations": "foxglove.ImageAnnotations",
    "/object/cuboid/transform": "foxglove.FrameTransforms",
    "/object/cuboid/tags": "foxglove.SceneUpdate",
    "/object/cuboid/ellipsoid": "foxglove.SceneUpdate",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}


def agrees(message, schema):
    kinds = {"object": dict, "array": list, "integer": int, "number": (int, float), "string": str, "boolean": bool}
    assert isinstance(message, kinds[schema["type"]]), (message, schema)
    for name, part in schema.get("properties", {}).items():
        agrees(message[name], part)
    for item in message if schema["type"] == "array" else []:
        agrees(item, schema["items"])


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
                if channel["encoding"] == "json":
                    agrees(json.loads(data), json.loads(channel["schema"]))
                else:
                    assert jpeg_of(data).startswith(b"\xff\xd8")
                seen.add(channel["topic"])
