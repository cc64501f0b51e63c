"""Pictures on materials."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt

from ._errors import SceneError

#: The bytes of a file, its path, or an array: of rows from the top, each from the left, of one number,
#: or of red, green and blue, and alpha. Of integers of 8 or 16 bits, or of linear floats.
Picture = Union[bytes, str, "os.PathLike[str]", npt.NDArray[Any]]


class Texture:
    """A picture, and how it lies on surfaces.

    >>> checks = np.array([[0, 255], [255, 0]], dtype=np.uint8)
    >>> world.add_material("floor", "diffuse", textures={"reflectance": sunstone.Texture(
    ...     checks, filter="nearest", transform=[[4, 0, 0], [0, 4, 0]])})

    Args:
        picture: the bytes of a file (PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR), its path, or an
            array.
        wrap: what it shows beyond its edges.
        filter: whether what is between the middles of its texels is interpolated.
        transform: two rows that, times (u, v, 1) of the shape, are where the picture is read, from
            (0, 0) at its upper left corner to (1, 1).
        coding: whether integers are encoded as sRGB is. They are by default where colors are wanted.
        channel: what of its texels counts: the color, by default where one is wanted, or else a
            number, by default the luminance.
        scale: of "normal", what right and up are multiplied by; of "bump", how high 1 is, in meters.
        cutoff: of "coverage": the least value that counts as all; what is less counts as nothing.
    """

    def __init__(
        self,
        picture: Picture,
        *,
        wrap: Literal["repeat", "mirror", "clamp"] = "repeat",
        filter: Literal["linear", "nearest"] = "linear",
        transform: Sequence[Sequence[float]] | None = None,
        coding: Literal["srgb", "linear"] | None = None,
        channel: Literal["color", "red", "green", "blue", "alpha", "luminance"] | None = None,
        scale: float | None = None,
        cutoff: float | None = None,
    ) -> None:
        keys = {
            **_stored(picture),
            "wrap": wrap,
            "filter": filter,
            "transform": transform,
            "coding": coding,
            "channel": channel,
            "scale": scale,
            "cutoff": cutoff,
        }
        self._keys = {key: value for key, value in keys.items() if value is not None}

    def __repr__(self) -> str:
        return f"<sunstone.Texture of {len(self._keys['picture'])} bytes>"


def as_keys(textures: Mapping[str, Texture | Picture]) -> dict[str, dict[str, Any]]:
    """What the native part takes."""

    def keys(of: Texture | Picture) -> dict[str, Any]:
        return (of if isinstance(of, Texture) else Texture(of))._keys

    if not isinstance(textures, Mapping):
        kind = type(textures).__name__
        raise TypeError(f"textures are a mapping, as {{'reflectance': 'wood.png'}}, not a {kind}")
    return {str(slot): keys(of) for slot, of in textures.items()}


def _stored(picture: Picture) -> dict[str, Any]:
    """A picture as the bytes of a file, or of linear floats in rows of a width."""
    if isinstance(picture, (bytes, bytearray, memoryview)):
        return {"picture": bytes(picture)}
    if isinstance(picture, (str, os.PathLike)):
        with open(picture, "rb") as file:
            return {"picture": file.read()}
    array = np.asarray(picture)
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    shape = array.shape
    if array.ndim != 3 or shape[2] not in (1, 2, 3, 4) or 0 in shape:
        raise SceneError(
            f"a picture must have the shape (height, width) or (height, width, channels), of one to "
            f"four channels, not {np.shape(picture)}"
        )
    if array.dtype in (np.uint8, np.uint16):
        return {"picture": _png(array)}
    if array.dtype.kind == "f" and shape[2] in (1, 3):
        colors = np.ascontiguousarray(np.broadcast_to(array, (*shape[:2], 3)), dtype=np.float32)
        return {"picture": colors.tobytes(), "width": int(shape[1])}
    raise SceneError(
        f"a picture must be of integers of 8 or 16 bits, or of floats of one or three channels, not "
        f"{array.dtype} of {shape[2]}"
    )


def _png(array: npt.NDArray[Any]) -> bytes:
    """A file of rows of integers."""
    height, width, channels = array.shape
    depth = 8 * array.dtype.itemsize
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder(">")).view(np.uint8)
    rows = rows.reshape(height, -1)
    # No row is filtered.
    lines = np.concatenate([np.zeros((height, 1), dtype=np.uint8), rows], axis=1)

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    data = zlib.compress(lines.tobytes(), 1)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )
