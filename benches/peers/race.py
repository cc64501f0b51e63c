#!/usr/bin/env python3
"""Races Sunstone against other renderers on the same scenes.

README.md beside this file says what is measured and what is needed. In short:

    python benches/peers/race.py                      all that are installed
    python benches/peers/race.py mitsuba --quick      a sanity pass
    python benches/peers/race.py --record benches/history.jsonl
"""

from __future__ import annotations

import argparse
import datetime
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Callable

REQUIREMENTS = "pip install -r benches/peers/requirements.txt"
for module in ("numpy", "OpenEXR"):
    if importlib.util.find_spec(module) is None:
        sys.exit(f"this needs the Python module {module}: {REQUIREMENTS}")

import embree_race  # noqa: E402
import luxcore_race  # noqa: E402
import mitsuba_race  # noqa: E402
import smallvcm_race  # noqa: E402
from common import (  # noqa: E402
    REPOSITORY,
    Options,
    PeerMissing,
    RaceError,
    Result,
    sunstone_version,
    table,
)

PEERS: dict[str, Callable[[Options], Result]] = {
    "mitsuba": mitsuba_race.race,
    "smallvcm": smallvcm_race.race,
    "luxcore": luxcore_race.race,
    "embree": embree_race.race,
}


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "peers", nargs="*", metavar="PEER", help=f"of {', '.join(PEERS)} [default: all]"
    )
    parser.add_argument("--rounds", type=int, help="pairs of renders [default: 7, --quick: 3]")
    parser.add_argument("--quick", action="store_true", help="few samples: is all in order?")
    parser.add_argument(
        "--threads",
        type=int,
        default=len(os.sched_getaffinity(0)),
        help="of both; Mitsuba is raced with one each [default: all processors]",
    )
    parser.add_argument("--sunstone", type=Path, default=REPOSITORY / "target/release/sunstone")
    parser.add_argument("--smallvcm", type=Path, help="SmallVCM's program: README.md builds it")
    parser.add_argument(
        "--embree", type=Path, help="Embree's library [default: that of the wheel embreex]"
    )
    parser.add_argument("--json", type=Path, help="write all figures to this file")
    parser.add_argument("--record", type=Path, help="append the figures as a line to this file")
    chosen = parser.parse_args()
    for name in chosen.peers:
        if name not in PEERS:
            parser.error(f"no race against {name!r} is written; there are {', '.join(PEERS)}")
    chosen.rounds = chosen.rounds or (3 if chosen.quick else 7)
    if chosen.rounds < 3:
        parser.error("--rounds: agreement needs the spread of at least three rounds")
    return chosen


def record(chosen: argparse.Namespace, version: str, result: Result) -> dict[str, Any]:
    """The line of a history: what was measured, when, of which commit, on what machine."""

    def git(*words: str) -> str:
        answer = subprocess.run(
            ["git", "-C", REPOSITORY, *words], capture_output=True, text=True, check=True
        )
        return answer.stdout.strip()

    dirty = "-dirty" if git("status", "--porcelain", "--untracked-files=no") else ""
    now = datetime.datetime.now(datetime.timezone.utc)
    model, processors = processor()
    return {
        "date": now.isoformat(timespec="seconds").replace("+00:00", "Z"),
        "commit": git("rev-parse", "--short", "HEAD") + dirty,
        "cpu": model,
        "processors": processors,
        "threads": chosen.threads,
        "version": version,
        "bench": "peers",
        "figures": {figure.name: round(figure.value, 5) for figure in result.figures},
    }


def processor() -> tuple[str, int]:
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else "unknown", len(models)


def main() -> None:
    chosen = arguments()
    whole, failed = Result(), False
    try:
        version = sunstone_version(chosen.sunstone)
    except RaceError as error:
        sys.exit(f"error: {error}")
    with tempfile.TemporaryDirectory() as work:
        options = Options(
            sunstone=chosen.sunstone,
            rounds=chosen.rounds,
            quick=chosen.quick,
            threads=chosen.threads,
            smallvcm=chosen.smallvcm,
            embree=chosen.embree,
            work=Path(work),
        )
        for name in chosen.peers or PEERS:
            try:
                result = PEERS[name](options)
            except PeerMissing as missing:
                print(f"skipped {name}: {missing}", flush=True)
                failed |= bool(chosen.peers)
            except RaceError as error:
                print(f"error: {name}: {error}", file=sys.stderr, flush=True)
                failed = True
            else:
                print("\n".join([*result.notes, "", table(result.figures), ""]), flush=True)
                for refusal in result.refusals:
                    print(f"error: {name}: {refusal}", file=sys.stderr, flush=True)
                failed |= bool(result.refusals)
                whole.figures += result.figures
                whole.notes += result.notes
    line = record(chosen, version, whole)
    if chosen.json:
        details = [
            {"name": f.name, "value": f.value, "interval": [f.low, f.high], "unit": f.unit}
            | ({"must": f.goal.must, "aim": f.goal.aim} if f.goal else {})
            for f in whole.figures
        ]
        text = json.dumps({**line, "notes": whole.notes, "details": details}, indent=1)
        chosen.json.write_text(text.replace("NaN", "null") + "\n")
    if chosen.record and whole.figures:
        with chosen.record.open("a") as history:
            history.write(json.dumps(line) + "\n")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
