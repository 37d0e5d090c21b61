"""Volumes: stores, files and arrays."""

from __future__ import annotations

import operator
import os
from typing import TYPE_CHECKING, Any, Callable, Iterator, Sequence

from kiln import _kiln
from kiln._arrays import is_array, source_of
from kiln._errors import path_of, whole_number, wrong_word
from kiln._functions import TransferFunction
from kiln._image import Image
from kiln._words import job_words, json_text, points_text, source_texts, text_of

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

Progress = Callable[[str, int, int], Any]
Box = Sequence[Sequence[int]]

_KINDS = {"u": "uint", "i": "int", "f": "float"}


class Volume:
    """An open volume; made by kiln.open. Threads may use one volume at once: they draw in turn, on all cores."""

    report: dict[str, Any] | None = None
    """What kiln.convert did to make the volume: voxels, bricks, buffer_bytes, decodings, seconds, ...; else None."""

    def __init__(self, volume: _kiln.Volume):
        self._volume = volume
        self._facts = volume.facts()

    @property
    def path(self) -> str:
        """The store's folder; "array" for an array."""
        return self._facts["path"]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Voxels along z, y, x."""
        return self._facts["shape"]

    @property
    def ndim(self) -> int:
        return 3

    @property
    def dtype(self) -> "numpy.dtype[Any]":
        """The type of voxels."""
        import numpy

        name = self._facts["type"]  # "u16"
        return numpy.dtype(_KINDS[name[0]] + name[1:])

    @property
    def affine(self) -> "NDArray[Any]":
        """World (x, y, z, 1) from voxel (x, y, z, 1). shape: (4, 4). unit: `unit`."""
        import numpy

        return numpy.array(self._facts["affine"])

    @property
    def spacing(self) -> tuple[float, float, float]:
        """Lengths of a voxel's edges along z, y, x. unit: `unit`."""
        return self._facts["spacing"]

    @property
    def unit(self) -> str:
        """The unit of length in the world, such as "mm"; empty if unknown."""
        return self._facts["unit"]

    @property
    def frame(self) -> str:
        """The patient's directions of the world's axes: "RAS", "LPS" or "unknown"."""
        return self._facts["frame"]

    @property
    def levels(self) -> tuple[tuple[int, int, int], ...]:
        """The shapes of all levels of the pyramid, the finest first."""
        return self._facts["levels"]

    @property
    def range(self) -> tuple[float, float] | None:
        """The least and the greatest value; None if all are NaN."""
        return self._facts["range"]

    @property
    def labels(self) -> dict[int, int] | None:
        """Voxels of each label, for a volume of labels of 8 or 16 bits, or of labels from 0 to 65534; else None."""
        return self._facts["labels"]

    def histogram(self) -> "tuple[NDArray[Any], NDArray[Any]]":
        """Returns counts of voxels and edges of bins, as numpy.histogram. shape: (n,) and (n + 1,)."""
        import numpy

        low, high, counts = self._facts["histogram"]
        return numpy.array(counts, dtype=numpy.uint64), numpy.linspace(low, high, len(counts) + 1)

    def read(self, level: int = 0, box: Box | None = None, progress: Progress | None = None) -> "NDArray[Any]":
        """Reads the voxels of a box of a level: ((z0, z1), (y0, y1), (x0, x1)), by default all.

        shape: (z1 - z0, y1 - y0, x1 - x0), in `dtype`.
        """
        import numpy

        level = operator.index(level)
        if box is None:
            if not 0 <= level < len(self.levels):
                raise IndexError(f"level: expected 0 to {len(self.levels) - 1} (found {level})")
            box = [(0, length) for length in self.levels[level]]
        try:
            (z0, z1), (y0, y1), (x0, x1) = box
            edges = [(operator.index(low), operator.index(high)) for low, high in ((z0, z1), (y0, y1), (x0, x1))]
        except (TypeError, ValueError):
            expected = "3 pairs of whole numbers, ((z0, z1), (y0, y1), (x0, x1))"
            raise ValueError(f"box: expected {expected} (found {box!r})") from None
        data = self._volume.read(level, edges, progress)
        return numpy.frombuffer(data, dtype=self.dtype).reshape([high - low for low, high in edges])

    def __getitem__(self, key: Any) -> Any:
        """Reads voxels of level 0: s[z0:z1, y0:y1, x0:x1], with numbers, steps and ... as in NumPy."""
        keys = list(key) if isinstance(key, tuple) else [key]
        ellipses = [at for at, one in enumerate(keys) if one is Ellipsis]  # arrays among the keys have no ==
        if ellipses:
            keys[ellipses[0] : ellipses[0] + 1] = [slice(None)] * (4 - len(keys))
        if len(keys) > 3:
            raise IndexError(f"a volume has 3 axes (found {len(keys)} indices)")
        keys += [slice(None)] * (3 - len(keys))
        box: list[tuple[int, int]] = []
        inside: list[int | slice] = []
        for axis, (one, length) in enumerate(zip(keys, self.shape)):
            if isinstance(one, slice):
                places = range(length)[one]
                box.append((min(places, default=0), max(places, default=-1) + 1))
                inside.append(slice(None, None, places.step))
            else:
                try:
                    # A mask in NumPy, not the number 0 or 1.
                    if isinstance(one, bool) or getattr(getattr(one, "dtype", None), "kind", "") == "b":
                        raise TypeError
                    place = operator.index(one)
                except TypeError:
                    found = type(one).__name__
                    raise TypeError(f"indices of a volume are whole numbers, slices and ... (found {found})") from None
                if not -length <= place < length:
                    raise IndexError(f"index {place} is out of bounds for axis {axis} of {length} voxels")
                place %= length
                box.append((place, place + 1))
                inside.append(0)
        return self.read(0, box)[tuple(inside)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> "NDArray[Any]":
        if copy is False:
            raise ValueError("the voxels of a volume are read, which is a copy")
        array = self.read()
        return array if dtype is None else array.astype(dtype, copy=False)

    def __len__(self) -> int:
        return self.shape[0]

    def render(self, *, progress: Progress | None = None, **words: Any) -> Image:
        """Draws a picture; `words` are the options of `kiln render` (kiln.options lists them).

        view="front", azimuth=20, fov=30, size=(width, height) in pixels, samples=4, memory="1G",
        aov=["depth", "normal"], and others. A word whose value is a dict is an object of a job: camera={"eye": ...}.
        tf: a preset, points, a file, or kiln.transfer_function(...).
        add, labels: further volumes in the picture, placed by their affines; add_tf: the transfer functions of these.
        progress: called with (step, done, total). Ctrl-C cancels. throws: kiln.Error.
        """
        more, words = more_volumes(words)
        return Image(self._volume.draw(self._job(words), more, None, progress))

    def frames(self, *, progress: Progress | None = None, **words: Any) -> Iterator[Image]:
        """Draws frames one after another, as they are iterated: turntable=60, or a camera with keyframes.

        The words are those of `render`. frames="1,10-20" are some of the frames.
        """
        more, words = more_volumes(words)
        job = self._job(words)
        return (Image(self._volume.draw(job, more, frame, progress)) for frame in self._volume.frames(job))

    def _job(self, words: dict[str, Any]) -> _kiln.JobWords:
        for word in ("output", "deep", "trace"):
            if words.get(word):
                raise TypeError(f"{word}: a picture in memory has no file; save it, or use kiln.render")
        return job_words(words, range_of(self))

    def __repr__(self) -> str:
        z, y, x = self.shape
        return f"<kiln.Volume {self.path}: {z} x {y} x {x} voxels of {self.dtype}, {len(self.levels)} levels>"


def shown_path(volume: Volume) -> str:
    """Returns the volume's path as UTF-8; other bytes are escaped, as in names that Kiln writes."""
    return os.fsencode(volume.path).decode("utf-8", "backslashreplace")


def range_of(volume: Volume) -> tuple[float, float]:
    """Returns the values that a colour map spans; in a volume without values all are alike."""
    return volume.range or (0.0, 1.0)


def more_volumes(words: dict[str, Any]) -> tuple[_kiln.MoreVolumes, dict[str, Any]]:
    """Returns the volumes among the words of a picture, and the other words."""
    words = dict(words)

    def listed(word: str) -> list[Any]:
        value = words.pop(word, None)
        return [] if value is None else list(value) if isinstance(value, (list, tuple)) else [value]

    def opened(volume: Any, labels: bool) -> Volume:
        return volume if isinstance(volume, Volume) else open(volume, labels=labels)

    def text(function: Any, volume: Volume | None) -> str:
        if isinstance(function, dict):
            return json_text(function)
        if not isinstance(function, TransferFunction):
            return points_text(function) or text_of(function)
        # A function without a volume is refused later, by the number of functions.
        return function.json(range_of(volume) if volume is not None else (0.0, 1.0)) or function.name

    added, labels = [opened(one, False) for one in listed("add")], [opened(one, True) for one in listed("labels")]
    functions = [words.pop("add_tf")] if points_text(words.get("add_tf")) else listed("add_tf")
    volumes: list[Volume | None] = [*added, *labels]
    volumes += [None] * (len(functions) - len(volumes))
    texts = [text(function, volume) for function, volume in zip(functions, volumes)]
    return _kiln.MoreVolumes([one._volume for one in added], [one._volume for one in labels], texts), words


def open(
    source: Any,
    *,
    labels: bool = False,
    memory: str | int = "2G",
    progress: Progress | None = None,
    store: str | os.PathLike[str] | None = None,
    axes: str | None = None,
    spacing: Any = None,
    affine: Any = None,
    unit: str = "",
    frame: str = "",
    brick_size: int | None = None,
    **words: Any,
) -> Volume:
    """Opens a store, a volume file or an array.

    A volume file becomes a store beside it first, or in the folder `store`; `words` describe the file as options of
    `kiln convert` do: dims, type, channel, time, .... An array (anything with shape, dtype and slices) is drawn without a
    file: a NumPy array in place, anything else sliced brick by brick; coarser levels are made within `memory`.

    axes: the array's, by default its `dims` (xarray) or "zyx"; c and t are chosen by channel and time. spacing: along x, y
    and z in the order of `axes`, of a file along z, y and x. affine: world (x, y, z) from voxel (x, y, z), 4 x 4. unit,
    frame: of the world, "mm" and "RAS". labels: values are labels. brick_size: by default 128. The array must not change.
    All but spacing, unit and labels are for arrays: a file has its own, and unit is for a file that states none.
    """
    if isinstance(source, Volume):
        raise wrong_word("source", "is a file or an array", "an open volume", "give its file, or slice it: volume[...]")
    if is_array(source):
        if store is not None:
            raise wrong_word("store", "is for files", "an array", "leave it out; kiln.convert makes a store of an array")
        described = source_of(
            source, axes=axes, spacing=spacing, affine=affine, unit=unit, frame=frame, labels=labels, **words
        )
        edge = 128 if brick_size is None else whole_number("brick_size", brick_size, 8, 4096)
        return Volume(_kiln.Volume.open_array(described, edge, text_of(memory), progress))
    refuse_words_of_arrays(axes=axes, frame=frame, brick_size=brick_size)
    texts = file_texts(dict(words, unit=unit or None), spacing, affine)
    memory_text, path = text_of(memory), source_path(source)
    return Volume(_kiln.Volume.open_file(path, texts, store_folder(store), labels, memory_text, progress))


_REMEDIES = {
    "axes": "leave it out; spacing is along z, y, x",
    "identity": "leave it out; the state of the file is compared",
    "brick_size": "leave it out; kiln.convert makes a store with other bricks",
}


def refuse_words_of_arrays(**words: Any) -> None:
    """throws: kiln.Error for a word that a file cannot take."""
    for word, value in words.items():
        if value not in (None, ""):
            raise wrong_word(word, "is for arrays", "a file", _REMEDIES.get(word, "leave it out; a file has its own"))


def source_path(source: Any) -> Any:
    """Returns the name of a file or store. throws: kiln.Error for other values."""
    return path_of("source", source, "is a file or an array", "give the name of a file, or an array")


def store_folder(store: str | os.PathLike[str] | None) -> Any:
    """Returns the folder for stores of volume files; empty for the folder of each file. throws: kiln.Error."""
    if store is None:
        return os.environ.get("KILN_STORE_DIR", "")
    return path_of("store", store, "is a folder", "name the folder for stores of volume files, or leave it out")


def file_texts(words: dict[str, Any], spacing: Any, affine: Any) -> dict[str, str]:
    """Returns the words of a file as texts; the command line has spacings along x, y, z."""
    if affine is not None:
        raise ValueError("affine: is for arrays (found a file); a file has its own, or spacing")
    if spacing is not None and not isinstance(spacing, str):
        edges = list(spacing)
        if len(edges) != 3:
            raise ValueError(f"spacing: expected three numbers, along z, y, x (found {len(edges)})")
        spacing = edges[::-1]
    return source_texts(dict(words, spacing=spacing))
