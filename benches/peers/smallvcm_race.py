"""Sunstone's `bdpt` and `ppm` against SmallVCM's `bpt` and `ppm`, in SmallVCM's boxes."""

from __future__ import annotations

import os
import re
import statistics
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import smallvcm_scenes
from common import (
    Agreement,
    Figure,
    Goal,
    Options,
    PeerMissing,
    RaceError,
    Result,
    agreement,
    equal_error,
    pixel_variance,
    ratio_figure,
    require_agreement,
    say,
    sunstone,
    take_turns,
    variance_ratio,
)

SIZE = 512
PATHS = SIZE * SIZE
#: Compiled into SmallVCM: the longest path in segments, and how merging radii start and shrink.
DEPTH, RADIUS, ALPHA = 10, 0.003 * smallvcm_scenes.SCENE_RADIUS, 0.75


@dataclass
class Algorithm:
    """One of SmallVCM's, and the options that make Sunstone do the same."""

    theirs: str
    ours: str
    settings: dict[str, object]
    #: Whether its images are biased, so that errors cannot be compared.
    biased: bool = False


ALGORITHMS = [
    # Their roulette plays after a vertex was connected, ours before: from the second vertex on,
    # both meet it equally often.
    Algorithm("bpt", "bdpt", {"roulette_after": 2}),
    Algorithm(
        "ppm",
        "ppm",
        {"photons": PATHS, "radius": RADIUS, "alpha": ALPHA, "roulette_after": 2},
        biased=True,
    ),
]


@dataclass
class Lap:
    """CPU seconds for a pair of a light and a sensor path, and images of equally many pairs."""

    seconds: list[float] = field(default_factory=list)
    images: list[np.ndarray] = field(default_factory=list)


def race(options: Options) -> Result:
    if options.smallvcm is None:
        raise PeerMissing("name its program with --smallvcm; README.md says how it is built")
    if not os.access(options.smallvcm, os.X_OK):
        raise PeerMissing(f"{options.smallvcm} is no program; README.md says how it is built")
    result = Result()
    for index, scene in enumerate(smallvcm_scenes.SCENES):
        path = smallvcm_scenes.write(scene, options.work)
        for algorithm in ALGORITHMS:
            say(f"smallvcm, {scene}, {algorithm.ours}: {options.rounds} rounds")
            one_scene(index, scene, path, algorithm, options, result)
    return result


def one_scene(
    index: int, scene: str, path: Path, algorithm: Algorithm, options: Options, result: Result
) -> None:
    # SmallVCM has one seed. What a longer run adds to a shorter one is a new image, though, so
    # round n renders n times as much. Its threads take whole iterations.
    step = options.threads * (1 if options.quick else 2)
    theirs, ours = Lap(), Lap()
    total = np.zeros((SIZE, SIZE, 3))

    def run_theirs(number: int) -> None:
        nonlocal total
        iterations = step * number
        seconds, image = smallvcm(options, index, algorithm.theirs, iterations)
        theirs.seconds.append(seconds / (iterations * PATHS))
        theirs.images.append(image * number - total)
        total = image * number

    def run_ours(number: int) -> None:
        render = sunstone(
            options,
            path,
            integrator=algorithm.ours,
            mode="scalar",
            iterations=step,
            seed=number,
            max_path_length=DEPTH,
            threads=options.threads,
            **algorithm.settings,
        )
        ours.seconds.append(render.cpu_seconds / (step * PATHS))
        ours.images.append(render.image)

    for number in range(1, options.rounds + 1):
        for run in take_turns([run_theirs, run_ours], number):
            run(number)
    name = f"peers.smallvcm.{scene}.{algorithm.ours}"
    found = agreement(theirs.images, ours.images)
    try:
        note = require_bias(name, found) if algorithm.biased else require_agreement(name, found)
    except RaceError as refusal:
        result.refusals.append(str(refusal))
    else:
        result.notes.append(note)
        result.figures += figures(name, algorithm, theirs, ours)


def require_bias(what: str, found: Agreement) -> str:
    """Like `require_agreement`, for photon mapping.

    Walls of the box come out up to an eighth too dark in SmallVCM, an image by 1 to 3 %; README.md
    says what may be the cause.
    """
    if abs(found.relative) > 0.05:
        raise RaceError(f"{what}: no times are reported, for {found.text()}: is it the same scene?")
    return f"{what}: the images agree but for what SmallVCM loses at walls: {found.text()}"


def figures(name: str, algorithm: Algorithm, theirs: Lap, ours: Lap) -> list[Figure]:
    result = [ratio_figure(f"{name}.speed_ratio", theirs.seconds, ours.seconds, Goal(1.5, 3.0))]
    if not algorithm.biased:
        variance = variance_ratio(
            f"{name}.variance_ratio", pixel_variance(ours.images), pixel_variance(theirs.images)
        )
        result += [variance, *equal_error(name, [(result[0].value, variance)])]
    for who, lap in (("smallvcm", theirs), ("sunstone", ours)):
        pairs = 1 / statistics.median(lap.seconds)
        result.append(Figure(f"{name}.{who}_pairs_per_cpu_second", pairs))
    return result


def smallvcm(
    options: Options, scene: int, algorithm: str, iterations: int
) -> tuple[float, np.ndarray]:
    """CPU seconds of all threads, which it measures itself, and the image."""
    output = options.work / "smallvcm.hdr"
    # It starts a thread for each processor it may use, whatever OMP_NUM_THREADS says.
    allowed = sorted(os.sched_getaffinity(0))[: options.threads]
    command = [options.smallvcm, "-s", scene, "-a", algorithm, "-i", iterations, "-o", output]
    command = [str(word) for word in command]
    answer = subprocess.run(
        command,
        capture_output=True,
        text=True,
        preexec_fn=lambda: os.sched_setaffinity(0, allowed),
    )
    taken = re.search(r"done in ([\d.]+) s", answer.stdout)
    if answer.returncode != 0 or not taken:
        raise RaceError(f"`{' '.join(command)}` failed:\n{answer.stdout}{answer.stderr}")
    if "glossy" in answer.stdout:
        raise RaceError(
            "this SmallVCM has glossy floors, which Sunstone has not: take kGlossyFloor out of "
            "its list of scenes as README.md says, and build it again"
        )
    return float(taken[1]), read_hdr(output)


def read_hdr(path: Path) -> np.ndarray:
    """A Radiance picture without run lengths, as SmallVCM writes it.

    It truncates to 8 bits, so half a step is added back but where there is no light at all.
    """
    _, data = path.read_bytes().split(b"\n\n", 1)
    size, data = data.split(b"\n", 1)
    _, height, _, width = size.split()
    rgbe = np.frombuffer(data, np.uint8).reshape(int(height), int(width), 4).astype(np.float64)
    steps = np.where(rgbe[..., :3] > 0, rgbe[..., :3] + 0.5, 0.0)
    return steps * np.exp2(rgbe[..., 3:] - 136)
