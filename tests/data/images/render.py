"""Renders references by Mitsuba 3: python render.py SCENE [RUNS], as `python render.py plastic`.

Writes stokes.npy, the mean over the runs, and stderr.npy, its standard error from their spread,
beside the scene's scene.xml; see README.md. Needs mitsuba (3.9.1) and numpy.
"""

import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_mono_polarized")


def main(name: str, runs: int = 16) -> None:
    folder = Path(__file__).parent / name
    scene = mi.load_file(str(folder / "scene.xml"))
    images = []
    for seed in range(runs):
        image = np.array(mi.render(scene, seed=seed), dtype=np.float64)
        # The color comes first, then S0 to S3 of every channel of the color.
        planes = image[:, :, -12:].reshape(*image.shape[:2], 4, 3)
        images.append(planes[..., 0])
        print(f"{name}: run {seed + 1} of {runs}", file=sys.stderr)
    stack = np.stack(images)
    np.save(folder / "stokes.npy", stack.mean(axis=0).astype(np.float32))
    error = stack.std(axis=0, ddof=1) / np.sqrt(runs)
    np.save(folder / "stderr.npy", error.astype(np.float32))


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
