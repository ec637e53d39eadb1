"""Makes odometry.txt: frames by pymavlink 2.4.50, whose encoder and CRC share nothing with ours, of poses that are
converted here once more with quaternions where the Rust code uses matrices. `pip install pymavlink==2.4.50`, then
`python odometry.py > odometry.txt`."""

import math

from pymavlink.dialects.v20 import common


def times(a, b):
    (w, x, y, z), (p, q, r, s) = a, b
    return (
        w * p - x * q - y * r - z * s,
        w * q + x * p + y * s - z * r,
        w * r - x * s + y * p + z * q,
        w * s + x * r - y * q + z * p,
    )


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def turned(q, v):
    return times(times(q, (0.0, *v)), conjugate(q))[1:]


# The test's pose.
T_NS = 1_800_000_000_123_456_789
POSITION = (1.5, -2.25, 0.75)
WORLD_FROM_OBJECT = (0.8, 0.16, -0.32, 0.48)  # w, x, y, z
TWIST = (0.5, -0.25, 0.125, 1.0, 2.0, -3.0)
COVARIANCE = [[(1 + row + column) * 1e-4 + (row == column) * 1e-2 for column in range(6)] for row in range(6)]
HALF_TURN_ABOUT_X = (0.0, 1.0, 0.0, 0.0)

norm = math.sqrt(sum(c * c for c in WORLD_FROM_OBJECT))
q_object = tuple(c / norm for c in WORLD_FROM_OBJECT)


def frame(local_from_world, frame_id, resets):
    """local_from_world: a quaternion."""
    rows = [turned(conjugate(local_from_world), axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    turn = [[rows[i % 3][j % 3] if i // 3 == j // 3 else 0.0 for j in range(6)] for i in range(6)]
    covariance = [
        [sum(turn[i][k] * COVARIANCE[k][l] * turn[j][l] for k in range(6) for l in range(6)) for j in range(6)]
        for i in range(6)
    ]
    world_from_body = times(q_object, HALF_TURN_ABOUT_X)
    q = times(local_from_world, world_from_body)
    if q[0] < 0:
        q = tuple(-c for c in q)
    v = turned(conjugate(world_from_body), TWIST[:3])
    w = turned(conjugate(world_from_body), TWIST[3:])
    message = common.MAVLink_odometry_message(
        T_NS // 1000, frame_id, common.MAV_FRAME_BODY_FRD, *turned(local_from_world, POSITION), q, *v, *w,
        [covariance[i][j] for i in range(6) for j in range(i, 6)], [math.nan] + [0.0] * 20,
        resets, common.MAV_ESTIMATOR_TYPE_MOCAP, 0,
    )
    return message


sender = common.MAVLink(None, srcSystem=7, srcComponent=197)
heartbeat = common.MAVLink_heartbeat_message(
    common.MAV_TYPE_ONBOARD_CONTROLLER, common.MAV_AUTOPILOT_INVALID, 0, 0, common.MAV_STATE_ACTIVE, 3
)
# East-north-up to north-east-down: half a turn about the axis between x and y.
s = math.sqrt(0.5)
frames = [
    heartbeat,
    frame(HALF_TURN_ABOUT_X, common.MAV_FRAME_LOCAL_FRD, 3),
    frame((0.0, s, s, 0.0), common.MAV_FRAME_LOCAL_NED, 0),
]
for message in frames:
    print(message.pack(sender).hex())
    sender.seq = (sender.seq + 1) % 256
