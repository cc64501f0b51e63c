"""Scenes: loaded or made, described, rendered."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, Union

from . import _sunstone
from ._edits import Object, Parts, file_keys, plain
from ._errors import RenderWarning, SceneError, SceneWarning
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
        camera: the name of the camera or of its node, or "#0", "#1" by the file's order; by default
            the first.

    Raises:
        OSError: if the file cannot be read.
        SceneError: if something in the scene is missing, invalid or not physical, or cannot be
            rendered; a file that it refers to included.

    Warns:
        SceneWarning: of what is not rendered as it was described.
    """
    scene = Scene._loaded(os.path.abspath(path), os.fspath(path), camera, allow_outside, {})
    for text in scene.warnings:
        warnings.warn(text, SceneWarning, stacklevel=2)
    return scene


class _File(NamedTuple):
    """Where a scene was loaded from, and how."""

    path: str
    camera: str | None
    allow_outside: bool


class _State(NamedTuple):
    """A scene as it is between two edits."""

    native: _sunstone.Scene
    source: Union[_File, Parts]


class Scene:
    """A scene in its place, with the tree of its shapes, which all its renders share.

    `load` reads one, and `World.place` makes one. It may be rendered by several threads at once,
    and edited meanwhile: a render keeps what it began with.

    Values are edited by name, KIND/NAME/KEY:

    >>> scene["materials/analyzer/axis_deg"] = 30
    >>> scene["analyzer"].axis_deg = 30           # where one thing of that name has that key
    >>> scene["media/milk/milk.dilution"]
    0.01
    >>> del scene["analyzer"].axis_deg            # as it was loaded or made
    >>> scene.edit({"nodes/ball/translation": (0, 1, 0), "cameras/#0/perspective.yfov": 0.5})

    Kinds are materials, nodes, lights, cameras and media. The first and the last slash separate, so
    a name may hold anything; #3 is the object of that index, from 0. Keys are those of scene files,
    the extension's and glTF's own, and of `World` those of its methods (of meshes and spheres, too,
    by the kind nodes; not the environment and the medium of the scene); dots lead inwards. Shapes
    and their tree are built again only if they change: where an edit is of a material, a light, a
    medium, a camera or an index, it takes milliseconds, and a tenth of a second where there are a
    million triangles.

    A loaded scene pickles as its path and its edits, and is loaded anew, so its files must be there
    (warnings are not repeated); one that was made in code pickles as all that it is made of. A copy
    shares the tree, and is edited by itself.
    """

    __slots__ = ("_state",)

    #: A `_State`, which edits replace.
    _state: _sunstone.Cell

    def __init__(self) -> None:
        raise TypeError("scenes are loaded by sunstone.load, or made by sunstone.World")

    @classmethod
    def _of(cls, native: _sunstone.Scene, source: Union[_File, Parts]) -> Scene:
        scene = cls.__new__(cls)
        scene._state = _sunstone.Cell(_State(native, source))
        return scene

    @classmethod
    def _loaded(
        cls, whole: str, path: str, camera: str | None, allow_outside: bool, edits: dict[str, Any]
    ) -> Scene:
        native = _sunstone.load(path, camera, allow_outside, edits)
        return cls._of(native, _File(whole, camera, allow_outside))

    @property
    def _native(self) -> _sunstone.Scene:
        native: _sunstone.Scene = self._state.value.native
        return native

    def __getitem__(self, target: str) -> Any:
        """A value, or, of a name or KIND/NAME, the `Object` whose attributes are the values.

        Lists are tuples and objects read-only mappings: what is to change is set.

        Raises:
            KeyError: if nothing states the value; it tells the default.
            SceneError: if there is no such thing, or several.
        """
        _check_target(target)
        native, source = self._state.value
        of = source if isinstance(source, Parts) else native
        if target.count("/") < 2:
            return Object(self, of.objects(target))
        is_stated, value = of.value(target)
        if is_stated:
            return value
        default = None if isinstance(source, Parts) else native.default_of(target)
        words = f"by default {default}" if default else "and there is no default"
        raise KeyError(f"{target} is not stated, {words}")

    def get(self, target: str, default: Any = None) -> Any:
        """The value of a place, or another where nothing states it."""
        try:
            return self[target]
        except KeyError:
            return default

    def __contains__(self, target: object) -> bool:
        """Whether the file, or an edit, states a value."""
        if not isinstance(target, str) or target.count("/") < 2:
            return False
        native, source = self._state.value
        try:
            stated: bool = (source if isinstance(source, Parts) else native).value(target)[0]
        except SceneError:
            return False
        return stated

    def __setitem__(self, target: str, value: Any) -> None:
        self._edit({target: value}, 3)

    def __delitem__(self, target: str) -> None:
        self._take_back(target, 3)

    #: Without it Python would ask for numbers.
    __iter__ = None

    def edit(self, edits: Mapping[str, Any]) -> None:
        """Makes several edits at once, all or none: values by KIND/NAME/KEY.

        For values that only go together, or of which each would build the tree again.

        Raises:
            SceneError: if there is no such thing, or several, or a value is not physical; then the
                scene stays as it is.

        Warns:
            SceneWarning: of what is not rendered as it is described now, and was before.
        """
        self._edit(edits, 3)

    @property
    def edits(self) -> dict[str, Any]:
        """The edits that count: values by KIND/NAME/KEY. `edit` makes them of another scene.

        What is within an edited value belongs to it, and of one place the last edit counts. It is a
        copy, of lists and dictionaries.
        """
        native, source = self._state.value
        edits: dict[str, Any] = plain(source if isinstance(source, Parts) else native.edits())
        return edits

    def _edit(self, edits: Mapping[str, Any], level: int) -> None:
        for target in edits:
            _check_target(target)
        values = {target: plain(value) for target, value in edits.items()}

        def change(state: _State) -> _State:
            if isinstance(state.source, Parts):
                return _remade(state, state.source.edited(values))
            return state._replace(native=state.native.edit(values))

        self._replace(change, level)

    def _take_back(self, target: str, level: int) -> None:
        _check_target(target)

        def change(state: _State) -> _State | None:
            if isinstance(state.source, Parts):
                parts = state.source.taken_back(target)
                return None if parts is None else _remade(state, parts)
            native = state.native.take_back(target)
            return None if native is None else state._replace(native=native)

        if not self._replace(change, level + 1):
            raise KeyError(f"{target} has not been edited")

    def _replace(self, change: Callable[[_State], _State | None], level: int) -> bool:
        """Replaces the state by what is made of it, unless that is nothing."""
        while True:
            old: _State = self._state.value
            new = change(old)
            if new is None:
                return False
            # Somebody else may have edited meanwhile, which must not be lost.
            if self._state.swap(old, new):
                break
        known = old.native.warnings
        for text in new.native.warnings:
            if text not in known:
                warnings.warn(text, SceneWarning, stacklevel=level + 1)
        return True

    def _keys(self, path: str) -> list[str]:
        """The keys that an object may have."""
        source = self._state.value.source
        return source.keys_of(path) if isinstance(source, Parts) else file_keys(path)

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
            RenderWarning: of what the image lacks, by the integrator that was chosen, and of what else
                there is to doubt about it.
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
        native, source = self._state.value
        if isinstance(source, Parts):
            return _made, (source.name, source.base, source.steps)
        path, camera, allow_outside = source
        return Scene._loaded, (path, path, camera, allow_outside, plain(native.edits()))

    def __copy__(self) -> Scene:
        return self._of(*self._state.value)

    def __deepcopy__(self, memo: object) -> Scene:
        return self.__copy__()


def native_world(name: str, steps: list[Any]) -> _sunstone.World:
    """A native world that has done all steps: the names of functions, with their arguments."""
    native = _sunstone.World(name)
    for function, arguments in steps:
        getattr(native, function)(*arguments)
    return native


def _made(name: str, base: list[Any], steps: list[Any]) -> Scene:
    return Scene._of(native_world(name, steps).place(None), Parts(name, base, steps))


def _remade(state: _State, parts: Parts) -> _State:
    """The scene of other parts, with the tree of what it was if that is the same."""
    return _State(native_world(parts.name, parts.steps).place(state.native), parts)


def _check_target(target: object) -> None:
    if not isinstance(target, str):
        raise TypeError(f"values are found by KIND/NAME/KEY, not by a {type(target).__name__}")


def _complete(options: dict[str, Any]) -> dict[str, Any]:
    """Options of `Scene.render`, with the defaults of those that are not there."""
    defaults = Scene.render.__kwdefaults__ or {}
    for name in options:
        if name not in defaults:
            names = ", ".join(defaults)
            raise TypeError(f"{name!r} is not an option of render; these are: {names}")
    return {**defaults, **options}
