"""Jobs of any kind, and their frames."""

from __future__ import annotations

import json
import os
from typing import Any, Iterator, NamedTuple

from kiln import _kiln
from kiln._errors import wrong_word
from kiln._functions import TransferFunction
from kiln._image import Image
from kiln._volume import Progress, Volume, range_of, shown_path, store_folder


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


def _is_utf8(text: str) -> bool:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:  # a name with bytes that are no UTF-8, which os.fsdecode made
        return False
    return True


def _plain(value: Any, volumes: list[Volume], drawn: Any = None) -> Any:
    """Returns a job's value as JSON has it, and collects open volumes. `drawn`: the volume of the object around it."""
    if isinstance(value, Volume):
        volumes.append(value)
        return shown_path(value)
    if isinstance(value, TransferFunction):
        text = value.json(range_of(drawn) if isinstance(drawn, Volume) else None)
        return json.loads(text) if text else value.name
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str) and not _is_utf8(value):
        raise wrong_word("job", "is UTF-8", ascii(value), "open such a volume, and rename other files")
    if isinstance(value, dict):
        drawn = value.get("volume", drawn)
        return {key: _plain(inner, volumes, drawn) for key, inner in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    return [_plain(inner, volumes, drawn) for inner in value] if isinstance(value, (list, tuple)) else value


def render(
    job: dict[str, Any] | str | os.PathLike[str],
    *,
    progress: Progress | None = None,
    store: str | os.PathLike[str] | None = None,
) -> Frames:
    """Returns the frames of a job, drawn as they are iterated.

    job: the file of a job, or its object (the manual's page jobs.md); its volumes are names of stores and files, or
    open volumes, then all of them. A colour map without `range` needs an open volume. A frame's files are written, if the
    job names any ("output", "outputs"), when the frame is drawn; the video after the last frame. store: folder for stores
    of volume files.
    progress: called with (step, done, total). throws: kiln.Error.
    """
    folder = store_folder(store)
    if not isinstance(job, dict):
        return Frames(_kiln.Frames.of_file(os.fspath(job), folder), progress)
    volumes: list[Volume] = []
    text = json.dumps({"kiln": _kiln.job_format, **_plain(job, volumes)})
    return Frames(_kiln.Frames.of_text(text, folder, [volume._volume for volume in volumes]), progress)
