#!/usr/bin/env python3
"""Builds the scene of docs/blender.md in Blender and exports it: blender.gltf beside this file.

    pip install bpy==5.0.1          # needs Python 3.11
    python3.11 scenes/blender.py    # or: blender --background --python scenes/blender.py

What glTF has no words for stands in custom properties whose names begin with `sunstone_`. They are
set here as a script does; in the user interface they are added under "Custom Properties" of the
material, object, light, camera or scene.
"""

import base64
import json
import math
import tempfile
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
#: Of the emitting panel: watts, as of an area light of Blender, which no exporter writes.
PANEL_WATTS = 40.0
PANEL_SIDE = 0.8


def material(name, color=(0.8, 0.8, 0.8), metallic=0.0, roughness=1.0, emission=0.0, **properties):
    """A material of the Principled shader, with custom properties."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1.0)
    shader.inputs["Metallic"].default_value = metallic
    shader.inputs["Roughness"].default_value = roughness
    if emission > 0.0:
        shader.inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
        shader.inputs["Emission Color"].default_value = (1.0, 1.0, 1.0, 1.0)
        shader.inputs["Emission Strength"].default_value = emission
    for key, value in properties.items():
        made["sunstone_" + key] = value
    return made


def placed(name, data, location, rotation_deg=(0.0, 0.0, 0.0), **properties):
    """An object in the scene, with custom properties."""
    made = bpy.data.objects.new(name, data)
    made.location = location
    made.rotation_euler = [math.radians(angle) for angle in rotation_deg]
    for key, value in properties.items():
        made["sunstone_" + key] = value
    bpy.context.scene.collection.objects.link(made)
    return made


def rectangle(name, width, height, of):
    """A rectangle that faces +z."""
    x, y = 0.5 * width, 0.5 * height
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(of)
    return mesh


def ball(name, radius, of):
    """A ball to look at in Blender; Sunstone takes the sphere that `sphere_radius` says."""
    mesh = bpy.data.meshes.new(name)
    rows, columns = 6, 12
    corners = [(0.0, 0.0, radius)]
    for row in range(1, rows):
        polar = math.pi * row / rows
        for column in range(columns):
            around = 2.0 * math.pi * column / columns
            corners.append((radius * math.sin(polar) * math.cos(around),
                            radius * math.sin(polar) * math.sin(around),
                            radius * math.cos(polar)))
    corners.append((0.0, 0.0, -radius))
    at = lambda row, column: 1 + (row - 1) * columns + column % columns
    faces = []
    for column in range(columns):
        faces.append((0, at(1, column), at(1, column + 1)))
        for row in range(1, rows - 1):
            faces.append((at(row, column), at(row + 1, column),
                          at(row + 1, column + 1), at(row, column + 1)))
        faces.append((at(rows - 1, column), len(corners) - 1, at(rows - 1, column + 1)))
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(of)
    return mesh


def build():
    """The scene: meters, z up."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    # Two sheets that are crossed, and between them a half-wave plate that lets light through again.
    upright = material("polarizer, upright", bsdf="polarizer", axis_deg=90.0)
    level = material("polarizer, level", bsdf="polarizer", axis_deg=0.0)
    plate = material("half-wave plate", bsdf="retarder", axis_deg=45.0, retardance_deg=180.0)
    for name, of, y, side in (("first sheet", upright, 0.3, 0.8), ("plate", plate, 0.2, 0.4),
                              ("second sheet", level, 0.1, 0.8)):
        placed(name, rectangle(name, side, side, of), (-0.7, y, 0.55), (90.0, 0.0, 0.0))
    # Analytic spheres: facets would falsify what they do to polarization.
    glass = material("glass", bsdf="dielectric", ior=1.5)
    gold = material("gold", bsdf="conductor", metal="Au")
    placed("glass ball", ball("glass ball", 0.25, glass), (0.1, -0.2, 0.25), sphere_radius=0.25)
    placed("gold ball", ball("gold ball", 0.25, gold), (0.75, 0.2, 0.25), sphere_radius=0.25)
    # What says nothing is as any viewer has it: brushed metal, a painted table, a wall.
    steel = material("steel", (0.6, 0.6, 0.65), metallic=1.0, roughness=0.4)
    card = rectangle("steel card", 0.6, 0.4, steel)
    placed("steel card", card, (0.2, 0.75, 0.3), (75.0, 0.0, -20.0))
    table = material("table", (0.25, 0.18, 0.12), roughness=0.3)
    placed("table", rectangle("table", 4.0, 4.0, table), (0.0, 0.0, 0.0))
    wall = material("wall", (0.6, 0.6, 0.6))
    placed("wall", rectangle("wall", 4.0, 3.0, wall), (0.0, 1.2, 1.5), (90.0, 0.0, 0.0))
    lights(scene)
    eye = bpy.data.cameras.new("camera")
    eye.lens, eye.sensor_width, eye.clip_end = 50.0, 36.0, 100.0
    eye["sunstone_film"] = {"resolution": [480, 320], "filter": "gaussian"}
    scene.render.resolution_x, scene.render.resolution_y = 480, 320
    scene.camera = placed("camera", eye, (0.0, -4.0, 1.3), (77.0, 0.0, 0.0))
    return scene


def lights(scene):
    """A lamp in watts, a panel that emits, and a faint sky."""
    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.energy = 30.0
    placed("lamp", lamp, (1.2, -1.5, 2.0))
    # An area light of so many watts has this radiance; Blender's strength of emission is one.
    radiance = PANEL_WATTS / (math.pi * PANEL_SIDE * PANEL_SIDE)
    panel = material("panel", emission=radiance)
    panel.use_backface_culling = True
    square = rectangle("panel", PANEL_SIDE, PANEL_SIDE, panel)
    placed("panel", square, (-1.0, -0.8, 2.2), (200.0, -25.0, 0.0))
    scene["sunstone_environment"] = {"radiance": [0.05, 0.06, 0.08]}


def export(path):
    """Writes one .gltf file with its buffer in it."""
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "scene.gltf"
        bpy.ops.export_scene.gltf(
            filepath=str(written),
            export_format="GLTF_SEPARATE",
            export_extras=True,  # custom properties
            export_lights=True,  # lamps
            export_cameras=True,
            export_texcoords=False,
            export_import_convert_lighting_mode="SPEC",  # candela and lux
        )
        file = json.loads(written.read_text())
        for buffer in file["buffers"]:
            data = base64.b64encode((Path(folder) / buffer["uri"]).read_bytes()).decode()
            buffer["uri"] = "data:application/octet-stream;base64," + data
    path.write_text(json.dumps(file, indent=1) + "\n")


if __name__ == "__main__":
    build()
    export(HERE / "blender.gltf")
