"""A recording of a demo as USD and glTF, read by OpenUSD, pygltflib and trimesh: poses, visibility, tags and what
cameras see are the recorded ones.
"""

import json
import subprocess

import numpy
import pytest
import sextant

#: Of 32-bit floats at a few metres.
FLOAT32 = 2e-6


@pytest.fixture(scope="module")
def recorded(binary, demo, tmp_path_factory):
    """A recording, and its poses by object and capture time."""
    file = tmp_path_factory.mktemp("animation") / "site.mcap"
    subprocess.run(
        [binary, "record", file, "--connect", demo, "--site", "demo", "--duration", "3"],
        check=True,
        capture_output=True,
    )
    poses = {}
    for _, key, message in sextant.read_messages(file):
        if key.endswith("/pose"):
            poses.setdefault(message.object, {})[message.capture_ns] = message
    assert poses
    return file, poses


def models(file):
    """The last rig, and objects."""
    found = {key: message for _, key, message in sextant.read_messages(file) if "/config/" in key}
    rig = next(message for key, message in found.items() if key.endswith("/config/rig"))
    return rig, {message.id: message for key, message in found.items() if "/config/object/" in key}


def converted(binary, file, ending):
    out = file.with_suffix(ending)
    subprocess.run([binary, "convert", file, out], check=True, capture_output=True)
    return out


def rotation(orientation):
    x, y, z, w = orientation
    return numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def motion(position, orientation):
    matrix = numpy.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation(orientation), position
    return matrix


def is_visible(pose):
    return pose.state in ("tracking", "coasting")


def pixels(camera, points):
    """Of points in the world, without distortion."""
    pose = camera.world_from_camera
    inside = (points - numpy.array(pose.position)) @ rotation(pose.orientation)
    lens = camera.lens
    assert (inside[:, 2] > 0).all()
    return inside[:, :2] / inside[:, 2:] * [lens.fx, lens.fy] + [lens.cx, lens.cy]


def before(camera):
    """Points in the world before a camera."""
    pose = camera.world_from_camera
    return (
        numpy.array([[0.1, 0.2, 2.0], [-0.3, 0.1, 1.0], [0.2, -0.2, 3.0]]) @ rotation(pose.orientation).T
        + pose.position
    )


def test_usd_opens_it_and_poses_agree(binary, recorded):
    pytest.importorskip("pxr")
    from pxr import Gf, Usd, UsdGeom

    file, poses = recorded
    rig, objects = models(file)
    stage = Usd.Stage.Open(str(converted(binary, file, ".usda")))
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    start_ns, rate = int(stage.GetRootLayer().customLayerData["startTimeNs"]), stage.GetTimeCodesPerSecond()
    compared = 0
    for name, of_object in poses.items():
        prim = UsdGeom.Xformable(stage.GetPrimAtPath(f"/Site/Objects/{name}"))
        for t_ns, pose in of_object.items():
            code = Usd.TimeCode((t_ns - start_ns) / 1e9 * rate)
            if not is_visible(pose):
                continue
            compared += 1
            found = numpy.array(prim.ComputeLocalToWorldTransform(code)).T
            assert numpy.abs(found - motion(pose.position, pose.orientation)).max() < 1e-9
            assert UsdGeom.Imageable(prim).ComputeVisibility(code) == "inherited"
        for tag in objects[name].tags:
            mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/Site/Objects/{name}/{tag.family}_{tag.id}"))
            corners = numpy.array(mesh.GetPointsAttr().Get())
            half = tag.size_m / 2
            assert (
                numpy.abs(corners - [[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]]).max()
                < 1e-7
            )
            local = numpy.array(UsdGeom.Xformable(mesh).GetLocalTransformation()).T
            placed = tag.object_from_tag
            assert numpy.abs(local - motion(placed.position, placed.orientation)).max() < 1e-12
    assert compared > 100
    check_valid(stage)
    for camera in rig.cameras:
        prim = UsdGeom.Camera(stage.GetPrimAtPath(f"/Site/Cameras/{camera.id}"))
        frustum = prim.GetCamera(Usd.TimeCode.Default()).frustum
        seen = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
        width, height = camera.resolution
        for point, pixel in zip(before(camera), pixels(camera, before(camera))):
            x, y, _ = seen.Transform(Gf.Vec3d(*point.tolist()))
            found = [(x + 1) / 2 * width - 0.5, (1 - y) / 2 * height - 0.5]
            assert numpy.abs(found - pixel).max() < 1e-3


def check_valid(stage):
    """By every rule of OpenUSD."""
    from pxr import UsdValidation

    rules = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(rules).Validate(stage)
    assert [error.GetMessage() for error in errors] == []


def test_gltf_opens_and_poses_agree(binary, recorded):
    pygltflib = pytest.importorskip("pygltflib")
    file, poses = recorded
    rig, _ = models(file)
    glb = converted(binary, file, ".glb")
    document = pygltflib.GLTF2().load(str(glb))
    data = document.binary_blob()
    names = {node.name: index for index, node in enumerate(document.nodes)}
    y_up_from_z_up = numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    assert numpy.allclose(rotation(document.nodes[0].rotation), y_up_from_z_up, atol=1e-7)
    start_ns = int(document.nodes[0].extras["startTimeNs"])

    def numbers(index):
        accessor = document.accessors[index]
        view = document.bufferViews[accessor.bufferView]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
        values = numpy.frombuffer(data, numpy.float32, accessor.count * width, view.byteOffset)
        return values.reshape(-1, width).astype(float)

    (animation,) = document.animations
    channels = {(c.target.node, c.target.path): animation.samplers[c.sampler] for c in animation.channels}
    compared = 0
    for name, of_object in poses.items():
        translation, turned = (channels[names[name], path] for path in ("translation", "rotation"))
        assert translation.interpolation == turned.interpolation == "LINEAR"
        times = numbers(translation.input)[:, 0]
        assert (numpy.diff(times) > 0).all()
        positions, orientations = numbers(translation.output), numbers(turned.output)
        assert (numpy.sum(orientations[1:] * orientations[:-1], axis=1) > 0).all()
        for t_ns, pose in of_object.items():
            if is_visible(pose):
                compared += 1
                at = numpy.argmin(abs(times - (t_ns - start_ns) / 1e9))
                assert abs(times[at] - (t_ns - start_ns) / 1e9) < 1e-6
                assert numpy.abs(positions[at] - pose.position).max() < FLOAT32
                assert numpy.abs(rotation(orientations[at]) - rotation(pose.orientation)).max() < FLOAT32
    assert compared > 100
    for camera in rig.cameras:
        node = document.nodes[names[camera.id]]
        perspective = document.cameras[node.camera].perspective
        width, height = camera.resolution
        tangent = numpy.tan(perspective.yfov / 2)
        inside = (before(camera) - numpy.array(node.translation)) @ rotation(node.rotation)
        found = inside[:, :2] / -inside[:, 2:] / [tangent * perspective.aspectRatio, tangent]
        # The principal point of glTF is the centre of the image.
        centred = pixels(camera, before(camera)) - [camera.lens.cx, camera.lens.cy]
        assert numpy.abs(found * [width / 2, -height / 2] - centred).max() < 1e-3


def test_trimesh_shows_the_first_poses(binary, recorded, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    file, poses = recorded
    out = tmp_path / "again.glb"
    subprocess.run([binary, "convert", file, out], check=True, capture_output=True)
    scene = trimesh.load(str(out))
    y_up_from_z_up = motion([0, 0, 0], [-(0.5**0.5), 0, 0, 0.5**0.5])
    for name, of_object in poses.items():
        first = next(pose for _, pose in sorted(of_object.items()) if is_visible(pose))
        found, _ = scene.graph.get(name)
        assert numpy.abs(found - y_up_from_z_up @ motion(first.position, first.orientation)).max() < FLOAT32


def test_a_replay_is_an_animation(binary, recording, tmp_path):
    pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    site, out = recording / "site", tmp_path / "replay.usda"
    files = ["--rig", site / "rig.toml", "--object", site / "cuboid.toml"]
    subprocess.run([binary, "replay", site, *files, "--out", out], check=True)
    stage = Usd.Stage.Open(str(out))
    check_valid(stage)
    start_ns, rate = int(stage.GetRootLayer().customLayerData["startTimeNs"]), stage.GetTimeCodesPerSecond()
    prim = UsdGeom.Xformable(stage.GetPrimAtPath("/Site/Objects/cuboid"))
    poses = map(json.loads, (recording / "poses.jsonl").read_text(encoding="utf-8").splitlines())
    compared = 0
    for pose in poses:
        if pose["state"] == "tracking":
            found = numpy.array(
                prim.ComputeLocalToWorldTransform(Usd.TimeCode((pose["t_ns"] - start_ns) / 1e9 * rate))
            ).T
            assert numpy.abs(found - motion(pose["position"], pose["orientation"])).max() < 1e-9
            compared += 1
    assert compared > 20
    failed = subprocess.run(
        [binary, "replay", site, *files, "--out", out, "--frame", "robot.toml"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert failed.returncode == 2 and "leave out --frame" in failed.stderr


def test_wrong_targets_say_what_to_do(binary, recorded, tmp_path):
    file, _ = recorded

    def refused(*words):
        failed = subprocess.run([binary, "convert", *words], capture_output=True, text=True, check=False)
        assert failed.returncode != 0
        return failed.stderr

    assert "let the name end with .usda" in refused(file, tmp_path / "a.usdc")
    assert "let the name end with .glb" in refused(file, tmp_path / "a.gltf")
    assert "leave out --ros2" in refused(file, tmp_path / "a.glb", "--ros2")
    taken = tmp_path / "b.glb"
    taken.write_bytes(b"")
    assert "choose a new name" in refused(file, taken)
    assert taken.read_bytes() == b""
