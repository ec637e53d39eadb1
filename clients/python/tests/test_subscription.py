"""Subscriptions without a network: order, bounds, waiting, ending."""

import asyncio
import threading
from types import SimpleNamespace

import pytest
from sextant._subscription import CAPACITY, Subscription
from sextant.errors import DecodeError, NoPoseError


def read(key, payload):
    if payload == b"":
        raise DecodeError("empty")
    return int(payload) if key == "right" else None


def subscription(timeout=None):
    return Subscription(read, timeout, lambda waited: NoPoseError(f"nothing within {waited:.1f} s"))


def sample(number, key="right"):
    return SimpleNamespace(key_expr=key, payload=str(number).encode())


def test_a_flood_leaves_the_newest_and_is_counted():
    flooded = subscription()
    for number in range(3 * CAPACITY):
        flooded._take_in(sample(number))
    assert next(flooded) == 2 * CAPACITY
    assert (flooded.received, flooded.dropped, flooded.refused) == (3 * CAPACITY, 2 * CAPACITY, 0)


def test_what_is_no_message_is_counted_and_passed_over():
    some = subscription()
    some._take_in(sample(1, key="wrong"))
    some._take_in(SimpleNamespace(key_expr="right", payload=b""))
    some._take_in(sample(7))
    assert next(some) == 7
    assert (some.received, some.refused, some.last_refusal) == (3, 2, "empty")


def test_silence_is_an_error_where_a_timeout_was_given():
    with pytest.raises(NoPoseError, match="nothing within"):
        next(subscription(timeout=0.05))
    with pytest.raises(NoPoseError, match="nothing within"):
        asyncio.run(subscription(timeout=0.05).__anext__())


def test_closing_ends_a_loop_that_waits():
    some = subscription()
    some._take_in(sample(1))
    found = []
    reader = threading.Thread(target=lambda: found.extend(some))
    reader.start()
    some.close()
    reader.join(timeout=60)
    assert found == [1] and not reader.is_alive()


def test_tasks_are_woken_from_another_thread():
    async def first_two():
        some = subscription()
        tasks = [asyncio.ensure_future(some.__anext__()) for _ in range(2)]
        await asyncio.sleep(0)
        feeder = threading.Thread(target=lambda: [some._take_in(sample(number)) for number in (1, 2)])
        feeder.start()
        found = await asyncio.wait_for(asyncio.gather(*tasks), 60)
        feeder.join()
        some.close()
        return sorted(found), [item async for item in some]

    assert asyncio.run(first_two()) == ([1, 2], [])
