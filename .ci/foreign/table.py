"""Renders glTF files of others and says in a table what became of each.

    python table.py [--sunstone PROGRAM] [--validator SCRIPT | --known TABLE] [--jobs N] [-o TABLE]
        FOLDER...

Every .gltf and .glb below the folders is rendered at 64 x 64 pixels and 4 samples, by the camera and
the light that it has or that are put in, and is counted as one of
    rendered    there is a picture, in which something can be told apart
    plain       there is a picture of one color: a failure, unless the file shows nothing
    waits       only materials or textures that are not supported yet are missing
    empty       there is nothing in the file that could be seen, and it is refused
    refused     with the first thing that is wrong; all is well if it should be refused
    crashed, hung
--validator is `validate.mjs` beside this script, which asks npm's gltf-validator for the number of
errors; --known takes these from a former table, and fails if anything became else than there says.
The table has a line for every file, and ends with the sums.
"""

import argparse
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SECONDS = 120
# What tells a refusal that later versions will not make, and that there is nothing to see.
WAITS = ["textures are not supported yet", "is a rough metal", "is rough glass",
         "by a partial factor", "by a partial metallicFactor", "`KHR_texture_transform`",
         "`EXT_texture_webp`"]
EMPTY = ["the file has no scene", "has nothing that could be seen"]


def pixels(path):
    """The bytes of an 8-bit PNG without palette, row by row."""
    data, place, packed = path.read_bytes(), 8, b""
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place:place + 8])
        body = data[place + 8:place + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
        packed += body if kind == b"IDAT" else b""
        place += 12 + length
    channels = {0: 1, 2: 3}[color]
    assert depth == 8
    raw, size, above, rows = zlib.decompress(packed), width * channels, bytes(width * channels), []
    for y in range(height):
        start = y * (size + 1)
        row = bytearray(raw[start + 1:start + 1 + size])
        for x in range(size):
            left = row[x - channels] if x >= channels else 0
            corner = above[x - channels] if x >= channels else 0
            up, guess = above[x], left + above[x] - corner
            paeth = min((left, up, corner), key=lambda it: abs(guess - it))
            row[x] = (row[x] + [0, left, up, (left + up) // 2, paeth][raw[start]]) % 256
        above = bytes(row)
        rows.append(above)
    return b"".join(rows)


def troubles(text):
    """The lines of an error that say what is wrong."""
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if not line.startswith(("warning:", "note:", "help:"))]
    first = next((i for i, line in enumerate(lines) if line.startswith("error:")), len(lines))
    lines = lines[first:]
    several = len(lines) > 1 and lines[0].endswith("things are wrong")
    return lines[1:] if several else lines[:1]


def render(program, file, picture):
    """What becomes of a file: the kind, more to say of it, and seconds."""
    command = [program, "render", file, "-o", picture, "--width", "64", "--height", "64", "--spp",
               "4", "--threads", "1", "--quiet"]
    start = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace",
                              timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return "hung", f"more than {SECONDS} s", SECONDS
    seconds = time.monotonic() - start
    if done.returncode == 0:
        values = pixels(picture)
        warned = [line[9:] for line in done.stderr.splitlines() if line.startswith("warning: ")]
        is_plain = max(values) - min(values) < 3
        return ("plain" if is_plain else "rendered"), "; ".join(warned), seconds
    if done.returncode not in (1, 2) or "panicked" in done.stderr:
        return "crashed", done.stderr.strip()[-200:], seconds
    wrong = troubles(done.stderr)
    # Of very many things only the first are told.
    told = [line for line in wrong if not (line.startswith("and ") and line.endswith(" more"))]
    others = [line for line in told if not any(text in line for text in WAITS)]
    if not others:
        return "waits", wrong[0], seconds
    is_empty = any(text in others[0] for text in EMPTY)
    return ("empty" if is_empty else "refused"), others[0], seconds


def verdicts(script, files):
    """The number of errors that gltf-validator finds in every file."""
    if not script:
        return {}
    told = subprocess.run(["node", script, *files], capture_output=True, text=True, check=True)
    return {file: count for count, file in
            (line.split(" ", 1) for line in told.stdout.splitlines())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--sunstone", default="sunstone")
    parser.add_argument("--validator")
    parser.add_argument("--known", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--pictures", type=Path, help="a folder to keep them in")
    parser.add_argument("--seconds", action="store_true", help="with a column of times")
    arguments = parser.parse_args()
    found = [(folder, path) for folder in arguments.folders for path in sorted(folder.rglob("*"))
             if path.suffix.lower() in (".gltf", ".glb") and path.is_file()]
    errors = verdicts(arguments.validator, [str(path) for _, path in found])
    known = {}
    if arguments.known:
        lines = arguments.known.read_text().splitlines()[1:]
        known = {row[0]: row for row in (line.split("\t") for line in lines) if len(row) > 3}
        errors = {str(path): known[str(path.relative_to(root))][1] for root, path in found
                  if str(path.relative_to(root)) in known}
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.pictures or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)

        def one(numbered):
            number, (root, path) = numbered
            picture = folder / f"{number:04}-{path.stem}.png"
            kind, text, seconds = render(arguments.sunstone, path, picture)
            # Neither machine nor number of the run is to be seen in what is kept.
            text = text.replace(str(path.parent), "").removeprefix("error: ").lstrip("/")
            row = [str(path.relative_to(root)), errors.get(str(path), "-"), kind, text[:200]]
            return row + [f"{seconds:.1f}"] * arguments.seconds

        with ThreadPoolExecutor(arguments.jobs) as pool:
            rows = list(pool.map(one, enumerate(found)))
    head = ["file", "errors", "became", "as"] + ["seconds"] * arguments.seconds
    lines = ["\t".join(cell.replace("\t", " ").replace("\n", " ") for cell in row)
             for row in [head, *rows]]
    good = [row for row in rows if row[1] == "0"]
    for of, name in [(rows, "all"), (good, "without errors")][:1 + bool(errors)]:
        sums = Counter(row[2] for row in of)
        lines.append(f"# {name}: {len(of)}; " + ", ".join(f"{n} {k}" for k, n in sorted(sums.items())))
    text = "\n".join(lines) + "\n"
    arguments.output.write_text(text) if arguments.output else sys.stdout.write(text)
    print("\n".join(lines[-2:]), file=sys.stderr)
    changed = [row for row in rows if known and known.get(row[0], row)[2] != row[2]]
    for row in changed:
        print(f"{row[0]}: was {known[row[0]][2]}, is {row[2]}: {row[3]}", file=sys.stderr)
    return bool(changed) or any(row[2] in ("crashed", "hung") for row in rows)


if __name__ == "__main__":
    sys.exit(main())
