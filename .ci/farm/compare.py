"""Compares the images of two folders, as OpenEXR reads them: names, channels and every bit."""

import sys
from pathlib import Path

import numpy as np
import OpenEXR


def channels(path: Path) -> dict[str, np.ndarray]:
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.copy() for name, channel in file.channels().items()}


def main() -> None:
    expected, found = (sorted(Path(it).glob("*.exr")) for it in sys.argv[1:3])
    assert expected and [it.name for it in expected] == [it.name for it in found], found
    for one, other in zip(expected, found, strict=True):
        a, b = channels(one), channels(other)
        assert sorted(a) == sorted(b) and any(name.startswith("variance") for name in a), other
        for name in a:
            assert a[name].dtype == np.float32, (other, name)
            assert a[name].tobytes() == b[name].tobytes(), (other, name)
        assert any(pixels.any() for pixels in a.values()), f"{one} is black"
    print(f"{len(found)} images, {len(a)} channels each: the same bits")


main()
