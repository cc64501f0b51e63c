"""Edits by name: bits, trees, errors, copies, threads."""

from __future__ import annotations

import copy
import fractions
import json
import math
import os
import pathlib
import pickle
import struct
import threading
import time
import warnings
from typing import Any

import numpy as np
import pytest

import sunstone
from conftest import CORNELL

SMALL: dict[str, Any] = dict(integrator="path", spp=2, width=16, height=16)


def pixels(scene: Any, **options: Any) -> Any:
    return scene.render(**{**SMALL, **options}).stokes


def extension(material: Any) -> Any:
    return material["extensions"]["SUNSTONE_polarization"]


def by_name(objects: Any, name: str) -> Any:
    return next(item for item in objects if item.get("name") == name)


#: An edit, and the same in the file.
CASES: list[tuple[str, Any, Any]] = [
    ("materials/half-wave plate/axis_deg", 12.5,
     lambda it, v: extension(by_name(it["materials"], "half-wave plate")).update(axis_deg=v)),
    ("materials/#5/ior", np.float32(1.75),
     lambda it, v: extension(it["materials"][5]).update(ior=v)),
    ("materials/white/reflectance", np.array([0.1, 0.2, 0.3]),
     lambda it, v: extension(it["materials"][0]).update(reflectance=v)),
    ("materials/white/reflectance", {"nm": [400, 700], "value": (0.2, 0.75)},
     lambda it, v: extension(it["materials"][0]).update(reflectance=v)),
    ("materials/light/emissiveFactor", (0.25, 0.5, 1),
     lambda it, v: by_name(it["materials"], "light").update(emissiveFactor=v)),
    ("cameras/camera/perspective.yfov", 0.5,
     lambda it, v: it["cameras"][0]["perspective"].update(yfov=v)),
    ("cameras/#0/film", {"analyzer": {"kind": "linear", "axis_deg": 30}},
     lambda it, v: it["cameras"][0].setdefault("extensions", {})
     .setdefault("SUNSTONE_polarization", {}).update(film=v)),
    ("nodes/glass ball/translation.0", 0.5,
     lambda it, v: by_name(it["nodes"], "glass ball")["matrix"].__setitem__(12, v)),
]


@pytest.mark.parametrize(("target", "value", "change"), CASES, ids=lambda it: str(it)[:20])
def test_edits_are_those_of_the_file(
    target: str, value: Any, change: Any, tmp_path: pathlib.Path
) -> None:
    scene = sunstone.load(CORNELL)
    before = pixels(scene)
    document = json.loads(CORNELL.read_text())
    plain = value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
    change(document, plain)
    (tmp_path / "edited.gltf").write_text(json.dumps(document))
    for file in CORNELL.parent.iterdir():
        if file.is_file() and file.suffix != ".gltf":
            (tmp_path / file.name).symlink_to(file)
    edited = sunstone.load(tmp_path / "edited.gltf", allow_outside=True)
    scene[target] = value
    after = pixels(scene)
    assert np.array_equal(after, pixels(edited)) and not np.array_equal(after, before)
    del scene[target]
    assert scene.edits == {} and np.array_equal(pixels(scene), before)


def test_values_are_told() -> None:
    scene = sunstone.load(CORNELL)
    assert scene["materials/half-wave plate/axis_deg"] == scene["half-wave plate"].axis_deg == 45
    assert "materials/half-wave plate/axis_deg" in scene and "materials/white/eta" not in scene
    assert "materials/snow/eta" not in scene and "snow" not in scene and 3 not in scene
    assert scene["white"]["pbrMetallicRoughness.baseColorFactor"][3] == 1
    assert isinstance(scene["nodes/glass ball/matrix"], tuple)
    with pytest.raises(KeyError, match="exterior_ior is not stated, by default 1"):
        scene["materials/glass/exterior_ior"]
    with pytest.raises(KeyError, match="not stated, and there is no default"):
        scene["materials/white/eta"]
    with pytest.raises(KeyError, match=r"doubleSided is not stated, by default false"):
        scene["materials/white/doubleSided"]
    with pytest.raises(sunstone.SceneError, match="the node has a `matrix`, which says where"):
        scene["nodes/camera/scale"]
    assert scene.get("materials/white/eta") is None and scene.get("materials/white/eta", 3) == 3
    with pytest.raises(AttributeError, match="by default 1"):
        scene["glass"].exterior_ior
    assert "axis_deg" in dir(scene["half-wave plate"]) and "yfov" not in dir(scene["camera"])
    assert "perspective" in dir(scene["camera"])
    # Nobody changes a copy and takes it for the scene.
    scene["cameras/camera/film"] = {"analyzer": {"kind": "linear"}}
    with pytest.raises(TypeError):
        scene["cameras/camera/film"]["analyzer"] = None
    assert scene["camera"].film.analyzer.kind == "linear"
    scene["camera"].film.analyzer.axis_deg = 45
    expected = {"kind": "linear", "axis_deg": 45}
    assert scene.edits == {"cameras/camera/film": {"analyzer": expected}}
    with pytest.raises(TypeError):
        scene["nodes/glass ball/matrix"][0] = 1
    with pytest.raises(TypeError):
        list(scene)  # type: ignore[call-overload]
    for number in (0.1, 1 / 3, math.pi, 1e-300, 123456789.123456789):
        scene["nodes/camera/translation.0"] = number
        assert scene["nodes/camera/translation.0"] == number


REFUSED: list[tuple[str, Any, str]] = [
    ("materials/snow/ior", 1.5, r"cornell.gltf: materials/snow/ior: no material is called `snow`"),
    ("materials/glass/iro", 1.5, r"a material has no key `iro`\n  help: keys are alpha, alpha_texture, alpha_u"),
    ("shapes/glass/ior", 1.5, r"`shapes` is no kind of object\n  help: kinds are materials"),
    ("glass", 1.5, r"glass is no edit\n  help: write KIND/NAME/KEY"),
    ("materials/glass/ior", -1, r'material 5 "glass", .*ior: -1 must be greater than 0'),
    ("materials/glass/ior", "much", r"ior"),
    ("materials/glass/ior", True, r"material 5 \"glass\", .*ior is not a spectrum"),
    ("materials/glass/ior", np.array([1.5, 1.6]), r"ior is not a spectrum"),
    ("materials/white/reflectance", (0.5, 0.5), r"reflectance is not a spectrum"),
    ("materials/white/reflectance", [0.5, True, 0.5], r"reflectance is not a spectrum"),
    ("materials/light/emissiveFactor", (1, 2), r"materials/light/emissiveFactor: material .*2"),
    ("materials/light/emissiveFactor", (1, 2, True), r"materials/light/emissiveFactor: material"),
    ("materials/light/doubleSided", 1, r"materials/light/doubleSided: material .*boolean"),
    ("nodes/glass ball/translation.0", "left", r"nodes/glass ball/translation.0: node"),
    ("nodes/glass ball/matrix", np.eye(4), r"nodes/glass ball/matrix: node"),
    ("nodes/glass ball/matrix.3", None, r"an item of a list, and cannot be taken away"),
    ("cameras/camera/film", {"resolution": (8, 8, 8)}, r"camera.*resolution"),
    ("cameras/camera/perspective.yfov", None, r"cameras/camera/perspective.yfov: camera .*yfov"),
    ("cameras/camera/perspective.yfov", True, r"cameras/camera/perspective.yfov: camera"),
    ("materials/glass/ior", math.nan, r"materials/glass/ior must be finite"),
    ("materials/glass/ior", np.float32("inf"), r"materials/glass/ior must be finite"),
    ("materials/glass/ior", 10**30, r"materials/glass/ior: the number is too large"),
    ("materials/glass/ior", object(), r"materials/glass/ior: cannot be a object"),
    ("nodes/glass ball/matrix.77", 1, r"its list has 16 items, from 0 on"),
    ("cameras/camera/perspective.yfov", 0, r"yfov"),
    ("nodes/glass ball/camera", 99, r"99 is not an index"),
]


@pytest.mark.parametrize(("target", "value", "text"), REFUSED, ids=lambda it: str(it)[:24])
def test_what_cannot_be_is_refused(target: str, value: Any, text: str) -> None:
    scene = sunstone.load(CORNELL)
    expected = pixels(scene)
    with pytest.raises(sunstone.SceneError, match=text):
        scene[target] = value
    with pytest.raises(sunstone.SceneError, match=text):
        scene.edit({"materials/white/reflectance": 0.1, target: value})
    assert scene.edits == {} and np.array_equal(pixels(scene), expected)
    for edits in (None, [(target, value)]):
        with pytest.raises(TypeError, match="edits are a mapping"):
            scene.edit(edits)
    with pytest.raises(KeyError, match="has not been edited"):
        del scene["materials/glass/ior"]
    with pytest.raises(TypeError, match="not by a int"):
        scene[3]  # type: ignore[index]


def test_names_have_to_be_unique(tmp_path: pathlib.Path) -> None:
    text = CORNELL.read_text().replace('"name": "red"', '"name": "white"')
    (tmp_path / "twins.gltf").write_text(text)
    scene = sunstone.load(tmp_path / "twins.gltf", allow_outside=True)
    with pytest.raises(sunstone.SceneError, match="several materials are called so: #0, #1"):
        scene["white"].doubleSided = True
    scene["materials/#1"].doubleSided = True
    with pytest.raises(sunstone.SceneError, match="snow: nothing is called so\n  help: .*white"):
        scene["snow"]
    # A node and a camera have this name: the key tells.
    scene["camera"].perspective.yfov = 0.4
    assert "cameras/camera/perspective.yfov" in scene.edits
    with pytest.raises(sunstone.SceneError, match="several things are called so: nodes/camera, c"):
        scene["camera"].nothing = 1


def test_copies_are_edited_by_themselves(room: sunstone.World) -> None:
    for scene, target, value in [
        (sunstone.load(CORNELL), "materials/glass/ior", 1.9),
        (room.place(), "materials/glass/ior", 1.9),
    ]:
        before = pixels(scene)
        scene[target] = value
        after = pixels(scene)
        assert not np.array_equal(before, after)
        for same in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
            assert same.edits == scene.edits == {target: value}
            assert np.array_equal(pixels(same), after)
            del same[target]
            assert np.array_equal(pixels(same), before) and scene.edits == {target: value}
        other = copy.copy(scene)
        other.edit({})
        assert other.edits == scene.edits
        thing = scene["glass"]
        for same in (copy.copy(thing), pickle.loads(pickle.dumps(thing))):
            assert same.ior == 1.9 and repr(same) == repr(thing)


def grid(folder: pathlib.Path, edge: int) -> pathlib.Path:
    """A scene with a mesh of many triangles above which a camera looks down."""
    x, y = np.meshgrid(np.linspace(-1, 1, edge), np.linspace(-1, 1, edge))
    positions = np.stack([x, y, 0.05 * np.sin(9 * x) * np.cos(7 * y)], axis=-1)
    corner = (np.arange(edge - 1)[:, None] * edge + np.arange(edge - 1)).ravel()
    a, b = [corner, corner + 1, corner + edge + 1], [corner, corner + edge + 1, corner + edge]
    triangles = np.concatenate([np.stack(a, axis=-1), np.stack(b, axis=-1)])
    data = positions.astype("<f4").tobytes() + triangles.astype("<u4").tobytes()
    (folder / "grid.bin").write_bytes(data)
    vertices, split = edge * edge, 12 * edge * edge
    low, high = positions.reshape(-1, 3).min(0), positions.reshape(-1, 3).max(0)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [
            {"mesh": 0, "name": "waves"},
            {"camera": 0, "translation": [0, 0, 3]},
            {"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 0}}},
        ],
        "cameras": [{"type": "perspective", "name": "eye",
                     "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "materials": [{"name": "sheet", "doubleSided": True,
                       "extensions": {"SUNSTONE_polarization": {"bsdf": "diffuse"}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "directional", "intensity": 683, "name": "sun"}]}},
        "buffers": [{"uri": "grid.bin", "byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": split},
            {"buffer": 0, "byteOffset": split, "byteLength": len(data) - split},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
             "min": np.float32(low).tolist(), "max": np.float32(high).tolist()},
            {"bufferView": 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
        ],
    }
    path = folder / "grid.gltf"
    path.write_text(json.dumps(document))
    return path


def cpu(work: Any) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def test_the_tree_is_built_once(tmp_path: pathlib.Path) -> None:
    path = grid(tmp_path, 200)
    scenes: list[sunstone.Scene] = []
    placing = cpu(lambda: scenes.append(sunstone.load(path)))
    scene = scenes[0]
    before = pixels(scene)

    def edit(target: str, value: Any) -> float:
        return cpu(lambda: scene.__setitem__(target, value))

    moved = edit("nodes/waves/translation", [0, 0, 0.5])
    cheap = min(
        edit(target, value)
        for target, value in [
            ("materials/sheet/reflectance", 0.25),
            ("cameras/eye/perspective.yfov", 0.5),
            ("lights/sun/intensity", 100),
            ("nodes/#1/translation.2", 2.5),
        ]
    )
    # What is left is to look at all triangles.
    assert cheap < 0.3 * min(moved, placing), (cheap, moved, placing)
    assert not np.array_equal(pixels(scene), before)


def test_scenes_made_in_code_are_edited(room: sunstone.World) -> None:
    scene = room.place()
    before = pixels(scene)
    assert room.place() is not scene
    scene["glass"].ior = 1.7
    scene["nodes/ball/position"] = (0, -0.6, 0)
    scene["ball"].position[0]
    scene["nodes/ball/position.0"] = 0.1
    scene["nodes/ball/radius"] = 0.3
    scene["eye"].yfov = 1.0
    assert scene["ball"].position == (0.1, -0.6, 0) and scene["nodes/ball/radius"] == 0.3
    other = sunstone.World("room")
    for function, arguments in room._steps:
        name, *rest = arguments
        keys = dict(rest[-1])
        rest = [*rest[:-1], keys]
        if name == "glass":
            keys["ior"] = 1.7
        if name == "ball":
            rest[0], keys["position"] = 0.3, (0.1, -0.6, 0)
        if name == "eye":
            keys["yfov"] = 1.0
        other._add(function, name, *rest)
    assert np.array_equal(pixels(scene), pixels(other))
    # The world is as it was.
    assert np.array_equal(pixels(room), before)
    assert set(scene.edits) == {
        "materials/glass/ior", "nodes/ball/position", "nodes/ball/radius", "cameras/eye/yfov"
    }
    again = room.place()
    again.edit(scene.edits)
    assert np.array_equal(pixels(again), pixels(scene))
    for target in scene.edits:
        del scene[target]
    assert scene.edits == {} and np.array_equal(pixels(scene), before)
    for target, value, text in [
        ("materials/glass/ior", -1, "material `glass`, ior: -1 must be"),
        ("materials/glass/axis_deg", 1, "axis_deg means nothing for"),
        ("materials/snow/ior", 1, "is called `snow`\n  help: the materials are #0 wall"),
        ("shapes/a/b", 1, "`shapes` is no kind of object"),
        ("lights/a/intensity", 1, "the scene has no lights"),
        ("nodes/ball/position.5", 1, "its list has 3 items"),
        ("nodes/ball/velocity.5", 1, "there is no `velocity` in it"),
        ("glass", 1, "is no edit"),
    ]:
        with pytest.raises(sunstone.SceneError, match=text):
            scene[target] = value
    with pytest.raises(sunstone.SceneError, match="nothing is called so"):
        scene["snow"]
    with pytest.raises(sunstone.SceneError, match="KIND/NAME/KEY; there is nothing yet"):
        sunstone.World()["snow"]
    for number in range(20):
        other.add_material(f"m{number}", "diffuse")
    with pytest.raises(sunstone.SceneError, match="m[0-9], and [0-9]+ more$"):
        other["materials/snow/ior"] = 1
    with pytest.raises(KeyError, match="exterior_ior is not stated"):
        scene["materials/glass/exterior_ior"]
    assert scene.edits == {}


def test_worlds_share_trees() -> None:
    edge = 300
    x, y = np.meshgrid(np.linspace(-1, 1, edge), np.linspace(-1, 1, edge))
    positions = np.stack([x, y, 0.05 * np.sin(9 * x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(edge - 1)[:, None] * edge + np.arange(edge - 1)).ravel()
    triangles = np.stack([corner, corner + 1, corner + edge + 1], axis=-1)
    world = sunstone.World("waves")
    world.add_material("sheet", "diffuse", reflectance=0.5, two_sided=True)
    world.add_mesh("waves", sunstone.Geometry(positions, triangles), "sheet")
    world.add_light("sun", "directional", 1.0)
    world.set_camera("eye", yfov=0.7, position=(0, 0, 3))
    placing = cpu(world.place)
    scene = world.place()
    before = pixels(scene, max_path_length=2)
    editing = cpu(lambda: scene.__setitem__("materials/sheet/reflectance", 0.25))
    assert editing < 0.3 * placing, (editing, placing)
    after = pixels(scene, max_path_length=2)
    np.testing.assert_allclose(after[..., 0], before[..., 0] / 2, rtol=1e-5)
    # The world itself goes on with its tree where only that is added which is no shape.
    world.set_camera("other", yfov=0.5, position=(0, 0, 3))
    assert cpu(world.place) < 0.3 * placing


def test_a_render_keeps_what_it_began_with() -> None:
    scene = sunstone.load(CORNELL)
    expected = pixels(scene, spp=16, threads=1)
    begun, images = threading.Event(), []

    def progress(done: int, total: int) -> None:
        begun.set()
        time.sleep(0.001)

    def render() -> None:
        options: Any = {**SMALL, "spp": 16, "threads": 1}
        images.append(scene.render(**options, progress=progress).stokes)

    worker = threading.Thread(target=render)
    worker.start()
    assert begun.wait(60)
    scene["materials/glass/ior"] = 2.0
    worker.join(60)
    assert np.array_equal(images[0], expected)
    assert not np.array_equal(pixels(scene, spp=16), expected)


def test_no_edit_is_lost_among_threads() -> None:
    scene = sunstone.load(CORNELL)
    names = ["white", "red", "green", "blue"]

    def work(name: str) -> None:
        for index in range(6):
            scene[f"materials/{name}/reflectance"] = 0.1 + 0.1 * index
            scene.render(integrator="path", spp=1, width=2, height=2)

    workers = [threading.Thread(target=work, args=(name,)) for name in names]
    [worker.start() for worker in workers]
    [worker.join(120) for worker in workers]
    assert set(scene.edits) == {f"materials/{name}/reflectance" for name in names}
    assert all(value == 0.1 + 0.1 * 5 for value in scene.edits.values())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_forked_processes_edit() -> None:
    scene = sunstone.load(CORNELL)
    scene["materials/glass/ior"] = 1.6
    reader, writer = os.pipe()
    if (child := os.fork()) == 0:
        scene["materials/glass/ior"] = 1.7
        os.write(writer, struct.pack("d", float(pixels(scene).sum())))
        os._exit(0)
    value = struct.unpack("d", os.read(reader, 8))[0]
    os.waitpid(child, 0)
    assert scene["glass"].ior == 1.6
    scene["glass"].ior = 1.7
    assert float(pixels(scene).sum()) == value


def test_warnings_come_with_edits(tmp_path: pathlib.Path) -> None:
    scene = sunstone.load(CORNELL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene["materials/glass/ior"] = 1.6
    # A ball within the aluminum block, or the like, overlaps it.
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        scene["glass ball"].matrix = scene["gold ball"].matrix
        scene.edit({"materials/gold/doubleSided": True})
    assert all(it.filename == __file__ for it in heard)
    assert len({str(it.message) for it in heard}) == len(heard)


def test_what_is_not_there_is_no_attribute(cornell: sunstone.Scene) -> None:
    assert getattr(cornell["glass"], "shape", None) is None
    assert not hasattr(cornell["glass"], "radius")
    with pytest.raises(AttributeError, match="radius"):
        cornell["glass"].radius


def test_pickles_have_no_edits_that_were_taken_back(room: sunstone.World) -> None:
    scene = room.place()
    target = "materials/glass/ior"
    before = scene[target]
    scene[target] = 1.3
    assert pickle.loads(pickle.dumps(scene)).edits == {target: 1.3}
    del scene[target]
    assert scene[target] == before
    assert scene.edits == {} == pickle.loads(pickle.dumps(scene)).edits


def test_what_goes_together_is_swapped(room: sunstone.World) -> None:
    scene = sunstone.load(CORNELL)
    for thing, edited in ((scene, "gold"), (room.place(), "plate"), (room, "plate")):
        before = pixels(thing)
        metal, eta, k = (f"materials/{edited}/{key}" for key in ("metal", "eta", "k"))
        for target in (eta, k):
            with pytest.raises(sunstone.SceneError, match="either `metal` or both `eta` and `k`"):
                thing[target] = 0.5
        with pytest.raises(sunstone.SceneError, match="either `metal` or both"):
            thing[metal] = None
        thing.edit({metal: None, eta: 0.2, k: np.float32(3.5)})
        after = pixels(thing)
        assert not np.array_equal(before, after) and metal not in thing
        assert thing.edits == {metal: None, eta: 0.2, k: 3.5}
        other = copy.deepcopy(thing)
        other.reset()
        other.edit(thing.edits)
        for same in (other, pickle.loads(pickle.dumps(thing))):
            assert same.edits == thing.edits and np.array_equal(pixels(same), after)
        with pytest.raises(sunstone.SceneError, match="either `metal` or both"):
            del thing[eta]
        assert np.array_equal(pixels(thing), after)
        thing.edit({metal: "Cu", eta: None, k: None})
        assert thing.edits == {metal: "Cu"}
        thing.edit({metal: None, eta: 0.2, k: 3.5})
        thing.reset(metal, eta, k)
        assert thing.edits == {} and np.array_equal(pixels(thing), before)
        for take_back in (thing.reset, lambda: thing.reset(edited),
                          lambda: thing.__delitem__(f"materials/{edited}")):
            thing.edit({metal: None, eta: 0.2, k: 3.5})
            take_back()
            assert thing.edits == {} and thing[metal]
        thing.reset()
        with pytest.raises(KeyError, match="has not been edited"):
            del thing[edited]
        with pytest.raises(sunstone.SceneError, match="snow"):
            thing.reset("snow")


def test_what_is_taken_away_is_not_stated() -> None:
    scene = sunstone.load(CORNELL)
    axis = "materials/half-wave plate/axis_deg"
    scene[axis] = None
    assert axis not in scene and scene.edits == {axis: None}
    with pytest.raises(KeyError, match="by default 0"):
        scene[axis]
    by_default = pixels(scene)
    scene[axis] = 0
    assert np.array_equal(pixels(scene), by_default)
    # What nothing states need not be taken away.
    scene["materials/glass/exterior_ior"] = None
    scene["materials/glass/exterior_ior"] = 1.1
    scene["glass"].exterior_ior = None
    assert set(scene.edits) == {axis}
    scene.edit({"nodes/glass ball/matrix": None, "nodes/glass ball/scale": (0.2, 0.2, 0.2),
                "nodes/glass ball/translation": (0.3, 0.3, 0.2)})
    scene["nodes/glass ball/translation.0"] = 0.25
    assert scene["nodes/glass ball/translation"] == (0.25, 0.3, 0.2)
    scene.reset("glass ball")
    assert len(scene["nodes/glass ball/matrix"]) == 16
    scene["cameras/camera/film"] = {"resolution": (8, 8)}
    with pytest.raises(KeyError, match="by itself: take back cameras/camera/film"):
        del scene["cameras/camera/film.resolution"]


def test_worlds_are_edited_and_go_on(room: sunstone.World) -> None:
    first = room.place()
    room["glass"].ior = 1.7
    room.add_sphere("bead", 0.1, "glass", position=(-0.4, -0.6, 0.2))
    room["nodes/bead/radius"] = 0.2
    room["bead"].position = (-0.5, -0.6, 0.2)
    assert set(room.edits) == {"materials/glass/ior", "nodes/bead/radius", "nodes/bead/position"}
    scene = room.place()
    assert scene.edits == {} and scene["glass"].ior == 1.7 and scene["nodes/bead/radius"] == 0.2
    assert first["glass"].ior == 1.5 and "nodes/bead/radius" not in first
    for same in (copy.copy(room), pickle.loads(pickle.dumps(room))):
        assert same.edits == room.edits
        same.add_sphere("sun", 0.05, "glow", position=(-0.4, 0.3, 0))
        same["nodes/sun/radius"] = 0.1
        assert len(same.edits) == 4 and not np.array_equal(pixels(same), pixels(scene))
        same.reset()
        assert same["nodes/bead/radius"] == 0.1 and same["nodes/sun/radius"] == 0.05
    with pytest.raises(sunstone.SceneError, match="ior: -1"):
        room["glass"].ior = -1
    assert np.array_equal(pixels(room), pixels(scene))


def test_names_like_indices_are_refused(tmp_path: pathlib.Path) -> None:
    text = CORNELL.read_text().replace('"name": "glass"', '"name": "#0"')
    (tmp_path / "a.gltf").write_text(text)
    world = sunstone.World()
    for name in ("white", "#0"):
        world.add_material(name, "diffuse", reflectance=0.5)
    for thing in (sunstone.load(tmp_path / "a.gltf", allow_outside=True), world):
        with pytest.raises(sunstone.SceneError, match="#0") as refused:
            thing["materials/#0/reflectance"] = 0.25
        assert "materials/#00/" in str(refused.value) or "#00" in str(refused.value)
        thing["materials/#00/reflectance"] = 0.25
        assert thing["materials/white/reflectance"] == 0.25


def test_types_of_worlds_are_checked(room: sunstone.World) -> None:
    scene = room.place()
    wrong: list[tuple[str, Any, str]] = [
        ("materials/glass/ior", "high", "material `glass`, ior"),
        ("materials/glass/ior", True, "material `glass`, ior must be a number"),
        ("materials/glass/ior", [1.5], "material `glass`, ior"),
        ("materials/glass/ior", math.nan, "material `glass`, ior"),
        ("materials/glass/two_sided", 1, "material `glass`, two_sided"),
        ("materials/wall/reflectance", (0.5, 0.5), "material `wall`, reflectance"),
        ("materials/wall/reflectance", [0.5, True, 1], "material `wall`, reflectance"),
        ("materials/plate/metal", 3, "material `plate`, metal"),
        ("nodes/ball/position", (1, 2), "sphere `ball`, position"),
        ("nodes/ball/position", "here", "sphere `ball`, position"),
        ("nodes/ball/position.1", True, "sphere `ball`, position"),
        ("nodes/ball/transform", np.eye(3), "sphere `ball`, transform"),
        ("nodes/ball/radius", "wide", "sphere `ball`, radius"),
        ("nodes/ball/radius", None, "sphere `ball`, radius"),
        ("nodes/walls/geometry", 3, "mesh `walls`, geometry"),
        ("cameras/eye/resolution", (-1, 8), "camera `eye`, resolution"),
        ("cameras/eye/resolution", (8.5, 8), "camera `eye`, resolution"),
        ("cameras/eye/yfov", object(), "camera `eye`, yfov"),
    ]
    for thing in (scene, room):
        expected = pixels(thing)
        for target, value, text in wrong:
            with pytest.raises((TypeError, ValueError), match=text):
                thing[target] = value
        assert thing.edits == {} and np.array_equal(pixels(thing), expected)
        with pytest.raises(sunstone.SceneError, match="position.0 is of the same place as nodes"):
            thing.edit({"nodes/ball/position": (0, 0, 0), "nodes/ball/position.0": 1})
    endless: list[Any] = []
    endless.append(endless)
    for thing in (scene, sunstone.load(CORNELL)):
        with pytest.raises(sunstone.SceneError, match="glass/ior is nested too deeply"):
            thing["materials/glass/ior"] = endless


class Tensor:
    """What other packages have for arrays."""

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return np.array([0.25, 0.5, 0.75])


def test_numbers_of_all_kinds_are_taken(room: sunstone.World) -> None:
    spectra = [np.array([0.25, 0.5, 0.75], kind) for kind in ("f2", "f4", "f8", "longdouble", "O")]
    for thing in (sunstone.load(CORNELL), room.place()):
        reflectance = next(f"materials/{name}/reflectance" for name in ("white", "wall")
                           if f"materials/{name}/reflectance" in thing)
        for value in (*spectra, Tensor(), (np.float16(0.25), fractions.Fraction(1, 2), 0.75)):
            thing[reflectance] = value
            assert thing[reflectance] == (0.25, 0.5, 0.75)
        for number in (np.float64(1.5), np.float32(1.5), np.longdouble(1.5), np.array(1.5),
                       np.array([3.0, 1.5])[1], fractions.Fraction(3, 2)):
            thing["materials/glass/ior"] = number
            assert thing["materials/glass/ior"] == 1.5
        for number in (np.int8(2), np.uint64(2), np.array(2)):
            thing["materials/glass/ior"] = number
            assert thing["materials/glass/ior"] == 2


def test_what_is_not_seen_is_checked(tmp_path: pathlib.Path) -> None:
    document = json.loads(CORNELL.read_text())
    spare = {"name": "spare", "extensions": {"SUNSTONE_polarization": {"bsdf": "dielectric"}}}
    document["materials"].append(spare)
    document["cameras"].append({"name": "other", "type": "perspective",
                                "perspective": {"yfov": 0.5, "znear": 0.1}})
    document["nodes"].append({"name": "away", "extensions": {
        "SUNSTONE_polarization": {"sphere_radius": 1, "material": 0}}})
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    scene = sunstone.load(tmp_path / "a.gltf", allow_outside=True)
    for target, value, text in [
        ("materials/spare/ior", "high", "spare.*ior: `high` is no substance"),
        ("materials/spare/ior", -1, "spare.*ior: -1 must be"),
        ("cameras/other/film", {"resolution": (0, 1)}, "other.*resolution"),
        ("cameras/other/perspective.yfov", -1, "other.*yfov"),
        ("nodes/away/sphere_radius", -1, "away.*sphere_radius"),
        ("nodes/away/interior", 7, "away.*interior"),
    ]:
        with pytest.raises(sunstone.SceneError, match=text):
            scene[target] = value
    assert scene.edits == {}
    scene["spare"].ior = 1.4
    assert scene.edits == {"materials/spare/ior": 1.4}


def test_warnings_that_are_errors_change_nothing(room: sunstone.World) -> None:
    scene = sunstone.load(CORNELL)
    size = "cameras/camera/film"
    edit = {size: {"resolution": (8, 2)}, "cameras/camera/perspective.aspectRatio": 1.0}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(2):
            with pytest.raises(sunstone.SceneWarning, match="aspect ratio"):
                scene.edit(edit)
            assert scene.edits == {}
    with pytest.warns(sunstone.SceneWarning, match="aspect ratio") as heard:
        scene.edit(edit)
    assert heard[0].filename == __file__
    # A world tells again, too.
    room.add_material("sheet", "null")
    for name, x in (("fog", -0.3), ("milk", 0.1)):
        room.add_medium(name, "isotropic", sigma_a=0, sigma_s=1)
        room.add_sphere(name, 0.3, "sheet", position=(x, 0.4, 0), interior=name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(2):
            with pytest.raises(sunstone.SceneWarning, match="overlaps"):
                room.place()
    with pytest.warns(sunstone.SceneWarning, match="overlaps"):
        room.place()


def test_the_size_of_a_film_that_is_overruled_is_told(room: sunstone.World) -> None:
    text = "resolution of the film is edited, which means nothing"
    for scene, target in [
        (sunstone.load(CORNELL), "cameras/camera/film.resolution"),
        (room.place(), "cameras/eye/resolution"),
    ]:
        pixels(scene)
        scene[target] = (8, 8)
        with pytest.warns(sunstone.RenderWarning, match=text) as heard:
            scene.render(integrator="path", spp=1, width=4, height=4)
        assert heard[0].filename == __file__
        assert any(text in note for note in scene.notes(width=4, height=4))
        assert scene.render(integrator="path", spp=1).stokes.shape[:2] == (8, 8)
        assert not any(text in note for note in scene.notes(width=4))
        del scene[target]
        pixels(scene)


def test_pickles_of_changed_files_are_refused(tmp_path: pathlib.Path) -> None:
    path = grid(tmp_path, 4)
    scene = sunstone.load(path)
    scene["materials/sheet/reflectance"] = 0.3
    pickled = pickle.dumps(scene)
    assert pickle.loads(pickled).edits == scene.edits
    data = (tmp_path / "grid.bin").read_bytes()
    (tmp_path / "grid.bin").write_bytes(b"\0\0\0\0" + data[4:])
    with pytest.raises(sunstone.SceneError, match=r"grid.bin: the file has changed since"):
        pickle.loads(pickled)
    # What has been read before the change is not what is there now.
    with pytest.raises(sunstone.SceneError, match=r"grid.bin: the file has changed since"):
        pickle.loads(pickle.dumps(scene))
    (tmp_path / "grid.bin").write_bytes(data)
    assert np.array_equal(pixels(pickle.loads(pickled)), pixels(scene))
    path.write_text(path.read_text().replace('"yfov": 0.7', '"yfov": 0.8'))
    with pytest.raises(sunstone.SceneError, match=r"grid.gltf: the file has changed since"):
        pickle.loads(pickled)


def test_texts_name_options_as_python_does(tmp_path: pathlib.Path) -> None:
    (tmp_path / "in").mkdir()
    path = grid(tmp_path, 4)
    (tmp_path / "in" / "grid.gltf").write_text(path.read_text().replace("grid.bin", "../grid.bin"))
    with pytest.raises(sunstone.SceneError, match="trust the scene: allow_outside=True$"):
        sunstone.load(tmp_path / "in" / "grid.gltf")
    scene = sunstone.load(CORNELL)
    texts = [*scene.notes(), *scene.notes(integrator="path"), scene.describe()]
    assert any('integrator="auto" takes' in text for text in texts)
    with pytest.warns(sunstone.RenderWarning, match="greater max_path_length, or none"):
        scene.render(integrator="path", spp=4, width=8, height=8, max_path_length=2)
    path.write_text(path.read_text().replace('"intensity": 683', '"intensity": 0'))
    with pytest.warns(sunstone.RenderWarning) as heard:
        world = sunstone.World()
        world.add_material("glow", "absorber", emission=1.0)
        world.add_sphere("lamp", 0.1, "glow", position=(0, 0, 5))
        world.set_camera(yfov=0.5, target=(0, 0, -1))
        world.render(integrator="path", spp=1, width=4, height=4)
        scene.render(integrator="light", spp=1, width=4, height=4)
    texts += [str(it.message) for it in heard]
    assert any('found by integrator="ppm"' in text for text in texts)
    assert not [text for text in texts if " --" in text]
