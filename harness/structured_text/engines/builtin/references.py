"""Pointers and references of generated code, and their form in a snapshot.

A pointer is an object with an attribute `V`, through which its target is read and written. The
target lives as long as its program instance, so a pointer needs no address. A snapshot may be
restored by another instance. A snapshot therefore contains, for each pointer, the path from a
program instance to its target: the names of slots and the positions in lists.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple, NoReturn

from structured_text.engines.builtin.byte_views import (
    Elements,
    Fields,
    Held,
    Layout,
    Number,
    Opaque,
    Row,
    Union,
    View,
)
from structured_text.engines.builtin.heap import kinds_of
from structured_text.engines.builtin.runtime import MemoryAccessError, ProgramError
from structured_text.engines.builtin.storage import is_scalar, slot_name, stored
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, BlockType, StructType, Type
from structured_text.language.values import indices_at

__all__ = ["NAMES", "Holders", "Item", "Slot"]


class _Movable:
    """The base of pointers that move by whole elements only."""

    __slots__ = ()

    def at(self, offset: int) -> Any:
        """Return a pointer that is `offset` elements further on."""
        raise NotImplementedError

    def moved(self, offset: int, size: int) -> Any:
        """Return a pointer that is `offset` bytes further on; `size` is the size of an element."""
        count, rest = divmod(offset, size)
        if rest:
            raise MemoryAccessError(
                f"a pointer is moved by {offset} bytes; its elements have {size}"
            )
        return self.at(count)


class Slot(_Movable):
    """A pointer to a scalar variable of an object."""

    __slots__ = ("holder", "key")

    def __init__(self, holder: Any, key: str) -> None:
        self.holder, self.key = holder, key

    @property
    def V(self) -> Any:  # noqa: N802 (all names of Structured Text are in upper case)
        """Return the value of the variable that the pointer refers to."""
        return getattr(self.holder, self.key)

    @V.setter
    def V(self, value: Any) -> None:  # noqa: N802
        setattr(self.holder, self.key, value)

    def at(self, offset: int) -> Slot:
        """Return this pointer; raise MemoryAccessError if `offset` is not 0."""
        if offset:
            raise MemoryAccessError(f"a pointer to {self.key} leads {offset} elements beyond it")
        return self


class Item(_Movable):
    """A pointer to an element of an array; its position is checked on access, not before."""

    __slots__ = ("holder", "key")

    def __init__(self, holder: list[Any], key: int) -> None:
        self.holder, self.key = holder, key

    def _inside(self) -> int:
        if 0 <= self.key < len(self.holder):
            return self.key
        raise MemoryAccessError(
            f"a pointer leads to element {self.key + 1} of an array of {len(self.holder)}"
        )

    @property
    def V(self) -> Any:  # noqa: N802
        """Return the value of the array element that the pointer refers to."""
        return self.holder[self._inside()]

    @V.setter
    def V(self, value: Any) -> None:  # noqa: N802
        self.holder[self._inside()] = value

    def at(self, offset: int) -> Item:
        """Return a pointer that is `offset` elements further on."""
        return Item(self.holder, self.key + offset)


class Whole(_Movable):
    """A pointer to a structure, block or whole array."""

    __slots__ = ("V",)

    def __init__(self, value: Any) -> None:
        self.V = value

    def at(self, offset: int) -> Whole:
        """Return this pointer; raise MemoryAccessError if `offset` is not 0."""
        if offset:
            raise MemoryAccessError(f"a pointer leads {offset} elements beyond its variable")
        return self


class _Null:
    """The null pointer; a single object."""

    __slots__ = ()

    def _refuse(self, *_: Any) -> NoReturn:
        raise MemoryAccessError("the pointer is 0 (NULL), or the reference refers to nothing")

    V = property(_refuse, _refuse)
    at = moved = _refuse

    def __reduce__(self) -> str:
        return "_NULL"


class _NoBlock:
    """The value of an interface variable before a block is assigned; a single object."""

    __slots__ = ()

    def __getattr__(self, name: str) -> NoReturn:
        if name.startswith("__"):
            raise AttributeError(name)
        raise MemoryAccessError("no block has been assigned to this variable of an interface")

    def __reduce__(self) -> str:
        return "_NO_BLOCK"


_NULL, _NO_BLOCK = _Null(), _NoBlock()


def _same(one: Any, other: Any) -> bool:
    """Return whether two pointers or interface values have the same target."""
    if one is other:
        return True
    if one is _NULL or other is _NULL:
        return False
    first, second = _place(one), _place(other)
    return first[0] is second[0] and first[1] == second[1]


def _asked(block: Any, names: Collection[str]) -> Any:
    """Return a block if `names` contains the name of its class, else the value for "no block"."""
    return block if type(block).__name__ in names else _NO_BLOCK


#: Limits for variables made while a program runs. Beyond them `__NEW` returns 0.
_MOST_MADE, _LONGEST_ROW = 100_000, 1_000_000


def _new(shared: Any, held: Any, number: int) -> Any:
    """Start a new variable and return a pointer to it; 0 (NULL) if the heap is full."""
    if len(shared.heap) >= _MOST_MADE:
        return _NULL
    shared.heap.put(held, number)
    begin = getattr(type(held), "begin", None)
    if begin is not None:
        begin(held)
    return Item(held, 0) if isinstance(held, list) else Whole(held)


def _new_row(shared: Any, number: int, count: int, make: Callable[[], Any]) -> Any:
    """Return a pointer to the first of several new variables; 0 (NULL) if the heap is full."""
    if not 0 < count <= _LONGEST_ROW:
        return _NULL
    return _new(shared, [make() for _ in range(count)], number)


def _delete(shared: Any, pointer: Any) -> None:
    """Call the exit methods of a variable made by `_new`, and remove it from the heap."""
    if pointer is _NULL:
        return
    if isinstance(pointer, View) and isinstance(pointer.memory, Held):
        # The pointer was recast: the exit methods belong to its original type.
        pointer = pointer.memory.pointer
    held = getattr(pointer, "V" if isinstance(pointer, Whole) else "holder", None)
    if id(held) not in shared.heap:
        raise MemoryAccessError("__DELETE needs a pointer to a variable that __NEW has made")
    for leave in getattr(type(held), "exits", ()):
        leave(held, *[False] * (leave.__code__.co_argcount - 1))
    shared.heap.drop(held)


def _place(pointer: Any) -> tuple[Any, Any]:
    if isinstance(pointer, Whole):
        return pointer.V, None
    if isinstance(pointer, Item) and 0 <= pointer.key < len(pointer.holder):
        value = pointer.holder[pointer.key]
        if not isinstance(value, (bool, int, float, str, Slot, Item, Whole, View, _Null, _NoBlock)):
            return value, None
    return pointer.holder, pointer.key


def _viewed(pointer: Any, layout: Layout) -> View:
    """Return a pointer as a view: the memory of its target, and the position in it [bytes]."""
    if isinstance(pointer, View):
        return pointer
    held: Any
    if isinstance(pointer, Whole):
        held = pointer.V
        if isinstance(held, (Elements, Fields)):
            return View(held.memory, held.at, layout)
        return View(Held(pointer, layout), 0, layout)
    held = pointer.holder
    if isinstance(held, Elements):
        return View(held.memory, held.place(pointer.key), layout)
    if isinstance(held, Fields):
        return View(held.memory, held.at + held.places[pointer.key][0], layout)
    if isinstance(held, list):
        row = Row(layout, len(held))
        return View(Held(Whole(held), row), pointer.key * layout.size, layout)
    return View(Held(pointer, layout), 0, layout)


def _recast(pointer: Any, own: Layout, other: Layout) -> Any:
    """Return a pointer to the same memory, with another type."""
    if pointer is _NULL:
        return pointer
    view = _viewed(pointer, own)
    memory = view.memory
    if isinstance(memory, Held):
        whole, rest = memory.layout, view.at_ % other.size
        known = isinstance(whole, Opaque) and not view.at_
        if isinstance(other, Opaque) and known and other.fits(memory.pointer.V):
            return memory.pointer
        if isinstance(whole, Row) and whole.element == other and not rest:
            # The pointer gets its original type back, so no view is needed.
            return Item(memory.pointer.V, view.at_ // other.size)
        if whole == other and not view.at_:
            return memory.pointer
    return View(memory, view.at_, other)


def _address(pointer: Any) -> int:
    """Return 0 as the number of the null pointer; raise MemoryAccessError for other pointers."""
    if pointer is _NULL:
        return 0
    raise MemoryAccessError(
        "the address of a variable has no number here, because it differs from run to run"
    )


_BYTE = Number("<B", 1)


def _bytes_at(pointer: Any) -> View | None:
    """Return a pointer to BYTE as a view; None if it is 0 (NULL)."""
    return None if pointer is _NULL else _viewed(pointer, _BYTE)


def _memmove(to: Any, of: Any, count: int) -> int:
    """Copy bytes, and return their number; 0 if an address or the number is 0."""
    target, source = _bytes_at(to), _bytes_at(of)
    if target is None or source is None or count <= 0:
        return 0
    target.memory.write(target.at_, source.memory.read(source.at_, count))
    return count


def _memset(to: Any, byte: int, count: int) -> int:
    """Set bytes, and return their number; 0 if the address or the number is 0."""
    target = _bytes_at(to)
    if target is None or count <= 0:
        return 0
    target.memory.write(target.at_, bytes((byte & 0xFF,)) * count)
    return count


def _memcmp(one: Any, other: Any, count: int) -> int:
    """Compare bytes and return -1, 0 or 1; return 16#FF if an address or the number is 0."""
    first, second = _bytes_at(one), _bytes_at(other)
    if first is None or second is None or count <= 0:
        return 0xFF
    left = first.memory.read(first.at_, count)
    right = second.memory.read(second.at_, count)
    return (left > right) - (left < right)


def _order(one: Any, other: Any, layout: Layout) -> int:
    """Return the distance between two pointers [bytes]; 0 (NULL) precedes all others.

    Raises:
        ProgramError: The pointers refer to different variables.
    """
    if one is _NULL or other is _NULL:
        return (one is not _NULL) - (other is not _NULL)
    first, second = _viewed(one, layout), _viewed(other, layout)
    if _base(first.memory) == _base(second.memory):
        return first.at_ - second.at_
    raise _ElsewhereError


class _ElsewhereError(ProgramError):
    """The error for a comparison of pointers into different variables, which have no order."""

    def __init__(self) -> None:
        super().__init__("pointers to different variables have no order")


def _unlike(one: Any, other: Any, layout: Layout) -> bool:
    """Return whether two pointers have different targets."""
    try:
        return _order(one, other, layout) != 0
    except _ElsewhereError:
        return True


def _base(memory: Any) -> tuple[int, Any]:
    """Return a key that identifies a variable's memory.

    All views of one variable have the same key.
    """
    if not isinstance(memory, Held):
        return id(memory), None
    pointer = memory.pointer
    if isinstance(pointer, Whole):
        return id(pointer.V), None
    return id(pointer.holder), pointer.key


#: First step of the path to a variable made by `__NEW`; no program instance has this name.
_MADE = "__NEW"
#: The functions and classes for pointers that generated code can use, by name.
NAMES: dict[str, Any] = {
    "recast": _recast,
    "order": _order,
    "unlike": _unlike,
    "Slot": Slot,
    "Item": Item,
    "Whole": Whole,
    "null": _NULL,
    "no_block": _NO_BLOCK,
    "same": _same,
    "address": _address,
    "memcpy": _memmove,
    "memmove": _memmove,
    "memset": _memset,
    "memcmp": _memcmp,
    "asked": _asked,
    "heap_new": _new,
    "heap_row": _new_row,
    "heap_delete": _delete,
}


# --- snapshots ---


class _Held(NamedTuple):
    """A pointer in a snapshot: its class, the path to its holder, and the slot or position."""

    kind: str
    way: tuple[Any, ...] | None
    key: str | int | None


class _Found(NamedTuple):
    """An object or list: the code to reach it, its path in user notation, and its type."""

    way: tuple[str | int, ...]
    path: str
    type: Type


class Holders:
    """All objects and lists of a program instance, by identity, with the paths to them.

    `BuiltinProgram` uses it to save and load pointers in snapshots.
    """

    def __init__(self, project: Project, shared: Any, roots: Mapping[str, Any]) -> None:
        self._project = project
        self._shared, self._roots = shared, roots
        self._found: dict[int, _Found] = {}
        self._kinds = kinds_of(project)
        self._version = 0

    def find(self, held: Any) -> _Found | None:
        """Return the entry of an object; None if it belonged to a call that has ended."""
        if self._version != self._shared.heap.version:
            self._found, self._version = {}, self._shared.heap.version
        if not self._found:
            for place, (made, number) in enumerate(self._shared.heap.values()):
                self._walk_made(made, self._kinds[number], place)
            for symbol in self._project.global_symbols.values():
                if symbol.address is None:
                    value = getattr(self._shared, symbol.name.upper())
                    self._walk(value, symbol.type, ("", symbol.name.upper()), symbol.name)
            self._found[id(self._shared)] = _Found(("",), "", BlockType("globals"))
            for name, kind in self._project.instances.items():
                self._walk(self._roots[name], kind, (name,), name)
        return self._found.get(id(held))

    def _walk_made(self, held: Any, kind: Type, place: int) -> None:
        """Find the objects of a variable made by `__NEW`.

        `place` is the index of the variable in the heap.
        """
        path = f"{_MADE}[{place + 1}]"
        if not isinstance(held, list):
            self._walk(held, kind, (_MADE, place), path)
            return
        self._found[id(held)] = _Found((_MADE, place), path, ArrayType("", ((0, 0),), kind))
        for position, part in enumerate(held if not is_scalar(kind) else ()):
            self._walk(part, kind, (_MADE, place, position), f"{path}[{position}]")

    def _walk(self, held: Any, kind: Type, way: tuple[str | int, ...], path: str) -> None:
        if isinstance(kind, (StructType, BlockType)):
            self._found[id(held)] = _Found(way, path, kind)
            for name, part in self._members(kind) if not isinstance(held, Union) else ():
                slot = slot_name(name)
                self._walk(getattr(held, slot), part, (*way, slot), f"{path}.{name}")
        elif isinstance(kind, ArrayType):
            self._found[id(held)] = _Found(way, path, kind)
            if not is_scalar(kind.element):
                for position, part in enumerate(held):
                    element = f"{path}[{_shown(kind, position)}]"
                    self._walk(part, kind.element, (*way, position), element)

    def _members(self, kind: StructType | BlockType) -> Iterable[tuple[str, Type]]:
        if isinstance(kind, StructType):
            return kind.fields
        pou = self._project.pous.get(kind.name.upper())
        symbols = stored(pou.symbols.values()) if pou is not None else []
        return [(symbol.name, symbol.type) for symbol in symbols]

    def _at(self, way: tuple[str | int, ...]) -> Any:
        held, rest = self._shared, way[1:]
        if way[0] == _MADE:
            held, rest = list(self._shared.heap.values())[int(way[1])][0], way[2:]
        elif way[0]:
            held = self._roots[str(way[0])]
        for key in rest:
            held = held[key] if isinstance(key, int) else getattr(held, key)
        return held

    def saved(self, value: Any) -> Any:
        """Return a value of a snapshot with all pointers replaced by paths."""
        if isinstance(value, (tuple, list)):
            return type(value)(self.saved(part) for part in value)
        if isinstance(value, (bool, int, float, str, bytes, _Null, _NoBlock)):
            return value
        held = getattr(value, "holder", None)
        if isinstance(held, (Elements, Fields)) and self.find(held) is None:
            # The holder is a temporary view. Therefore the memory behind the view is saved.
            whole = held.row if isinstance(held, Elements) else held.record
            view = self.saved(View(held.memory, held.at, whole))
            return _Held(type(value).__name__, ("", view), value.key)
        if isinstance(value, View):
            return _Held("View", ("", self._saved_memory(value.memory), value.layout), value.at_)
        if isinstance(value, (Slot, Item)):
            found = self.find(value.holder)
            return _Held(type(value).__name__, found and found.way, value.key)
        found = self.find(value.V if isinstance(value, Whole) else value)
        return _Held("Whole" if isinstance(value, Whole) else "", found and found.way, None)

    def loaded(self, value: Any) -> Any:
        """Return a saved value with pointers into this program instance.

        A pointer to a variable of a call that has ended becomes NULL.
        """
        if isinstance(value, _Held):
            if value.way is None:
                return _NULL if value.kind else _NO_BLOCK
            if value.kind == "View":
                memory = self._loaded_memory(value.way[1])
                return _NULL if memory is None else View(memory, int(value.key or 0), value.way[2])
            held = self._at(value.way) if not isinstance(value.way[-1], _Held) else None
            if held is None:
                view = self.loaded(value.way[-1])
                if view is _NULL:
                    return _NULL
                held = view.V
            if value.kind == "Slot":
                return Slot(held, str(value.key))
            if value.kind == "Item":
                return Item(held, int(value.key or 0))
            return Whole(held) if value.kind else held
        if isinstance(value, (tuple, list)):
            return type(value)(self.loaded(part) for part in value)
        return value

    def _saved_memory(self, memory: Any) -> Any:
        """Return the saved form of a view's memory: a union, or a variable with its layout."""
        if isinstance(memory, Held):
            return self.saved(memory.pointer), memory.layout
        found = self.find(memory)
        return found and found.way

    def _loaded_memory(self, saved: Any) -> Any:
        if saved is None:
            return None
        if isinstance(saved[0], _Held):
            pointer = self.loaded(saved[0])
            return None if pointer is _NULL else Held(pointer, saved[1])
        return self._at(saved)

    def path(self, pointer: Any) -> str:
        """Return the path of a pointer's target; empty for NULL, `?` if the target has no path."""
        if isinstance(pointer, (_Null, _NoBlock)):
            return ""
        if isinstance(pointer, View):
            memory, at = pointer.memory, pointer.at_
            found = self.find(memory)
            base = self.path(memory.pointer) if isinstance(memory, Held) else ""
            base = found.path if found is not None else base
            return base if base in ("", "?") or not at else f"{base}+{at}"
        if isinstance(pointer, (Slot, Item)):
            if isinstance(pointer.holder, (Elements, Fields)):
                found = self.find(pointer.holder)
                if found is None:
                    return self.path(_viewed(pointer, Row(Number("?", 1), 0)))
            found = self.find(pointer.holder)
            if found is None:
                return "?"
            if isinstance(pointer, Slot):
                name = self._declared(found.type, pointer.key)
                return f"{found.path}.{name}" if found.path else name
            assert isinstance(found.type, ArrayType)
            inside = 0 <= pointer.key < len(pointer.holder)
            return f"{found.path}[{_shown(found.type, pointer.key)}]" if inside else "?"
        found = self.find(pointer.V if isinstance(pointer, Whole) else pointer)
        return found.path if found is not None else "?"

    def _declared(self, kind: Type, slot: str) -> str:
        """Return the name of a member in its declared spelling."""
        if isinstance(kind, BlockType) and kind.name == "globals":
            symbol = self._project.global_symbols.get(slot)
            return symbol.name if symbol is not None else slot
        assert isinstance(kind, (StructType, BlockType))
        names = [name for name, _ in self._members(kind) if slot_name(name) == slot]
        return names[0] if names else slot


def _shown(kind: ArrayType, position: int) -> str:
    """Return the indices of an element as they are written in brackets."""
    return ",".join(map(str, indices_at(kind, position)))
