"""Sunstone's `bdpt` against LuxCore's BIDIRCPU: Cornell box with a glass and a mirror sphere."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import statistics
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from common import (
    REPOSITORY,
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

VERSION = "2.11.2"
SIZE, DEPTH = 512, 10
#: LuxCore limits subpaths, not paths: with DEPTH segments each it makes all paths of up to DEPTH
#: segments and some of up to twice as many. So ours are raced with either limit.
DEPTHS = {"": DEPTH, "_twice_as_deep": 2 * DEPTH}
#: Neither limit gives quite the same light.
ALLOWED = 0.005
#: The plainest is the fastest a sample; errors are compared with whichever of them does better.
SAMPLERS = ["RANDOM", "SOBOL"]


@dataclass
class Lap:
    """CPU seconds a sample, and images, with the variance that one sample a pixel would have."""

    seconds: list[float] = field(default_factory=list)
    images: list[np.ndarray] = field(default_factory=list)
    samples: list[float] = field(default_factory=list)

    def sample_variance(self) -> np.ndarray:
        return pixel_variance(self.images) * statistics.mean(self.samples)


def race(options: Options) -> Result:
    if importlib.util.find_spec("pyluxcore") is None:
        raise PeerMissing("no module `pyluxcore`: pip install -r benches/peers/requirements.txt")
    found = importlib.metadata.version("pyluxcore")
    if found != VERSION:
        raise PeerMissing(f"pyluxcore {found} is installed, the race is against {VERSION}")
    result = Result()
    scene = write_scene(options.work)
    for threads in sorted({1, options.threads}):
        with_threads(scene, threads, options, result)
    return result


def write_scene(folder: Path) -> Path:
    """The reference Cornell box with a mirror that reflects all but nothing: LuxCore's mirror has
    one reflectance for all angles."""
    scene = json.loads((REPOSITORY / "scenes/reference/cornell.gltf").read_text())
    for material in scene["materials"]:
        body = material["extensions"]["SUNSTONE_polarization"]
        if body["bsdf"] == "conductor":
            body.update(eta=0.001, k=10.0)
    path = folder / "luxcore_cornell.gltf"
    path.write_text(json.dumps(scene))
    return path


def with_threads(scene: Path, threads: int, options: Options, result: Result) -> None:
    say(f"luxcore, {threads} threads: {options.rounds} rounds")
    samples = 1 if options.quick else 3
    theirs = {sampler: Lap() for sampler in SAMPLERS}
    ours = {name: Lap() for name in DEPTHS}

    def run_theirs(seed: int) -> None:
        for sampler, lap in theirs.items():
            luxcore(lap, scene, sampler, samples, seed, threads, options)

    def run_ours(seed: int) -> None:
        for name, depth in DEPTHS.items():
            render = sunstone(
                options,
                scene,
                integrator="bdpt",
                mode="scalar",
                # One more, for LuxCore's first is not timed.
                spp=samples + 1,
                seed=seed,
                width=SIZE,
                max_path_length=depth,
                roulette_after=1_000_000,
                threads=threads,
            )
            lap = ours[name]
            lap.seconds.append(render.cpu_seconds / (SIZE * SIZE * (samples + 1)))
            lap.images.append(render.image)
            lap.samples.append(samples + 1)

    for seed in range(1, options.rounds + 1):
        for run in take_turns([run_theirs, run_ours], seed):
            run(seed)
    for suffix, lap in ours.items():
        name = f"peers.luxcore.cornell.bdpt{suffix}.threads_{threads}"
        try:
            for sampler in SAMPLERS:
                found = agreement(theirs[sampler].images, lap.images)
                what = f"{name}, {sampler}"
                result.notes.append(require_agreement(what, found, allowed=ALLOWED))
        except RaceError as refusal:
            result.refusals.append(str(refusal))
        else:
            result.figures += figures(name, theirs, lap)


def figures(name: str, theirs: dict[str, Lap], ours: Lap) -> list[Figure]:
    plain = theirs[SAMPLERS[0]]
    result = [ratio_figure(f"{name}.speed_ratio", plain.seconds, ours.seconds, Goal(4.0, 6.0))]
    candidates = []
    for sampler, lap in theirs.items():
        figure = f"{name}.variance_ratio_{sampler.lower()}"
        result.append(variance_ratio(figure, ours.sample_variance(), lap.sample_variance()))
        faster = statistics.median(a / b for a, b in zip(lap.seconds, ours.seconds))
        candidates.append((faster, result[-1]))
    result += equal_error(name, candidates)
    for who, lap in (("luxcore", plain), ("sunstone", ours)):
        samples = 1 / statistics.median(lap.seconds)
        result.append(Figure(f"{name}.{who}_samples_per_cpu_second", samples))
    return result


def luxcore(
    lap: Lap,
    scene: Path,
    sampler: str,
    samples: int,
    seed: int,
    threads: int,
    options: Options,
) -> None:
    """One render in a process of its own."""
    image = options.work / "luxcore.npy"
    worker = Path(__file__).with_name("luxcore_worker.py")
    numbers = [SIZE, DEPTH, samples, seed, threads]
    command = [sys.executable, worker, scene, *numbers, sampler, image]
    answer = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    lines = [line for line in answer.stdout.splitlines() if line.startswith("{")]
    if answer.returncode != 0 or not lines:
        raise RaceError(f"LuxCore failed:\n{answer.stdout[-2000:]}{answer.stderr[-2000:]}")
    taken = json.loads(lines[-1])
    lap.seconds.append(taken["cpu_seconds"] / taken["samples"])
    lap.samples.append(taken["total"] / (SIZE * SIZE))
    lap.images.append(np.load(image).astype(np.float64))
