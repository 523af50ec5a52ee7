"""The type model of Structured Text variables, which all engines share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

__all__ = [
    "NO_STORAGE",
    "ArrayType",
    "BlockType",
    "ElementaryType",
    "EnumType",
    "InterfaceType",
    "Located",
    "ReferenceType",
    "StructType",
    "Type",
    "Variable",
    "has_address",
    "has_block",
    "inside",
    "integer_name",
    "members",
    "type_name",
]


#: Sections of variables without storage of their own. Their value belongs to another variable.
NO_STORAGE = ("VAR_IN_OUT", "VAR_EXTERNAL")


@dataclass(frozen=True)
class ElementaryType:
    """An elementary type of IEC 61131-3, by its upper-case name: `BOOL`, `DINT`, `TIME` ...

    `length` is the number of characters of a STRING or WSTRING; None for the default length.
    """

    name: str
    length: int | None = None


@dataclass(frozen=True)
class EnumType:
    """An enumeration of integers of the type `base`.

    `values` has one entry per member. If it is empty, the members count from 0. `attributes` has
    `strict` and `to_string`, as far as the declaration has these attributes.
    """

    name: str
    members: tuple[str, ...]
    values: tuple[int, ...] = ()
    base: str = "INT"
    attributes: frozenset[str] = field(default=frozenset(), compare=False)

    def value_of(self, member: str) -> int:
        """Return the value of a member, or raise ValueError; names are compared without case."""
        place = [one.upper() for one in self.members].index(member.upper())
        return self.values[place] if self.values else place

    def member_of(self, value: int) -> str | None:
        """Return the member with a value; None if there is none."""
        if not self.values:
            return self.members[value] if 0 <= value < len(self.members) else None
        return self.members[self.values.index(value)] if value in self.values else None


@dataclass(frozen=True)
class ArrayType:
    """An array type; `bounds` holds (lower, upper) per dimension, both inclusive.

    `open` is true only for the type of a parameter that takes arrays with any bounds.
    """

    name: str
    bounds: tuple[tuple[int, int], ...]
    element: Type
    open: bool = False


@dataclass(frozen=True)
class StructType:
    """A structure with its fields in order of declaration and names as declared.

    `union` is true if all fields share the same memory. `bits` are the upper-case names of the
    fields of the type BIT: they are BOOL, but up to eight in a row share a byte.
    """

    name: str
    fields: tuple[tuple[str, Type], ...]
    union: bool = False
    bits: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Variable:
    """A variable of a function block or program.

    `section` is VAR, VAR_INPUT, VAR_OUTPUT, VAR_IN_OUT, VAR_EXTERNAL or VAR_GLOBAL. `address` is
    its direct address (`%QX0.0`), if any. `retain` is true if it keeps its value over a warm start.
    """

    name: str
    type: Type
    section: str
    address: str | None = None
    retain: bool = False


@dataclass(frozen=True, eq=False)
class BlockType:
    """A function block or program type with its variables in order of declaration."""

    name: str
    variables: tuple[Variable, ...] = field(default_factory=tuple)


@dataclass(frozen=True)
class InterfaceType:
    """An interface. Its variables hold a block that implements it, or nothing."""

    name: str


@dataclass(eq=False)
class ReferenceType:
    """POINTER TO, REFERENCE TO or REF_TO another type.

    `target` is set once all declarations are known, because types may point to each other. Two
    reference types are equal if their targets have the same name; arrays without a name must have
    the same form.
    """

    kind: str
    target: Type | None = None

    @property
    def name(self) -> str:
        """Return the type as it is written: `POINTER TO INT`."""
        word = self.kind if self.kind == "REF_TO" else f"{self.kind} TO"
        return f"{word} {_form(self.target)}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ReferenceType) and self.name.upper() == other.name.upper()

    def __hash__(self) -> int:
        return hash(self.kind)


def _form(kind: Type | None) -> str:
    """Return the name of a type; for an array without a name, the text of its declaration."""
    if isinstance(kind, ArrayType) and not kind.name:
        bounds = ", ".join(f"{low}..{high}" for low, high in kind.bounds)
        return f"ARRAY [{bounds}] OF {_form(kind.element)}"
    return kind.name if kind is not None else "?"


Type: TypeAlias = (
    ElementaryType | EnumType | ArrayType | StructType | BlockType | InterfaceType | ReferenceType
)


@dataclass(frozen=True)
class Located:
    """A directly represented variable: its address (`%QW3`), path and type.

    `start` is the first byte of an element or field, whose address does not show the byte.
    """

    address: str
    path: str
    type: Type
    start: int | None = None


def type_name(kind: Type | None) -> str:
    """Return the name of an elementary type; empty for every other type."""
    return kind.name if isinstance(kind, ElementaryType) else ""


def integer_name(kind: Type | None) -> str:
    """Return the name of an elementary type, or of the base type of an enumeration."""
    return kind.base if isinstance(kind, EnumType) else type_name(kind)


def members(kind: Type) -> tuple[tuple[str, Type], ...]:
    """Return the members of a structure, or the variables of a block that have a value."""
    if isinstance(kind, StructType):
        return kind.fields
    if isinstance(kind, BlockType):
        pins = (pin for pin in kind.variables if pin.section not in NO_STORAGE)
        return tuple((pin.name, pin.type) for pin in pins)
    return ()


def inside(kind: Type) -> Iterator[Type]:
    """Yield a type and the types of its elements and fields, but not of a block's variables.

    A type that several fields have is yielded for each of them.
    """
    yield kind
    if isinstance(kind, ArrayType):
        yield from inside(kind.element)
    elif isinstance(kind, StructType):
        for _, field in kind.fields:
            yield from inside(field)


def has_address(kind: Type) -> bool:
    """Return whether a type is or contains a block, pointer, reference or interface."""
    addressed = (BlockType, InterfaceType, ReferenceType)
    return any(isinstance(one, addressed) for one in inside(kind))


def has_block(kind: Type) -> bool:
    """Return whether a type is a block, or an array of blocks."""
    while isinstance(kind, ArrayType):
        kind = kind.element
    return isinstance(kind, BlockType)
