#!/usr/bin/env python3
"""Writes materials.glb: a stand of balls, each of another material, and filters before some.

    python3 scenes/materials.py            writes it beside this file
    python3 scenes/materials.py --check    fails if it differs from what would be written

Only the standard library is needed. All pictures are made here, of sines. The check compares them
unpacked, as versions of zlib pack in different ways. A material more is a line in a row of `ROWS`.
"""

import base64
import json
import math
import struct
import sys
import zlib
from dataclasses import dataclass

sys.dont_write_bytecode = True  # nothing but the scene is written beside this file

from generate import (EXTENSION, HERE, SHAPES, Scene, camera_look_at, compose, conductor, diffuse,
                      extended, glass, light, look_at, null, polarizer, retarder, rotate, scale,
                      translate)

TAU = 2 * math.pi
#: Of a ball, and from one to the next, in meters.
RADIUS, PITCH = 0.052, 0.125
#: Height and depth of a step.
RISE, DEPTH = 0.078, 0.125


# -- pictures: functions of u to the right and v downwards, both from 0 to 1, periodic ------------

def waves(u, v, *terms):
    """A sum of sines within [0, 1]; a term is its waves along u and v, and its phase."""
    total = sum(math.sin(TAU * (a * u + b * v) + phase) for a, b, phase in terms)
    return 0.5 + 0.5 * total / len(terms)


def mix(low, high, share):
    return [a + (b - a) * share for a, b in zip(low, high)]


def step(low, high, x):
    """From 0 to 1 between two numbers, smoothly."""
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def grain(u, v):
    """Rings of wood along u."""
    bent = v + 0.03 * math.sin(TAU * u + 1.0) + 0.02 * math.sin(TAU * (2 * u + v))
    return 0.5 + 0.35 * math.sin(TAU * 5 * bent) + 0.15 * math.sin(TAU * 17 * bent + 2.0)


def wood(u, v):
    return mix((0.28, 0.16, 0.10), (0.46, 0.29, 0.19), grain(u, v))


def wood_roughness(u, v):
    return 0.0, 0.30 + 0.18 * grain(u, v), 0.0


def plaster(u, v):
    tone = waves(u, v, (3, 2, 0.4), (5, -4, 1.1), (2, 7, 2.0))
    return mix((0.40, 0.43, 0.47), (0.46, 0.49, 0.52), tone)


def marble(u, v):
    bent = waves(u, v, (2, 1, 0.0), (3, -2, 1.0), (5, 3, 2.5))
    return abs(math.sin(TAU * (2 * u + v + 0.7 * bent)))


def stone(u, v):
    return mix((0.16, 0.30, 0.26), (0.80, 0.84, 0.74), marble(u, v) ** 0.5)


def stone_roughness(u, v):
    return 0.0, 0.15 + 0.5 * marble(u, v), 0.0


def stone_height(u, v):
    return 0.02 * step(0.0, 0.35, marble(u, v))


def dents(u, v):
    """A hammered surface."""
    return -0.010 * (math.sin(TAU * 10 * u) * math.sin(TAU * 6 * v)) ** 2


def hammered(u, v):
    """Bronze in its dents, and patina, which is no metal, where others rub it less."""
    metal = step(0.25, 0.55, waves(u, v, (1, 2, 0.5), (3, 1, 2.0), (2, -3, 4.0)))
    return 0.0, 0.75 - 0.5 * metal, metal


def bronze(u, v):
    return mix((0.10, 0.30, 0.24), (0.80, 0.52, 0.28), hammered(u, v)[2])


def bands(u, v):
    """Rough and polished belts."""
    return 0.0, 0.25 + 0.75 * step(0.35, 0.65, 0.5 + 0.5 * math.sin(TAU * (3 * v + u))), 1.0


def checks(u, v):
    share = step(-0.1, 0.1, math.sin(TAU * 6 * u) * math.sin(TAU * 3 * v))
    return mix((0.75, 0.72, 0.62), (0.60, 0.10, 0.12), share)


def swirl(u, v):
    share = 0.5 + 0.5 * math.sin(TAU * (3 * u + 2 * v) + 2.0 * math.sin(TAU * 2 * v))
    return mix((0.85, 0.45, 0.08), (0.10, 0.22, 0.55), step(0.3, 0.7, share))


def lacquer(u, v):
    """Where the coat is."""
    return (step(0.35, 0.5, waves(u, v, (4, 2, 0.0), (4, -2, 1.0))),) * 3


def lacquer_roughness(u, v):
    return 0.0, 0.05 + 0.4 * waves(u, v, (2, 3, 0.0), (3, -1, 0.0)), 0.0


def velvet(u, v):
    return mix((0.55, 0.10, 0.30), (0.95, 0.60, 0.70), waves(u, v, (6, 3, 0.0), (6, -3, 0.0)))


def velvet_roughness(u, v):
    return 1.0, 1.0, 1.0, 0.35 + 0.5 * waves(u, v, (6, 3, 0.0), (6, -3, 0.0))


def windows(u, v):
    """Where light goes through."""
    return (step(-0.15, 0.15, math.sin(TAU * 5 * u) * math.cos(TAU * 2 * v)),) * 3


def paper(u, v):
    return 1.0, 1.0, 1.0, 0.35 + 0.45 * step(0.4, 0.6, 0.5 + 0.5 * math.sin(TAU * 8 * u))


def paper_color(u, v):
    return mix((1.0, 0.62, 0.28), (1.0, 0.88, 0.66), 0.5 + 0.5 * math.cos(TAU * v))


def gloss(u, v):
    return 1.0, 1.0, 1.0, step(0.3, 0.6, 0.5 + 0.5 * math.sin(TAU * (4 * u + 2 * v)))


def gloss_color(u, v):
    return mix((1.0, 0.75, 0.35), (0.35, 0.80, 1.0), 0.5 + 0.5 * math.sin(TAU * 2 * u))


def embers(u, v):
    heat = waves(u, v, (3, 1, 0.0), (2, -3, 1.2), (5, 2, 3.0)) ** 2
    return min(1.0, 0.04 + 1.5 * heat), min(1.0, 1.2 * heat * heat), 0.5 * heat ** 3


def lattice(u, v):
    alpha = step(-0.05, 0.05, 0.35 - math.sin(TAU * 7 * u) * math.sin(TAU * 4 * v))
    return *mix((0.10, 0.45, 0.50), (0.15, 0.65, 0.60), v), alpha


def clouds(u, v):
    tone = waves(u, v, (2, 1, 0.0), (3, -2, 2.0), (1, 4, 4.0))
    return *mix((0.30, 0.45, 0.85), (0.95, 0.95, 0.98), tone), step(0.25, 0.75, tone)


def frost(u, v):
    return 0.0, 0.2 + 0.8 * step(0.3, 0.7, waves(u, v, (3, 0, 0.0), (0, 4, 0.5))), 0.0


def screen(u, v):
    """A test card: hues, and a ramp of grey below."""
    if v > 0.75:
        return (u, u, u)
    return [0.5 + 0.5 * math.cos(TAU * (u - third / 3)) for third in range(3)]


def slide(u, v):
    """What the projector throws: rays of the sun and a soft rim."""
    x, y = 2 * u - 1, 2 * v - 1
    radius = math.hypot(x, y)
    rays = step(-0.3, 0.3, math.sin(12 * math.atan2(y, x) + 5 * radius))
    inside = 1.0 - step(0.75, 0.98, radius)
    disk = 1.0 - step(0.20, 0.24, radius)
    color = mix((0.16, 0.20, 0.34), (1.0, 0.72, 0.36), max(rays * 0.8, disk))
    return [inside * channel for channel in color]


def normals_of(height):
    """The normal map of a surface whose height over its width is given, four times as wide."""
    def normal(u, v, delta=1.0 / 512):
        along_u = (height(u + delta, v) - height(u - delta, v)) / (2 * delta)
        along_v = (height(u, v + delta) - height(u, v - delta)) / (2 * delta)
        slope_u, slope_v = -along_u, along_v  # green is up, against v
        length = math.sqrt(slope_u * slope_u + slope_v * slope_v + 1.0)
        return [0.5 + 0.5 * part / length for part in (slope_u, slope_v, 1.0)]
    return normal


#: Width, height and what makes a texel; where there is a fourth channel, it is alpha.
PICTURES = {
    "wood": (96, 96, wood),
    "wood roughness": (96, 96, wood_roughness),
    "wood normals": (96, 96, normals_of(lambda u, v: 0.006 * grain(u, v))),
    "plaster": (64, 64, plaster),
    "stone": (128, 64, stone),
    "stone roughness": (128, 64, stone_roughness),
    "stone normals": (128, 64, normals_of(stone_height)),
    "bronze": (128, 64, bronze),
    "hammered": (128, 64, hammered),
    "hammered normals": (128, 64, normals_of(dents)),
    "bands": (64, 32, bands),
    "checks": (128, 64, checks),
    "swirl": (128, 64, swirl),
    "lacquer": (128, 64, lacquer),
    "lacquer roughness": (64, 32, lacquer_roughness),
    "velvet": (64, 32, velvet),
    "velvet roughness": (64, 32, velvet_roughness),
    "windows": (128, 64, windows),
    "paper": (128, 64, paper),
    "paper color": (64, 32, paper_color),
    "gloss": (64, 32, gloss),
    "gloss color": (64, 32, gloss_color),
    "embers": (128, 64, embers),
    "lattice": (128, 64, lattice),
    "clouds": (64, 32, clouds),
    "frost": (64, 32, frost),
    "screen": (64, 32, screen),
    "slide": (128, 128, slide),
}


def png(width, height, texel):
    """A PNG of 8 bits, of that filter of rows by which it packs best."""
    rows = []
    for j in range(height):
        row = bytearray()
        for i in range(width):
            values = texel((i + 0.5) / width, (j + 0.5) / height)
            row += bytes(round(255 * min(max(value, 0.0), 1.0)) for value in values)
        rows.append(bytes(row))
    channels = len(rows[0]) // width
    def filtered(kind):
        data, above = bytearray(), bytes(len(rows[0]))
        for row in rows:
            base = {0: bytes(len(row)), 1: bytes(channels) + row[:-channels], 2: above}[kind]
            data.append(kind)
            data += bytes((a - b) & 255 for a, b in zip(row, base))
            above = row
        return zlib.compress(bytes(data), 9)
    packed = min(map(filtered, range(3)), key=len)
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    head = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed)
            + chunk(b"IEND", b""))


# -- shapes with coordinates of textures: positions, normals, triangles, coordinates, tangents ----

def painted_ball(rings=16, segments=32):
    """A unit sphere about y, whose seam is at -z; 960 triangles."""
    points, coordinates, tangents = [], [], []
    for ring in range(rings + 1):
        for segment in range(segments + 1):
            polar, azimuth = math.pi * ring / rings, TAU * segment / segments - math.pi
            sin = math.sin(polar)
            points.append((sin * math.sin(azimuth), math.cos(polar), sin * math.cos(azimuth)))
            coordinates.append((segment / segments, ring / rings))
            tangents.append((math.cos(azimuth), 0.0, -math.sin(azimuth), 1.0))
    triangles = []
    for ring in range(rings):
        for segment in range(segments):
            a = ring * (segments + 1) + segment
            b, c, d = a + segments + 1, a + segments + 2, a + 1
            # One of the two has no area at a pole.
            triangles += [(a, b, c)] if ring < rings - 1 else []
            triangles += [(a, c, d)] if ring > 0 else []
    return points, points, triangles, coordinates, tangents


def painted_rectangle():
    """[-1, 1]^2, which faces +z, and on which pictures are upright."""
    positions, normals, triangles = SHAPES["rectangle"]()
    coordinates = [(0.5 + 0.5 * x, 0.5 - 0.5 * y) for x, y, _ in positions]
    return positions, normals, triangles, coordinates, [(1.0, 0.0, 0.0, 1.0)] * 4


PAINTED = {"painted ball": painted_ball, "painted rectangle": painted_rectangle}


# -- materials ------------------------------------------------------------------------------------

def picture(name, *, tiles=(1, 1), **more):
    """A texture by the name of its picture, so many times over a shape."""
    transform = {"extensions": {"KHR_texture_transform": {"scale": list(tiles)}}}
    return {"index": name, **more, **(transform if tuple(tiles) != (1, 1) else {})}


def plain(color=(1.0, 1.0, 1.0), metallic=0.0, roughness=1.0, *, base=None, metal=None, alpha=1.0,
          extensions=None, **other):
    """A material of glTF; `base` and `metal` are its color and metallic-roughness textures."""
    body = {"baseColorFactor": [*color, alpha], "metallicFactor": metallic,
            "roughnessFactor": roughness}
    body |= {"baseColorTexture": base} if base else {}
    body |= {"metallicRoughnessTexture": metal} if metal else {}
    named = {"KHR_materials_" + name: value for name, value in (extensions or {}).items()}
    return {"pbrMetallicRoughness": body, **({"extensions": named} if named else {}), **other}


def painted(material, **textures):
    """A material of our extension, with textures of glTF."""
    material["pbrMetallicRoughness"].update(textures)
    return material


def rough_metal(color, **body):
    return extended({"bsdf": "rough_conductor", **body}, color, metallic=1.0,
                    roughness=body["roughness"])


def brushed_metal(color, **body):
    return extended({"bsdf": "rough_conductor", **body}, color, metallic=1.0, roughness=0.4)


def blended(first, second, weight, color):
    """Two other materials by their names, the second where the picture is white."""
    return extended({"bsdf": "blend", "first": first, "second": second, "weight_texture": weight},
                    color, metallic=0.5, roughness=0.6)


def plastic(color, **body):
    return extended({"bsdf": "plastic", "reflectance": list(color), **body}, color, roughness=0.2)


def shining(radiance, stokes=None, **other):
    """A black surface that shines: `light` of generate.py, polarized and with a picture."""
    material = light(radiance)
    material.update(other)
    if stokes:
        material["extensions"][EXTENSION]["stokes"] = stokes
    return material


def sheet(color, **body):
    return extended(body, color, alpha=0.4)


def rotator(degrees):
    """Quartz cut across its axis: it turns what is polarized, blue light more than red."""
    cos = [math.cos(math.radians(2 * angle)) for angle in degrees]
    sin = [math.sin(math.radians(2 * angle)) for angle in degrees]
    matrix = [[1, 0, 0, 0], [0, cos, [-x for x in sin], 0], [0, sin, cos, 0], [0, 0, 0, 1]]
    return sheet((0.9, 0.9, 0.95), bsdf="mueller", matrix=matrix)


LEVEL, UPRIGHT = polarizer(0), polarizer(90)
HALF_WAVE = retarder(45, 180)
CIRCULAR = sheet((0.25, 0.25, 0.25), bsdf="circular_polarizer", handedness="right")
# A film of polyvinyl alcohol, which leaks in the blue, and a thin crystal.
REAL = sheet((0.3, 0.3, 0.3), bsdf="polarizer", axis_deg=90, transmittance=[0.84, 0.82, 0.72],
             blocked=[0.01, 0.02, 0.09])
CRYSTAL = lambda thickness: sheet((0.8, 0.8, 0.9), bsdf="retarder", axis_deg=45,
                                  birefringence=0.009, thickness_um=thickness)


# -- what stands there ----------------------------------------------------------------------------

@dataclass
class Ball:
    """A ball of triangles with coordinates of textures."""
    name: str
    material: dict
    #: A sphere inside, by its material and its share of the radius.
    core: tuple = ()
    #: Before it from back to front: name, material, half of width and height in meters.
    sheets: tuple = ()


@dataclass
class Sphere:
    """An analytic sphere; `medium` is what fills it."""
    name: str
    material: dict
    medium: dict | None = None
    sheets: tuple = ()


@dataclass
class Screen:
    """A display: a picture that shines, polarized along x."""
    name: str
    material: dict
    sheets: tuple = ()


def whole(name, material):
    return name, material, 0.052, 0.052


BLACK_PLASTIC = plastic((0.02, 0.02, 0.02), alpha=0.0)
FILTERED = [
    Sphere("plastic behind a level polarizer", BLACK_PLASTIC, sheets=(whole("level", LEVEL),)),
    Sphere("plastic behind an upright polarizer", BLACK_PLASTIC,
           sheets=(whole("upright", UPRIGHT),)),
    Sphere("aluminum behind a circular polarizer", conductor((0.91, 0.92, 0.92), metal="Al"),
           sheets=(whole("circular polarizer", CIRCULAR),)),
    Screen("display", shining(1.6, stokes=[1, 0, 0], emissiveTexture=picture("screen")),
           sheets=(("thin crystal", CRYSTAL(58), 0.040, 0.013),
                   ("thick crystal", CRYSTAL(112), 0.013, 0.040),
                   ("before the display", UPRIGHT, 0.052, 0.040))),
    Ball("embers", shining(1.3, emissiveTexture=picture("embers")),
         sheets=(whole("level before embers", LEVEL), ("half-wave plate", HALF_WAVE, 0.018, 0.052),
                 whole("upright before embers", UPRIGHT))),
    Ball("white behind quartz", diffuse(0.85),
         sheets=(whole("level before white", LEVEL),
                 ("quartz", rotator([86, 130, 200]), 0.03, 0.03),
                 whole("upright before white", UPRIGHT))),
    Sphere("copper behind a real polarizer", conductor((0.95, 0.64, 0.54), metal="Cu"),
           sheets=(whole("real polarizer", REAL),)),
    Ball("white behind circular light", diffuse([0.80, 0.76, 0.68]),
         sheets=(whole("level before the plate", LEVEL),
                 whole("quarter-wave plate", retarder(45, 90)))),
]

GLASSES = [
    Sphere("glass", glass(1.5)),
    Sphere("coated glass", glass(1.52, film={"eta": 1.9, "thickness_nm": 140})),
    Sphere("rough glass", extended(
        {"bsdf": "rough_dielectric", "ior": 1.5, "roughness": 0.5}, roughness=0.5,
        extensions={"KHR_materials_transmission": {"transmissionFactor": 1.0},
                    "KHR_materials_volume": {"thicknessFactor": 2 * RADIUS}})),
    Sphere("bubble", extended({"bsdf": "thin_dielectric", "ior": 1.33}, roughness=0.0,
                              extensions={"KHR_materials_transmission":
                                          {"transmissionFactor": 1.0}})),
    Sphere("milk in glass", glass(1.5), medium={
        "name": "milk in water", "phase": "mie",
        "milk": {"fat_percent": 3.5, "protein_percent": 3.4, "dilution": 0.001}}),
    Sphere("fog", null(), medium={"name": "fog", "phase": "rayleigh", "sigma_a": 0.0,
                                  "sigma_s": [9.0, 18.0, 36.0], "depolarization": 0.03}),
    Sphere("flint", extended({"bsdf": "dielectric", "ior": "SF10"}, roughness=0.0,
                             extensions={"KHR_materials_ior": {"ior": 1.728},
                                         "KHR_materials_transmission": {"transmissionFactor": 1.0},
                                         "KHR_materials_volume": {"thicknessFactor": 0.1}})),
    Ball("frosted glass", plain(
        metal=picture("frost"), roughness=0.6,
        extensions={"transmission": {"transmissionFactor": 1.0},
                    "volume": {"thicknessFactor": 2 * RADIUS, "attenuationDistance": 0.06,
                               "attenuationColor": [0.25, 0.75, 0.55]}})),
]

METALS = [
    Sphere("aluminum", conductor((0.91, 0.92, 0.92), metal="Al")),
    Sphere("oxide on titanium", conductor((0.5, 0.4, 0.7), metal="Ti",
                                          film={"eta": 2.4, "thickness_nm": 75})),
    Sphere("iridescent metal", plain((0.92, 0.90, 0.86), 1.0, 0.0, extensions={
        "iridescence": {"iridescenceFactor": 1.0, "iridescenceIor": 1.4,
                        "iridescenceThicknessMaximum": 420.0}})),
    Ball("gold, GGX", rough_metal((1.0, 0.77, 0.34), metal="Au", roughness=0.5)),
    Ball("copper, Beckmann", rough_metal((0.95, 0.64, 0.54), metal="Cu", roughness=0.4,
                                         distribution="beckmann")),
    Ball("brushed iron", brushed_metal((0.56, 0.57, 0.58), metal="Fe", alpha_u=0.45, alpha_v=0.1)),
    Ball("banded silver", plain((0.97, 0.96, 0.92), 1.0, 0.7, metal=picture("bands"))),
    Ball("hammered bronze", plain(metallic=1.0, base=picture("bronze"), metal=picture("hammered"),
                                  normalTexture=picture("hammered normals"))),
]

OPAQUE = [
    Ball("checks", painted(diffuse(1.0), baseColorTexture=picture("checks"))),
    Sphere("smooth plastic", plastic((0.62, 0.06, 0.05), alpha=0.0)),
    Ball("rough plastic", painted(plastic((1.0, 1.0, 1.0), roughness=0.35),
                                  baseColorTexture=picture("swirl"))),
    Ball("stone", plain(base=picture("stone"), metal=picture("stone roughness"),
                        normalTexture=picture("stone normals"))),
    Ball("gilded checks", blended("checks", "gold, GGX", picture("windows"), (0.7, 0.6, 0.4))),
    Ball("lacquer", plain((0.35, 0.05, 0.30), 0.0, 0.7, extensions={
        "clearcoat": {"clearcoatFactor": 1.0, "clearcoatTexture": picture("lacquer"),
                      "clearcoatRoughnessFactor": 1.0,
                      "clearcoatRoughnessTexture": picture("lacquer roughness")}})),
    Ball("velvet", plain((0.18, 0.03, 0.08), 0.0, 0.9, extensions={
        "sheen": {"sheenColorFactor": [1.0, 1.0, 1.0], "sheenColorTexture": picture("velvet"),
                  "sheenRoughnessFactor": 1.0,
                  "sheenRoughnessTexture": picture("velvet roughness")}})),
    Ball("colored gloss", plain((0.03, 0.05, 0.10), 0.0, 0.35, extensions={
        "ior": {"ior": 1.9},
        "specular": {"specularTexture": picture("gloss"),
                     "specularColorTexture": picture("gloss color")}})),
]

PERFORATED = [
    Ball("paper lantern", plain((0.9, 0.85, 0.75), 0.0, 0.8, doubleSided=True, extensions={
        "diffuse_transmission": {
            "diffuseTransmissionFactor": 1.0, "diffuseTransmissionTexture": picture("paper"),
            "diffuseTransmissionColorTexture": picture("paper color")}}),
         core=(shining([6.0, 4.6, 3.0]), 0.35)),
    Ball("painted windows", plain((0.15, 0.35, 0.55), 0.0, 0.2, doubleSided=True, extensions={
        "transmission": {"transmissionFactor": 0.95, "transmissionTexture": picture("windows")}}),
         core=(diffuse([0.80, 0.60, 0.10]), 0.6)),
    Ball("frosted wall", plain((0.9, 0.97, 1.0), 0.0, 0.3, doubleSided=True, extensions={
        "transmission": {"transmissionFactor": 1.0}}),
         core=(diffuse([0.70, 0.12, 0.10]), 0.5)),
    Ball("lattice", plain(roughness=0.4, base=picture("lattice"), doubleSided=True,
                          alphaMode="MASK"),
         core=(conductor((1.0, 0.77, 0.34), metal="Au"), 0.6)),
    Ball("clouds", plain(roughness=0.8, base=picture("clouds"), doubleSided=True,
                         alphaMode="BLEND"),
         core=(diffuse([0.75, 0.35, 0.08]), 0.6)),
    Sphere("hot tungsten", extended(
        {"bsdf": "conductor", "metal": "W", "incandescent": True,
         "emission": {"blackbody_k": 2700, "scale": 0.75}}, (0.5, 0.5, 0.5), metallic=1.0,
        roughness=0.0)),
    Sphere("absorber", extended({"bsdf": "absorber"}, (0.0, 0.0, 0.0))),
]

#: From the front to the back; a row stands in the middle of its step, which has room for eight.
ROWS = [FILTERED, GLASSES, METALS, OPAQUE, PERFORATED]

#: A downlight, in candela per 683 lm/W by angle from its axis (IES LM-63, type C).
DOWNLIGHT = """IESNA:LM-63-2002
[TEST] downlight of materials.py
[MANUFAC] none
TILT=NONE
1 -1 1 10 1 1 2 0 0 0
1 1 1
0 4 8 11 14 16 18 19 20 90
0
600 590 540 440 310 190 90 30 0 0
"""


class Stand(Scene):
    """A scene whose materials may have pictures, as a .glb."""

    def __init__(self, name):
        super().__init__(name)
        self.gltf["asset"]["generator"] = "sunstone scenes/materials.py"
        self.texture_of, self.material_of = {}, {}

    def view(self, data, **more):
        """The index of a buffer view of some bytes."""
        self.blob += bytes(-len(self.blob) % 4)
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data), **more}
        self.blob += data
        return self.add("bufferViews", view)

    def texture(self, name):
        if name not in self.texture_of:
            view = self.view(png(*PICTURES[name]))
            image = self.add("images", {"name": name, "bufferView": view, "mimeType": "image/png"})
            self.texture_of[name] = self.add("textures", {"name": name, "source": image})
        return self.texture_of[name]

    def resolved(self, value):
        """A material with indices in place of the names of pictures."""
        if isinstance(value, list):
            return [self.resolved(inner) for inner in value]
        if not isinstance(value, dict):
            return value
        return {key: self.texture(inner) if key == "index" else self.resolved(inner)
                for key, inner in value.items()}

    def material(self, name, body):
        """Once for all that have the same one."""
        key = json.dumps(body)
        if key not in self.material_of:
            self.material_of[key] = super().material(name, self.resolved(body))
        return self.material_of[key]

    def mesh(self, kind, material):
        if kind not in PAINTED or (kind, material) in self.mesh_of:
            return super().mesh(kind, material)
        if kind not in self.accessors_of:
            *plain_parts, coordinates, tangents = PAINTED[kind]()
            positions, normals, indices = self.geometry(*plain_parts)
            self.accessors_of[kind] = indices, {
                "POSITION": positions, "NORMAL": normals,
                "TEXCOORD_0": self.accessor(coordinates, "f", "VEC2", 34962),
                "TANGENT": self.accessor(tangents, "f", "VEC4", 34962)}
        indices, attributes = self.accessors_of[kind]
        primitive = {"attributes": attributes, "indices": indices, "material": material}
        name = f"{kind} {self.gltf['materials'][material]['name']}"
        mesh = self.add("meshes", {"name": name, "primitives": [primitive]})
        self.mesh_of[kind, material] = mesh
        return mesh

    def accessor(self, rows, code, kind, target, **extent):
        self.blob += bytes(-len(self.blob) % 4)
        return super().accessor(rows, code, kind, target, **extent)

    def ball(self, ball, at):
        material = self.material(ball.name, ball.material)
        self.shape(ball.name, "painted ball", material, scale(RADIUS), translate(*at))
        if ball.core:
            core, share = ball.core
            name = f"inside {ball.name}"
            self.sphere(name, self.material(name, core), at, share * RADIUS)

    def round(self, sphere, at):
        material = self.material(sphere.name, sphere.material)
        self.sphere(sphere.name, material, at, RADIUS)
        if sphere.medium:
            body = dict(sphere.medium)
            sides = {"interior": self.medium(body.pop("name"), **body)}
            self.gltf["nodes"][-1]["extensions"][EXTENSION].update(sides)

    def put(self, thing, at):
        """A thing and the sheets before it, which lean back to face the camera."""
        leaning = lambda forward: (rotate("x", -14), translate(at[0], at[1], at[2] + forward))
        if isinstance(thing, Screen):
            material = self.material(thing.name, thing.material)
            self.shape(thing.name, "painted rectangle", material, scale(0.052, 0.040, 1),
                       *leaning(0.02))
        elif isinstance(thing, Sphere):
            self.round(thing, at)
        else:
            self.ball(thing, at)
        for index, (name, body, width, height) in enumerate(thing.sheets):
            self.shape(f"{name}, {thing.name}", "rectangle", self.material(name, body),
                       scale(width, height, 1), *leaning(0.062 + 0.004 * index))

    def extend_lamp(self, **body):
        """Adds to what our extension says of the last lamp."""
        lights = self.gltf["extensions"]["KHR_lights_punctual"]["lights"]
        lights[-1]["extensions"][EXTENSION].update(body)

    def glb(self):
        used = set()
        def visit(value):
            for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
                used.update(inner if key == "extensions" else ())
                if isinstance(inner, (dict, list)):
                    visit(inner)
        visit(self.gltf)
        gltf = {**self.gltf, "extensionsUsed": sorted(used),
                "buffers": [{"byteLength": len(self.blob)}]}
        return packed(json.dumps(gltf, separators=(",", ":")).encode(), self.blob)


def packed(text, blob):
    """A .glb of its two chunks."""
    text, blob = text + b" " * (-len(text) % 4), blob + bytes(-len(blob) % 4)
    chunks = (struct.pack("<I4s", len(text), b"JSON") + text
              + struct.pack("<I4s", len(blob), b"BIN\0") + blob)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def furniture(scene):
    """Steps, the wall behind them, and the floor before them."""
    board = scene.material("wood", plain(
        base=picture("wood", tiles=(3, 0.5)), metal=picture("wood roughness", tiles=(3, 0.5)),
        normalTexture=picture("wood normals", tiles=(3, 0.5))))
    half = 0.58
    for index in range(len(ROWS)):
        y, z = index * RISE, -index * DEPTH
        front = 0.14 if index == 0 else 0.5 * DEPTH
        depth = 0.5 * (front + 0.5 * DEPTH)
        scene.shape(f"step {index}", "painted rectangle", board, scale(half, depth, 1),
                    rotate("x", -90), translate(y=y, z=z + front - depth))
        scene.shape(f"riser {index}", "painted rectangle", board, scale(half, 0.5 * RISE, 1),
                    translate(y=y - 0.5 * RISE, z=z + front))
    wall = scene.material("wall", plain(base=picture("plaster", tiles=(4, 2)), roughness=0.9))
    scene.shape("wall", "painted rectangle", wall, scale(2.4, 1.0, 1), translate(y=0.9, z=-0.72))
    floor = scene.material("floor", plain((0.16, 0.16, 0.18), 0.0, 0.25))
    scene.shape("floor", "rectangle", floor, scale(2.4, 1.8, 1), rotate("x", -90),
                translate(y=-RISE, z=1.0))


def lamps(scene):
    """A panel, a polarized panel, a projector, two downlights and a faint sky."""
    middle = (0.0, 0.15, -0.25)
    scene.shape("panel", "rectangle", scene.material("panel", light([9.0, 8.5, 7.8])),
                scale(0.45, 0.30, 1), look_at((-0.75, 1.25, 0.85), middle))
    # As the window of a room of displays: its light is polarized along its x, which is level.
    polarized = shining([2.6, 3.2, 4.2], stokes=[0.95, 0, 0])
    scene.shape("polarized panel", "rectangle", scene.material("polarized panel", polarized),
                scale(0.12, 0.55, 1), look_at((1.25, 0.60, 0.55), middle))
    card = "data:image/png;base64," + base64.b64encode(png(*PICTURES["slide"])).decode()
    scene.lamp({"name": "projector", "type": "spot", "intensity": 9.0,
                "spot": {"outerConeAngle": 0.125}},
               camera_look_at((0.0, 1.05, 1.20), (0.0, 0.53, -0.72)))
    scene.extend_lamp(picture=card)
    for side in (-1, 1):
        scene.lamp({"name": f"downlight {'left' if side < 0 else 'right'}", "type": "point",
                    "intensity": 0.003, "color": [1.0, 0.86, 0.68]},
                   camera_look_at((0.42 * side, 0.86, -0.60), (0.42 * side, 0.50, -0.72)))
        ies = "data:text/plain;base64," + base64.b64encode(DOWNLIGHT.encode()).decode()
        scene.extend_lamp(ies=ies)
    environment = {"radiance": [0.20, 0.23, 0.28], "gradient": [-0.1, 0.7, 0.3]}
    scene.gltf["extensions"].setdefault(EXTENSION, {})["environment"] = environment


def stand(rows):
    scene = Stand("materials")
    furniture(scene)
    for index, row in enumerate(rows):
        for column, thing in enumerate(row):
            x = (column - 0.5 * (len(row) - 1)) * PITCH
            scene.put(thing, (x, index * RISE + RADIUS + 0.001, -index * DEPTH))
    lamps(scene)
    scene.camera({"yfov": math.radians(25.5), "aspectRatio": 4 / 3},
                 camera_look_at((0.0, 1.03, 1.52), (0.0, 0.225, -0.25)), [512, 384])
    return scene


def meaning(glb):
    """What is in a .glb, with its pictures unpacked."""
    length, = struct.unpack_from("<I", glb, 12)
    gltf, blob = json.loads(glb[20:20 + length]), glb[28 + length:]
    del gltf["buffers"]
    parts = []
    for view in gltf.pop("bufferViews"):
        start = view.pop("byteOffset")
        parts.append((unpacked(blob[start:start + view["byteLength"]]), view["buffer"]))
    for lamp in gltf["extensions"]["KHR_lights_punctual"]["lights"]:
        head, separator, data = lamp["extensions"][EXTENSION].get("picture", "").partition(",")
        if separator:
            lamp["extensions"][EXTENSION]["picture"] = head
            parts.append(unpacked(base64.b64decode(data)))
    return gltf, parts


def unpacked(data):
    """The texels of a PNG of `png`; other bytes as they are."""
    if not data.startswith(b"\x89PNG"):
        return data
    width, height, _, kind = struct.unpack_from(">IIBB", data, 16)
    length, = struct.unpack_from(">I", data, 33)
    channels = {2: 3, 6: 4}[kind]
    rows = zlib.decompress(data[41:41 + length])
    above, texels, size = bytes(width * channels), [], 1 + width * channels
    for j in range(height):
        filter_of_row, row = rows[j * size], bytearray(rows[j * size + 1:(j + 1) * size])
        for i in range(len(row)):
            left = row[i - channels] if i >= channels else 0
            row[i] = (row[i] + (0, left, above[i])[filter_of_row]) & 255
        above = bytes(row)
        texels.append(above)
    return width, height, b"".join(texels)


def main():
    path, glb = HERE / "materials.glb", stand(ROWS).glb()
    if "--check" not in sys.argv:
        path.write_bytes(glb)
    elif not path.exists() or meaning(path.read_bytes()) != meaning(glb):
        sys.exit("out of date, run scenes/materials.py: materials.glb")


if __name__ == "__main__":
    main()
