"""A Mitsuba that stays alive: one variant, told over a pipe what to render next.

    python mitsuba_worker.py VARIANT THREADS

Each line of standard input is a JSON object with the keys scene, sampler, spp, seed, size, depth
and output; the answer is a line with cpu_seconds and wall_seconds. Scenes are loaded when first
named. Kernels are compiled when a scene is first rendered with that number of samples, so warm up
with those that will be timed.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

VARIANT, THREADS = sys.argv[1], int(sys.argv[2])

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402
import numpy as np  # noqa: E402

import gltf  # noqa: E402

mi.set_variant(VARIANT)
dr.set_thread_count(THREADS)
POLARIZED = VARIANT.endswith("polarized")


class DepolarizingHenyeyGreenstein(mi.PhaseFunction):
    """Henyey-Greenstein times a depolarizer.

    Mitsuba's own `hg` multiplies by the identity between frames that have nothing to do with each
    other, which is no phase matrix; ours depolarizes. In scalar variants theirs is used.
    """

    def __init__(self, props: mi.Properties) -> None:
        super().__init__(props)
        self.g = props["g"]
        self.m_flags = +mi.PhaseFunctionFlags.Anisotropic

    def density(self, cosine: mi.Float) -> mi.Float:
        base = 1 + self.g * self.g + 2 * self.g * cosine
        return dr.inv_four_pi * (1 - self.g * self.g) / (base * dr.sqrt(base))

    def sample(self, ctx, mei, sample1, sample2, active=True):
        g = self.g
        root = (1 - g * g) / (1 - g + 2 * g * sample2.x)
        # With respect to mei.wi, which points back to where the path came from.
        cosine = -(1 + g * g - root * root) / (2 * g)
        sine = dr.safe_sqrt(1 - cosine * cosine)
        sin_phi, cos_phi = dr.sincos(dr.two_pi * sample2.y)
        frame = mi.Frame3f(mei.wi)
        wo = frame.to_world(mi.Vector3f(sine * cos_phi, sine * sin_phi, cosine))
        return wo, mi.Spectrum(mi.mueller.depolarizer(1.0)), self.density(cosine)

    def eval_pdf(self, ctx, mei, wo, active=True):
        pdf = self.density(dr.dot(wo, mei.wi))
        return mi.Spectrum(mi.mueller.depolarizer(pdf)), pdf

    def to_string(self) -> str:
        return f"DepolarizingHenyeyGreenstein[g={self.g}]"


mi.register_phase("hg_depolarizing", lambda props: DepolarizingHenyeyGreenstein(props))


def spectrum(value: Any) -> dict[str, Any]:
    """A constant for all wavelengths, or red, green and blue."""
    if isinstance(value, list) and len(set(value)) > 1:
        return {"type": "rgb", "value": value}
    return {"type": "spectrum", "value": float(value[0] if isinstance(value, list) else value)}


def bsdf(material: gltf.Material) -> dict[str, Any]:
    body = material.body
    kind = body["bsdf"]
    if kind in ("diffuse", "absorber"):
        result = {"type": "diffuse", "reflectance": spectrum(body.get("reflectance", 0.0))}
        return {"type": "twosided", "inner": result} if material.double_sided else result
    if kind == "conductor":
        return {"type": "conductor", "eta": spectrum(body["eta"]), "k": spectrum(body["k"])}
    if kind == "dielectric":
        return {
            "type": "dielectric",
            "int_ior": float(body["ior"]),
            "ext_ior": float(body.get("exterior_ior", 1.0)),
        }
    if kind == "polarizer":
        return {"type": "polarizer", "theta": spectrum(float(body.get("axis_deg", 0.0)))}
    raise ValueError(f"material {material.name}: no Mitsuba counterpart of `{kind}` is written")


def medium(body: dict[str, Any]) -> dict[str, Any]:
    extinction = body["sigma_a"] + body["sigma_s"]
    if body["phase"] != "hg":
        raise ValueError(f"medium {body['name']}: no counterpart of phase `{body['phase']}`")
    return {
        "type": "homogeneous",
        "sigma_t": spectrum(extinction),
        "albedo": spectrum(body["sigma_s"] / extinction),
        "phase": {"type": "hg_depolarizing" if POLARIZED else "hg", "g": body["g"]},
    }


def geometry(shape: gltf.Shape, file: Path) -> dict[str, Any]:
    """Spheres and rectangles as such, for Mitsuba is a few per cent faster with them."""
    if shape.sphere:
        center, radius = shape.sphere
        return {"type": "sphere", "center": center.tolist(), "radius": float(radius)}
    if len(shape.positions) == 4:
        a, b, c, d = shape.positions
        matrix = np.identity(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 3] = (b - a) / 2, (d - a) / 2, (a + c) / 2
        normal = np.cross(matrix[:3, 0], matrix[:3, 1])
        matrix[:3, 2] = normal / np.linalg.norm(normal)
        return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix)}
    write_ply(file, shape)
    return {"type": "ply", "filename": str(file), "face_normals": True}


def write_ply(path: Path, shape: gltf.Shape) -> None:
    """A mesh without normals."""
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(shape.positions)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(shape.triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(shape.triangles), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, shape.triangles
    points = shape.positions.astype("<f4").tobytes()
    path.write_bytes(header.encode() + points + faces.tobytes())


def load(path: Path, sampler: str, size: int, depth: int, folder: Path) -> mi.Scene:
    """The Mitsuba scene of a glTF file, with the integrator and film of the race."""
    scene = gltf.load(path)
    camera = scene.camera
    in_media = any(shape.interior for shape in scene.shapes)
    integrator: dict[str, Any] = {
        "type": "volpath" if in_media else "path",
        "max_depth": depth,
        "rr_depth": 1_000_000,
    }
    if POLARIZED:
        integrator = {"type": "stokes", "inner": integrator}
    result: dict[str, Any] = {
        "type": "scene",
        "integrator": integrator,
        "sensor": {
            "type": "perspective",
            "fov": camera.field_of_view,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=camera.origin.tolist(),
                target=(camera.origin + camera.forward).tolist(),
                up=camera.up.tolist(),
            ),
            "sampler": {"type": sampler},
            "film": {
                "type": "hdrfilm",
                "width": size,
                "height": size,
                "rfilter": {"type": "box"},
                "pixel_format": "luminance" if "mono" in VARIANT else "rgb",
                "component_format": "float32",
            },
        },
    }
    for index, shape in enumerate(scene.shapes):
        body = geometry(shape, folder / f"{index}.ply")
        body["bsdf"] = bsdf(shape.material)
        if shape.material.radiance:
            radiance = spectrum(shape.material.radiance)
            body["emitter"] = {"type": "area", "radiance": radiance}
        if shape.interior:
            body["interior"] = medium(shape.interior)
        result[f"shape{index}"] = body
    return mi.load_dict(result)


def stokes(image: np.ndarray) -> np.ndarray:
    """S0 to S3, or S0 alone of a scalar variant, as luminances, so that 1 at all wavelengths is 1.

    The integrator `stokes` puts four planes of three channels each behind those of the image, even
    of one wavelength.
    """
    weights = np.array(gltf.LUMINANCE)
    if POLARIZED:
        return image[..., -12:].reshape(*image.shape[:2], 4, 3) @ weights
    return image if image.shape[2] == 1 else image[..., :3] @ weights[:, None]


def main() -> None:
    # Only answers go to the pipe, whatever else libraries print.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    loaded: dict[tuple[str, str, int, int], mi.Scene] = {}
    with tempfile.TemporaryDirectory() as folder:
        for line in sys.stdin:
            task = json.loads(line)
            key = (task["scene"], task["sampler"], task["size"], task["depth"])
            if key not in loaded:
                loaded[key] = load(Path(key[0]), *key[1:], Path(folder))
            dr.sync_thread()
            cpu, wall = time.process_time(), time.perf_counter()
            image = mi.render(loaded[key], spp=task["spp"], seed=task["seed"])
            dr.eval(image)
            dr.sync_thread()
            taken = {
                "cpu_seconds": time.process_time() - cpu,
                "wall_seconds": time.perf_counter() - wall,
            }
            np.save(task["output"], stokes(np.array(image)))
            print(json.dumps(taken), file=answers, flush=True)


if __name__ == "__main__":
    main()
