"""Sunstone: a bidirectional renderer that follows polarized light.

>>> import sunstone
>>> scene = sunstone.load("scenes/cornell.gltf")
>>> image = scene.render(integrator="path", spp=4, width=32, height=32)
>>> image.stokes.shape                        # height, width, channels, Stokes components
(32, 32, 3, 4)
>>> image.save("cornell.exr")

`load` reads a glTF scene, `World` makes one in code, `Scene.render` renders it to an `Image`, and
`batch` renders all that a job file asks for. Scenes are edited by name:

>>> scene["materials/glass/ior"] = 1.33       # KIND/NAME/KEY, or scene["glass"].ior

Lengths are in meters, angles in radians unless a name ends in `_deg`, wavelengths in nanometers,
radiance in W/(m^2 sr). Stokes vectors are those of Mitsuba 3: the frame of a pixel has x to the
right in the image, y up and k towards the sensor; S1 > 0 is polarized along x, S2 > 0 along x + y,
and S3 > 0 is right circular, clockwise as the sensor sees it.
"""

from __future__ import annotations

# The native part needs it, and the check of the processor asks it.
import numpy as _numpy  # noqa: F401

from . import _processor

_processor.check()

from ._batch import Batch, Result, batch  # noqa: E402
from ._edits import Object  # noqa: E402
from ._errors import (  # noqa: E402
    Error,
    RenderError,
    RenderWarning,
    SceneError,
    SceneWarning,
)
from ._image import Band, Image  # noqa: E402
from ._scene import Scene, load  # noqa: E402
from ._sunstone import Geometry, __version__  # noqa: E402
from ._texture import Texture  # noqa: E402
from ._world import World  # noqa: E402

__all__ = [
    "Band",
    "Batch",
    "Error",
    "Geometry",
    "Image",
    "Object",
    "RenderError",
    "RenderWarning",
    "Result",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Texture",
    "World",
    "__version__",
    "batch",
    "load",
]
