"""Texts for failed tests: pins and signals with names, codes and words as 16#."""

from __future__ import annotations

from collections.abc import Sequence

from structured_text.engines.base import Value

#: Number of words in a telegram: the code or status, and fifteen data words.
_TELEGRAM = 16
_IN_16 = ("ErrorID", "AlarmGroup", "AlarmCategory", "Applied", "holder")


def written(one: Value, name: str = "") -> str:
    """Return a value in the form of the manual and docs/reference/errors.md, with words as 16#."""
    is_word = name in _IN_16 or name.startswith("word ")
    return f"16#{one:04X}" if is_word or (_is_word(one) and one > 0xFF) else repr(one)


def differences(names: Sequence[str], got: Sequence[Value], expected: Sequence[Value]) -> str:
    """Return the differences as `Busy is True, not False`; an empty text without differences."""
    return "; ".join(
        f"{name} is {written(one, name)}, not {written(two, name)}"
        for name, one, two in zip(names, got, expected, strict=True)
        if one != two
    )


def hexadecimal_comparison(op: str, left: Value, right: Value) -> list[str] | None:
    """Return the lines that explain a failed comparison of codes, ErrorIDs or words, else None."""
    if _is_word(left) and _is_word(right) and max(left, right) > 0xFF:
        return [f"{written(left)} {op} {written(right)}"]
    if op == "==" and _are_words(left) and _are_words(right) and len(left) == len(right):
        whole = len(left) == _TELEGRAM
        pairs = enumerate(zip(left, right, strict=True))
        return ["different words:"] + [
            f"  [{k}]{f' (byte {2 * k})' * whole}: 16#{one:04X}, not 16#{two:04X}"
            for k, (one, two) in pairs
            if one != two
        ]
    return None


def _is_word(one: Value) -> bool:
    return isinstance(one, int) and not isinstance(one, bool) and 0 <= one <= 0xFFFF


def _are_words(some: Value) -> bool:
    """Return whether the values are words. Small numbers alone are shown in decimal."""
    several = isinstance(some, (list, tuple)) and len(some) > 1
    return several and all(map(_is_word, some)) and max(some) > 0xFF
