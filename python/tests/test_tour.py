"""A tour of Sunstone in thirteen examples, each of which runs as a test.

They render small and noisy, to be quick; give more `spp`.
"""

from __future__ import annotations

import concurrent.futures
import pathlib
import pickle

import numpy as np

import sunstone

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"


def test_1_render_a_scene(tmp_path: pathlib.Path) -> None:
    """Load a scene, render it, keep everything in a file."""
    scene = sunstone.load(SCENES / "cornell.gltf")
    image = scene.render(integrator="path", spp=4, width=32, height=32)
    assert image.stokes.shape == (32, 32, 3, 4)  # height, width, channels, S0 to S3
    image.save(tmp_path / "cornell.exr")
    again = sunstone.Image.load(tmp_path / "cornell.exr")
    assert np.array_equal(again.stokes, image.stokes)


def test_2_the_effect_of_polarization() -> None:
    """Both modes trace the same paths: what differs is the effect of polarization, not noise."""
    scene = sunstone.load(SCENES / "cornell.gltf")
    options = dict(integrator="path", spp=4, width=32, height=32, sampling="intensity")
    polarized = scene.render(mode="intensity", **options)
    scalar = scene.render(mode="scalar", **options)
    difference = polarized.stokes - scalar.stokes
    assert difference.shape == (32, 32, 3, 1)
    assert np.any(difference != 0)


def test_3_degree_and_angle() -> None:
    """Maps of polarization, as arrays and as a picture with legends."""
    scene = sunstone.load(SCENES / "mirror.gltf")
    image = scene.render(spp=4, width=32, height=32)
    print(f"up to {image.dop.max():.0%} polarized, for one at {np.degrees(image.aolp[0, 0, 0])}")
    assert image.dop.shape == image.aolp.shape == (32, 32, 3)
    assert image.png("aolp").startswith(b"\x89PNG")


def test_4_one_wavelength() -> None:
    """Red light of a laser, with the variance of every value."""
    scene = sunstone.load(SCENES / "cornell.gltf")
    image = scene.render(
        integrator="path", color="mono", wavelength=633, spp=8, variance=True, width=32, height=32
    )
    assert image.channels == ("633 nm",)
    assert image.variance is not None
    assert image.variance.shape == image.stokes.shape == (32, 32, 1, 4)


def test_5_a_world_in_code() -> None:
    """A lamp above a mesh of numpy arrays."""
    x, y = np.meshgrid(np.linspace(-1, 1, 20), np.linspace(-1, 1, 20))
    height = 0.1 * np.sin(6 * x) * np.cos(6 * y)
    positions = np.stack([x, height, -y], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(19)[:, None] * 20 + np.arange(19)).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + 21], axis=-1),
            np.stack([corner, corner + 21, corner + 20], axis=-1),
        ]
    ).astype(np.uint32)

    world = sunstone.World("waves")
    world.add_material("copper", "conductor", metal="Cu", two_sided=True)
    world.add_mesh("waves", sunstone.Geometry(positions, triangles), "copper")
    world.set_environment([0.6, 0.8, 1.0])
    world.set_camera(yfov=0.8, position=(0, 1.5, 2), target=(0, 0, 0))
    image = world.render(integrator="path", spp=4, width=32, height=32)
    assert image.dop.max() > 0.05


def test_6_law_of_malus() -> None:
    """Two polarizers before a lamp: the light goes as the squared cosine of their angle."""

    def through(angle: float) -> float:
        world = sunstone.World("bench")
        world.add_material("glow", "absorber", emission=1.0)
        world.add_material("polarizer", "polarizer")
        world.add_material("analyzer", "polarizer", axis_deg=angle)
        for depth, name in enumerate(["analyzer", "polarizer", "glow"]):
            sheet = sunstone.Geometry.quad((0, 0, -1.0 - depth), (5, 0, 0), (0, 5, 0))
            world.add_mesh(name, sheet, name)
        world.set_camera(yfov=0.1, position=(0, 0, 0), target=(0, 0, -1))
        image = world.render(integrator="path", color="mono", spp=1, width=4, height=4)
        return float(image.stokes[..., 0].mean())

    for angle in (0, 30, 60, 90):
        expected = 0.5 * np.cos(np.radians(angle)) ** 2
        assert abs(through(angle) - expected) < 1e-4


def test_7_milk() -> None:
    """A ball of milk in the open, whose particles are computed by the theory of Mie."""
    world = sunstone.World("dairy")
    world.add_medium("milk", "mie", milk=dict(fat_percent=3.5, protein_percent=3.4, dilution=0.01))
    world.add_material("boundary", "null")
    world.add_sphere("drop", 0.01, "boundary", interior="milk")
    world.add_light("sun", "directional", 1.0, direction=(-1, 0, 0))
    world.set_camera(yfov=0.5, position=(0, 0, 0.05), target=(0, 0, 0))
    image = world.render(integrator="path", color="mono", spp=8, width=16, height=16)
    assert 0.1 < np.average(image.dop, weights=image.stokes[..., 0]) < 0.9


def test_8_progress_and_time() -> None:
    """Hear how far a render is, and end it with what is done."""
    scene = sunstone.load(SCENES / "cornell.gltf")
    heard = []

    def progress(done: int, total: int) -> bool:
        heard.append(done / total)
        return done < 32  # False ends the render

    image = scene.render(integrator="path", spp=4096, width=16, height=16, progress=progress)
    assert heard and 32 <= int(image.metadata["iterations"]) < 4096
    image = scene.render(integrator="path", spp=10**6, width=16, height=16, time_limit=0.1)
    assert int(image.metadata["iterations"]) < 10**6


def test_9_several_at_once() -> None:
    """Renders in threads, of one scene, whose tree they share."""
    scene = sunstone.load(SCENES / "cornell.gltf")

    def render(seed: int) -> np.ndarray:
        options = dict(integrator="path", spp=4, width=16, height=16, threads=1)
        return scene.render(seed=seed, **options).stokes

    with concurrent.futures.ThreadPoolExecutor(4) as threads:
        images = np.stack(list(threads.map(render, range(8))))
    noise = images.std(axis=0)
    assert noise.shape == (16, 16, 3, 4) and noise.max() > 0


def test_10_what_is_wrong_is_said() -> None:
    """Errors name the object and the field; scenes and images can be sent to other processes."""
    world = sunstone.World("winter")
    try:
        world.add_material("snow", "diffuse", reflectance=2.5)
    except sunstone.SceneError as error:
        assert str(error) == "material `snow`, reflectance: 2.5 must be within [0, 1]"
    scene = sunstone.load(SCENES / "cornell.gltf")
    same = pickle.loads(pickle.dumps(scene))
    options = dict(integrator="path", spp=1, width=8, height=8)
    assert np.array_equal(same.render(**options).stokes, scene.render(**options).stokes)


def test_11_sweeps() -> None:
    """Edit a scene by name; the tree of its shapes is kept, and the bits are those of the file."""
    scene = sunstone.load(SCENES / "cornell.gltf")
    options = dict(integrator="path", spp=1, width=8, height=8)
    images = []
    for angle in (0, 22.5, 45):
        scene["materials/half-wave plate/axis_deg"] = angle
        images.append(scene.render(**options).stokes)
    assert scene["half-wave plate"].axis_deg == 45
    assert not np.array_equal(images[0], images[2])
    scene.edit({"materials/glass/ior": 1.33, "cameras/camera/perspective.yfov": 0.5})
    assert scene.edits["materials/glass/ior"] == 1.33
    del scene["half-wave plate"].axis_deg  # as the file has it


def test_12_batches(tmp_path: pathlib.Path) -> None:
    """Many renders from one job file; what is done is not done again."""
    (tmp_path / "jobs.toml").write_text(
        f"""
        version = 1
        [defaults]
        scene = "{SCENES / 'cornell.gltf'}"
        integrator = "path"
        spp = 1
        width = 8
        height = 8
        [[jobs]]
        name = "glass"
        output = "out/{{name}}-{{ior}}.exr"
        sweep = [{{ name = "ior", key = "materials/glass/ior", values = [1.33, 1.5] }}]
        """
    )
    for result in sunstone.batch(tmp_path / "jobs.toml"):
        assert result.error is None and result.values["ior"] in (1.33, 1.5)
        assert sunstone.Image.load(result.output).stokes.shape == (8, 8, 3, 4)
    assert all(result.was_done for result in sunstone.batch(tmp_path / "jobs.toml"))


def test_13_spectra(tmp_path: pathlib.Path) -> None:
    """Light at all wavelengths, measured in bands: the spectrum of a pixel."""
    world = sunstone.World("shop")
    world.add_material("gold", "conductor", metal="Au")
    world.add_sphere("ball", 1.0, "gold")
    world.set_environment({"illuminant": "D65"})
    world.set_camera(yfov=0.6, position=(0, 0, 3), target=(0, 0, 0))
    options = dict(integrator="path", color="spectral", spp=64, width=8, height=8)
    image = world.render(bands=(400, 700, 7), **options)  # seven of 50 nm
    assert image.stokes.shape == (8, 8, 7, 4) and image.wavelengths_nm is not None
    for nm, (s0, s1, s2, s3) in zip(image.wavelengths_nm, image.stokes[4, 4]):
        print(f"{nm:.0f} nm: {s0:.3f} W/(m^2 sr nm), {np.hypot(s1, s2) / s0:.1%} linear")
    blue, red = image.at(450).stokes[4, 4, 0, 0], image.at(650).stokes[4, 4, 0, 0]
    assert red > 1.5 * blue  # under daylight, which has more of blue
    image.save(tmp_path / "bands.exr")  # as Fichet et al. 2021 lay spectra out
    again = sunstone.Image.load(tmp_path / "bands.exr")
    assert again.bands == image.bands and np.array_equal(again.stokes, image.stokes)
    color = world.render(**options)  # red, green and blue, as the eye sees these spectra
    assert color.stokes[4, 4, 0, 0] > color.stokes[4, 4, 2, 0]
