"""What a variable of a Structured Text program can be: the type model both engines share."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

__all__ = [
    "ArrayType",
    "BlockType",
    "ElementaryType",
    "EnumType",
    "StructType",
    "Type",
    "Variable",
]


@dataclass(frozen=True)
class ElementaryType:
    """An elementary type of IEC 61131-3, by its upper-case name: `BOOL`, `DINT`, `TIME` ..."""

    name: str


@dataclass(frozen=True)
class EnumType:
    """An enumeration; values count from 0 in the order of the members."""

    name: str
    members: tuple[str, ...]


@dataclass(frozen=True)
class ArrayType:
    """A named array type; `bounds` holds (lower, upper) per dimension, both inclusive."""

    name: str
    bounds: tuple[tuple[int, int], ...]
    element: Type


@dataclass(frozen=True)
class StructType:
    """A structure; fields in order of declaration, names as declared."""

    name: str
    fields: tuple[tuple[str, Type], ...]


@dataclass(frozen=True)
class Variable:
    """A variable of a function block or program.

    `section` is VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT, VAR_EXTERNAL or VAR_GLOBAL;
    `address` the direct address it is located at (`%QX0.0`), if any.
    """

    name: str
    type: Type
    section: str
    address: str | None = None


@dataclass(frozen=True, eq=False)
class BlockType:
    """A function block or program type with its variables in order of declaration."""

    name: str
    variables: tuple[Variable, ...] = field(default_factory=tuple)


Type: TypeAlias = ElementaryType | EnumType | ArrayType | StructType | BlockType
