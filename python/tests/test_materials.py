"""Materials by keyword arguments, and what is said of those that are wrong."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import sunstone

SMALL: dict[str, Any] = dict(width=8, height=8, spp=16, integrator="path")


def through(bsdf: Any, options: dict[str, Any] = SMALL, **keys: Any) -> npt.NDArray[np.float32]:
    """Stokes vectors of a polarized lamp behind a sheet, or in a mirror where nothing goes through."""
    world = sunstone.World("sheet")
    world.add_material("sheet", bsdf, **keys)
    quad = sunstone.Geometry.quad((0, 0, 0), (3, 0, 0), (0, 3, 0))
    world.add_mesh("sheet", quad, "sheet")
    world.set_camera("eye", yfov=0.02, position=(0, 0, 4), target=(0, 0, 0))
    world.set_environment(2.0, stokes=(0.3, 0.4, 0.5))
    return world.render(**options).stokes


def test_sheets_of_matrices_do_what_others_do() -> None:
    polarizer = through("polarizer", axis_deg=30, transmittance=0.5, blocked=0.0)
    double = np.deg2rad(60)
    cosine, sine = np.cos(double), np.sin(double)
    # To light that goes to the back, counterclockwise about the normal is clockwise.
    along = np.array([1, cosine, -sine, 0])
    matrix = 0.25 * np.outer(along, along)
    assert np.allclose(through("mueller", matrix=matrix), polarizer, atol=1e-4)
    quarter = through("retarder", axis_deg=30, retardance_deg=90)
    # 550 nm alone, as a crystal has another retardance at every wavelength.
    green = SMALL | dict(color="mono", wavelength=550)
    crystal = through("retarder", green, axis_deg=30, birefringence=0.011, thickness_um=12.5)
    plate = through("retarder", green, axis_deg=30, retardance_deg=90)
    assert np.allclose(crystal, plate, atol=1e-5) and not np.allclose(quarter, polarizer, atol=0.1)
    # From the back to the front it is an analyzer: half of S0 + S3, or of S0 - S3.
    for hand, share in (("right", 0.5 * (2 + 1)), ("left", 0.5 * (2 - 1))):
        stokes = through("circular_polarizer", handedness=hand)
        assert np.allclose(stokes[..., 0], share, atol=1e-3), hand


def test_films_are_seen() -> None:
    bare = through("conductor", metal="Al")
    film = dict(eta=1.5, thickness_nm=0.0)
    assert np.allclose(through("conductor", metal="Al", film=film), bare, atol=1e-4)
    thick = through("conductor", metal="Al", film=dict(eta=2.2, thickness_nm=60))
    assert abs(thick[..., 2, 0].mean() / bare[..., 2, 0].mean() - 1) > 0.05


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        (dict(bsdf="mueller"), "material `m`, matrix is missing"),
        (dict(bsdf="mueller", matrix=np.eye(3)), "material `m`, matrix is not 4 by 4"),
        (dict(bsdf="conductor", metal="Xx"), "material `m`, metal: `Xx` is not tabulated"),
        (dict(bsdf="diffuse", alpha=1), "material `m`, alpha means nothing for a material of"),
        (dict(bsdf="diffuse", reflectance="Au"), "reflectance: `Au` is a name, and none are taken"),
        (dict(bsdf="diffuse", emission="D65"), 'emission: `D65` is a name: give {"illuminant"'),
        (dict(bsdf="conductor", metal="Al", film={"eta": 1}), "film, thickness_nm is missing"),
        (
            dict(bsdf="conductor", metal="Al", film={"eta": 1, "thickness_nm": 9}, emission=1)
            | dict(incandescent=True),
            "material `m`, incandescent does not go with film",
        ),
        (
            dict(bsdf="diffuse", textures={"reflectance": np.full((2, 2, 3), np.nan)}),
            "material `m`, textures, reflectance, picture has a value that is not a number",
        ),
        (
            dict(bsdf="polarizer", textures={"bump": np.zeros((2, 2))}),
            "material `m`, normals are by a texture, and sheets and null have none",
        ),
    ],
)
def test_errors_are_sentences(keys: dict[str, Any], text: str) -> None:
    with pytest.raises(sunstone.SceneError) as refused:
        sunstone.World().add_material("m", **keys)
    assert text in str(refused.value) and ": :" not in str(refused.value)


def test_files_are_named_once(tmp_path: pathlib.Path) -> None:
    for read, name in ((sunstone.load, "gone.gltf"), (sunstone.Image.load, "gone.exr")):
        gone = tmp_path / name
        with pytest.raises(FileNotFoundError) as found:
            read(gone)
        assert str(found.value) == f"[Errno 2] cannot read: No such file or directory: '{gone}'"
        assert found.value.filename == str(gone)
