"""The layout of a compiled program's variables in memory, and codecs for their values.

Offsets and sizes come from the compiler (table `shim_layout`), never from assumptions. Each engine
adds what the compiler cannot report in its `Dialect`: names in C, and the representation of
scalars.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from structured_text.engines.base import Value
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
    Variable,
)
from structured_text.language.values import array_length, nest, scalar_to_python

__all__ = [
    "FORMATS",
    "Codec",
    "Dialect",
    "Layout",
    "Member",
    "converted",
    "layout_expressions",
    "memory_at",
    "packed",
    "tables",
]

#: Format characters of `struct` for the types that are numbers in C.
FORMATS = {
    "BOOL": "?",
    "SINT": "b",
    "INT": "h",
    "DINT": "i",
    "LINT": "q",
    "USINT": "B",
    "UINT": "H",
    "UDINT": "I",
    "ULINT": "Q",
    "BYTE": "B",
    "WORD": "H",
    "DWORD": "I",
    "LWORD": "Q",
    "REAL": "f",
    "LREAL": "d",
}

Getter = Callable[[memoryview, int], Value]
Putter = Callable[[memoryview, int, Value], None]


@dataclass(frozen=True)
class Codec:
    """Functions that read and write values of one type in memory.

    Attributes:
        size: Size of a value [bytes].
        get: Return the value at an offset of a memory view.
        put: Set the value at an offset; the value is in the form of the front end's
            `from_python`.
        form: The `struct` format, if that gives exactly the value of `get`; else empty.
    """

    size: int
    get: Getter
    put: Putter
    form: str = ""


class Dialect(Protocol):
    """The names that an engine uses in C, and its representation of values."""

    def type_name(self, kind: StructType | BlockType) -> str:
        """Return the name of a structure or block in C."""

    def member_name(self, kind: StructType | BlockType, variable: Variable) -> str:
        """Return the C expression of a member's value, relative to its structure or block."""

    def is_pointer(self, variable: Variable) -> bool:
        """Return whether the member is a pointer to a value that is stored somewhere else."""

    def scalar(self, kind: ElementaryType | EnumType, size: int) -> Codec:
        """Return the codec of an elementary type or enumeration of `size` bytes."""


@dataclass(frozen=True)
class Member:
    """A field of a structure or a variable of a block, with its place in memory.

    VAR_IN_OUT and VAR_EXTERNAL are not members: their values belong to other variables.
    """

    type: Type
    offset: int
    codec: Codec


def layout_expressions(types: Sequence[StructType | BlockType], dialect: Dialect) -> Iterator[str]:
    """Yield the C expressions of the table that `Layout` reads, in the order of the table."""
    for kind in types:
        name = dialect.type_name(kind)
        yield f"sizeof({name})"
        for variable in _members(kind):
            member = dialect.member_name(kind, variable)
            yield f"offsetof({name}, {member})"
            pointed = "*" if dialect.is_pointer(variable) else ""
            yield f"sizeof({pointed}(({name} *)0)->{member})"


def tables(regions: Sequence[str], layout: Sequence[str], linkage: str = "") -> Iterator[str]:
    """Yield the C text of the tables that a shared object exports.

    `layout` are the expressions of `layout_expressions`. In C++ `linkage` is the prefix that gives
    the tables C linkage.
    """
    contents = {
        "void *const shim_regions": [f"(void *)&({region})" for region in regions],
        "const size_t shim_sizes": [f"sizeof({region})" for region in regions],
        "const size_t shim_layout": layout,
    }
    for declaration, entries in contents.items():
        yield f"{linkage}{declaration}[] = {{"
        yield from (f"  {entry}," for entry in entries)
        yield "};"
        yield f"{linkage}const size_t {declaration.split()[-1].lstrip('*')}_count = {len(entries)};"


def _members(kind: StructType | BlockType) -> Iterator[Variable]:
    """Yield the members that hold a value between calls, or a pointer to such a value."""
    if isinstance(kind, StructType):
        yield from (Variable(name, field, "VAR") for name, field in kind.fields)
    else:
        others = ("VAR_IN_OUT", "VAR_EXTERNAL")
        yield from (pin for pin in kind.variables if pin.section not in others)


class Layout:
    """Offsets and codecs of a program's types.

    The types must be the same as in the call of `layout_expressions`. `table` has the values of the
    expressions that this call returned [bytes].
    """

    def __init__(
        self, types: Sequence[StructType | BlockType], table: Sequence[int], dialect: Dialect
    ) -> None:
        self._dialect = dialect
        self._members: dict[str, dict[str, Member]] = {}
        self._codecs: dict[str, Codec] = {}
        numbers = iter(table)
        for kind in types:
            self._add(kind, next(numbers), numbers)

    def _add(self, kind: StructType | BlockType, size: int, numbers: Iterator[int]) -> None:
        members: dict[str, Member] = {}
        for variable in _members(kind):
            offset, codec = next(numbers), self.codec(variable.type, next(numbers))
            if self._dialect.is_pointer(variable):
                codec = _pointed(codec)
            members[variable.name] = Member(variable.type, offset, codec)
        key = kind.name.upper()
        self._members[key], self._codecs[key] = members, _record(size, members)

    def member(self, kind: StructType | BlockType, name: str) -> Member:
        """Return a field or variable by its declared name."""
        return self._members[kind.name.upper()][name]

    def codec(self, kind: Type, size: int) -> Codec:
        """Return the codec of a type; `size` is the number of bytes of a value."""
        if isinstance(kind, ArrayType):
            return self._array_codec(kind, size)
        if isinstance(kind, (StructType, BlockType)):
            return self._codecs[kind.name.upper()]
        assert isinstance(kind, (ElementaryType, EnumType))
        return self._dialect.scalar(kind, size)

    def _array_codec(self, kind: ArrayType, size: int) -> Codec:
        count = array_length(kind)
        element = self.codec(kind.element, size // count)
        step, get_one, put_one = element.size, element.get, element.put
        flat = len(kind.bounds) == 1

        def get(memory: memoryview, at: int) -> Value:
            values = [get_one(memory, place) for place in range(at, at + size, step)]
            return values if flat else nest(kind, values)

        def put(memory: memoryview, at: int, value: Value) -> None:
            for place, one in zip(range(at, at + size, step), value, strict=True):
                put_one(memory, place, one)

        return Codec(size, get, put)


def _record(size: int, members: dict[str, Member]) -> Codec:
    """Return the codec of a structure or block; its values are dicts by declared names."""
    parts = [(name, member.offset, member.codec) for name, member in members.items()]

    def get(memory: memoryview, at: int) -> Value:
        return {name: codec.get(memory, at + offset) for name, offset, codec in parts}

    def put(memory: memoryview, at: int, value: Value) -> None:
        for name, offset, codec in parts:
            if name in value:
                codec.put(memory, at + offset, value[name])

    return Codec(size, get, put)


def _pointed(target: Codec) -> Codec:
    """Return the codec of a pointer to a value stored somewhere else: a located variable."""
    pointer = struct.Struct("@P")

    def there(memory: memoryview, at: int) -> memoryview:
        return memory_at(pointer.unpack_from(memory, at)[0], target.size)

    def get(memory: memoryview, at: int) -> Value:
        return target.get(there(memory, at), 0)

    def put(memory: memoryview, at: int, value: Value) -> None:
        target.put(there(memory, at), 0, value)

    return Codec(pointer.size, get, put)


def memory_at(address: int, size: int) -> memoryview:
    """Return the bytes at an address as a writable view."""
    return memoryview((ctypes.c_char * size).from_address(address)).cast("B")


def packed(form: str, size: int) -> Codec:
    """Return the codec of a number at the start of `size` bytes.

    `form` is its format character for `struct`. Bytes behind the number are not changed.
    """
    packer = struct.Struct("=" + form)
    rest = f"{size - packer.size}x" if size > packer.size else ""

    def get(memory: memoryview, at: int) -> Value:
        return packer.unpack_from(memory, at)[0]

    def put(memory: memoryview, at: int, value: Value) -> None:
        packer.pack_into(memory, at, value)

    return Codec(size, get, put, form + rest)


def converted(kind: ElementaryType | EnumType, number: Codec) -> Codec:
    """Return the codec of an enumeration, duration or date that is stored as a number."""

    def get(memory: memoryview, at: int) -> Value:
        return scalar_to_python(kind, number.get(memory, at))

    return Codec(number.size, get, number.put)
