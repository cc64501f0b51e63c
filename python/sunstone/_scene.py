"""Scenes: loaded or made, described, rendered."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from typing import Any, Literal

from . import _sunstone
from ._errors import RenderWarning, SceneWarning
from ._image import Image

Integrator = Literal["auto", "path", "light", "bdpt", "ppm"]
Mode = Literal["polarized", "intensity", "scalar"]
Color = Literal["rgb", "mono"]
Sampling = Literal["stokes", "intensity"]


def load(
    path: str | os.PathLike[str], *, allow_outside: bool = False, camera: str | None = None
) -> Scene:
    """Loads a scene: glTF 2.0, .gltf or .glb.

    Args:
        path: the file.
        allow_outside: let it read files outside its folder; only for scenes that you trust.
        camera: the name of the camera, or "#2" for the second; by default the first.

    Raises:
        OSError: if the file cannot be read.
        SceneError: if something in the scene is missing, invalid or not physical, or cannot be
            rendered; a file that it refers to included.

    Warns:
        SceneWarning: of what is not rendered as it was described.
    """
    scene = Scene._loaded(os.path.abspath(path), os.fspath(path), camera, allow_outside)
    for text in scene.warnings:
        warnings.warn(text, SceneWarning, stacklevel=2)
    return scene


class Scene:
    """A scene in its place, with the tree of its shapes, which all its renders share.

    `load` reads one, and `World.place` makes one. It may be rendered by several threads at once.

    A loaded scene pickles as its path and is loaded anew, so its files must be there (warnings are
    not repeated); one that was made in code pickles as all that it is made of. A copy shares the
    tree.
    """

    __slots__ = ("_made_of", "_native")

    _native: _sunstone.Scene
    #: What makes it anew: a function and its arguments.
    _made_of: tuple[Callable[..., Scene], tuple[Any, ...]]

    def __init__(self) -> None:
        raise TypeError("scenes are loaded by sunstone.load, or made by sunstone.World")

    @classmethod
    def _of(
        cls, native: _sunstone.Scene, made_of: tuple[Callable[..., Scene], tuple[Any, ...]]
    ) -> Scene:
        scene = cls.__new__(cls)
        scene._native = native
        scene._made_of = made_of
        return scene

    @classmethod
    def _loaded(
        cls, whole: str, path: str, camera: str | None, allow_outside: bool
    ) -> Scene:
        native = _sunstone.load(path, camera, allow_outside)
        return cls._of(native, (cls._loaded, (whole, whole, camera, allow_outside)))

    @property
    def name(self) -> str:
        """The scene's own name, or the file's if it has none."""
        return self._native.name

    @property
    def files(self) -> list[str]:
        """The files that it was read from: itself, its buffers and tables; none if made in code."""
        return [os.fspath(file) for file in self._native.files]

    @property
    def warnings(self) -> list[str]:
        """What of it is not rendered as it was described, a sentence each."""
        return self._native.warnings

    def describe(self) -> str:
        """What is in it, in words, as `sunstone inspect` says it."""
        return self._native.describe()

    def notes(self, **options: Any) -> list[str]:
        """What is to be known of a render of these options, those of `render`, before it begins.

        Which integrator was chosen and why, what it does not find, lamps that are shut in.
        """
        return self._native.notes(_complete(options))

    def render(
        self,
        *,
        integrator: Integrator = "auto",
        mode: Mode = "polarized",
        spp: int | None = None,
        seed: int = 0,
        width: int | None = None,
        height: int | None = None,
        color: Color = "rgb",
        wavelength: float | None = None,
        iterations: int | None = None,
        max_path_length: int | None = None,
        roulette_after: int | None = None,
        sampling: Sampling = "stokes",
        variance: bool = False,
        replicates: int | None = None,
        photons: int | None = None,
        samples_per_iteration: int | None = None,
        radius: float | None = None,
        alpha: float | None = None,
        time_limit: float | None = None,
        threads: int | None = None,
        progress: Callable[[int, int], object] | None = None,
    ) -> Image:
        """Renders an image: the same bits as the command line with the same options.

        The interpreter is free meanwhile: other threads go on, and may render too. Ctrl-C ends it
        with KeyboardInterrupt.

        Args:
            integrator: how light is found; "auto" takes what suits the scene.
            mode: "polarized" measures S0 to S3, "intensity" S0 of polarized light, "scalar" S0 as
                if light had no polarization.
            spp: samples per pixel, 64 by default.
            seed: seed of all randomness, from 0 to 2^32 - 1.
            width: width in pixels; by default the scene's, or 512.
            height: height in pixels; by default what follows from the width and the camera.
            color: "rgb" is linear in sRGB primaries, "mono" one wavelength.
            wavelength: of "mono", in nanometers, 550 by default.
            iterations: in place of `spp`: of one sample in every pixel, or, by "ppm", of a pass of
                photons with its samples.
            max_path_length: most segments of a path: 1 shows emitters only, 2 adds direct light; no
                limit by default.
            roulette_after: segments after which roulette may end a path.
            sampling: what directions are drawn by where light is polarized; with "intensity" all
                modes trace the same paths.
            variance: also estimate the variance of every value.
            replicates: independent replicates that the samples are split into.
            photons: light paths an iteration, by "ppm".
            samples_per_iteration: samples per pixel an iteration, by "ppm".
            radius: radius of the first iteration in meters, by "ppm".
            alpha: how the kernel shrinks, from 0 to 1, by "ppm"; 2/3 by default.
            time_limit: seconds after which to stop with what is done.
            threads: threads, one for every processor by default; they change no bit.
            progress: called in this thread now and then with the samples per pixel that are done
                and those in all; if it returns False, the image is what is done. What it raises
                ends the render.

        Raises:
            RenderError: if an option is out of its range, or the memory too small.
            SceneError: if the scene cannot be seen at the wavelength, or nothing in it emits.

        Warns:
            RenderWarning: of what there is to doubt about the image.
        """
        options = dict(locals())
        del options["self"]
        return self._rendered(options)

    def _rendered(self, options: dict[str, Any]) -> Image:
        progress = options.pop("progress")
        parts, doubts = self._native.render(options, progress)
        for text in doubts:
            # Of the line that called what has called this.
            warnings.warn(text, RenderWarning, stacklevel=3)
        return Image._of(parts)

    def __repr__(self) -> str:
        return f"<sunstone.Scene {self.name!r}>"

    def __reduce__(self) -> tuple[object, ...]:
        return self._made_of

    def __copy__(self) -> Scene:
        return self._of(self._native, self._made_of)

    def __deepcopy__(self, memo: object) -> Scene:
        return self.__copy__()


def _complete(options: dict[str, Any]) -> dict[str, Any]:
    """Options of `Scene.render`, with the defaults of those that are not there."""
    defaults = Scene.render.__kwdefaults__ or {}
    for name in options:
        if name not in defaults:
            names = ", ".join(defaults)
            raise TypeError(f"{name!r} is not an option of render; these are: {names}")
    return {**defaults, **options}
