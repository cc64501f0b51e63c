"""One render with LuxCore's BIDIRCPU: prints what it took as a line of JSON.

    python luxcore_worker.py SCENE.gltf SIZE DEPTH SAMPLES SEED THREADS SAMPLER IMAGE.npy

Time is counted between two looks at the running render, so that neither building the scene nor
starting the threads is in it.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import pyluxcore

import gltf

#: Rings and segments of the meshes that stand in for spheres, which LuxCore has not.
RINGS, SEGMENTS = 64, 128


def ball(center: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, triangles and normals of a sphere."""
    polar = np.pi * np.arange(RINGS + 1)[:, None] / RINGS
    azimuth = 2 * np.pi * np.arange(SEGMENTS + 1)[None, :] / SEGMENTS
    normals = np.stack(
        np.broadcast_arrays(
            np.sin(polar) * np.sin(azimuth), np.cos(polar), np.sin(polar) * np.cos(azimuth)
        ),
        axis=-1,
    ).reshape(-1, 3)
    a = (np.arange(RINGS)[:, None] * (SEGMENTS + 1) + np.arange(SEGMENTS)[None, :]).ravel()
    b, c, d = a + SEGMENTS + 1, a + SEGMENTS + 2, a + 1
    upper, lower = np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)
    triangles = np.concatenate([upper[SEGMENTS:], lower[:-SEGMENTS]])  # none at the poles
    return center + radius * normals, triangles, normals


def material(properties: pyluxcore.Properties, name: str, body: gltf.Material) -> None:
    kind = body.body["bsdf"]
    values: dict[str, object] = {}
    if kind in ("diffuse", "absorber"):
        reflectance = np.broadcast_to(body.body.get("reflectance", 0.0), 3).tolist()
        values = {"type": "matte", "kd": reflectance}
    elif kind == "conductor":
        # At normal incidence; the race's mirror reflects all but nothing of all angles.
        n, k = body.body["eta"], body.body["k"]
        values = {"type": "mirror", "kr": [((n - 1) ** 2 + k * k) / ((n + 1) ** 2 + k * k)] * 3}
    elif kind == "dielectric":
        values = {
            "type": "glass",
            "kr": [1.0] * 3,
            "kt": [1.0] * 3,
            "interiorior": body.body["ior"],
            "exteriorior": 1.0,
        }
    else:
        raise ValueError(f"material {body.name}: no LuxCore counterpart of `{kind}` is written")
    if body.radiance:
        # Without power and efficiency the color is the radiance.
        values |= {"emission": body.radiance, "emission.power": 0.0, "emission.efficency": 0.0}
        values |= {"emission.gain": [1.0] * 3}
    for key, value in values.items():
        properties.Set(pyluxcore.Property(f"scene.materials.{name}.{key}", value))


def build(path: Path) -> pyluxcore.Scene:
    description = gltf.load(path)
    scene = pyluxcore.Scene()
    properties = pyluxcore.Properties()
    camera = description.camera
    for key, value in {
        "type": "perspective",
        "lookat.orig": camera.origin.tolist(),
        "lookat.target": (camera.origin + camera.forward).tolist(),
        "up": camera.up.tolist(),
        "fieldofview": camera.field_of_view,
        "autofocus.enable": False,
    }.items():
        properties.Set(pyluxcore.Property(f"scene.camera.{key}", value))
    for index, shape in enumerate(description.shapes):
        if shape.sphere:
            points, triangles, normals = ball(*shape.sphere)
        else:
            points, triangles, normals = shape.positions, shape.triangles, None
        scene.DefineMesh(
            f"mesh{index}",
            [tuple(map(float, p)) for p in points],
            [tuple(map(int, t)) for t in triangles],
            None if normals is None else [tuple(map(float, n)) for n in normals],
            None,
            None,
            None,
        )
        material(properties, f"material{index}", shape.material)
        name = f"scene.objects.object{index}"
        properties.Set(pyluxcore.Property(f"{name}.shape", f"mesh{index}"))
        properties.Set(pyluxcore.Property(f"{name}.material", f"material{index}"))
    scene.Parse(properties)
    return scene


def main() -> None:
    path, image = Path(sys.argv[1]), Path(sys.argv[8])
    size, depth, samples, seed, threads = map(int, sys.argv[2:7])
    pyluxcore.Init()
    pyluxcore.SetLogHandler(lambda message: None)
    settings = pyluxcore.Properties()
    for key, value in {
        "renderengine.type": "BIDIRCPU",
        "renderengine.seed": seed,
        "native.threads.count": threads,
        "path.maxdepth": depth,
        "light.maxdepth": depth,
        "path.russianroulette.depth": 1000,
        "sampler.type": sys.argv[7],
        "sampler.sobol.adaptive.strength": 0.0,
        "film.width": size,
        "film.height": size,
        "film.filter.type": "NONE",
        "film.imagepipelines.0.0.type": "NOP",
    }.items():
        settings.Set(pyluxcore.Property(key, value))
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, build(path)))
    session.Start()
    looks = []
    # From the first sample of each pixel on, or thereabouts.
    for count in (size * size, size * size * (samples + 1)):
        while True:
            session.UpdateStats()
            taken = session.GetStats().Get("stats.renderengine.total.samplecount").GetFloat()
            if taken >= count:
                break
            time.sleep(0.02)
        looks.append((taken, time.process_time(), time.perf_counter()))
    session.Stop()
    film = np.zeros((size, size, 3), dtype=np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, film)
    # Its rows go up, and what it draws is a row lower than its camera says.
    np.save(image, np.roll(film[::-1], -1, axis=0))
    first, last = looks
    answer = {
        "samples": last[0] - first[0],
        "cpu_seconds": last[1] - first[1],
        "wall_seconds": last[2] - first[2],
        "total": session.GetStats().Get("stats.renderengine.total.samplecount").GetFloat(),
    }
    print(json.dumps(answer), flush=True)
    # LuxCore's destructors may end in a fault when Python shuts down.
    os._exit(0)


if __name__ == "__main__":
    main()
