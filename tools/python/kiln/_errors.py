"""Refusals of words, as the extension module makes them."""

from __future__ import annotations

from kiln import _kiln


def wrong_word(word: str, constraint: str, found: str, remedy: str) -> _kiln.Error:
    """Returns the error of a word that cannot be kept to, with the code "usage"."""
    error = _kiln.Error(f"{word}: {constraint} (found {found}); {remedy}")
    error.code, error.path = "usage", None
    return error
