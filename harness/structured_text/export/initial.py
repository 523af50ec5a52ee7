"""Initial values of the sources: the scalars inside them, and their literals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import datetime
from itertools import groupby, product
from typing import Any

from structured_text.language.resolve import default_scalar
from structured_text.language.scalars import DIGITS
from structured_text.language.types import ArrayType, BlockType, ElementaryType, StructType, Type
from structured_text.language.values import array_length, scalar_to_python

__all__ = ["differing", "is_scalar", "literal", "runs", "zero"]


def is_scalar(kind: Type) -> bool:
    """Return whether a type is elementary or an enumeration."""
    return not isinstance(kind, StructType | ArrayType | BlockType)


def zero(kind: Type) -> Any:
    """Return the default value of a type, for variables without any initial value."""
    if isinstance(kind, StructType):
        return {name: zero(field) for name, field in kind.fields}
    if isinstance(kind, ArrayType):
        return [zero(kind.element)] * array_length(kind)
    return default_scalar(kind) if isinstance(kind, ElementaryType) else 0


def literal(value: Any, kind: ElementaryType) -> str:
    """Return a value of an elementary type as Structured Text.

    Bit patterns are written with their type.
    """
    name = kind.name
    if name == "BOOL":
        return "TRUE" if value else "FALSE"
    if name in DIGITS:
        return f"{name}#16#{int(value):0{DIGITS[name]}X}"
    if name in ("REAL", "LREAL"):
        digits, mark, exponent = f"{float(value):.{9 if name == 'REAL' else 17}g}".partition("e")
        return f"{digits if '.' in digits else f'{digits}.0'}{mark.upper()}{exponent}"
    if name in ("STRING", "CHAR"):
        return _quoted(str(value), "'", 2)
    if name in ("WSTRING", "WCHAR"):
        return _quoted(str(value), '"', 4)
    if name in ("TIME", "LTIME"):
        ms, rest = divmod(abs(int(value)), 1_000_000)
        digits = f"{ms}.{rest:06d}".rstrip("0") if rest else str(ms)
        return f"{'T' if name == 'TIME' else name}#{'-' if value < 0 else ''}{digits}ms"
    if name in ("DATE", "TOD", "DT", "LDATE", "LTOD", "LDT"):
        found = scalar_to_python(kind, value)
        shown = f"{found:%Y-%m-%d-%H:%M:%S.%f}" if isinstance(found, datetime) else str(found)
        return f"{name}#{shown}"
    return str(int(value))


def differing(
    path: str, value: Any, other: Any, kind: Type, field: Callable[[str], str]
) -> Iterator[tuple[str, Any, Type]]:
    """Yield path, value and type of each scalar in a value that differs from another value.

    If `other` is None, yield each scalar. `field` returns the name of a field in a path.
    """
    if isinstance(kind, StructType):
        for name, inner in kind.fields:
            below = None if other is None else other[name]
            yield from differing(f"{path}.{field(name)}", value[name], below, inner, field)
    elif isinstance(kind, ArrayType):
        places = product(*(range(low, high + 1) for low, high in kind.bounds))
        for place, (indices, item) in enumerate(zip(places, value, strict=True)):
            below = None if other is None else other[place]
            at = f"{path}[{', '.join(map(str, indices))}]"
            yield from differing(at, item, below, kind.element, field)
    elif other is None or value != other:
        yield path, value, kind


def runs(values: list[str]) -> str:
    """Return the elements of an array as Structured Text; `[1, 2(7)]` repeats 7 twice."""
    found = [(text, len(list(same))) for text, same in groupby(values)]
    return f"[{', '.join(text if count == 1 else f'{count}({text})' for text, count in found)}]"


def _quoted(text: str, quote: str, digits: int) -> str:
    """Return a text in quotes; a character that a literal cannot contain becomes its code."""
    plain = {one: one for one in map(chr, range(ord(" "), ord("~") + 1)) if one != quote}
    plain["$"] = "$$"
    return quote + "".join(plain.get(one, f"${ord(one):0{digits}X}") for one in text) + quote
