"""Renders lamps behind leaky polarizers, has a camera of polarization record them, and lets
polanalyser find their degree and angle of polarization, within the quantization.

    python check.py PROGRAM       in a folder that takes the files

Needs polanalyser, opencv-python-headless, sympy and matplotlib; .ci/cameras/run installs them.
"""

import base64
import json
import struct
import subprocess
import sys

import cv2
import numpy as np
import polanalyser as pa

# Of every patch: the axis of its polarizer in degrees and the extinction ratio of that.
PATCHES = [[(0, 1e9), (30, 3.0)], [(100, 1.5), (145, 20.0)]]
RADIANCE = [0.9, 0.5, 0.25]
PATCH = 16  # pixels
RIM = 4  # pixels of a patch along its edge, which demosaicing mixes with others
ANGLES = np.radians([0, 45, 90, 135])
EXPOSURE = 1  # stops


def scene(name, radiance):
    """Each patch is a square that emits, behind one that polarizes; the camera looks along -z."""
    positions = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    data = b"".join(struct.pack("<3f", *p) for p in positions)
    data += struct.pack("<12f", *[0, 0, 1] * 4) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    extension = "SUNSTONE_polarization"
    material = {"extensions": {extension: {"bsdf": "absorber"}}, "emissiveFactor": radiance}
    materials = [material]
    primitive = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}
    meshes = [{"primitives": [{**primitive, "material": 0}]}]
    nodes = [{"camera": 0, "translation": [0, 0, 3]}, {"mesh": 0, "scale": [3, 3, 1]}]
    for line, patches in enumerate(PATCHES):
        for column, (axis_deg, ratio) in enumerate(patches):
            body = {"bsdf": "polarizer", "axis_deg": axis_deg, "extinction_ratio": ratio}
            materials.append({"extensions": {extension: body}})
            meshes.append({"primitives": [{**primitive, "material": len(materials) - 1}]})
            place = [column - 0.5, 0.5 - line, 1]
            nodes.append({"mesh": len(meshes) - 1, "translation": place, "scale": [0.5, 0.5, 1]})
    views = [(0, 48), (48, 48), (96, 12)]
    accessors = [(0, 5126, 4, "VEC3"), (1, 5126, 4, "VEC3"), (2, 5123, 6, "SCALAR")]
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": [extension],
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "materials": materials,
        "meshes": meshes,
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
    with open(name, "w") as file:
        json.dump(document, file)


def sunstone(*arguments):
    subprocess.run([sys.argv[1], *arguments], check=True)


def patch(image, line, column):
    """The inner pixels of a patch."""
    top, left = line * PATCH + RIM, column * PATCH + RIM
    edge = PATCH - 2 * RIM
    return image[top:top + edge, left:left + edge]


def check(kind, bits, black_level):
    """What polanalyser makes of one sensor's image; the worst errors over what is allowed."""
    name = f"{kind}-{bits}.png"
    sunstone("visualize", f"{kind}.exr", "-o", name, "--map", "mosaic", "--sensor", kind,
             "--bits", str(bits), "--black-level", str(black_level), "--exposure", str(EXPOSURE))
    raw = cv2.imread(name, cv2.IMREAD_UNCHANGED)
    assert raw.dtype == (np.uint8 if bits == 8 else np.uint16), raw.dtype
    assert raw.shape == (2 * PATCH, 2 * PATCH), raw.shape
    assert black_level <= raw.min() and raw.max() < 1 << bits, (raw.min(), raw.max())
    code = pa.COLOR_PolarMono if kind == "mono" else pa.COLOR_PolarRGB
    images = [image.astype(float) - black_level for image in pa.demosaicing(raw, code)]
    stokes = pa.calcStokes(images, ANGLES)
    dolp, aolp = pa.cvtStokesToDoLP(stokes), pa.cvtStokesToAoLP(stokes)
    # Blue comes first in OpenCV.
    radiances = [RADIANCE[1]] if kind == "mono" else RADIANCE[::-1]
    numbers = (1 << bits) - 1 - black_level
    worst = np.zeros(3)
    for line, patches in enumerate(PATCHES):
        for column, (axis_deg, ratio) in enumerate(patches):
            for channel, radiance in enumerate(radiances):
                def of(image):
                    image = patch(image, line, column)
                    return image if kind == "mono" else image[..., channel]
                s0 = numbers * 2**EXPOSURE * radiance * (1 + 1 / ratio) / 2
                degree = (ratio - 1) / (ratio + 1)
                # Each of four numbers is rounded by the sensor, and once or twice in demosaicing.
                rounding = 1.5 * 2**0.5 * 2 / s0
                turned = np.degrees(of(aolp)) - axis_deg
                errors = [
                    np.abs(of(stokes[..., 0]) / s0 - 1).max() / rounding,
                    np.abs(of(dolp) - degree).max() / rounding,
                    np.abs((turned + 90) % 180 - 90).max() / np.degrees(rounding / 2 / degree),
                ]
                worst = np.maximum(worst, errors)
    print(f"{kind:5} {bits:2} bits, black level {black_level:4}: errors of S0, degree and angle up "
          "to {:.2f}, {:.2f}, {:.2f} of the quantization's".format(*worst))
    assert worst.max() <= 1, worst


def main():
    scene("color.gltf", RADIANCE)
    # A grey is its number at all wavelengths.
    scene("mono.gltf", [RADIANCE[1]] * 3)
    size = ["--width", str(2 * PATCH), "--height", str(2 * PATCH), "--quiet"]
    common = ["--integrator", "path", "--spp", "4", *size]
    sunstone("render", "color.gltf", "-o", "color.exr", *common)
    sunstone("render", "mono.gltf", "-o", "mono.exr", *common, "--color", "mono")
    for kind in ["mono", "color"]:
        for bits, black_level in [(8, 0), (8, 10), (12, 0), (12, 240), (16, 0), (16, 4000)]:
            check(kind, bits, black_level)


main()
