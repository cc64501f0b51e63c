"""The package from outside: bits, arrays, errors, files, copies, processes, signals, memory."""

from __future__ import annotations

import copy
import gc
import inspect
import json
import math
import multiprocessing
import os
import pathlib
import pickle
import shutil
import signal
import stat
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import sunstone
from conftest import CORNELL, ROOT, SETTLED

SMALL: dict[str, Any] = dict(integrator="path", spp=2, width=16, height=16)

CASES: list[dict[str, Any]] = [
    {},
    dict(mode="scalar"),
    dict(mode="intensity", variance=True),
    dict(integrator="bdpt", seed=7, max_path_length=3, roulette_after=2),
    dict(integrator="light", color="mono"),
    dict(integrator="ppm", photons=2000, samples_per_iteration=2, spp=4, alpha=0.5, radius=0.1),
    dict(integrator="ppm", photons=1000, iterations=3, samples_per_iteration=3),
    dict(color="mono", wavelength=633.5, variance=True, replicates=2, spp=4),
    dict(color="spectral", wavelengths=4),
    dict(color="spectral", bands=(420, 660, 7), variance=True),
    dict(color="spectral", bands="450:650:3", range=(400, 700), rgb_white="d65", mode="scalar"),
    dict(color="spectral", bands="450x20,red=650x30", wavelengths=4),
    dict(color="spectral", responses="nikon-d5100", white_balance="D50", wavelengths=4),
    dict(color="spectral", responses="xyz", raw_response=True, mode="scalar", variance=True),
    dict(sampling="intensity", replicates=2, threads=1),
    dict(filter="mitchell", filter_radius=1.5, crop="25%,0%,75%,100%", pixel_aspect=2.0),
    dict(filter="gaussian", filter_samples="own", width=20, height=10),
    dict(integrator="auto", variance=True, spp=32, height=9, width=33),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: " ".join(case) or "defaults")
def test_bits_are_the_program_s(
    case: dict[str, Any],
    cornell: sunstone.Scene,
    program: Callable[..., None],
    tmp_path: pathlib.Path,
) -> None:
    OpenEXR = pytest.importorskip("OpenEXR")
    options = {**SMALL, **case}
    if "iterations" in options:
        del options["spp"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sunstone.RenderWarning)
        image = cornell.render(**options)
    words = []
    for name, value in options.items():
        words.append("--" + name.replace("_", "-"))
        numbers = ":".join(map(str, value)) if isinstance(value, tuple) else value
        words += [] if value is True else [numbers]
    program("render", CORNELL, "-o", tmp_path / "a.exr", *words)
    image.save(tmp_path / "b.exr")
    channels = {}
    for name in "a", "b":
        file = OpenEXR.File(str(tmp_path / f"{name}.exr"), separate_channels=True)
        channels[name] = {key: value.pixels for key, value in file.channels().items()}
    assert channels["a"].keys() == channels["b"].keys()
    for key, pixels in channels["a"].items():
        assert np.array_equal(pixels, channels["b"][key]), key
    # And where they stand in the arrays, by a stranger's reading of the file.
    rgb, components = image.channels == ("R", "G", "B"), image.stokes.shape[3]
    colors = [".R", ".G", ".B"] if rgb else [""]
    if image.bands is not None:
        colors = [f".{band.center_nm:.6f}nm".replace(".", ",") for band in image.bands]
        colors = ["." + color[1:] for color in colors]
    elif image.responses is not None:
        colors = [f".{name}" for name in image.channels]
    for array, prefix in (image.stokes, ""), (image.variance, "variance."):
        for channel, color in enumerate(colors):
            for component in range(components):
                key = f"{prefix}S{component}{color}"
                if components == 1 and rgb and not prefix:
                    key = color[1:]
                if array is None:
                    assert key not in channels["a"]
                else:
                    assert np.array_equal(channels["a"][key], array[:, :, channel, component]), key


def test_defaults_are_the_program_s(
    cornell: sunstone.Scene, program: Callable[..., None], tmp_path: pathlib.Path
) -> None:
    program("render", CORNELL, "-o", tmp_path / "a.exr", "--width", 12)
    image = cornell.render(width=12)
    again = sunstone.Image.load(tmp_path / "a.exr")
    assert np.array_equal(again.stokes, image.stokes) and again.variance is None
    own = {"scene", "seconds", "command"}
    facts = {key: text for key, text in again.metadata.items() if key not in own}
    assert facts == {key: text for key, text in image.metadata.items() if key not in own}
    names = list(inspect.signature(sunstone.Scene.render).parameters)
    assert len(names) == len(set(names)) == 36


def test_arrays_are_as_promised(cornell: sunstone.Scene) -> None:
    image = cornell.render(**SMALL, variance=True)
    for array in (image.stokes, image.variance):
        assert array is not None and array.dtype == np.float32 and array.shape == (16, 16, 3, 4)
        assert array.flags.c_contiguous and array.flags.writeable and array.flags.owndata
    assert image.stokes is image.stokes
    assert cornell.render(**SMALL, mode="scalar").stokes.shape == (16, 16, 3, 1)
    assert cornell.render(**SMALL, color="mono", mode="intensity").stokes.shape == (16, 16, 1, 1)
    assert cornell.render(integrator="path", spp=1, width=5, height=3).stokes.shape == (3, 5, 3, 4)


def test_maps_follow_their_formulas() -> None:
    stokes = np.zeros((1, 6, 1, 4), np.float32)
    stokes[0, :, 0] = [
        [1, 0.5, 0, 0],
        [2, 0, 1, 0],
        [2, 0, 0, -2],
        [1, -0.3, 0, 0.4],
        [0, 0, 0, 0],
        [1, 0, -1, 0],
    ]
    image = sunstone.Image(stokes, wavelength_nm=550)
    np.testing.assert_allclose(image.dop[0, :, 0], [0.5, 0.5, 1, 0.5, 0, 1], rtol=1e-6)
    angles = np.array([0, 45, 0, 90, 0, 135])
    np.testing.assert_allclose(np.degrees(image.aolp[0, :, 0]) % 180, angles, atol=1e-4)
    assert image.dop.dtype == image.aolp.dtype == np.float32
    assert image.channels == ("550 nm",) and image.wavelength_nm == 550
    almost = np.array([1, 1, -1e-30, 0], np.float32).reshape(1, 1, 1, 4)
    assert sunstone.Image(almost, wavelength_nm=550).aolp[0, 0, 0] < math.pi


def test_pictures_have_their_legends(cornell: sunstone.Scene) -> None:
    def size(png: bytes) -> tuple[int, int]:
        assert png.startswith(b"\x89PNG\r\n\x1a\n")
        return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")

    image = cornell.render(**SMALL)
    panels, one = size(image._repr_png_()), size(image.png("dop"))
    assert panels[0] > 2 * one[0] and one[0] >= 16 and one[1] > 16
    scalar = cornell.render(**SMALL, mode="scalar")
    assert scalar._repr_png_() == scalar.png("intensity")
    with pytest.raises(sunstone.Error, match="polarized"):
        scalar.png("dop")
    with pytest.raises(sunstone.Error, match="there is no map \"hue\"; known are"):
        image.png("hue")


def test_files_keep_what_is_written_to_the_array(
    cornell: sunstone.Scene, tmp_path: pathlib.Path
) -> None:
    image = cornell.render(**SMALL, variance=True)
    image.stokes[3, 4, 1, 2] = 7.5
    image.metadata["note"] = "edited"
    image.save(tmp_path / "a name with spaces.exr")
    again = sunstone.Image.load(tmp_path / "a name with spaces.exr")
    assert again.stokes[3, 4, 1, 2] == 7.5 and again.metadata["note"] == "edited"
    assert image.variance is not None and again.variance is not None
    assert np.array_equal(again.variance, image.variance)
    assert list(again.metadata) == list(image.metadata)
    image.save(str(tmp_path / "b.hdr"))
    image.save(tmp_path / "c.png")
    names = [f"b.S{component}.hdr" for component in range(4)]
    assert sorted(os.listdir(tmp_path)) == ["a name with spaces.exr", *names, "c.png"]


def test_errors_have_their_classes(cornell: sunstone.Scene, tmp_path: pathlib.Path) -> None:
    assert issubclass(sunstone.SceneError, (sunstone.Error, ValueError))
    assert issubclass(sunstone.RenderError, sunstone.Error)
    assert not issubclass(sunstone.RenderError, ValueError)
    with pytest.raises(FileNotFoundError, match="none.gltf") as found:
        sunstone.load(tmp_path / "none.gltf")
    assert found.value.filename == str(tmp_path / "none.gltf")
    (tmp_path / "bad.gltf").write_text("{")
    with pytest.raises(sunstone.SceneError, match="bad.gltf"):
        sunstone.load(tmp_path / "bad.gltf")
    with pytest.raises(sunstone.SceneError, match="camera"):
        sunstone.load(CORNELL, camera="nobody's")
    image = cornell.render(**SMALL)
    with pytest.raises(FileNotFoundError, match="create the folder"):
        image.save(tmp_path / "no" / "a.exr")
    with pytest.raises(IsADirectoryError):
        (tmp_path / "folder.exr").mkdir()
        image.save(tmp_path / "folder.exr")
    with pytest.raises(sunstone.Error, match="extension must be one of"):
        image.save(tmp_path / "a.tiff")
    with pytest.raises(FileNotFoundError):
        sunstone.Image.load(tmp_path / "none.exr")
    (tmp_path / "bad.exr").write_bytes(b"no image")
    with pytest.raises(sunstone.Error, match="bad.exr"):
        sunstone.Image.load(tmp_path / "bad.exr")
    (tmp_path / "kept.exr").write_bytes(b"")
    (tmp_path / "kept.exr").chmod(stat.S_IRUSR)
    with pytest.raises(PermissionError, match="read-only"):
        image.save(tmp_path / "kept.exr")
    assert os.path.getsize(tmp_path / "kept.exr") == 0
    pickled = pickle.loads(pickle.dumps(sunstone.SceneError("text")))
    assert isinstance(pickled, sunstone.SceneError) and str(pickled) == "text"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no full device")
def test_a_device_is_not_replaced(cornell: sunstone.Scene, tmp_path: pathlib.Path) -> None:
    (tmp_path / "full.exr").symlink_to("/dev/full")
    with pytest.raises(OSError, match="a device or pipe"):
        cornell.render(**SMALL).save(tmp_path / "full.exr")


REFUSED: list[tuple[dict[str, Any], str]] = [
    (dict(spp=0), r"spp must be from 1 to 1073741824, not 0"),
    (dict(spp=-1), r"spp must be a whole number from 0 to 4294967295, not -1"),
    (dict(seed=2**32), r"seed must be a whole number"),
    (dict(width=0), r"width must be from 1 to 65535, not 0"),
    (dict(width=65535, height=65535), r"too large: a film has|memory"),
    (dict(max_path_length=0), r"max_path_length must be from 1 to"),
    (dict(integrator="magic"), r'integrator must be one of auto, .*path.*, not "magic"'),
    (dict(mode="Polarized"), r"mode must be one of scalar, intensity, polarized, not"),
    (dict(color="rgb", rgb_white="e"), r"rgb_white goes with light at wavelengths"),
    (dict(color="mono", rgb_white="d50"), r"rgb_white must be one of d65, e"),
    (dict(color="rgb", wavelength=500), r"wavelength goes with color=\"mono\""),
    (dict(color="mono", wavelength=math.nan), r"wavelength must be from 1 to 1000000 nanometers"),
    (dict(bands=(400, 700, 31)), r"^bands goes with color=\"spectral\""),
    (dict(color="mono", wavelengths=4), r"^wavelengths goes with color=\"spectral\""),
    (dict(color="spectral", wavelength=500), r"^wavelength goes with color=\"mono\"; color=\"spec"),
    (dict(color="spectral", wavelengths=5), r"^wavelengths must be 4 or 8, not 5"),
    (dict(color="spectral", range=(700, 400)), r"^range must go from a shorter .* not 700:400"),
    (dict(color="spectral", range="400"), r"^range: it is two wavelengths, .* not 400"),
    (dict(color="spectral", bands=(400, 700)), r"^bands: it is the centers .* not 400:700"),
    (dict(color="spectral", bands=(400, 700, 3.5)), r"^bands: it is .* not 400:700:3.5"),
    (dict(color="spectral", bands=(700, 400, 3)), r"^bands go from 700 down to 400 nm; turn them"),
    (dict(color="spectral", bands=(400, math.inf, 3)), r"^bands from 400 to inf nm are no wavel"),
    (dict(color="spectral", bands=(), range=(400, 700)), r"^bands: it is the centers"),
    (dict(color="spectral", bands="a.csv", responses="xyz"), r"^bands and responses cannot both"),
    (dict(color="spectral", responses="kodak"), r"^responses kodak is not known: use one of"),
    (dict(color="spectral", responses="no.csv"), r"^cannot read no.csv"),
    (dict(color="spectral", raw_response=True), r"^raw_response"),
    (dict(color="rgb", responses="xyz"), r"^responses goes with color=\"spectral\""),
    (dict(color="spectral", white_balance="blue"), r"^white_balance: "),
    (
        dict(color="spectral", bands=(400, 700, 31), range=(400, 700)),
        r"^bands must be within range 400:700, and 400 nm reaches from 395 to 405 nm",
    ),
    (dict(integrator="path", photons=10), r"photons goes with integrator=\"ppm\""),
    (dict(integrator="ppm", alpha=0), r"alpha must be greater than 0 and at most 1, not 0"),
    (dict(spp=4, iterations=4), r"spp and iterations cannot both be given"),
    (dict(spp=3, replicates=4), r"replicates must be from 1 to the number of iterations"),
    (dict(spp=1, variance=True), r"variance needs two iterations or more"),
    (dict(time_limit=-1), r"time_limit must be a number of seconds, not -1"),
    (dict(time_limit=math.nan), r"time_limit must be a number of seconds, not NaN"),
    (dict(threads=0), r"threads must be from 1 to 4096, not 0"),
    (dict(threads=10**6), r"threads must be from 1 to 4096, not 1000000"),
]


@pytest.mark.parametrize(("options", "text"), REFUSED, ids=lambda value: str(value)[:30])
def test_options_are_refused_by_name(
    options: dict[str, Any], text: str, cornell: sunstone.Scene
) -> None:
    with pytest.raises(sunstone.RenderError, match=text):
        cornell.render(**options)


def test_what_is_no_option_is_a_type_error(cornell: sunstone.Scene) -> None:
    with pytest.raises(TypeError, match="sppp"):
        cornell.render(sppp=3)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="'sppp' is not an option of render; these are: integr"):
        cornell.notes(sppp=3)
    with pytest.raises(TypeError, match="spp"):
        cornell.render(spp="many")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="spp"):
        cornell.render(spp=1.5)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="range"):
        cornell.render(color="spectral", range=380)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="bands must be a number, not True or False"):
        cornell.render(color="spectral", bands=(400, 700, True))
    assert cornell.render(**{**SMALL, "spp": np.int64(2)}).stokes.shape == (16, 16, 3, 4)


def test_warnings_are_python_s(tmp_path: pathlib.Path, room: sunstone.World) -> None:
    text = CORNELL.read_text().replace('"extensionsUsed": [', '"extensionsUsed": ["ACME_x", ', 1)
    (tmp_path / "odd.gltf").write_text(text)
    with pytest.warns(sunstone.SceneWarning, match="ACME_x") as caught:
        scene = sunstone.load(tmp_path / "odd.gltf", allow_outside=True)
    assert caught[0].filename == __file__
    assert any("ACME_x" in warning for warning in scene.warnings)
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        room.render(integrator="path", spp=1, max_path_length=1, width=1, height=1)
    assert {(it.filename, it.category) for it in heard} == {(__file__, sunstone.RenderWarning)}
    assert any("the image is black" in str(it.message) for it in heard)
    assert any("auto" in note or "chosen" in note for note in scene.notes())


def test_what_an_image_lacks_is_told(cornell: sunstone.Scene) -> None:
    options: dict[str, Any] = {"spp": 1, "width": 16, "threads": 1}
    with pytest.warns(sunstone.RenderWarning, match="cannot see through solid glass") as caught:
        cornell.render(integrator="light", **options)
    assert caught[0].filename == __file__
    assert any("solid glass" in note for note in cornell.notes(integrator="light"))
    cornell.render(integrator="bdpt", **options)


def test_nothing_is_printed() -> None:
    code = (
        "import sunstone, warnings; warnings.simplefilter('ignore')\n"
        f"s = sunstone.load({str(CORNELL)!r}); s.render(spp=1, width=8); s.notes()\n"
        "try: s.render(spp=0)\nexcept sunstone.Error: pass"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stdout == b"" and done.stderr == b""


def test_worlds_go_on_after_a_render(room: sunstone.World) -> None:
    before = room.render(**SMALL)
    assert np.array_equal(room.render(**SMALL).stokes, before.stokes)
    room.add_sphere("other", 0.2, "plate", position=(-0.4, -0.8, 0.2))
    after = room.render(**SMALL)
    assert not np.array_equal(after.stokes, before.stokes)
    scene = room.place()
    assert np.array_equal(scene.render(**SMALL).stokes, after.stokes)


def test_bands_are_channels(room: sunstone.World, tmp_path: pathlib.Path) -> None:
    options = dict(**SMALL, color="spectral", variance=True)
    image = room.render(**options, bands=np.array([420, 660, 7]))
    assert image.stokes.shape == (16, 16, 7, 4) and image.wavelength_nm is None
    assert image.bands is not None and image.wavelengths_nm is not None
    assert image.bands[2] == ("500 nm", 500.0, 40.0) and image.bands[2].width_nm == 40
    assert image.wavelengths_nm.dtype == np.float32
    assert image.wavelengths_nm.tolist() == [420, 460, 500, 540, 580, 620, 660]
    assert image.channels == tuple(f"{nm} nm" for nm in (420, 460, 500, 540, 580, 620, 660))
    assert "7 bands from 420 to 660 nm, with variances" in repr(image)
    assert image.dop.shape == image.aolp.shape == (16, 16, 7)
    one = image.at(612)
    assert one.wavelength_nm == 620 and one.wavelengths_nm is not None
    assert np.array_equal(one.stokes, image.stokes[:, :, 5:6]) and one.variance is not None
    assert np.array_equal(one.variance, image.variance[:, :, 5:6])  # type: ignore[index]
    with pytest.raises(sunstone.Error, match="7 bands from 420 to 660 nm, and none of that has 7"):
        image.at(700)
    image.save(tmp_path / "bands.exr")
    others = [sunstone.Image.load(tmp_path / "bands.exr"), copy.copy(image)]
    others += [pickle.loads(pickle.dumps(image)), copy.deepcopy(image)]
    for other in others:
        assert np.array_equal(other.stokes, image.stokes) and other.bands == image.bands
        assert np.array_equal(other.variance, image.variance)  # type: ignore[arg-type]
        assert other.metadata == image.metadata
    with pytest.raises(sunstone.Error, match="7 bands"):
        image.save(tmp_path / "bands.hdr")
    for picture in image._repr_png_(), image.png("aolp"), one.png("intensity"):
        assert picture.startswith(b"\x89PNG")
    plain = room.render(**options)
    assert plain.bands is None and plain.wavelengths_nm is None and plain.channels[0] == "R"
    with pytest.raises(sunstone.Error, match="the image has RGB, and none of that has 550 nm"):
        plain.at(550)


def test_responses_are_channels(room: sunstone.World, tmp_path: pathlib.Path) -> None:
    options = dict(**SMALL, color="spectral", wavelengths=4)
    image = room.render(**options, responses="nikon-d5100", white_balance="3200K", variance=True)
    assert image.channels == ("red", "green", "blue") and image.bands is None
    assert image.stokes.shape == (16, 16, 3, 4) and image.responses is not None
    assert image.wavelengths_nm is not None
    red, green, blue = image.wavelengths_nm
    assert 560 < red < 640 and 500 < green < 560 and 430 < blue < 500
    image.save(tmp_path / "a.exr")
    others = [sunstone.Image.load(tmp_path / "a.exr"), pickle.loads(pickle.dumps(image))]
    others.append(sunstone.Image(image.stokes, responses=image.responses))
    for other in others:
        assert np.array_equal(other.stokes, image.stokes) and other.responses == image.responses
    assert "red, green, blue" in repr(image) and image._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(sunstone.Error, match="responses: this is not what"):
        sunstone.Image(image.stokes, responses="nikon-d5100")
    with pytest.raises(sunstone.Error, match="an image of 3 responses has"):
        sunstone.Image(image.stokes[:, :, :2], responses=image.responses)
    (tmp_path / "two.csv").write_text("wavelength_nm,a,b\n450,0,0\n550,1,0\n650,0,1\n")
    other = room.render(**options, responses=str(tmp_path / "two.csv"))
    assert other.channels == ("a", "b")


def test_bands_are_named_by_who_makes_an_image(tmp_path: pathlib.Path) -> None:
    values = np.random.default_rng(1).random((2, 3, 2, 1), np.float32)
    image = sunstone.Image(values, bands=[("NIR", 850, 40), sunstone.Band("SWIR", 1600.1, 90)])
    assert image.channels == ("NIR", "SWIR") and image.bands is not None
    assert image.bands[1].center_nm == np.float32(1600.1)
    assert "NIR, SWIR" in repr(image) and image._repr_png_().startswith(b"\x89PNG")
    image.save(tmp_path / "a.exr")
    again = sunstone.Image.load(tmp_path / "a.exr")
    assert again.bands == image.bands and np.array_equal(again.stokes, values)
    for bands, text in (
        ([("a", 500, 10)], r"must be \(height, width, 1, 1 or 4\), as an image of 1 bands has"),
        ([("b", 600, 10), ("a", 500, 10)], r"at 600 nm and then at 500 nm; sort them"),
        ([("a", 500, 10), ("a", 600, 10)], r'called "a" twice'),
        ([("a", 500, 0), ("b", 600, 1)], r"bands\[0\].width"),
        ([("a", math.nan, 1), ("b", 600, 1)], r"bands\[0\].center"),
        ([], r"bands are 0, and there must be"),
    ):
        with pytest.raises(sunstone.Error, match=text):
            sunstone.Image(values, bands=bands)
    with pytest.raises(sunstone.Error, match="wavelength_nm and bands cannot both be given"):
        sunstone.Image(values, bands=[("a", 1, 1), ("b", 2, 1)], wavelength_nm=550)


def test_glass_of_worlds_disperses() -> None:
    """One wavelength and another are refracted otherwise, and only where an index depends on it."""
    world = sunstone.World("prism")
    world.add_material("glass", "dielectric", ior="SF10")
    world.add_material("sky", "diffuse", reflectance=0.5, emission=1.0, two_sided=True)
    world.add_sphere("ball", 0.5, "glass")
    world.add_mesh("floor", sunstone.Geometry.quad((0, 0, -2), (1, 0, 0), (0, 1, 0)), "sky")
    world.set_camera(yfov=0.8, position=(0, 0, 2), target=(0, 0, 0))
    options = dict(integrator="path", color="mono", spp=1, width=24, height=24, seed=3)

    def at(nm: float) -> Any:
        return world.render(wavelength=nm, **options).stokes

    assert not np.array_equal(at(450), at(650))
    world["glass"].ior = {"cauchy": {"a": 1.5, "b_um2": 0.01, "range_nm": [350, 900]}}
    assert not np.array_equal(at(450), at(650))
    world["glass"].ior = 1.7
    assert np.array_equal(at(450), at(650))
    with pytest.raises(sunstone.SceneError, match="material `glass`, ior: `BK77` is no substance"):
        world["glass"].ior = "BK77"
    world["glass"].ior = "BK7"
    # Spectra of edits are those of what was made so.
    world["sky"].emission = {"illuminant": "D65"}
    # In so many iterations every band has a wavelength of light that disperses.
    spectral = dict(options, color="spectral", bands=(450, 650, 5), spp=32)
    image = world.render(**spectral)
    assert np.isfinite(image.stokes).all() and image.stokes[..., 0].max() > 0
    scene = world.place()
    assert np.array_equal(scene.render(**spectral).stokes, image.stokes)
    scene["glass"].ior = "SF10"
    assert not np.array_equal(scene.render(**spectral).stokes, image.stokes)
    del scene["glass"].ior
    assert np.array_equal(scene.render(**spectral).stokes, image.stokes)
    scene["glass"].ior = {"nm": [450, 650], "value": [1.6, 1.5]}
    with pytest.raises(sunstone.SceneError, match="`glass`, ior covers 450 to 650 nm only.*425"):
        scene.render(**spectral)
    with pytest.warns(sunstone.RenderWarning, match="glass"):
        held = scene.render(**spectral, hold_spectra=True)
    assert np.isfinite(held.stokes).all()


def test_files_take_spectra_as_edits(cornell: sunstone.Scene) -> None:
    scene = copy.copy(cornell)
    # In so many iterations every band has a wavelength of light that disperses.
    spectral = dict(SMALL, color="spectral", bands=(450, 650, 5), spp=32)
    before = scene.render(**spectral)
    scene["materials/glass/ior"] = "SF10"
    other = scene.render(**spectral)
    assert not np.array_equal(before.stokes, other.stokes)
    with pytest.raises(sunstone.SceneError, match="glass.*ior"):
        scene["materials/glass/ior"] = "N-BK77"
    del scene["glass"].ior
    assert np.array_equal(scene.render(**spectral).stokes, before.stokes)


def test_worlds_know_names_of_spectra() -> None:
    world = sunstone.World("shop")
    cauchy = {"cauchy": {"a": 1.5046, "b_um2": 0.0042, "range_nm": [350, 900]}}
    world.add_material("mirror", "conductor", eta="Ag", k="Ag")
    world.add_material("glass", "dielectric", ior="BK7", exterior_ior=cauchy)
    world.add_material("window", "diffuse", emission={"illuminant": "D65", "scale": 2})
    world.add_light("bulb", "point", {"blackbody_k": 2700})
    world.add_light("laser", "point", {"lines": [[532, 1, 0.1]], "shape": "box"})
    world.set_environment({"nm": [300, 900], "value": [1, 2], "scale": 0.5})


def test_worlds_refuse_what_is_wrong(room: sunstone.World) -> None:
    def refused(text: str) -> Any:
        return pytest.raises(sunstone.SceneError, match=text)

    quad = sunstone.Geometry.quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    with refused("material `wall`: there is one of this name already"):
        room.add_material("wall", "diffuse")
    with refused("material `x`, ior means nothing for a material of bsdf \"diffuse\""):
        room.add_material("x", "diffuse", ior=1.5)
    with refused("material `x`, bsdf: `velvet` is not a model"):
        room.add_material("x", "velvet")  # type: ignore[arg-type]
    with refused("`Xx` is not tabulated"):
        room.add_material("x", "conductor", metal="Xx")
    with refused("material `x`, eta: `Xx` is no substance in the tables"):
        room.add_material("x", "conductor", eta="Xx", k="Ag")
    with refused("material `x`, ior: `Ag` is a metal"):
        room.add_material("x", "dielectric", ior="Ag")
    with refused("material `x`, emission, illuminant: `D66` is no illuminant"):
        room.add_material("x", "diffuse", emission={"illuminant": "D66"})
    with refused("material `x`, reflectance: a spectrum is a number"):
        room.add_material("x", "diffuse", reflectance=[1, 2])
    with refused("material `x`, reflectance: 1.5 must be within"):
        room.add_material("x", "diffuse", reflectance={"nm": [400, 700], "value": [0.5, 1.5]})
    with refused("mesh `m`, material: there is no material `gold`; there are: glass, glow"):
        room.add_mesh("m", quad, "gold")
    with refused("an opaque surface has nothing behind it"):
        room.add_mesh("m", quad, "wall", interior="none")
    with refused("transform is singular"):
        room.add_mesh("m", quad, "wall", transform=np.zeros((4, 4)) + np.diag([0, 0, 0, 1]))
    with refused("last row of the matrix"):
        room.add_mesh("m", quad, "wall", transform=np.eye(4).T + np.eye(4, k=-3))
    with refused("its place is given twice"):
        room.add_mesh("m", quad, "wall", transform=np.eye(4), position=(0, 0, 0))
    with refused("sphere `s`, radius: -1 must be"):
        room.add_sphere("s", -1.0, "wall")
    with refused("triangle 0 has no area"):
        line = sunstone.Geometry(np.zeros((3, 3), np.float32), np.array([[0, 1, 2]], np.uint32))
        room.add_mesh("m", line, "wall")
    with refused("takes either `yfov` or both"):
        room.set_camera("c")
    with refused("singular or not finite"):
        room.set_camera("c", yfov=1.0, position=(1, 1, 1), target=(1, 1, 1))
    with refused("medium `fog`, sigma_a is missing"):
        room.add_medium("fog", "isotropic", sigma_s=1.0)
    with refused("medium `fog`, particles\\[0\\], distribution, of is missing"):
        beads = {"kind": "gamma", "mean_um": 1, "sd_um": 0.1}
        part = {"distribution": beads, "eta": 1.5, "volume_fraction": 0.1}
        room.add_medium("fog", "mie", particles=[part], host={"eta": 1.33})
    with refused("environment"):
        room.set_environment(-1.0)
    with refused("spot"):
        room.add_light("l", "spot", 1.0, outer=3.0)
    with refused("the world has no camera"):
        sunstone.World("empty").place()
    assert room.render(**SMALL).stokes.shape == (16, 16, 3, 4)


def test_geometries_are_refused_by_shape() -> None:
    with pytest.raises(sunstone.SceneError, match=r"positions: must have the shape \(count, 3\)"):
        sunstone.Geometry(np.zeros((3, 2)), np.zeros((1, 3)))
    with pytest.raises(sunstone.SceneError, match="triangles: 7 is not one of the 3"):
        world = sunstone.World()
        world.add_material("m", "diffuse")
        corners = np.eye(3)
        world.add_mesh("m", sunstone.Geometry(corners, [[0, 1, 7]]), "m")
    with pytest.raises(sunstone.SceneError, match="triangles: .*whole numbers"):
        sunstone.Geometry(np.eye(3), [[0, 1, -1]])
    with pytest.raises(sunstone.SceneError, match="triangles: .*whole numbers"):
        sunstone.Geometry(np.eye(3), [[0, 1, 1.5]])
    mesh = sunstone.Geometry(np.eye(3)[::-1], np.array([[0, 1, 2]]), normals=np.ones((3, 3)))
    assert np.array_equal(mesh.positions, np.eye(3)[::-1]) and mesh.triangles.dtype == np.uint32
    assert mesh.normals is not None and mesh.normals.shape == (3, 3)


@pytest.mark.filterwarnings("ignore:points or directions light mirrors:sunstone.RenderWarning")
def test_everything_pickles_and_copies(cornell: sunstone.Scene, room: sunstone.World) -> None:
    fog = room  # with a medium, a light and a shared mesh besides
    fog.add_medium("fog", "hg", sigma_a=0.1, sigma_s=[0.1, 0.2, 0.3], g=0.5)
    fog.set_scene_medium("fog")
    fog.add_light("spot", "spot", 1.0, outer=0.5, position=(0, 0.9, 0), direction=(0, -1, 0))
    pane = sunstone.Geometry([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
    fog.add_mesh("a", pane, "wall")
    fog.add_mesh("b", pane, "wall", position=np.array([0.2, 0, 0]))
    for thing in (cornell, fog, fog.place(), copy.deepcopy(fog), copy.copy(cornell)):
        expected = thing.render(**SMALL).stokes
        for protocol in (2, pickle.HIGHEST_PROTOCOL):
            same = pickle.loads(pickle.dumps(thing, protocol))
            assert np.array_equal(same.render(**SMALL).stokes, expected)
        assert np.array_equal(copy.deepcopy(thing).render(**SMALL).stokes, expected)
    expected = fog.render(**SMALL).stokes
    other = copy.deepcopy(fog)
    other.add_sphere("s", 0.3, "plate")
    assert np.array_equal(fog.render(**SMALL).stokes, expected)
    image = cornell.render(**SMALL, variance=True, color="mono")
    for same in (pickle.loads(pickle.dumps(image)), copy.deepcopy(image)):
        assert np.array_equal(same.stokes, image.stokes) and same.channels == image.channels
        assert same.stokes is not image.stokes and same.metadata == image.metadata
        assert same.variance is not None and image.variance is not None
        assert np.array_equal(same.variance, image.variance)


def test_what_was_given_may_change(room: sunstone.World) -> None:
    color = [0.5, 0.5, 0.5]
    room.add_material("grey", "diffuse", reflectance=color)
    color[0] = 7
    place = np.eye(4)
    room.add_sphere("s", 0.1, "grey", transform=place)
    place[:] = 0
    room.render(**SMALL)
    room.add_sphere("t", 0.1, "grey", position=(0.5, 0, 0))
    room.render(**SMALL)


def test_several_threads_agree(cornell: sunstone.Scene) -> None:
    expected = [cornell.render(**SMALL, seed=seed).stokes for seed in range(4)]
    scene = sunstone.load(CORNELL)
    wrong: list[int] = []

    def work(seed: int) -> None:
        for threads in (None, 1, 2):
            image = scene.render(**SMALL, seed=seed, threads=threads)
            if not np.array_equal(image.stokes, expected[seed]):
                wrong.append(seed)

    workers = [threading.Thread(target=work, args=(index % 4,)) for index in range(8)]
    [worker.start() for worker in workers]
    [worker.join(60) for worker in workers]
    assert not wrong and not any(worker.is_alive() for worker in workers)


def test_the_interpreter_stays_free(cornell: sunstone.Scene) -> None:
    done = threading.Event()
    options: Any = dict(integrator="path", time_limit=1.0, spp=10**6, width=32)
    worker = threading.Thread(
        target=lambda: (cornell.render(**options), done.set())
    )
    worker.start()
    turns, longest, last = 0, 0.0, time.monotonic()
    while not done.is_set():
        time.sleep(0.005)
        turns, longest, last = turns + 1, max(longest, time.monotonic() - last), time.monotonic()
    worker.join()
    assert turns > 20 and longest < 0.5


def test_what_progress_raises_ends_the_render(cornell: sunstone.Scene) -> None:
    def progress(done: int, total: int) -> None:
        raise LookupError(f"{done} of {total}")

    start = time.monotonic()
    with pytest.raises(LookupError, match="of 1000000"):
        cornell.render(integrator="path", spp=10**6, width=16, height=16, progress=progress)
    assert time.monotonic() - start < 10


@pytest.mark.parametrize("integrator", ["path", "ppm"])
def test_ctrl_c_ends_a_render_within_a_second(integrator: str) -> None:
    code = (
        "import signal, sunstone, time\n"
        # Whoever starts the tests in the background has children ignore it.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"s = sunstone.load({str(CORNELL)!r})\n"
        "for _ in range(2):\n"
        "    cpu = time.process_time()\n"
        f"    s.render(integrator={integrator!r}, spp=4, width=16, height=16)\n"
        # Without optimization all takes dozens of times as long, what cannot be stopped, too.
        "edge = 2000 if time.process_time() - cpu < 0.15 else 100\n"
        "print('ready', flush=True)\n"
        "try:\n"
        f"    s.render(integrator={integrator!r}, spp=10**6, width=edge, height=edge)\n"
        "except KeyboardInterrupt:\n"
        "    stopped = time.monotonic()\n"
        "    s.render(integrator='path', spp=1, width=4, height=4)\n" + SETTLED
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        time.sleep(1.5)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    stopped, busy = map(float, out.split())
    assert stopped - sent < 1.0
    # Nothing goes on behind one's back.
    assert busy < 0.1


def _in_child(scene: sunstone.Scene, results: Any) -> None:
    results.put(scene.render(**SMALL).stokes)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_other_processes_render(method: str) -> None:
    scene = sunstone.load(CORNELL)
    expected = scene.render(**SMALL).stokes
    context: Any = multiprocessing.get_context(method)
    results = context.Queue()
    children = [context.Process(target=_in_child, args=(scene, results)) for _ in range(3)]
    [child.start() for child in children]
    for _ in children:
        assert np.array_equal(results.get(timeout=60), expected)
    [child.join(10) for child in children]
    assert all(child.exitcode == 0 for child in children)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_a_fork_amid_a_render_does_not_hang() -> None:
    scene = sunstone.load(CORNELL)
    other = sunstone.load(CORNELL)
    stop = threading.Event()
    begun = threading.Event()

    def progress(done: int, total: int) -> bool:
        begun.set()
        return not stop.is_set()

    options = dict(integrator="path", width=32, height=32, spp=10**6, progress=progress)
    worker = threading.Thread(target=lambda: scene.render(**options))  # type: ignore[arg-type]
    worker.start()
    assert begun.wait(30)
    for _ in range(5):
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                scene.render(**SMALL)
                os.write(writer, b"rendered ")
            except sunstone.RenderError as error:
                os.write(writer, b"raised " if "forked" in str(error) else b"wrong ")
            other.render(**SMALL)
            os.write(writer, b"other")
            os._exit(0)
        os.close(writer)
        end = time.monotonic() + 60
        while os.waitpid(child, os.WNOHANG)[0] == 0:
            if time.monotonic() > end:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                pytest.fail("the child hangs")
            time.sleep(0.01)
        assert os.read(reader, 100) in (b"raised other", b"rendered other")
        os.close(reader)
    stop.set()
    worker.join(30)
    assert not worker.is_alive()


def test_memory_stays_where_it_is(cornell: sunstone.Scene) -> None:
    def resident() -> int:
        status = pathlib.Path("/proc/self/status")
        if not status.exists():
            pytest.skip("the system does not tell")
        lines = status.read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS"))

    renders = int(os.environ.get("SUNSTONE_RENDERS", "1000"))
    seen = []
    scene = copy.copy(cornell)
    for index in range(renders):
        if index % 4 == 0:
            scene["materials/glass/ior"] = 1.4 + 0.2 * (index % 7) / 7
        scene.render(integrator="path", spp=1, width=8, height=8, seed=index)
        if index in (renders // 10 - 1, renders - 1):
            gc.collect()
            seen.append(resident())
    print(f"{seen} kB resident after {renders // 10} and {renders} renders")
    assert seen[-1] - seen[0] <= 2048, seen


def test_an_old_processor_is_an_import_error() -> None:
    from sunstone import _processor

    old = "processor : 0\nflags\t\t: fpu sse sse2 ssse3 sse4_1 sse4_2 popcnt\n\nprocessor : 1\n"
    flags = _processor.flags_of(old)
    assert flags is not None and "popcnt" in flags
    text = _processor.refusal(flags, {})
    assert text is not None and "lacks avx, avx2, bmi1, bmi2, f16c, fma, movbe" in text
    assert _processor.refusal(None, {"AVX2": False}) is not None
    assert _processor.refusal(frozenset(_processor.FLAGS), {"AVX2": True}) is None
    assert _processor.refusal(None, {}) is None
    code = (
        "import numpy, os, sys\n"
        "real = os.read\n"
        f"os.read = lambda file, size: {old.encode()!r}\n"
        "import importlib.util as u, pathlib\n"
        "try:\n"
        "    import sunstone\n"
        "except ImportError as error:\n"
        "    assert 'AVX2' in str(error), error\n"
        "    assert 'sunstone._sunstone' not in sys.modules\n"
        "    print('refused')\n"
    )
    if not _processor._is_needed():
        pytest.skip("this build runs on any processor")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stdout == b"refused\n"


def test_the_readme_is_true(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scenes").symlink_to(CORNELL.parent)
    monkeypatch.chdir(tmp_path)
    parts = (ROOT / "README.md").read_text().split("```python\n")[1:]
    assert len(parts) == 5
    names = {"sunstone": sunstone}
    for part in parts:
        block = part.split("```")[0].replace("spp=64", "spp=4").replace("spp=16", "spp=1")
        exec(block, names)
    assert (tmp_path / "cornell.exr").exists() and (tmp_path / "turned-45.exr").exists()


#: What stubtest does not understand: aliases of literals, and a list that pyo3 adds.
ALLOWED = r"""
sunstone\._scene\.(Color|Filter|Integrator|Light|Mode|RgbWhite|Sampling)
sunstone\._sunstone\.__all__
"""


def test_stubs_and_types(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("mypy")
    stubtest = [sys.executable, "-m", "mypy.stubtest", "sunstone", "--ignore-disjoint-bases"]
    allowed = tmp_path / "allowed"
    allowed.write_text(ALLOWED)
    stubtest += ["--allowlist", str(allowed)]
    done = subprocess.run(stubtest, capture_output=True, text=True, cwd="/")
    assert done.returncode == 0, done.stdout + done.stderr
    folder = os.path.dirname(sunstone.__file__)
    # In the folder of an environment mypy takes the neighbors for the user's own.
    shutil.copytree(folder, tmp_path / "sunstone", ignore=shutil.ignore_patterns("*.so"))
    strict = [sys.executable, "-m", "mypy", "--strict", "--cache-dir=/dev/null", "sunstone"]
    done = subprocess.run(strict, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert os.path.exists(os.path.join(folder, "py.typed"))
    for name in sunstone.__all__:
        assert getattr(sunstone, name).__doc__, name
    assert ROOT.exists()


def test_files_without_camera_and_light_are_shown(tmp_path: pathlib.Path) -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()
    (tmp_path / "corners.bin").write_bytes(corners)
    times = np.array([0, 1, 0, 0, 0, 4, 0, 0], np.float32).tobytes()
    (tmp_path / "times.bin").write_bytes(times)
    path = tmp_path / "model.gltf"
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"doubleSided": True, "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "buffers": [{"uri": "corners.bin", "byteLength": 36},
                    {"uri": "times.bin", "byteLength": 32}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 1, "byteLength": 32}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
            {"bufferView": 1, "componentType": 5126, "type": "SCALAR", "count": 2},
            {"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": 2, "byteOffset": 8},
        ],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                        "samplers": [{"input": 1, "output": 2}]}],
    }))
    scene = sunstone.load(path, time=0.5)
    image = scene.render(**SMALL)
    assert image.stokes[..., 0].std() > 0
    notes = "\n".join(scene.notes())
    assert "a camera that sees all" in notes and 'light="none"' in notes
    assert {"camera", "light"} <= set(image.metadata)
    assert "bounds (2.0000, 0.0000, 0.0000)" in scene.describe()
    again = pickle.loads(pickle.dumps(scene))
    assert np.array_equal(again.render(**SMALL).stokes, image.stokes)
    with pytest.raises(sunstone.SceneError, match="nothing in the scene emits"):
        sunstone.load(path, light="none", time=0.5).render(**SMALL)
    with pytest.raises(sunstone.SceneError, match="time must be seconds"):
        sunstone.load(path, time=-1)
