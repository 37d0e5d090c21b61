"""The words of a call as options of the command line, and as keys of a job."""

from __future__ import annotations

import functools
import json
import os
from typing import Any, NamedTuple

from kiln import _kiln
from kiln._errors import wrong_word
from kiln._functions import TransferFunction


class Option(NamedTuple):
    """An option of pictures: its word in Python, its flag, the values it takes, and its help."""

    word: str
    flag: str
    arguments: str  # "none", "one", "several" or "list"
    group: str
    values: str
    help: str


@functools.lru_cache(maxsize=None)
def _by_word() -> dict[str, Option]:
    rows = (Option(flag[2:].replace("-", "_"), flag, *rest) for flag, *rest in _kiln.flags())
    return {row.word: row for row in rows}


def options() -> list[Option]:
    """Returns all options of pictures, in the order of `kiln render --help`."""
    return list(_by_word().values())


def text_of(value: Any) -> str:
    """Returns a value as the command line writes it: (1, 2.5) is "1,2.5"."""
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:  # a number of NumPy's
        value = value.item()
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, str):
        return value
    if isinstance(value, (bytes, os.PathLike)):
        return os.fsdecode(value)
    if isinstance(value, float):
        return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    if isinstance(value, int):
        return str(value)
    if getattr(value, "ndim", 1) > 1 or not hasattr(value, "__iter__"):  # volumes, too
        raise TypeError(
            f"expected a text, a number or a sequence of these (found {type(value).__name__}); "
            "a volume is named by its path"
        )
    return ",".join(text_of(item) for item in value)


def _is_utf8(text: str) -> bool:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:  # a name with bytes that are no UTF-8, which os.fsdecode made
        return False
    return True


def _job_value(value: Any, volumes: list[Any] | None, drawn: Any = None) -> Any:
    """Returns a job's value as JSON has it. `drawn`: the volume of the object around the value."""
    from kiln._volume import Volume, range_of, shown_path  # which import this module

    if isinstance(value, Volume) and volumes is not None:
        volumes.append(value)
        return shown_path(value)
    if isinstance(value, TransferFunction):
        text = value.json(range_of(drawn) if isinstance(drawn, Volume) else None)
        return json.loads(text) if text else value.name
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    elif hasattr(value, "tolist"):  # arrays and numbers of NumPy
        value = value.tolist()
    if isinstance(value, str) and not _is_utf8(value):
        raise wrong_word("job", "is UTF-8", ascii(value), "open such a volume, and rename other files")
    if isinstance(value, dict):
        drawn = value.get("volume", drawn)
        return {key: _job_value(inner, volumes, drawn) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_job_value(inner, volumes, drawn) for inner in value]
    if value is None or isinstance(value, (str, int, float)):
        return value
    raise TypeError(f"a job has texts, numbers, lists and dicts (found {type(value).__name__})")


def json_text(value: Any, volumes: list[Any] | None = None) -> str:
    """Returns the JSON of a job, or of an object of a job. Open volumes are collected in `volumes`, else refused."""
    return json.dumps(_job_value(value, volumes))


def _is_json(value: Any) -> bool:
    return isinstance(value, dict) or (
        isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(item, dict) for item in value)
    )


def _key_of(word: str) -> str:
    """Returns the key of a job for the word of an option: `colorBy` for `color_by`, `lights` for `light`."""
    first, *others = ("lights" if word == "light" else word).split("_")
    return first + "".join(part.capitalize() for part in others)


def points_text(points: Any) -> str | None:
    """Returns points such as [(1000, 0), (1300, 0.5, "orange")] as --tf writes them; None for other values."""
    if getattr(points, "ndim", 0) == 2 and hasattr(points, "tolist"):
        points = points.tolist()
    if not isinstance(points, (list, tuple)) or not points:
        return None
    if not all(isinstance(point, (list, tuple)) and point for point in points):
        return None
    if any(isinstance(point[0], (list, tuple)) for point in points):  # a list of such points
        return None
    if any(not 2 <= len(point) <= 3 for point in points):
        raise wrong_word("tf", "a point is (value, opacity) or (value, opacity, color)", repr(points), "give such points")
    return ",".join(":".join(text_of(part) for part in point) for point in points)


def _is_one(row: Option, value: Any) -> bool:
    """Returns whether a list holds the numbers of one value, such as [1, 0, 0, 0] of a clip plane."""
    if row.arguments != "several":
        return row.arguments == "one"
    return "," in row.values and len(value) > 0 and not any(isinstance(item, (str, list, tuple)) for item in value)


def _text_of_word(word: str, value: Any) -> str | bytes:
    """Returns the text of a word; bytes for a name of a file whose bytes are no UTF-8."""
    try:
        text = text_of(value)
    except TypeError as failure:
        raise TypeError(f"{word}: {failure}") from None
    return text if _is_utf8(text) else os.fsencode(text)


def _is_set(word: str, value: Any) -> bool:
    """Returns whether a flag without an argument is given. Texts, such as "off", are refused."""
    if isinstance(value, (str, bytes)):
        raise wrong_word(word, "takes True or False", repr(value), "give one of these")
    return bool(value)


def flag_texts(words: dict[str, Any]) -> dict[str, list[str | bytes]]:
    """Returns words as texts of flags."""
    known = _by_word()
    flags: dict[str, list[str | bytes]] = {}
    for word, value in words.items():
        row = known.get(word)
        if value is None:
            continue
        if row is None:
            flags["--" + word.replace("_", "-")] = [""]  # refused with the nearest option
        elif row.arguments == "none":
            if _is_set(word, value):
                flags[row.flag] = [""]
        elif isinstance(value, (list, set)) and not _is_one(row, value):
            flags[row.flag] = [_text_of_word(word, item) for item in value]
        else:
            flags[row.flag] = [_text_of_word(word, value)]
    return flags


def job_words(words: dict[str, Any], value_range: tuple[float, float] | None = None) -> _kiln.JobWords:
    """Divides words into flags and objects of a job. `value_range` stretches a colour map without values."""
    words = dict(words)
    function = ""
    if isinstance(words.get("tf"), TransferFunction):
        tf = words.pop("tf")
        function = tf.json(value_range)
        if not function:
            words["tf"] = tf.name
    elif isinstance(words.get("tf"), dict):
        function = json_text(words.pop("tf"))
    elif (text := points_text(words.get("tf"))) is not None:
        words["tf"] = text
    objects = {_key_of(word): words.pop(word) for word, value in list(words.items()) if _is_json(value)}
    if isinstance(objects.get("lights"), dict):
        objects["lights"] = [objects["lights"]]
    text = json_text({"kiln": _kiln.job_format, "volume": "volume", **objects}) if objects else ""
    return _kiln.JobWords(text, flag_texts(words), function)


def source_texts(words: dict[str, Any]) -> dict[str, str | bytes]:
    """Returns the words of a volume file as texts."""
    return {word: _text_of_word(word, value) for word, value in words.items() if value is not None}
