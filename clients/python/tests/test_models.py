"""Rig, objects and camera settings of a running site, changed from Python: answers, refusals, taking back, and who may
not.
"""

import getpass
import subprocess
from contextlib import contextmanager
from dataclasses import replace

import numpy
import pytest
import sextant
from conftest import free_port, running, wait_for
from sextant._changes import signature
from sextant.messages import CameraSettings, Proposal, RefusalSharedTag, TagId


@pytest.fixture
def site(binary, recording, tmp_path):
    """A fusion node of its own with a cuboid and two cameras."""
    with fusion(binary, recording / "site", tmp_path) as endpoint, wait_for(lambda: connected(endpoint)) as site:
        yield site


@contextmanager
def fusion(binary, files, folder, security="", protocol="tcp"):
    endpoint = f"{protocol}/127.0.0.1:{free_port()}"
    models = f'site = "lab"\nrig = "{files}/rig.toml"\nobjects = ["{files}/cuboid.toml"]\n'
    (folder / "fusion.toml").write_text(models + f'[network]\nmode = "router"\nlisten = ["{endpoint}"]\n' + security)
    with running(binary, "fusion", "--config", folder / "fusion.toml"):
        yield endpoint


def connected(endpoint, **proof):
    try:
        return sextant.connect(endpoint, site="lab", timeout=2, **proof)
    except sextant.NoRouterError:
        return None


def shifted(rig, by):
    first = rig.cameras[0]
    place = replace(first.world_from_camera, position=tuple(numpy.add(first.world_from_camera.position, by)))
    return replace(rig, cameras=(replace(first, world_from_camera=place), *rig.cameras[1:]))


def test_a_rig_is_changed_and_the_change_is_taken_back(site):
    before = site.rig()
    assert site.former() is None and site.proposal() is None
    answer = site.set(shifted(before, [0.001, 0, 0]))
    assert (answer.key, answer.outcome.to_json(), answer.followers) == ("config/rig", "taken", ())
    after = site.rig()
    assert after.cameras[0].world_from_camera.position[0] == pytest.approx(
        before.cameras[0].world_from_camera.position[0] + 0.001
    )
    # The very same answer counts also where it was given before.
    assert [site.set(after).outcome.to_json() for _ in range(3)] == ["same"] * 3
    former = site.former()
    assert sextant.decode(former.rig) == before
    assert site.set(former).outcome.to_json() == "taken"
    assert site.rig() == before


def test_objects_come_and_go_and_models_change_together(site):
    rig, cuboid = site.rig(), site.objects()["cuboid"].config
    half = replace(cuboid, tags=cuboid.tags[1:])
    other = replace(cuboid, id="other", tags=cuboid.tags[:1])
    with pytest.raises(
        sextant.RefusedError, match="is on object cuboid and on object other: print another id"
    ) as refused:
        site.set(other)
    tag = cuboid.tags[0]
    assert refused.value.refusal == RefusalSharedTag(TagId(tag.family, tag.id), "cuboid", "other")
    assert set(site.objects()) == {"cuboid"}, "nothing has changed"
    assert site.set(rig, half, other).key == "config/models"
    assert set(site.objects()) == {"cuboid", "other"} and site.objects()["cuboid"].config == half
    assert site.remove_object("other").key == "config/object/other"
    assert set(site.objects()) == {"cuboid"}
    with pytest.raises(sextant.UnknownNameError, match="it has cuboid"):
        site.remove_object("other")


def test_a_proposal_is_put_in_force(site):
    rig = shifted(site.rig(), [0.001, 0, 0])
    proposed = Proposal("other", 0, sextant.encode(rig), (), n_images=100, before_px=0.5, after_px=0.2)
    key = "sextant/v1/lab/fusion/other/proposal"
    queryable = site._session.declare_queryable(key, lambda query: query.reply(key, sextant.encode(proposed)))
    assert site.proposal() == proposed
    assert site.set(site.proposal()).outcome.to_json() == "taken"
    assert site.rig() == rig
    queryable.undeclare()


def test_settings_of_a_camera_are_put_in_force(demo):
    with sextant.connect(demo) as site:
        controls = lambda: site.cameras()["north"].status.controls  # noqa: E731
        assert site.set(CameraSettings("north", None, None, 20.0)).key == "config/camera/north"
        wait_for(lambda: controls().outcome.to_json() == "applied" and controls().rate_hz.value == 20)
        assert site.set(CameraSettings("north", None, None, None)).outcome.to_json() == "taken"
        wait_for(lambda: controls().outcome.to_json() == "none")


def test_a_change_is_made_where_the_user_has_no_name(monkeypatch):
    def unknown():
        raise ImportError("pwd")

    monkeypatch.setattr(getpass, "getuser", unknown)
    assert signature().startswith("somebody@")


def test_a_refusal_is_an_error_with_the_words_of_the_command_line(site):
    rig = site.rig()
    first = rig.cameras[0]
    for wrong, words in (
        (replace(rig, cameras=()), "the rig has no camera"),
        (replace(rig, cameras=(first, first)), "is there twice"),
        (replace(rig, cameras=(replace(first, lens=replace(first.lens, fx=-1.0)),)), "focal length"),
    ):
        with pytest.raises(sextant.RefusedError, match=f"fusion refused: .*{words}.*; nothing has changed"):
            site.set(wrong)
    assert site.rig() == rig


def test_what_is_no_model_does_not_leave_the_program(site):
    rig = site.rig()
    for wrong in ((), (rig, rig), (rig, CameraSettings("north", 1.0, None, None)), ("rig.toml",)):
        with pytest.raises(TypeError):
            site.set(*wrong)
    with pytest.raises(sextant.EncodeError, match="not finite"):
        site.set(replace(rig, scale_sigma=float("nan")))
    with pytest.raises(sextant.InvalidNameError):
        site.set(replace(site.objects()["cuboid"].config, id="a/b"))


def test_a_site_without_a_fusion_node_has_no_models(demo):
    with sextant.connect(demo, site="hall", timeout=0.3) as hall:
        for ask in (hall.rig, hall.former, lambda: hall.set(CameraSettings("north", None, None, None))):
            with pytest.raises(sextant.NoFusionError, match="this router serves demo"):
                ask()


def test_a_site_that_has_gone_is_out_of_reach(binary, recording, tmp_path):
    with fusion(binary, recording / "site", tmp_path) as endpoint:
        site = wait_for(lambda: connected(endpoint))
        rig = site.rig()
    wait_for(lambda: not site.is_connected)
    with site, pytest.raises(sextant.NoRouterError, match="is being made again"):
        site.set(rig)


def test_only_operators_change_a_protected_site(binary, recording, tmp_path):
    authority = tmp_path / "authority"
    subprocess.run([binary, "keys", "init", authority, "--site", "lab"], check=True)
    for name, role in (("fusion", "fusion"), ("screen", "viewer"), ("ann", "operator")):
        subprocess.run([binary, "keys", "add", authority, name, "--role", role], check=True)
    security = f'[security]\nprofile = "site"\nkeys = "{authority}/fusion"\n'
    with fusion(binary, recording / "site", tmp_path, security, "quic") as endpoint:
        with wait_for(lambda: connected(endpoint, keys=authority / "ann")) as site:
            assert site.set(shifted(site.rig(), [0.001, 0, 0])).outcome.to_json() == "taken"
            assert sextant.run("config", "get", "rig", site=site)[0]["kind"] == "rig"
        with connected(endpoint, keys=authority / "screen") as site:
            with pytest.raises(sextant.OptionsError, match="keys of the role viewer may not change the site"):
                site.set(site.rig())
