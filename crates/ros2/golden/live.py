"""Runs the demo and `sextant ros2`, and listens to them as ROS 2 would: the zenoh team's own Python binding, whose
AdvancedSubscriber is the one of rmw_zenoh, and rosbags to decode.

    python live.py PROGRAM      PROGRAM is the sextant to run

Needs what oracle.py needs, and eclipse-zenoh. Every wait is for a condition.
"""

import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import threading
import time

import xxhash
import zenoh
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber
from zenoh_ros2_sdk.attachment import Attachment

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from oracle import STORE  # noqa: E402

PATIENCE_S = 60
ALSO = [word for also in ("odometry", "named-poses", "rigid-bodies") for word in ("--also", also)]
TF = "tf2_msgs/msg/TFMessage"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
INFO = "sensor_msgs/msg/CameraInfo"
DETECTIONS = "apriltag_msgs/msg/AprilTagDetectionArray"
PICTURE = "sensor_msgs/msg/CompressedImage"
ODOMETRY = "nav_msgs/msg/Odometry"
NAMED_POSES = "motion_capture_tracking_interfaces/msg/NamedPoseArray"
RIGID_BODIES = "mocap4r2_msgs/msg/RigidBodies"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"


def until(what, condition):
    deadline = time.monotonic() + PATIENCE_S
    while True:
        found = condition()
        if found:
            return found
        if time.monotonic() > deadline:
            raise SystemExit(f"live: never happened: {what}")
        time.sleep(0.05)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def events(process):
    """The lines of a program as they come."""
    found = []

    def read():
        for line in process.stdout:
            found.append(json.loads(line))

    threading.Thread(target=read, daemon=True).start()
    return found


def session(mode, endpoint):
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("listen/endpoints" if mode == "router" else "connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    # As rmw_zenoh's sessions and router have it; an AdvancedSubscriber does not need it.
    config.insert_json5("timestamping/enabled", "true")
    return zenoh.open(config)


class Topic:
    """A subscription as rmw_zenoh makes it."""

    def __init__(self, listener, name, kind, latched):
        package, _, short = kind.split("/")
        self.kind, self.messages, self.attachments = kind, [], []
        self.key = f"0/{name.strip('/')}/{package}::msg::dds_::{short}_/{STORE.hash_rihs01(kind)}"
        if latched:
            history = HistoryConfig(detect_late_publishers=True, max_samples=1)
            recovery = RecoveryConfig(heartbeat=True)
            self.subscriber = declare_advanced_subscriber(
                listener, self.key, self.take, history=history, recovery=recovery, subscriber_detection=True
            )
        else:
            self.subscriber = listener.declare_subscriber(self.key, self.take)

    def take(self, sample):
        attachment = sample.attachment.to_bytes()
        assert len(attachment) == 33, attachment
        self.attachments.append(Attachment.from_bytes(attachment))
        self.messages.append(STORE.deserialize_cdr(sample.payload.to_bytes(), self.kind))

    def first(self):
        return until(f"a message on {self.key}", lambda: self.messages)[0]


def check_graph(listener, topics):
    """The tokens that make `ros2 node list` and `ros2 topic list`, and the GIDs made of them."""
    tokens = [reply.ok.key_expr for reply in listener.liveliness().get("@ros2_lv/0/**") if reply.ok]
    tokens = sorted(str(token) for token in tokens)
    kinds = [token.split("/")[5] for token in tokens]
    assert kinds.count("NN") == 1, tokens
    by_topic = {token.split("/")[9].replace("%", "/"): token for token in tokens if "/MP/" in token}
    for name, topic in topics.items():
        gid = xxhash.xxh3_128(by_topic[name].encode()).intdigest().to_bytes(16, "little")
        sent = topic.attachments
        assert all(attachment.gid == gid for attachment in sent), name
        numbers = [attachment.sequence_id for attachment in sent]
        assert numbers == sorted(set(numbers)) and numbers[0] >= 1, (name, numbers[:10])
        age_s = time.time() - sent[-1].timestamp_ns * 1e-9
        assert -1 < age_s < PATIENCE_S, (name, age_s)
    return len(by_topic)


def check(listener):
    static = Topic(listener, "/tf_static", TF, latched=True)
    cameras, tags = [], []
    for entry in static.first().transforms:
        (cameras if entry.header.frame_id == "world" else tags).append(entry.child_frame_id)
    assert cameras and all(frame.endswith("_optical") for frame in cameras), cameras
    assert tags and all("/" in frame for frame in tags), tags
    camera = cameras[0].removesuffix("_optical")
    moving = Topic(listener, "/tf", TF, latched=False)
    entry = moving.first().transforms[0]
    assert entry.header.frame_id == "world"
    name = f"/sextant/object/{entry.child_frame_id.replace('-', '_')}/pose"
    pose = Topic(listener, name, POSE, latched=False)
    first = pose.first()
    assert first.header.frame_id == "world"
    covariance = first.pose.covariance.reshape(6, 6)
    assert (covariance.diagonal() > 0).all() and abs(covariance - covariance.T).max() < 1e-12
    q = first.pose.pose.orientation
    assert abs(q.x**2 + q.y**2 + q.z**2 + q.w**2 - 1) < 1e-9
    age_s = time.time() - (first.header.stamp.sec + first.header.stamp.nanosec * 1e-9)
    assert -1 < age_s < PATIENCE_S, age_s
    info = Topic(listener, f"/sextant/camera/{camera}/camera_info", INFO, latched=True)
    lens = info.first()
    assert lens.header.frame_id == cameras[0] and lens.k[8] == 1 and lens.k[0] > 100
    detections = Topic(listener, f"/sextant/camera/{camera}/detections", DETECTIONS, latched=False)
    tag = until("a detection", lambda: [d for m in detections.messages for d in m.detections])[0]
    assert tag.family == "tag36h11" and 0 <= tag.centre.x < lens.width, tag
    pictures = Topic(listener, f"/sextant/camera/{camera}/preview/image/compressed", PICTURE, latched=False)
    small = Topic(listener, f"/sextant/camera/{camera}/preview/camera_info", INFO, latched=False)
    picture = pictures.first()
    assert bytes(picture.data[:2]) == b"\xff\xd8" and bytes(picture.data[-2:]) == b"\xff\xd9"
    until("a lens of a picture", lambda: [i for i in small.messages for p in pictures.messages if i.header == p.header])
    assert small.messages[0].k[0] <= lens.k[0]
    state = Topic(listener, "/diagnostics", DIAGNOSTICS, latched=False)
    until("a status of each node", lambda: any(len(m.status) > len(cameras) for m in state.messages))
    odometry = Topic(listener, name.removesuffix("pose") + "odom", ODOMETRY, latched=False)
    named = Topic(listener, "/poses", NAMED_POSES, latched=False)
    bodies = Topic(listener, "/rigid_bodies", RIGID_BODIES, latched=False)
    at = lambda message: (message.header.stamp.sec, message.header.stamp.nanosec)
    same = lambda first, second: at(first[0]) == at(second[0]) and first[1] == second[1]
    poses = lambda: [(m, m.pose.pose) for m in odometry.messages]
    by_name = lambda: [(m, p.pose) for m in named.messages for p in m.poses]
    rigid = lambda: [(m, b.pose) for m in bodies.messages for b in m.rigidbodies]
    for others in (by_name, rigid):
        until("the pose of odometry under a name", lambda: [1 for p in poses() for o in others() if same(p, o)])
    topics = {"/tf_static": static, "/tf": moving, name: pose, "/diagnostics": state}
    count = check_graph(listener, topics)
    print(f"live: {count} topics, of which {len(topics) + 7} were decoded; {len(moving.messages)} messages on /tf")


def end(process):
    """Politely, as Ctrl-C would."""
    if process and process.poll() is None:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=PATIENCE_S)


def main():
    program = sys.argv[1]
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    demo = ros2 = None
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("ROS_", "SEXTANT_"))}
    start = lambda *words: subprocess.Popen(
        [program, "--json", *words], stdout=subprocess.PIPE, text=True, env=environment
    )
    try:
        demo = start("demo", "--no-browser", "--port", str(free_port()), "--cameras", "2", "--objects", "1")
        told = events(demo)
        ready = until("the demo is ready", lambda: told)[0]
        # The bridge waits for a router that comes later.
        ros2 = start("ros2", "--connect", ready["connect"], "--router", endpoint, *ALSO)
        said = events(ros2)
        router = session("router", endpoint)
        listener = session("client", endpoint)
        until("the bridge is connected", lambda: said)
        check(listener)
        # One that comes late, and from elsewhere, gets what does not move.
        late = session("client", endpoint)
        Topic(late, "/tf_static", TF, latched=True).first()
        end(ros2)
        summary = until("a summary", lambda: [line for line in said if line["event"] == "end"])[0]
        assert ros2.returncode == 0 and summary["failed"] == summary["invalid"] == 0, summary
        until("the node is gone", lambda: not list(listener.liveliness().get("@ros2_lv/0/**")))
        for one in (late, listener, router):
            one.close()
        print(f"live: {summary}")
    finally:
        end(ros2)
        end(demo)
    return 0


if __name__ == "__main__":
    sys.exit(main())
