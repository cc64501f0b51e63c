"""Layers of what the camera sees first, and what scenes of Mitsuba ask for."""

from __future__ import annotations

import json
import pathlib
import pickle
from typing import Any

import numpy as np
import pytest

import sunstone

SMALL: dict[str, Any] = dict(integrator="path", spp=1, width=12, height=9)
CHANNELS = dict(depth=1, normal=3, albedo=3, position=3, uv=2, material=1, object=1)


def test_layers_are_arrays_and_survive_files_and_pickles(
    cornell: sunstone.Scene, tmp_path: pathlib.Path
) -> None:
    image = cornell.render(**SMALL, layers=list(CHANNELS))
    shapes = {name: array.shape for name, array in image.layers.items()}
    assert shapes == {name: (9, 12, count) for name, count in CHANNELS.items()}
    # Normals have a length of one at most, and numbers name what is in the scene.
    assert np.linalg.norm(image.layers["normal"], axis=2).max() < 1.0001
    names = json.loads(image.metadata["materials"])
    numbers = image.layers["material"]
    assert "white" in names and 0 <= numbers.min() and numbers.max() <= len(names)
    depth = image.layers["depth"][..., 0]
    assert np.all(depth > 0) and np.ptp(depth[np.isfinite(depth)]) > 0
    image.save(tmp_path / "a.exr")
    for other in (sunstone.Image.load(tmp_path / "a.exr"), pickle.loads(pickle.dumps(image))):
        assert list(other.layers) == list(CHANNELS)
        for name, array in image.layers.items():
            assert np.array_equal(other.layers[name], array), name
    assert "with depth, normal" in repr(image)
    few = cornell.render(**SMALL, layers="normal,depth")
    assert np.array_equal(few.layers["depth"], image.layers["depth"])
    assert np.array_equal(few.stokes, image.stokes)
    assert cornell.render(**SMALL).layers == {}


def test_layers_that_are_none_are_refused(
    cornell: sunstone.Scene, tmp_path: pathlib.Path
) -> None:
    for layers, words in [
        (["depht"], "layers are depth, normal"),
        (["depth", "depth"], "layers must be different ones"),
        ("", "layers are depth"),
    ]:
        with pytest.raises(sunstone.RenderError, match=words):
            cornell.render(**SMALL, layers=layers)
    stokes = np.zeros((4, 5, 3, 1), np.float32)
    with pytest.raises(sunstone.Error, match=r"must be \(4, 5, its channels\)"):
        sunstone.Image(stokes, layers={"depth": np.zeros((5, 4, 1))})
    for name, shape, words in [("depth", (4, 5, 2), r"\(4, 5, 1\)"), ("fog", (4, 5, 1), "layers")]:
        image = sunstone.Image(stokes, layers={name: np.zeros(shape)})
        with pytest.raises(sunstone.Error, match=words):
            image.save(tmp_path / "b.exr")


SCENE = """<scene version='3.0.0'><default name='spp' value='3'/><integrator type='path'>
<integer name='max_depth' value='5'/></integrator><sensor type='perspective'>
<sampler type='independent'><integer name='sample_count' value='$spp'/>
<integer name='seed' value='9'/></sampler><film type='hdrfilm'>
<integer name='width' value='6'/><integer name='height' value='4'/><rfilter type='box'/></film>
</sensor><shape type='sphere'><point name='center' x='0' y='0' z='4'/></shape>
<emitter type='constant'/></scene>"""


def test_what_a_scene_of_mitsuba_asks_for_counts_if_nothing_else_is_said(
    tmp_path: pathlib.Path,
) -> None:
    (tmp_path / "lab.xml").write_text(SCENE)
    scene = sunstone.load(tmp_path / "lab.xml", define={"spp": 5})
    image = scene.render()
    said = dict(integrator="path", spp=5, seed=9, max_path_length=5)
    again = scene.render(**said)  # type: ignore[arg-type]
    assert image.stokes.shape[:2] == (4, 6) and np.array_equal(image.stokes, again.stokes)
    assert (image.metadata["seed"], image.metadata["integrator"]) == ("9", "path")
    other = scene.render(seed=0, integrator="bdpt", iterations=2)
    assert (other.metadata["seed"], other.metadata["integrator"]) == ("0", "bdpt")
    assert not np.array_equal(other.stokes, image.stokes)
