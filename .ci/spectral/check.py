"""Renders bands of a lamp behind a polarizer, and has OpenImageIO and colour-science read them.

Wavelengths, values and attributes are those that Sunstone reads, and what the lamp and the
polarizer make of light: Malus in every band.

    python check.py PROGRAM       in a folder that takes the files
"""

import base64
import json
import struct
import subprocess
import sys
import warnings
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO

with warnings.catch_warnings():
    # It says which other packages are not there, and needs none of them here.
    warnings.simplefilter("ignore")
    import colour

AXIS_DEG = 30.0
LAMP = {"nm": [400, 700], "value": [1.0, 4.0]}  # linear, so that the mean of a band is its center's
BANDS, CENTERS = "430:670:7", np.array([430, 470, 510, 550, 590, 630, 670], float)
SIZE = (12, 8)
NAMES = ["S0", "S1", "S2", "S3"]


def scene():
    """A square that emits, behind one that polarizes; the camera looks along -z."""
    positions = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    data = b"".join(struct.pack("<3f", *p) for p in positions)
    data += struct.pack("<12f", *[0, 0, 1] * 4) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    extension = "SUNSTONE_polarization"
    bodies = [{"bsdf": "absorber", "emission": LAMP}, {"bsdf": "polarizer", "axis_deg": AXIS_DEG}]
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}
    views = [(0, 48), (48, 48), (96, 12)]
    accessors = [(0, 5126, 4, "VEC3"), (1, 5126, 4, "VEC3"), (2, 5123, 6, "SCALAR")]
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": [extension],
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"camera": 0, "translation": [0, 0, 3]},
                  {"mesh": 0, "scale": [3, 3, 1]},
                  {"mesh": 1, "scale": [3, 3, 1], "translation": [0, 0, 1]}],
        "materials": [{"extensions": {extension: body}} for body in bodies],
        "meshes": [{"primitives": [{**primitive, "material": index}]} for index in (0, 1)],
        "cameras": [{"type": "orthographic",
                     "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9}}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64,"
                     + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteOffset": offset, "byteLength": length}
                        for offset, length in views],
        "accessors": [{"bufferView": view, "componentType": kind, "count": count, "type": shape}
                      for view, kind, count, shape in accessors],
    }
    document["accessors"][0].update(min=[-1, -1, 0], max=[1, 1, 0])
    Path("lamp.gltf").write_text(json.dumps(document))


def sunstone(*arguments):
    subprocess.run([sys.argv[1], *map(str, arguments)], check=True)


def render(name, mode):
    width, height = SIZE
    sunstone("render", "lamp.gltf", "-o", name, "--integrator", "path", "--mode", mode,
             "--spp", 256, "--width", width, "--height", height, "--color", "spectral",
             "--bands", BANDS, "--variance", "--quiet")


def read_by_sunstone(name, components):
    """What the page of an image holds: (components, height, width, bands)."""
    sunstone("view", name, "-o", "page.html")
    text = Path("page.html").read_text()
    width, height = SIZE
    planes = []
    for index in range(components * len(CENTERS)):
        packed = text.split(f'id="pixels-0-values-{index}">')[1].split("<")[0]
        planes.append(np.frombuffer(zlib.decompress(base64.b64decode(packed)), "<f4"))
    shape = (components, len(CENTERS), height, width)
    return np.stack(planes).reshape(shape).transpose(0, 2, 3, 1)


def check_openimageio(name, own):
    """Channels by their names, and the attributes of the layout."""
    image = OpenImageIO.ImageInput.open(name)
    spec = image.spec()
    assert (spec.width, spec.height) == SIZE
    pixels = image.read_image(OpenImageIO.FLOAT)
    names = list(spec.channelnames)
    for component, values in enumerate(own):
        for band, center in enumerate(CENTERS):
            channel = f"S{component}.{center:.6f}nm".replace(".", ",").replace(",", ".", 1)
            found = pixels[:, :, names.index(channel)]
            assert found.tobytes() == values[:, :, band].tobytes(), channel
    assert spec.getattribute("spectralLayoutVersion") == "1.0"
    assert spec.getattribute("emissiveUnits") == "W.m^-2.sr^-1"
    handedness = spec.getattribute("polarisationHandedness")
    assert handedness == ("right" if len(own) == 4 else None), handedness
    image.close()


def check_colour(name, own):
    """The layout as colour-science understands it."""
    found, about = colour.read_spectral_image_Fichet2021(name, additional_data=True)
    assert sorted(found) == NAMES[: len(own)], sorted(found)
    assert about.is_emissive and about.is_polarised == (len(own) == 4), about
    for component, values in zip(NAMES, own):
        wavelengths, seen = found[component]
        order = np.argsort(wavelengths)
        assert (np.asarray(wavelengths)[order] == CENTERS).all(), wavelengths
        assert (np.asarray(seen)[:, :, order].astype("<f4") == values).all(), component


def check_light(own):
    """A lamp behind a polarizer: half of its light, and the same polarization in all bands."""
    s0 = own[0].astype(float)
    lamp = np.interp(CENTERS, LAMP["nm"], LAMP["value"])
    # What is left of the unevenness of wavelengths is well below it after so many iterations.
    assert abs(s0.mean(axis=(0, 1)) / (lamp / 2) - 1).max() < 0.02, s0.mean(axis=(0, 1))
    double = np.radians(2 * AXIS_DEG)
    for values, share in zip(own[1:], [np.cos(double), np.sin(double), 0.0]):
        assert abs(values / s0 - share).max() < 1e-5


scene()
for mode, components in (("polarized", 4), ("scalar", 1)):
    name = f"{mode}.exr"
    render(name, mode)
    own = read_by_sunstone(name, components)
    check_openimageio(name, own)
    check_colour(name, own)
    if mode == "polarized":
        check_light(own)
    print(f"{mode}: {len(CENTERS)} bands as OpenImageIO {OpenImageIO.VERSION_STRING} and "
          f"colour-science {colour.__version__} read them")
