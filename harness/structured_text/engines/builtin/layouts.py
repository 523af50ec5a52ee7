"""Code for the layouts of types: the order and size of values in memory (see `byte_views`)."""

from __future__ import annotations

from structured_text.language.scalars import ANY_STRING, MOMENTS, SIGNED, WIDTH
from structured_text.language.sizes import places_of, size_of
from structured_text.language.types import ArrayType, ElementaryType, EnumType, StructType, Type
from structured_text.language.values import array_length

__all__ = ["layout_of"]

_CODES = {8: "B", 16: "H", 32: "I", 64: "Q"}
_REALS = {"REAL": "<f", "LREAL": "<d"}
#: Unit of a time or date in memory [ns]: milliseconds, or seconds if it has a date.
_UNITS = {"TIME": 1_000_000, "TOD": 1_000_000, "DATE": 1_000_000_000, "DT": 1_000_000_000}


def layout_of(kind: Type) -> str:
    """Return code that makes the layout of a type; the type must have a size (`size_of`)."""
    if isinstance(kind, EnumType):
        return layout_of(ElementaryType(kind.base))
    if isinstance(kind, ElementaryType):
        return _scalar(kind)
    if isinstance(kind, ArrayType):
        return f"Row({layout_of(kind.element)}, {array_length(kind)})"
    if isinstance(kind, StructType):
        pairs = zip(kind.fields, places_of(kind), strict=True)
        fields = "".join(
            f"({name.upper()!r}, {place}, {layout_of(field)}), " for (name, field), place in pairs
        )
        return f"Record(({fields}), {size_of(kind)}, {kind.union})"
    return "Pointer()"


def _scalar(kind: ElementaryType) -> str:
    name, size = kind.name, size_of(kind)
    if name == "BOOL":
        return "Truth()"
    if name in ANY_STRING:
        return f"Text({size}, {1 if name == 'STRING' else 2})"
    if name in ("CHAR", "WCHAR"):
        return f"Character({size})"
    if name in MOMENTS:
        return f"Moment({_UNITS.get(name, 1)}, {size}, {name == 'LTIME'})"
    if name in _REALS:
        return f"Number({_REALS[name]!r}, {size})"
    code = _CODES[WIDTH[name]]
    return f"Number({'<' + (code.lower() if name in SIGNED else code)!r}, {size})"
