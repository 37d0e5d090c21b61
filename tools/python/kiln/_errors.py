"""Refusals of words, as the extension module makes them."""

from __future__ import annotations

import operator
import os
from typing import Any

from kiln import _kiln


def wrong_word(word: str, constraint: str, found: str, remedy: str) -> _kiln.Error:
    """Returns the error of a word that cannot be kept to, with the code "usage"."""
    error = _kiln.Error(f"{word}: {constraint} (found {found}); {remedy}")
    error.code, error.path = "usage", None
    return error


def whole_number(word: str, value: Any, low: int, high: int) -> int:
    """Returns a whole number. throws: kiln.Error for other values."""
    try:
        number = operator.index(value)
    except TypeError:
        number = low - 1
    if not low <= number <= high:
        raise wrong_word(word, f"expected a whole number from {low} to {high}", repr(value), "give such a number")
    return number


def path_of(word: str, value: Any, constraint: str, remedy: str) -> Any:
    """Returns the name of a file or folder as text or bytes. throws: kiln.Error for other values."""
    if not isinstance(value, (str, bytes, os.PathLike)):
        raise wrong_word(word, constraint, type(value).__name__, remedy)
    return os.fspath(value)
