"""The reference engine: ST translated by matiec's iec2c, compiled to C, scanned in process."""

from __future__ import annotations

import _ctypes
import ctypes
import os
import struct
import tempfile
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, groupby
from operator import itemgetter
from typing import Any

from rcx_harness.engine.base import Located, Value
from rcx_harness.engine.frontend.paths import resolve, walk
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.frontend.values import array_length, describe, from_python
from rcx_harness.engine.matiec.build import Matiec, TranslationError, Wanted, compile_program
from rcx_harness.engine.matiec.memory import Codec, Layout, layout_expressions, memory_at
from rcx_harness.engine.matiec.source import HIDDEN_INSTANCE, explain, join_sources
from rcx_harness.engine.types import ArrayType, BlockType, ElementaryType, StructType, Type
from rcx_harness.errors import InputError

__all__ = ["MatiecProgram"]

_POINTER = ctypes.sizeof(ctypes.c_void_p)
_BYTES = (ElementaryType("BYTE"), ElementaryType("WORD"))


class _Region(ctypes.Structure):
    """`rcx_region` of matiec_runtime.c."""

    _fields_ = [("address", ctypes.c_void_p), ("size", ctypes.c_size_t)]


@dataclass(frozen=True)
class _Slot:
    """Where the variable of a path lies."""

    path: str
    type: Type
    memory: memoryview
    at: int
    codec: Codec


@dataclass(frozen=True)
class _Snapshot:
    image: bytes
    tick: int
    contents: tuple[bytes, ...]


class MatiecProgram:
    """One running instance of a program that matiec compiled; see `engine.base.Program`.

    Args:
        project: The checked sources.
        image: The shared object made of them.

    Raises:
        InputError: the shared object cannot be loaded.
    """

    engine = "matiec"

    def __init__(self, project: Project, image: bytes) -> None:
        self.tick_us = project.tick_us
        self._project = project
        self._image = image
        library, self.close = _load_private_copy(self, image)
        self._scan = library.rcx_scan
        self._scan.argtypes = [ctypes.c_longlong]
        self._tick = ctypes.c_ulong.in_dll(library, "rcx_tick")
        types = _contained_types(project)
        self._layout = Layout(types, _table(library, "rcx_layout", ctypes.c_size_t))
        regions = _table(library, "rcx_regions", _Region)
        self._regions = [memory_at(region.address, region.size) for region in regions]
        kinds: dict[str, Type] = dict(project.instances)
        kinds.update((variable.name, variable.type) for variable in project.globals.values())
        # The located variables' storage comes after these.
        self._roots = {
            name: (kind, memory)
            for (name, kind), memory in zip(kinds.items(), self._regions, strict=False)
        }
        self._slots: dict[str, _Slot] = {}
        self._views: dict[str, tuple[memoryview, int]] = {}
        library.config_init__()
        # What a snapshot of another instance must not replace: the ways into its own memory.
        self._pointers = [
            (memory[at : at + _POINTER], memory[at : at + _POINTER].tobytes())
            for kind, memory in self._roots.values()
            if isinstance(kind, BlockType)
            for at in self._layout.pointers(kind)
        ]

    @classmethod
    def build(cls, project: Project, matiec: Matiec, compiler: str) -> MatiecProgram:
        """Compile a project.

        Args:
            project: The checked sources.
            matiec: The installation to use.
            compiler: The C compiler.

        Raises:
            InputError: iec2c or the C compiler refuses it, for iec2c with file and line; or the
                priorities of the tasks ask for an order that matiec does not keep.
        """
        _check_order(project)
        source = join_sources(project)
        instances = tuple(project.instances) if project.configured else (HIDDEN_INSTANCE,)
        wanted = Wanted(
            instances=tuple(name.upper() for name in instances),
            globals=tuple(project.globals),
            layout=tuple(layout_expressions(_contained_types(project))),
        )
        try:
            image = compile_program(source.text, wanted, matiec, compiler)
        except TranslationError as error:
            raise explain(error, source, project, matiec) from None
        return cls(project, image)

    def instance(self) -> MatiecProgram:
        """Another instance of the same program, in its first state."""
        return MatiecProgram(self._project, self._image)

    def scan(self, now_us: int) -> None:
        """Run one base tick at PLC time `now_us`, microseconds.

        Indices are not checked and endless loops are not ended: C has no notion of either.

        Raises:
            InputError: the program divides an integer by zero.
        """
        if self._scan(now_us):
            raise InputError(
                "the program divides by zero", hint="the built-in engine tells the file and line"
            )

    def read(self, path: str) -> Value:
        """Value at `path`."""
        slot = self._slot(path)
        return slot.codec.get(slot.memory, slot.at)

    def reader(self, paths: Sequence[str]) -> Callable[[], tuple[Value, ...]]:
        """A function that reads these variables; see `engine.base.Program.reader`."""
        slots = [self._slot(path) for path in paths]
        parts = [_reader(list(part)) for _, part in groupby(slots, lambda one: id(one.memory))]
        if len(parts) == 1:
            return parts[0]
        return lambda: tuple(chain.from_iterable([part() for part in parts]))

    def write(self, path: str, value: Value) -> None:
        """Set `path`, whole or in part."""
        slot = self._slot(path)
        slot.codec.put(slot.memory, slot.at, from_python(slot.type, value, slot.path))

    def read_bytes(self, path: str, start: int = 0, size: int | None = None) -> bytes:
        """An array of BYTE or WORD as bytes, little endian; see `engine.base.Program`."""
        memory, _ = self._views.get(path) or self._view(path)
        return memory[start : None if size is None else start + size].tobytes()

    def write_bytes(self, path: str, data: bytes, start: int = 0) -> None:
        """Set bytes of an array of BYTE or WORD; see `engine.base.Program`."""
        memory, step = self._views.get(path) or self._view(path)
        end = start + len(data)
        if end > len(memory) or start % step or end % step:
            given = f"{len(data)} from byte {start} on" if start else f"{len(data)}"
            raise InputError(f"{path} holds {len(memory)} bytes and cannot take {given}")
        memory[start:end] = data

    def type_of(self, path: str) -> Type:
        """Type of the variable at `path`."""
        return self._slot(path).type

    def instances(self) -> Mapping[str, Type]:
        """The program instances by name."""
        return dict(self._project.instances)

    def walk(self) -> Iterator[tuple[str, Type]]:
        """Every variable below the program instances, parents before children."""
        return walk(self._project)

    def located(self) -> list[Located]:
        """Directly represented variables in order of declaration."""
        return list(self._project.located)

    def note_calls(self, blocks: Mapping[str, int | None]) -> None:
        """The C that matiec writes does not show its calls."""

    def snapshot(self) -> object:
        """The whole state."""
        contents = tuple(memory.tobytes() for memory in self._regions)
        return _Snapshot(self._image, self._tick.value, contents)

    def restore(self, snapshot: object) -> None:
        """Go back to a state that `snapshot` gave, of this or another instance of the program.

        Raises:
            InputError: the snapshot is of another program.
        """
        if not isinstance(snapshot, _Snapshot) or snapshot.image != self._image:
            raise InputError("this snapshot is of another program")
        for memory, content in zip(self._regions, snapshot.contents, strict=True):
            memory[:] = content
        for pointer, address in self._pointers:
            pointer[:] = address
        self._tick.value = snapshot.tick

    def _slot(self, path: str) -> _Slot:
        slot = self._slots.get(path)
        if slot is None:
            slot = self._slots[path] = self._find(path)
        return slot

    def _find(self, path: str) -> _Slot:
        found = resolve(self._project, path)
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

    def _view(self, path: str) -> tuple[memoryview, int]:
        """The memory of an array of BYTE or WORD, and the bytes of an element."""
        slot = self._slot(path)
        kind = slot.type
        if not isinstance(kind, ArrayType) or kind.element not in _BYTES:
            raise InputError(
                f"{slot.path} is of type {describe(kind)}",
                hint="only an array of BYTE or WORD can be taken as bytes",
            )
        size = slot.codec.size
        view = slot.memory[slot.at : slot.at + size]
        found = self._views[path] = (view, size // array_length(kind))
        return found


def _reader(slots: Sequence[_Slot]) -> Callable[[], tuple[Value, ...]]:
    """A reader of variables in one memory; plain ones are taken in one go."""
    if all(one.codec.form for one in slots):
        packed = _packed_reader(slots)
        if packed is not None:
            return packed
    places = [(slot.codec.get, slot.memory, slot.at) for slot in slots]
    return lambda: tuple([get(memory, at) for get, memory, at in places])


def _packed_reader(slots: Sequence[_Slot]) -> Callable[[], tuple[Value, ...]] | None:
    """A reader of plain variables in one memory; None if one of them is asked for twice."""
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


def _check_order(project: Project) -> None:
    """Refuse what would run in another order: matiec ignores the tasks' priorities."""
    declared = list(project.instances)
    if [run.instance for run in project.schedule] == declared:
        return
    place = next(unit for unit in project.units if unit.kind == "CONFIGURATION")
    wanted = ", ".join(run.instance for run in project.schedule)
    raise InputError(
        f"matiec runs programs as they are declared ({', '.join(declared)}), not by priority",
        file=place.file,
        line=place.line,
        hint=f"declare them in the order {wanted}",
    )


def _contained_types(project: Project) -> list[StructType | BlockType]:
    """Structures and blocks in the program instances and globals, each after what it contains."""
    found: dict[str, StructType | BlockType] = {}

    def visit(kind: Type) -> None:
        if isinstance(kind, ArrayType):
            visit(kind.element)
        elif isinstance(kind, StructType):
            for _, field in kind.fields:
                visit(field)
            found.setdefault(kind.name.upper(), kind)
        elif isinstance(kind, BlockType):
            for variable in kind.variables:
                visit(variable.type)
            found.setdefault(kind.name.upper(), kind)

    for block in project.instances.values():
        visit(block)
    for variable in project.globals.values():
        visit(variable.type)
    return list(found.values())


def _load_private_copy(
    owner: object, image: bytes
) -> tuple[ctypes.PyDLL, weakref.finalize[..., object]]:
    """Load a shared object from a file of its own: one that is loaded twice shares its data.

    Returns:
        The library, and the call that unloads it (at the latest when `owner` is gone).
    """
    with tempfile.NamedTemporaryFile(prefix="rcx-", suffix=".so", delete=False) as file:
        file.write(image)
    try:
        # PyDLL: no other thread may scan meanwhile, the runtime's signal handler is the process's.
        library = ctypes.PyDLL(file.name)
    except OSError as error:
        raise InputError(
            f"the compiled program cannot be loaded: {error}",
            hint="set TMPDIR to a directory from which programs may be run",
        ) from None
    finally:
        os.unlink(file.name)
    return library, weakref.finalize(owner, _ctypes.dlclose, library._handle)  # noqa: SLF001


def _table(library: ctypes.PyDLL, name: str, kind: Any) -> list[Any]:
    count = ctypes.c_size_t.in_dll(library, f"{name}_count").value
    return list((kind * count).in_dll(library, name))
