"""Conversion to stores."""

from __future__ import annotations

import os
from typing import Any

from kiln import _kiln
from kiln._arrays import is_array, source_of
from kiln._errors import path_of, whole_number, wrong_word
from kiln._volume import Progress, Volume, file_texts, open, refuse_words_of_arrays, source_path
from kiln._words import text_of


def convert(
    source: Any,
    out: str | os.PathLike[str],
    *,
    spacing: Any = None,
    affine: Any = None,
    axes: str | None = None,
    unit: str = "",
    frame: str = "",
    labels: bool = False,
    memory: str | int = "2G",
    overwrite: bool = False,
    resume: bool = False,
    half: bool = False,
    levels: int = 0,
    brick_size: int = 128,
    threads: int = 0,
    identity: str | None = None,
    progress: Progress | None = None,
    **words: Any,
) -> Volume:
    """Converts a file or an array to a store, and opens the store.

    source: a path, as for `kiln convert` (`words` describe the file: dims, type, channel, time, ...), or anything with
    shape, dtype and slices: NumPy arrays and memmaps, h5py, zarr, dask. It is read box by box, in whole chunks of its own,
    each once where `memory` has room for the chunks that neighbouring bricks share.

    axes, spacing, affine, unit, frame, labels: as for kiln.open. levels: the most levels, 0 for all. half: round to half
    floats.
    resume: continue an interrupted conversion. Kiln compares the state of the files of memmap, h5py and zarr; for other
    arrays `identity` is a text that is another for other voxels.
    progress: called with (step, done, total). Ctrl-C cancels and keeps finished bricks. throws: kiln.Error, and what the
    array raises.
    """
    options = _kiln.ConvertWords()
    options.memory = text_of(memory)
    options.brick_size = whole_number("brick_size", brick_size, 8, 4096)
    options.levels, options.threads = whole_number("levels", levels, 0, 64), whole_number("threads", threads, 0, 4096)
    options.overwrite, options.resume, options.half, options.labels = overwrite, resume, half, labels
    target = path_of("out", out, "is a folder", "name the store to make, such as 'head.kiln'")
    if isinstance(source, Volume):
        raise wrong_word("source", "is a file or an array", "an open volume", "give its file, or slice it: volume[...]")
    if is_array(source):
        options.command = f"kiln.convert({type(source).__name__}, {target!r})"
        described = source_of(
            source,
            axes=axes,
            spacing=spacing,
            affine=affine,
            unit=unit,
            frame=frame,
            labels=labels,
            identity=identity,
            **words,
        )
        report = _kiln.convert_array(described, target, options, progress)
    else:
        path = source_path(source)
        options.command = f"kiln.convert({path!r}, {target!r})"
        refuse_words_of_arrays(axes=axes, frame=frame, identity=identity)
        texts = file_texts(dict(words, unit=unit or None), spacing, affine)
        report = _kiln.convert_file(path, texts, target, options, progress)
    volume = open(target, memory=memory)
    volume.report = report
    return volume
