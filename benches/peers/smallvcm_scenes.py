"""SmallVCM's Cornell boxes as glTF: the same numbers, in our materials.

Its floor is Phong-glossy in the scenes it ships with; ours has no such material, so both race
with its diffuse white one (README.md). Its perfect mirror becomes a conductor that reflects more
than 99.9 %, its glass loses nothing, and its lights are what they are.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any, Callable

from common import REPOSITORY

sys.path.insert(0, str(REPOSITORY / "scenes"))

import generate as g  # noqa: E402

LOW, HIGH = (-1.27029, -1.25549, -1.28002), (1.28975, 1.30455, 1.28002)
#: Half the lamp box's width, and its bottom; its top is the ceiling.
LAMP, LAMP_BOTTOM = 0.25, 1.26002
WHITE = [0.803922] * 3
GREEN = [0.156863, 0.803922, 0.172549]
RED = [0.803922, 0.152941, 0.152941]
RADIUS_LARGE, RADIUS_SMALL = 0.8, 0.5
#: The sphere around the scene has this radius; SmallVCM measures merging radii with it.
SCENE_RADIUS = sum((high - low) ** 2 for low, high in zip(LOW, HIGH)) ** 0.5 / 2


def quad(center: tuple, u: tuple, v: tuple) -> list[list[float]]:
    """The transform that makes a rectangle of half axes u and v, facing u x v."""
    normal = g.normalize(g.cross(u, v))
    return g.from_axes(u, v, normal, center)


def mirror() -> dict[str, Any]:
    return g.conductor((1.0, 1.0, 1.0), eta=0.001, k=10.0)


def box(name: str, lamp_box: bool, lamp: bool) -> g.Scene:
    """Room, camera and, under the ceiling, a flat box that is a lamp or not."""
    scene = g.Scene(name)
    white, green, red = (
        scene.material(name, g.diffuse(color, doubleSided=True))
        for name, color in (("white", WHITE), ("green", GREEN), ("red", RED))
    )
    x, y, z = ((low + high) / 2 for low, high in zip(LOW, HIGH))
    a, b, c = ((high - low) / 2 for low, high in zip(LOW, HIGH))
    walls = [
        ("floor", white, (x, y, LOW[2]), (a, 0, 0), (0, b, 0)),
        ("ceiling", white, (x, y, HIGH[2]), (a, 0, 0), (0, -b, 0)),
        ("back wall", white, (x, HIGH[1], z), (a, 0, 0), (0, 0, c)),
        ("left wall", green, (LOW[0], y, z), (0, b, 0), (0, 0, c)),
        ("right wall", red, (HIGH[0], y, z), (0, -b, 0), (0, 0, c)),
    ]
    if lamp_box:
        height = (HIGH[2] - LAMP_BOTTOM) / 2
        middle = LAMP_BOTTOM + height
        walls += [
            ("lamp, back", white, (0, LAMP, middle), (-LAMP, 0, 0), (0, 0, height)),
            ("lamp, front", white, (0, -LAMP, middle), (LAMP, 0, 0), (0, 0, height)),
            ("lamp, left", white, (-LAMP, 0, middle), (0, -LAMP, 0), (0, 0, height)),
            ("lamp, right", white, (LAMP, 0, middle), (0, LAMP, 0), (0, 0, height)),
        ]
        bottom = scene.material("lamp", g.light(25.03329895614464)) if lamp else white
        walls.append(("lamp", bottom, (0, 0, LAMP_BOTTOM), (LAMP, 0, 0), (0, -LAMP, 0)))
    for wall, material, *axes in walls:
        scene.shape(wall, "rectangle", material, quad(*axes))
    origin = (-0.0439815, -4.12529, 0.222539)
    forward = (0.00688625, 0.998505, -0.0542161)
    target = [o + f for o, f in zip(origin, forward)]
    up = (3.73896e-4, 0.0542148, 0.998529)
    scene.camera(g.square_fov(45), g.camera_look_at(origin, target, up), [512, 512])
    return scene


def small_spheres(scene: g.Scene) -> None:
    """A mirror on the left and glass on the right, on the floor."""
    y, z = (LOW[1] + HIGH[1]) / 2, LOW[2] + RADIUS_SMALL
    inset = 2 * (HIGH[0] - LOW[0]) / 7
    scene.sphere("mirror", scene.material("mirror", mirror()), (LOW[0] + inset, y, z), RADIUS_SMALL)
    glass = scene.material("glass", g.glass(1.6))
    scene.sphere("glass", glass, (HIGH[0] - inset, y, z), RADIUS_SMALL)


def sun() -> g.Scene:
    scene = box("small spheres, sun", lamp_box=True, lamp=False)
    small_spheres(scene)
    body = {
        "name": "sun",
        "type": "directional",
        "intensity": 10.0,
        "color": [1.0, 0.4, 0.0],
        "extensions": {g.EXTENSION: {"units": "radiometric"}},
    }
    scene.gltf["extensions"].setdefault("KHR_lights_punctual", {"lights": [body]})
    # Such lights shine along their node's -z.
    turn = g.camera_look_at((0, 0, 0), (-1.0, 1.5, -1.0), (0, 0, 1))
    scene.node("sun", turn, extensions={"KHR_lights_punctual": {"light": 0}})
    return scene


def ceiling() -> g.Scene:
    scene = box("large mirror sphere, area light", lamp_box=True, lamp=True)
    center = ((LOW[0] + HIGH[0]) / 2, (LOW[1] + HIGH[1]) / 2, LOW[2] + RADIUS_LARGE)
    scene.sphere("mirror", scene.material("mirror", mirror()), center, RADIUS_LARGE)
    return scene


def point() -> g.Scene:
    scene = box("small spheres, point light", lamp_box=False, lamp=False)
    small_spheres(scene)
    scene.point_light("light", (0.0, -0.5, 1.0), [70 / (4 * math.pi)] * 3)
    return scene


def background() -> g.Scene:
    scene = box("small spheres, background", lamp_box=True, lamp=False)
    small_spheres(scene)
    sky = {"environment": {"radiance": [135 / 255, 206 / 255, 250 / 255]}}
    scene.gltf["scenes"][0]["extensions"] = {g.EXTENSION: sky}
    return scene


#: In the order of its option -s.
SCENES: dict[str, Callable[[], g.Scene]] = {
    "sun": sun,
    "ceiling": ceiling,
    "point": point,
    "background": background,
}


def write(name: str, folder: Path) -> Path:
    path = folder / f"smallvcm_{name}.gltf"
    path.write_text(SCENES[name]().text())
    return path
