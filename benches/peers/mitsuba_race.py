"""Sunstone's `path` against Mitsuba 3's `path` and `volpath`, polarized and not."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import os
import statistics
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Optional

import numpy as np

from common import (
    REPOSITORY,
    Figure,
    Goal,
    Options,
    PeerMissing,
    RaceError,
    Render,
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

VERSION = "3.9.1"
SIZE = 256
#: So many samples a pixel are timed against SHORT of them: the difference has no fixed costs in
#: it, neither Mitsuba's tracing of its kernels nor our start.
SHORT = 4


@dataclass
class Course:
    """A scene of scenes/reference, with the longest path in segments and samples a pixel."""

    name: str
    depth: int
    samples: int


#: Samples are m n with n = m or m + 1 or so, and fourths of them (--quick) too: `multijitter` would
#: round others up.
COURSES = [Course("cornell", 12, 48), Course("mirror", 12, 144), Course("tank", 40, 36)]
#: The plainest is the fastest a sample; the other, in its favor, is what comes nearest to our
#: stratified samples, and errors are compared with whichever of them does better.
SAMPLERS = ["independent", "multijitter"]


@dataclass
class Variant:
    """A variant of Mitsuba, and the options that make Sunstone render the same."""

    name: str
    mitsuba: str
    mode: str
    color: str
    #: How many times as fast ours must be, scene by scene, and should be; of other scenes nothing.
    goals: dict[str, Goal]
    #: How many are carried together, if light has all of them; Mitsuba carries four.
    wavelengths: Optional[int] = None

    def options(self) -> dict[str, object]:
        carried = {"wavelengths": self.wavelengths} if self.wavelengths else {}
        return {"mode": self.mode, "color": self.color} | carried


def everywhere(must: float, aim: float) -> dict[str, Goal]:
    return {course.name: Goal(must, aim) for course in COURSES}


VARIANTS = [
    Variant("mono_polarized", "llvm_ad_mono_polarized", "polarized", "mono", everywhere(1.2, 1.7)),
    Variant(
        "spectral_polarized", "llvm_ad_spectral_polarized", "polarized", "rgb", everywhere(1.2, 1.7)
    ),
    Variant(
        "spectral_polarized_4",
        "llvm_ad_spectral_polarized",
        "polarized",
        "spectral",
        {"cornell": Goal(2.7, 2.7), "tank": Goal(2.2, 2.2)},
        wavelengths=4,
    ),
    Variant(
        "spectral_polarized_8",
        "llvm_ad_spectral_polarized",
        "polarized",
        "spectral",
        {"cornell": Goal(2.2, 2.2), "tank": Goal(1.7, 1.7)},
        wavelengths=8,
    ),
    Variant("rgb", "llvm_ad_rgb", "scalar", "rgb", everywhere(1.0, 1.3)),
    Variant("mono", "llvm_ad_mono", "scalar", "mono", everywhere(1.0, 1.3)),
]


def require_mitsuba() -> None:
    """Mitsuba itself, in the pinned version, and the LLVM that its variants compile with."""
    if importlib.util.find_spec("mitsuba") is None:
        raise PeerMissing("no module `mitsuba`: pip install -r benches/peers/requirements.txt")
    found = importlib.metadata.version("mitsuba")
    if found != VERSION:
        raise PeerMissing(f"mitsuba {found} is installed, the race is against {VERSION}")


class Mitsuba:
    """A worker process of one variant."""

    def __init__(self, variant: str, options: Options) -> None:
        self.output = options.work / f"{variant}.npy"
        worker = Path(__file__).with_name("mitsuba_worker.py")
        self.process = subprocess.Popen(
            [sys.executable, worker, variant, "1"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def render(self, scene: Path, sampler: str, course: Course, samples: int, seed: int) -> Render:
        task = {
            "scene": str(scene),
            "sampler": sampler,
            "size": SIZE,
            "depth": course.depth,
            "spp": samples,
            "seed": seed,
            "output": str(self.output),
        }
        print(json.dumps(task), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            llvm = os.environ.get("DRJIT_LIBLLVM_PATH", "not set")
            raise RaceError(
                "Mitsuba's process ended; what it said is above. If it found no LLVM, or an "
                "unfit one, install LLVM 19 and set DRJIT_LIBLLVM_PATH to its libLLVM.so "
                f"(now: {llvm})"
            )
        return Render(**json.loads(answer), image=np.load(self.output).astype(np.float64))

    def close(self) -> None:
        self.process.stdin.close()
        self.process.wait()


@dataclass
class Lap:
    """What one renderer did in all rounds: microseconds of CPU a sample, and its images."""

    microseconds: list[float] = field(default_factory=list)
    images: list[np.ndarray] = field(default_factory=list)

    def add(self, long: Render, short: Render, samples: int) -> None:
        seconds = long.cpu_seconds - short.cpu_seconds
        self.microseconds.append(seconds / (SIZE * SIZE * (samples - SHORT)) * 1e6)
        self.images.append(long.image)

    def intensities(self) -> list[np.ndarray]:
        return [image[..., :1] for image in self.images]


def race(options: Options) -> Result:
    require_mitsuba()
    result = Result()
    for variant in VARIANTS:
        mitsuba = Mitsuba(variant.mitsuba, options)
        try:
            for course in COURSES:
                say(f"mitsuba, {variant.name}, {course.name}: {options.rounds} rounds")
                one_course(mitsuba, variant, course, options, result)
        finally:
            mitsuba.close()
    return result


def one_course(
    mitsuba: Mitsuba, variant: Variant, course: Course, options: Options, result: Result
) -> None:
    scene = REPOSITORY / "scenes" / "reference" / f"{course.name}.gltf"
    samples = course.samples // 4 if options.quick else course.samples

    def renderer(sampler: str) -> Callable[[int, int], Render]:
        return lambda count, seed: mitsuba.render(scene, sampler, course, count, seed)

    def render_ours(count: int, seed: int) -> Render:
        return sunstone(
            options,
            scene,
            integrator="path",
            **variant.options(),
            spp=count,
            seed=seed,
            width=SIZE,
            max_path_length=course.depth,
            roulette_after=1_000_000,
            threads=1,
        )

    runners = [(Lap(), renderer(sampler)) for sampler in SAMPLERS] + [(Lap(), render_ours)]
    for _, render in runners:
        for count in (SHORT, samples):
            render(count, 0)
    for seed in range(1, options.rounds + 1):
        for lap, render in take_turns(runners, seed):
            short = render(SHORT, seed)
            lap.add(render(samples, seed), short, samples)
    name = f"peers.mitsuba.{course.name}.{variant.name}"
    *theirs, ours = [lap for lap, _ in runners]
    if variant.mode == "scalar":  # the scenes are grey: any channel is the luminance
        ours.images = [image[..., :1] for image in ours.images]
    try:
        for sampler, lap in zip(SAMPLERS, theirs):
            found = agreement(lap.images, ours.images)
            result.notes.append(require_agreement(f"{name}, {sampler}", found))
    except RaceError as refusal:
        result.refusals.append(str(refusal))
    else:
        result.figures += figures(name, variant.goals.get(course.name), theirs, ours)


def figures(name: str, goal: Optional[Goal], theirs: list[Lap], ours: Lap) -> list[Figure]:
    plain = theirs[0]
    speed = ratio_figure(f"{name}.speed_ratio", plain.microseconds, ours.microseconds, goal)
    result = [speed]
    candidates = []
    for sampler, lap in zip(SAMPLERS, theirs):
        # Ours must be no worse than plain samples.
        variance = variance_ratio(
            f"{name}.variance_ratio_{sampler}",
            pixel_variance(ours.intensities()),
            pixel_variance(lap.intensities()),
            Goal(1.0, 1.0, at_most=True) if lap is plain else None,
        )
        result.append(variance)
        faster = statistics.median(a / b for a, b in zip(lap.microseconds, ours.microseconds))
        candidates.append((faster, variance))
    result += equal_error(name, candidates)
    for who, lap in (("mitsuba", plain), ("sunstone", ours)):
        microseconds = statistics.median(lap.microseconds)
        result.append(Figure(f"{name}.{who}_us_per_sample", microseconds, unit="us"))
    return result
