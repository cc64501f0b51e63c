"""Pictures on materials made in code."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
import sunstone

SMALL = dict(width=4, height=4, spp=16, integrator="path", mode="scalar", color="rgb", seed=1)
COLORS = np.array(
    [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], dtype=np.uint8
)


def seen(bsdf: str, shape: sunstone.Geometry | None = None, **keys: object) -> np.ndarray:
    """The image of a quad, or shape, that fills the view."""
    world = sunstone.World("painted")
    world.add_material("painted", bsdf, two_sided=True, **keys)  # type: ignore[arg-type]
    quad = sunstone.Geometry.quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    world.add_mesh("quad", shape or quad, "painted")
    world.set_camera("eye", half_width=1, half_height=1, position=(0, 0, 2), target=(0, 0, 0))
    world.set_environment(1.0)
    return np.asarray(world.render(**SMALL).stokes[..., 0])


def test_pictures_are_arrays_paths_or_bytes(tmp_path: Path) -> None:
    nearest = dict(filter="nearest", coding="linear")
    texture = sunstone.Texture(COLORS, **nearest)  # type: ignore[arg-type]
    image = seen("absorber", emission=1.0, textures={"emission": texture})
    expected = np.repeat(np.repeat(COLORS / 255.0, 2, axis=0), 2, axis=1)
    assert np.allclose(image, expected, atol=1e-5)
    path = tmp_path / "colors.png"
    path.write_bytes(texture._keys["picture"])
    for same in [
        path,
        str(path),
        path.read_bytes(),
        (COLORS / np.float32(255)),
        COLORS.astype(np.uint16) * 257,
        np.dstack([COLORS, np.full((2, 2), 255, np.uint8)]),
    ]:
        other = sunstone.Texture(same, **nearest)  # type: ignore[arg-type]
        assert np.allclose(image, seen("absorber", emission=1.0, textures={"emission": other}))


def test_what_pictures_feed() -> None:
    gray = np.full((2, 2), 128, dtype=np.uint8)
    share = 128 / 255
    linear = sunstone.Texture(gray, coding="linear")
    for slot, bsdf, keys in [
        ("reflectance", "diffuse", {}),
        ("reflectance", "plastic", {"alpha": 0.2}),
        ("transmitted", "thin_dielectric", {}),
        ("reflected", "thin_dielectric", {}),
        ("reflected", "conductor", {"metal": "Al"}),
    ]:
        by_picture = seen(bsdf, textures={slot: linear}, **keys)
        plain = seen(bsdf, **{slot: share}, **keys)
        assert np.allclose(by_picture, plain, rtol=1e-4), (slot, bsdf)
        assert not np.allclose(plain, seen(bsdf, **{slot: 1.0}, **keys), rtol=1e-2)
    metal = dict(metal="Al")
    by_picture = seen("rough_conductor", textures={"alpha": gray}, **metal)
    assert np.allclose(by_picture, seen("rough_conductor", alpha=share, **metal), rtol=1e-4)
    halves = np.array([[0, 255]], dtype=np.uint8)
    holes = sunstone.Texture(halves, filter="nearest", cutoff=0.5)
    image = seen("absorber", textures={"coverage": holes})
    assert np.all(image[:, :2] == 1) and np.all(image[:, 2:] == 0)
    flat = sunstone.Texture(np.full((2, 2, 3), (128, 128, 255), np.uint8))
    ramp = sunstone.Texture(np.array([[0, 255]], dtype=np.uint8), scale=0.2)
    plain = seen("conductor", metal="Al")
    assert np.allclose(seen("conductor", metal="Al", textures={"normal": flat}), plain, rtol=1e-2)
    assert np.all(np.isfinite(seen("conductor", metal="Al", textures={"bump": ramp})))


def test_coordinates_of_geometry() -> None:
    quad = sunstone.Geometry.quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    assert quad.uv is not None and quad.uv.tolist() == [[0, 1], [1, 1], [1, 0], [0, 0]]
    bare = sunstone.Geometry(quad.positions, quad.triangles)
    assert bare.uv is None
    flipped = sunstone.Geometry(quad.positions, quad.triangles, uv=quad.uv[:, ::-1])
    for again in pickle.loads(pickle.dumps(flipped)), copy.deepcopy(flipped):
        assert again.uv.tolist() == flipped.uv.tolist()  # type: ignore[union-attr]
    texture = {"emission": sunstone.Texture(COLORS, filter="nearest", coding="linear")}
    image = seen("absorber", flipped, emission=1.0, textures=texture)
    upright = seen("absorber", emission=1.0, textures=texture)
    assert np.allclose(image, upright.transpose(1, 0, 2), atol=1e-5)
    assert not np.allclose(image, upright, atol=1e-2)
    with pytest.raises(sunstone.SceneError, match="TEXCOORD_0"):
        seen("absorber", bare, emission=1.0, textures=texture)
    with pytest.raises(sunstone.SceneError, match=r"uv: must have the shape \(count, 2\)"):
        sunstone.Geometry(quad.positions, quad.triangles, uv=quad.positions)


def test_worlds_with_pictures_pickle() -> None:
    world = sunstone.World("globe")
    world.add_material("globe", "absorber", emission=1.0, textures={"emission": COLORS})
    world.add_sphere("globe", 1.0, "globe")
    world.set_camera("eye", yfov=1.0, position=(0, -4, 0), target=(0, 0, 0), up=(0, 0, 1))
    image = world.render(**SMALL).stokes
    again = pickle.loads(pickle.dumps(world))
    assert np.array_equal(again.render(**SMALL).stokes, image)
    assert image[1:3, 1:3, :, 0].std() > 0.05


def test_wrong_textures_are_told() -> None:
    gray = np.full((2, 2), 128, dtype=np.uint8)
    for keys, expected in [
        (dict(bsdf="diffuse", textures={"shine": gray}), "shine means nothing"),
        (dict(bsdf="conductor", metal="Al", textures={"alpha": gray}), "no facets by a picture"),
        (dict(bsdf="diffuse", textures={"emission": gray}), "no emission"),
        (dict(bsdf="diffuse", textures={"transmitted": gray}), "is of glass that refracts"),
        (dict(bsdf="diffuse", transmitted=0.5), "is of glass that refracts"),
        (dict(bsdf="dielectric", textures={"coverage": gray}), "have no holes"),
        (dict(bsdf="diffuse", textures={"normal": gray, "bump": gray}), "keep one"),
        (dict(bsdf="diffuse", textures={"reflectance": b"no picture"}), "is of a format"),
        (
            dict(
                bsdf="diffuse",
                reflectance={"nm": [300, 900], "value": [0.1, 0.2]},
                textures={"reflectance": gray},
            ),
            "is given by wavelength",
        ),
        (
            dict(bsdf="diffuse", textures={"bump": sunstone.Texture(gray, wrap="zigzag")}),  # type: ignore[arg-type]
            "`zigzag` is not known",
        ),
    ]:
        world = sunstone.World("wrong")
        with pytest.raises(sunstone.SceneError, match=expected):
            world.add_material("wrong", **keys)  # type: ignore[arg-type]
    for wrong in np.zeros((2, 2, 5), np.uint8), np.zeros(3, np.uint8), np.zeros((0, 2), np.uint8):
        with pytest.raises(sunstone.SceneError, match="must have the shape"):
            sunstone.Texture(wrong)
    for array in np.zeros((2, 2), np.int64), np.zeros((2, 2, 4), np.float32):
        with pytest.raises(sunstone.SceneError, match="must be of integers"):
            sunstone.Texture(array)
    negative = np.full((2, 2, 3), -1.0, dtype=np.float32)
    world = sunstone.World("wrong")
    with pytest.raises(sunstone.SceneError, match="picture"):
        world.add_material("wrong", "diffuse", textures={"reflectance": negative})
    with pytest.raises(FileNotFoundError):
        sunstone.Texture("no/such/file.png")
