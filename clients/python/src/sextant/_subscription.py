"""Messages as they come: an iterator that blocks, and an asynchronous one; behind both a bounded queue that drops the
oldest and counts.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from contextlib import suppress
from time import monotonic
from typing import Any, Callable, Generic, Optional, TypeVar

from .errors import DecodeError

T = TypeVar("T")

#: Messages that wait for a slow reader.
CAPACITY = 256
#: Longest sleep in a wait, so that Ctrl-C is noticed on every system.
_GLANCE = 0.5


class Subscription(Generic[T]):
    """A subscription: `for message in subscription`, or `async for` in asynchronous programs.

    It goes on while the router is out of reach, and ends when it or its site is closed. With a `timeout` it raises the
    error that was agreed on when nothing came for so many seconds.
    """

    def __init__(
        self,
        read: Callable[[str, bytes], Optional[T]],
        timeout: Optional[float],
        silence: Callable[[float], Exception],
    ) -> None:
        self._read = read
        self._timeout = timeout
        self._silence = silence
        self._items: deque[T] = deque()
        self._arrival = threading.Condition()
        self._waiters: list[tuple[asyncio.AbstractEventLoop, asyncio.Future[None]]] = []
        self._subscriber: Any = None
        self._closed = False
        #: Messages that arrived.
        self.received = 0
        #: Those that gave way to newer ones because the reader was slow; 256 wait at most.
        self.dropped = 0
        #: Those that break their contract or have another version of it.
        self.refused = 0
        #: Why the last one was refused.
        self.last_refusal: Optional[str] = None

    def _take_in(self, sample: Any) -> None:
        """On a thread of zenoh."""
        item, refusal = None, None
        try:
            item = self._read(str(sample.key_expr), bytes(sample.payload))
        except DecodeError as cause:
            refusal = str(cause)
        with self._arrival:
            self.received += 1
            if item is None:
                self.refused += 1
                self.last_refusal = refusal or "the message names something else than its key"
                return
            if len(self._items) == CAPACITY:
                self._items.popleft()
                self.dropped += 1
            self._items.append(item)
            self._wake()

    def _wake(self) -> None:
        self._arrival.notify_all()
        for loop, waiter in self._waiters:
            if not loop.is_closed():
                loop.call_soon_threadsafe(_finish, waiter)
        self._waiters.clear()

    def __iter__(self) -> Subscription[T]:
        return self

    def __next__(self) -> T:
        started = monotonic()
        with self._arrival:
            while True:
                if self._items:
                    return self._items.popleft()
                if self._closed:
                    raise StopIteration
                waited = monotonic() - started
                left = _GLANCE if self._timeout is None else self._timeout - waited
                if left <= 0:
                    break
                self._arrival.wait(min(left, _GLANCE))
        raise self._silence(waited)

    def __aiter__(self) -> Subscription[T]:
        return self

    async def __anext__(self) -> T:
        loop = asyncio.get_running_loop()
        started = monotonic()
        while True:
            waiter: asyncio.Future[None] = loop.create_future()
            with self._arrival:
                if self._items:
                    return self._items.popleft()
                if self._closed:
                    raise StopAsyncIteration
                self._waiters.append((loop, waiter))
            try:
                await asyncio.wait_for(waiter, self._timeout)
            except asyncio.TimeoutError:
                raise self._silence(monotonic() - started) from None

    def close(self) -> None:
        """Ends the subscription, and whatever loop runs over it."""
        with self._arrival:
            subscriber, self._subscriber = self._subscriber, None
            self._closed = True
            self._wake()
        if subscriber is not None:
            subscriber.undeclare()

    def __del__(self) -> None:
        # Perhaps on a thread of zenoh, which must not wait for itself.
        subscriber = getattr(self, "_subscriber", None)
        if subscriber is not None:
            with suppress(RuntimeError):
                threading.Thread(target=subscriber.undeclare).start()

    def __enter__(self) -> Subscription[T]:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _finish(waiter: asyncio.Future[None]) -> None:
    if not waiter.done():
        waiter.set_result(None)
