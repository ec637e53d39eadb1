"""Poses between poses, and from one object to another; the covariances are those of the Rust client.

The errors of successive estimates are correlated to an unknown degree: for any correlation the covariance of
`(1 - s) a + s b` is at most `(1 - s) Cov(a) + s Cov(b)`. Even motion leaves out acceleration; the remainder,
`s (1 - s) / 2 T (v_b - v_a)` over an interval `T`, enters as an error of that size.
"""

from __future__ import annotations

from dataclasses import replace

from ._messages import ObjectPose, State
from ._rotations import exponential, inverse, logarithm, product, rotated, rotation_matrix, sandwich

#: From the state that promises most to the one that promises least.
_RANK = (State.TRACKING, State.COASTING, State.INITIALISING, State.LOST)


def worse(one: State, other: State) -> State:
    return max(one, other, key=_RANK.index)


def interpolate(before: ObjectPose, after: ObjectPose, t_ns: int) -> ObjectPose:
    """The pose at `t_ns`, from `before` to `after`."""
    interval_ns = after.capture_ns - before.capture_ns
    if t_ns <= before.capture_ns or interval_ns <= 0:
        return before
    if t_ns >= after.capture_ns:
        return after
    s = (t_ns - before.capture_ns) / interval_ns

    def mixed(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
        return tuple((1 - s) * x + s * y for x, y in zip(a, b))

    turn = logarithm(product(after.orientation, inverse(before.orientation)))
    weight = s * (1 - s) / 2 * interval_ns * 1e-9
    error = [weight * (b - a) for a, b in zip(before.twist, after.twist)]
    covariance = mixed(before.covariance, after.covariance)
    return replace(
        before,
        capture_ns=t_ns,
        published_ns=after.published_ns,
        state=worse(before.state, after.state),
        position=mixed(before.position, after.position),
        orientation=product(exponential([part * s for part in turn]), before.orientation),
        covariance=tuple(c + error[k // 6] * error[k % 6] for k, c in enumerate(covariance)),
        twist=mixed(before.twist, after.twist),
        cameras=min(before.cameras, after.cameras),
        tags=min(before.tags, after.tags),
        rms_px=max(before.rms_px, after.rms_px),
    )


def relative_pose(a: ObjectPose, b: ObjectPose) -> tuple[tuple[float, ...], tuple[float, ...], list[float]]:
    """Position, orientation and covariance of b in a, from poses of the same instant with independent errors.

    To first order the error is `R_a' (e_b - e_a + d x r_a, r_b - r_a)` with `d` from a to b, all in world axes.
    """
    a_from_world = inverse(a.orientation)
    d = [y - x for x, y in zip(a.position, b.position)]
    cross = [[0.0, -d[2], d[1]], [d[2], 0.0, -d[0]], [-d[1], d[0], 0.0]]
    by_a = [[-float(i == j) for j in range(6)] for i in range(6)]
    turn = [[0.0] * 6 for _ in range(6)]
    rotation = rotation_matrix(a_from_world)
    for i in range(3):
        by_a[i][3:] = cross[i]
        turn[i][:3] = rotation[i]
        turn[i + 3][3:] = rotation[i]
    in_world = [x + y for x, y in zip(sandwich(by_a, a.covariance), b.covariance)]
    return rotated(a_from_world, d), product(a_from_world, b.orientation), sandwich(turn, in_world)
