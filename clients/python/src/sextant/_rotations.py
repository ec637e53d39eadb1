"""Rotations and small matrices in plain Python: quaternions x, y, z, w; matrices row by row."""

from __future__ import annotations

from math import acos, cos, hypot, sin, sqrt
from typing import Sequence

Numbers = Sequence[float]
Tuple = tuple[float, ...]


def product(a: Numbers, b: Numbers) -> Tuple:
    """The rotation `a` after `b`."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def inverse(q: Numbers) -> Tuple:
    return (-q[0], -q[1], -q[2], q[3])


def exponential(turn: Numbers) -> Tuple:
    """The rotation about an axis by its length, radians."""
    angle = sqrt(sum(part * part for part in turn))
    # sin(angle / 2) / angle
    scale = 0.5 - angle * angle / 48 if angle < 1e-4 else sin(angle / 2) / angle
    return (turn[0] * scale, turn[1] * scale, turn[2] * scale, cos(angle / 2))


def logarithm(q: Numbers) -> Tuple:
    """The axis times the angle, at most half a turn."""
    x, y, z, w = q if q[3] >= 0 else [-part for part in q]
    half_sine = hypot(x, y, z)
    # angle / sin(angle / 2)
    scale = 2.0 + half_sine * half_sine / 3 if half_sine < 1e-4 else 2 * acos(min(w, 1.0)) / half_sine
    return (x * scale, y * scale, z * scale)


def rotation_matrix(q: Numbers) -> list[list[float]]:
    x, y, z, w = q
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def rotated(q: Numbers, point: Numbers) -> Tuple:
    return tuple(sum(a * b for a, b in zip(row, point)) for row in rotation_matrix(q))


def sandwich(by: Sequence[Numbers], covariance: Numbers) -> list[float]:
    """`by C by'` for a covariance of 36 numbers."""
    six = range(6)
    half = [[sum(by[i][k] * covariance[6 * k + j] for k in six) for j in six] for i in six]
    return [sum(half[i][k] * by[j][k] for k in six) for i in six for j in six]
