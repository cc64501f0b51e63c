"""Reads the glTF scenes that the races share: as much of it as they use, refusing the rest.

Peers get their scenes from the same file that Sunstone renders, so that no second description can
part from the first. Spheres stay spheres, all else is triangles in world space.
"""

from __future__ import annotations

import base64
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import numpy as np

EXTENSION = "SUNSTONE_polarization"
COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
#: Of red, green and blue with sRGB primaries.
LUMINANCE = (0.2126, 0.7152, 0.0722)
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass
class Material:
    """Our keys (`bsdf`, `reflectance`, `ior`, `eta`, `k`, `metal`, ...), and what it emits."""

    name: str
    body: dict[str, Any]
    radiance: Optional[list[float]]
    double_sided: bool


@dataclass
class Shape:
    """A sphere (center, radius) or triangles (positions, corners), of one material."""

    name: str
    material: Material
    interior: Optional[dict[str, Any]]
    sphere: Optional[tuple[np.ndarray, float]] = None
    positions: Optional[np.ndarray] = None
    triangles: Optional[np.ndarray] = None


@dataclass
class Camera:
    """Where it stands, what it looks at, what is up for it, and its vertical angle in degrees."""

    origin: np.ndarray
    forward: np.ndarray
    up: np.ndarray
    field_of_view: float


@dataclass
class Scene:
    name: str
    camera: Camera
    shapes: list[Shape]


def load(path: Path) -> Scene:
    """Reads a scene of scenes/ or of this folder: flat node lists, matrices, embedded buffers."""
    gltf = json.loads(path.read_text())
    blobs = [base64.b64decode(b["uri"].split(",", 1)[1]) for b in gltf["buffers"]]
    media = gltf.get("extensions", {}).get(EXTENSION, {}).get("media", [])
    implicit = gltf.get("extensions", {}).get("KHR_implicit_shapes", {}).get("shapes", [])
    materials = [material(m) for m in gltf["materials"]]
    shapes: list[Shape] = []
    camera = None
    for node in gltf["nodes"]:
        matrix = np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
        body = node.get("extensions", {}).get(EXTENSION, {})
        if "camera" in node:
            camera = camera_of(gltf["cameras"][node["camera"]], matrix)
        elif "mesh" not in node:
            raise ValueError(f"{path}: node {node['name']}: the races know meshes and cameras only")
        else:
            interior = media[body["interior"]] if body.get("interior") is not None else None
            for primitive in gltf["meshes"][node["mesh"]]["primitives"]:
                shape = Shape(node["name"], materials[primitive["material"]], interior)
                if "shape" in body:
                    radius = implicit[body["shape"]]["sphere"]["radius"]
                    shape.sphere = (matrix[:3, 3], radius * np.linalg.norm(matrix[:3, 0]))
                else:
                    points = accessor(gltf, blobs, primitive["attributes"]["POSITION"])
                    shape.positions = points @ matrix[:3, :3].T + matrix[:3, 3]
                    shape.triangles = accessor(gltf, blobs, primitive["indices"]).reshape(-1, 3)
                shapes.append(shape)
    return Scene(path.stem, camera, shapes)


def material(body: dict[str, Any]) -> Material:
    extensions = body.get("extensions", {})
    radiance = None
    if any(body.get("emissiveFactor", [])):
        strength = extensions.get("KHR_materials_emissive_strength", {})
        radiance = [x * strength.get("emissiveStrength", 1.0) for x in body["emissiveFactor"]]
    ours = extensions[EXTENSION]
    return Material(body["name"], ours, radiance, body.get("doubleSided", False))


def camera_of(body: dict[str, Any], matrix: np.ndarray) -> Camera:
    angle = math.degrees(body["perspective"]["yfov"])
    return Camera(matrix[:3, 3], -matrix[:3, 2], matrix[:3, 1], angle)


def accessor(gltf: dict[str, Any], blobs: list[bytes], index: int) -> np.ndarray:
    a = gltf["accessors"][index]
    view = gltf["bufferViews"][a["bufferView"]]
    width = WIDTHS[a["type"]]
    values = np.frombuffer(
        blobs[view["buffer"]],
        dtype=COMPONENTS[a["componentType"]],
        count=a["count"] * width,
        offset=view.get("byteOffset", 0) + a.get("byteOffset", 0),
    )
    return values.reshape(-1, width) if width > 1 else values
