#!/usr/bin/env python3
"""Many small images of one scene: `sunstone batch`, one long render, a process for each image, and
Mitsuba's loop over the same values.

    python benches/peers/sweep.py                     40 angles x 25 indices, 4 and 64 samples
    python benches/peers/sweep.py --angles 4 --indices 5 --spp 4

README.md beside this file says what is measured. Times are those of the clock on the wall, of the
whole program for Sunstone, and of the loop alone, with its kernels compiled, for Mitsuba. Needs a
machine that does nothing else.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Iterator

import numpy as np
import OpenEXR

REPOSITORY = Path(__file__).resolve().parents[2]
SIZE, DEPTH, SEED = 64, 12, 0
VARIANTS = {"llvm_ad_mono_polarized": "mono", "llvm_ad_spectral_polarized": "rgb"}


def lab(folder: Path) -> Path:
    """The Cornell box of the races with an analyzer before the camera."""
    scene = json.loads((REPOSITORY / "scenes/reference/cornell.gltf").read_text())
    sheet = {"bsdf": "polarizer", "axis_deg": 0}
    scene["materials"].append(
        {"name": "analyzer", "doubleSided": True, "extensions": {"SUNSTONE_polarization": sheet}}
    )
    back = next(node for node in scene["nodes"] if node["name"] == "back")
    primitive = dict(scene["meshes"][back["mesh"]]["primitives"][0])
    primitive["material"] = len(scene["materials"]) - 1
    scene["meshes"].append({"name": "analyzer", "primitives": [primitive]})
    matrix = [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 3.4, 1]
    node = {"name": "analyzer", "mesh": len(scene["meshes"]) - 1, "matrix": matrix}
    scene["nodes"].append(node)
    scene["scenes"][0]["nodes"].append(len(scene["nodes"]) - 1)
    path = folder / "lab.gltf"
    path.write_text(json.dumps(scene))
    return path


def values(options: argparse.Namespace) -> Iterator[tuple[float, float]]:
    """Angles in degrees and indices, the index fastest."""
    for angle in np.linspace(0, 175, options.angles):
        for index in np.linspace(1.3, 1.7, options.indices):
            yield float(angle), float(index)


def timed(command: list[str], folder: Path) -> float:
    start = time.perf_counter()
    subprocess.run(command, cwd=folder, check=True)
    return time.perf_counter() - start


def render(options: argparse.Namespace, color: str, spp: int, output: str) -> list[str]:
    words = [options.sunstone, "render", "lab.gltf", "-o", output, "-q", "--integrator", "path"]
    words += ["--color", color, "--width", SIZE, "--height", SIZE, "--spp", spp]
    words += ["--max-path-length", DEPTH, "--roulette-after", DEPTH, "--threads", options.threads]
    return [str(word) for word in words]


def batch(options: argparse.Namespace, color: str, spp: int, folder: Path) -> float:
    name = f"{color}-{spp}"
    angle = f"from = 0, to = 175, count = {options.angles}"
    index = f"from = 1.3, to = 1.7, count = {options.indices}"
    (folder / f"{name}.toml").write_text(
        f"""version = 1
[defaults]
scene = "lab.gltf"
integrator = "path"
color = "{color}"
spp = {spp}
width = {SIZE}
height = {SIZE}
max_path_length = {DEPTH}
roulette_after = {DEPTH}
[[jobs]]
output = "{name}/{{angle}}-{{ior}}.exr"
sweep = [
  {{ name = "angle", key = "materials/analyzer/axis_deg", {angle} }},
  {{ name = "ior", key = "materials/glass/ior", {index} }},
]
"""
    )
    words = [options.sunstone, "batch", f"{name}.toml", "-q", "--threads", options.threads]
    return timed([str(word) for word in words], folder)


def mitsuba(options: argparse.Namespace, variant: str, spp: int, folder: Path) -> float:
    """The time of the loop, in a process of its own, as variants last as long as their process."""
    words = [sys.executable, __file__, "--loop", variant, "--spp", spp, "--folder", folder]
    words += ["--threads", options.threads, "--angles", options.angles]
    words += ["--indices", options.indices]
    done = subprocess.run([str(word) for word in words], check=True, stdout=subprocess.PIPE)
    return float(done.stdout)


def loop(options: argparse.Namespace) -> None:
    """Mitsuba's way: parameters are set, kernels stay, and images are written by other threads."""
    sys.argv = [sys.argv[0], options.loop, str(options.threads)]
    import mitsuba_worker as worker

    mi, dr = worker.mi, worker.dr
    spp, folder = options.spp[0], options.folder
    scene = worker.load(folder / "lab.gltf", "independent", SIZE, DEPTH, folder)
    parameters = mi.traverse(scene)
    # A metal's index is a spectrum, `eta.value`, and a dielectric's a number.
    (angle_of,) = (key for key in parameters.keys() if ".theta" in key)
    (index_of,) = (key for key in parameters.keys() if key.endswith(".eta"))
    output = folder / f"{options.loop}-{spp}"
    output.mkdir(exist_ok=True)

    def image(angle: float, index: float) -> None:
        parameters[angle_of] = angle
        parameters[index_of] = index
        parameters.update()
        found = mi.render(scene, spp=spp, seed=SEED)
        mi.util.write_bitmap(str(output / f"{angle}-{index}.exr"), found, write_async=True)

    # Values become parameters of kernels when they are set first.
    for angle, index in [(1.0, 1.4), (2.0, 1.45), (3.0, 1.35)]:
        image(angle, index)
    dr.sync_thread()
    start = time.perf_counter()
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for angle, index in values(options):
            image(angle, index)
        dr.sync_thread()
        mi.Thread.wait_for_tasks()
        taken = time.perf_counter() - start
        compiled = sum(1 for kernel in dr.kernel_history() if kernel.get("cache_hit") is False)
    if compiled:
        print(f"{compiled} kernels were compiled within the loop", file=sys.stderr)
    print(taken)


def agree(folder: Path, variant: str, color: str, spp: int) -> str:
    """Means of S0 over all images, which have to be equal but for noise."""
    def mean(of: Path) -> float:
        return float(np.mean([first_plane(path) for path in sorted(of.glob("*-*.exr"))]))

    ours, theirs = mean(folder / f"{color}-{spp}"), mean(folder / f"{variant}-{spp}")
    return f"mean {ours:.5f} and {theirs:.5f}"


def first_plane(path: Path) -> float:
    """The mean of S0; Mitsuba's Stokes planes, of three colors each, are the last of a file."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        planes = {name: float(np.mean(it.pixels)) for name, it in file.channels().items()}
    ours = [name for name in planes if name.startswith("S0")]
    return float(np.mean([planes[name] for name in ours or sorted(planes)[-12:-9]]))


def race(options: argparse.Namespace) -> None:
    count = options.angles * options.indices
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lab(folder)
        for variant, color in VARIANTS.items():
            for spp in options.spp:
                ours = batch(options, color, spp, folder)
                theirs = mitsuba(options, variant, spp, folder)
                long = timed(render(options, color, spp * count, "long.exr"), folder)
                some = min(count, options.processes)
                one = render(options, color, spp, "one.exr")
                single = sum(timed(one, folder) for _ in range(some)) * count / some
                print(
                    f"{color}, {count} images of {spp} samples: batch {ours:.2f} s, Mitsuba"
                    f" ({variant}) {theirs:.2f} s, ratio {theirs / ours:.2f}; one long render"
                    f" {long:.2f} s, {long / ours:.1%} of its samples a second; a process each"
                    f" {single:.1f} s; {agree(folder, variant, color, spp)}",
                    flush=True,
                )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--angles", type=int, default=40)
    parser.add_argument("--indices", type=int, default=25)
    parser.add_argument("--spp", type=int, nargs="+", default=[4, 64])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--processes", type=int, default=100, help="of which 1,000 are reckoned")
    parser.add_argument("--sunstone", type=Path, default=REPOSITORY / "target/release/sunstone")
    parser.add_argument("--loop", help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    options.sunstone = options.sunstone.absolute()
    loop(options) if options.loop else race(options)


if __name__ == "__main__":
    main()
