#!/usr/bin/env python3
"""Writes the shipped scenes: glTF 2.0 with embedded buffers, from this description of them.

    python3 scenes/generate.py            writes them beside this file
    python3 scenes/generate.py --check    fails if a file differs from what would be written

Only the standard library is needed. `reference/` holds exact counterparts of the Mitsuba 3 scenes
that the images under tests are compared with; the helpers below therefore speak Mitsuba's
language: a rectangle is [-1, 1]^2 and faces +z, a cube is [-1, 1]^3, transforms are applied in the
order in which they are written, and `look_at` turns +z towards the target.
"""

import base64
import json
import math
import struct
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
EXTENSION = "SUNSTONE_polarization"


# -- transforms: 4x4 matrices as lists of rows --------------------------------------------------

def identity():
    return [[float(i == j) for j in range(4)] for i in range(4)]


def compose(*steps):
    """The transform that applies the steps one after the other."""
    result = identity()
    for step in steps:
        result = [[sum(step[i][k] * result[k][j] for k in range(4)) for j in range(4)]
                  for i in range(4)]
    return result


def translate(x=0.0, y=0.0, z=0.0):
    result = identity()
    for row, value in enumerate((x, y, z)):
        result[row][3] = value
    return result


def scale(x, y=None, z=None):
    result = identity()
    for row, value in enumerate((x, x if y is None else y, x if z is None else z)):
        result[row][row] = value
    return result


def rotate(axis, degrees):
    """A turn about one of the axes "x", "y" or "z", counter-clockwise seen from its tip."""
    quarter, rest = divmod(degrees, 90.0)
    cos, sin = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarter) % 4):  # exact at multiples of 90 degrees
        cos, sin = -sin, cos
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    result = identity()
    result[i][i], result[i][j], result[j][i], result[j][j] = cos, -sin, sin, cos
    return result


def normalize(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def from_axes(x, y, z, origin):
    return [[x[i], y[i], z[i], origin[i]] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def look_at(origin, target, up=(0.0, 1.0, 0.0)):
    """Puts the origin of a shape at `origin` and its +z axis towards `target`."""
    forward = normalize([t - o for t, o in zip(target, origin)])
    left = normalize(cross(up, forward))
    return from_axes(left, cross(forward, left), forward, origin)


def camera_look_at(origin, target, up=(0.0, 1.0, 0.0)):
    """Puts a glTF camera, which looks along -z with x to the right, where Mitsuba's would be."""
    forward = normalize([t - o for t, o in zip(target, origin)])
    right = normalize(cross(forward, up))
    return from_axes(right, cross(right, forward), [-x for x in forward], origin)


# -- geometry: positions, normals (or None), triangles ------------------------------------------

def rectangle():
    positions = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    return positions, [(0, 0, 1)] * 4, [(0, 1, 2), (0, 2, 3)]


def flat_mesh(faces):
    """A mesh of convex planar faces, each a list of points counter-clockwise from outside."""
    positions, normals, triangles = [], [], []
    for face in faces:
        first = len(positions)
        edges = [[b - a for a, b in zip(face[0], corner)] for corner in face[1:3]]
        positions += face
        normals += [normalize(cross(*edges))] * len(face)
        triangles += [(first, first + i, first + i + 1) for i in range(1, len(face) - 1)]
    return positions, normals, triangles


def cube():
    faces = []
    for axis in range(3):
        for side in (-1, 1):
            square = [(-1, -1), (1, -1), (1, 1), (-1, 1)][::side]
            face = []
            for u, v in square:
                point = [0, 0, 0]
                point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = side, u, v
                face.append(tuple(point))
            faces.append(face)
    return flat_mesh(faces)


def prism():
    """Equilateral triangles of circumradius 1 in xy, from z = -1 to 1; one edge at the top."""
    angles = [math.radians(90 + 120 * i) for i in range(3)]
    corners = [(math.cos(angle), math.sin(angle)) for angle in angles]
    front = [(x, y, 1.0) for x, y in corners]
    back = [(x, y, -1.0) for x, y in corners]
    sides = [[back[i], back[(i + 1) % 3], front[(i + 1) % 3], front[i]] for i in range(3)]
    return flat_mesh([front, back[::-1]] + sides)


def ball(rings=12, segments=24):
    """A coarse unit sphere with smooth normals: what viewers without analytic spheres show."""
    points = [(0.0, 1.0, 0.0)]
    for ring in range(1, rings):
        polar = math.pi * ring / rings
        for segment in range(segments):
            azimuth = 2 * math.pi * segment / segments
            points.append((math.sin(polar) * math.sin(azimuth), math.cos(polar),
                           math.sin(polar) * math.cos(azimuth)))
    points.append((0.0, -1.0, 0.0))
    row = lambda ring, segment: 1 + (ring - 1) * segments + segment % segments
    triangles = []
    for s in range(segments):
        triangles.append((0, row(1, s), row(1, s + 1)))
        for r in range(1, rings - 1):
            a, b, c, d = row(r, s), row(r + 1, s), row(r + 1, s + 1), row(r, s + 1)
            triangles += [(a, b, c), (a, c, d)]
        triangles.append((row(rings - 1, s), len(points) - 1, row(rings - 1, s + 1)))
    return points, points, triangles


RIPPLES = [  # slope, waves per 2 pi, direction in degrees, phase
    (0.066, 14.0, 20, 0.3), (0.0594, 17.0, 95, 1.9), (0.0528, 12.0, 150, 4.0),
    (0.0462, 21.0, 60, 2.2), (0.0396, 9.0, -15, 5.1),
]


def ripple(x, y):
    height = 0.0
    for slope, frequency, degrees, phase in RIPPLES:
        along = x * math.cos(math.radians(degrees)) + y * math.sin(math.radians(degrees))
        height += slope / frequency * math.sin(frequency * along + phase)
    return height


def pane(cells=80):
    """A pane of glass, [-1, 1]^2 and 0.16 thick: flat towards -z, rippled towards +z.

    No normals: the facets are meant, as shading normals would not conserve energy.
    """
    positions = [(x, y, 0.08 + ripple(x, y))
                 for y in (2 * j / cells - 1 for j in range(cells + 1))
                 for x in (2 * i / cells - 1 for i in range(cells + 1))]
    at = lambda i, j: j * (cells + 1) + i
    triangles = []
    for j in range(cells):
        for i in range(cells):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            triangles += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    steps = range(cells)
    rim = ([at(i, 0) for i in steps] + [at(cells, j) for j in steps]
           + [at(cells - i, cells) for i in steps] + [at(0, cells - j) for j in steps])
    first, center = len(positions), len(positions) + len(rim)
    positions += [(*positions[corner][:2], -0.08) for corner in rim] + [(0.0, 0.0, -0.08)]
    for k, corner in enumerate(rim):
        after = (k + 1) % len(rim)
        triangles += [(first + k, first + after, rim[after]), (first + k, rim[after], corner),
                      (center, first + after, first + k)]
    return positions, None, triangles


def bunny():
    """The Stanford bunny: see meshes/README.md. No normals: the facets are meant."""
    positions, triangles = [], []
    for line in (HERE / "meshes" / "bunny.obj").read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            positions.append(tuple(map(float, words)))
        elif kind == "f":
            triangles.append(tuple(int(word.split("/")[0]) - 1 for word in words))
    return positions, None, triangles


# An open tank in meters: half the outer width and depth, height, walls, and how far it is filled.
TANK = {"x": 0.160, "z": 0.110, "height": 0.210, "wall": 0.008, "level": 0.175}


def box_sides(x, z, low, high):
    """The four sides of an upright box, seen from outside."""
    corners = [(-x, z), (x, z), (x, -z), (-x, -z)]
    return [[(ax, low, az), (bx, low, bz), (bx, high, bz), (ax, high, az)]
            for (ax, az), (bx, bz) in zip(corners, corners[1:] + corners[:1])]


def tank_glass():
    """What the glass of the tank shares with air; the milk bounds the rest of it.

    Outside, bottom, rim, and the inside above the milk, whose lower edge is that of the milk.
    """
    x, z, height, wall, level = TANK.values()
    inner_x, inner_z = x - wall, z - wall
    bottom = [(-x, 0, -z), (x, 0, -z), (x, 0, z), (-x, 0, z)]
    inside = [face[::-1] for face in box_sides(inner_x, inner_z, level, height)]
    outer, inner = ([(a, height, c), (b, height, c), (b, height, -c), (a, height, -c)]
                    for a, b, c in ((-x, x, z), (-inner_x, inner_x, inner_z)))
    rim = [[outer[i], outer[(i + 1) % 4], inner[(i + 1) % 4], inner[i]] for i in range(4)]
    return flat_mesh(box_sides(x, z, 0, height) + [bottom] + rim + inside)


def milk_sides():
    """Sides and bottom of what fills the tank, where it meets the glass."""
    x, z, _, wall, level = TANK.values()
    x, z = x - wall, z - wall
    bottom = [(-x, wall, -z), (x, wall, -z), (x, wall, z), (-x, wall, z)]
    return flat_mesh(box_sides(x, z, wall, level) + [bottom])


def milk_surface():
    """The top of what fills the tank, where it meets the air."""
    x, z, _, wall, level = TANK.values()
    x, z = x - wall, z - wall
    return flat_mesh([[(-x, level, z), (x, level, z), (x, level, -z), (-x, level, -z)]])


SHAPES = {"rectangle": rectangle, "cube": cube, "prism": prism, "ball": ball, "pane": pane,
          "bunny": bunny, "tank glass": tank_glass, "milk sides": milk_sides,
          "milk surface": milk_surface}


# -- materials ----------------------------------------------------------------------------------

def extended(body, color=(1.0, 1.0, 1.0), metallic=0.0, roughness=1.0, alpha=1.0, **other):
    """A material with our extension, and with what other viewers should show instead of it."""
    material = {"pbrMetallicRoughness": {"baseColorFactor": [*color, alpha],
                                         "metallicFactor": metallic,
                                         "roughnessFactor": roughness}}
    if alpha < 1.0:
        material.update(alphaMode="BLEND", doubleSided=True)
    extensions = other.pop("extensions", {})
    material.update(other)
    material["extensions"] = {**extensions, EXTENSION: body}
    return material


def diffuse(reflectance, **other):
    color = reflectance if isinstance(reflectance, list) else [reflectance] * 3
    return extended({"bsdf": "diffuse", "reflectance": reflectance}, color, **other)


def light(radiance):
    """A black surface that emits from its front."""
    rgb = radiance if isinstance(radiance, list) else [radiance] * 3
    strength = max(rgb)
    return extended({"bsdf": "absorber"}, (0.0, 0.0, 0.0),
                    emissiveFactor=[x / strength for x in rgb],
                    extensions={"KHR_materials_emissive_strength": {"emissiveStrength": strength}})


def glass(ior, **body):
    return extended({"bsdf": "dielectric", "ior": ior, **body}, roughness=0.0,
                    extensions={"KHR_materials_ior": {"ior": ior},
                                "KHR_materials_transmission": {"transmissionFactor": 1.0},
                                # Solid: without it plain glTF means thin panes.
                                "KHR_materials_volume": {"thicknessFactor": 0.1}})


def null():
    """A boundary of media and nothing else."""
    return extended({"bsdf": "null"}, alpha=0.1)


def conductor(color, **body):
    return extended({"bsdf": "conductor", **body}, color, metallic=1.0, roughness=0.0)


def polarizer(axis_deg):
    return extended({"bsdf": "polarizer", "axis_deg": axis_deg}, (0.25, 0.25, 0.25), alpha=0.5)


def retarder(axis_deg, retardance_deg):
    body = {"bsdf": "retarder", "axis_deg": axis_deg, "retardance_deg": retardance_deg}
    return extended(body, (0.8, 0.8, 0.9), alpha=0.2)


# Palik's at 550 nm, as Mitsuba ships them.
ALUMINUM_550 = conductor((0.92, 0.92, 0.92), eta=0.9586, k=6.687)
ALUMINUM = conductor((0.91, 0.92, 0.92), metal="Al")
GOLD = conductor((1.0, 0.77, 0.34), metal="Au")
COPPER = conductor((0.95, 0.64, 0.54), metal="Cu")


# -- files --------------------------------------------------------------------------------------

class Scene:
    """Collects nodes; shapes and materials are stored once, whoever uses them."""

    def __init__(self, name):
        self.blob = b""
        self.accessors_of, self.mesh_of = {}, {}
        self.gltf = {
            "asset": {"version": "2.0", "generator": "sunstone scenes/generate.py"},
            "extensionsUsed": [],
            "scene": 0,
            "scenes": [{"name": name, "nodes": []}],
        }

    def add(self, array, element):
        elements = self.gltf.setdefault(array, [])
        elements.append(element)
        return len(elements) - 1

    def node(self, name, transform, **content):
        columns = [round(transform[i][j], 12) + 0.0 for j in range(4) for i in range(4)]
        node = {"name": name, "matrix": columns, **content}
        self.gltf["scenes"][0]["nodes"].append(self.add("nodes", node))

    def material(self, name, body):
        return self.add("materials", {"name": name, **body})

    def shape(self, name, kind, material, *steps, **sides):
        """`interior` and `exterior` are media on the two sides of its surface."""
        self.node(name, compose(*steps), mesh=self.mesh(kind, material), **self.extension(sides))

    def parts(self, name, parts, *steps, **sides):
        """Several kinds of shapes, each of its material, as one mesh."""
        meshes = [self.gltf["meshes"][self.mesh(kind, material)] for kind, material in parts]
        primitives = [mesh["primitives"][0] for mesh in meshes]
        mesh = self.add("meshes", {"name": name, "primitives": primitives})
        self.node(name, compose(*steps), mesh=mesh, **self.extension(sides))

    def extension(self, body):
        return {"extensions": {EXTENSION: body}} if body else {}

    def medium(self, name, **body):
        extension = self.gltf.setdefault("extensions", {}).setdefault(EXTENSION, {"media": []})
        extension["media"].append({"name": name, **body})
        return len(extension["media"]) - 1

    def point_light(self, name, position, intensity):
        """`intensity` is red, green and blue in W/sr."""
        strength = max(intensity)
        self.lamp({"name": name, "type": "point", "intensity": strength,
                   "color": [x / strength for x in intensity]}, translate(*position))

    def lamp(self, light, transform):
        lights = self.gltf.setdefault("extensions", {}).setdefault(
            "KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({**light, "extensions": {EXTENSION: {"units": "radiometric"}}})
        self.node(light["name"], transform,
                  extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})

    def spot(self, name, transform, intensity, half_degrees):
        """A point that shines along -z into an even cone; `intensity` is in W/sr."""
        self.lamp({"name": name, "type": "spot", "intensity": intensity,
                   "spot": {"innerConeAngle": math.radians(half_degrees * 0.9),
                            "outerConeAngle": math.radians(half_degrees)}}, transform)

    def sphere(self, name, material, center, radius):
        """An analytic sphere with a tessellated stand-in for viewers that know none."""
        shapes = {"shapes": [{"type": "sphere", "sphere": {"radius": 1.0}}]}
        self.gltf.setdefault("extensions", {})["KHR_implicit_shapes"] = shapes
        self.node(name, compose(scale(radius), translate(*center)),
                  mesh=self.mesh("ball", material), extensions={EXTENSION: {"shape": 0}})

    def mesh(self, kind, material):
        if (kind, material) not in self.mesh_of:
            if kind not in self.accessors_of:
                self.accessors_of[kind] = self.geometry(*SHAPES[kind]())
            positions, normals, indices = self.accessors_of[kind]
            attributes = {"POSITION": positions}
            if normals is not None:
                attributes["NORMAL"] = normals
            primitive = {"attributes": attributes, "indices": indices, "material": material}
            name = f"{kind} {self.gltf['materials'][material]['name']}"
            self.mesh_of[kind, material] = self.add(
                "meshes", {"name": name, "primitives": [primitive]})
        return self.mesh_of[kind, material]

    def geometry(self, positions, normals, triangles):
        as_float32 = lambda x: struct.unpack("<f", struct.pack("<f", x))[0]
        columns = [[as_float32(x) for x in column] for column in zip(*positions)]
        flat = normals is None
        extent = {"min": [min(c) for c in columns], "max": [max(c) for c in columns]}
        return (self.accessor(positions, "f", "VEC3", 34962, **extent),
                None if flat else self.accessor(normals, "f", "VEC3", 34962),
                self.accessor([(i,) for row in triangles for i in row], "H", "SCALAR", 34963))

    def accessor(self, rows, code, kind, target, **extent):
        data = b"".join(struct.pack(f"<{len(row)}{code}", *row) for row in rows)
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data),
                "target": target}
        self.blob += data + bytes(-len(data) % 4)
        component = {"f": 5126, "H": 5123}[code]
        return self.add("accessors", {"bufferView": self.add("bufferViews", view), "type": kind,
                                      "componentType": component, "count": len(rows), **extent})

    def camera(self, projection, transform, resolution):
        kind = "perspective" if "yfov" in projection else "orthographic"
        camera = {"name": "camera", "type": kind, kind: {**projection, "znear": 0.01},
                  "extensions": {EXTENSION: {"film": {"resolution": resolution}}}}
        self.node("camera", transform, camera=self.add("cameras", camera))

    def text(self):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        gltf = {**self.gltf, "buffers": [{"byteLength": len(self.blob), "uri": uri}]}
        used = {name for name in ("KHR_implicit_shapes", "KHR_lights_punctual",
                                  "KHR_materials_emissive_strength", "KHR_materials_ior",
                                  "KHR_materials_transmission", "KHR_materials_volume", EXTENSION)
                if f'"{name}"' in json.dumps(gltf)}
        gltf["extensionsUsed"] = sorted(used)
        # One line per element: readable, and easy on diffs.
        entries = []
        for key, value in gltf.items():
            if isinstance(value, list) and value and isinstance(value[0], dict):
                lines = ",\n    ".join(json.dumps(element) for element in value)
                entries.append(f'  "{key}": [\n    {lines}\n  ]')
            else:
                entries.append(f'  "{key}": {json.dumps(value)}')
        return "{\n" + ",\n".join(entries) + "\n}\n"


def square_fov(degrees):
    """The projection of a square picture."""
    return {"yfov": math.radians(degrees), "aspectRatio": 1.0}


def box_walls(scene, white, left, right):
    """The inside of a [-1, 1]^3 box without its front."""
    scene.shape("floor", "rectangle", white, rotate("x", -90), translate(y=-1))
    scene.shape("ceiling", "rectangle", white, rotate("x", 90), translate(y=1))
    scene.shape("back", "rectangle", white, translate(z=-1))
    scene.shape("left wall", "rectangle", left, rotate("y", 90), translate(x=-1))
    scene.shape("right wall", "rectangle", right, rotate("y", -90), translate(x=1))


# -- the reference scenes -----------------------------------------------------------------------

def reference_cornell():
    scene = Scene("cornell reference")
    white = scene.material("white", diffuse(0.73))
    red = scene.material("red", diffuse(0.60))
    green = scene.material("green", diffuse(0.30))
    box_walls(scene, white, red, green)
    scene.shape("light", "rectangle", scene.material("light", light(6.0)),
                scale(0.5), rotate("x", 90), translate(y=0.995))
    scene.sphere("glass ball", scene.material("glass", glass(1.5)), (0.45, -0.6, 0.35), 0.38)
    aluminum = scene.material("aluminum", ALUMINUM_550)
    scene.sphere("aluminum ball", aluminum, (-0.42, -0.55, -0.25), 0.44)
    scene.camera(square_fov(39), camera_look_at((0, 0, 3.9), (0, 0, 0)), [64, 64])
    return scene


def reference_mirror():
    scene = Scene("mirror reference")
    white = scene.material("white", diffuse(0.6))
    red = scene.material("red", diffuse(0.7))
    green = scene.material("green", diffuse(0.45))
    blue = scene.material("blue", diffuse(0.25))
    clear = scene.material("glass", glass(1.5))
    aluminum = scene.material("aluminum", ALUMINUM_550)
    scene.sphere("big mirror", aluminum, (0, 0, 0), 2.0)
    scene.shape("floor", "rectangle", white, scale(14), rotate("x", -90), translate(y=-2))
    scene.shape("back wall", "rectangle", white, scale(14), rotate("y", 180), translate(z=12))
    scene.shape("cube 1", "cube", red, scale(0.8), rotate("y", 30), translate(-2.5, -1.2, 7.5))
    scene.shape("cube 2", "cube", green, scale(0.6, 1.2, 0.6), rotate("y", -20),
                translate(2.8, -0.8, 8.5))
    scene.sphere("ball", blue, (-3.5, -1, 4.2), 1.0)
    scene.shape("plane mirror", "rectangle", aluminum, scale(1.2, 1.8, 1), rotate("y", -140),
                translate(4, -0.1, 4.5))
    scene.sphere("glass ball", clear, (1.7, -1.1, 4.6), 0.8)
    scene.shape("light", "rectangle", scene.material("light", light(8.0)),
                scale(2), rotate("x", 90), translate(y=6, z=5))
    scene.camera(square_fov(36), camera_look_at((0, 0.5, 6.5), (0, 0, 0)), [64, 64])
    return scene


def reference_brewster():
    scene = Scene("brewster reference")
    scene.shape("plate", "rectangle", scene.material("glass", glass(1.5)),
                scale(40), rotate("x", -90))
    scene.shape("light", "rectangle", scene.material("light", light(1.0)),
                scale(8), look_at((0, 6.65640235, -9.98460353), (0, 0, 0)))
    scene.camera(square_fov(30), camera_look_at((0, 2.21880078, 3.32820118), (0, 0, 0)), [64, 64])
    return scene


def reference_polarizers():
    """A 3x3 grid of stacks; light travels towards +z and meets the layers of a stack in order.

    Mitsuba's polarizer angle is clockwise, so its sign is turned; its retarder's is not.
    """
    p = lambda theta: ("polarizer", -theta)
    r = lambda theta, delta: ("retarder", theta, delta)
    grid = [  # column, row from the center, turn of the shapes, layers
        (-1, 1, 0, [p(0)]), (0, 1, 0, [p(30)]), (1, 1, 30, [p(0)]),
        (-1, 0, 0, [p(0), p(90)]), (0, 0, 0, [p(0), p(45), p(90)]), (1, 0, 0, [p(0), r(45, 90)]),
        (-1, -1, 0, [p(0), r(45, 90), p(90)]), (0, -1, 0, [p(0), r(22.5, 180)]),
        (1, -1, 0, [p(0), r(30, 60)]),
    ]
    scene = Scene("polarizers reference")
    scene.shape("light", "rectangle", scene.material("light", light(1.0)), scale(3),
                translate(z=-1))
    materials = {}
    for column, row, turn, layers in grid:
        for index, (kind, axis, *more) in enumerate(layers):
            key = (kind, axis, *more)
            if key not in materials:
                body = polarizer(axis) if kind == "polarizer" else retarder(axis, *more)
                materials[key] = scene.material(" ".join(map(str, key)), body)
            scene.shape(f"row {1 - row} column {column + 1} layer {index}", "rectangle",
                        materials[key], scale(0.42), rotate("z", turn),
                        translate(0.95 * column, 0.95 * row, 0.3 * index))
    scene.camera({"xmag": 1.5, "ymag": 1.5, "zfar": 100.0},
                 camera_look_at((0, 0, 10), (0, 0, 0)), [128, 128])
    return scene


def reference_rayleigh():
    scene = Scene("rayleigh reference")
    cloud = scene.medium("cloud", phase="rayleigh", sigma_a=0.0, sigma_s=1.0)
    scene.shape("cloud", "cube", scene.material("boundary", null()), scale(0.5), interior=cloud)
    scene.shape("light", "rectangle", scene.material("light", light(10.0)),
                scale(0.5), rotate("y", 90), translate(x=-3))
    scene.camera(square_fov(22), camera_look_at((0.8, 0.9, 4), (0, 0, 0)), [64, 64])
    return scene


def reference_tank():
    scene = Scene("tank reference")
    milk = scene.medium("diluted milk", phase="hg", g=0.8, sigma_a=0.012, sigma_s=0.588)
    plane = scene.material("plane", diffuse(0.7, doubleSided=True))
    scene.shape("tank", "cube", scene.material("glass", glass(1.5)), scale(1.2, 0.9, 0.8),
                interior=milk)
    scene.shape("inner floor", "rectangle", plane, scale(1.1, 0.7, 1), rotate("x", -90),
                translate(y=-0.8))
    scene.shape("inner back", "rectangle", plane, scale(1.1, 0.75, 1), translate(z=-0.7))
    scene.shape("bunny", "bunny", scene.material("bunny", diffuse(0.5)), scale(0.1),
                translate(-0.1, -0.79, 0))
    scene.shape("light", "rectangle", scene.material("light", light(6.0)),
                scale(2), rotate("x", 90), translate(y=3))
    scene.camera(square_fov(38), camera_look_at((1.6, 1.2, 4.6), (0, -0.05, 0)), [64, 64])
    return scene


# -- the scenes to look at ----------------------------------------------------------------------

def cornell():
    """Glass, metals and a pool of black glass in a Cornell box, which is closed behind the camera.

    The pool reflects near Brewster's angle, so that what is seen in it is polarized. Two crossed
    polarizer sheets hang in the room: black where they overlap, but for the strip where a
    half-wave plate between them turns the polarization by 90 degrees.
    """
    scene = Scene("cornell")
    white = scene.material("white", diffuse([0.73, 0.72, 0.70]))
    red = scene.material("red", diffuse([0.61, 0.07, 0.05]))
    green = scene.material("green", diffuse([0.13, 0.44, 0.09]))
    blue = scene.material("blue", diffuse([0.35, 0.50, 0.70]))
    black = scene.material("black", extended({"bsdf": "absorber"}, (0.0, 0.0, 0.0)))
    clear = scene.material("glass", glass(1.5))
    aluminum = scene.material("aluminum", ALUMINUM)
    gold = scene.material("gold", GOLD)
    copper = scene.material("copper", COPPER)
    deep = (scale(1, 1, 2.1), translate(z=1.1))  # from z = -1 to 3.2
    scene.shape("floor", "rectangle", white, rotate("x", -90), *deep, translate(y=-1))
    scene.shape("ceiling", "rectangle", white, rotate("x", 90), *deep, translate(y=1))
    scene.shape("left wall", "rectangle", red, rotate("y", 90), *deep, translate(x=-1))
    scene.shape("right wall", "rectangle", green, rotate("y", -90), *deep, translate(x=1))
    scene.shape("back", "rectangle", white, translate(z=-1))
    scene.shape("front", "rectangle", blue, rotate("y", 180), translate(z=3.2))
    scene.shape("light", "rectangle", scene.material("light", light([17.0, 13.3, 9.1])),
                scale(0.38), rotate("x", 90), translate(y=0.995))
    scene.shape("mirror block", "cube", aluminum, scale(0.25, 0.6, 0.25), rotate("y", 24),
                translate(-0.5, -0.399, -0.5))
    for name, material, height in (("bottom of the pool", black, -0.996),
                                   ("pool", clear, -0.992)):
        scene.shape(name, "rectangle", material, scale(0.42, 0.36, 1), rotate("x", -90),
                    translate(-0.34, height, 0.3))
    scene.sphere("copper ball", copper, (-0.3, -0.79, 0.2), 0.2)
    scene.sphere("gold ball", gold, (0.2, -0.7, -0.5), 0.3)
    scene.sphere("glass ball", clear, (0.55, -0.66, 0.25), 0.34)
    horizontal = scene.material("polarizer, horizontal", polarizer(0))
    vertical = scene.material("polarizer, vertical", polarizer(90))
    half_wave = scene.material("half-wave plate", retarder(45, 180))
    scene.shape("back sheet", "rectangle", horizontal, scale(0.2), translate(0.2, 0.27, 0.5))
    scene.shape("strip", "rectangle", half_wave, scale(0.035, 0.2, 1),
                translate(0.32, 0.15, 0.53))
    scene.shape("front sheet", "rectangle", vertical, scale(0.2), translate(0.42, 0.07, 0.56))
    scene.camera(square_fov(42), camera_look_at((0, 0.18, 3.15), (0, -0.15, 0)), [512, 512])
    return scene


def caustic_glass():
    """Caustics of a rippled pane of glass, which is above the picture, on diffuse surfaces.

    A lamp of 5 cm shines through the pane only, at the end of a black shaft. Sensor paths find it
    by chance alone; light paths come to every point that is seen, as no glass is in the picture.
    """
    scene = Scene("caustic glass")
    floor = scene.material("floor", diffuse([0.80, 0.71, 0.58]))
    wall = scene.material("wall", diffuse([0.50, 0.65, 0.80]))
    rose = scene.material("rose", diffuse([0.80, 0.52, 0.50]))
    sage = scene.material("sage", diffuse([0.52, 0.72, 0.52]))
    black = scene.material("black", extended({"bsdf": "absorber"}, (0.0, 0.0, 0.0),
                                             doubleSided=True))
    clear = scene.material("glass", glass(1.5))
    scene.shape("floor", "rectangle", floor, scale(3.5), rotate("x", -90))
    scene.shape("back wall", "rectangle", wall, scale(3.5, 2, 1), translate(y=2, z=-1.6))
    lamp = look_at((-1.2, 4.0, 1.5), (0.0, 0.55, -0.6))
    length, half = 1.2, 0.85
    scene.shape("light", "rectangle", scene.material("light", light([11000.0, 9900.0, 7900.0])),
                scale(0.025), lamp)
    for side in range(4):
        scene.shape(f"shaft, side {side}", "rectangle", black, scale(half, length / 2 + 0.025, 1),
                    rotate("x", 90), translate(y=half - 0.001, z=length / 2 + 0.025),
                    rotate("z", 90 * side), lamp)
    scene.shape("pane", "pane", clear, scale(half), translate(z=length), lamp)
    scene.sphere("rose ball", rose, (0.65, 0.33, -0.2), 0.33)
    scene.shape("sage block", "cube", sage, scale(0.22, 0.5, 0.22), rotate("y", 28),
                translate(-0.7, 0.5, -0.7))
    scene.camera(square_fov(30), camera_look_at((0, 1.2, 5.2), (0, 0.75, -0.4)), [512, 512])
    return scene


def dispersion():
    """A sheet of white light that rakes a table, and what a prism of dense flint makes of it.

    The lamp is a point, 6 m before the prism, behind a slit. Its sheet meets the prism at the least
    deviation, 60 degrees, and the table before and behind it. A panel above shows the rest.
    """
    scene = Scene("prism")
    white = scene.material("table", diffuse(0.75))
    black = scene.material("slit", extended({"bsdf": "absorber"}, (0.0, 0.0, 0.0),
                                            doubleSided=True))
    flint = scene.material("flint", glass(1.728))
    scene.gltf["materials"][flint]["extensions"][EXTENSION]["ior"] = "SF10"
    scene.shape("table", "rectangle", white, scale(4, 3, 1), rotate("x", -90), translate(x=0.6))
    scene.shape("prism", "prism", flint, scale(0.5, 0.5, 0.2), rotate("x", -90),
                translate(y=0.201))
    # Within the prism light goes along x; before it 29.8 degrees away from the base.
    entry = (-0.21, 0.0, -0.1)
    turn = math.radians(29.8)
    at = lambda distance, height: (entry[0] - distance * math.cos(turn), height,
                                   entry[2] + distance * math.sin(turn))
    lamp = at(6.0, 0.36)
    scene.spot("lamp", camera_look_at(lamp, entry), 2000.0, 1.8)
    for side in (-1, 1):
        scene.shape(f"slit, side {side}", "rectangle", black, scale(0.05, 0.1, 1),
                    translate(x=side * 0.0535), look_at(at(5.0, 0.30), at(4.0, 0.30)))
    scene.shape("panel", "rectangle", scene.material("panel", light(0.8)),
                scale(0.9, 0.6, 1), look_at((-0.4, 3.4, -3.4), (0, 0, 0)))
    scene.camera({"yfov": math.radians(34), "aspectRatio": 1.5},
                 camera_look_at((0.25, 3.3, 2.75), (0.25, 0.0, 0.34)), [540, 360])
    return scene


def mirror():
    """After figure 3 of the paper: a room in a large sphere of aluminum.

    The camera looks at the sphere alone. In it are diffuse surfaces, a plane mirror and a glass
    ball, lit by a point that does not polarize.
    """
    scene = Scene("mirror")
    surface = lambda name, *rgb: scene.material(name, diffuse(list(rgb)))
    white = surface("white", 0.75, 0.74, 0.72)
    aluminum = scene.material("aluminum", ALUMINUM)
    floor = surface("sand", 0.62, 0.54, 0.42)
    scene.sphere("big mirror", aluminum, (0, 0, 0), 2.0)
    scene.shape("floor", "rectangle", floor, scale(7, 8.5, 1), rotate("x", -90),
                translate(y=-2, z=3.5))
    scene.shape("ceiling", "rectangle", white, scale(7, 8.5, 1), rotate("x", 90),
                translate(y=7, z=3.5))
    scene.shape("left wall", "rectangle", surface("terracotta", 0.66, 0.22, 0.12),
                scale(8.5, 4.5, 1), rotate("y", 90), translate(-7, 2.5, 3.5))
    scene.shape("right wall", "rectangle", surface("teal", 0.08, 0.42, 0.45),
                scale(8.5, 4.5, 1), rotate("y", -90), translate(7, 2.5, 3.5))
    scene.shape("wall behind the camera", "rectangle", surface("ochre", 0.68, 0.50, 0.14),
                scale(7, 4.5, 1), rotate("y", 180), translate(y=2.5, z=12))
    scene.shape("wall behind the mirror", "rectangle", white, scale(7, 4.5, 1),
                translate(y=2.5, z=-5))
    scene.shape("red block", "cube", surface("red", 0.68, 0.08, 0.07), scale(0.8),
                rotate("y", 30), translate(-2.0, -1.2, 6.4))
    scene.shape("green block", "cube", surface("green", 0.14, 0.48, 0.12), scale(0.6, 1.2, 0.6),
                rotate("y", -20), translate(0.5, -0.8, 7.6))
    scene.sphere("blue ball", surface("blue", 0.10, 0.20, 0.62), (-3.5, -1, 4.2), 1.0)
    scene.shape("plane mirror", "rectangle", aluminum, scale(1.2, 1.8, 1), rotate("y", -140),
                translate(4, -0.1, 4.5))
    scene.sphere("glass ball", scene.material("glass", glass(1.5)), (3.9, -0.9, 1.0), 1.1)
    scene.point_light("light", (-1.0, 3.8, 5.8), [46.0, 43.0, 37.0])
    scene.camera(square_fov(36), camera_look_at((0, 0.5, 6.5), (0, 0, 0)), [512, 512])
    return scene


def tank():
    """After figure 4 of the paper: a glass tank of milk in water with a bunny and two plates.

    Lengths are real ones. Whole milk is diluted to 1 : 4000, which makes the depth of the tank
    2.6 mean free paths at 550 nm. Glass, milk and air meet pairwise: the faces of the glass face
    the air, and those of the milk the glass or the air, each with the index that lies before it.
    """
    scene = Scene("tank")
    milk = scene.medium("milk in water", phase="mie", milk={
        "fat_percent": 3.5, "protein_percent": 3.4, "dilution": 0.00025})
    clear = scene.material("glass", glass(1.5))
    wet_glass = scene.material("milk against glass", glass(1.33, exterior_ior=1.5))
    surface = scene.material("milk against air", glass(1.33))
    above_table = translate(y=0.002)
    scene.shape("tank", "tank glass", clear, above_table, interior=None, exterior=None)
    scene.parts("milk", [("milk sides", wet_glass), ("milk surface", surface)], above_table,
                interior=milk, exterior=None)
    plate = lambda name, *rgb: scene.material(name, diffuse(list(rgb), doubleSided=True))
    scene.shape("lower plate", "rectangle", plate("sand", 0.70, 0.58, 0.40),
                scale(0.135, 0.088, 1), rotate("x", -90), translate(y=0.016))
    scene.shape("back plate", "rectangle", plate("blue", 0.20, 0.36, 0.62),
                scale(0.130, 0.068, 1), rotate("x", -8), translate(y=0.090, z=-0.080))
    scene.shape("bunny", "bunny", scene.material("bunny", diffuse([0.72, 0.38, 0.30])),
                scale(0.0108), rotate("y", 12), translate(-0.015, 0.0165, 0.005))
    scene.shape("table", "rectangle", scene.material("table", diffuse([0.44, 0.42, 0.40])),
                scale(1.5), rotate("x", -90))
    scene.shape("wall", "rectangle", scene.material("wall", diffuse([0.50, 0.52, 0.55])),
                scale(1.5, 1, 1), translate(y=1, z=-0.7))
    scene.point_light("light", (-0.32, 0.62, 0.30), [2.6, 2.5, 2.3])
    scene.camera(square_fov(32), camera_look_at((0.25, 0.34, 0.66), (0, 0.085, 0)), [512, 512])
    return scene


SCENES = {
    "reference/cornell.gltf": reference_cornell,
    "reference/mirror.gltf": reference_mirror,
    "reference/brewster.gltf": reference_brewster,
    "reference/polarizers.gltf": reference_polarizers,
    "reference/rayleigh.gltf": reference_rayleigh,
    "reference/tank.gltf": reference_tank,
    "cornell.gltf": cornell,
    "caustic_glass.gltf": caustic_glass,
    "mirror.gltf": mirror,
    "prism.gltf": dispersion,
    "tank.gltf": tank,
}


def main():
    stale = []
    for name, build in SCENES.items():
        path, text = HERE / name, build().text()
        if "--check" not in sys.argv:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        elif not path.exists() or path.read_text() != text:
            stale.append(name)
    if stale:
        sys.exit(f"out of date, run scenes/generate.py: {', '.join(stale)}")


if __name__ == "__main__":
    main()
