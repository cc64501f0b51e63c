"""Sunstone's rays against Embree 4's: runs the program in `embree/` and takes its figures over."""

from __future__ import annotations

import importlib.util
import json
import subprocess
from pathlib import Path

from common import REPOSITORY, Figure, Goal, Options, PeerMissing, RaceError, Result, say

MANIFEST = REPOSITORY / "benches/peers/embree/Cargo.toml"


def race(options: Options) -> Result:
    library = options.embree or installed()
    # More rounds than renders need: a round takes a second.
    rounds = 3 if options.quick else max(options.rounds, 9)
    command = ["cargo", "run", "--release", "--quiet", "--manifest-path", str(MANIFEST), "--"]
    command += [str(library), "--json", "--rounds", str(rounds), "--threads", str(options.threads)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RaceError(done.stderr.strip())
    say(f"embree: {rounds} rounds")
    return figures(json.loads(done.stdout))


def figures(found: dict) -> Result:
    result = Result()
    add = result.figures.append
    for built in found["built"]:
        name = f"peers.embree.{built['scene']}"
        seconds = built["seconds"]
        times = seconds["sunstone"] / seconds["embree"]
        is_large = built["triangles"] > 4_000_000
        goals = [Goal(3, 1.5, at_most=True), Goal(160, 120, at_most=True)] if is_large else [None, None]
        add(exact(f"{name}.build_time_ratio", times, "x", goals[0]))
        add(exact(f"{name}.bytes_per_triangle", built["bytes_per_triangle"], "", goals[1]))
    for raced in found["raced"]:
        name = f"peers.embree.{raced['scene']}.{raced['set'].replace(' ', '_')}"
        add(exact(f"{name}.speed_ratio", raced["ratio"], "x"))
        add(exact(f"{name}.sunstone_ns", raced["nanoseconds"]["sunstone"], "ns"))
        if raced["differing"]:
            result.notes.append(f"{name}: {raced['differing']} rays differ by more than rounding")
    for kind, means, worst in [
        ("single", Goal(1.2, 1.4), Goal(0.9, 1.0)),
        ("coherent", Goal(0.6, 1.0), None),
    ]:
        summary = found[kind]
        add(exact(f"peers.embree.{kind}.mean.speed_ratio", summary["geometric_mean"], "x", means))
        add(exact(f"peers.embree.{kind}.worst.speed_ratio", summary["worst"], "x", worst))
    return result


def exact(name: str, value: float, unit: str, goal: Goal | None = None) -> Figure:
    """A median whose interval the program does not tell."""
    return Figure(name, value, unit=unit, goal=goal)


def installed() -> Path:
    """The library that the wheel `embreex` carries."""
    package = importlib.util.find_spec("embreex")
    if package is None or package.origin is None:
        raise PeerMissing("pip install embreex, or name libembree4 with --embree")
    folder = Path(package.origin).parent.parent / "embreex.libs"
    libraries = sorted(folder.glob("libembree4*"))
    if not libraries:
        raise PeerMissing(f"there is no libembree4 in {folder}: name it with --embree")
    return libraries[0]
