"""Pictures."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

from kiln import _kiln
from kiln._errors import path_of
from kiln._words import flag_texts

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Image:
    """A drawn picture. numpy.asarray(image) is its light, without a copy.

    shape: (height, width, 4), float32: red, green, blue and alpha; linear light, premultiplied.
    """

    def __init__(self, picture: _kiln.Picture, view: int = 0):
        self._picture = picture
        self._view = view

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, 4)."""
        height, width = self._picture.size(self._view)
        return height, width, 4

    @property
    def frame(self) -> int:
        """The number of the frame; 1 for a single picture."""
        return self._picture.frame

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> "NDArray[Any]":
        import numpy

        array = numpy.asarray(self._picture.colors(self._view))
        if dtype is not None and array.dtype != dtype:
            if copy is False:
                raise ValueError(f"the pixels are {array.dtype}, so that {numpy.dtype(dtype)} is a copy")
            return array.astype(dtype)
        return array.copy() if copy else array

    @property
    def planes(self) -> "dict[str, NDArray[Any]]":
        """The planes of `aov` by their names in an EXR. shape: (height, width), float32."""
        import numpy

        return {name: numpy.asarray(plane) for name, plane in self._picture.planes(self._view).items()}

    def _plane(self, name: str, aov: str) -> "NDArray[Any]":
        import numpy

        plane = self._picture.planes(self._view).get(name)
        if plane is None:
            raise AttributeError(f'the picture has no {aov}; render it with aov=["{aov}"]')
        return numpy.asarray(plane)

    @property
    def depth(self) -> "NDArray[Any]":
        """Depth along the view at which alpha passes one half; infinite where it does not. unit: the world's.

        shape: (height, width), float32. requires: aov=["depth"].
        """
        return self._plane("Z", "depth")

    @property
    def normal(self) -> "NDArray[Any]":
        """Mean normals in the world, of unit length or 0. shape: (height, width, 3). requires: aov=["normal"]."""
        import numpy

        return numpy.stack([self._plane(name, "normal") for name in ("N.X", "N.Y", "N.Z")], axis=-1)

    @property
    def value(self) -> "NDArray[Any]":
        """Projected values, NaN without values. shape: (height, width). requires: aov=["value"] and a mode."""
        return self._plane("value", "value")

    @property
    def right(self) -> "Image | None":
        """The right eye's picture of stereo="both", of which this is the left eye's; else None."""
        return Image(self._picture, 1) if self._picture.views > 1 and self._view == 0 else None

    def srgb8(self) -> "NDArray[Any]":
        """Returns the colours as the PNG has them. shape: (height, width, 4), uint8, sRGB, straight alpha."""
        import numpy

        return numpy.frombuffer(self._picture.srgb(self._view), dtype=numpy.uint8).reshape(self.shape)

    def save(self, path: str | os.PathLike[str], **words: Any) -> None:
        """Writes a picture, byte for byte as `kiln render -o`. words: options of files, such as png_bits=16.

        Of stereo="both", both eyes; `right.save` writes the right eye's.
        """
        file = path_of("path", path, "is a file", "name the picture to write, such as 'head.png'")
        self._picture.save(self._view, file, flag_texts(words))

    @property
    def job(self) -> dict[str, Any]:
        """The job that draws the picture again, with every choice made."""
        job: dict[str, Any] = json.loads(self._picture.job)
        return job

    def _repr_png_(self) -> bytes:
        return self._picture.png(self._view)

    def __repr__(self) -> str:
        height, width, _ = self.shape
        return f"<kiln.Image {width} x {height}>"
