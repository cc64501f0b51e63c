"""Images: arrays of Stokes vectors, with what is known of their error and origin."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _sunstone
from ._errors import Error

Array = npt.NDArray[np.float32]
#: Channels that `__repr__` names one by one, at most.
FEW = 4


class Band(NamedTuple):
    """A range of wavelengths over which light is averaged: a channel of an `Image`."""

    #: What it is called.
    name: str
    #: Vacuum wavelength of its middle in nanometers.
    center_nm: float
    #: From its one end to the other in nanometers.
    width_nm: float


class Image:
    """A Stokes image.

    `Scene.render` returns them, `Image.load` reads them, and arrays become one:

    >>> image = sunstone.Image(np.ones((480, 640, 3, 1)))

    Images pickle and copy with all that they hold.
    """

    __slots__ = ("_bands", "_layers", "_metadata", "_responses", "_stokes", "_variance", "_wavelength_nm")

    def __init__(
        self,
        stokes: npt.ArrayLike,
        *,
        variance: npt.ArrayLike | None = None,
        wavelength_nm: float | None = None,
        bands: Iterable[Band | tuple[str, float, float]] | None = None,
        responses: str | None = None,
        metadata: Mapping[str, str] | None = None,
        layers: Mapping[str, npt.ArrayLike] | None = None,
    ) -> None:
        """An image of arrays, which are copied only where they have to be.

        Args:
            stokes: values of shape (height, width, channels, components): 3 channels, or 1 with
                `wavelength_nm`, or those of `bands`; 4 Stokes components, or 1 for the intensity
                alone.
            variance: squared standard errors of the same shape.
            wavelength_nm: wavelength in vacuum in nanometers of an image of one channel.
            bands: what the channels stand for in place of it, in the order of their centers: name,
                center and width in nanometers of each.
            responses: or else the curves that they have, as `Image.responses` of another has them.
            metadata: facts about the image, names to texts.
            layers: what the camera sees first, by the names that `Scene.render` takes, each of
                shape (height, width, its channels).
        """
        given = {"wavelength_nm": wavelength_nm, "bands": bands, "responses": responses}
        if len(names := [name for name, value in given.items() if value is not None]) > 1:
            raise Error(f"{' and '.join(names)} cannot both be given: leave one out")
        self._wavelength_nm = wavelength_nm
        self._responses = responses
        self._bands = None if bands is None else _bands(bands)
        self._stokes = _checked("stokes", stokes, self)
        self._variance = None
        if variance is not None:
            self._variance = _checked("variance", variance, self)
            if self._variance.shape != self._stokes.shape:
                shapes = f"{self._variance.shape}, and the values {self._stokes.shape}"
                raise Error(f"variance has the shape {shapes}: give one to each value")
        self._metadata = dict(metadata or {})
        self._layers = {
            name: np.require(values, np.float32, ("C", "W", "A"))
            for name, values in (layers or {}).items()
        }
        for name, array in self._layers.items():
            if array.ndim != 3 or array.shape[:2] != self._stokes.shape[:2]:
                height, width = self._stokes.shape[:2]
                raise Error(
                    f"the layer {name!r} has the shape {array.shape}: must be ({height}, {width}, "
                    "its channels)"
                )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Image:
        """Reads an image: .exr, .hdr (the set of files of the paper) or .npy.

        Raises:
            OSError: if the file cannot be read.
            Error: if it is not what its name promises.
        """
        return cls._of(_sunstone.load_image(os.fspath(path)))

    @classmethod
    def _of(cls, parts: _sunstone._Parts) -> Image:
        stokes, variance, channels, metadata, layers = parts
        return cls(
            stokes,
            variance=variance,
            wavelength_nm=channels if isinstance(channels, float) else None,
            bands=channels if isinstance(channels, list) else None,
            responses=channels if isinstance(channels, str) else None,
            metadata=dict(metadata),
            layers=dict(layers),
        )

    @property
    def _channels(self) -> _sunstone._Channels:
        """What the channels stand for, as the native part has it."""
        if self._bands is not None:
            return list(self._bands)
        return self._wavelength_nm if self._responses is None else self._responses

    @property
    def stokes(self) -> Array:
        """Stokes vectors: float32, C-contiguous, of shape (height, width, channels, components).

        Rows from the top, pixels from the left; channels as `channels` says; S0 to S3, or S0 alone
        in the modes "scalar" and "intensity". Radiance in W/(m^2 sr), or S0 linear in sRGB
        primaries. It is the image's own, and may be written to.
        """
        return self._stokes

    @property
    def variance(self) -> Array | None:
        """Squared standard errors in the shape of `stokes`, if they were asked for."""
        return self._variance

    @property
    def dop(self) -> Array:
        """Degree of polarization, 0 to 1, of shape (height, width, channels).

        sqrt(S1^2 + S2^2 + S3^2) / S0; 0 where there is no light, and of intensities alone.
        """
        if self._stokes.shape[3] == 1:
            return np.zeros(self._stokes.shape[:3], np.float32)
        s0, s1, s2, s3 = np.moveaxis(self._stokes, 3, 0)
        polarized = np.hypot(np.hypot(s1, s2), s3)
        degree: Array = np.divide(polarized, s0, out=np.zeros_like(s0), where=s0 > 0)
        return degree

    @property
    def aolp(self) -> Array:
        """Angle of linear polarization in radians, in [0, pi), of shape (height, width, channels).

        Counterclockwise from the right of the image as one looks at it: atan2(S2, S1) / 2 modulo
        pi; 0 where nothing is linearly polarized.
        """
        if self._stokes.shape[3] == 1:
            return np.zeros(self._stokes.shape[:3], np.float32)
        pi = np.float32(np.pi)
        angle = np.mod(np.float32(0.5) * np.arctan2(self._stokes[..., 2], self._stokes[..., 1]), pi)
        # A tiny negative angle rounds up to pi itself.
        return np.where(angle < pi, angle, np.float32(0))

    @property
    def channels(self) -> tuple[str, ...]:
        """What the channels are called.

        ("R", "G", "B"), or the wavelength, as ("550 nm",), or the names of bands or responses.
        """
        names, _ = _sunstone.about_channels(self._channels)
        return tuple(names)

    @property
    def wavelength_nm(self) -> float | None:
        """Wavelength in vacuum in nanometers of an image of one wavelength."""
        return self._wavelength_nm

    @property
    def bands(self) -> tuple[Band, ...] | None:
        """The bands that the channels are, in the order of their centers, if they are bands.

        Values of a band are means over its width, per nanometer.
        """
        return self._bands

    @property
    def responses(self) -> str | None:
        """The curves of the channels, if they have any, as files hold them: a text."""
        return self._responses

    @property
    def wavelengths_nm(self) -> Array | None:
        """The wavelength of every channel in nanometers; None in RGB.

        Of bands their centers, and of responses their means, not a number where one has none.

        >>> plt.plot(image.wavelengths_nm, image.stokes[y, x, :, 0])
        """
        if (channels := self._channels) is None:
            return None
        _, wavelengths = _sunstone.about_channels(channels)
        return np.array(wavelengths, np.float32)

    def at(self, wavelength_nm: float) -> Image:
        """The band that has a wavelength in nanometers, as an image of the one of its center.

        Raises:
            Error: if none has it.
        """
        channel, center_nm = _sunstone.channel_at(self._channels, wavelength_nm)
        one = slice(channel, channel + 1)
        return Image(
            self._stokes[:, :, one].copy(),
            variance=None if self._variance is None else self._variance[:, :, one].copy(),
            wavelength_nm=center_nm,
            metadata=self._metadata,
            layers=self._layers,
        )

    @property
    def layers(self) -> dict[str, Array]:
        """What the camera sees first, by name, each of shape (height, width, channels).

        >>> image = scene.render(layers=["depth", "normal", "material"])
        >>> image.layers["depth"][..., 0]    # in meters, infinite where nothing is

        Numbers of "material" and "object" count from 1, 0 is nothing; their names are lists of
        JSON in `metadata`, under "materials" and "objects". They are the image's own.
        """
        return self._layers

    @property
    def metadata(self) -> dict[str, str]:
        """Facts about the render: integrator, seed, iterations and so on; what `save` stores."""
        return self._metadata

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the image as the extension says: .exr (everything), .hdr or .png (a preview).

        The file appears when it is complete, and never as half a file.

        Raises:
            OSError: if it cannot be written.
            Error: if the extension is another.
        """
        _sunstone.save_image(
            os.fspath(path),
            self._stokes,
            self._variance,
            self._channels,
            [(str(name), str(text)) for name, text in self._metadata.items()],
            list(self._layers.items()),
        )

    def png(
        self, map: str | None = None, *, exposure: float = 0.0, full_scale: bool = False
    ) -> bytes:
        """A picture with its legend, as the bytes of a PNG.

        Args:
            map: one of the maps of `sunstone visualize`: "intensity", "dop", "linear-circular",
                "aolp", "aolp-dark", "chirality", "stokes", "stokes-relative", "dop-red", "type",
                "orientation" or "panels", which are the first three side by side. By default the
                panels, or the intensity where there is nothing else.
            exposure: of intensities, in stops.
            full_scale: scales end at full polarization, and not where the image's does.
        """
        if map is None:
            map = "panels" if self._stokes.shape[3] == 4 else "intensity"
        which = None if map == "panels" else map
        return _sunstone.picture(self._stokes, self._channels, which, exposure, full_scale)

    def _repr_png_(self) -> bytes:
        return self.png()

    def __repr__(self) -> str:
        height, width, _, components = self._stokes.shape
        what = "Stokes vectors" if components == 4 else "intensities"
        names = self.channels
        channels = ", ".join(names)
        if self._bands is not None and len(names) > FEW:
            ends = f"{self._bands[0].center_nm:g} to {self._bands[-1].center_nm:g} nm"
            channels = f"{len(names)} bands from {ends}"
        variance = ", with variances" if self._variance is not None else ""
        layers = f", with {', '.join(self._layers)}" if self._layers else ""
        size = f"{width} x {height}"
        return f"<sunstone.Image: {what} of {size} pixels, {channels}{variance}{layers}>"

    def __reduce__(self) -> tuple[object, ...]:
        rows = None if self._bands is None else [(*band,) for band in self._bands]
        kept = (self._stokes, self._variance, self._wavelength_nm, self._metadata)
        return _image, (*kept, rows, self._responses, self._layers)


def _image(
    stokes: Array,
    variance: Array | None,
    wavelength_nm: float | None,
    metadata: dict[str, str],
    bands: list[tuple[str, float, float]] | None = None,
    responses: str | None = None,
    layers: dict[str, Array] | None = None,
) -> Image:
    return Image(
        stokes,
        variance=variance,
        wavelength_nm=wavelength_nm,
        bands=bands,
        responses=responses,
        metadata=metadata,
        layers=layers,
    )


def _bands(bands: Iterable[Band | tuple[str, float, float]]) -> tuple[Band, ...]:
    """Bands whose numbers are those that are stored."""
    rows = _sunstone.checked_bands([(name, center, width) for name, center, width in bands])
    return tuple(Band(*row) for row in rows)


def _checked(name: str, values: npt.ArrayLike, image: Image) -> Array:
    """Values of a shape that goes with what the channels of an image stand for."""
    array = np.require(values, np.float32, ("C", "W", "A"))
    channels = len(image.channels)
    if array.ndim != 4 or array.shape[2] != channels or array.shape[3] not in (1, 4):
        what = "of one wavelength" if image.wavelength_nm is not None else "in RGB"
        if image.bands is not None or image.responses is not None:
            what = f"of {channels} {'bands' if image.bands is not None else 'responses'}"
        raise Error(
            f"{name} has the shape {array.shape}: must be (height, width, {channels}, 1 or 4), as "
            f"an image {what} has"
        )
    return array
