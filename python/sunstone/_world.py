"""Worlds made in code."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt

from . import _sunstone
from ._edits import Editable, Parts, plain, values
from ._errors import SceneWarning
from ._image import Image
from ._scene import Scene, _complete, native_world
from ._sunstone import Geometry
from ._texture import Picture, Texture, as_keys

#: The same at every wavelength; red, green and blue; or values at wavelengths in nanometers:
#: {"nm": [...], "value": [...]}.
Spectrum = Union[float, Sequence[float], Mapping[str, Sequence[float]]]
#: Part of an index of refraction: a spectrum, the name of a substance ("Ag", "BK7", "water"), or of n
#: a formula: {"sellmeier": {"b": [...], "c_um2": [...], "range_nm": [...]}} or
#: {"cauchy": {"a": ..., "b_um2": ..., "c_um4": ..., "range_nm": [...]}}.
Index = Union[Spectrum, str, Mapping[str, Mapping[str, Any]]]
#: What shines: a spectrum, {"illuminant": "D65"}, {"blackbody_k": 3000}, or
#: {"lines": [[nm, power, width_nm], ...], "shape": "gaussian"}; with "scale" if need be.
Lamp = Union[Spectrum, Mapping[str, Any]]
#: How what is emitted is polarized: S1, S2 and S3 over S0, each a spectrum, whose squares add up to 1
#: at most. For light along k the frame is (x, k cross x, k), x less what of it is along k.
Stokes = Sequence[Spectrum]
#: Three numbers.
Vector = Union[Sequence[float], npt.NDArray[Any]]


class World(Editable):
    """A scene in the making: materials, media, shapes, lights and a camera, added one by one.

    >>> world = sunstone.World("room")
    >>> world.add_material("white", "diffuse", reflectance=0.7, two_sided=True)
    >>> world.add_material("glow", "absorber", emission=[20, 18, 15])
    >>> world.add_mesh("walls", sunstone.Geometry.cuboid((-1, -1, -1), (1, 1, 1)), "white")
    >>> world.add_sphere("lamp", 0.2, "glow", position=(0, 0.7, 0))
    >>> world.set_camera("eye", yfov=1.2, position=(0, 0, 0.9), target=(0, 0, 0))
    >>> image = world.render(width=64, height=64, spp=16)

    Keys, units and ranges are those of the scene files. What is not physical raises a SceneError
    with the name of the object and the field, and is not added. Materials and media are referred to
    by their names, each of which there is once.

    What was added is edited by name, as in a `Scene`, and the world goes on with that:

    >>> world["white"].reflectance = 0.5
    >>> world["nodes/lamp/position"] = (0, 0.6, 0)

    Worlds pickle and copy as all that they are made of.
    """

    def __init__(self, name: str = "world") -> None:
        """An empty one, of a name."""
        self._name = name
        #: All that was added, names of functions and arguments, and what edits make of it.
        self._parts = Parts(name, [])
        self._native: _sunstone.World | None = _sunstone.World(name)
        self._scene: Scene | None = None
        #: The latest scene, whose tree the next one has if its shapes are the same.
        self._latest: _sunstone.Scene | None = None

    @property
    def name(self) -> str:
        """What it is called."""
        return self._name

    @property
    def _steps(self) -> list[tuple[str, tuple[Any, ...]]]:
        """The calls that it is made of, after edits."""
        return self._parts.steps

    def _source(self) -> Parts:
        return self._parts

    def _keys(self, path: str) -> list[str]:
        return self._parts.keys_of(path)

    def _edit(self, edits: Mapping[str, Any], level: int) -> None:
        self._become(self._parts.edited(values(edits)))

    def _take_back(self, targets: list[str], level: int) -> bool:
        parts = self._parts.taken_back(targets)
        if parts is not None:
            self._become(parts)
        return parts is not None

    def _become(self, parts: Parts) -> None:
        """Goes on as other parts, if they can be made."""
        self._native = native_world(self._name, parts.steps)
        self._parts, self._scene = parts, None

    def add_material(
        self,
        name: str,
        bsdf: Literal[
            "absorber",
            "circular_polarizer",
            "conductor",
            "dielectric",
            "diffuse",
            "measured",
            "mueller",
            "null",
            "plastic",
            "polarizer",
            "retarder",
            "rough_conductor",
            "rough_dielectric",
            "thin_dielectric",
        ],
        *,
        reflectance: Spectrum | None = None,
        metal: str | None = None,
        eta: Index | None = None,
        k: Index | None = None,
        alpha: float | None = None,
        roughness: float | None = None,
        distribution: Literal["beckmann", "ggx"] | None = None,
        multiple_scattering: bool | None = None,
        specular: float | None = None,
        internal_reflection: Literal["lost", "linear", "nonlinear"] | None = None,
        ior: Index | None = None,
        exterior_ior: Index | None = None,
        axis_deg: float | None = None,
        extinction_ratio: float | None = None,
        transmittance: Spectrum | None = None,
        blocked: Spectrum | None = None,
        retardance_deg: Spectrum | None = None,
        birefringence: Spectrum | None = None,
        thickness_um: float | None = None,
        handedness: Literal["left", "right"] | None = None,
        matrix: npt.ArrayLike | None = None,
        film: Mapping[str, Any] | None = None,
        table: bytes | None = None,
        reflected: Spectrum | None = None,
        transmitted: Spectrum | None = None,
        textures: Mapping[str, Texture | Picture] | None = None,
        emission: Lamp | None = None,
        stokes: Stokes | None = None,
        incandescent: bool = False,
        two_sided: bool = False,
    ) -> None:
        """Adds a material.

        Args:
            name: what shapes call it.
            bsdf: how it scatters.
            reflectance: of "diffuse" and the base of "plastic", from 0 to 1; 0.8 by default.
            metal: of "conductor" and "rough_conductor", by its chemical symbol, or else `eta` and
                `k`.
            eta: of the same: real part of the index of refraction n - i k.
            k: of the same: its extinction coefficient.
            alpha: of "rough_conductor", "rough_dielectric" and "plastic": roughness of facets, from 0
                to 1; smooth below 0.001.
            roughness: of the same, instead of `alpha`: its root.
            distribution: of the same: how the normals of facets are distributed; "ggx" by default.
            multiple_scattering: of "rough_conductor" and "rough_dielectric": whether light that
                several facets have scattered is there; true by default.
            specular: of "plastic": share of what its facets would reflect; 1 by default.
            internal_reflection: of "plastic": what becomes of light that its interface reflects
                back to the base: "lost", or scattered again, without loss ("linear") or like all
                light ("nonlinear", by default).
            ior: of "dielectric" and "rough_dielectric" (behind the front), "thin_dielectric" and
                "plastic" (within; one number, from that outside to ten times it); 1.5 by default.
                One that depends on the wavelength disperses light by the former two; in RGB that at
                587.56 nm holds for all.
            exterior_ior: of these: index of refraction outside; 1 by default.
            axis_deg: of "polarizer" (transmission axis), "retarder" (fast axis), both in
                "circular_polarizer", and "mueller", in degrees from the x axis of the shape,
                counterclockwise about the normal; 0 by default.
            extinction_ratio: of "polarizer": greatest over least transmittance; infinite by
                default.
            transmittance: of "polarizer" and "circular_polarizer": along the axis; 1 by default.
            blocked: of the same: transmittance across it, in place of `extinction_ratio`.
            retardance_deg: of "retarder" and "circular_polarizer" (90 by default), in degrees.
            birefringence: of the same, with `thickness_um` in place of `retardance_deg`.
            thickness_um: of the same: of the crystal, in micrometers.
            handedness: of "circular_polarizer": of the light that it makes; "right" by default.
            matrix: of "mueller": four rows of four numbers, for light from the front to the back.
            film: on metal and glass, smooth and rough: {"eta": 1.33, "k": 0, "thickness_nm": 300,
                "share": 1}.
            table: of "measured": the bytes of a file of Mueller matrices, as Mitsuba's
                measured_polarized reads.
            reflected: of glass and metal: share that is left of light that it reflects, a number or
                red, green and blue from 0 to 1; all of it by default.
            transmitted: of glass: the same of light that goes through, each time.
            textures: pictures, each by what it is multiplied with: "reflectance", "alpha" (1 by
                default then), "reflected", "transmitted" and "emission"; "coverage", how much of the
                surface is there, and "normal" or "bump", normals or heights that bend normals.
                Meshes need `uv` for them, and spheres have it: once round their z axis, and from
                that to its other end.
            emission: radiance in W/(m^2 sr) that it emits besides.
            stokes: how that is polarized; unpolarized by default. x is the x axis of the shape.
            incandescent: of "conductor" and "dielectric": emission is that of a black body, of
                which leaves what the surface does not reflect, polarized.
            two_sided: the back is like the front; else it is black and dark.
        """
        self._add(
            "add_material",
            name,
            _given(
                bsdf=bsdf,
                reflectance=reflectance,
                metal=metal,
                eta=eta,
                k=k,
                alpha=alpha,
                roughness=roughness,
                distribution=distribution,
                multiple_scattering=multiple_scattering,
                specular=specular,
                internal_reflection=internal_reflection,
                ior=ior,
                exterior_ior=exterior_ior,
                axis_deg=axis_deg,
                extinction_ratio=extinction_ratio,
                transmittance=transmittance,
                blocked=blocked,
                retardance_deg=retardance_deg,
                birefringence=birefringence,
                thickness_um=thickness_um,
                handedness=handedness,
                matrix=matrix,
                film=film,
                table=table,
                reflected=reflected,
                transmitted=transmitted,
                textures=None if textures is None else as_keys(textures),
                emission=emission,
                stokes=stokes,
                incandescent=incandescent,
                two_sided=two_sided,
            ),
        )

    def add_medium(
        self,
        name: str,
        phase: Literal["hg", "isotropic", "mie", "mueller_table", "rayleigh"],
        *,
        sigma_a: Spectrum | None = None,
        sigma_s: Spectrum | None = None,
        g: Spectrum | None = None,
        depolarization: float | None = None,
        particles: Sequence[Mapping[str, Any]] | None = None,
        host: Mapping[str, Any] | None = None,
        milk: Mapping[str, float] | None = None,
        table: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        """Adds a participating medium, which fills nothing yet.

        Args:
            name: what shapes call it.
            phase: how it scatters.
            sigma_a: absorption coefficient in 1/m; by default that of the particles, by "mie".
            sigma_s: scattering coefficient in 1/m; likewise.
            g: of "hg": mean cosine of the scattering angle, within (-1, 1).
            depolarization: of "rayleigh", from 0 to 0.5; 0 by default.
            particles: of "mie": each {"distribution": {"kind": "log_normal", "mean_um": 0.5,
                "sd_um": 0.1, "of": "number"}, "eta": 1.59, "k": 0, "volume_fraction": 1e-4}; kinds
                are gamma, log_normal, monodisperse ("radius_um") and table ("radii_um", "density").
            host: of "mie": {"eta": 1.33, "k": 0}, in which the particles are.
            milk: of "mie", in place of these: {"fat_percent": 3.5, "protein_percent": 3.4,
                "dilution": 0.01}.
            table: of "mueller_table": columns theta_deg, m00, m01, m22, m23, and perhaps m11, m33
                and lambda_nm.
        """
        self._add(
            "add_medium",
            name,
            _given(
                phase=phase,
                sigma_a=sigma_a,
                sigma_s=sigma_s,
                g=g,
                depolarization=depolarization,
                particles=particles,
                host=host,
                milk=milk,
                table=table,
            ),
        )

    def add_mesh(
        self,
        name: str,
        geometry: Geometry,
        material: str,
        *,
        position: Vector | None = None,
        transform: npt.ArrayLike | None = None,
        interior: str | None = None,
        exterior: str | None = None,
        priority: int = 0,
    ) -> None:
        """Adds a mesh in a place. Meshes of one geometry keep it once.

        Args:
            name: what errors call it.
            geometry: its triangles.
            material: the name of its material.
            position: where its origin is, in meters.
            transform: or else a (4, 4) matrix from its space to the world's, of column vectors.
            interior: the name of the medium behind its surfaces, against their normals, or "none".
            exterior: of that before them.
            priority: where closed bodies overlap, that of the highest counts.
        """
        self._add(
            "add_mesh",
            name,
            geometry,
            _given(
                material=material,
                position=position,
                transform=transform,
                interior=interior,
                exterior=exterior,
                priority=priority,
            ),
        )

    def add_sphere(
        self,
        name: str,
        radius: float,
        material: str,
        *,
        position: Vector | None = None,
        transform: npt.ArrayLike | None = None,
        interior: str | None = None,
        exterior: str | None = None,
        priority: int = 0,
    ) -> None:
        """Adds an exact sphere about the origin of its place.

        Args:
            name: what errors call it.
            radius: in meters.
            material: the name of its material.
            position: where its center is, in meters.
            transform: or else a (4, 4) matrix, which may scale all axes alike.
            interior: the name of the medium within, or "none".
            exterior: of that outside.
            priority: where closed bodies overlap, that of the highest counts.
        """
        self._add(
            "add_sphere",
            name,
            radius,
            _given(
                material=material,
                position=position,
                transform=transform,
                interior=interior,
                exterior=exterior,
                priority=priority,
            ),
        )

    def add_light(
        self,
        name: str,
        kind: Literal["directional", "point", "spot"],
        intensity: Lamp,
        *,
        inner: float | None = None,
        outer: float | None = None,
        falloff: Literal["angle", "cosine"] | None = None,
        angular_diameter: float | None = None,
        ies: bytes | None = None,
        picture: bytes | None = None,
        stokes: Stokes | None = None,
        position: Vector | None = None,
        direction: Vector | None = None,
        target: Vector | None = None,
        transform: npt.ArrayLike | None = None,
    ) -> None:
        """Adds a light without extent.

        Args:
            name: what errors call it.
            kind: its shape.
            intensity: radiant intensity in W/sr, or of "directional" irradiance in W/m^2 on what
                faces it.
            inner: of "spot": half angle of full intensity in radians; 0 by default.
            outer: of "spot": half angle of the cone in radians, at most pi/2.
            falloff: of "spot": between these it falls off with the square of a ramp in the cosine,
                which is the default, or evenly with the "angle".
            angular_diameter: of "directional": the angle in radians that it takes up, 0.0093 for
                the sun; a direction by default.
            ies: of "point": the bytes of a file of IES LM-63, type C. The intensity is what one
                candela of that stands for; its axis is where the light shines.
            picture: of "spot": the bytes of a picture that it throws, of PNG, JPEG, WebP, BMP,
                OpenEXR or Radiance HDR. From left to right that takes up twice `outer`, which may be up to
                1.55; a facing wall at a distance of 1 m gets the intensity times the texel.
            stokes: how its light is polarized; unpolarized by default. x is its x axis.
            position: where it is, in meters.
            direction: where it shines.
            target: or else what it shines on.
            transform: or else a (4, 4) matrix; it shines along the -z axis.
        """
        self._add(
            "add_light",
            name,
            _given(
                kind=kind,
                intensity=intensity,
                inner=inner,
                outer=outer,
                falloff=falloff,
                angular_diameter=angular_diameter,
                ies=ies,
                picture=picture,
                stokes=stokes,
                position=position,
                direction=direction,
                target=target,
                transform=transform,
            ),
        )

    def set_camera(
        self,
        name: str = "camera",
        *,
        yfov: float | None = None,
        aspect: float | None = None,
        aperture_radius: float | None = None,
        focus_distance: float | None = None,
        half_width: float | None = None,
        half_height: float | None = None,
        position: Vector | None = None,
        target: Vector | None = None,
        direction: Vector | None = None,
        up: Vector | None = None,
        transform: npt.ArrayLike | None = None,
        resolution: tuple[int, int] | None = None,
    ) -> None:
        """Sets the camera, in place of another.

        Args:
            name: what errors call it.
            yfov: vertical angle of view in radians; without it the projection is parallel.
            aspect: width over height, where no film says it.
            aperture_radius: radius of a thin lens in meters; 0 by default, a pinhole.
            focus_distance: distance of the plane in focus in meters.
            half_width: of a parallel projection, half the width of the picture in meters.
            half_height: half its height.
            position: where it is, in meters.
            target: what it looks at.
            direction: or else where it looks.
            up: what is up in the image; y by default.
            transform: or else a (4, 4) matrix; it looks along the -z axis, y up.
            resolution: width and height in pixels that renders have by default.
        """
        self._add(
            "set_camera",
            name,
            _given(
                yfov=yfov,
                aspect=aspect,
                aperture_radius=aperture_radius,
                focus_distance=focus_distance,
                half_width=half_width,
                half_height=half_height,
                position=position,
                target=target,
                direction=direction,
                up=up,
                transform=transform,
                resolution=resolution,
            ),
        )

    def set_environment(self, radiance: Lamp, *, stokes: Stokes | None = None) -> None:
        """Has light come from everywhere outside.

        Args:
            radiance: in W/(m^2 sr).
            stokes: how it is polarized; unpolarized by default. x is that of the scene.
        """
        self._add("set_environment", plain(radiance), plain(stokes))

    def set_environment_map(
        self,
        picture: bytes,
        *,
        factor: float | Sequence[float] = 1.0,
        rotation: Sequence[float] = (0.0, 0.0, 0.0, 1.0),
    ) -> None:
        """Has light come from everywhere as a picture of all directions says.

        Args:
            picture: the bytes of an equirectangular OpenEXR or Radiance HDR file, in W/(m^2 sr), or
                of PNG, JPEG or WebP. Its middle shows +x, right of that lies +z, and the upper edge
                is +y. OpenEXR with Stokes channels is polarized.
            factor: what its values are multiplied by; one number or red, green and blue.
            rotation: a quaternion (x, y, z, w) that turns it.
        """
        colors = np.broadcast_to(np.asarray(factor, dtype=float), 3).tolist()
        turn = np.asarray(rotation, dtype=float).tolist()
        self._add("set_environment_map", bytes(picture), colors, turn)

    def set_clear_sky(
        self,
        sun_direction: Vector,
        *,
        turbidity: float = 3.0,
        max_degree: float = 0.8,
        factor: float = 1.0,
    ) -> None:
        """Has the light of a clear sky, which is polarized, come from above the plane of x and z.

        Args:
            sun_direction: to the sun, y > 0. The sun itself is a light of its own.
            turbidity: how hazy it is, from 2 (clear) to 10.
            max_degree: the degree of polarization at a right angle to the sun.
            factor: what its radiance is multiplied by.
        """
        sun = np.asarray(sun_direction, dtype=float).tolist()
        self._add("set_clear_sky", sun, [float(turbidity), float(max_degree)], float(factor))

    def set_scene_medium(self, name: str | None) -> None:
        """Fills what is outside all boundaries with a medium, or with none."""
        self._add("set_scene_medium", name)

    def place(self) -> Scene:
        """The scene as it is now, ready to be rendered and edited; the world may go on.

        Edits of the scene are its own, and leave the world as it is: what is to hold for scenes to
        come, too, is edited in the world.

        Raises:
            SceneError: if there is no camera, or things do not go together.

        Warns:
            SceneWarning: of what is not rendered as it was described.
        """
        return copy.copy(self._placed())

    def render(self, **options: Any) -> Image:
        """Renders the world as it is now: `Scene.render` of `place`, with its options."""
        complete = _complete(options)
        return self._placed()._rendered(complete)

    def _placed(self) -> Scene:
        if self._scene is None:
            native, self._native = self._filled(), None
            self._latest = native.place(self._latest)
            # The world may go on, and what the scene is made of may not.
            scene = Scene._of(self._latest, Parts(self._name, list(self._steps)))
            # Who makes errors of warnings is told again.
            for text in scene.warnings:
                warnings.warn(text, SceneWarning, stacklevel=3)
            self._scene = scene
        return self._scene

    def _filled(self) -> _sunstone.World:
        """The native world of all steps."""
        if self._native is None:
            self._native = native_world(self._name, self._steps)
        return self._native

    def _add(self, function: str, *arguments: Any) -> None:
        # What was given may change later, and the world does not with it.
        arguments = copy.deepcopy(arguments)
        getattr(self._filled(), function)(*arguments)
        self._parts.add((function, arguments))
        self._scene = None
        if function in ("add_mesh", "add_sphere"):
            # Two trees would be in the memory at once.
            self._latest = None

    def __repr__(self) -> str:
        return f"<sunstone.World {self._name!r} of {len(self._steps)} things>"

    def __reduce__(self) -> tuple[object, ...]:
        return _world, (self._name, self._parts.base, self._parts.steps)

    def __copy__(self) -> World:
        return _world(self._name, list(self._parts.base), list(self._parts.steps))

    def __deepcopy__(self, memo: object) -> World:
        return self.__copy__()


def _world(name: str, base: list[Any], steps: list[Any]) -> World:
    world = World(name)
    world._parts, world._native = Parts(name, base, steps), None
    return world


def _given(**keys: Any) -> dict[str, Any]:
    """The keys that have a value, as plain numbers, lists and dictionaries."""
    return {key: plain(value, key) for key, value in keys.items() if value is not None}
