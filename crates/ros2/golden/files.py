"""Records the demo, converts the recording to a bag of ROS 2, and reads both files as people's tools do: the bag by
rosbags, which shares no code with Sextant; both by Rerun; the recording by Foxglove's own protobuf classes. Each pose
is compared with the recorded payload.

    python files.py PROGRAM      PROGRAM is the sextant to run

Needs what live.py needs, and foxglove-schemas-protobuf, mcap-protobuf-support, and for what concerns Rerun rerun-sdk.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

sys.dont_write_bytecode = True
FOLDER = pathlib.Path(__file__).parent
sys.path[:0] = [str(FOLDER), str(FOLDER.parents[2] / "clients/python/src")]
import sextant  # noqa: E402
from live import free_port  # noqa: E402

#: Rerun's transforms are 32-bit floats.
TOLERANCE = 1e-6
KNOWN = ("tracking", "coasting")


def nanoseconds(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def recorded(file):
    """Poses by object and arrival, from the payloads of the network's contract."""
    return {(m.object, at): m for at, key, m in sextant.read_messages(file) if key.endswith("/pose")}


def quality(pose):
    variances = np.array(pose.covariance).reshape(6, 6).diagonal()
    lengths = [np.sqrt(variances[:3].sum()), np.sqrt(variances[3:].sum())]
    return [*lengths, pose.rms_px, pose.cameras, pose.tags]


def close(found, expected):
    return np.allclose(found, expected, rtol=0, atol=TOLERANCE)


def turned(found, expected):
    """Whether quaternions are of one attitude."""
    return close(abs(np.dot(found, expected)), 1)


def check_protobuf(file, poses):
    """With the descriptors in the file and nothing else."""
    seen = set()
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        topics = [c.topic for c in reader.get_summary().channels.values() if c.message_encoding == "protobuf"]
        for schema, channel, record, message in reader.iter_decoded_messages(topics):
            seen.add(schema.name)
            if schema.name == "foxglove.PoseInFrame":
                pose = poses[channel.topic.split("/")[2], record.log_time]
                assert message.timestamp.ToNanoseconds() == pose.capture_ns
                assert tuple(getattr(message.pose.position, a) for a in "xyz") == tuple(pose.position)
                assert tuple(getattr(message.pose.orientation, a) for a in "xyzw") == tuple(pose.orientation)
    kinds = ("PoseInFrame", "FrameTransforms", "SceneUpdate", "ImageAnnotations", "CameraCalibration")
    assert seen == {f"foxglove.{kind}" for kind in kinds}, seen
    return len(seen)


def check_bag(bag, poses, counts):
    """What rosbags reads, with the definitions in the file and nothing else; returns the pictures."""
    pictures, seen = {}, {}
    with AnyReader([bag]) as reader:
        for connection, at_ns, raw in reader.messages():
            topic, kind = connection.topic, connection.msgtype
            message = reader.deserialize(raw, kind)
            seen[topic] = seen.get(topic, 0) + 1
            if kind.endswith("/PoseWithCovarianceStamped"):
                pose, found = poses[topic.split("/")[3], at_ns], message.pose
                at, q = found.pose.position, found.pose.orientation
                assert nanoseconds(message.header.stamp) == pose.capture_ns
                assert (at.x, at.y, at.z) == tuple(pose.position)
                assert turned([q.x, q.y, q.z, q.w], pose.orientation)
                assert list(found.covariance) == list(pose.covariance)
            elif topic == "/tf":
                for one in message.transforms:
                    pose, at = poses[one.child_frame_id, at_ns], one.transform.translation
                    assert pose.state.value in KNOWN and (at.x, at.y, at.z) == tuple(pose.position)
                    assert nanoseconds(one.header.stamp) == pose.capture_ns
            elif kind.endswith("/CompressedImage"):
                pictures.setdefault(topic, set()).add(bytes(message.data))
        profiles = {c.topic: c.ext.offered_qos_profiles for c in reader.connections}
    assert seen == counts, (seen, counts)
    # tf takes one transform an instant: of the poses after the images of one instant the first.
    instants = {(pose.object, pose.capture_ns) for pose in poses.values() if pose.state.value in KNOWN}
    assert 0 < seen["/tf"] <= len(instants), (seen, len(instants))
    assert profiles["/tf_static"][0].durability.name == "TRANSIENT_LOCAL", profiles
    assert profiles["/tf"][0].durability.name == "VOLATILE"
    for topic, files in pictures.items():
        start = b"\xff\xd8" if "/preview/" in topic else b"\x89PNG"
        assert all(file.startswith(start) for file in files), topic
    assert any("/preview/" not in topic for topic in pictures), pictures.keys()
    return set().union(*pictures.values())


def check_rerun(file, poses, pictures):
    """Transforms, pictures, lenses and numbers are typed data in Rerun; returns how many of each."""
    from rerun.chunk import McapReader

    found = dict.fromkeys(("transforms", "poses", "pictures", "lenses", "scalars"), 0)
    objects = {name for name, _ in poses}
    for chunk in McapReader(file).stream():
        batch, owner = chunk.to_record_batch(), chunk.entity_path.split("/")[-2]
        names = batch.schema.names
        column = lambda name: [row and row[0] for row in batch.column(name).to_pylist()]
        times = lambda name: batch.column(name).cast("int64").to_pylist()
        if "Transform3D:translation" in names:
            rows = zip(*(column(f"Transform3D:{c}") for c in ("child_frame", "translation", "quaternion")))
            for k, (frame, translation, quaternion) in enumerate(rows):
                # Cameras and tags have no time of capture.
                if (name := frame.removeprefix("object/")) in objects:
                    pose = poses[name, times("message_log_time")[k]]
                    assert "timestamp" not in names or times("timestamp")[k] == pose.capture_ns
                    assert close(translation, pose.position) and turned(quaternion, pose.orientation)
                    found["transforms"] += 1
        if "InstancePoses3D:translations" in names:
            for at_ns, translation in zip(times("message_log_time"), column("InstancePoses3D:translations")):
                assert close(translation, poses[owner, at_ns].position)
                found["poses"] += 1
        if "EncodedImage:blob" in names:
            for blob in column("EncodedImage:blob"):
                assert bytes(blob) in pictures
                found["pictures"] += 1
        if "Scalars:scalars" in names:
            for at_ns, numbers in zip(times("message_log_time"), batch.column("Scalars:scalars").to_pylist()):
                assert close(numbers, quality(poses[owner, at_ns]))
                found["scalars"] += 1
        if "Pinhole:image_from_camera" in names:
            found["lenses"] += len(batch)
    return found


def main():
    program = sys.argv[1]
    run = lambda *words: subprocess.run(
        [program, "--json", *map(str, words)], check=True, capture_output=True, text=True
    )
    with tempfile.TemporaryDirectory() as folder:
        file, bag = pathlib.Path(folder) / "site.mcap", pathlib.Path(folder) / "bag"
        demo = ("demo", "--no-browser", "--port", free_port(), "--cameras", 2, "--objects", 1, "--duration", 8)
        run(*demo, "--record", file, "--images")
        counts = json.loads(run("convert", file, bag, "--ros2").stdout)["topics"]
        poses = recorded(file)
        kinds = check_protobuf(file, poses)
        pictures = check_bag(bag, poses, counts)
        print(
            f"files: {len(poses)} poses in {kinds} schemas of Foxglove, {sum(counts.values())} messages on "
            f"{len(counts)} topics of ROS"
        )
        try:
            import rerun
        except ImportError:
            print("files: no rerun-sdk for this Python; what Rerun reads is not tested")
            return 0
        for one in (file, bag / "bag_0.mcap"):
            found = check_rerun(one, poses, pictures)
            print(f"files: Rerun {rerun.__version__} has of {one.name}: {found}")
            assert all(found[what] for what in ("transforms", "pictures", "lenses", "scalars"))
            assert one != file or found["poses"] == found["scalars"] == len(poses)
    return 0


if __name__ == "__main__":
    sys.exit(main())
