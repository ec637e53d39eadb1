"""Makes and checks the golden files of this folder with implementations of ROS 2's formats that share no code with
Sextant.

    python oracle.py make FOLDER      writes the files
    python oracle.py check FOLDER     compares them with the files there; and, where ROS 2's own packages are installed,
                                      lets Fast CDR read each file, write it again, and compares type hashes with
                                      those that the packages ship

Files: *.cdr and hashes.txt by rosbags; graph.txt, with keys, liveliness tokens, GIDs and attachments, by zenoh-ros2-sdk
and xxhash. All three are on PyPI. For the second part ros-rclpy, ros-geometry-msgs, ros-sensor-msgs,
ros-diagnostic-msgs.
"""

import importlib
import json
import pathlib
import sys

import numpy as np
import xxhash
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from zenoh_ros2_sdk.attachment import Attachment
from zenoh_ros2_sdk.entity import EndpointEntity, EntityKind, NodeEntity
from zenoh_ros2_sdk.keyexpr import endpoint_liveliness_keyexpr, node_liveliness_keyexpr, topic_keyexpr
from zenoh_ros2_sdk.qos import QosDurability, QosProfile, QosReliability

# apriltag_msgs 2.0.1, of which rosbags knows nothing.
APRILTAG = {
    "apriltag_msgs/msg/Point": "float64 x\nfloat64 y\n",
    "apriltag_msgs/msg/AprilTagDetection": """string family
int32 id
int32 hamming
float32 goodness
float32 decision_margin
Point centre
Point[4] corners
float64[9] homography
""",
    "apriltag_msgs/msg/AprilTagDetectionArray": "std_msgs/Header header\nAprilTagDetection[] detections\n",
}

# motion_capture_tracking_interfaces 1.0 and mocap4r2_msgs 0.0.3 likewise.
MOCAP = {
    "motion_capture_tracking_interfaces/msg/NamedPose": "string name\ngeometry_msgs/Pose pose\n",
    "motion_capture_tracking_interfaces/msg/NamedPoseArray": "std_msgs/Header header\nNamedPose[] poses\n",
    "mocap4r2_msgs/msg/Marker": """int8 USE_NAME=0
int8 USE_INDEX=1
int8 USE_BOTH=2
int8 id_type
int32 marker_index
string marker_name
geometry_msgs/Point translation
""",
    "mocap4r2_msgs/msg/RigidBody": "string rigid_body_name\nMarker[] markers\ngeometry_msgs/Pose pose\n",
    "mocap4r2_msgs/msg/RigidBodies": "std_msgs/Header header\nuint32 frame_number\n"
    "mocap4r2_msgs/RigidBody[] rigidbodies\n",
}

STORE = get_typestore(Stores.ROS2_JAZZY)
for name, text in (APRILTAG | MOCAP).items():
    STORE.register(get_types_from_msg(text, name))


def make(name, /, **fields):
    return STORE.types[name](**fields)


def header(sec, nanosec, frame):
    stamp = make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def quaternion(x, y, z, w):
    return make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


def transform(sec, nanosec, frame, child, t, q):
    translation = make("geometry_msgs/msg/Vector3", x=t[0], y=t[1], z=t[2])
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=header(sec, nanosec, frame),
        child_frame_id=child,
        transform=make("geometry_msgs/msg/Transform", translation=translation, rotation=quaternion(*q)),
    )


def samples():
    """Each file's message: the same values as in tests/ros_golden.rs."""
    yield "tf", make(
        "tf2_msgs/msg/TFMessage",
        transforms=[
            transform(1_700_000_000, 123_456_789, "world", "cube", (1.5, -2.25, 0.125), (0.5, -0.5, 0.5, 0.5)),
            transform(1_700_000_000, 999_999_999, "world", "pad-2", (-1e-3, 1e6, 0.0), (0.0, 0.0, 0.0, 1.0)),
        ],
    )
    yield "tf-empty", make("tf2_msgs/msg/TFMessage", transforms=[])
    position = make("geometry_msgs/msg/Point", x=0.25, y=-0.5, z=1.75)
    pose = make("geometry_msgs/msg/Pose", position=position, orientation=quaternion(0.5, 0.5, -0.5, 0.5))
    covariance = np.array([k / 8 for k in range(36)])
    yield "pose", make(
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        header=header(1_700_000_001, 5, "map"),
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
    )
    axis = make("std_msgs/msg/MultiArrayDimension", label="sigma_m rms_px", size=2, stride=2)
    yield "quality", make(
        "std_msgs/msg/Float64MultiArray",
        layout=make("std_msgs/msg/MultiArrayLayout", dim=[axis], data_offset=0),
        data=np.array([0.001, 0.25]),
    )
    vector = lambda x, y, z: make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)
    twist = make("geometry_msgs/msg/Twist", linear=vector(1.0, -2.0, 0.5), angular=vector(0.25, 0.0, -4.0))
    yield "odometry", make(
        "nav_msgs/msg/Odometry",
        header=header(1_700_000_001, 6, "map"),
        child_frame_id="cube",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance),
    )
    named = lambda name: make("motion_capture_tracking_interfaces/msg/NamedPose", name=name, pose=pose)
    yield "named-poses", make(
        "motion_capture_tracking_interfaces/msg/NamedPoseArray",
        header=header(1_700_000_001, 7, "map"),
        poses=[named("cube"), named("pad-2")],
    )
    marker = make(
        "mocap4r2_msgs/msg/Marker", id_type=2, marker_index=-3, marker_name="tag36h11:3", translation=position
    )
    body = lambda name, markers: make("mocap4r2_msgs/msg/RigidBody", rigid_body_name=name, markers=markers, pose=pose)
    yield "rigid-bodies", make(
        "mocap4r2_msgs/msg/RigidBodies",
        header=header(1_700_000_001, 8, "map"),
        frame_number=9,
        rigidbodies=[body("cube", [marker, marker]), body("pad-2", [])],
    )
    yield "camera-info", make(
        "sensor_msgs/msg/CameraInfo",
        header=header(1_700_000_002, 0, "north_optical"),
        height=480,
        width=640,
        distortion_model="plumb_bob",
        d=np.array([-0.25, 0.125, 0.001, -0.002, 0.5]),
        k=np.array([600.0, 0, 319.5, 0, 601.0, 239.5, 0, 0, 1]),
        r=np.array([1.0, 0, 0, 0, 1, 0, 0, 0, 1]),
        p=np.array([600.0, 0, 319.5, 0, 0, 601.0, 239.5, 0, 0, 0, 1, 0]),
        binning_x=0,
        binning_y=0,
        roi=make("sensor_msgs/msg/RegionOfInterest", x_offset=1, y_offset=2, height=3, width=4, do_rectify=True),
    )
    yield "picture", make(
        "sensor_msgs/msg/CompressedImage",
        header=header(1_700_000_003, 1, "n_optical"),
        format="jpeg",
        data=np.array([0xFF, 0xD8, 0xFF, 0xE0, 0x00, 0xFF, 0xD9], dtype=np.uint8),
    )
    point = lambda x, y: make("apriltag_msgs/msg/Point", x=x, y=y)
    detection = make(
        "apriltag_msgs/msg/AprilTagDetection",
        family="tag36h11",
        id=586,
        hamming=1,
        goodness=0.0,
        decision_margin=61.5,
        centre=point(320.25, 240.75),
        corners=[point(300.0, 260.0), point(340.5, 261.0), point(341.0, 220.0), point(299.5, 221.0)],
        homography=np.array([20.0, 1.0, 320.25, -1.0, 20.5, 240.75, 0.001, -0.002, 1.0]),
    )
    yield "detections", make(
        "apriltag_msgs/msg/AprilTagDetectionArray",
        header=header(1_700_000_004, 2, "east_optical"),
        detections=[detection, detection],
    )
    value = lambda key, text: make("diagnostic_msgs/msg/KeyValue", key=key, value=text)
    status = lambda level, name, message, hardware, values: make(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=level, name=name, message=message, hardware_id=hardware, values=values,
    )
    yield "diagnostics", make(
        "diagnostic_msgs/msg/DiagnosticArray",
        header=header(1_700_000_005, 3, ""),
        status=[
            status(0, "sextant: camera north", "30.0 images/s", "pi-1", [value("images", "7"), value("µ", "")]),
            status(2, "sextant: fusion main", "camera east is not where the rig says", "", []),
        ],
    )


def type_name(message):
    return message.__msgtype__


def types():
    """The published types and everything that they refer to."""
    names = set()
    for _, message in samples():
        names.add(type_name(message))
    return sorted(names)


SESSION = "9aed1ea85b72095f6dbc9ee90dabd56"
TF = "tf2_msgs/msg/TFMessage"
INFO = "sensor_msgs/msg/CameraInfo"
# What rmw_zenoh leaves out, since it is its default.
DEFAULT = QosProfile(history_depth=42)
BEST_EFFORT = QosProfile(reliability=QosReliability.BEST_EFFORT, history_depth=5)
LATCHED = QosProfile(durability=QosDurability.TRANSIENT_LOCAL, history_depth=1)
TOPICS = [
    ("/tf", TF, QosProfile(history_depth=100)),
    ("/tf_static", TF, LATCHED),
    ("/sextant/object/cube/pose", "geometry_msgs/msg/PoseWithCovarianceStamped", QosProfile()),
    ("/sextant/object/cube/quality", "std_msgs/msg/Float64MultiArray", QosProfile()),
    ("/sextant/object/cube/odom", "nav_msgs/msg/Odometry", QosProfile()),
    ("/poses", "motion_capture_tracking_interfaces/msg/NamedPoseArray", QosProfile()),
    ("/rigid_bodies", "mocap4r2_msgs/msg/RigidBodies", QosProfile()),
    ("/sextant/camera/north/detections", "apriltag_msgs/msg/AprilTagDetectionArray", QosProfile()),
    ("/sextant/camera/north/camera_info", INFO, LATCHED),
    ("/sextant/camera/north/image/compressed", "sensor_msgs/msg/CompressedImage", BEST_EFFORT),
    ("/sextant/camera/north/preview/image/compressed", "sensor_msgs/msg/CompressedImage", BEST_EFFORT),
    ("/sextant/camera/north/preview/camera_info", INFO, BEST_EFFORT),
    ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", QosProfile()),
]


def node(namespace):
    return NodeEntity(domain_id=42, session_id=SESSION, node_id=0, node_name="bridge", namespace=namespace)


def publisher(topic, kind, qos, type_hash):
    package, _, short = kind.split("/")
    dds = f"{package}::msg::dds_::{short}_"
    endpoint = EndpointEntity(
        node=node("/sextant"), entity_id=7, kind=EntityKind.PUBLISHER, name=topic,
        dds_type_name=dds, type_hash=type_hash, qos=qos.encode(default=DEFAULT),
    )
    token = endpoint_liveliness_keyexpr(endpoint)
    # The low half comes first.
    gid = xxhash.xxh3_128(token.encode()).intdigest().to_bytes(16, "little")
    return topic_keyexpr(42, topic, dds, type_hash), token, gid


def graph():
    """A line each: what it is, what it is of, and how it is written."""
    for namespace in ("/sextant", "/lab/west", "/"):
        yield f"node {namespace} {node_liveliness_keyexpr(node(namespace))}"
    for distribution in ("jazzy", "humble"):
        for topic, kind, qos in TOPICS:
            type_hash = STORE.hash_rihs01(kind) if distribution == "jazzy" else "TypeHashNotSupported"
            key, token, gid = publisher(topic, kind, qos, type_hash)
            attachment = Attachment(sequence_id=300, timestamp_ns=1_700_000_000_123_456_789, gid=gid).to_bytes()
            yield f"{distribution} {topic} {key} {token} {gid.hex()} {attachment.hex()}"


def fresh():
    files = {f"{name}.cdr": bytes(STORE.serialize_cdr(message, type_name(message))) for name, message in samples()}
    hashes = [f"{name} {STORE.hash_rihs01(name)}\n" for name in types()]
    files["hashes.txt"] = "".join(hashes).encode()
    files["graph.txt"] = "".join(line + "\n" for line in graph()).encode()
    return files


def check_by_ros(folder):
    """Fast CDR leaves the padding between fields as it is, so that bytes are compared after its reading, not after its
    writing.
    """
    try:
        from rclpy.serialization import deserialize_message, serialize_message
    except ImportError:
        print("oracle: ROS 2 is not installed; compared without it")
        return []
    wrong, seen = [], []
    hashes = dict(line.split() for line in (folder / "hashes.txt").read_text().splitlines())
    for name, message in samples():
        kind = type_name(message)
        package, _, short = kind.split("/")
        try:
            module = importlib.import_module(f"{package}.msg")
        except ImportError:
            continue
        read = deserialize_message((folder / f"{name}.cdr").read_bytes(), getattr(module, short))
        again = STORE.deserialize_cdr(serialize_message(read), kind)
        if bytes(STORE.serialize_cdr(again, kind)) != (folder / f"{name}.cdr").read_bytes():
            wrong.append(f"{name}: Fast CDR reads something else")
        description = pathlib.Path(sys.prefix) / "share" / package / "msg" / f"{short}.json"
        described = json.loads(description.read_text())["type_hashes"]
        shipped = {entry["type_name"]: entry["hash_string"] for entry in described}
        if shipped[kind] != hashes[kind]:
            wrong.append(f"{kind}: {package} ships {shipped[kind]}")
        seen.append(kind)
    print(f"oracle: ROS 2's own packages agree on {', '.join(seen)}")
    return wrong


def main():
    command, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    files = fresh()
    if command == "make":
        for name, content in files.items():
            (folder / name).write_bytes(content)
        return 0
    wrong = [f"{name} differs" for name, content in files.items() if (folder / name).read_bytes() != content]
    wrong += check_by_ros(folder)
    for line in wrong:
        print(f"oracle: {line}", file=sys.stderr)
    if not wrong:
        print(f"oracle: {len(files)} files are as rosbags and zenoh-ros2-sdk write them")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
