"""Calibrations from recordings and of a running demo: reports as they are typed, partial results, failures, the end of
those that run.
"""

import asyncio
import shutil
import signal
import subprocess
import sys
import time
from typing import Any, Union, get_args, get_origin, get_type_hints

import pytest
import sextant
import sextant.aio
from conftest import PATIENCE, wait_for


@pytest.fixture(scope="module")
def simulated(binary, tmp_path_factory):
    """A recording of three seconds."""
    folder = tmp_path_factory.mktemp("simulated") / "site"
    sextant.run("simulate", "--out", folder, "--seconds", 3, "--cameras", 2, "--objects", 1)
    return folder


@pytest.fixture
def files(simulated, tmp_path):
    """Rig and object files that may be written."""
    return {
        name: shutil.copy(simulated / f"{file}.toml", tmp_path) for name, file in (("rig", "rig"), ("object", "cuboid"))
    }


def check(value, of, where):
    """A value has the keys and types that its report promises, and no others."""
    if of is Any:
        return
    origin, arguments = get_origin(of), get_args(of)
    if hasattr(of, "__required_keys__"):
        hints = get_type_hints(of)
        assert of.__required_keys__ <= value.keys() <= hints.keys(), (where, value.keys() ^ hints.keys())
        for key, part in value.items():
            check(part, hints[key], f"{where}.{key}")
    elif origin is Union:
        check(value, type(None) if value is None else arguments[0], where)
    elif origin is list:
        for item in value:
            check(item, arguments[0], f"{where}[]")
    else:
        assert isinstance(value, (int, float) if of is float else origin or of), (where, value)


def test_reports_are_as_they_are_typed(simulated, files, tmp_path):
    calibrate, rig, cuboid = sextant.calibrate, files["rig"], files["object"]
    lens = calibrate.lens(simulated, board=cuboid, camera="north", rig=rig)
    check(lens, calibrate.LensReport, "lens")
    check(calibrate.rig(simulated, rig=rig, object=cuboid), calibrate.RigReport, "rig")
    site = calibrate.site(simulated, size=[0.057, "2:0.06", "3:0.06"], out=tmp_path / "found")
    check(site, calibrate.SiteReport, "site")
    assert (tmp_path / "found" / "rig.toml").is_file()
    robot = calibrate.robot(
        simulated, poses=simulated / "cuboid.tum", rig=rig, object=cuboid, out=tmp_path / "robot.toml"
    )
    check(robot, calibrate.RobotReport, "robot")
    for tags in ({"size": 0.057}, {"size": 0.057, "tags": "0,1,2:0.06"}):
        learned = calibrate.learn(simulated, rig=rig, id="pad", out=tmp_path / "pad.toml", **tags)
        check(learned, calibrate.LearnReport, "learn")
        assert learned["object"] == "pad"


def test_a_partial_result_names_what_is_missing_unless_it_is_refused(simulated, files, tmp_path):
    tags = {"rig": files["rig"], "id": "pad", "tags": "0,1,99", "size": 0.057}
    report = sextant.calibrate.learn(simulated, out=tmp_path / "pad.toml", **tags)
    assert "99" in report["unsolved"][0] and (tmp_path / "pad.toml").is_file()
    with pytest.raises(sextant.CommandError, match="99") as refused:
        sextant.calibrate.learn(simulated, out=tmp_path / "none.toml", strict=True, **tags)
    assert refused.value.exit_code == 3 and not (tmp_path / "none.toml").exists()


def test_a_failure_has_the_words_and_the_exit_code_of_the_command(files, tmp_path, monkeypatch):
    with pytest.raises(sextant.CommandError, match="there is no such file") as failed:
        sextant.calibrate.rig(tmp_path / "nowhere", **files)
    assert failed.value.exit_code == 3
    with pytest.raises(sextant.CommandError, match="'--orgin' found") as failed:
        sextant.calibrate.rig(tmp_path, **files, orgin="tag:3")
    assert failed.value.exit_code == 2
    with pytest.raises(sextant.CommandError) as failed:
        sextant.run("check", tmp_path / "none.toml")
    assert "none.toml" in str(failed.value.output)
    monkeypatch.setenv("SEXTANT_BINARY", "/no/program")
    with pytest.raises(sextant.NoProgramError, match="set SEXTANT_BINARY"):
        sextant.run("--version")


@pytest.fixture
def in_force(demo, tmp_path):
    """Files of what the demo works from."""
    with sextant.connect(demo) as site:
        for name, words in (("rig", ["rig"]), ("object", ["object", "cuboid"])):
            (tmp_path / f"{name}.toml").write_text(sextant.run("config", "get", *words, site=site)[0]["toml"])
    return {"rig": tmp_path / "rig.toml", "object": tmp_path / "object.toml"}


def test_a_running_site_is_calibrated_with_progress(demo, in_force):
    before, seen = in_force["rig"].read_text(), []

    def enough(progress):
        check(progress, sextant.calibrate.Progress, "progress")
        seen.append(progress["hint"])
        return progress["images"] > 60

    with sextant.connect(demo) as site:
        report = sextant.calibrate.rig(site, **in_force, progress=enough)
        check(report, sextant.calibrate.RigReport, "rig")
        assert seen and report["images"] > 60 and in_force["rig"].read_text() != before
        answer = sextant.run("config", "set", "rig", in_force["rig"], site=site)
        assert answer[0]["outcome"] == "taken"
        site.set(site.former())


def test_an_error_in_progress_ends_the_calibration_without_a_result(demo, in_force):
    before = in_force["rig"].read_text()
    with sextant.connect(demo) as site:
        with pytest.raises(ZeroDivisionError):
            sextant.calibrate.rig(site, **in_force, progress=lambda progress: 1 / 0)
    assert in_force["rig"].read_text() == before


def test_cancellation_ends_the_calibration_without_a_result(demo, in_force):
    before = in_force["rig"].read_text()

    async def cancelled():
        async with sextant.aio.connect(demo) as site:
            work = asyncio.to_thread(sextant.calibrate.rig, site.blocking, **in_force)
            await asyncio.wait_for(work, 1)

    started = time.monotonic()
    with pytest.raises(asyncio.TimeoutError):
        asyncio.run(cancelled())
    assert time.monotonic() - started < PATIENCE / 2
    assert in_force["rig"].read_text() == before


def test_a_command_ends_with_the_program_that_runs_it(demo, tmp_path):
    code = (
        "import sextant, sys, time\n"
        f"recording = sextant.connect({demo!r}).record(sys.argv[1])\n"
        "print(recording._command._process.pid, flush=True)\n"
        "time.sleep(1000)"
    )
    file = tmp_path / "site.mcap"
    with subprocess.Popen([sys.executable, "-c", code, file], stdout=subprocess.PIPE, text=True) as program:
        recorder = int(program.stdout.readline())
        assert is_alive(recorder)
        program.send_signal(signal.SIGKILL)
    wait_for(lambda: not is_alive(recorder))
    assert list(sextant.read_messages(file))


def test_a_calibration_computes_from_its_images_where_its_program_is_killed(demo, in_force):
    before = in_force["rig"].read_text()
    code = (
        "import sextant, sys\n"
        f"sextant.calibrate.rig(sextant.connect({demo!r}), rig=sys.argv[1], object=sys.argv[2],\n"
        "    progress=lambda progress: print(progress['images'], flush=True))"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, *in_force.values()], stdout=subprocess.PIPE, text=True
    ) as program:
        while int(program.stdout.readline()) < 60:
            pass
        program.send_signal(signal.SIGKILL)
    wait_for(lambda: in_force["rig"].read_text() != before)


def is_alive(process):
    """Neither gone nor a zombie that nobody has waited for yet."""
    try:
        with open(f"/proc/{process}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
