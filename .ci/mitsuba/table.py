"""Renders scenes of the public repository mitsuba-renderer/mitsuba-data by both programs and says in
a table how far they agree.

    python table.py --data CHECKOUT [--sunstone PROGRAM] [--runs N] [--spp N] [-o TABLE] [SCENE...]

Scenes are read as they are. Each is rendered in RGB without polarization by the integrator that it asks for, N times with
different seeds by each program, on a small film of the same shape. The means over blocks of 8 x 8
pixels are compared in each channel; those at the edges are left out, where Mitsuba's films have no
samples beyond. Columns:

    became   rendered, or what is refused
    rms      of Welch's t over all blocks that are not black; sqrt(df / (df - 2)) if nothing differs
    worst    the greatest of these
    p        how probable a worst one as great is if nothing differs, of all blocks together
    means    the mean of the whole image over Mitsuba's
    speed    Mitsuba's seconds over ours with --speed; both programs from start to file

p is of Gaussian noise: with few samples, where rare paths are bright, it is too strict.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

BLOCK = 8
ROUNDING = 1e-5
PIXELS = 128 * 96
SCENES = ["scenes/cbox/cbox.xml", "scenes/cbox/cbox-rgb.xml", "scenes/matpreview/matpreview.xml",
          "docs/scenes/integrator_direct_both.xml"]
DOCUMENTED = ["bsdf_diffuse_plain", "bsdf_diffuse_textured", "bsdf_dielectric_glass",
              "bsdf_dielectric_diamond", "bsdf_conductor_gold", "bsdf_conductor_aluminium",
              "bsdf_roughconductor_copper", "bsdf_roughconductor_textured_carbon",
              "bsdf_roughconductor_anisotropic_aluminium", "bsdf_roughdielectric_glass",
              "bsdf_roughdielectric_rough", "bsdf_roughdielectric_textured", "bsdf_plastic_default",
              "bsdf_plastic_diffuse", "bsdf_plastic_shiny", "bsdf_plastic_preserve",
              "bsdf_plastic_nopreserve", "bsdf_roughplastic_beckmann", "bsdf_roughplastic_ggx",
              "bsdf_roughplastic_diffuse", "bsdf_pplastic", "bsdf_thindielectric_glass",
              "bsdf_normalmap_with", "bsdf_normalmap_without", "bsdf_bumpmap_with",
              "bsdf_bumpmap_without", "bsdf_mask_before", "bsdf_mask_after", "bsdf_blendbsdf",
              "bsdf_twosided_cbox", "bsdf_hair_blonde", "shape_disk", "shape_disk_parameterization",
              "shape_rectangle_parameterization", "shape_sphere_parameterization",
              "shape_cylinder_twosided", "shape_ply_bunny", "texture_checkerboard",
              "shape_sdfgrid", "shape_bsplinecurve_basic", "sensor_thinlens"]
SCENES += [f"docs/scenes/{name}.xml" for name in DOCUMENTED]

MITSUBA = """
import math
import sys
import mitsuba as mi
mi.set_variant(sys.argv[1])
import numpy as np
scene = mi.load_file(sys.argv[2])
sensor = scene.sensors()[0]
params = mi.traverse(sensor)
width, height = (int(side) for side in params["film.size"])
if sys.argv[6] != "0":
    # The angle of view has been found for this shape: it is to stay exactly so where it can.
    unit = math.gcd(width, height)
    unit = unit if width * height / unit ** 2 <= float(sys.argv[6]) else 1
    scale = (float(sys.argv[6]) / (width * height)) ** 0.5
    scale = round(scale * unit) / unit if unit > 1 else scale
    params["film.size"] = [round(width * scale), round(height * scale)]
    params.update()
images = []
for seed in range(int(sys.argv[4])):
    image = mi.render(scene, sensor=0, spp=int(sys.argv[3]), seed=seed)
    images.append(np.array(image)[:, :, :3])
np.save(sys.argv[5], np.stack(images))
"""


def survival(t, df):
    """The probability that Student's t is farther from zero, by the trapezoidal rule."""
    # With x = tan(a) sqrt(df) the density is cos(a) to the power df - 1.
    angles = np.linspace(0, np.pi / 2, 200001)
    density = np.cos(angles) ** (df - 1)
    return float(density[angles >= np.arctan(t / df ** 0.5)].sum() / density.sum())


def blocks(images):
    """Means over blocks within the edges, one row an image."""
    count, height, width, channels = images.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = images[:, :rows * BLOCK, :columns * BLOCK]
    cut = cut.reshape(count, rows, BLOCK, columns, BLOCK, channels).mean(axis=(2, 4))
    return cut[:, 1:-1, 1:-1]


def compared(ours, theirs):
    """Root mean square and greatest t, its probability, and the ratio of means."""
    a, b = (blocks(images).reshape(len(images), -1) for images in (ours, theirs))
    count = len(a)
    spread = (a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / count
    # Even lamps have no noise but that of rounding.
    spread += (ROUNDING * b.mean(axis=0)) ** 2
    lit = spread > 0
    t = np.abs(a.mean(axis=0) - b.mean(axis=0))[lit] / np.sqrt(spread[lit])
    if not len(t):
        return 0, 0, 1, 1
    p = survival(t.max(), 2 * count - 2)
    alarm = 1 - (1 - p) ** len(t)
    return np.sqrt((t ** 2).mean()), t.max(), alarm, a.mean() / b.mean()


def read(path):
    """An image that has been written as EXR, by Mitsuba's reader."""
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    bitmap = mi.Bitmap(str(path))
    return np.array(bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))


def render_ours(program, path, size, spp, runs, folder, data):
    """Our images, or what is refused."""
    images = []
    for seed in range(runs):
        out = folder / f"{seed}.exr"
        command = [program, "render", path, "-o", out, "--mode", "scalar",
                   "--width", str(size[0]), "--height", str(size[1]), "--spp", str(spp), "--seed",
                   str(seed + 1), "--quiet", "--allow-outside"]
        done = subprocess.run(command, capture_output=True, text=True,
                              env={**os.environ, "SUNSTONE_CACHE": "off"})
        if done.returncode != 0:
            lines = [line.strip() for line in done.stderr.splitlines()
                     if line.strip() and not line.startswith("warning")]
            several = len(lines) > 1 and lines[0].endswith("things are wrong")
            text = lines[1 if several else 0] if lines else "?"
            return None, text.replace(f"{data}/", "").removeprefix("error: ")
        images.append(read(out))
    return np.stack(images), ""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--sunstone", default="sunstone")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--runs", type=int, default=16)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--speed", action="store_true", help="race at the film's own size")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--images", type=Path, help="a folder to keep them in, as PNG")
    arguments = parser.parse_args()
    data = arguments.data.resolve()
    rows = []
    for name in arguments.scenes or SCENES:
        with tempfile.TemporaryDirectory() as scratch:
            rows.append(row(arguments, data, name, Path(scratch)))
            print("\t".join(rows[-1]), flush=True)
    head = ["scene", "became", "rms", "worst", "p", "means", "speed"]
    text = "\n".join("\t".join(cells) for cells in [head, *rows]) + "\n"
    if arguments.output:
        arguments.output.write_text(text)


def row(arguments, data, name, folder):
    """The line of a scene."""
    none = ["-"] * 5
    path, kept = data / name, folder / "theirs.npy"
    command = [sys.executable, "-c", MITSUBA, arguments.variant, str(path)]
    pixels = [str(arguments.spp), str(arguments.runs), str(kept), str(PIXELS)]
    done = subprocess.run(command + pixels, capture_output=True, text=True)
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:]
        return [name, f"Mitsuba: {''.join(last)[:120]}", *none]
    theirs = np.load(kept)
    size = (theirs.shape[2], theirs.shape[1])
    ours, refused = render_ours(arguments.sunstone, path, size, arguments.spp, arguments.runs,
                                folder, data)
    if ours is None:
        return [name, refused[:160], *none]
    rms, worst, p, means = compared(ours, theirs)
    if arguments.images:
        keep(arguments.images, Path(name).stem, ours, theirs)
    speed = race(arguments, command, path, folder) if arguments.speed else "-"
    return [name, "rendered", f"{rms:.2f}", f"{worst:.2f}", f"{p:.3f}", f"{means:.4f}", speed]


def keep(folder, name, ours, theirs):
    """Both images side by side, and how many standard errors they differ by."""
    import mitsuba as mi
    folder.mkdir(parents=True, exist_ok=True)
    a, b = ours.mean(axis=0), theirs.mean(axis=0)
    error = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / len(ours))
    z = 0.5 + 0.1 * (a - b) / np.maximum(error, 1e-9)
    bitmap = mi.Bitmap(np.concatenate([a, b, np.clip(z, 0, 1)], axis=1).astype(np.float32))
    rgb = bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True)
    rgb.write(str(folder / f"{name}.png"))


def race(arguments, command, path, folder):
    """Mitsuba's seconds over ours for 64 samples at the film's own size."""
    times = []
    ours = [arguments.sunstone, "render", path, "-o", folder / "o.exr", "--mode", "scalar", "--spp", "64", "--quiet", "--allow-outside"]
    for racer in (command + ["64", "1", str(folder / "speed.npy"), "0"], ours):
        start = time.monotonic()
        subprocess.run(racer, check=True, capture_output=True)
        times.append(time.monotonic() - start)
    return f"{times[0] / times[1]:.2f}"


if __name__ == "__main__":
    main()
