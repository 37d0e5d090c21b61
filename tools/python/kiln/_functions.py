"""Transfer functions."""

from __future__ import annotations

import builtins
import json as _json
import numbers
from typing import Any, Callable, Iterable, Sequence

from kiln import _kiln
from kiln._errors import wrong_word

_SAMPLES = 64  # of a colour map


class TransferFunction:
    """Colour and opacity of each value; made by kiln.transfer_function."""

    def __init__(self, name: str = "", points: Iterable[dict[str, Any]] = (), stretched: bool = False):
        self.name = name
        self.points = [dict(point) for point in points]
        self._stretched = stretched

    def json(self, value_range: tuple[float, float] | None = None) -> str:
        """Returns the function as a job's JSON; an empty text for a preset or a file.

        value_range: the values of the first and last colour, for a colour map made without `range`.
        throws: kiln.Error if such a map has no values.
        """
        if not self.points:
            return ""
        points = self.points
        if self._stretched:
            if value_range is None:
                raise wrong_word("range", "a colour map spans values", "no open volume", "give range to transfer_function")
            low, high = value_range
            points = [{**point, "value": low + (high - low) * point["value"]} for point in points]
        return _json.dumps({"kiln": _kiln.job_format, "points": points})

    def save(self, path: Any) -> None:
        """Writes a file for --tf. A preset has no file: use `kiln tf --json`."""
        if not self.points:
            raise ValueError(f"{self.name} is a preset or a file; kiln tf --json writes its points")
        text = self.json()
        with open(path, "w", encoding="utf-8") as file:
            file.write(text + "\n")

    def __repr__(self) -> str:
        return f"kiln.TransferFunction({self.name!r}" + (f", {len(self.points)} points)" if self.points else ")")


def _color(color: Any) -> Any:
    return color if isinstance(color, str) else [float(channel) for channel in tuple(color)[:3]]


def _opacities(opacity: Any, places: Sequence[float]) -> list[float]:
    if callable(opacity):
        return [float(opacity(place)) for place in places]
    if isinstance(opacity, numbers.Real):
        return [float(opacity)] * len(places)
    steps = [float(value) for value in opacity]
    if not steps:
        raise wrong_word("opacity", "expected a number, numbers or a function", "no number", "give at least one")
    out = []
    for place in places:
        at = place * (len(steps) - 1)
        low = min(int(at), len(steps) - 2)
        out.append(steps[low] + (steps[low + 1] - steps[low]) * (at - low))
    return out


def transfer_function(
    source: Any,
    range: tuple[float, float] | None = None,
    opacity: float | Sequence[float] | Callable[[float], float] = (0.0, 0.2),
) -> TransferFunction:
    """Makes a transfer function for the word tf.

    source: a preset, points as text or a file, as for --tf; points (value, opacity) or (value, opacity, color), the
    color a name, "#rrggbb" or sRGB numbers from 0 to 1; or a colour map of Matplotlib, a callable from 0..1 to RGBA.
    range: values of the first and last colour of a colour map; by default the volume's.
    opacity: of a colour map, per mean spacing of voxels: a number, numbers in equal steps, or a function of 0..1.
    """
    if isinstance(source, TransferFunction):
        return source
    if isinstance(source, str) or hasattr(source, "__fspath__"):
        return TransferFunction(name=str(source))
    if callable(source):
        places = [i / (_SAMPLES - 1) for i in builtins.range(_SAMPLES)]
        colors = [_color(source(place)) for place in places]
        alphas = _opacities(opacity, places)
        low, high = (0.0, 1.0) if range is None else map(float, range)
        return TransferFunction(
            name=getattr(source, "name", "") or "colour map",
            points=[
                {"value": low + (high - low) * place, "color": color, "opacity": alpha}
                for place, color, alpha in zip(places, colors, alphas)
            ],
            stretched=range is None,
        )
    points = [tuple(point) for point in source]
    if not points or any(not 2 <= len(point) <= 3 for point in points):
        expected = "expected points (value, opacity) or (value, opacity, color)"
        raise wrong_word("source", expected, repr(source), "give such points")
    # As in the text of points: a point without a color has that of the point before, or of the first with one.
    color = next((_color(point[2]) for point in points if len(point) > 2), "white")
    out = []
    for point in points:
        color = _color(point[2]) if len(point) > 2 else color
        out.append({"value": float(point[0]), "opacity": float(point[1]), "color": color})
    return TransferFunction(name="points", points=out)
