"""What all races share: running Sunstone, interleaving, statistics, agreement, the table."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Optional, Sequence, TypeVar

import numpy as np

import gltf

T = TypeVar("T")
REPOSITORY = Path(__file__).resolve().parents[2]


class PeerMissing(Exception):
    """A peer that is not installed; the message says how to install it."""


class RaceError(Exception):
    """What makes a race meaningless; the message says how to mend it."""


@dataclass
class Options:
    """What the command line asks of every race."""

    sunstone: Path
    rounds: int
    quick: bool
    threads: int
    smallvcm: Optional[Path]
    embree: Optional[Path]
    work: Path


@dataclass
class Goal:
    """What a figure must reach for the comparison to be won, and what is aimed at."""

    must: float
    aim: float
    #: Whether smaller figures are better.
    at_most: bool = False

    def verdict(self, value: float) -> str:
        met = [value <= x if self.at_most else value >= x for x in (self.must, self.aim)]
        return "aim" if all(met) else "must" if met[0] else "MISSED"


@dataclass
class Figure:
    """A line of the table: a number with an interval, and its goal if there is one."""

    name: str
    value: float
    low: float = math.nan
    high: float = math.nan
    unit: str = ""
    goal: Optional[Goal] = None


@dataclass
class Result:
    """What a race found: its figures, and sentences that belong with them."""

    figures: list[Figure] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    #: Why figures are not reported.
    refusals: list[str] = field(default_factory=list)


def say(what: str) -> None:
    """Progress, on standard error."""
    print(what, file=sys.stderr, flush=True)


# -- Sunstone -----------------------------------------------------------------------------------


@dataclass
class Render:
    """One render: what it took, loading and writing excluded, and where its image is.

    `image` is an array (height, width, components): luminances of S0 to S3 of a polarized render,
    red, green and blue of a scalar one.
    """

    cpu_seconds: float
    wall_seconds: float
    image: np.ndarray


def sunstone_version(sunstone: Path) -> str:
    """The version, which is also the proof that the program runs."""
    try:
        answer = subprocess.run([sunstone, "--version"], capture_output=True, text=True)
    except OSError as error:
        raise RaceError(
            f"{sunstone} does not run ({error}): build it with `cargo build --release`, "
            "or name another with --sunstone"
        ) from error
    return answer.stdout.split()[-1]


def sunstone(options: Options, scene: Path, **settings: object) -> Render:
    """Renders a scene; settings are options of `sunstone render` with _ for -."""
    with tempfile.TemporaryDirectory(dir=options.work) as folder:
        output = Path(folder) / "image.exr"
        command = [options.sunstone, "render", scene, "--output", output]
        command += ["--quiet", "--stats", "json"]
        for name, value in settings.items():
            command += ["--" + name.replace("_", "-"), value]
        command = [str(word) for word in command]
        answer = subprocess.run(command, capture_output=True, text=True)
        if answer.returncode != 0:
            raise RaceError(f"`{' '.join(command)}` failed:\n{answer.stderr.strip()}")
        taken = json.loads(answer.stdout)
        return Render(taken["cpu_seconds"], taken["seconds"], read_sunstone_image(output))


def read_sunstone_image(path: Path) -> np.ndarray:
    """Luminances of S0 to S3 if the image has them, else its channels, as (height, width, n)."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        planes = {name: channel.pixels for name, channel in file.channels().items()}
    if "S1" in planes:
        layers = [planes[f"S{i}"] for i in range(4)]
    elif "S1.G" in planes:
        luminance = dict(zip("RGB", gltf.LUMINANCE))
        layers = [sum(w * planes[f"S{i}.{c}"] for c, w in luminance.items()) for i in range(4)]
    else:
        layers = [planes[name] for name in ("RGB" if "R" in planes else "Y")]
    return np.stack(layers, axis=-1).astype(np.float64)


def take_turns(runners: Sequence[T], number: int) -> Sequence[T]:
    """The runners of a round: who goes first changes, lest a machine that slows down favor one."""
    return runners if number % 2 else runners[::-1]


# -- statistics ---------------------------------------------------------------------------------


def median_interval(values: Sequence[float]) -> tuple[float, float, float]:
    """The median, and the narrowest pair of order statistics that holds it with 95 %.

    That is so for whatever distribution. Fewer than six values cannot promise as much: of these
    it is the smallest and the largest.
    """
    ordered = sorted(values)
    n = len(ordered)

    def outside(rank: int) -> float:
        return 2 * sum(math.comb(n, i) for i in range(rank + 1)) / 2**n

    rank = 0
    while outside(rank + 1) <= 0.05:
        rank += 1
    return float(np.median(ordered)), ordered[rank], ordered[n - 1 - rank]


def ratio_figure(
    name: str, theirs: Sequence[float], ours: Sequence[float], goal: Optional[Goal]
) -> Figure:
    """How many times their time ours is: the median over pairs of the same round."""
    value, low, high = median_interval([a / b for a, b in zip(theirs, ours)])
    return Figure(name, value, low, high, "x", goal)


def pixel_variance(images: Sequence[np.ndarray]) -> np.ndarray:
    """The variance over independent images, a pixel each, averaged over components."""
    return np.stack(images).var(axis=0, ddof=1).mean(axis=-1)


def variance_ratio(
    name: str, ours: np.ndarray, theirs: np.ndarray, goal: Optional[Goal] = None
) -> Figure:
    """Mean variance of ours over that of theirs, with an interval from a jackknife over tiles.

    Both are maps of pixels. What makes variances uncertain is fireflies, which are local, so the
    ratio without one tile at a time shows how much hangs on them.
    """
    tiles = [blocks(variance[..., np.newaxis]).ravel() for variance in (ours, theirs)]
    a, b = tiles
    without = np.log((a.sum() - a) / (b.sum() - b))
    error = math.sqrt((len(a) - 1) * without.var())
    value = a.sum() / b.sum()
    spread = math.exp(2 * error)
    return Figure(name, float(value), float(value / spread), float(value * spread), "x", goal)


def equal_error(name: str, candidates: Sequence[tuple[float, Figure]]) -> list[Figure]:
    """How much longer theirs takes to the same error, by the best of (speed, variance) ratios.

    Nothing if a variance is known to no better than a factor of two, as when one bright pixel in
    one round makes up most of it.
    """
    if any(variance.high > 2 * variance.value for _, variance in candidates):
        return []
    value = min(speed / variance.value for speed, variance in candidates)
    return [Figure(f"{name}.equal_error_ratio", value, unit="x")]


# -- agreement ----------------------------------------------------------------------------------

#: Edge of the blocks of pixels whose means are compared; smaller ones are too far from normal.
BLOCK = 16
#: What blocks may differ by, as a share of each component, besides noise: conversions of spectra,
#: tessellated spheres and images of few bits do not come nearer.
TOLERANCE = 0.0025


@dataclass
class Agreement:
    """How far two renderers' images of one scene are apart."""

    #: Mean of the first component, theirs over ours, less one.
    relative: float
    #: The same difference in standard errors.
    z: float
    #: Root mean square of the differences of blocks in their standard errors; 1 is expected.
    rms: float

    def text(self) -> str:
        return (
            f"means differ by {self.relative:+.2%} (z = {self.z:+.1f}), "
            f"blocks of {BLOCK} x {BLOCK} by an rms z of {self.rms:.2f}"
        )


def blocks(image: np.ndarray) -> np.ndarray:
    height, width, components = image.shape
    rows, columns = height // BLOCK, width // BLOCK
    image = image[: rows * BLOCK, : columns * BLOCK]
    return image.reshape(rows, BLOCK, columns, BLOCK, components).mean(axis=(1, 3))


def agreement(theirs: Sequence[np.ndarray], ours: Sequence[np.ndarray]) -> Agreement:
    """Compares means over rounds, errors taken from the spread of the rounds."""
    mean = [[float(image[..., 0].mean()) for image in images] for images in (theirs, ours)]
    error = math.sqrt(sum(np.var(x, ddof=1) / len(x) for x in mean))
    difference = np.mean(mean[0]) - np.mean(mean[1])

    cells = [np.stack([blocks(image) for image in images]) for images in (theirs, ours)]
    variance = sum(x.var(axis=0, ddof=1) / len(x) for x in cells)
    # Where neither has noise (emitters, black) only rounding is left.
    noise = variance > 1e-12 * np.mean(mean[1]) ** 2
    variance += (TOLERANCE * cells[1].mean(axis=0)) ** 2
    squares = (cells[0].mean(axis=0) - cells[1].mean(axis=0))[noise] ** 2 / variance[noise]
    # z of an estimated error follows Student's t, whose variance is that of `degrees`.
    degrees = len(theirs) + len(ours) - 2
    rms = math.sqrt(squares.mean() * (degrees - 2) / degrees)
    return Agreement(float(difference / np.mean(mean[1])), float(difference / error), rms)


def require_agreement(what: str, found: Agreement, allowed: float = 0.002) -> str:
    """The sentence that two renderers agree, or a refusal to compare their times.

    Means may differ by the share `allowed`, and by more if noise explains it.
    """
    if abs(found.relative) > allowed and abs(found.z) > 5.0:
        reason = "their means differ"
    elif found.rms > 2.0:
        reason = "their images differ from block to block"
    else:
        return f"{what}: the images agree: {found.text()}"
    raise RaceError(
        f"{what}: no times are reported, for {reason}: {found.text()}. Do both render the same "
        "scene to the same depth? Fewer than seven rounds judge badly."
    )


# -- the table ----------------------------------------------------------------------------------


def table(figures: Sequence[Figure]) -> str:
    """All figures, a line each, with their goals."""
    width = max((len(figure.name) for figure in figures), default=0)
    lines = [f"{'figure':<{width}} {'value':>9} {'interval':>17} {'must':>6} {'aim':>6}"]
    for figure in figures:
        interval = ""
        if not math.isnan(figure.low):
            interval = f"{number(figure.low)} .. {number(figure.high)}"
        line = f"{figure.name:<{width}} {number(figure.value) + figure.unit:>9} {interval:>17}"
        if goal := figure.goal:
            line += f" {number(goal.must):>6} {number(goal.aim):>6} {goal.verdict(figure.value)}"
        lines.append(line.rstrip())
    return "\n".join(lines)


def number(value: float) -> str:
    """Three digits are more than such measurements hold."""
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
