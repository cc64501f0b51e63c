"""What the tests share: scenes, and the program that the package has to agree with."""

from __future__ import annotations

import os
import pathlib
import subprocess
from collections.abc import Callable

import pytest

import sunstone

ROOT = pathlib.Path(__file__).resolve().parents[2]
CORNELL = ROOT / "scenes" / "cornell.gltf"

#: What a child tells when it has been stopped: when, and the seconds of a processor that it still
#: takes in half a second. What had begun may end first, which takes long without optimization.
SETTLED = (
    "    for _ in range(40):\n"
    "        cpu = time.process_time(); time.sleep(0.5); busy = time.process_time() - cpu\n"
    "        if busy < 0.1: break\n"
    "    print(stopped, busy, flush=True)\n"
)


@pytest.fixture(scope="session")
def cornell() -> sunstone.Scene:
    return sunstone.load(CORNELL)


@pytest.fixture(scope="session")
def program() -> Callable[..., None]:
    """Runs the program, which $SUNSTONE names, or which cargo has built."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    names = [os.environ.get("SUNSTONE"), target / "release/sunstone", target / "debug/sunstone"]
    found = next((str(name) for name in names if name and os.access(name, os.X_OK)), None)
    if found is None:
        pytest.skip("the program is not built: cargo build --release")

    def run(*arguments: object) -> None:
        words = [str(argument) for argument in arguments]
        subprocess.run([found, *words], check=True, capture_output=True, text=True)

    return run


@pytest.fixture
def room() -> sunstone.World:
    """A room with a lamp, a ball of glass and a plate of metal."""
    world = sunstone.World("room")
    world.add_material("wall", "diffuse", reflectance=0.7, two_sided=True)
    world.add_material("glass", "dielectric", ior=1.5)
    world.add_material("plate", "conductor", metal="Al")
    world.add_material("glow", "absorber", emission=[20, 18, 15], two_sided=True)
    world.add_mesh("walls", sunstone.Geometry.cuboid((-1, -1, -1), (1, 1, 1)), "wall")
    lamp = sunstone.Geometry.quad((0, 0.99, 0), (0.3, 0, 0), (0, 0, 0.3))
    world.add_mesh("lamp", lamp, "glow")
    plate = sunstone.Geometry.quad((0, 0, -0.9), (0.5, 0, 0), (0, 0.5, 0))
    world.add_mesh("plate", plate, "plate")
    world.add_sphere("ball", 0.4, "glass", position=(0.2, -0.6, 0))
    world.set_camera("eye", yfov=1.2, position=(0, 0, 0.9), target=(0, 0, 0), resolution=(32, 32))
    return world
