"""A program in a shared object, scanned in process; the base of the matiec and STruC++ engines.

The shared object exports `shim_start`, `shim_scan`, `shim_tick`, and the tables `shim_regions`,
`shim_sizes` and `shim_layout` (`native.c_layout.tables`). The regions hold the whole state of the
program. A snapshot is a copy of their bytes.
"""

from __future__ import annotations

import ctypes
import math
import os
import struct
import tempfile
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, groupby
from operator import itemgetter
from typing import Any, Literal, TypeVar

from structured_text.engines.base import OfProject, Value
from structured_text.engines.native.c_layout import (
    Codec,
    Dialect,
    Layout,
    layout_expressions,
    memory_at,
)
from structured_text.errors import COMMAND, InputError
from structured_text.language.paths import resolve
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, BlockType, ElementaryType, StructType, Type
from structured_text.language.values import array_length, describe, from_python
from structured_text.output import system

__all__ = ["NativeProgram", "layout_of"]

_P = TypeVar("_P", bound="NativeProgram")
_POINTER = struct.Struct("@P")
#: Size of an element [bytes], and its format character for `memoryview`.
_BYTES: dict[Type, tuple[int, Literal["B", "H"]]] = {
    ElementaryType("BYTE"): (1, "B"),
    ElementaryType("WORD"): (2, "H"),
}


@dataclass(frozen=True)
class _Slot:
    """The memory, the offset and the codec of the variable at a path."""

    path: str
    type: Type
    memory: memoryview
    at: int
    codec: Codec


@dataclass(frozen=True)
class _Cells:
    """The elements of an array of BYTE or WORD, which need not be contiguous.

    Attributes:
        memory: View of the elements.
        width: Size of an element [bytes].
        form: Format character of an element.
        size: Size of all elements [bytes].
    """

    memory: memoryview
    width: int
    form: Literal["B", "H"]
    size: int


@dataclass(frozen=True)
class _Snapshot:
    """The state of an instance, its state at the start, and the address of its memory."""

    image: bytes
    tick: int
    contents: tuple[bytes, ...]
    first: tuple[bytes, ...]
    base: int


class NativeProgram(OfProject):
    """One running instance of a compiled program; see `engines.base.Program`.

    Raises:
        InputError: The shared object cannot be loaded.
    """

    engine: str
    dialect: Dialect

    def __init__(self, project: Project, image: bytes) -> None:
        # A native scheduler counts in the tick of the tasks, also for programs without a task.
        intervals = [task.interval_us for task in project.tasks]
        self.tick_us = math.gcd(*intervals) if intervals else None
        self.project = project
        self._image = image
        library, self.close = _load_private_copy(self, image)
        self.check(library)
        self._scan = library.shim_scan
        self._scan.argtypes, self._scan.restype = [ctypes.c_longlong], ctypes.c_char_p
        self._tick = ctypes.c_ulonglong.in_dll(library, "shim_tick")
        table = _table(library, "shim_layout", ctypes.c_size_t)
        self._layout = Layout(_contained_types(project), table, self.dialect)
        places = _table(library, "shim_regions", ctypes.c_void_p)
        sizes = _table(library, "shim_sizes", ctypes.c_size_t)
        self._regions = [memory_at(*region) for region in zip(places, sizes, strict=True)]
        self._base = places[0]
        kinds: dict[str, Type] = dict(project.instances)
        kinds.update((variable.name, variable.type) for variable in project.globals.values())
        # An engine may add regions after those of the instances and globals, so the lists differ in
        # length.
        self._roots = {
            name: (kind, memory)
            for (name, kind), memory in zip(kinds.items(), self._regions, strict=False)
        }
        self._slots: dict[str, _Slot] = {}
        self._views: dict[str, _Cells] = {}
        library.shim_start()
        self._first = self._contents()

    def check(self, library: ctypes.PyDLL) -> None:
        """Check the loaded library before it is used.

        Subclasses for an engine override this method.
        """

    def instance(self: _P) -> _P:
        """Return another instance of the same program, in the state before the first scan."""
        return type(self)(self.project, self._image)

    def scan(self, now_us: int) -> None:
        """Run one base tick at PLC time `now_us` [µs].

        Endless loops are not ended. An index is checked only if the compiler's code does so. Raise
        InputError if the program divides an integer by zero, or accesses memory outside its own.
        """
        wrong = self._scan(now_us)
        if wrong is not None:
            raise InputError(
                wrong.decode("utf-8", "replace"),
                hint="run it with --engine builtin to see the file and line",
            )

    def read(self, path: str) -> Value:
        """Return the value at `path`."""
        slot = self._slot(path)
        return slot.codec.get(slot.memory, slot.at)

    def reader(self, paths: Sequence[str]) -> Callable[[], tuple[Value, ...]]:
        """Return a function that reads the variables at `paths`.

        See `engines.base.Program.reader`.
        """
        slots = [self._slot(path) for path in paths]
        parts = [_reader(list(part)) for _, part in groupby(slots, lambda one: id(one.memory))]
        if len(parts) == 1:
            return parts[0]
        return lambda: tuple(chain.from_iterable([part() for part in parts]))

    def write(self, path: str, value: Value) -> None:
        """Write a value to `path`; see `engines.base.Program.write`."""
        slot = self._slot(path)
        slot.codec.put(slot.memory, slot.at, from_python(slot.type, value, slot.path))

    def read_bytes(self, path: str, start: int = 0, size: int | None = None) -> bytes:
        """Return an array of BYTE or WORD as bytes (little endian); see `engines.base.Program`."""
        cells = self._views.get(path) or self._view(path)
        end = cells.size if size is None else start + size
        first, last = start // cells.width, -(-end // cells.width)
        return cells.memory[first:last].tobytes()[: end - start]

    def write_bytes(self, path: str, data: bytes, start: int = 0) -> None:
        """Set bytes of an array of BYTE or WORD; see `engines.base.Program`."""
        cells = self._views.get(path) or self._view(path)
        end = start + len(data)
        if end > cells.size or start % cells.width or end % cells.width:
            given = f"{len(data)} from byte {start} on" if start else f"{len(data)}"
            raise InputError(f"{path} holds {cells.size} bytes and cannot take {given}")
        first, last = start // cells.width, end // cells.width
        cells.memory[first:last] = memoryview(data).cast(cells.form)

    def type_of(self, path: str) -> Type:
        """Return the type of the variable at `path`."""
        return self._slot(path).type

    def note_calls(self, blocks: Mapping[str, int | None]) -> None:
        """Return None: calls inside compiled code cannot be observed."""

    def snapshot(self) -> object:
        """Return the whole state."""
        first, base = self._first, self._base
        return _Snapshot(self._image, self._tick.value, self._contents(), first, base)

    def restore(self, snapshot: object) -> None:
        """Restore a state that `snapshot` of this or another instance of the program has returned.

        Another instance has other addresses. Pointers into the instance's own memory are therefore
        not copied but set to their first values. Raise InputError if the snapshot belongs to
        another program.
        """
        if not isinstance(snapshot, _Snapshot) or snapshot.image != self._image:
            raise InputError("this snapshot belongs to another program")
        every = zip(self._regions, snapshot.contents, snapshot.first, self._first, strict=True)
        for memory, content, theirs, ours in every:
            memory[:] = content
            if theirs != ours:
                _keep_pointers(memory, theirs, ours, self._base - snapshot.base)
        self._tick.value = snapshot.tick

    def _contents(self) -> tuple[bytes, ...]:
        return tuple(memory.tobytes() for memory in self._regions)

    def _slot(self, path: str) -> _Slot:
        slot = self._slots.get(path)
        if slot is None:
            slot = self._slots[path] = self._find(path)
        return slot

    def _find(self, path: str) -> _Slot:
        found = resolve(self.project, path)
        kind, memory = self._roots[found.root]
        at = 0
        codec = self._layout.codec(kind, len(memory))
        for step in found.steps:
            if isinstance(kind, ArrayType):
                size = codec.size // array_length(kind)
                at += int(step) * size
                kind = kind.element
                codec = self._layout.codec(kind, size)
            elif isinstance(kind, (StructType, BlockType)):
                member = self._layout.member(kind, str(step))
                kind, codec = member.type, member.codec
                at += member.offset
        return _Slot(found.path, found.type, memory, at, codec)

    def _view(self, path: str) -> _Cells:
        slot = self._slot(path)
        kind = slot.type
        if not isinstance(kind, ArrayType) or kind.element not in _BYTES:
            raise InputError(
                f"{slot.path} is of type {describe(kind)}",
                hint="name an array of BYTE or WORD",
            )
        width, form = _BYTES[kind.element]
        count = array_length(kind)
        every = slot.memory[slot.at : slot.at + slot.codec.size].cast(form)
        cells = every[:: slot.codec.size // (count * width)]
        found = self._views[path] = _Cells(cells, width, form, count * width)
        return found


def _keep_pointers(memory: memoryview, theirs: bytes, ours: bytes, distance: int) -> None:
    """Set pointers into the instance's own memory to their first values.

    A word is such a pointer if its first values in two instances differ by the distance between the
    memories of these instances.
    """
    for at in range(0, len(ours) - _POINTER.size + 1, _POINTER.size):
        there, here = _POINTER.unpack_from(theirs, at)[0], _POINTER.unpack_from(ours, at)[0]
        if here - there == distance:
            _POINTER.pack_into(memory, at, here)


def _reader(slots: Sequence[_Slot]) -> Callable[[], tuple[Value, ...]]:
    """Return a function that reads variables in one memory; it unpacks numbers in a single call."""
    if all(one.codec.form for one in slots):
        packed = _packed_reader(slots)
        if packed is not None:
            return packed
    places = [(slot.codec.get, slot.memory, slot.at) for slot in slots]
    return lambda: tuple([get(memory, at) for get, memory, at in places])


def _packed_reader(slots: Sequence[_Slot]) -> Callable[[], tuple[Value, ...]] | None:
    """Return a function that reads numbers in one memory; None if two numbers overlap."""
    memory = slots[0].memory
    order = sorted(range(len(slots)), key=lambda k: slots[k].at)
    start = end = slots[order[0]].at
    form = "="
    for slot in (slots[k] for k in order):
        if slot.at < end:
            return None
        form += f"{slot.at - end}x{slot.codec.form}"
        end = slot.at + slot.codec.size
    unpack = struct.Struct(form).unpack_from
    if order == sorted(order):
        return lambda: unpack(memory, start)
    pick = itemgetter(*(order.index(k) for k in range(len(slots))))
    return lambda: pick(unpack(memory, start))


def layout_of(project: Project, dialect: Dialect) -> tuple[str, ...]:
    """Return the C expressions of a project's table `shim_layout`."""
    return tuple(layout_expressions(_contained_types(project), dialect))


def _contained_types(project: Project) -> list[StructType | BlockType]:
    """Return the structures and blocks of the program, each after the types that it contains."""
    found: dict[str, StructType | BlockType] = {}

    def visit(kind: Type) -> None:
        if isinstance(kind, ArrayType):
            visit(kind.element)
        elif isinstance(kind, (StructType, BlockType)) and kind.name.upper() not in found:
            if isinstance(kind, StructType):
                inner = [field for _, field in kind.fields]
            else:
                inner = [variable.type for variable in kind.variables]
            for part in inner:
                visit(part)
            found.setdefault(kind.name.upper(), kind)

    for block in project.instances.values():
        visit(block)
    for variable in project.globals.values():
        visit(variable.type)
    return list(found.values())


def _load_private_copy(
    owner: object, image: bytes
) -> tuple[ctypes.PyDLL, weakref.finalize[..., object]]:
    """Load a shared object from a temporary file of its own.

    The system loads a file only once, so two instances from the same file would share data.

    Returns:
        The library, and the call that unloads it (at the latest when `owner` is collected).
    """
    with tempfile.NamedTemporaryFile(prefix=f"{COMMAND}-", suffix=system.DLL, delete=False) as file:
        file.write(image)
    try:
        # PyDLL keeps the GIL: only one thread may scan, because the handlers of faults.h belong to
        # the process.
        library = ctypes.PyDLL(file.name)
    except OSError as error:
        os.unlink(file.name)
        raise InputError(
            f"the compiled program cannot be loaded: {error}",
            hint="set TMPDIR to a directory from which programs may be run",
        ) from None
    system.loaded(file.name)
    handle = library._handle  # noqa: SLF001
    return library, weakref.finalize(owner, system.unload, handle, file.name)


def _table(library: ctypes.PyDLL, name: str, kind: Any) -> list[Any]:
    count = ctypes.c_size_t.in_dll(library, f"{name}_count").value
    return list((kind * count).in_dll(library, name))
