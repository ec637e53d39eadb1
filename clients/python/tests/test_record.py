"""Recordings of a running demo: what is in the file, its end, failures."""

import asyncio
import multiprocessing
import time

import pytest
import sextant
import sextant.aio
from conftest import PATIENCE, free_port


@pytest.mark.parametrize("objects", ["cuboid", ["cuboid"]])
def test_what_is_received_is_recorded(demo, binary, tmp_path, objects):
    file = tmp_path / "site.mcap"
    with sextant.connect(demo) as site:
        with site.record(file, objects=objects) as recording:
            poses = site.poses("cuboid", timeout=PATIENCE)
            first, *_, last = [next(poses) for _ in range(30)]
            # The recorder receives the last one as well before it ends.
            for _ in range(30):
                next(poses)
        assert recording.figures["messages"] > 30 and recording.figures["dropped"] == 0
    recorded = sextant.read_poses(file)
    assert set(recorded.object) == {"cuboid"}
    assert recorded.t_ns[0] <= first.t_ns and last.t_ns <= recorded.t_ns[-1]
    sextant.run("replay", file, "--out", tmp_path / "poses.jsonl")
    assert len(sextant.read_poses(tmp_path / "poses.jsonl")) > 10


def test_a_recording_is_replaced_only_on_request_and_ends_with_its_site(demo, tmp_path):
    file = tmp_path / "site.mcap"
    with sextant.connect(demo) as site:
        recording = site.record(file)
        with pytest.raises(sextant.CommandError, match="another program is writing|the file exists"):
            site.record(file)
        recording.close()
        recording.close()
        with pytest.raises(sextant.CommandError, match="the file exists; choose another name") as refused:
            site.record(file)
        assert refused.value.exit_code == 3
        again = site.record(file, force=True)
    assert again.figures["messages"] > 0
    with pytest.raises(sextant.ClosedError):
        site.record(file, force=True)


def test_asynchronous_programs_record(demo, tmp_path):
    async def record():
        async with sextant.aio.connect(demo) as site:
            async with site.record(tmp_path / "site.mcap") as recording:
                await site.pose("cuboid", PATIENCE)
            return recording.figures

    assert asyncio.run(record())["messages"] > 0


def test_an_error_in_the_program_comes_out_and_the_file_is_whole(demo, tmp_path):
    with sextant.connect(demo) as site:
        with pytest.raises(ZeroDivisionError):
            with site.record(tmp_path / "site.mcap"):
                1 / 0
    assert list(sextant.read_messages(tmp_path / "site.mcap"))


def test_a_site_is_closed_although_its_recording_failed(demo, tmp_path):
    site = sextant.connect(demo)
    session = site._session
    failed, *others = [site.record(tmp_path / name) for name in ("1.mcap", "2.mcap", "3.mcap")]
    failed._command._process.kill()
    with pytest.raises(sextant.CommandError, match="exit code -9"):
        site.close()
    assert session.is_closed() and all(other.figures for other in others)
    site.close()


def test_an_error_in_the_program_is_not_replaced_by_that_of_a_recording(demo, tmp_path):
    with pytest.raises(ZeroDivisionError):
        with sextant.connect(demo) as site:
            recording = site.record(tmp_path / "site.mcap")
            recording._command._process.kill()
            1 / 0


def test_a_recording_ends_although_a_forked_process_keeps_its_input_open(demo, tmp_path):
    with sextant.connect(demo) as site:
        recording = site.record(tmp_path / "site.mcap")
        fork = multiprocessing.get_context("fork").Process(target=time.sleep, args=(PATIENCE,))
        fork.start()
        recording.close()
        assert fork.is_alive() and recording.figures
        fork.kill()
        fork.join()


def test_a_recording_that_begins_while_its_site_is_closed_ends(demo, tmp_path, monkeypatch):
    site, commands = sextant.connect(demo), []

    def begun(file, command):
        commands.append(command)
        site.close()
        return sextant.Recording(file, command)

    monkeypatch.setattr("sextant._site.Recording", begun)
    with pytest.raises(sextant.ClosedError):
        site.record(tmp_path / "site.mcap")
    assert commands[0]._process.poll() is not None


def test_commands_go_to_the_endpoint_that_answers(demo, tmp_path):
    with sextant.connect([f"tcp/127.0.0.1:{free_port()}", demo]) as site:
        assert sextant.run("config", "get", "rig", site=site)[0]["kind"] == "rig"


def test_images_that_do_not_come_are_an_error_and_all_else_is_recorded(demo, tmp_path):
    with sextant.connect(demo) as site:
        # A demo's images are in a place of its own.
        recording = site.record(tmp_path / "site.mcap", images=True)
        recording._command._process.wait(PATIENCE)
        with pytest.raises(sextant.CommandError, match="no image was recorded") as failed:
            recording.close()
        assert failed.value.exit_code == 4
    assert list(sextant.read_messages(tmp_path / "site.mcap"))
