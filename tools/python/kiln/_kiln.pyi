"""The extension module; for the package's own use."""

from typing import Any, Callable, TypedDict

version: str
job_format: int
Progress = Callable[[str, int, int], Any] | None
Flags = dict[str, list[str | bytes]]

class Error(Exception):
    code: str
    path: str | None

class Warning(UserWarning): ...

Shape = tuple[int, int, int]

class Facts(TypedDict):
    path: str
    shape: Shape
    type: str
    affine: list[tuple[float, float, float, float]]
    spacing: tuple[float, float, float]
    unit: str
    frame: str
    levels: tuple[Shape, ...]
    range: tuple[float, float] | None
    nan_count: int
    histogram: tuple[float, float, list[int]]
    labels: dict[int, int] | None

class JobWords:
    def __init__(self, json: str, flags: Flags, function: str) -> None: ...

class MoreVolumes:
    def __init__(self, added: list[Volume], labels: list[Volume], functions: list[str]) -> None: ...

class ArrayWords:
    name: str
    number: str
    shape: list[int]
    chunks: list[int]
    fixed: list[int]
    axis_of: list[int]
    affine: list[float]
    unit: str
    frame: str
    labels: bool
    known: bool
    files: list[str]
    trees: list[str]

class ArraySource:
    @staticmethod
    def in_place(words: ArrayWords, array: Any) -> ArraySource: ...
    @staticmethod
    def sliced(words: ArrayWords, read: Callable[[tuple[int, ...], tuple[int, ...]], Any]) -> ArraySource: ...

class ConvertWords:
    memory: str
    command: str
    brick_size: int
    overwrite: bool
    resume: bool
    half: bool
    labels: bool
    levels: int
    threads: int

class Floats:
    """A buffer of float32."""

class Picture:
    views: int
    frame: int
    job: str
    def size(self, view: int) -> tuple[int, int]: ...
    def colors(self, view: int) -> Floats: ...
    def planes(self, view: int) -> dict[str, Floats]: ...
    def srgb(self, view: int) -> bytearray: ...
    def png(self, view: int) -> bytes: ...
    def save(self, view: int, path: str, flags: Flags) -> None: ...

class Volume:
    @staticmethod
    def open_file(
        path: str, words: dict[str, str | bytes], store: str, labels: bool, memory: str, progress: Progress
    ) -> Volume: ...
    @staticmethod
    def open_array(source: ArraySource, brick_size: int, memory: str, progress: Progress) -> Volume: ...
    def facts(self) -> Facts: ...
    def read(self, level: int, box: list[tuple[int, int]], progress: Progress) -> bytearray: ...
    def frames(self, words: JobWords) -> list[int]: ...
    def draw(self, words: JobWords, more: MoreVolumes, frame: int | None, progress: Progress) -> Picture: ...

class Frames:
    count: int
    @staticmethod
    def of_file(path: str, store: str) -> Frames: ...
    @staticmethod
    def of_text(json: str, store: str, volumes: list[Volume]) -> Frames: ...
    def next(self, progress: Progress) -> Picture | None: ...
    def run(self, resume: bool, checkpoint: bool, progress: Progress) -> tuple[list[int], list[int], list[int], str]: ...

class Viewer:
    address: str
    def __init__(
        self, volume: Volume, words: JobWords, more: MoreVolumes, job_file: str, title: str, port: int
    ) -> None: ...
    def stop(self) -> None: ...

def flags() -> list[tuple[str, str, str, str, str]]: ...
def convert_file(
    path: str, words: dict[str, str | bytes], out: str, options: ConvertWords, progress: Progress
) -> dict[str, Any]: ...
def convert_array(source: ArraySource, out: str, options: ConvertWords, progress: Progress) -> dict[str, Any]: ...
