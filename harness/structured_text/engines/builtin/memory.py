"""Memory looked at as bytes: unions, and pointers to memory of another type.

A layout says how a value of a type lies in memory: little endian, each field at a multiple of
its own alignment, as `language.sizes` counts it. Variables stay Python values; only what is
looked at as another type is made of bytes, and those bytes are taken back into the variable.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

from structured_text.engines.builtin.runtime import ProgramError

__all__ = [
    "NAMES",
    "Character",
    "Elements",
    "Fields",
    "Held",
    "Layout",
    "Memory",
    "Moment",
    "Number",
    "Pointer",
    "Record",
    "Row",
    "Text",
    "Truth",
    "Union",
    "View",
]


class Memory(Protocol):
    """Bytes that are read and written."""

    def read(self, at: int, size: int) -> bytes:
        """Some bytes from a place on."""

    def write(self, at: int, data: bytes) -> None:
        """Put bytes at a place."""


# --- how values lie in memory -----------------------------------------------------------------


class _Scalar:
    """What scalars have in common: they are packed and unpacked as a whole."""

    size: int

    def pack(self, value: Any) -> bytes:
        """The bytes of a value."""
        raise NotImplementedError

    def unpack(self, data: bytes) -> Any:
        """The value of bytes."""
        raise NotImplementedError

    def read(self, value: Any, at: int, size: int) -> bytes:
        """Some bytes of a value."""
        return self.pack(value)[at : at + size]

    def write(self, value: Any, at: int, data: bytes) -> Any:
        """The value with some bytes changed."""
        if at == 0 and len(data) == self.size:
            return self.unpack(data)
        held = bytearray(self.pack(value))
        held[at : at + len(data)] = data
        return self.unpack(bytes(held))

    def look(self, memory: Memory, at: int) -> Any:
        """The value that lies in some memory."""
        return self.unpack(memory.read(at, self.size))

    def store(self, memory: Memory, at: int, value: Any) -> None:
        """Put a value into some memory."""
        memory.write(at, self.pack(value))


@dataclass(frozen=True)
class Number(_Scalar):
    """A number or bit string; `code` is that of `struct`."""

    code: str
    size: int

    def pack(self, value: Any) -> bytes:
        """See `_Scalar`."""
        return struct.pack(self.code, value)

    def unpack(self, data: bytes) -> Any:
        """See `_Scalar`."""
        return struct.unpack(self.code, data)[0]


@dataclass(frozen=True)
class Truth(_Scalar):
    """A BOOL: a byte that is not 0."""

    size: int = 1

    def pack(self, value: Any) -> bytes:
        """See `_Scalar`."""
        return b"\1" if value else b"\0"

    def unpack(self, data: bytes) -> Any:
        """See `_Scalar`."""
        return data[0] != 0


@dataclass(frozen=True)
class Moment(_Scalar):
    """A duration or date, held in nanoseconds, counted in units in memory."""

    unit: int
    size: int
    signed: bool = False

    def pack(self, value: Any) -> bytes:
        """See `_Scalar`."""
        count: int = value // self.unit
        return (count & (1 << 8 * self.size) - 1).to_bytes(self.size, "little")

    def unpack(self, data: bytes) -> Any:
        """See `_Scalar`."""
        return int.from_bytes(data, "little", signed=self.signed) * self.unit


@dataclass(frozen=True)
class Text(_Scalar):
    """A text and the 0 behind it; `width` is 1 or 2 bytes for a character.

    What lies behind the first 0 stays part of the value, until the whole is assigned.
    """

    size: int
    width: int

    def pack(self, value: Any) -> bytes:
        """See `_Scalar`."""
        if self.width == 1:
            data: bytes = value.encode("latin-1")
        else:
            data = struct.pack(f"<{len(value)}H", *map(ord, value))
        return data.ljust(self.size, b"\0")

    def unpack(self, data: bytes) -> Any:
        """See `_Scalar`."""
        held = data[: self.size - self.width]
        if self.width == 1:
            return held.rstrip(b"\0").decode("latin-1")
        codes = struct.unpack(f"<{len(held) // 2}H", held)
        return "".join(map(chr, codes)).rstrip("\0")


@dataclass(frozen=True)
class Character(_Scalar):
    """A CHAR or WCHAR."""

    size: int

    def pack(self, value: Any) -> bytes:
        """See `_Scalar`."""
        return ord(value).to_bytes(self.size, "little")

    def unpack(self, data: bytes) -> Any:
        """See `_Scalar`."""
        return chr(int.from_bytes(data, "little"))


@dataclass(frozen=True)
class Pointer(_Scalar):
    """A pointer: it takes room, but has no bytes that could be looked at."""

    size: int = 4

    def pack(self, value: Any) -> bytes:
        """See `_Scalar`."""
        raise ProgramError("a pointer cannot be looked at as bytes")

    def unpack(self, data: bytes) -> Any:
        """See `_Scalar`."""
        raise ProgramError("bytes cannot be looked at as a pointer")


class _Composite:
    """What structures, unions and arrays have in common: they are looked at in place."""

    size: int

    def look(self, memory: Memory, at: int) -> Any:
        raise NotImplementedError

    def read(self, value: Any, at: int, size: int) -> bytes:
        raise NotImplementedError

    def store(self, memory: Memory, at: int, value: Any) -> None:
        """Put a value into some memory."""
        memory.write(at, self.read(value, 0, self.size))


@dataclass(frozen=True)
class Row(_Composite):
    """An array: `count` elements of one layout."""

    element: Layout
    count: int

    @property
    def size(self) -> int:  # type: ignore[override]
        """Bytes of all elements."""
        return self.element.size * self.count

    def read(self, value: Any, at: int, size: int) -> bytes:
        """Some bytes of a list, or of what is looked at as one."""
        step = self.element.size
        first, end = at // step, -(-(at + size) // step)
        data = b"".join(self.element.read(value[k], 0, step) for k in range(first, end))
        return data[at - first * step :][:size]

    def write(self, value: Any, at: int, data: bytes) -> Any:
        """Change some bytes of a list."""
        step, behind = self.element.size, at + len(data)
        for k in range(at // step, -(-behind // step)):
            begin, end = max(at, k * step), min(behind, (k + 1) * step)
            part = data[begin - at : end - at]
            value[k] = self.element.write(value[k], begin - k * step, part)
        return value

    def look(self, memory: Memory, at: int) -> Elements:
        """The array that lies in some memory."""
        return Elements(memory, at, self)


@dataclass(frozen=True)
class Record(_Composite):
    """A structure: slot, place and layout of each field; in a union all places are 0."""

    fields: tuple[tuple[str, int, Layout], ...]
    size: int
    union: bool = False

    def read(self, value: Any, at: int, size: int) -> bytes:
        """Some bytes of a structure, or of what is looked at as one."""
        if self.union:
            found: bytes = _memory(value).read(_at(value) + at, size)
            return found
        data = bytearray(size)
        for slot, place, layout in self.fields:
            begin, end = max(at, place), min(at + size, place + layout.size)
            if begin < end:
                part = layout.read(getattr(value, slot), begin - place, end - begin)
                data[begin - at : end - at] = part
        return bytes(data)

    def write(self, value: Any, at: int, data: bytes) -> Any:
        """Change some bytes of a structure; what lies between its fields takes none."""
        if self.union:
            _memory(value).write(_at(value) + at, data)
            return value
        for slot, place, layout in self.fields:
            begin, end = max(at, place), min(at + len(data), place + layout.size)
            if begin < end:
                old = getattr(value, slot)
                new = layout.write(old, begin - place, data[begin - at : end - at])
                if new is not old:
                    setattr(value, slot, new)
        return value

    def look(self, memory: Memory, at: int) -> Fields:
        """The structure that lies in some memory."""
        return Fields(memory, at, self)


#: The names that generated code finds, besides `Union`.
NAMES: dict[str, Any] = {
    one.__name__: one for one in (Number, Truth, Moment, Text, Character, Pointer, Row, Record)
}
Layout: TypeAlias = Number | Truth | Moment | Text | Character | Pointer | Row | Record


# --- what is looked at ------------------------------------------------------------------------


class Elements:
    """Bytes looked at as an array: what a list of the elements does."""

    __slots__ = ("at", "memory", "row")

    def __init__(self, memory: Memory, at: int, row: Row) -> None:
        self.memory, self.at, self.row = memory, at, row

    def place(self, position: int) -> int:
        """Where an element lies."""
        return self.at + position * self.row.element.size

    def __len__(self) -> int:
        return self.row.count

    def __iter__(self) -> Iterator[Any]:
        return (self[k] for k in range(self.row.count))

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, slice):
            return [self[k] for k in range(*key.indices(self.row.count))]
        return self.row.element.look(self.memory, self.place(key))

    def __setitem__(self, key: Any, value: Any) -> None:
        if not isinstance(key, slice):
            self.row.element.store(self.memory, self.place(key), value)
            return
        for k, item in zip(range(*key.indices(self.row.count)), list(value), strict=False):
            self[k] = item


class Fields:
    """Bytes looked at as a structure: its fields are attributes, in upper case."""

    __slots__ = ("at", "memory", "places", "record")

    def __init__(self, memory: Memory, at: int, record: Record) -> None:
        put = object.__setattr__
        put(self, "memory", memory)
        put(self, "at", at)
        put(self, "record", record)
        put(self, "places", {slot: (place, layout) for slot, place, layout in record.fields})

    def __getattr__(self, slot: str) -> Any:
        if slot not in self.places:
            raise AttributeError(slot)
        place, layout = self.places[slot]
        return layout.look(self.memory, self.at + place)

    def __setattr__(self, slot: str, value: Any) -> None:
        place, layout = self.places[slot]
        layout.store(self.memory, self.at + place, value)


class Union(Fields):
    """A variable that is a union, with the bytes that all its fields lie in."""

    __slots__ = ("held",)

    def __init__(self, record: Record) -> None:
        super().__init__(self, 0, record)
        object.__setattr__(self, "held", bytearray(record.size))

    def read(self, at: int, size: int) -> bytes:
        """See `Memory`."""
        _check(at, size, len(self.held))
        return bytes(self.held[at : at + size])

    def write(self, at: int, data: bytes) -> None:
        """See `Memory`."""
        _check(at, len(data), len(self.held))
        self.held[at : at + len(data)] = data


class Held:
    """The bytes of a variable that a pointer leads to."""

    __slots__ = ("layout", "pointer")

    def __init__(self, pointer: Any, layout: Layout) -> None:
        self.pointer, self.layout = pointer, layout

    def read(self, at: int, size: int) -> bytes:
        """See `Memory`."""
        _check(at, size, self.layout.size)
        return self.layout.read(self.pointer.V, at, size)

    def write(self, at: int, data: bytes) -> None:
        """See `Memory`."""
        _check(at, len(data), self.layout.size)
        old = self.pointer.V
        new = self.layout.write(old, at, data)
        if new is not old:
            self.pointer.V = new


NAMES["Union"] = Union


class View:
    """A pointer to memory that is looked at as a type; it may lead outside until it is used."""

    __slots__ = ("at_", "layout", "memory")

    def __init__(self, memory: Memory, at: int, layout: Layout) -> None:
        self.memory, self.at_, self.layout = memory, at, layout

    @property
    def V(self) -> Any:  # noqa: N802 (as other pointers have it)
        """What it leads to."""
        return self.layout.look(self.memory, self.at_)

    @V.setter
    def V(self, value: Any) -> None:  # noqa: N802
        self.layout.store(self.memory, self.at_, value)

    def at(self, offset: int) -> View:
        """The pointer some elements further."""
        return View(self.memory, self.at_ + offset * self.layout.size, self.layout)

    def moved(self, offset: int, size: int) -> View:
        """The pointer some bytes further."""
        del size
        return View(self.memory, self.at_ + offset, self.layout)


def _memory(value: Any) -> Any:
    return value.memory


def _at(value: Any) -> int:
    at: int = value.at
    return at


def _check(at: int, size: int, most: int) -> None:
    if at < 0 or at + size > most:
        raise ProgramError(
            f"a pointer leads to byte {at + 1} of {most}: outside the variable it was made from"
            if size == 1
            else f"a pointer leads to bytes {at + 1} to {at + size} of {most}:"
            " outside the variable it was made from"
        )
