"""Poses of a fusion node that another one has replaced are dropped."""

from sextant._epochs import EpochFilter


def test_an_older_epoch_of_the_same_object_is_dropped_until_the_newer_one_is_silent():
    now = [5.0]
    epochs = EpochFilter(lambda: now[0])
    said = [("cube", 5), ("cube", 7), ("cube", 6), ("ball", 6), ("cube", 7)]
    assert [epochs.admits(*one) for one in said] == [True, True, False, True, True]
    now[0] += 1.9
    assert not epochs.admits("cube", 6)
    now[0] += 0.2
    assert epochs.admits("cube", 6)


def test_a_flood_of_objects_ends_at_the_bound():
    now = [5.0]
    epochs = EpochFilter(lambda: now[0])
    assert sum(epochs.admits(f"o{n}", 1) for n in range(10_000)) == 4096
    now[0] += 3.0
    assert epochs.admits("late", 1)
