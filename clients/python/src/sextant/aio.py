"""Sites in asynchronous programs: what `sextant.connect` and `sextant.Site` have except `close`, without blocking the
event loop.

>>> import asyncio, sextant.aio
>>> async def main():
...     async with sextant.aio.connect("tcp/127.0.0.1:7447", site="demo") as site:
...         print(await site.pose("cuboid"))
...         async for pose in site.poses("cuboid"):
...             print(pose.t_ns, pose.state, pose.position)
>>> asyncio.run(main())   # doctest: +SKIP

Methods that wait run on threads of the event loop's executor. The end of `async with`, also by cancellation or Ctrl-C,
closes the site and ends them.
"""

from __future__ import annotations

import asyncio
import os
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, asynccontextmanager
from functools import wraps
from typing import (
    TYPE_CHECKING,
    Any,
    AsyncIterator,
    Callable,
    Coroutine,
    Generator,
    Generic,
    Optional,
    Sequence,
    TypeVar,
    Union,
)

from . import _site
from ._subscription import Subscription

if TYPE_CHECKING:
    from typing import Concatenate, ParamSpec

    P = ParamSpec("P")
T = TypeVar("T")
R = TypeVar("R", bound=AbstractContextManager)  # type: ignore[type-arg]


@asynccontextmanager
async def connect(
    endpoint: Union[str, Sequence[str], None] = None,
    site: str = "demo",
    *,
    keys: Union[str, os.PathLike[str], None] = None,
    user: Optional[str] = None,
    password: Optional[str] = None,
    timeout: float = 5.0,
) -> AsyncIterator[Site]:
    """As `sextant.connect`, for `async with`."""
    proof: dict[str, Any] = {"keys": keys, "user": user, "password": password}
    blocking = await asyncio.to_thread(_site.connect, endpoint, site, timeout=timeout, **proof)
    error: Optional[type[BaseException]] = None
    try:
        yield Site(blocking)
    except BaseException as cause:
        error = type(cause)
        raise
    finally:
        await _on_own_thread(blocking.__exit__, error)


async def _on_own_thread(end: Callable[..., object], *arguments: object) -> None:
    """Ends something, also where its task is cancelled; the threads of the event loop's executor may all wait for that.
    """
    executor = ThreadPoolExecutor(1)
    ended = asyncio.get_running_loop().run_in_executor(executor, end, *arguments)
    executor.shutdown(wait=False)
    await asyncio.shield(ended)


class Opening(Generic[R]):
    """A subscription or recording that begins when it is awaited, or at the beginning of `async with`."""

    def __init__(self, begin: Callable[[], R]) -> None:
        self._begin = begin
        self._begun: Optional[R] = None

    def __await__(self) -> Generator[Any, None, R]:
        return asyncio.to_thread(self._begin).__await__()

    async def __aenter__(self) -> R:
        self._begun = await self
        return self._begun

    async def __aexit__(self, *error: Any) -> None:
        if self._begun is not None:
            await _on_own_thread(self._begun.__exit__, *error)


class Stream(Opening[Subscription[T]]):
    """A subscription for `async for`; `async with` and `await` give the `Subscription` itself, with its counts."""

    async def __aiter__(self) -> AsyncIterator[T]:
        async with self as subscription:
            async for message in subscription:
                yield message


def _awaited(method: Callable[Concatenate[_site.Site, P], T]) -> Callable[Concatenate[Site, P], Coroutine[Any, Any, T]]:
    @wraps(method)
    async def call(self: Site, /, *arguments: P.args, **named: P.kwargs) -> T:
        return await asyncio.to_thread(method, self.blocking, *arguments, **named)

    return call


def _opened(method: Callable[Concatenate[_site.Site, P], R]) -> Callable[Concatenate[Site, P], Opening[R]]:
    @wraps(method)
    def call(self: Site, /, *arguments: P.args, **named: P.kwargs) -> Opening[R]:
        return Opening(lambda: method(self.blocking, *arguments, **named))

    return call


def _streamed(
    method: Callable[Concatenate[_site.Site, P], Subscription[T]],
) -> Callable[Concatenate[Site, P], Stream[T]]:
    @wraps(method)
    def call(self: Site, /, *arguments: P.args, **named: P.kwargs) -> Stream[T]:
        return Stream(lambda: method(self.blocking, *arguments, **named))

    return call


class Site:
    """A connection to a site, as `connect` makes it."""

    def __init__(self, blocking: _site.Site) -> None:
        #: The same connection for code that blocks, such as `sextant.calibrate` on a thread.
        self.blocking = blocking
        #: The name of the site.
        self.name = blocking.name

    @property
    def is_connected(self) -> bool:
        """Whether the router answers now. While it does not, the connection is being made again."""
        return self.blocking.is_connected

    objects = _awaited(_site.Site.objects)
    cameras = _awaited(_site.Site.cameras)
    nodes = _awaited(_site.Site.nodes)
    statuses = _awaited(_site.Site.statuses)
    pose = _awaited(_site.Site.pose)
    pose_at = _awaited(_site.Site.pose_at)
    transform = _awaited(_site.Site.transform)
    rig = _awaited(_site.Site.rig)
    proposal = _awaited(_site.Site.proposal)
    former = _awaited(_site.Site.former)
    set = _awaited(_site.Site.set)
    remove_object = _awaited(_site.Site.remove_object)
    poses = _streamed(_site.Site.poses)
    observations = _streamed(_site.Site.observations)
    record = _opened(_site.Site.record)


__all__ = ["Opening", "Site", "Stream", "connect"]
