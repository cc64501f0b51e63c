"""Looks at pages of `sunstone view` in Chromium: what they show is what is in the files.

The images are made here with OpenEXR's own library, what is to be seen is computed here with
NumPy, and maps are compared with the pictures of `sunstone visualize`.

    python check.py PROGRAM
"""

import base64
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image
from playwright.sync_api import sync_playwright

CHROMIUM = "/usr/bin/chromium"
FLAGS = """--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
    --disable-component-update --disable-sync""".split()
# The color at the middle of every pixel of the image on the screen.
READ_PICTURE = """([width, height]) => {
    const canvas = document.getElementById("picture");
    const [left, top, zoom] = ["left", "top", "zoom"].map((key) => Number(canvas.dataset[key]));
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    const codes = [];
    for (let y = 0; y < height; y += 1) {
        for (let x = 0; x < width; x += 1) {
            const at = 4 * (Math.floor(top + (y + 0.5) * zoom) * canvas.width
                + Math.floor(left + (x + 0.5) * zoom));
            codes.push(data[at], data[at + 1], data[at + 2]);
        }
    }
    return codes;
}"""


def sky(width, height, channels="RGB", degree=1.0):
    """Stokes planes of every polarization there is: an array (4, channels, height, width)."""
    y, x = np.mgrid[0:height, 0:width]
    dx, dy = 2 * (x + 0.5) / width - 1, 1 - 2 * (y + 0.5) / height
    radius, angle = np.hypot(dx, dy), 2 * np.arctan2(dy, dx)
    share = degree * np.clip(1.1 - abs(radius - 0.7) * 2.2, 0, 1)
    circular = np.clip(3 * dx * dy, -1, 1)
    linear = np.sqrt(1 - circular**2)
    unit = [np.ones_like(dx), share * linear * np.cos(angle), share * linear * np.sin(angle)]
    unit = np.stack([*unit, share * circular])
    s0 = [(0.9 - 0.2 * i) * (1.1 - dx) * (radius < 1.3) for i in range(len(channels))]
    return (unit[:, None] * np.stack(s0)[None]).astype(np.float32)


def save(path, planes, variances=None):
    """Writes planes with the channels that Sunstone gives them."""
    components, channels = planes.shape[:2]
    suffixes = [".R", ".G", ".B"] if channels == 3 else [""]
    parts = {}
    for component in range(components):
        for channel, suffix in enumerate(suffixes):
            name = f"S{component}{suffix}"
            parts[name] = planes[component, channel]
            if variances is not None:
                parts[f"variance.{name}"] = variances[component, channel]
    if channels == 3 and components == 1:
        parts = {name.replace("S0.", "") if "var" not in name else name: plane
                 for name, plane in parts.items()}
    parts = {name: np.ascontiguousarray(plane) for name, plane in parts.items()}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, parts).write(str(path))


def srgb(linear):
    """Codes of the sRGB standard, not rounded."""
    linear = np.clip(np.nan_to_num(linear.astype(np.float64), nan=0.0, posinf=1.0, neginf=0.0), 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def analyzed(planes, kind, degrees=0.0):
    """What an ideal analyzer lets through, by channel."""
    s0, s1, s2, s3 = planes.astype(np.float64)
    double = np.radians(2 * degrees)
    return {
        "none": lambda: s0,
        "linear": lambda: (s0 + s1 * np.cos(double) + s2 * np.sin(double)) / 2,
        "right": lambda: (s0 + s3) / 2,
        "left": lambda: (s0 - s3) / 2,
    }[kind]()


class Checks:
    """Pages in a browser, with everything that they say or ask for."""

    def __init__(self, program, folder, browser):
        self.program, self.folder, self.browser = program, folder, browser

    def sunstone(self, *arguments):
        subprocess.run([self.program, *arguments], cwd=self.folder, check=True, capture_output=True)

    def open(self, *files, options=(), **settings):
        """The page of these images."""
        self.sunstone("view", *files, "-o", "page.html", *options)
        return self.look("page.html", **settings)

    def look(self, name, **settings):
        """A page in the browser."""
        settings = {"viewport": {"width": 1280, "height": 800}} | settings
        page = self.browser.new_context(**settings).new_page()
        page.said = []
        page.on("console", lambda message: page.said.append(message.text))
        page.on("pageerror", lambda error: page.said.append(str(error)))
        page.on("request", lambda request: page.said.append(request.url))
        self.address = (self.folder / name).as_uri()
        page.goto(self.address)
        page.wait_for_selector("html[data-ready]", timeout=60000)
        return page

    def close(self, page):
        """Nothing was said, and nothing asked for but the page (and what it made itself)."""
        others = [text for text in page.said if text != self.address]
        others = [text for text in others if not text.startswith(("blob:", "data:"))]
        assert others == [], others
        page.context.close()

    def visualized(self, file, name, size, options=()):
        """The map of `visualize`, a color a pixel; for the Stokes planes, three of them."""
        self.sunstone("visualize", file, "-o", "map.png", "--map", name, *options)
        picture = np.asarray(Image.open(self.folder / "map.png").convert("RGB"), dtype=int)
        width, height = size
        scale = -(-250 // width)
        cut = lambda x, y: picture[y:, x:][: scale * height : scale, : scale * width : scale]
        if not name.startswith("stokes"):
            return [cut(0, 0)]
        gap = 5 * -(-scale * width // 420)
        right, below = scale * width + gap, (picture.shape[0] - gap) // 2 + gap
        return [cut(right, 0), cut(0, below), cut(right, below)]


def settle(page):
    """Waits until what was changed is drawn."""
    page.evaluate("() => new Promise((done) => "
                  "requestAnimationFrame(() => requestAnimationFrame(done)))")


def picture(page, size):
    settle(page)
    codes = page.evaluate(READ_PICTURE, list(size))
    return np.array(codes, dtype=int).reshape(size[1], size[0], 3)


def hover(page, x, y):
    """Moves the pointer over a pixel of the image."""
    settle(page)
    box = page.locator("#picture").bounding_box()
    data = page.evaluate("() => ({...document.getElementById('picture').dataset})")
    left, top, zoom = (float(data[key]) for key in ("left", "top", "zoom"))
    page.mouse.move(box["x"] + left + (x + 0.5) * zoom, box["y"] + top + (y + 0.5) * zoom)


def turn(page, kind, degrees=None):
    page.locator(f"input[name=analyzer][value={kind}]").check(force=True)
    if degrees is not None and degrees == int(degrees):
        page.evaluate("""(angle) => {
            const slider = document.getElementById("angle");
            slider.value = angle;
            slider.dispatchEvent(new Event("input"));
        }""", degrees)
    elif degrees is not None:
        page.fill("#angle-number", str(degrees))


def rows(page):
    """The tables under the pointer: for each, names and what the cells hold."""
    return page.evaluate("""() => [...document.querySelectorAll("#vectors table")].map((table) =>
        Object.fromEntries([...table.rows].slice(1).map((row) => [
            row.cells[0].textContent,
            [...row.cells].slice(1).map((cell) => [
                cell.dataset.value ?? null, cell.querySelector("small")?.title ?? null,
                cell.firstChild.textContent,
            ]),
        ])))""")


def number(text):
    return np.float32(text.replace("Infinity", "inf"))


def check_pixels(checks):
    """What is packed in the page are the file's bits."""
    planes = sky(31, 17)
    planes[0, 0, 0, :4] = [np.nan, np.inf, -0.0, 1e-42]
    save(checks.folder / "bits.exr", planes, planes * planes)
    checks.sunstone("view", "bits.exr", "-o", "bits.html")
    text = (checks.folder / "bits.html").read_text()
    for kind, expected in (("values", planes), ("variances", planes * planes)):
        for index, plane in enumerate(expected.reshape(12, 17, 31)):
            packed = text.split(f'id="pixels-0-{kind}-{index}">')[1].split("<")[0]
            found = zlib.decompress(base64.b64decode(packed))
            assert found == plane.astype("<f4").tobytes(), (kind, index)


def check_analyzer(checks):
    size = (96, 72)
    planes = sky(*size)
    planes[0, 1, 3, 5:8] = [np.nan, np.inf, -1.0]
    planes[1:, :, 9, 9] = np.nan
    save(checks.folder / "sky.exr", planes)
    page = checks.open("sky.exr")
    cases = [("none", None), ("right", None), ("left", None)]
    cases += [("linear", angle) for angle in (0, 17, 45, 90, 101.25, 135, 180)]
    worst = 0.0
    for exposure in (0, -1.5):
        page.fill("#exposure-number", str(exposure))
        for kind, angle in cases:
            turn(page, kind, angle)
            light = analyzed(planes, kind, angle or 0) * 2.0**exposure
            error = abs(picture(page, size) - srgb(light).transpose(1, 2, 0)).max()
            assert error <= 1, (kind, angle, exposure, error)
            worst = max(worst, error)
    # Turning goes on from the keyboard, from any map.
    page.select_option("#map", "dop")
    page.focus("#angle")
    page.keyboard.press("ArrowLeft")
    assert page.input_value("#map") == "intensity"
    light = analyzed(planes, "linear", 179)
    page.fill("#exposure-number", "0")
    assert abs(picture(page, size) - srgb(light).transpose(1, 2, 0)).max() <= 1
    assert page.text_content(".legend-name") == "intensity behind a linear analyzer at 179°"
    # One channel alone is grey.
    page.select_option("#channel", "1")
    grey = srgb(light[1])[..., None]
    assert abs(picture(page, size) - grey).max() <= 1
    # What is saved is what is seen.
    with page.expect_download() as download:
        page.click("#save")
    saved = np.asarray(Image.open(download.value.path()).convert("RGB"), dtype=int)
    assert (saved == picture(page, size)).all()
    checks.close(page)
    print(f"  analyzer: at most {worst:.2f} codes from the formula")


def check_maps(checks):
    size = (96, 72)
    for degree in (1.0, 0.04):
        planes = sky(*size, degree=degree)
        planes[2, 0, 30, 30] = np.nan
        save(checks.folder / "maps.exr", planes)
        page = checks.open("maps.exr")
        names = page.eval_on_selector_all("#map option", "list => list.map((item) => item.value)")
        singles = [name for name in names if "stokes" not in name]
        worst = 0
        for options, end in (((), None), (("--full-scale",), 9)):
            if end is not None:
                page.select_option("#map", "dop")
                page.select_option("#end", str(end))
            for name in [*singles, "stokes", "stokes-relative"]:
                for index, expected in enumerate(checks.visualized("maps.exr", name, size, options)):
                    choice = f"{name}-{index + 1}" if "stokes" in name else name
                    page.select_option("#map", choice)
                    error = abs(picture(page, size) - expected).max()
                    assert error <= 1, (choice, degree, options, error)
                    worst = max(worst, error)
        assert len(names) == 16, names
        checks.close(page)
        print(f"  {len(names)} maps of degree {degree}: at most {worst} codes from visualize")


def check_numbers(checks):
    size = (24, 18)
    planes = sky(*size)
    planes[0, 2, 4, 7] = np.nan
    variances = (planes * 0.1) ** 2
    save(checks.folder / "numbers.exr", planes, variances)
    page = checks.open("numbers.exr")
    for x, y in ((0, 0), (23, 17), (12, 5), (7, 4), (3, 11)):
        hover(page, x, y)
        assert page.text_content("#place") == f"{x}, {y}"
        (table,) = rows(page)
        for component in range(4):
            for channel in range(3):
                value, error, _ = table[f"S{component}"][channel]
                expected = planes[component, channel, y, x]
                assert number(value).tobytes() == expected.tobytes() or np.isnan(expected), value
                error = float(error.removeprefix("standard error ").replace("Infinity", "inf"))
                assert np.isclose(error, np.sqrt(variances[component, channel, y, x]), rtol=1e-6,
                                  equal_nan=True)
        stokes = planes[:, 1, y, x].astype(np.float64)
        if stokes[0] > 0:
            linear = np.hypot(stokes[1], stokes[2])
            degree = np.hypot(linear, stokes[3]) / stokes[0]
            assert np.isclose(float(table["DoP"][1][0]), degree, rtol=1e-6, atol=1e-9)
            if linear > 1e-6:
                angle = np.arctan2(stokes[2], stokes[1]) / 2 % np.pi
                assert np.isclose(float(table["AoLP"][1][0]), angle, rtol=1e-6, atol=1e-9)
                turned = np.arctan2(stokes[3], linear) / 2
                assert np.isclose(float(table["Ellip."][1][0]), turned, rtol=1e-6, atol=1e-9)
    hover(page, 7, 4)
    assert rows(page)[0]["S0"][2][2] == "NaN"
    # From the keyboard.
    hover(page, 12, 5)
    page.focus("#picture")
    for key in ("ArrowRight", "ArrowDown", "Shift+ArrowLeft", "ArrowUp", "ArrowUp"):
        page.keyboard.press(key)
    assert page.text_content("#place") == "3, 4", page.text_content("#place")
    checks.close(page)
    page = checks.open("numbers.exr", options=["--no-variance"])
    assert page.locator("small").count() == 0
    checks.close(page)


def check_divider(checks):
    size = (64, 48)
    first, second = sky(*size), sky(*size)[:, ::-1] * np.float32(0.5)
    save(checks.folder / "a.exr", first)
    save(checks.folder / "b.exr", second)
    page = checks.open("a.exr", "b.exr")
    box = page.locator("#picture").bounding_box()
    seen = [srgb(planes[0]).transpose(1, 2, 0) for planes in (first, second)]
    centers = lambda: page.evaluate("""(width) => {
        const { left, zoom } = document.getElementById("picture").dataset;
        return [...Array(width).keys()].map((x) => Number(left) + (x + 0.5) * Number(zoom));
    }""", size[0])
    for share in (0.5, 0.3, 0.62):
        handle = page.locator("#divider").bounding_box()
        page.mouse.move(handle["x"] + handle["width"] / 2, handle["y"] + 40)
        page.mouse.down()
        page.mouse.move(box["x"] + share * box["width"], box["y"] + 100)
        page.mouse.up()
        found = picture(page, size)
        is_first = np.array(centers()) < share * box["width"]
        assert 3 < is_first.sum() < 61
        assert abs(found - seen[0])[:, is_first].max() <= 1
        assert abs(found - seen[1])[:, ~is_first].max() <= 1
    for key, planes in (("Home", 1), ("End", 0)):
        page.focus("#divider")
        page.keyboard.press(key)
        assert abs(picture(page, size) - seen[planes]).max() <= 1
    hover(page, 40, 9)
    for table, planes in zip(rows(page), (first, second), strict=True):
        assert [number(cell[0]) for cell in table["S0"][:3]] == list(planes[0, :, 9, 40])
    checks.close(page)


def check_without_polarization(checks):
    save(checks.folder / "scalar.exr", sky(32, 20)[:1])
    page = checks.open("scalar.exr")
    assert page.locator("#analyzer").count() == 0
    assert "no polarization" in page.text_content("#no-polarization")
    assert page.locator("#map option").count() == 1
    assert abs(picture(page, (32, 20)) - srgb(sky(32, 20)[0]).transpose(1, 2, 0)).max() <= 1
    hover(page, 3, 4)
    assert list(rows(page)[0]) == ["S0"]
    checks.close(page)
    # Beside one with polarization, it is grey where that is shown.
    save(checks.folder / "polarized.exr", sky(32, 20))
    page = checks.open("polarized.exr", "scalar.exr")
    assert "B: scalar.exr holds the intensity S0 alone" in page.text_content("#no-polarization")
    page.select_option("#map", "dop")
    page.focus("#divider")
    page.keyboard.press("Home")
    assert (picture(page, (32, 20)) == [70, 70, 76]).all()
    checks.close(page)


def check_sizes_and_names(checks):
    one = sky(1, 1, channels="M")
    one[:, 0, 0, 0] = [2.0, 1.0, 0.0, -1.0]
    save(checks.folder / "one.exr", one)
    page = checks.open("one.exr", color_scheme="dark")
    turn(page, "right")
    page.fill("#exposure-number", "-1")
    assert abs(picture(page, (1, 1)) - srgb(np.array(0.25))).max() <= 1
    assert page.locator("#channel").count() == 0
    checks.close(page)
    long = sky(3000, 7)
    save(checks.folder / "long.exr", long)
    page = checks.open("long.exr", device_scale_factor=2)
    page.keyboard.press("m")
    page.focus("#picture")
    for key in ("1", "+", "0", "-"):
        page.keyboard.press(key)
    checks.close(page)
    for name in ("<script>alert(1)<", "a\"b", "</script><!--", "{{data}} & ünï"):
        name = name.replace("/", "∕") + ".exr"
        save(checks.folder / name, one)
        page = checks.open(name)
        assert page.text_content("#names") == name
        assert page.title() == name
        checks.close(page)


CENTERS = np.linspace(400, 700, 31)


def many(width, height, centers):
    """Stokes planes of bands: what `sky` has, of a color and a degree that change over the image."""
    planes = sky(width, height, channels="M")
    x = np.linspace(0, 1, width)[None, :]
    shape = lambda nm: 0.6 + 0.4 * np.cos((nm - 400) / 60 + 6 * x)
    weak = lambda nm: 0.3 + 0.7 * (nm - 400) / 300 * x
    is_polarized = np.arange(4)[:, None, None] > 0
    of_band = lambda nm: planes[:, 0] * shape(nm) * np.where(is_polarized, weak(nm), 1)
    return np.stack([of_band(nm) for nm in centers], axis=1).astype(np.float32)


def save_bands(path, planes, centers, variances=None):
    """Writes bands as Fichet et al. lay them out."""
    parts = {}
    for component, bands in enumerate(planes):
        for band, nm in enumerate(centers):
            name = f"S{component}.{nm:.6f}nm".replace(".", ",").replace(",", ".", 1)
            parts[name] = np.ascontiguousarray(bands[band])
            if variances is not None:
                parts[f"variance.{name}"] = np.ascontiguousarray(variances[component, band])
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage,
              "spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1"}
    OpenEXR.File(header, parts).write(str(path))


def seen(values, centers):
    """Linear sRGB of what the CIE 1931 observer sees of bands (bands first) that lie side by side."""
    rows = (Path(__file__).resolve().parents[2] / "src/spectrum/data/cie1931.csv").read_text()
    rows = [line for line in rows.splitlines() if line and line[0].isdigit()]
    table = np.array([[float(cell) for cell in line.split(",")] for line in rows])
    nm, observer = table[:, 0], table[:, 1:]
    half = (centers[1] - centers[0]) / 2
    inside = (nm >= centers[0] - half) & (nm <= centers[-1] + half)
    # Linear between the centers, constant beyond.
    at = np.stack([np.interp(nm, centers, unit) for unit in np.eye(len(centers))])
    weights = (at * inside) @ observer / observer[:, 1].sum()
    # IEC 61966-2-1; its white is rounded, which is why codes are compared and not numbers.
    matrix = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415],
                       [0.0557, -0.2040, 1.0570]])
    return np.einsum("bc,bhw->chw", weights @ matrix.T, values.astype(float))


def check_bands(checks):
    """A picture in color, maps and numbers of every band, and the spectrum under the pointer."""
    size = (48, 36)
    planes = many(*size, CENTERS)
    planes[2, 7, 5, 6] = np.nan
    variances = (planes * 0.1) ** 2
    save_bands(checks.folder / "bands.exr", planes, CENTERS, variances)
    page = checks.open("bands.exr")
    worst = 0
    for kind, angle in (("none", None), ("right", None), ("linear", 30)):
        turn(page, kind, angle)
        light = np.stack([analyzed(planes[:, [band]], kind, angle or 0)[0]
                          for band in range(len(CENTERS))])
        error = abs(picture(page, size) - srgb(seen(light, CENTERS)).transpose(1, 2, 0)).max()
        assert error <= 1.5, (kind, error)
        worst = max(worst, error)
    turn(page, "none")
    expected, = checks.visualized("bands.exr", "intensity", size)
    assert abs(picture(page, size) - expected).max() <= 1
    print(f"  {len(CENTERS)} bands in color: at most {worst:.2f} codes from the observer")
    page.select_option("#map", "dop")
    page.select_option("#end", "9")
    for choice, options in (("", ()), ("20", ("--wavelength", "600"))):
        page.select_option("#channel", choice)
        for name in ("dop", "aolp", "chirality") + (("intensity",) if choice else ()):
            page.select_option("#map", name)
            expected, = checks.visualized("bands.exr", name, size, ("--full-scale", *options))
            assert abs(picture(page, size) - expected).max() <= 1, (choice, name)
    look_at_spectrum(page, planes, variances)
    checks.close(page)
    look_at_other_bands(checks, planes)


def look_at_spectrum(page, planes, variances):
    """The plot and the tables under the pointer are those of the file; a click chooses a band."""
    page.select_option("#map", "intensity")
    page.evaluate("() => { document.getElementById('all-bands').open = true; }")
    for x, y in ((0, 0), (47, 35), (20, 9), (6, 5)):
        hover(page, x, y)
        assert page.text_content("#place") == f"{x}, {y}"
        found = page.evaluate("""() => [...document.querySelectorAll("#band-values tr")].slice(1)
            .map((row) => [...row.cells].map((cell) => cell.dataset.value ?? cell.textContent))""")
        assert [float(row[0]) for row in found] == list(CENTERS)
        for band, row in enumerate(found):
            values = planes[:, band, y, x]
            same = [number(a).tobytes() == b.tobytes() or np.isnan(b) for a, b in zip(row[1:], values)]
            assert all(same), (band, row)
            if values[0] > 0 and np.isfinite(values).all():
                degree = np.linalg.norm(values[1:].astype(float)) / float(values[0])
                assert np.isclose(float(row[5]), degree, rtol=1e-5, atol=1e-7)
        (table,) = rows(page)
        column = [number(table[f"S{i}"][0][0]) for i in range(4)]
        assert np.array_equal(column, planes[:, 20, y, x], equal_nan=True)
        mean = [float(table[f"S{i}"][1][0]) for i in range(4)]
        assert np.allclose(mean, planes[:, :, y, x].mean(axis=1), rtol=1e-5, atol=1e-6,
                           equal_nan=True)
    hover(page, 20, 9)
    panels = page.evaluate("""() => [...document.querySelectorAll(".spectrum .panel")].map((panel) => ({
        ...panel.dataset,
        lines: [...panel.querySelectorAll(".line")].map((line) => line.getAttribute("d")),
    }))""")
    assert [len(panel["lines"]) for panel in panels] == [1, 3, 1]
    values = planes[:, :, 9, 20].astype(float)
    expected = [[values[0]], values[1:], [np.linalg.norm(values[1:], axis=0) / values[0]]]
    for panel, curves in zip(panels, expected):
        top, height, low, high = (float(panel[key]) for key in ("top", "height", "low", "high"))
        for line, curve in zip(panel["lines"], curves):
            points = [part.split(" ") for part in line.replace("M", "L").split("L")[1:]]
            drawn = low + (high - low) * (1 - (np.array([float(y) for _, y in points]) - top) / height)
            assert abs(drawn - curve).max() <= 0.006 / height * (high - low) + 1e-9
            steps = np.diff([float(x) for x, _ in points])
            assert (abs(steps - steps[0]) < 0.03).all()
    page.locator(".spectrum").scroll_into_view_if_needed()
    box = page.locator(".spectrum").bounding_box()
    # The band at 440 nm, between ends at 395 and 705.
    page.mouse.click(box["x"] + box["width"] * (4 + 318 * (440 - 395) / 310) / 326, box["y"] + 40)
    assert page.input_value("#channel") == "4"
    page.focus("#band")
    page.keyboard.press("ArrowRight")
    assert page.input_value("#channel") == "5" and page.text_content("#band-words") == "450 nm"


def look_at_other_bands(checks, planes):
    """Bands that tell no color are grey; three are no red, green and blue; two sets are refused."""
    size = planes.shape[:-3:-1]
    near = np.array([800.0, 850.0, 900.0])
    save_bands(checks.folder / "near.exr", planes[:, :3], near)
    page = checks.open("near.exr")
    grey = srgb(planes[0, :3].astype(float).mean(axis=0))[..., None]
    assert abs(picture(page, size) - grey).max() <= 1
    page.select_option("#channel", "1")
    assert abs(picture(page, size) - srgb(planes[0, 1])[..., None]).max() <= 1
    checks.close(page)
    save_bands(checks.folder / "scalar.exr", planes[:1], CENTERS)
    save_bands(checks.folder / "bands.exr", planes, CENTERS)
    page = checks.open("bands.exr", "scalar.exr")
    page.select_option("#map", "dop")
    assert len(rows(page)) == 2 and page.locator(".spectrum").count() == 2
    assert page.locator(".spectrum").nth(1).locator(".panel").count() == 1
    checks.close(page)
    words = subprocess.run([checks.program, "view", "bands.exr", "near.exr", "-o", "no.html"],
                           cwd=checks.folder, capture_output=True, text=True)
    assert words.returncode == 1 and "--wavelength" in words.stderr, words.stderr
    assert not (checks.folder / "no.html").exists()


def run(names):
    """Runs the checks among these, in an empty folder."""
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        checks = Checks(sys.argv[1], Path(folder), browser)
        for name, check in names.items():
            if name.startswith("check_"):
                print(name.removeprefix("check_").replace("_", " "), flush=True)
                check(checks)
        browser.close()
    print("ok")


if __name__ == "__main__":
    run(dict(globals()))
