"""Jobs of any kind, and their frames."""

from __future__ import annotations

import os
from typing import Any, Iterator, NamedTuple

from kiln import _kiln
from kiln._errors import path_of
from kiln._image import Image
from kiln._volume import Progress, Volume, store_folder
from kiln._words import json_text


class Finished(NamedTuple):
    """The numbers of the frames that were drawn, kept from an earlier run, and failed; the first error."""

    drawn: list[int]
    kept: list[int]
    failed: list[int]
    first_failure: str


class Frames(Iterator[Image]):
    """The frames of a job; made by kiln.render. Each is drawn when it is asked for, from one cache."""

    def __init__(self, frames: _kiln.Frames, progress: Progress | None):
        self._frames = frames
        self._progress = progress

    def __len__(self) -> int:
        """The number of all frames of the job."""
        return self._frames.count

    def __iter__(self) -> "Frames":
        return self

    def __next__(self) -> Image:
        picture = self._frames.next(self._progress)
        if picture is None:
            raise StopIteration
        return Image(picture)

    def run(self, *, resume: bool = False, checkpoint: bool = False) -> Finished:
        """Draws all frames to the job's files and keeps none, as `kiln render JOB.json`; the video, too."""
        return Finished(*self._frames.run(resume, checkpoint, self._progress))


def render(
    job: dict[str, Any] | str | os.PathLike[str],
    *,
    progress: Progress | None = None,
    store: str | os.PathLike[str] | None = None,
) -> Frames:
    """Returns the frames of a job, drawn as they are iterated.

    job: the file of a job, or its object (the manual's page jobs.md); its volumes are names of stores and files, or
    open volumes, then all of them. A colour map without `range` needs an open volume. A frame's files are written, if the
    job names any ("output", "outputs"), when the frame is drawn; the video after the last frame, by ffmpeg, of volumes
    with names. store: folder for stores of volume files.
    progress: called with (step, done, total). throws: kiln.Error.
    """
    folder = store_folder(store)
    if not isinstance(job, dict):
        file = path_of("job", job, "is a dict or a file", "give the job's object, or the name of its file")
        return Frames(_kiln.Frames.of_file(file, folder), progress)
    volumes: list[Volume] = []
    text = json_text({"kiln": _kiln.job_format, **job}, volumes)
    return Frames(_kiln.Frames.of_text(text, folder, [volume._volume for volume in volumes]), progress)
