"""Arrays as volumes: NumPy, and anything with a shape, a dtype and slices."""

from __future__ import annotations

import math
import mmap
import os
from typing import Any, Sequence

from kiln import _kiln
from kiln._errors import whole_number, wrong_word

# Read in place, without Python.
_IN_PLACE = {"uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"}
# A box that Python slices at a time. unit: voxels along an axis, bytes.
_LEAST_EDGE, _MOST_BYTES = 64, 64 << 20


def is_array(source: Any) -> bool:
    if isinstance(source, (str, os.PathLike)):
        return False
    return hasattr(source, "shape") and hasattr(source, "dtype") and hasattr(source, "__getitem__")


def _number_type(array: Any) -> Any:
    import numpy

    try:
        return numpy.dtype(array.dtype)
    except TypeError:  # a dtype of another library
        return numpy.asarray(array[(slice(0, 1),) * len(array.shape)]).dtype


def _edges(array: Any, shape: Sequence[int], fixed: Sequence[bool], itemsize: int) -> list[int]:
    """Returns the box to slice at a time: whole chunks of the array if it has any."""
    chunks = getattr(array, "chunks", None)
    edges = []
    for axis, length in enumerate(shape):
        chunk = chunks[axis] if chunks is not None else 1
        # An axis without voxels has chunks without voxels; its shape is refused later.
        chunk = max(1, max(chunk) if isinstance(chunk, tuple) else int(chunk))
        least = 1 if fixed[axis] else _LEAST_EDGE if chunks is not None else 2 * _LEAST_EDGE
        edges.append(min(-(-least // chunk) * chunk, length))
    while itemsize * math.prod(edges) > _MOST_BYTES:
        longest = edges.index(max(edges))
        edges[longest] = -(-edges[longest] // 2)
    return edges


def _place(array: Any) -> str:
    """Returns the place of a memmap's first voxel in its file, as a text: slices share the file and its offset."""
    import numpy

    base = array
    while base is not None and not isinstance(base, mmap.mmap):
        base = getattr(base, "base", None)
    if base is None:
        return ""
    begin = numpy.frombuffer(base, dtype="uint8").__array_interface__["data"][0]
    return f", place {array.__array_interface__['data'][0] - begin}"


def _state(array: Any) -> tuple[str, list[str], list[str]]:
    """Returns a text that tells the array from others of its files, and these files and folders."""
    filename = getattr(array, "filename", None)  # numpy.memmap
    if filename is not None and hasattr(array, "__array_interface__"):
        text = f"offset {getattr(array, 'offset', 0)}{_place(array)}, type {array.dtype.str}, strides {array.strides}"
        return text, [os.fspath(filename)], []
    file = getattr(array, "file", None)  # h5py
    if file is not None and isinstance(getattr(file, "filename", None), str):
        return str(getattr(array, "name", "")), [file.filename], []
    store = getattr(array, "store", None)  # zarr
    path = getattr(store, "path", None) or getattr(store, "root", None)
    if path is not None and os.path.isdir(os.fspath(path)):
        return str(getattr(array, "path", "")), [], [os.fspath(path)]
    return "", [], []


def _matrix(axes: str, spacing: Any, affine: Any) -> list[float]:
    if affine is not None:
        if spacing is not None:
            raise ValueError("affine: contradicts spacing; give one of them")
        rows = [[float(value) for value in row] for row in affine]
        if len(rows) == 3:
            rows.append([0.0, 0.0, 0.0, 1.0])
        if len(rows) != 4 or any(len(row) != 4 for row in rows):
            raise ValueError("affine: expected 4 x 4 or 3 x 4 numbers")
        if rows[3] != [0.0, 0.0, 0.0, 1.0]:
            raise ValueError(f"affine: expected 0, 0, 0, 1 in the last row (found {rows[3]}); a transposed matrix has this")
        return [value for row in rows for value in row]
    edges = dict.fromkeys("xyz", 1.0)
    if spacing is not None:
        spatial = [axis for axis in axes if axis in "xyz"]
        values = [float(value) for value in spacing] if hasattr(spacing, "__iter__") else []
        if len(values) != len(spatial) or not all(value > 0 for value in values):
            raise ValueError(f"spacing: expected {len(spatial)} positive numbers, along {', '.join(spatial)}")
        edges.update(zip(spatial, values))
    out = [0.0] * 16
    for i, axis in enumerate("xyz"):
        out[5 * i] = edges[axis]
    out[15] = 1.0
    return out


def _checked_axes(axes: str | None, array: Any, shape: Sequence[int]) -> str:
    out: str = "zyx"[-len(shape) :]
    named = "".join(map(str, getattr(array, "dims", ())))  # xarray
    if len(named) == len(shape) and set(named) <= set("xyzct"):
        out = named
    if axes:
        out = axes
    if len(out) != len(shape) or len(set(out)) != len(out) or not {"x", "y"} <= set(out) <= set("xyzct"):
        raise ValueError(
            f"axes: expected a letter of x, y, z, c, t for each of {len(shape)} axes, with x and y (found {out!r})"
        )
    return out


def _checked_index(word: str, index: int | None, axes: str, shape: Sequence[int]) -> int:
    axis = axes.find(word[0])
    if index is None:
        return 0
    if axis < 0:
        raise wrong_word(word, f"needs an axis {word[0]}", f"axes {axes!r}", "name all axes, or leave it out")
    return whole_number(word, index, 0, shape[axis] - 1)


def _unmasked(array: Any) -> Any:
    """Returns an array of NumPy without its mask. A masked voxel has no value, so it is refused."""
    import numpy

    if not isinstance(array, numpy.ma.MaskedArray):
        return array
    masked = int(numpy.ma.count_masked(array))
    if masked:
        raise wrong_word(
            "array", "expected a value for each voxel", f"{masked} masked", "array.filled(VALUE) gives them one"
        )
    return array.data


def source_of(
    array: Any,
    *,
    axes: str | None,
    spacing: Any,
    affine: Any,
    unit: str,
    frame: str,
    labels: bool,
    channel: int | None = None,
    time: int | None = None,
    identity: str | None = None,
    **others: Any,
) -> _kiln.ArraySource:
    """Opens an array as a source of a conversion or a volume."""
    import numpy

    if others:
        word, value = next(iter(others.items()))
        raise wrong_word(word, "is no word of an array", repr(value), "leave it out")
    if frame not in ("", "unknown", "RAS", "LPS"):
        raise ValueError(f'frame: expected "RAS" or "LPS", the directions of the world (found {frame!r})')
    array = _unmasked(array)
    shape = [int(length) for length in array.shape]
    axes = _checked_axes(axes, array, shape)
    at: dict[str, Any] = {
        "c": _checked_index("channel", channel, axes, shape),
        "t": _checked_index("time", time, axes, shape),
    }
    dtype = _number_type(array)
    words = _kiln.ArrayWords()
    text, files, trees = _state(array)
    if identity is not None:
        text, files, trees = identity, [], []
    if text:
        text += f", axes {axes}" + "".join(f", {axis} {at[axis]}" for axis in axes if axis in at)
    kind = f"{type(array).__module__.split('.')[0]} {type(array).__name__}" if identity is None else "array"
    words.name = f"{kind}, {text}" if text else kind
    words.known = identity is not None
    words.files, words.trees = files, trees
    words.number = dtype.newbyteorder("=").name
    words.shape = shape
    words.axis_of = [axes.find(axis) for axis in "xyz"]
    words.affine = _matrix(axes, spacing, affine)
    words.unit, words.frame, words.labels = unit, frame, labels
    if isinstance(array, numpy.ndarray) and dtype.name in _IN_PLACE and dtype.isnative:
        view = array[tuple(at.get(axis, slice(None)) for axis in axes)]
        view = view.transpose([[a for a in axes if a in "xyz"].index(axis) for axis in "zyx" if axis in axes])
        return _kiln.ArraySource.in_place(words, view if "z" in axes else view[numpy.newaxis])
    fixed = [axis in at for axis in axes]
    words.fixed = [at.get(axis, 0) for axis in axes]
    words.chunks = _edges(array, shape, fixed, dtype.itemsize)
    native = dtype.newbyteorder("=")

    def read(low: tuple[int, ...], high: tuple[int, ...]) -> Any:
        piece = numpy.asarray(_unmasked(array[tuple(slice(a, b) for a, b in zip(low, high))]))
        expected = tuple(b - a for a, b in zip(low, high))
        if piece.shape != expected:
            raise ValueError(f"a slice of the array has the shape {piece.shape} instead of {expected}")
        return numpy.ascontiguousarray(piece, dtype=native)

    return _kiln.ArraySource.sliced(words, read)
