"""Asynchronous programs against a running demo: the same poses, the end of `async with`, cancellation and Ctrl-C, wrong
inputs.
"""

import asyncio
import subprocess
import sys
import threading
import time
from contextlib import nullcontext

import pytest
import sextant
import sextant.aio
from conftest import PATIENCE, free_port, heed_ctrl_c

#: Begins a program that Ctrl-C ends soon after it has printed a line.
INTERRUPTED = """
import asyncio, os, signal, sextant.aio
async def main():
    async with sextant.aio.connect({endpoint!r}) as site:
        asyncio.get_running_loop().call_later(0.3, os.kill, os.getpid(), signal.SIGINT)
        {what}
asyncio.run(main())
"""


def test_what_blocks_is_awaited(demo):
    async def look():
        async with sextant.aio.connect(demo) as site:
            assert set(await site.objects()) == {"cuboid", "prism", "frustum"}
            pose, transform = await asyncio.gather(
                site.pose("cuboid", PATIENCE), site.transform("cuboid", "prism", PATIENCE)
            )
            assert pose.object == "cuboid" and (transform.a, transform.b) == ("cuboid", "prism")
            assert await site.rig() == site.blocking.rig()
            assert (await site.set(await site.rig())).outcome.to_json() == "same"
            assert site.name == "demo" and site.is_connected
            assert {name for name in dir(site.blocking) if name[0] != "_"} - {"close"} <= set(dir(site))

    asyncio.run(look())


def test_a_loop_over_poses_can_be_left_and_begun_again(demo):
    async def sequences(site):
        found = []
        async for pose in site.poses("cuboid", timeout=PATIENCE):
            found.append(pose.sequence)
            if len(found) == 3:
                return found

    async def twice():
        async with sextant.aio.connect(demo) as site:
            return await sequences(site) + await sequences(site)

    found = asyncio.run(twice())
    assert found == sorted(found) and len(found) == 6


def test_a_slow_loop_gets_the_newest_and_the_others_are_counted(demo):
    async def sleepy():
        async with sextant.aio.connect(demo) as site, site.poses(timeout=PATIENCE) as poses:
            while poses.dropped == 0:
                await asyncio.sleep(0.1)
            await poses.__anext__()
            assert poses.received > poses.dropped > 0

    asyncio.run(sleepy())


def test_the_end_of_async_with_ends_what_waits(demo):
    async def leave():
        async with sextant.aio.connect(demo) as site:
            far = time.time_ns() + 10**12
            waiting = [asyncio.ensure_future(site.pose_at("cuboid", far, timeout=PATIENCE)) for _ in range(20)]
            await asyncio.sleep(0.3)
        ended = await asyncio.gather(*waiting, return_exceptions=True)
        assert {type(end) for end in ended} == {sextant.ClosedError}

    started = time.monotonic()
    asyncio.run(leave())
    assert time.monotonic() - started < PATIENCE / 2


@pytest.mark.parametrize("is_cancelled", [False, True])
def test_the_loop_runs_while_the_site_is_closed(demo, monkeypatch, is_cancelled):
    may_close, closed, close = threading.Event(), [], sextant.Site.close

    def close_later(site):
        closed.append(may_close.wait(PATIENCE))
        close(site)

    async def leave():
        async with sextant.aio.connect(demo):
            asyncio.get_running_loop().call_later(0.1, may_close.set)
            if is_cancelled:
                asyncio.current_task().cancel()
            await asyncio.sleep(0)

    monkeypatch.setattr(sextant.Site, "close", close_later)
    with pytest.raises(asyncio.CancelledError) if is_cancelled else nullcontext():
        asyncio.run(leave())
    assert closed == [True]


@pytest.mark.parametrize(
    "what",
    [
        "async for _ in site.poses('cuboid'): pass",
        "await site.pose_at('cuboid', 10**19 // 2, timeout=1000)",
        "await asyncio.gather(*[site.pose_at('cuboid', 10**19 // 2, timeout=1000) for _ in range(20)])",
    ],
)
def test_ctrl_c_ends_a_program_that_waits(demo, what):
    code = INTERRUPTED.format(endpoint=demo, what=what)
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE, preexec_fn=heed_ctrl_c
    )
    assert ended.returncode != 0 and ended.stderr.strip().endswith("KeyboardInterrupt"), ended.stderr


def test_errors_are_those_of_programs_that_block(demo):
    async def wrong():
        async with sextant.aio.connect(demo) as site:
            with pytest.raises(sextant.UnknownNameError, match="it has cuboid"):
                await site.pose("sphere")
            with pytest.raises(sextant.UnknownNameError, match="it has cuboid"):
                async for _ in site.poses("sphere"):
                    pass
        with pytest.raises(sextant.ClosedError):
            await site.nodes()
        with pytest.raises(sextant.NoRouterError, match="start the site"):
            async with sextant.aio.connect(f"tcp/127.0.0.1:{free_port()}", timeout=0.5):
                pass

    asyncio.run(wrong())
