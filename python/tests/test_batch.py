"""Batches from Python: results, errors, what is done, signals, ends before the end."""

from __future__ import annotations

import gc
import hashlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import sunstone
from conftest import CORNELL, SETTLED

DEFAULTS = """version = 1
[defaults]
scene = "lab.gltf"
integrator = "path"
spp = 2
width = 8
height = 8
"""
SWEEP = """
[[jobs]]
name = "sweep"
output = "out/{name}-{angle}-{ior}.exr"
sweep = [
    { name = "angle", key = "materials/half-wave plate/axis_deg", values = [0, 22.5] },
    { name = "ior", key = "materials/glass/ior", values = [1.33, 1.7] },
]
"""
#: Jobs that take their time.
LONG = """
[[jobs]]
name = "long"
output = "out/{n}.exr"
spp = 1000000
sweep = [{ name = "n", key = "seed", from = 0, to = 9, count = 10 }]
""".replace("{ name = \"n\"", "{ name = \"seed\"").replace("{n}", "{seed}")


@pytest.fixture
def lab(tmp_path: pathlib.Path) -> Callable[[str], pathlib.Path]:
    """Writes a job file beside its scene."""
    shutil.copy(CORNELL, tmp_path / "lab.gltf")
    for file in CORNELL.parent.glob("*.bin"):
        shutil.copy(file, tmp_path)

    def write(text: str) -> pathlib.Path:
        (tmp_path / "jobs.toml").write_text(DEFAULTS + text)
        return tmp_path / "jobs.toml"

    return write


def records(folder: pathlib.Path) -> list[dict[str, Any]]:
    lines = (folder / "results.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines]


def test_results_come_as_jobs_end(lab: Callable[[str], pathlib.Path]) -> None:
    jobs = lab(SWEEP)
    heard: list[tuple[int, int]] = []
    results = list(sunstone.batch(jobs, threads=2, progress=lambda *it: heard.append(it)))
    assert sorted(result.index for result in results) == [0, 1, 2, 3]
    scene = sunstone.load(jobs.parent / "lab.gltf")
    for result in results:
        assert result.name == "sweep" and result.error is None and not result.was_done
        assert set(result.values) == {"angle", "ior"}
        assert result.seconds is not None and 0 < result.seconds < 100
        content = pathlib.Path(result.output).read_bytes()
        assert hashlib.sha256(content).hexdigest() == result.checksum
        scene["materials/half-wave plate/axis_deg"] = result.values["angle"]
        scene["materials/glass/ior"] = result.values["ior"]
        image = scene.render(integrator="path", spp=2, width=8, height=8)
        assert np.array_equal(sunstone.Image.load(result.output).stokes, image.stokes)
    assert all(done <= total for done, total in heard)
    noted = {record["index"]: record for record in records(jobs.parent)}
    for result in results:
        record = noted[result.index]
        assert record["values"] == result.values and record["checksum"] == result.checksum
        assert jobs.parent / record["output"] == pathlib.Path(result.output)


def test_what_is_done_is_told_and_not_done_again(
    lab: Callable[[str], pathlib.Path], program: Callable[..., None]
) -> None:
    jobs = lab(SWEEP)
    plan = list(sunstone.batch(jobs, dry_run=True))
    assert [result.index for result in plan] == [0, 1, 2, 3]
    assert all(result.seconds is None and not result.was_done for result in plan)
    assert not (jobs.parent / "out").exists() and not (jobs.parent / "results.jsonl").exists()
    first = sorted(sunstone.batch(jobs), key=lambda result: result.index)
    again = list(sunstone.batch(jobs))
    assert [result.was_done for result in again] == [True] * 4
    assert [result._replace(was_done=False) for result in again] == first
    os.remove(first[2].output)
    third = {result.index: result.was_done for result in sunstone.batch(jobs)}
    assert third == {0: True, 1: True, 2: False, 3: True}
    dry = list(sunstone.batch(jobs, dry_run=True))
    assert all(result.was_done and result.seconds is not None for result in dry)
    # The program takes them for done too, and the other way round.
    times = {path: path.stat().st_mtime_ns for path in (jobs.parent / "out").iterdir()}
    program("batch", jobs, "--quiet")
    assert times == {path: path.stat().st_mtime_ns for path in (jobs.parent / "out").iterdir()}


def test_jobs_that_fail_stop_no_other(lab: Callable[[str], pathlib.Path]) -> None:
    bad = '[[jobs]]\nname = "bad"\noutput = "bad.exr"\nset = { "materials/glass/ior" = -1 }\n'
    jobs = lab(SWEEP + bad)
    results = {result.index: result for result in sunstone.batch(str(jobs))}
    assert len(results) == 5
    error = results[4].error
    assert error is not None and "ior: -1 must be greater than 0" in error
    assert results[4].checksum is None and results[4].name == "bad"
    assert all(results[index].error is None for index in range(4))


def test_all_that_is_wrong_is_raised_at_once(
    lab: Callable[[str], pathlib.Path], tmp_path: pathlib.Path
) -> None:
    one = '[[jobs]]\noutput = "a.exr"\nspp = 0\nset = { "materials/snow/ior" = 1 }\n'
    jobs = lab(one + '[[jobs]]\nname = "b"\nhue = 3\noutput = "../b.exr"\n')
    with pytest.raises(sunstone.Error) as caught:
        sunstone.batch(jobs)
    text = str(caught.value)
    for words in ("spp must be from 1", "no material is called `snow`", "hue: is not an option"):
        assert words in text, text
    assert "things are wrong" in text and not (tmp_path / "results.jsonl").exists()
    with pytest.raises(FileNotFoundError, match="none.toml"):
        sunstone.batch(tmp_path / "none.toml")
    with pytest.raises(sunstone.Error, match="ends in .toml or .jsonl"):
        sunstone.batch(tmp_path / "lab.gltf")
    jobs = lab('[[jobs]]\nname = "b"\noutput = "../b.exr"\n')
    with pytest.raises(sunstone.Error, match="outside of the folder of the job file"):
        sunstone.batch(jobs)
    with pytest.raises(sunstone.RenderError, match="threads must be from 1 to 4096, not 0"):
        list(sunstone.batch(lab(SWEEP), threads=0))
    with pytest.raises(sunstone.RenderError, match="threads must be a whole number"):
        list(sunstone.batch(lab(SWEEP), threads=-1))


def test_lines_of_json_are_jobs_too(
    lab: Callable[[str], pathlib.Path], tmp_path: pathlib.Path
) -> None:
    lab("")
    line = dict(scene="lab.gltf", spp=1, width=4, height=4, integrator="path")
    lines = [{**line, "output": f"{index}.exr", "name": f"n{index}"} for index in range(3)]
    (tmp_path / "jobs.jsonl").write_text("\n".join(map(json.dumps, lines)))
    other = tmp_path / "other results.jsonl"
    results = list(sunstone.batch(tmp_path / "jobs.jsonl", results=other))
    assert {result.name for result in results} == {"n0", "n1", "n2"} and other.exists()


def test_a_batch_ends_before_the_end(lab: Callable[[str], pathlib.Path]) -> None:
    short = SWEEP.replace('"sweep"', '"short"')
    jobs = lab(short + LONG)
    start = time.monotonic()
    for result in sunstone.batch(jobs):
        assert result.name == "short"
        break
    # It ended with the loop: the results are free, and nothing is rendered any more.
    assert time.monotonic() - start < 20
    busy = time.process_time()
    time.sleep(0.3)
    assert time.process_time() - busy < 0.2
    with sunstone.batch(jobs) as results:
        assert {next(results).name, next(results).name} <= {"short"}
        with pytest.raises(sunstone.Error, match="another batch is at work on it"):
            next(sunstone.batch(jobs))
    with pytest.raises(StopIteration):
        next(results)
    unused = sunstone.batch(jobs)
    del unused
    gc.collect()
    ends = sunstone.batch(jobs, progress=lambda done, total: False)
    assert {result.name for result in ends} <= {"short"}
    assert all("partial" not in name for name in os.listdir(jobs.parent / "out"))
    assert not [record for record in records(jobs.parent) if record["name"] == "long"]


def test_what_progress_raises_ends_a_batch(lab: Callable[[str], pathlib.Path]) -> None:
    def progress(done: int, total: int) -> None:
        raise LookupError(f"{done} of {total}")

    with pytest.raises(LookupError, match="of 640000000"):
        list(sunstone.batch(lab(LONG), progress=progress))


def test_the_interpreter_is_free(lab: Callable[[str], pathlib.Path]) -> None:
    jobs = lab(LONG)
    batch = sunstone.batch(jobs)
    worker = threading.Thread(target=lambda: list(batch), daemon=True)
    stop = sunstone.batch(jobs, progress=None)
    del stop
    worker.start()
    turns, last, longest = 0, time.monotonic(), 0.0
    while turns < 100:
        time.sleep(0.005)
        turns, longest, last = turns + 1, max(longest, time.monotonic() - last), time.monotonic()
    assert longest < 0.5
    with pytest.raises((RuntimeError, sunstone.Error)):
        # Who waits for results has the batch; another one finds them taken.
        next(sunstone.batch(jobs))


@pytest.mark.parametrize("where", ["waiting", "loop"])
def test_ctrl_c_ends_a_batch_within_a_second(
    where: str, lab: Callable[[str], pathlib.Path]
) -> None:
    jobs = lab(SWEEP + LONG)
    code = (
        "import signal, sunstone, time\n"
        # Whoever starts the tests in the background has children ignore it.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "try:\n"
        f"    for result in sunstone.batch({str(jobs)!r}):\n"
        "        print('ready', flush=True)\n"
        f"        if {where == 'loop'}: time.sleep(60)\n"
        "except KeyboardInterrupt:\n"
        "    stopped = time.monotonic()\n" + SETTLED
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"ready\n"
        time.sleep(1.0)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    stopped, busy = map(float, out.split()[-2:])
    assert stopped - sent < 1.0 and busy < 0.1
    assert not list((jobs.parent / "out").glob("[0-9].exr"))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")
def test_a_forked_batch_raises(lab: Callable[[str], pathlib.Path]) -> None:
    batch = sunstone.batch(lab(SWEEP + LONG))
    next(batch)
    reader, writer = os.pipe()
    if (child := os.fork()) == 0:
        try:
            next(batch)
        except sunstone.RenderError:
            os.write(writer, b"raised")
        batch.close()
        os._exit(0)
    os.close(writer)
    assert os.read(reader, 100) == b"raised"
    os.waitpid(child, 0)
    batch.close()


def test_warnings_are_told_once(lab: Callable[[str], pathlib.Path]) -> None:
    jobs = lab(SWEEP)
    text = (jobs.parent / "lab.gltf").read_text()
    text = text.replace('"extensionsUsed": [', '"extensionsUsed": ["ACME_x", ', 1)
    (jobs.parent / "lab.gltf").write_text(text)
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        results = list(sunstone.batch(jobs))
    assert all(any("ACME_x" in text for text in result.warnings) for result in results)
    told = [it for it in heard if "ACME_x" in str(it.message)]
    assert len(told) == 1 and told[0].category is sunstone.RenderWarning
    assert told[0].filename == __file__ and 'job ' in str(told[0].message)
    # Made an error, it keeps no result from whoever goes on.
    (jobs.parent / "results.jsonl").unlink()
    batch = sunstone.batch(jobs)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sunstone.RenderWarning, match="ACME_x"):
            next(batch)
        assert sorted(result.index for result in batch) == [0, 1, 2, 3]


def test_texts_name_options_as_python_does(lab: Callable[[str], pathlib.Path]) -> None:
    jobs = lab(SWEEP.replace("out/{name}", "../{name}"))
    with pytest.raises(sunstone.Error, match="allow it by allow_outside=True"):
        sunstone.batch(jobs)
    jobs = lab(SWEEP)
    (jobs.parent / "lab").mkdir()
    (jobs.parent / "lab" / "lab.gltf").write_text(
        '{"asset": {"version": "2.0"}, "scenes": [{}],'
        ' "buffers": [{"byteLength": 1, "uri": "../jobs.toml"}]}')
    jobs.write_text(jobs.read_text().replace("lab.gltf", "lab/lab.gltf").split("[[jobs]]")[0]
                    + "[[jobs]]\noutput = \"a.exr\"\n")
    result, = sunstone.batch(jobs)
    assert result.error is not None and "trust the scene: allow_outside=True" in result.error


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no full device")
def test_results_that_cannot_be_noted_are_an_error_in_the_end(
    lab: Callable[[str], pathlib.Path],
) -> None:
    jobs = lab(SWEEP)
    (jobs.parent / "full.jsonl").symlink_to("/dev/full")
    results = []
    with pytest.raises(OSError, match="full.jsonl"):
        for result in sunstone.batch(jobs, results=jobs.parent / "full.jsonl"):
            results.append(result)
    assert len(results) in (0, 4)
