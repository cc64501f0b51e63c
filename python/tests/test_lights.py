"""Lights that files say more of: luminaires, projectors, and parameters of scenes that have them."""

import pathlib
import pickle
import struct
import zlib
from typing import Any

import numpy as np
import pytest

import sunstone

SMALL: dict[str, Any] = dict(
    width=12, height=12, spp=16, max_path_length=2, integrator="path", mode="scalar"
)

#: 10 candela all around.
EVEN = b"IES:LM-63-2019\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 180\n0\n10 10\n"


def png(rows: list[list[tuple[int, int, int]]]) -> bytes:
    """A picture of red, green and blue."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        checksum = struct.pack(">I", zlib.crc32(kind + body))
        return struct.pack(">I", len(body)) + kind + body + checksum

    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    texels = b"".join(b"\0" + bytes(value for texel in row for value in texel) for row in rows)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(texels)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def wall() -> sunstone.World:
    """A wall of reflectance 0.5 that fills the film."""
    world = sunstone.World("wall")
    world.add_material("wall", "diffuse", reflectance=0.5)
    quad = sunstone.Geometry.quad((0, 0, 0), (3, 0, 0), (0, 3, 0))
    world.add_mesh("wall", quad, "wall")
    world.set_camera("eye", yfov=0.2, position=(0, 0, 4), target=(0, 0, 0))
    return world


def test_luminaires_and_points_are_the_same() -> None:
    point, measured = wall(), wall()
    point.add_light("lamp", "point", 20.0, position=(0, 0, 2))
    measured.add_light("lamp", "point", 2.0, ies=EVEN, position=(0, 0, 2))
    expected, found = (world.render(**SMALL).stokes for world in (point, measured))
    assert np.allclose(found, expected, rtol=1e-4)
    again = pickle.loads(pickle.dumps(measured))
    assert np.array_equal(again.render(**SMALL).stokes, found)


def test_projectors_show_their_pictures() -> None:
    # Red to the left, and blue below it, on half of what is seen.
    red, blue, black = (255, 0, 0), (0, 0, 255), (0, 0, 0)
    world = wall()
    outer = float(np.arctan(np.tan(0.1) * 4 / 2))
    picture = png([[red, black], [blue, black]])
    world.add_light(
        "slides", "spot", 3.0, outer=outer, picture=picture, position=(0, 0, 2), target=(0, 0, 0)
    )
    found = world.render(**SMALL).stokes[..., 0]
    # The irradiance of a texel of 1 on a wall at 2 m, by the albedo over pi.
    full = 0.5 / np.pi * 3.0 / 4
    assert np.allclose(found[:2, :2], [full, 0, 0], rtol=1e-4)
    assert np.allclose(found[-2:, :2], [0, 0, full], rtol=1e-4)
    assert np.allclose(found[:, -2:], 0.0)


def test_what_is_wrong_with_lights_is_told() -> None:
    picture = png([[(1, 2, 3)]])
    cases: list[tuple[Any, dict[str, Any], str]] = [
        ("point", dict(ies=b"nothing"), "TILT"),
        ("point", dict(picture=picture), "picture means nothing"),
        ("spot", dict(outer=0.3, ies=EVEN), "ies means nothing"),
        ("spot", dict(outer=0.3, picture=b""), "picture"),
        ("spot", dict(outer=0.3, picture=png([[(0, 0, 0)]])), "black"),
        ("spot", dict(outer=1.57, picture=picture), "outer angle"),
        ("directional", dict(picture=picture), "picture means nothing"),
    ]
    for kind, more, text in cases:
        with pytest.raises(sunstone.SceneError, match=text):
            wall().add_light("lamp", kind, 1.0, **more)
    path: Any = "lamp.ies"
    with pytest.raises(TypeError):
        wall().add_light("lamp", "point", 1.0, ies=path)


def test_parameters_of_mitsuba_scenes_are_given(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "scene.xml"
    path.write_text("""<scene version="3.0.0"><default name="bright" value="1"/>
        <default name="kind" value="diffuse"/>
        <sensor type="perspective"><float name="fov" value="20"/>
            <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
            <film type="hdrfilm"><rfilter type="box"/></film></sensor>
        <shape type="rectangle"><bsdf type="$kind"/></shape>
        <emitter type="constant"><rgb name="radiance" value="$bright"/></emitter></scene>""")
    plain = sunstone.load(path).render(**SMALL).stokes
    defined = sunstone.load(path, define={"bright": 2})
    found = defined.render(**SMALL).stokes
    assert np.allclose(found, 2 * plain, rtol=1e-5)
    again = pickle.loads(pickle.dumps(defined))
    assert np.array_equal(again.render(**SMALL).stokes, found)
    with pytest.raises(sunstone.SceneError, match="dim"):
        sunstone.load(path, define={"dim": 2})


def test_spots_fall_off_as_they_say_and_tables_are_materials() -> None:
    quarter = np.float32(np.pi / 2)
    matrix = np.zeros((2, 2, 2, 2, 4, 4), np.float32)
    matrix[..., 0, 0] = 0.5 / np.pi
    fields = {
        "phi_d": (10, np.array([[-np.pi, np.pi]], np.float32)),
        "theta_d": (10, np.array([[0, quarter]], np.float32)),
        "theta_h": (10, np.array([[0, quarter]], np.float32)),
        "wvls": (3, np.array([400, 700], np.uint16)),
        "M": (10, matrix),
    }
    at = 18 + sum(13 + len(name) + 8 * array.ndim for name, (_, array) in fields.items())
    head = b"tensor_file\0\x01\x00" + len(fields).to_bytes(4, "little")
    for name, (kind, array) in fields.items():
        head += len(name).to_bytes(2, "little") + name.encode()
        head += array.ndim.to_bytes(2, "little") + bytes([kind]) + at.to_bytes(8, "little")
        head += b"".join(extent.to_bytes(8, "little") for extent in array.shape)
        at += array.nbytes
    table = head + b"".join(array.tobytes() for _, array in fields.values())

    def walls(falloff: str | None, **wall: object) -> sunstone.Image:
        world = sunstone.World("spot")
        world.add_material("wall", **wall)  # type: ignore[arg-type]
        square = sunstone.Geometry.quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
        world.add_mesh("wall", square, "wall")
        world.add_light(
            "lamp", "spot", 1.0, inner=0.1, outer=0.9, falloff=falloff,  # type: ignore[arg-type]
            position=(0, 0, 1), direction=(0, 0, -1),
        )
        world.set_camera(yfov=0.7, position=(0, 0, 2), target=(0, 0, 0), resolution=(9, 9))
        return world.place().render(integrator="path", spp=16, max_path_length=2, mode="scalar")

    even = walls("angle", bsdf="diffuse", reflectance=0.5).stokes[4, :, 0, 0]
    steep = walls(None, bsdf="diffuse", reflectance=0.5).stokes[4, :, 0, 0]
    # Straight below both are full; aside the one falls off evenly.
    assert abs(even[4] / steep[4] - 1) < 0.1 and even[1] != steep[1]
    angle = np.arctan(abs(1 - 4) * 2 * 2 * np.tan(0.35) / 9)
    full = 0.5 / np.pi * np.cos(angle) ** 3
    assert abs(even[1] / full - (0.9 - angle) / 0.8) < 0.05
    measured = walls("angle", bsdf="measured", table=table).stokes[4, :, 0, 0]
    assert np.allclose(measured, even, rtol=0.05)
    with pytest.raises(sunstone.SceneError, match="is not known"):
        walls("sharp", bsdf="absorber")
    with pytest.raises(sunstone.SceneError, match="table is missing"):
        walls(None, bsdf="measured")
