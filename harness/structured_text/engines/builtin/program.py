"""The built-in engine's program: Structured Text as Python, without a compiler, on any system."""

from __future__ import annotations

import inspect
import struct
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

from structured_text.engines.base import CallLog, OfProject, Value
from structured_text.engines.builtin.collector import Collector
from structured_text.engines.builtin.module import Module, module_of
from structured_text.engines.builtin.objects import holds_pointers
from structured_text.engines.builtin.references import Holders
from structured_text.engines.builtin.runtime import FAULTS, ProgramError
from structured_text.engines.builtin.storage import address_slot, is_scalar
from structured_text.errors import InputError
from structured_text.language.paths import Resolved, Step, resolve
from structured_text.language.project import Project
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
    Variable,
)
from structured_text.language.values import describe, from_python, nest, scalar_to_python

__all__ = ["BuiltinProgram"]

_NO_STORAGE = ("VAR_IN_OUT", "VAR_EXTERNAL")
#: Types whose stored value is also the result of `read`, without a conversion.
_AS_HELD = frozenset(
    {
        *("BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT"),
        *("USINT", "UINT", "UDINT", "ULINT", "REAL", "LREAL"),
    }
)


class _Place(NamedTuple):
    """The location of a variable: slot `key` of an object, or element `key` of a list."""

    holder: Any
    key: Any
    type: Type
    path: str


class _Snapshot(NamedTuple):
    module: Module
    scans: int
    data: tuple[Any, ...]
    made: tuple[Any, ...] = ()


class _CallLog:
    """The built-in engine's `engines.base.CallLog`.

    The key of an instance is its Python identity, which is unique because instances live as long as
    the program.
    """

    def __init__(self, program: BuiltinProgram, calls: deque[tuple[int, int]]) -> None:
        self._program, self._calls = program, calls
        calls.clear()

    def key(self, path: str) -> int:
        return id(self._program.holder(path))

    def take(self) -> list[tuple[int, int]]:
        taken = list(self._calls)
        self._calls.clear()
        return taken


class BuiltinProgram(OfProject):
    """One running instance of a compiled module; see `engines.base.Program`."""

    engine = "builtin"

    def __init__(self, module: Module) -> None:
        self.module = module
        names, project = module.names, module.project
        self.project = project
        self.tick_us = project.tick_us
        self._globals = names["b_globals"]()
        self._scans = 0
        self._roots = {name: self._made(block) for name, block in project.instances.items()}
        self._runs = [
            (
                run.every,
                names[f"f_{project.instances[run.instance].name.upper()}"],
                self._roots[run.instance],
            )
            for run in project.schedule
        ]
        # Globals first, then each program instance, as (object, save function, load function).
        self._parts = [(self._globals, names["save_globals"], names["load_globals"])]
        for name, block in project.instances.items():
            key = block.name.upper()
            self._parts.append((self._roots[name], names[f"save_{key}"], names[f"load_{key}"]))
        self._holders = Holders(project, self._globals, self._roots)
        self._has_pointers = holds_pointers(project)
        if "start" in names:
            self._run(partial(names["start"], self._globals, self._roots))
        self._places: dict[str, _Place] = {}
        self._looks: dict[str, Callable[[], Value]] = {}
        self._converters: dict[int, Callable[[Any], Value] | None] = {}
        self._readers: dict[tuple[str, ...], Callable[[], tuple[Value, ...]]] = {}
        self._byte_lists: dict[str, tuple[Any, int]] = {}

    def _made(self, block: BlockType) -> Any:
        """Return the object of a program instance.

        If other POUs call the program by its name, its only object is returned. Otherwise the
        object is new.
        """
        key = block.name.upper()
        shared = self.project.global_symbols.get(key)
        if shared is not None and shared.type is block:
            return getattr(self._globals, key)
        return self.module.names[f"b_{key}"](self._globals)

    def pace(self, scan_us: int) -> None:
        """Set the time from one scan to the next; see `engines.base.Program.pace`."""
        if not self.project.free:
            return
        intervals = {
            name: task.interval_us for task in self.project.tasks for name in task.instances
        }
        self._runs = [
            (max(1, round(intervals.get(run.instance, 0) / scan_us)), body, instance)
            for run, (_, body, instance) in zip(self.project.schedule, self._runs, strict=True)
        ]

    @classmethod
    def build(cls, project: Project, collector: Collector | None = None) -> BuiltinProgram:
        """Compile a checked project and make its first instance.

        Args:
            project: The project.
            collector: The collector that counts executed statements; None to use the one that is
                active (`collector.collecting`).
        """
        return cls(module_of(project) if collector is None else Module(project, collector))

    def instance(self) -> BuiltinProgram:
        """Return another instance of the same program in its initial state, without recompiling."""
        return BuiltinProgram(self.module)

    def scan(self, now_us: int) -> None:
        """Run one base tick at PLC time `now_us` [µs].

        Raises:
            InputError: The program divides by zero, uses an index outside of an array, or does not
                end a loop. The error has the file and line of the statement.
        """
        self._globals.now = now_us * 1000
        scans = self._scans
        self._scans = scans + 1
        try:
            for every, body, instance in self._runs:
                if scans % every == 0:
                    body(instance)
        except FAULTS as error:
            raise self._fault(error) from None

    def _fault(self, error: Exception) -> InputError:
        file, line = self.module.origin(error.__traceback__) or (None, None)
        return InputError(_fault(error), file=file, line=line)

    def _run(self, start: Callable[[], None]) -> None:
        """Run generated code before the first scan, at PLC time 0."""
        self._globals.now = 0
        try:
            start()
        except FAULTS as error:
            raise self._fault(error) from None

    # --- variables by path ---

    def _place(self, path: str) -> _Place:
        place = self._places.get(path)
        if place is None:
            found = self.module.resolved.get(path)
            if found is None:
                found = self.module.resolved[path] = resolve(self.project, path)
            place = self._places[path] = self._locate(found)
        return place

    def _locate(self, found: Resolved) -> _Place:
        holder: Any
        steps: tuple[Step, ...]
        if found.address is not None:
            slot = address_slot(found.address)
            if not found.inside:
                return _Place(self._globals, slot, found.type, found.path)
            holder, steps = getattr(self._globals, slot), found.inside
        elif found.is_global:
            holder, steps = self._globals, (found.root, *found.steps)
        else:
            holder, steps = self._roots[found.root], found.steps
            if not steps:
                return _Place(self._roots, found.root, found.type, found.path)
        for step in steps[:-1]:
            holder = holder[step] if isinstance(step, int) else getattr(holder, step.upper())
        last = steps[-1]
        key = last if isinstance(last, int) else last.upper()
        return _Place(holder, key, found.type, found.path)

    def read(self, path: str) -> Value:
        """Return the value at `path`; see `engines.base.Program.read`."""
        look = self._looks.get(path)
        if look is None:
            look = self._looks[path] = self._look(path)
        return look()

    def _look(self, path: str) -> Callable[[], Value]:
        place = self._place(path)
        if _is_plain(place):
            return partial(getattr, place.holder, place.key)
        convert = self._converter(place.type) or _same
        return lambda: convert(_get(place.holder, place.key))

    def reader(self, paths: Sequence[str]) -> Callable[[], tuple[Value, ...]]:
        """Return a function that reads the variables at `paths`.

        See `engines.base.Program.reader`.
        """
        read = self._readers.get(tuple(paths))
        if read is None:
            read = self._readers[tuple(paths)] = self._reader(paths)
        return read

    def _reader(self, paths: Sequence[str]) -> Callable[[], tuple[Value, ...]]:
        places = [self._place(path) for path in paths]
        if places and all(_is_plain(place) for place in places):
            return _plain_reader(places)
        looks = [self._look(path) for path in paths]
        return lambda: tuple([look() for look in looks])

    def _converter(self, kind: Type) -> Callable[[Any], Value] | None:
        """Return the function that converts a stored value for `read`.

        The result is None if no conversion is needed. The function is made once for each type,
        because monitors and tests read the same structures in each scan.
        """
        if id(kind) not in self._converters:
            self._converters[id(kind)] = self._made_converter(kind)
        return self._converters[id(kind)]

    def _made_converter(self, kind: Type) -> Callable[[Any], Value] | None:
        if isinstance(kind, ArrayType):
            item = self._converter(kind.element)
            if item is None:
                return partial(nest, kind)
            return lambda held: nest(kind, [item(element) for element in held])
        if isinstance(kind, StructType):
            return _fields([(name, self._converter(field)) for name, field in kind.fields])
        if isinstance(kind, BlockType):
            return self._pins(kind)
        if isinstance(kind, (ReferenceType, InterfaceType)):
            return self._holders.path
        if isinstance(kind, ElementaryType) and kind.name in _AS_HELD:
            return None
        if self.project.views:
            return lambda held: scalar_to_python(
                kind, held.partition("\0")[0] if isinstance(held, str) else held
            )
        return partial(scalar_to_python, kind)

    def _pins(self, kind: BlockType) -> Callable[[Any], Value]:
        """Return a function that reads all variables of a block as a dict."""
        pins = [pin for pin in kind.variables if pin.section not in _NO_STORAGE]
        own = _fields([(pin.name, self._converter(pin.type)) for pin in pins])
        if all(pin.address is None for pin in pins):
            return own
        converters = [(pin, self._converter(pin.type) or _same) for pin in pins]
        return lambda held: {
            pin.name: convert(_get(*self._slot(held, pin))) for pin, convert in converters
        }

    def _slot(self, instance: Any, pin: Variable) -> tuple[Any, str]:
        if pin.address is not None:
            return self._globals, address_slot(pin.address)
        return instance, pin.name.upper()

    def write(self, path: str, value: Value) -> None:
        """Write a value to `path`; see `engines.base.Program.write`."""
        place = self._place(path)
        self._assign(place, from_python(place.type, value, place.path))

    def _assign(self, place: _Place, value: Any) -> None:
        holder, key, kind, path = place
        if is_scalar(kind):
            if isinstance(key, int):
                holder[key] = value
            else:
                setattr(holder, key, value)
            return
        held = _get(holder, key)
        if isinstance(kind, ArrayType):
            for position, item in enumerate(value):
                self._assign(_Place(held, position, kind.element, path), item)
        elif isinstance(kind, StructType):
            types = dict(kind.fields)
            for name, item in value.items():
                self._assign(_Place(held, name.upper(), types[name], path), item)
        elif isinstance(kind, BlockType):
            for pin in kind.variables:
                if pin.name in value:
                    self._assign(_Place(*self._slot(held, pin), pin.type, path), value[pin.name])

    def holder(self, path: str) -> Any:
        """Return the object of a structure or block; its variables are slots in upper case.

        The object lives as long as the program: state exploration reads and sets it directly.
        """
        place = self._place(path)
        return _get(place.holder, place.key)

    def read_bytes(self, path: str, start: int = 0, size: int | None = None) -> bytes:
        """Return an array of BYTE or WORD as bytes (little endian); see `engines.base.Program`."""
        held, width = self._bytes_of(path)
        end = len(held) if size is None else (start + size) // width
        items = held[start // width : end]
        return bytes(items) if width == 1 else struct.pack(f"<{len(items)}H", *items)

    def write_bytes(self, path: str, data: bytes, start: int = 0) -> None:
        """Set bytes of an array of BYTE or WORD; see `engines.base.Program`."""
        held, width = self._bytes_of(path)
        end = start + len(data)
        if start % width or end % width or end > len(held) * width:
            given = f"{len(data)} from byte {start} on" if start else f"{len(data)}"
            raise InputError(f"{path} holds {len(held) * width} bytes and cannot take {given}")
        items = data if width == 1 else struct.unpack(f"<{len(data) // 2}H", data)
        held[start // width : end // width] = items

    def _bytes_of(self, path: str) -> tuple[Any, int]:
        """Return the list behind an array of BYTE or WORD, and the size of an element [bytes]."""
        found = self._byte_lists.get(path)
        if found is None:
            place = self._place(path)
            width = 1 if _element(place) == "BYTE" else 2
            found = self._byte_lists[path] = (_get(place.holder, place.key), width)
        return found

    # --- variables, their types and addresses ---

    def type_of(self, path: str) -> Type:
        """Return the type of the variable at `path`."""
        return self._place(path).type

    def note_calls(self, blocks: Mapping[str, int | None]) -> CallLog:
        """Record the calls of some block types from now on; see `engines.base.Program`."""
        return _CallLog(self, self.module.note_calls(blocks))

    @contextmanager
    def answering(self, answers: Mapping[str, Callable[..., Any]]) -> Iterator[None]:
        """Replace the calls of some FUNCTIONs by Python functions inside the `with`.

        A Python function gets the inputs in the order of their declaration, as the engine
        represents them. Functions that the program does not have are ignored.
        """
        with self.module.answering(answers):
            yield

    @contextmanager
    def skipping(self, block: str, place: int, called: Callable[[int], None]) -> Iterator[None]:
        """Replace the calls of one instance of a block by calls of `called(place)`.

        `place` is the identity of the instance (see `holder`).
        """
        with self.module.skipping(block, place, called):
            yield

    @contextmanager
    def guarding(
        self, pous: Iterable[str], called: Callable[[str, Any, Callable[[], Any]], Any]
    ) -> Iterator[None]:
        """Let `called` run the calls of these FUNCTIONs and methods inside the `with`.

        `called` gets the name of the POU, the first argument of the call (for a method, the
        instance), and a function that runs the call. This function raises InputError, with file and
        line, if the program fails at run time. The result of `called` becomes the result of the
        call. Calls that occur inside a guarded call are not guarded.

        Args:
            pous: Names of the POUs; the name of a method is `Block.Method`.
            called: The function that runs each guarded call.
        """
        active = False

        def replaced(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
            def call(*arguments: Any) -> Any:
                nonlocal active
                if active:
                    return function(*arguments)
                active = True
                try:
                    run = partial(self._guarded, function, arguments)
                    return called(name, arguments[0] if arguments else None, run)
                finally:
                    active = False

            return call

        with self.module.replacing(pous, replaced):
            yield

    def _guarded(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        try:
            return function(*arguments)
        except FAULTS as error:
            raise self._fault(error) from None
        except InputError as error:  # raised by a Python function of `answering`
            if error.file is not None:
                raise
            file, line = self.module.origin(error.__traceback__) or (None, None)
            raise InputError(error.message, file=file, line=line, hint=error.hint) from None

    def advance(self, time_ns: int) -> None:
        """Advance the time within a scan [ns]; the next scan sets the time anew."""
        self._globals.now += time_ns

    def running(self) -> Iterator[tuple[str, int]]:
        """Yield file and line of the running statements, the innermost first.

        Only a function that `answering` has installed can use this method.
        """
        return self.module.running(inspect.currentframe())

    # --- state ---

    def snapshot(self) -> object:
        """Return the whole state, as a value that `restore` accepts."""
        data = tuple(save(part) for part, save, _ in self._parts)
        made = self._globals.heap.saved(self.module.names)
        if self._has_pointers or made:
            data, made = self._holders.saved(data), self._holders.saved(made)
        return _Snapshot(self.module, self._scans, data, made)

    def restore(self, snapshot: object) -> None:
        """Restore a state that `snapshot` of this or another instance of the program has returned.

        Raise InputError if the snapshot belongs to another program.
        """
        if not isinstance(snapshot, _Snapshot) or snapshot.module is not self.module:
            raise InputError("this snapshot belongs to another program")
        self._scans = snapshot.scans
        heap, names = self._globals.heap, self.module.names
        if heap or snapshot.made:
            heap.make(snapshot.made, names, self._globals)
            heap.load(self._holders.loaded(snapshot.made), names)
        data = self._holders.loaded(snapshot.data) if self._has_pointers else snapshot.data
        for (part, _, load), saved in zip(self._parts, data, strict=True):
            load(part, saved)

    def close(self) -> None:
        """Do nothing, because Python frees the objects."""


def _plain_reader(places: Sequence[_Place]) -> Callable[[], tuple[Value, ...]]:
    """Return a reader that gets all attributes in one generated expression.

    Attribute access in one expression is the fastest way in Python.
    """
    names: dict[int, str] = {}
    looks = [f"{names.setdefault(id(one.holder), f'h{len(names)}')}.{one.key}," for one in places]
    holders = {id(one.holder): one.holder for one in places}
    read = eval(f"lambda {', '.join(names.values())}: ({''.join(looks)})")
    return partial(read, *holders.values())


def _is_plain(place: _Place) -> bool:
    """Return whether a variable is an attribute with the same value as the result of `read`."""
    kind = place.type
    held = isinstance(place.key, str) and not isinstance(place.holder, dict)
    return held and isinstance(kind, ElementaryType) and kind.name in _AS_HELD


def _get(holder: Any, key: Any) -> Any:
    return (
        getattr(holder, key)
        if isinstance(key, str) and not isinstance(holder, dict)
        else (holder[key])
    )


def _same(held: Any) -> Any:
    return held


def _fields(
    fields: Sequence[tuple[str, Callable[[Any], Value] | None]],
) -> Callable[[Any], dict[str, Value]]:
    """Return a function that reads these variables of an object, each with its converter.

    One generated expression reads them all, as in `_plain_reader`.
    """
    given = {f"c{at}": convert for at, (_, convert) in enumerate(fields) if convert is not None}
    looks = [
        f"held.{name.upper()}" if name.isascii() else f"getattr(held, {name.upper()!r})"
        for name, _ in fields
    ]
    items = [
        f"{name!r}: c{at}({look})" if f"c{at}" in given else f"{name!r}: {look}"
        for at, ((name, _), look) in enumerate(zip(fields, looks, strict=True))
    ]
    found: Callable[[Any], dict[str, Value]] = eval(f"lambda held: {{{', '.join(items)}}}", given)
    return found


def _element(place: _Place) -> str:
    """Return BYTE or WORD, the element type of a process image, or raise InputError."""
    kind = place.type
    element = kind.element if isinstance(kind, ArrayType) else None
    if isinstance(element, ElementaryType) and element.name in ("BYTE", "WORD"):
        return element.name
    raise InputError(
        f"{place.path} is of type {describe(kind)}",
        hint="name an array of BYTE or WORD",
    )


def _fault(error: Exception) -> str:
    if isinstance(error, ProgramError):
        return str(error)
    if isinstance(error, RecursionError):
        return "calls nested too deeply: a block or function calls itself"
    if isinstance(error, ZeroDivisionError):
        return "division by zero"
    if isinstance(error, OverflowError):
        return "a result is too large for its type"
    return "a function is not defined for its argument"
