"""Memory viewed as bytes: unions, and pointers to memory of another type.

A layout describes a value of a type in memory: little endian, with each field at a multiple of its
own alignment, as `language.sizes` computes it. Variables remain Python values. A variable is packed
to bytes only if it is accessed as another type. Changed bytes are unpacked into the variable.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

from structured_text.engines.builtin.runtime import MemoryAccessError

__all__ = [
    "NAMES",
    "Bit",
    "Character",
    "Elements",
    "Fields",
    "Held",
    "Layout",
    "Moment",
    "Number",
    "Opaque",
    "Pointer",
    "Record",
    "Row",
    "Text",
    "Union",
    "View",
]


class ByteRange(Protocol):
    """A range of bytes that can be read and written."""

    def read(self, at: int, size: int) -> bytes:
        """Return `size` bytes from position `at`."""

    def write(self, at: int, data: bytes) -> None:
        """Write bytes at position `at`."""


# --- layouts: values in memory ----------------------------------------------------------------


class _Scalar:
    """The common base of scalar layouts, which pack and unpack a value as a whole."""

    size: int

    def pack(self, value: Any) -> bytes:
        """Return the bytes of a value."""
        raise NotImplementedError

    def unpack(self, data: bytes) -> Any:
        """Return the value that the bytes represent."""
        raise NotImplementedError

    def read(self, value: Any, at: int, size: int) -> bytes:
        """Return `size` bytes of a value, from position `at`."""
        return self.pack(value)[at : at + size]

    def write(self, value: Any, at: int, data: bytes) -> Any:
        """Return the value after `data` has replaced its bytes from position `at` on."""
        if at == 0 and len(data) == self.size:
            return self.unpack(data)
        held = bytearray(self.pack(value))
        held[at : at + len(data)] = data
        return self.unpack(bytes(held))

    def look(self, memory: ByteRange, at: int) -> Any:
        """Return the value at a position in memory."""
        return self.unpack(memory.read(at, self.size))

    def store(self, memory: ByteRange, at: int, value: Any) -> None:
        """Write a value to a position in memory."""
        memory.write(at, self.pack(value))


@dataclass(frozen=True)
class Number(_Scalar):
    """The layout of a number, bit string or BOOL; `code` is its format for `struct`."""

    code: str
    size: int

    def pack(self, value: Any) -> bytes:
        """Return the bytes of a number."""
        return struct.pack(self.code, value)

    def unpack(self, data: bytes) -> Any:
        """Return the number that the bytes represent."""
        return struct.unpack(self.code, data)[0]


@dataclass(frozen=True)
class Bit(_Scalar):
    """The layout of a BIT: bit `number` of a byte.

    The other bits of the byte belong to other fields.
    """

    number: int
    size: int = 1

    def pack(self, value: Any) -> bytes:
        """Return the byte of a BIT; its other bits are 0."""
        return bytes((bool(value) << self.number,))

    def unpack(self, data: bytes) -> Any:
        """Return the value of the BIT in a byte."""
        return bool(data[0] >> self.number & 1)

    def store(self, memory: ByteRange, at: int, value: Any) -> None:
        """Write a bit to a position in memory."""
        others = memory.read(at, 1)[0] & ~(1 << self.number)
        memory.write(at, bytes((others | bool(value) << self.number,)))


@dataclass(frozen=True)
class Moment(_Scalar):
    """The layout of a duration or date.

    The Python value is an int in ns. In memory the number counts units of `unit` ns.
    """

    unit: int
    size: int
    signed: bool = False

    def pack(self, value: Any) -> bytes:
        """Return the bytes of a duration or date."""
        count: int = value // self.unit
        return (count & (1 << 8 * self.size) - 1).to_bytes(self.size, "little")

    def unpack(self, data: bytes) -> Any:
        """Return the duration or date that the bytes represent."""
        return int.from_bytes(data, "little", signed=self.signed) * self.unit


@dataclass(frozen=True)
class Text(_Scalar):
    """The layout of a text with a 0 at its end; `width` is 1 or 2 bytes per character.

    Characters behind the first 0 remain part of the value, until the text is assigned as a whole.
    """

    size: int
    width: int

    def pack(self, value: Any) -> bytes:
        """Return the bytes of a text."""
        if self.width == 1:
            data: bytes = value.encode("latin-1")
        else:
            data = struct.pack(f"<{len(value)}H", *map(ord, value))
        return data.ljust(self.size, b"\0")

    def unpack(self, data: bytes) -> Any:
        """Return the text that the bytes represent."""
        held = data[: self.size - self.width]
        if self.width == 1:
            return held.rstrip(b"\0").decode("latin-1")
        codes = struct.unpack(f"<{len(held) // 2}H", held)
        return "".join(map(chr, codes)).rstrip("\0")


@dataclass(frozen=True)
class Character(_Scalar):
    """The layout of a CHAR or WCHAR."""

    size: int

    def pack(self, value: Any) -> bytes:
        """Return the bytes of a character."""
        return ord(value).to_bytes(self.size, "little")

    def unpack(self, data: bytes) -> Any:
        """Return the character that the bytes represent."""
        return chr(int.from_bytes(data, "little"))


@dataclass(frozen=True)
class Pointer(_Scalar):
    """The layout of a pointer: it takes 4 bytes, but they cannot be read or written."""

    size: int = 4

    def pack(self, value: Any) -> bytes:
        """Raise MemoryAccessError: a pointer has no readable bytes."""
        raise MemoryAccessError("a pointer cannot be accessed as bytes")

    def unpack(self, data: bytes) -> Any:
        """Raise MemoryAccessError: bytes cannot become a pointer."""
        raise MemoryAccessError("bytes cannot be accessed as a pointer")


@dataclass(frozen=True)
class Opaque:
    """The layout of a block, an interface, or a structure that contains one; its bytes are unknown.

    A pointer to it can become a pointer to another type and back. `slots` are the variables that a
    block or structure must have to be the target of such a pointer.
    """

    name: str
    size: int
    slots: tuple[str, ...]

    def fits(self, value: Any) -> bool:
        """Return whether a block or structure has all variables that this layout requires."""
        return all(hasattr(value, slot) for slot in self.slots)

    def read(self, value: Any, at: int, size: int) -> bytes:
        """Raise MemoryAccessError: the bytes are not known."""
        raise MemoryAccessError(f"{self.name} cannot be accessed as bytes")

    def write(self, value: Any, at: int, data: bytes) -> Any:
        """Raise MemoryAccessError: the bytes are not known."""
        raise MemoryAccessError(f"{self.name} cannot be accessed as bytes")

    def look(self, memory: ByteRange, at: int) -> Any:
        """Raise MemoryAccessError: memory of another type cannot be read as this type."""
        raise MemoryAccessError(f"bytes cannot be accessed as {self.name}")

    def store(self, memory: ByteRange, at: int, value: Any) -> None:
        """Raise MemoryAccessError: memory of another type cannot be written as this type."""
        raise MemoryAccessError(f"bytes cannot be accessed as {self.name}")


class _Composite:
    """The common base of the layouts of structures, unions and arrays.

    These values are not unpacked as a whole: a view reads and writes single elements in memory.
    """

    size: int

    def look(self, memory: ByteRange, at: int) -> Any:
        raise NotImplementedError

    def read(self, value: Any, at: int, size: int) -> bytes:
        raise NotImplementedError

    def store(self, memory: ByteRange, at: int, value: Any) -> None:
        """Write a value to a position in memory."""
        memory.write(at, self.read(value, 0, self.size))


@dataclass(frozen=True)
class Row(_Composite):
    """The layout of an array: `count` elements of the same layout."""

    element: Layout
    count: int

    @property
    def size(self) -> int:  # type: ignore[override]
        """Return the size of all elements [bytes]."""
        return self.element.size * self.count

    def read(self, value: Any, at: int, size: int) -> bytes:
        """Return `size` bytes, from position `at`, of a list or of an `Elements` view."""
        step = self.element.size
        first, end = at // step, -(-(at + size) // step)
        data = b"".join(self.element.read(value[k], 0, step) for k in range(first, end))
        return data[at - first * step :][:size]

    def write(self, value: Any, at: int, data: bytes) -> Any:
        """Replace the bytes of an array, which is a list, from position `at` on by `data`."""
        step, behind = self.element.size, at + len(data)
        for k in range(at // step, -(-behind // step)):
            begin, end = max(at, k * step), min(behind, (k + 1) * step)
            part = data[begin - at : end - at]
            value[k] = self.element.write(value[k], begin - k * step, part)
        return value

    def look(self, memory: ByteRange, at: int) -> Elements:
        """Return a view of the array at a position in memory."""
        return Elements(memory, at, self)


@dataclass(frozen=True)
class Record(_Composite):
    """The layout of a structure: for each field the slot, the position and the layout.

    In a union, all positions are 0.
    """

    fields: tuple[tuple[str, int, Layout], ...]
    size: int
    union: bool = False

    def read(self, value: Any, at: int, size: int) -> bytes:
        """Return `size` bytes, from position `at`, of a structure or of a `Fields` view."""
        if self.union:
            found: bytes = value.memory.read(value.at + at, size)
            return found
        data = bytearray(size)
        for slot, place, layout in self.fields:
            begin, end = max(at, place), min(at + size, place + layout.size)
            if begin < end:
                part = layout.read(getattr(value, slot), begin - place, end - begin)
                if isinstance(layout, Bit):
                    part = bytes((data[begin - at] | part[0],))
                data[begin - at : end - at] = part
        return bytes(data)

    def write(self, value: Any, at: int, data: bytes) -> Any:
        """Replace the bytes of a structure from position `at` on.

        Bytes between its fields are ignored.
        """
        if self.union:
            value.memory.write(value.at + at, data)
            return value
        for slot, place, layout in self.fields:
            begin, end = max(at, place), min(at + len(data), place + layout.size)
            if begin < end:
                old = getattr(value, slot)
                new = layout.write(old, begin - place, data[begin - at : end - at])
                if new is not old:
                    setattr(value, slot, new)
        return value

    def look(self, memory: ByteRange, at: int) -> Fields:
        """Return a view of the structure at a position in memory."""
        return Fields(memory, at, self)


#: The classes of layouts that generated code can use, by name.
NAMES: dict[str, Any] = {
    one.__name__: one
    for one in (Number, Bit, Moment, Text, Character, Pointer, Opaque, Row, Record)
}
Layout: TypeAlias = Number | Bit | Moment | Text | Character | Pointer | Opaque | Row | Record


# --- views ------------------------------------------------------------------------------------


class Elements:
    """A view of bytes as an array, with the interface of a list of the elements."""

    __slots__ = ("at", "memory", "row")

    def __init__(self, memory: ByteRange, at: int, row: Row) -> None:
        self.memory, self.at, self.row = memory, at, row

    def place(self, position: int) -> int:
        """Return the position in memory [bytes] of the element with the index `position`."""
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
    """A view of bytes as a structure; its fields are attributes, in upper case."""

    __slots__ = ("at", "memory", "places", "record")

    def __init__(self, memory: ByteRange, at: int, record: Record) -> None:
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
    """A variable of a union type, with the bytes that all its fields share."""

    __slots__ = ("held",)

    def __init__(self, record: Record) -> None:
        super().__init__(self, 0, record)
        object.__setattr__(self, "held", bytearray(record.size))

    def read(self, at: int, size: int) -> bytes:
        """Return `size` of the shared bytes, from position `at`."""
        _check(at, size, len(self.held))
        return bytes(self.held[at : at + size])

    def write(self, at: int, data: bytes) -> None:
        """Write `data` to the shared bytes, from position `at` on."""
        _check(at, len(data), len(self.held))
        self.held[at : at + len(data)] = data


class Held:
    """The memory of a variable that a pointer refers to; each access packs or unpacks its value."""

    __slots__ = ("layout", "pointer")

    def __init__(self, pointer: Any, layout: Layout) -> None:
        self.pointer, self.layout = pointer, layout

    def read(self, at: int, size: int) -> bytes:
        """Return `size` bytes of the variable, from position `at`."""
        _check(at, size, self.layout.size)
        return self.layout.read(self.pointer.V, at, size)

    def write(self, at: int, data: bytes) -> None:
        """Write `data` to the bytes of the variable, from position `at` on."""
        _check(at, len(data), self.layout.size)
        old = self.pointer.V
        new = self.layout.write(old, at, data)
        if new is not old:
            self.pointer.V = new


NAMES["Union"] = Union


class View:
    """A pointer to memory that is read as another type; each access checks the position."""

    __slots__ = ("at_", "layout", "memory")

    def __init__(self, memory: ByteRange, at: int, layout: Layout) -> None:
        self.memory, self.at_, self.layout = memory, at, layout

    @property
    def V(self) -> Any:  # noqa: N802 (as other pointers have it)
        """Return the value that the bytes at the pointer's position represent."""
        return self.layout.look(self.memory, self.at_)

    @V.setter
    def V(self, value: Any) -> None:  # noqa: N802
        self.layout.store(self.memory, self.at_, value)

    def at(self, offset: int) -> View:
        """Return a pointer that is `offset` elements further on."""
        return View(self.memory, self.at_ + offset * self.layout.size, self.layout)

    def moved(self, offset: int, size: int) -> View:
        """Return a pointer that is `offset` bytes further on."""
        del size
        return View(self.memory, self.at_ + offset, self.layout)


def _check(at: int, size: int, most: int) -> None:
    if at < 0 or at + size > most:
        raise MemoryAccessError(
            f"a pointer leads to byte {at + 1} of {most}: outside the variable it was made from"
            if size == 1
            else f"a pointer leads to bytes {at + 1} to {at + size} of {most}:"
            " outside the variable it was made from"
        )
