"""Sizes of types for SIZEOF and UNION: bytes in the layout of a 32-bit CODESYS."""

from __future__ import annotations

from dataclasses import replace

from structured_text.language.scalars import ANY_STRING, WIDTH, string_length
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)
from structured_text.language.values import array_length

__all__ = ["bits_of", "block_size", "places_of", "size_of"]

_SIZES = {
    **{name: bits // 8 for name, bits in WIDTH.items()},
    "BOOL": 1,
    "REAL": 4,
    "LREAL": 8,
    "CHAR": 1,
    "WCHAR": 2,
    **dict.fromkeys(("TIME", "DATE", "TOD", "DT"), 4),
    **dict.fromkeys(("LTIME", "LDATE", "LTOD", "LDT"), 8),
}


def size_of(kind: Type) -> int | None:
    """Return the size of a variable of this type [bytes].

    The result is None for blocks, because each tool lays them out in its own way. Each field of a
    structure lies at a multiple of its alignment. The alignment of a field is its size, at most 8.
    """
    found = _layout(kind)
    return None if found is None else found[0]


def block_size(kind: Type) -> int | None:
    """Return the size [bytes] of a block, or of a variable with blocks inside.

    Each tool lays out blocks in its own way. Here a block is a structure: a pointer to the methods,
    the variables of the base block, and the block's own variables. A VAR_IN_OUT is a pointer. The
    result is None if a part has no size.
    """
    found = _layout(_as_structure(kind))
    return None if found is None else found[0]


def _as_structure(kind: Type) -> Type:
    """Return a type with a structure in place of each block."""
    if isinstance(kind, InterfaceType):
        return ReferenceType("POINTER", None)
    if isinstance(kind, ArrayType):
        return replace(kind, element=_as_structure(kind.element))
    if isinstance(kind, StructType):
        fields = tuple((name, _as_structure(field)) for name, field in kind.fields)
        return replace(kind, fields=fields)
    if not isinstance(kind, BlockType):
        return kind
    pointer = ReferenceType("POINTER", None)
    held = [
        pointer if one.section in ("VAR_IN_OUT", "VAR_EXTERNAL") else _as_structure(one.type)
        for one in kind.variables
    ]
    return StructType(kind.name, tuple((str(at), one) for at, one in enumerate((pointer, *held))))


def _layout(kind: Type) -> tuple[int, int] | None:
    """Return size and alignment of a type [bytes]; None if the type has no known layout."""
    if isinstance(kind, ElementaryType):
        if kind.name in ANY_STRING:
            width = 1 if kind.name == "STRING" else 2
            return (string_length(kind) + 1) * width, width
        return _SIZES[kind.name], _SIZES[kind.name]
    if isinstance(kind, EnumType):
        return _SIZES[kind.base], _SIZES[kind.base]
    if isinstance(kind, ReferenceType):
        return 4, 4
    if isinstance(kind, ArrayType) and kind.open:
        return None
    if isinstance(kind, ArrayType):
        element = _layout(kind.element)
        return None if element is None else (element[0] * array_length(kind), element[1])
    if not isinstance(kind, StructType):
        return None
    found = _places(kind)
    if found is None:
        return None
    most = max((alignment for _, _, _, alignment in found), default=1)
    end = max((begin + size for begin, _, size, _ in found), default=0)
    return -(-end // most) * most, most


def _places(kind: StructType) -> list[tuple[int, int | None, int, int]] | None:
    """Return offset, bit, size and alignment of each field; None if a layout is unknown.

    The bit is None for a field that is not a BIT.
    """
    end, bit, places = 0, 8, list[tuple[int, int | None, int, int]]()
    for name, field in kind.fields:
        found = _layout(field)
        if found is None:
            return None
        size, alignment = found
        if name.upper() in kind.bits and not kind.union:
            if bit == 8:
                end, bit = end + 1, 0
            places.append((end - 1, bit, 1, 1))
            bit += 1
            continue
        begin, bit = 0 if kind.union else -(-end // alignment) * alignment, 8
        end = begin + size
        places.append((begin, 0 if name.upper() in kind.bits else None, size, alignment))
    return places


def places_of(kind: StructType) -> list[int]:
    """Return the offset [bytes] of each field of a structure; 0 for all fields of a union.

    The structure must have a size (`size_of`).
    """
    found = _places(kind)
    assert found is not None
    return [place for place, _, _, _ in found]


def bits_of(kind: StructType) -> list[int | None]:
    """Return the number of the bit of each field of the type BIT; None for other fields.

    The structure must have a size (`size_of`).
    """
    found = _places(kind)
    assert found is not None
    return [bit for _, bit, _, _ in found]
