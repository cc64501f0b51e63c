"""Looks at pages of `sunstone report` in Chromium: what they show is what is in the files.

Images are made here with OpenEXR's own library, and read with it; what is to be seen is computed
here with NumPy from what was read.

    python check_report.py PROGRAM
"""

import csv
import hashlib
import json
import os
import shutil
import sys
import time
from pathlib import Path
from urllib.parse import unquote, urlparse

import numpy as np
import OpenEXR

from check import CENTERS, many, run, save, save_bands, seen, settle, sky, srgb

SCENES = Path(__file__).resolve().parents[2] / "scenes"
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def record(index, output, folder, **others):
    """What a batch would have noted."""
    path = folder / output
    checksum = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None
    known = dict(jobs="jobs.toml", index=index, name="job", values={}, output=output,
                 seconds=0.5 + index, error=None, checksum=checksum, key="", inputs={})
    return known | others


def write_report(checks, folder, records, *options):
    (folder / "results.jsonl").write_text("".join(json.dumps(line) + "\n" for line in records))
    checks.sunstone("report", str(folder), "-o", str(folder / "report.html"), *options)


def report(checks, folder, records, *options, **settings):
    """The page of a batch, in a browser."""
    write_report(checks, folder, records, *options)
    return checks.look(folder / "report.html", **settings)


def planes_of(path):
    """Stokes planes of a file: an array (components, channels, height, width)."""
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    pixels = {name: channel.pixels for name, channel in channels.items()}
    for suffixes in ([".R", ".G", ".B"], [""]):
        names = [[f"S{component}{suffix}" for suffix in suffixes] for component in range(4)]
        names = [row for row in names if all(name in pixels for name in row)]
        if names:
            return np.array([[pixels[name] for name in row] for row in names])
    return np.array([[pixels[name] for name in "RGB"]])


def figures_of(path, channel=None):
    """All figures of an image, by the names that the page has for them."""
    planes = planes_of(path).astype(np.float64)
    planes = planes[:, :, np.isfinite(planes).all(axis=(0, 1))]
    mean = planes.mean(axis=2) if planes.shape[2] else np.full(planes.shape[:2], np.nan)
    if mean.shape[1] == 1:
        stokes = mean[:, 0]
    else:
        stokes = mean @ LUMINANCE if channel is None else mean[:, channel]
    found = {f"s{component}": value for component, value in enumerate(stokes)}
    if len(stokes) == 4 and stokes[0] > 0:
        s0, s1, s2, s3 = stokes
        linear = np.hypot(s1, s2)
        found |= {f"s{i}/s0": stokes[i] / s0 for i in (1, 2, 3)}
        found |= {"dop": np.hypot(linear, s3) / s0, "dolp": linear / s0}
        if linear > 0:
            found["aolp"] = np.degrees(np.arctan2(s2, s1) / 2 % np.pi)
        if linear > 0 or s3 != 0:
            found["ellipticity"] = np.degrees(np.arctan2(s3, linear) / 2)
    return {name: value for name, value in found.items() if np.isfinite(value)}


def cards(page):
    """The cards that are shown: their jobs, figures and words."""
    page.evaluate("() => document.getElementById('more').scrollIntoView()")
    settle(page)
    return page.evaluate("""() => [...document.querySelectorAll(".card")].map((card) => ({
        job: Number(card.dataset.job),
        text: card.textContent,
        link: card.querySelector("a")?.href ?? null,
        figures: Object.fromEntries([...card.querySelectorAll("[data-figure]")].map((part) =>
            [part.dataset.figure, "value" in part.dataset ? Number(part.dataset.value) : null])),
    }))""")


def points(page, y, x, series=""):
    """What a plot shows: for each point its place, and the series."""
    for key, value in (("y", y), ("x", x), ("series", series)):
        page.select_option(f"#plot-{key}", value)
    settle(page)
    found = page.evaluate("""() => [...document.querySelectorAll("#chart .points circle")].map(
        (point) => [point.dataset.x, point.dataset.y, point.dataset.series,
            point.getAttribute("cx"), point.getAttribute("cy")])""")
    return [(float(x), float(y), series, float(cx), float(cy)) for x, y, series, cx, cy in found]


def folder_with_images(checks, name):
    """A batch of images of all kinds, with trouble."""
    folder = checks.folder / name
    (folder / "out").mkdir(parents=True)
    random = np.random.default_rng(7)
    records = []
    for index in range(24):
        angle, kind = 15.0 * (index % 12), ["plain", "odd"][index // 12]
        planes = sky(20 + index, 12, channels="RGB" if index % 3 else "M", degree=1 / (1 + index))
        planes *= random.uniform(0.2, 0.8, planes.shape[-2:]).astype(np.float32)
        if index % 5 == 4:
            planes = planes[:1]
        if index == 7:
            planes[0, 0, 3, 3:6] = [np.nan, np.inf, -np.inf]
        if index == 8:
            planes[:] = np.nan
        save(folder / f"out/{index}.exr", planes)
        values = {"angle": angle, "kind": kind, "far": index}
        records.append(record(index, f"out/{index}.exr", folder, name=f"set {kind}", values=values))
    records[3]["checksum"] = "0" * 64
    (folder / "out/5.exr").unlink()
    (folder / "out/6.exr").write_bytes((folder / "out/4.exr").read_bytes()[:200])
    for index in range(24, 34):
        cause = f"materials/glass/ior: {index} is below zero <b>"
        records.append(record(index, f"out/{index}.exr", folder, name="bad", error=cause,
                              values={"kind": "odd", "far": index}))
    return folder, records


def check_figures(checks):
    """Cards, plots, the table and the opened job have the numbers of the files."""
    folder, records = folder_with_images(checks, "figures")
    page = report(checks, folder, records)
    files = {index: folder / f"out/{index}.exr" for index in range(24) if index not in (5, 6)}
    expected = {index: figures_of(path) for index, path in files.items()}
    found = cards(page)
    assert [card["job"] for card in found] == list(range(34))
    for card in found:
        index, shown = card["job"], card["figures"]
        assert shown["seconds"] == records[index]["seconds"]
        if index not in expected:
            assert set(shown) == {"seconds"} and card["link"] is None or index == 6, card
            continue
        for name in ("s0", "dop", "aolp"):
            value = expected[index].get(name)
            found_it = shown[name]
            near = found_it is None if value is None else np.isclose(found_it, value, rtol=1e-6)
            assert near, (index, name, shown, value)
        assert Path(unquote(urlparse(card["link"]).path)) == files[index]
    for index in range(24, 34):
        assert f"{index} is below zero <b>" in found[index]["text"]
    assert "checksum differs" in found[3]["text"] and "the image is gone" in found[5]["text"]
    assert "not a usable EXR file" in found[6]["text"]
    assert "3 pixels are not finite" in found[7]["text"]
    assert "34 jobs · 10 failed · 2 without an image to show · 1 changed since" in (
        page.text_content("#summary"))
    # Every figure over every axis, by channel too.
    count = 0
    for channel in (None, 0, 2):
        page.select_option("#channel", "" if channel is None else str(channel))
        of_channel = {index: figures_of(path, channel) for index, path in files.items()}
        for name in ("s0", "s1", "s2", "s3", "s1/s0", "s2/s0", "s3/s0", "dop", "dolp", "aolp",
                     "ellipticity"):
            for axis in ("angle", "far"):
                shown = points(page, name, f"axis:{axis}")
                values = sorted((records[index]["values"][axis], figures[name])
                                for index, figures in of_channel.items() if name in figures)
                assert np.allclose(sorted(point[:2] for point in shown), values, rtol=1e-6,
                                   atol=1e-12), (name, axis, channel)
                count += len(shown)
    shown = points(page, "seconds", "axis:kind", "axis:kind")
    assert sorted(point[:3] for point in shown) == sorted(
        (kind, records[index]["seconds"], str(kind))
        for index in range(34) for kind in [int(index >= 12)])
    # Points lie where their values are.
    *_, cx, cy = np.array([point for point in points(page, "index", "seconds")], dtype=object).T
    for coordinates in (cx, cy):
        steps = np.diff(coordinates.astype(float))
        assert np.allclose(steps, steps[0], atol=1e-6)
    with page.expect_download() as download:
        page.select_option("#channel", "")
        page.click("#save")
    rows = list(csv.DictReader(Path(download.value.path()).open(newline="")))
    assert len(rows) == 34 and rows[30]["cause"] == records[30]["error"]
    for row, line in zip(rows, records, strict=True):
        assert row["name"] == line["name"] and row["far"] == str(line["values"]["far"])
        for name, value in expected.get(line["index"], {}).items():
            assert np.isclose(float(row[name]), value, rtol=1e-6, atol=1e-12), (name, row)
    checks.close(page)
    print(f"  {count} points of plots are figures of the files")


def check_opened_jobs(checks):
    folder, records = folder_with_images(checks, "opened")
    page = report(checks, folder, records, color_scheme="dark")
    page.click(".card >> nth=1 >> button")
    mean = planes_of(folder / "out/1.exr").astype(np.float64).mean(axis=(2, 3))
    table = page.evaluate("""() => Object.fromEntries([...document.querySelectorAll(
        "#details table tr")].slice(1).map((row) => [row.cells[0].textContent,
        [...row.cells].slice(1).map((cell) => Number(cell.dataset.value))]))""")
    for component in range(4):
        assert np.allclose(table[f"S{component}"][:3], mean[component], rtol=1e-12)
    assert page.text_content("#details-title") == "set plain"
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert page.get_attribute("#details", "data-job") == "3"
    assert "checksum differs" in page.text_content("#details")
    page.keyboard.press("Escape")
    assert not page.locator("#details").is_visible()
    # The plot from the keyboard.
    page.keyboard.press("p")
    page.keyboard.press("ArrowRight")
    assert page.text_content("#plot-words").startswith("set plain (0): "), (
        page.text_content("#plot-words"))
    page.keyboard.press("Enter")
    assert page.get_attribute("#details", "data-job") == "0"
    page.keyboard.press("Escape")
    page.keyboard.press("j")
    page.keyboard.press("Enter")
    assert page.locator("#details").is_visible()
    checks.close(page)


def check_filters(checks):
    folder, records = folder_with_images(checks, "filters")
    page = report(checks, folder, records)

    def shown(test):
        settle(page)
        expected = [line["index"] for line in records if test(line)]
        found = [card["job"] for card in cards(page)]
        assert found == expected, (found, expected)
        words = f"{len(expected)} of {len(records)} jobs"
        assert page.text_content("#count") == (words if expected != list(range(34)) else "34 jobs")

    def choose(title, value, on=True):
        chip = page.locator(f'[data-filter="{title}"] input[value=\'{json.dumps(value)}\']')
        chip.set_checked(on, force=True)

    shown(lambda line: True)
    choose("kind", "odd")
    shown(lambda line: line["values"]["kind"] == "odd")
    choose("angle", 30)
    choose("angle", None)
    shown(lambda line: line["values"]["kind"] == "odd"
          and line["values"].get("angle") in (30, None))
    choose("State", "done")
    shown(lambda line: line["index"] == 14)
    page.click("#reset")
    shown(lambda line: True)
    page.fill('[aria-label="far from"]', "3.5")
    page.fill('[aria-label="far to"]', "28")
    shown(lambda line: 3.5 <= line["values"]["far"] <= 28)
    page.keyboard.press("Escape")
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("/")
    page.keyboard.type("below ZERO 2")
    shown(lambda line: line["index"] in range(24, 29))
    page.fill("#search", "nowhere")
    shown(lambda line: False)
    assert page.locator("#chart circle").count() == 0
    page.click("#reset")
    choose("State", "changed")
    choose("State", "no image")
    shown(lambda line: line["index"] in (3, 5, 6))
    page.click("#reset")
    # Sorted by a figure; what has none comes last.
    page.select_option("#sort", "dop")
    page.click("#turn")
    order = [card["figures"].get("dop") for card in cards(page)]
    known = [value for value in order if value is not None]
    assert known == sorted(known, reverse=True) and order[len(known):] == [None] * (34 - len(known))
    checks.close(page)


def codes(page, job, place):
    """The colors of a small copy, as they are on its canvas."""
    page.wait_for_selector(f'.card[data-job="{job}"][data-painted]')
    settle(page)
    width, height, data = page.evaluate("""([job, place]) => {
        const canvas = document.querySelectorAll(`.card[data-job="${job}"] canvas`)[place];
        const { width, height } = canvas;
        const copy = new OffscreenCanvas(width, height).getContext("2d");
        copy.drawImage(canvas, 0, 0);
        return [width, height, [...copy.getImageData(0, 0, width, height).data]];
    }""", [job, place])
    return np.array(data, dtype=int).reshape(height, width, 4)[..., :3]


def check_maps(checks):
    """Small copies have the colors of `visualize`, as far as a byte a value tells."""
    folder = checks.folder / "maps"
    folder.mkdir()
    size = (64, 48)
    cases = [sky(*size), sky(*size, degree=0.3), sky(*size)[:1], sky(*size, channels="M")]
    cases[0][0, 0, 5, 5] = np.nan
    for index, planes in enumerate(cases):
        save(folder / f"{index}.exr", planes)
    save(folder / "large.exr", np.repeat(np.repeat(cases[1], 9, axis=2), 9, axis=3))
    names = ["0.exr", "1.exr", "2.exr", "3.exr", "large.exr"]
    page = report(checks, folder, [record(i, name, folder) for i, name in enumerate(names)],
                  "--thumbnails", "64", viewport={"width": 1500, "height": 1600})
    worst = {}
    for index, planes in [*enumerate(cases), (4, cases[1])]:
        bad = ~np.isfinite(planes).all(axis=(0, 1))
        seen = np.where(bad, 0, planes[0].astype(np.float64))
        error = abs(codes(page, index, 0) - srgb(seen).transpose(1, 2, 0)).max()
        worst["intensity"] = max(worst.get("intensity", 0), error)
        if planes.shape[0] == 1:
            assert (codes(page, index, 1) == [70, 70, 76]).all()
            continue
        file = f"{min(index, 3)}.exr" if index < 4 else "1.exr"
        for place, name in ((1, "dop"), (2, "aolp")):
            full = checks.visualized(str(folder / file), name, size, ("--full-scale",))[0]
            error = abs(codes(page, index, place) - full).max(axis=2)
            # Where it is almost dark, a byte tells no light from hardly any.
            lit = planes[0].mean(axis=0) > 1e-3
            worst[name] = max(worst.get(name, 0), error[lit].max())
    assert worst["intensity"] <= 3 and worst["dop"] <= 4 and worst["aolp"] <= 8, worst
    # Other maps and exposures: nothing is asked for, and colors change.
    before = codes(page, 0, 1)
    page.select_option("#maps select >> nth=1", "ellipticity")
    assert (codes(page, 0, 1) != before).any()
    page.evaluate("""() => {
        const slider = document.getElementById("exposure");
        slider.value = -2;
        slider.dispatchEvent(new Event("input"));
    }""")
    page.wait_for_function("() => document.querySelector('.card canvas').title !== ''")
    settle(page)
    darker = srgb(np.nan_to_num(cases[1][0].astype(np.float64)) / 4).transpose(1, 2, 0)
    assert abs(codes(page, 1, 0) - darker).max() <= 3
    checks.close(page)
    words = ", ".join(f"{error:.1f} codes off in {name}" for name, error in worst.items())
    print(f"  at most {words}")


def check_malus(checks):
    """The shipped sweep: what is plotted over the plate's angle follows Malus' law."""
    folder = checks.folder / "malus"
    folder.mkdir()
    for name in ("malus.toml", "cornell.gltf"):
        shutil.copy(SCENES / name, folder)
    checks.sunstone("batch", str(folder / "malus.toml"), "-q")
    lines = [json.loads(line) for line in (folder / "results.jsonl").read_text().splitlines()]
    page = report(checks, folder, lines)
    lines = [line for line in lines if line["values"]]
    files = {(line["values"]["angle"], line["values"]["ior"]): figures_of(folder / line["output"])
             for line in lines}
    for figure in ("s0", "s1/s0"):
        shown = points(page, figure, "axis:angle", "axis:ior")
        assert len(shown) == 24
        for angle, value, ior, *_ in shown:
            assert np.isclose(value, files[angle, float(ior)][figure], rtol=1e-6), (angle, ior)
    # A half-wave plate at an angle between crossed polarizers lets sin^2 of twice that through.
    for ior in (1.33, 1.5, 1.7):
        curve = np.array([(x, y) for x, y, key, *_ in points(page, "s0", "axis:angle", "axis:ior")
                          if float(key) == ior])
        share = np.sin(2 * np.radians(curve[:, 0])) ** 2
        basis = np.stack([np.ones_like(share), share], axis=1)
        (dark, bright), *_ = np.linalg.lstsq(basis, curve[:, 1], rcond=None)
        rest = abs(curve[:, 1] - basis @ [dark, bright]).max()
        assert bright > 0 and rest < 0.05 * bright, (ior, dark, bright, rest)
        print(f"  ior {ior}: {dark:.5f} + {bright:.5f} sin^2, at most {rest / bright:.1%} off")
    checks.close(page)


def check_names(checks):
    folder = checks.folder / "batch <i>&'\" 100% #1? ü"
    folder.mkdir()
    names = ["<script>alert(1)<.exr", "a\"b'c.exr", "100% of #1?.exr", "{{data}} & ünï 漢.exr",
             "javascript:alert(1).exr", " .exr"]
    hostile = "</script><script>alert(1)</script><!-- \u2028 \u202e"
    records = []
    for index, name in enumerate(names):
        save(folder / name, sky(4, 3))
        values = {name: name, "__proto__": index, "": [1, {"<b>": None}], "constructor": True}
        records.append(record(index, name, folder, name=name, values=values, jobs=hostile))
    records.append(record(6, hostile, folder, name=hostile, error=hostile))
    page = report(checks, folder, records)
    assert page.title() == folder.name and page.text_content("#name") == folder.name
    found = cards(page)
    for name, card in zip(names, found):
        assert name in card["text"] and f"__proto__ {card['job']}" in card["text"], card
        assert Path(unquote(urlparse(card["link"]).path)) == folder / name
    assert "</script><script>alert(1)</script>" in found[6]["text"]
    for key in ("y", "x", "series"):
        for value in page.eval_on_selector_all(f"#plot-{key} option", "l => l.map((o) => o.value)"):
            page.select_option(f"#plot-{key}", value)
    page.click(".card >> nth=6 >> button")
    checks.close(page)


def check_odd_batches(checks):
    folder = checks.folder / "odd"
    folder.mkdir()
    page = report(checks, folder, [])
    assert "There are no jobs" in page.text_content("#summary")
    checks.close(page)
    failed = [record(i, f"{i}.exr", folder, error="no") for i in range(3)]
    page = report(checks, folder, failed)
    assert len(cards(page)) == 3 and not page.locator("#maps").is_visible()
    checks.close(page)
    save(folder / "0.exr", sky(1, 500, channels="M")[:1])
    small = {"width": 400, "height": 700}
    page = report(checks, folder, [record(0, "0.exr", folder)], viewport=small)
    assert len(cards(page)) == 1
    page.click(".card button")
    checks.close(page)


def check_a_thousand_jobs(checks):
    """Images of noise, which shrink least; ten thousand are links to the same."""
    folder = checks.folder / "thousand"
    folder.mkdir()
    random = np.random.default_rng(1)
    for index in range(100):
        noise = random.uniform(0.1, 1, (64, 64)).astype(np.float32)
        planes = sky(64, 64) * noise * random.uniform(0.5, 1, (1, 3, 64, 64)).astype(np.float32)
        planes[1:] *= random.uniform(-1, 1, (3, 1, 64, 64)).astype(np.float32)
        save(folder / f"{index}.exr", planes)
    for count, megabytes in ((1000, 32), (10000, 55)):
        for index in range(count):
            if not (folder / f"{index}.exr").exists():
                os.link(folder / f"{index % 100}.exr", folder / f"{index}.exr")
        records = [record(i, f"{i}.exr", folder, name="noise", checksum=None,
                          values={"angle": i % 100 * 1.8, "ior": 1.3 + i // 100 / 100})
                   for i in range(count)]
        times = [time.monotonic()]
        write_report(checks, folder, records)
        times.append(time.monotonic())
        page = checks.look(folder / "report.html")
        page.wait_for_selector(".card[data-painted]")
        times.append(time.monotonic())
        page.fill('[aria-label="angle to"]', "9")
        settle(page)
        assert page.text_content("#count") == f"{count // 100 * 6} of {count} jobs"
        times.append(time.monotonic())
        checks.close(page)
        size = (folder / "report.html").stat().st_size / 1e6
        made, opened, filtered = np.diff(times)
        print(f"  {count} jobs: {size:.1f} MB, made in {made:.1f} s, opened in {opened:.1f} s, "
              f"filtered in {filtered:.1f} s")
        assert size < megabytes


def check_images_of_bands(checks):
    """They are shown as what is seen of them, or as their mean."""
    folder = checks.folder / "bands"
    (folder / "out").mkdir(parents=True)
    planes = many(24, 18, CENTERS)
    save_bands(folder / "out/0.exr", planes, CENTERS)
    near = np.array([800.0, 850.0, 900.0])
    save_bands(folder / "out/1.exr", planes[:, :3], near)
    page = report(checks, folder, [record(index, f"out/{index}.exr", folder) for index in (0, 1)])
    found = {card["job"]: card["figures"] for card in cards(page)}
    means = planes.astype(np.float64).mean(axis=(2, 3))
    colors = np.stack([seen(mean[:, None, None], CENTERS)[:, 0, 0] for mean in means])
    expected = {0: colors @ LUMINANCE, 1: means[:, :3].mean(axis=1)}
    for job, stokes in expected.items():
        # The matrix of the standard, by which colors are computed here, has four digits.
        assert np.isclose(found[job]["s0"], stokes[0], rtol=1e-3), (job, found[job], stokes)
        degree = np.linalg.norm(stokes[1:]) / stokes[0]
        assert np.isclose(found[job]["dop"], degree, atol=2e-3), (job, found[job], degree)
    for job, words in enumerate(("31 bands from 400 to 700 nm", "mean of 3 bands")):
        page.locator(f".card[data-job='{job}'] button, .card[data-job='{job}'] h2").first.click()
        settle(page)
        assert words in page.text_content("dialog"), page.text_content("dialog")
        page.keyboard.press("Escape")
    checks.close(page)


if __name__ == "__main__":
    run(dict(globals()))
