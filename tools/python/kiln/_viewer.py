"""The viewer in a browser."""

from __future__ import annotations

import html
import os
import weakref
from typing import Any

from kiln import _kiln
from kiln._errors import path_of, whole_number
from kiln._volume import Volume, more_volumes, open, range_of, shown_path
from kiln._words import job_words


class Viewer:
    """A running viewer; made by kiln.view. It runs until `stop`, or until Python ends. A notebook shows its page."""

    def __init__(self, viewer: _kiln.Viewer, height: int):
        self._viewer = viewer
        self._height = height
        weakref.finalize(self, viewer.stop)  # at Python's end, too

    @property
    def url(self) -> str:
        """The address for a browser of this machine. It holds the token: show it to nobody else."""
        return self._viewer.address

    def stop(self) -> None:
        """Ends the viewer."""
        self._viewer.stop()

    def __enter__(self) -> "Viewer":
        return self

    def __exit__(self, *failure: Any) -> None:
        self.stop()

    def _repr_html_(self) -> str:
        return f'<iframe src="{html.escape(self.url)}" width="100%" height="{self._height}" style="border:0"></iframe>'

    def __repr__(self) -> str:
        return f"<kiln.Viewer {self.url}>"


def view(
    volume: Any,
    *,
    job: str | os.PathLike[str] | None = None,
    port: int = 0,
    height: int = 640,
    **words: Any,
) -> Viewer:
    """Starts the viewer of a volume, or of what kiln.open opens, and returns it: its `url`, or an iframe in a notebook.

    job: the only file that the viewer writes, ending in .json. port: of 127.0.0.1; 0 takes a free one. height: of the
    iframe, in pixels. words: the first look, as for Volume.render.
    """
    if not isinstance(volume, Volume):
        volume = open(volume)
    title = os.path.basename(os.path.normpath(shown_path(volume)))
    # The working directory may change while the viewer runs.
    name = ""
    if job is not None:
        name = os.path.abspath(path_of("job", job, "is a file", "name the file to write, such as 'look.json'"))
    more, words = more_volumes(words)
    port = whole_number("port", port, 0, 65535)
    viewer = _kiln.Viewer(volume._volume, job_words(words, range_of(volume)), more, name, title, port)
    return Viewer(viewer, height)
