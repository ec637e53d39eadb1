"""Poses between poses and from one object to another, against plain numpy."""

from dataclasses import replace

import numpy
import pytest
from sextant import _rotations as rotations
from sextant._estimates import interpolate, relative_pose
from sextant._history import CAPACITY, History
from sextant.errors import NoPoseError
from sextant.messages import ObjectPose, State

START = 1_800_000_000_000_000_000


def pose(seconds=0.0, position=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0), variance=1e-6):
    return ObjectPose(
        object="cube",
        epoch=1,
        sequence=0,
        capture_ns=START + round(seconds * 1e9),
        published_ns=START,
        state=State.TRACKING,
        position=tuple(position),
        orientation=rotations.exponential(turn),
        covariance=tuple((numpy.eye(6) * variance).ravel()),
        twist=(0.0,) * 6,
        cameras=2,
        tags=3,
        rms_px=0.1,
    )


def at(seconds):
    return START + round(seconds * 1e9)


def test_half_way_is_half_the_motion():
    before = pose()
    after = replace(pose(0.1, (0.2, 0.0, -0.4), (0.0, 0.0, 1.0)), state=State.COASTING)
    between = interpolate(before, after, at(0.05))
    assert between.position == pytest.approx((0.1, 0.0, -0.2))
    assert rotations.logarithm(between.orientation) == pytest.approx((0.0, 0.0, 0.5))
    assert between.state is State.COASTING
    assert interpolate(before, after, at(0.0)) is before
    assert interpolate(before, after, at(0.1)) is after


def test_the_covariance_covers_acceleration():
    g, interval = 9.81, 0.1
    before = pose(variance=0.0)
    after = replace(pose(interval, (0, 0, -g * interval**2 / 2), variance=0.0), twist=(0, 0, -g * interval, 0, 0, 0))
    between = interpolate(before, after, at(interval / 2))
    error = between.position[2] + g * (interval / 2) ** 2 / 2
    assert between.covariance[14] ** 0.5 == pytest.approx(abs(error))


def test_the_covariance_of_a_transform_is_that_of_numeric_jacobians():
    random = numpy.random.default_rng(1)

    def some():
        root = random.normal(size=(6, 6)) * 1e-3
        covariance = tuple((root @ root.T).ravel())
        return replace(pose(0, random.normal(size=3), random.normal(size=3)), covariance=covariance)

    a, b = some(), some()

    def moved(one, step):
        position = numpy.array(one.position) + step[:3]
        return replace(
            one,
            position=tuple(position),
            orientation=rotations.product(rotations.exponential(step[3:]), one.orientation),
        )

    def error(left, right):
        turn = rotations.logarithm(rotations.product(left[1], rotations.inverse(right[1])))
        return numpy.concatenate([numpy.subtract(left[0], right[0]), turn])

    still, step = relative_pose(a, b), 1e-6
    steps = numpy.eye(6) * step
    by_a = numpy.array([error(relative_pose(moved(a, s), b), still) for s in steps]).T / step
    by_b = numpy.array([error(relative_pose(a, moved(b, s)), still) for s in steps]).T / step
    matrices = [numpy.reshape(one.covariance, (6, 6)) for one in (a, b)]
    expected = by_a @ matrices[0] @ by_a.T + by_b @ matrices[1] @ by_b.T
    assert numpy.reshape(still[2], (6, 6)) == pytest.approx(expected, abs=1e-4 * expected.max())


def test_poses_in_any_order_are_found_by_time():
    history = History()
    for seconds in (0.0, 0.2, 0.1, 0.3):
        history.insert(pose(seconds, (seconds, 0, 0)))
    for seconds in (0.0, 0.05, 0.1, 0.17, 0.3):
        assert history.at("cube", at(seconds), 0.0).position[0] == pytest.approx(seconds)


def test_what_is_not_covered_is_refused():
    history = History()
    with pytest.raises(NoPoseError, match="none is known yet"):
        history.at("cube", START, 0.0)
    for seconds in (0.0, 0.6):
        history.insert(pose(seconds))
    with pytest.raises(NoPoseError, match="too far"):
        history.at("cube", at(0.3), 0.0)
    for outside in (-0.1, 0.7):
        with pytest.raises(NoPoseError, match=f"known from {at(0)} to {at(0.6)}"):
            history.at("cube", at(outside), 0.0)


def test_a_flood_stays_within_both_bounds_and_a_clock_set_back_begins_anew():
    slow, fast = History(), History()
    for second in range(100):
        slow.insert(pose(second))
    assert len(slow._poses) == len(slow._times) == 11
    for step in range(3 * CAPACITY):
        fast.insert(pose(step * 1e-4))
    assert len(fast._poses) == CAPACITY
    slow.insert(pose(20.0))
    assert len(slow._poses) == 1
