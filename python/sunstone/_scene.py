"""Scenes: loaded or made, described, rendered."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, Optional, Union

from . import _sunstone
from ._edits import Editable, Parts, file_keys, plain, values
from ._errors import RenderWarning, SceneError, SceneWarning
from ._image import Image

Integrator = Literal["auto", "path", "light", "bdpt", "ppm"]
Mode = Literal["polarized", "intensity", "scalar"]
Color = Literal["rgb", "mono", "spectral"]
Sampling = Literal["stokes", "intensity"]
Filter = Literal["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"]
RgbWhite = Literal["d65", "e"]
Light = Literal["auto", "none"]


def load(
    path: str | os.PathLike[str],
    *,
    allow_outside: bool = False,
    camera: str | None = None,
    light: Light = "auto",
    time: float | None = None,
    define: Mapping[str, str | float | bool] | None = None,
) -> Scene:
    """Loads a scene: glTF 2.0, .gltf or .glb, or of Mitsuba 3, .xml.

    Args:
        path: the file.
        allow_outside: let it read files outside its folder; only for scenes that you trust.
        camera: the name of the camera or of its node, or "0", "1" by the file's order; "auto" puts
            one in that sees all of the scene. By default the first, and "auto" where there is none.
        light: what shines where nothing in the scene does: "auto", a neutral sky, or "none". What
            has been put in is told by `Scene.notes`, and in the metadata of images.
        time: seconds into the animations of the file; by default nothing moves.
        define: of .xml: values of its parameters, in place of their defaults, by their names.

    Raises:
        OSError: if the file cannot be read.
        SceneError: if something in the scene is missing, invalid or not physical, or cannot be
            rendered; a file that it refers to included.

    Warns:
        SceneWarning: of what is not rendered as it was described.
    """
    view = _View(camera, light, None if time is None else float(time))
    file = _File(os.fspath(path), view, allow_outside, _texts(define or {}))
    scene = Scene._loaded(os.path.abspath(path), file, {})
    for text in scene.warnings:
        warnings.warn(text, SceneWarning, stacklevel=2)
    return scene


def _texts(define: Mapping[str, str | float | bool]) -> tuple[tuple[str, str], ...]:
    """Parameters and their values as .xml files write them."""
    words = {True: "true", False: "false"}
    values = ((name, plain(value, f"define, {name}")) for name, value in define.items())
    return tuple((name, words[it] if isinstance(it, bool) else str(it)) for name, it in values)


class _View(NamedTuple):
    """What is seen of a scene file."""

    camera: Optional[str]
    light: str
    time: Optional[float]


class _File(NamedTuple):
    """Where a scene was loaded from, and how."""

    path: str
    view: _View
    allow_outside: bool
    #: Parameters of an .xml file, and their values.
    define: tuple[tuple[str, str], ...] = ()


class _State(NamedTuple):
    """A scene as it is between two edits."""

    native: _sunstone.Scene
    source: Union[_File, Parts]


class Scene(Editable):
    """A scene in its place, with the tree of its shapes, which all its renders share.

    `load` reads one, and `World.place` makes one. It may be rendered by several threads at once,
    and edited meanwhile: a render keeps what it began with.

    Values are edited by name, KIND/NAME/KEY:

    >>> scene["materials/analyzer/axis_deg"] = 30
    >>> scene["analyzer"].axis_deg = 30           # where one thing of that name has that key
    >>> scene["media/milk/milk.dilution"]
    0.01
    >>> scene["analyzer"].axis_deg = None         # as if nothing stated it: the default
    >>> del scene["analyzer"].axis_deg            # as it was loaded or made
    >>> scene.edit({"nodes/ball/translation": (0, 1, 0), "cameras/#0/perspective.yfov": 0.5})
    >>> scene.reset()                             # all of it as it was loaded or made

    What is set is checked at once, and what `edit` is given after the last of it, as with values
    that only go together. Kinds are materials, nodes, lights, cameras and media. The first and the
    last slash separate, so a name may hold anything; #3 is the object of that index, from 0. Keys
    are those of scene files, the extension's and glTF's own, and of `World` those of its methods
    (of meshes and spheres, too, by the kind nodes; not the environment and the medium of the
    scene); dots lead inwards. Shapes and their tree are built again only if they change: where an
    edit is of a material, a light, a medium, a camera or an index, it takes milliseconds, and a
    tenth of a second where there are a million triangles.

    A loaded scene pickles as its path and its edits, and is loaded anew, so its files must be
    there, and hold what they held (warnings are not repeated); one that was made in code pickles as
    all that it is made of. A copy shares the tree, and is edited by itself.
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
    def _loaded(cls, whole: str, file: _File, edits: dict[str, Any]) -> Scene:
        native = _sunstone.load(*file, edits)
        return cls._of(native, file._replace(path=whole))

    @property
    def _native(self) -> _sunstone.Scene:
        native: _sunstone.Scene = self._state.value.native
        return native

    def _source(self) -> Any:
        native, source = self._state.value
        return source if isinstance(source, Parts) else native

    def _edit(self, edits: Mapping[str, Any], level: int) -> None:
        changes = values(edits)

        def change(state: _State) -> _State:
            if isinstance(state.source, Parts):
                return _remade(state, state.source.edited(changes))
            return state._replace(native=state.native.edit(changes))

        self._replace(change, level)

    def _take_back(self, targets: list[str], level: int) -> bool:
        def change(state: _State) -> _State | None:
            if isinstance(state.source, Parts):
                parts = state.source.taken_back(targets)
                return None if parts is None else _remade(state, parts)
            native = state.native.take_back(targets)
            return None if native is None else state._replace(native=native)

        return self._replace(change, level)

    def _replace(self, change: Callable[[_State], _State | None], level: int) -> bool:
        """Replaces the state by what is made of it, unless that is nothing."""
        said: set[str] = set()
        while True:
            old: _State = self._state.value
            new = change(old)
            if new is None:
                return False
            known = old.native.warnings
            # Before: who makes errors of warnings has the scene as it was.
            for text in new.native.warnings:
                if text not in known and text not in said:
                    said.add(text)
                    warnings.warn(text, SceneWarning, stacklevel=level + 1)
            # Somebody else may have edited meanwhile, which must not be lost.
            if self._state.swap(old, new):
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
        complete = _complete(options)
        return [*self._overruled(complete), *self._native.notes(complete)]

    def _overruled(self, options: dict[str, Any]) -> list[str]:
        """Says if the size of the film has been edited, and options state another."""
        if options["width"] is None or options["height"] is None:
            return []
        text = "the resolution of the film is edited, which means nothing where both width and " \
            "height are given"
        return [text] if self._source().has_film_size else []

    def render(
        self,
        *,
        integrator: Integrator | None = None,
        mode: Mode = "polarized",
        spp: int | None = None,
        seed: int | None = None,
        width: int | None = None,
        height: int | None = None,
        filter: Filter | None = None,
        filter_radius: float | None = None,
        filter_samples: Literal["shared", "own"] | None = None,
        crop: tuple[int, int, int, int] | str | None = None,
        pixel_aspect: float | None = None,
        color: Color = "rgb",
        wavelength: float | None = None,
        rgb_white: RgbWhite | None = None,
        wavelengths: Literal[4, 8] | None = None,
        range: Sequence[float] | str | None = None,
        bands: Sequence[float] | str | None = None,
        responses: str | None = None,
        raw_response: bool = False,
        white_balance: str | None = None,
        hold_spectra: bool = False,
        iterations: int | None = None,
        max_path_length: int | None = None,
        roulette_after: int | None = None,
        sampling: Sampling = "stokes",
        variance: bool = False,
        layers: Sequence[str] | str | None = None,
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
            integrator: how light is found; "auto" takes what suits the scene, and is the default.
                What a scene of Mitsuba asks for goes before the defaults of this, of `spp`, `seed`,
                `max_path_length` and `roulette_after`.
            mode: "polarized" measures S0 to S3, "intensity" S0 of polarized light, "scalar" S0 as
                if light had no polarization.
            spp: samples per pixel, 64 by default.
            seed: seed of all randomness, from 0, which is the default, to 2^32 - 1.
            width: width in pixels; by default the scene's, or 512.
            height: height in pixels; by default what follows from the width and the camera.
            filter: how light about a pixel counts for it: "box", "tent", "gaussian", "mitchell",
                "catmullrom" or "lanczos"; by default the scene's, or "box".
            filter_radius: where that ends, in pixels from the center; each has its own by default.
            filter_samples: "shared", the default, lets samples count for all pixels whose filters
                reach them, for the least noise; "own" for one, for independent noise of neighbors.
            crop: the part of the film that is rendered: left, top, right, bottom in pixels, as
                (100, 50, 300, 200), or "25%,25%,75%,75%"; its pixels are those of the whole.
            pixel_aspect: width of a pixel over its height; by default the scene's, or 1.
            color: "rgb" is linear in sRGB primaries, "mono" one wavelength, "spectral" carries
                light at several wavelengths, others in every iteration, and measures `bands`, or
                red, green and blue as the CIE 1931 observer sees them.
            wavelength: of "mono", in nanometers, 550 by default.
            rgb_white: the white under which red, green and blue of materials and lights have the
                color that they say, of "mono" and "spectral": "e", equal energy, by default, or
                "d65", which is the default of "spectral" without `bands`.
            wavelengths: of "spectral", how many are carried together: 4 or 8, which is the default.
            range: of "spectral", the first and the last that light may have, in nanometers, as
                (380, 780); by default those of the bands.
            bands: of "spectral", what is measured: the centers of the first and the last in
                nanometers and how many there are, as (400, 700, 31); each as wide as these are
                apart. A text is what the command line takes: "400:700:31", "450x20,red=650x30" or
                the path of a file .csv.
            responses: of "spectral" in place of bands, channels with curves of their own: "xyz",
                "luminance", "nikon-d5100", "sigma-sd1" or the path of a file .csv.
            raw_response: of responses: integrals of radiance times their numbers; otherwise each is
                normalized to 1 for a spectrum of radiance 1 per nanometer.
            white_balance: of "spectral" without `bands`, a light that the film shows as white: an
                illuminant ("D50"), a temperature ("3200K") or the path of a file .spd.
            hold_spectra: hold what tables and formulas say at their ends where the wavelengths
                reach beyond, instead of refusing that; a warning and the metadata say of which.
            iterations: in place of `spp`: of one sample in every pixel, or, by "ppm", of a pass of
                photons with its samples.
            max_path_length: most segments of a path: 1 shows emitters only, 2 adds direct light; no
                limit by default.
            roulette_after: segments after which roulette may end a path.
            sampling: what directions are drawn by where light is polarized; with "intensity" all
                modes trace the same paths.
            variance: also estimate the variance of every value.
            layers: what else the image tells of what the camera sees first, in `Image.layers`:
                "depth", "normal", "albedo", "position", "uv", "material", "object".
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
            RenderWarning: of what the image lacks, by the integrator that was chosen, and of what
                else there is to doubt about it.
        """
        options = dict(locals())
        del options["self"]
        return self._rendered(options)

    def _rendered(self, options: dict[str, Any]) -> Image:
        for text in self._overruled(options):
            warnings.warn(text, RenderWarning, stacklevel=3)
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
        return _loaded_again, (source, plain(native.edits()), _checksums(native, source.path))

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


def _checksums(native: _sunstone.Scene, path: str) -> dict[str, str]:
    """What tells whether files still hold what was read of them, the scene's own first."""
    paths = [path, *(os.fspath(file) for file in native.files[1:])]
    return dict(zip(paths, native.checksums))


def _loaded_again(
    source: tuple[Any, ...], edits: dict[str, Any], checksums: dict[str, str]
) -> Scene:
    """A scene out of a pickle, if its files still hold what they held."""
    file = _File(*source)
    scene = Scene._loaded(file.path, file._replace(view=_View(*file.view)), edits)
    now = _checksums(scene._native, file.path).values()
    for path, before, found in zip(checksums, checksums.values(), now):
        if before != found:
            raise SceneError(
                f"{path}: the file has changed since the scene was pickled\n"
                "  help: load the scene anew, make its edits again, and pickle that"
            )
    return scene


def _made(name: str, base: list[Any], steps: list[Any]) -> Scene:
    return Scene._of(native_world(name, steps).place(None), Parts(name, base, steps))


def _remade(state: _State, parts: Parts) -> _State:
    """The scene of other parts, with the tree of what it was if that is the same."""
    return _State(native_world(parts.name, parts.steps).place(state.native), parts)


def _complete(options: dict[str, Any]) -> dict[str, Any]:
    """Options of `Scene.render`, with the defaults of those that are not there."""
    defaults = Scene.render.__kwdefaults__ or {}
    for name in options:
        if name not in defaults:
            names = ", ".join(defaults)
            raise TypeError(f"{name!r} is not an option of render; these are: {names}")
    return {**defaults, **options}
