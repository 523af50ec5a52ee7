"""Variables of a program as the engine stores them: how to find, show and set them.

A BOOL or number has its Python value, a time is in nanoseconds, an enumeration is its number. A
structure or block is an object with slots in upper case, an array is one list of all elements.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, TypeAlias

from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.engines.builtin.references import Holders
from structured_text.engines.builtin.storage import address_slot, is_scalar, slot_name
from structured_text.errors import InputError
from structured_text.language import tree as t
from structured_text.language.displayed import value_text
from structured_text.language.paths import Resolved
from structured_text.language.types import (
    ArrayType,
    BlockType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)
from structured_text.language.values import array_length, describe, scalar_to_python

__all__ = ["Held", "Item", "ProgramVariables", "Shown", "Text", "local", "refuse_set"]

#: Number of elements of an array that a line of text shows.
_FEW = 8


@dataclass(frozen=True)
class Held:
    """A variable, or a value that is not stored in a variable.

    Attributes:
        name: Displayed name: a member, `[3]`, or the user's expression.
        get: Returns the value.
        set: Sets the value; None if it cannot be set.
        path: An expression for the variable in its POU; empty if there is no such expression.
    """

    name: str
    type: Type
    get: Callable[[], Any]
    set: Callable[[Any], None] | None = None
    path: str = ""


@dataclass(frozen=True)
class Text:
    """A displayed item that is not a variable of the program: a name, a text and inner items."""

    name: str
    text: str
    type: str = ""
    below: Callable[[], list[Item]] | None = None


Item: TypeAlias = Held | Text


@dataclass(frozen=True)
class Shown:
    """A value for display: its text, and the number of its named and numbered parts."""

    text: str
    type: str
    named: int = 0
    numbered: int = 0


class ProgramVariables:
    """The variables of a program.

    Attributes:
        roots: The objects of the program instances, by name.
        shared: The object of the global variables.
    """

    def __init__(self, program: BuiltinProgram) -> None:
        self._program, self._project = program, program.module.project
        self.roots = {name: program.holder(name) for name in program.instances()}
        self.shared: Any = next(iter(self.roots.values())).g
        self._holders = Holders(self._project, self.shared, self.roots)

    def path(self, held: Any) -> str:
        """Return the path of an instance or structure.

        The result is empty if the object exists only during a call.
        """
        found = self._holders.find(held)
        return found.path if found is not None else ""

    # --- members and elements ---

    def parts(self, of: Held, first: int = 0, count: int | None = None) -> list[Held]:
        """Return the members or elements of a variable.

        For an array, return `count` elements from `first` on. If `count` is None, return all
        elements from `first` on.
        """
        kind, held = of.type, of.get()
        if isinstance(kind, ArrayType):
            return self._elements(of, kind, held, first, count)
        if isinstance(kind, StructType):
            return [self._slot(held, of, name, name.upper(), one) for name, one in kind.fields]
        if isinstance(kind, BlockType):
            return self._of_block(of, kind, held)
        return []

    def _of_block(self, of: Held, kind: BlockType, held: Any) -> list[Held]:
        pou = self._project.pous.get(kind.name.upper())
        if pou is None:  # a standard block has no POU, only pins
            return [
                self._slot(held, of, one.name, one.name.upper(), one.type)
                for one in kind.variables
                if hasattr(held, one.name.upper())
            ]
        symbols = (one for one in pou.symbols.values() if not one.name.startswith(" "))
        return [found for one in symbols if (found := self.of_symbol(one, held, of.path))]

    def of_symbol(self, symbol: t.Symbol, instance: Any, path: str = "") -> Held | None:
        """Return a variable of an instance; None if the instance does not store this variable."""
        whole = f"{path}.{symbol.name}" if path else symbol.name
        if symbol.section == "VAR_EXTERNAL":
            key = symbol.source or symbol.name.upper()
            found = self._project.global_symbols.get(key)
            if found is None:
                return None
            return self.of_global(found, symbol.name, whole)
        if symbol.address is not None:
            return self._place(
                self.shared, address_slot(symbol.address), symbol.name, whole, symbol.type
            )
        slot = slot_name(symbol.name)
        if symbol.section in ("VAR_TEMP", "RESULT", "VAR_IN_OUT") or not hasattr(instance, slot):
            return None
        return self._place(instance, slot, symbol.name, whole, symbol.type)

    def of_global(self, symbol: t.Symbol, name: str = "", path: str = "") -> Held:
        """Return a global variable for display."""
        slot = symbol.name.upper() if symbol.address is None else address_slot(symbol.address)
        shown = name or symbol.name
        return self._place(self.shared, slot, shown, path or shown, symbol.type)

    def _slot(self, holder: Any, of: Held, name: str, slot: str, kind: Type) -> Held:
        return self._place(holder, slot, name, f"{of.path}.{name}" if of.path else "", kind)

    @staticmethod
    def _place(holder: Any, slot: str, name: str, path: str, kind: Type) -> Held:
        return Held(
            name,
            kind,
            lambda: getattr(holder, slot),
            (lambda value: setattr(holder, slot, value)) if is_scalar(kind) else None,
            path,
        )

    def _elements(
        self, of: Held, kind: ArrayType, held: Any, first: int, count: int | None
    ) -> list[Held]:
        bounds = held.bounds if kind.open else kind.bounds
        items = held.held if kind.open else held
        places = list(product(*(range(low, high + 1) for low, high in bounds)))
        end = len(places) if count is None else first + count
        found = []
        for position, place in list(enumerate(places))[first:end]:
            name = f"[{','.join(map(str, place))}]"
            path = f"{of.path}{name}" if of.path else ""
            found.append(self.element(items, position, name, path, kind.element))
        return found

    @staticmethod
    def element(items: Any, position: int, name: str, path: str, kind: Type) -> Held:
        """Return an element of an array as a variable."""
        return Held(
            name,
            kind,
            lambda: items[position],
            (lambda value: items.__setitem__(position, value)) if is_scalar(kind) else None,
            path,
        )

    # --- display ---

    def shown(self, of: Held) -> Shown:
        """Return a variable's value for display."""
        kind, held = of.type, of.get()
        name = describe(kind)
        if isinstance(kind, ArrayType):
            items = held.held if kind.open else held
            length = len(items) if kind.open else array_length(kind)
            if is_scalar(kind.element):
                few = [self.text(kind.element, one) for one in items[:_FEW]]
                more = ["..."] if length > _FEW else []
                return Shown(f"[{', '.join([*few, *more])}]", name, 0, length)
            return Shown(f"{length} elements", name, 0, length)
        if isinstance(kind, BlockType):
            return Shown(self._of_pins(kind, held), name, max(1, len(kind.variables)))
        if isinstance(kind, StructType):
            scalars = [(one, part) for one, part in kind.fields if is_scalar(part)][:_FEW]
            pairs = [f"{one} := {self.text(p, getattr(held, one.upper()))}" for one, p in scalars]
            more = ["..."] if len(kind.fields) > len(pairs) else []
            return Shown(f"({', '.join([*pairs, *more])})", name, len(kind.fields))
        return Shown(self.text(kind, held), name)

    @staticmethod
    def _of_pins(kind: BlockType, held: Any) -> str:
        """Return the names of a block's BOOL outputs that are TRUE, such as Busy or Done."""
        pins = [
            one.name
            for one in kind.variables
            if one.section == "VAR_OUTPUT" and getattr(held, one.name.upper(), None) is True
        ]
        return ", ".join(pins) or kind.name

    def text(self, kind: Type, held: Any) -> str:
        """Return a scalar as Structured Text writes it."""
        if isinstance(kind, (ReferenceType, InterfaceType)):
            return self._holders.path(held) or "NULL"
        if isinstance(kind, EnumType):
            return kind.member_of(int(held)) or str(int(held))
        if isinstance(held, str):
            held = held.partition("\0")[0]
        return value_text(kind, scalar_to_python(kind, held))

    def text_of(self, kind: Type, held: Any) -> str:
        """Return the value of any variable as one line of text."""
        return self.shown(Held("", kind, lambda: held)).text

    def at(self, found: Resolved) -> Held:
        """Return the variable at a path, which begins with a program or a global variable."""
        kind, path = found.type, found.path
        if found.address is not None:
            slot = address_slot(found.address)
            if not found.inside:
                return self._place(self.shared, slot, path, path, kind)
            holder: Any = getattr(self.shared, slot)
            way = found.inside
        else:
            holder = self.shared if found.is_global else self.roots[found.root]
            way = (found.root, *found.steps) if found.is_global else found.steps
        if not way:
            return Held(path, kind, lambda: holder, None, path)
        for step in way[:-1]:
            holder = holder[step] if isinstance(step, int) else getattr(holder, step.upper())
        last = way[-1]
        if isinstance(last, int):
            return self.element(holder, last, path, path, kind)
        return self._place(holder, last.upper(), path, path, kind)


def local(
    frame_locals: Mapping[str, Any], symbol: t.Symbol, store: Callable[[str, Any], None]
) -> Held:
    """Return a local variable of a call; `frame` is the Python frame of the call."""
    name = symbol.name.upper()
    in_list = symbol.addressed and is_scalar(symbol.type)

    def get() -> Any:
        held = frame_locals.get(name)
        return held[0] if in_list and isinstance(held, list) else held

    def put(value: Any) -> None:
        if in_list:
            store(name, [value])
        else:
            store(name, value)

    return Held(symbol.name, symbol.type, get, put if is_scalar(symbol.type) else None, symbol.name)


def refuse_set(of: Held) -> InputError:
    """Return the error for a variable that cannot be set."""
    if not of.path:
        return InputError(f"{of.name} is not a variable", hint="set a variable")
    text = f"{of.path} is a {describe(of.type)}"
    return InputError(text, hint="set its members or elements one by one")
