"""The words of a call as options of the command line, and as keys of a job."""

from __future__ import annotations

import functools
import json
import os
from typing import Any, NamedTuple

from kiln import _kiln
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
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
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


def _json_value(value: Any) -> Any:
    """Returns values that JSON lacks: arrays and numbers of NumPy, paths, transfer functions."""
    if isinstance(value, TransferFunction):
        text = value.json()
        return json.loads(text) if text else value.name
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"an object of a job has texts, numbers, lists and dicts (found {type(value).__name__})")


def json_text(value: Any) -> str:
    """Returns the JSON of a dict among the words."""
    return json.dumps(value, default=_json_value)


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
    return ",".join(":".join(text_of(part) for part in point) for point in points)


def _is_one(row: Option, value: Any) -> bool:
    """Returns whether a list holds the numbers of one value, such as [1, 0, 0, 0] of a clip plane."""
    if row.arguments != "several":
        return row.arguments == "one"
    return "," in row.values and len(value) > 0 and not any(isinstance(item, (str, list, tuple)) for item in value)


def _text_of_word(word: str, value: Any) -> str:
    try:
        return text_of(value)
    except TypeError as failure:
        raise TypeError(f"{word}: {failure}") from None


def flag_texts(words: dict[str, Any]) -> dict[str, list[str]]:
    """Returns words as texts of flags."""
    known = _by_word()
    flags: dict[str, list[str]] = {}
    for word, value in words.items():
        row = known.get(word)
        if value is None:
            continue
        if row is None:
            flags["--" + word.replace("_", "-")] = [""]  # refused with the nearest option
        elif row.arguments == "none":
            if value:
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


def source_texts(words: dict[str, Any]) -> dict[str, str]:
    """Returns the words of a volume file as texts."""
    return {word: _text_of_word(word, value) for word, value in words.items() if value is not None}
