"""How the variables of a matiec program lie in memory, and what is read from there.

matiec keeps a block as a C structure whose elementary members, enumerations, arrays and
structures are each wrapped with a byte of flags, nested blocks lie bare, and external and located
variables are pointers. Offsets and sizes come from the C compiler (`rcx_layout`), never from
assumptions made here.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from rcx_harness.engine.base import Value
from rcx_harness.engine.frontend.values import array_length, nest, scalar_to_python
from rcx_harness.engine.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
    Variable,
)

__all__ = ["Codec", "Layout", "Member", "layout_expressions", "memory_at"]

_FORMATS = {
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
    """Reads and writes values of one type in memory.

    Attributes:
        size: Bytes.
        get: Value at an offset of a memory view.
        put: Set the value at an offset; takes what `from_python` of the front end gives.
        form: Its character for `struct` where that gives the very value of `get`, else empty.
    """

    size: int
    get: Getter
    put: Putter
    form: str = ""


@dataclass(frozen=True)
class Member:
    """A field of a structure, or a variable of a block; not what belongs to others."""

    type: Type
    offset: int
    codec: Codec


def layout_expressions(types: Sequence[StructType | BlockType]) -> Iterator[str]:
    """C expressions that, evaluated in order, make the table that `Layout` reads."""
    for kind in types:
        name = kind.name.upper()
        yield f"sizeof({name})"
        for member in _members(kind):
            c_name = member.name.upper()
            if isinstance(kind, BlockType) and not isinstance(member.type, BlockType):
                c_name += ".value"
            yield f"offsetof({name}, {c_name})"
            pointed = "*" if _is_pointer(member) else ""
            yield f"sizeof({pointed}(({name} *)0)->{c_name})"


def _members(kind: StructType | BlockType) -> Iterator[Variable]:
    """The members that hold a value between two calls, or lead to one."""
    if isinstance(kind, StructType):
        yield from (Variable(name, field, "VAR") for name, field in kind.fields)
    else:
        yield from (pin for pin in kind.variables if pin.section != "VAR_IN_OUT")


def _is_pointer(variable: Variable) -> bool:
    return variable.section == "VAR_EXTERNAL" or variable.address is not None


class Layout:
    """Offsets and codecs of a program's types.

    Args:
        types: The types that `layout_expressions` was given, in the same order; each after
            those that it contains.
        table: What the C compiler made of these expressions, bytes.
    """

    def __init__(self, types: Sequence[StructType | BlockType], table: Sequence[int]) -> None:
        self._members: dict[str, dict[str, Member]] = {}
        self._codecs: dict[str, Codec] = {}
        self._pointers: dict[str, tuple[int, ...]] = {}
        numbers = iter(table)
        for kind in types:
            self._add(kind, next(numbers), numbers)

    def _add(self, kind: StructType | BlockType, size: int, numbers: Iterator[int]) -> None:
        members: dict[str, Member] = {}
        pointers: list[int] = []
        for variable in _members(kind):
            offset, codec = next(numbers), self.codec(variable.type, next(numbers))
            if _is_pointer(variable):
                pointers.append(offset)
                codec = _pointed(codec)
            elif isinstance(variable.type, BlockType):
                pointers += [offset + inner for inner in self.pointers(variable.type)]
            if variable.section != "VAR_EXTERNAL":
                members[variable.name] = Member(variable.type, offset, codec)
        key = kind.name.upper()
        self._members[key], self._pointers[key] = members, tuple(pointers)
        self._codecs[key] = _record(size, members)

    def pointers(self, kind: BlockType) -> tuple[int, ...]:
        """Offsets of the pointers in a block: its external and located variables."""
        return self._pointers[kind.name.upper()]

    def member(self, kind: StructType | BlockType, name: str) -> Member:
        """A field or variable by its declared name."""
        return self._members[kind.name.upper()][name]

    def codec(self, kind: Type, size: int) -> Codec:
        """The codec of a type whose values take `size` bytes."""
        if isinstance(kind, EnumType):
            return _enum_codec(kind, size)
        if isinstance(kind, ArrayType):
            return self._array_codec(kind, size)
        if isinstance(kind, (StructType, BlockType)):
            return self._codecs[kind.name.upper()]
        return _elementary_codec(kind, size)

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
    """A structure or block, as a dict by declared names."""
    parts = [(name, member.offset, member.codec) for name, member in members.items()]

    def get(memory: memoryview, at: int) -> Value:
        return {name: codec.get(memory, at + offset) for name, offset, codec in parts}

    def put(memory: memoryview, at: int, value: Value) -> None:
        for name, offset, codec in parts:
            if name in value:
                codec.put(memory, at + offset, value[name])

    return Codec(size, get, put)


def _pointed(target: Codec) -> Codec:
    """A pointer to a value elsewhere: a located variable."""
    pointer = struct.Struct("@P")

    def there(memory: memoryview, at: int) -> memoryview:
        return memory_at(pointer.unpack_from(memory, at)[0], target.size)

    def get(memory: memoryview, at: int) -> Value:
        return target.get(there(memory, at), 0)

    def put(memory: memoryview, at: int, value: Value) -> None:
        target.put(there(memory, at), 0, value)

    return Codec(pointer.size, get, put)


def memory_at(address: int, size: int) -> memoryview:
    """The bytes at an address, to read and to write."""
    return memoryview((ctypes.c_char * size).from_address(address)).cast("B")


def _elementary_codec(kind: ElementaryType, size: int) -> Codec:
    if kind.name == "STRING":
        return _string_codec(size)
    if kind.name in _FORMATS:
        return _packed(_FORMATS[kind.name])
    return _moment_codec(kind)


def _packed(form: str) -> Codec:
    packer = struct.Struct("=" + form)

    def get(memory: memoryview, at: int) -> Value:
        return packer.unpack_from(memory, at)[0]

    def put(memory: memoryview, at: int, value: Value) -> None:
        packer.pack_into(memory, at, value)

    return Codec(packer.size, get, put, form)


def _moment_codec(kind: ElementaryType) -> Codec:
    """TIME, DATE, TOD and DT: seconds and nanoseconds, each a C long.

    Read in whole microseconds, to the nearest: matiec computes literals such as T#1300ms in
    floating point and may be one nanosecond off.
    """
    packer = struct.Struct("@ll")

    def get(memory: memoryview, at: int) -> Value:
        seconds, nanoseconds = packer.unpack_from(memory, at)
        microseconds = seconds * 1_000_000 + (nanoseconds + 500) // 1000
        return scalar_to_python(kind, microseconds * 1000)

    def put(memory: memoryview, at: int, value: Value) -> None:
        seconds, nanoseconds = divmod(abs(value), 1_000_000_000)
        sign = -1 if value < 0 else 1
        packer.pack_into(memory, at, sign * seconds, sign * nanoseconds)

    return Codec(packer.size, get, put)


def _enum_codec(kind: EnumType, size: int) -> Codec:
    number = _packed({1: "b", 2: "h", 4: "i"}[size])

    def get(memory: memoryview, at: int) -> Value:
        return scalar_to_python(kind, number.get(memory, at))

    return Codec(size, get, number.put)


def _string_codec(size: int) -> Codec:
    """A byte with the length, then the characters."""

    def get(memory: memoryview, at: int) -> Value:
        return bytes(memory[at + 1 : at + 1 + memory[at]]).decode("latin-1")

    def put(memory: memoryview, at: int, value: Value) -> None:
        text = value.encode("latin-1")
        memory[at] = len(text)
        memory[at + 1 : at + size] = text.ljust(size - 1, b"\0")

    return Codec(size, get, put)
