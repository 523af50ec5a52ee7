"""Describes a state that the solver has found, with the names and literals of the program."""

from __future__ import annotations

import struct
from typing import Any

import z3

from structured_text.language.displayed import value_text
from structured_text.language.types import ArrayType, ElementaryType, Type, members
from structured_text.language.values import indices_at, scalar_to_python
from structured_text.prove.search import value_of
from structured_text.prove.surroundings import Surroundings
from structured_text.prove.symbolic_memory import Path, SymbolicMemory

__all__ = ["Names"]

_REALS = {"REAL": "f", "LREAL": "d"}


class Names:
    """Translates solver variables and their values into the program's names, for messages."""

    def __init__(self, memory: SymbolicMemory, around: Surroundings) -> None:
        self._memory = memory
        instances = {name.upper(): name for name in around.project.instances}
        self._roots: dict[Path, tuple[str, Type]] = {}
        for path, symbol in around.roots():
            owner = instances.get(str(path[0]), "")
            text = f"{owner}.{symbol.name}" if owner else symbol.name
            self._roots[path] = text, symbol.type
        self._inputs = {one.name: one.type for one in around.inputs}
        self._around = around

    def told(self, model: Any, variable: Any) -> str:
        """Return a solver variable with its value in the program's words: `Main.Stage = CELL_IDLE`.

        The result is empty for a variable that is not in the program, such as the clock or the
        inner state of a timer.
        """
        name = variable.decl().name()
        place = self._memory.places.get(name)
        if place is not None:
            found = self.declared(place)
            return f"{found[0]} = {_value(model, variable, found[1])}" if found else ""
        whole, _, number = name.rpartition(".")
        if number.isdigit() and whole in self._inputs:
            return f"{whole} = {_value(model, variable, self._inputs[whole])}"
        kind, _, rest = name.partition(".")
        if kind == "connected":
            status = self._around.linked.get(int(rest.partition(".")[0]))
            found = self.declared(status) if status is not None else None
            text = found[0] if found else "the connection"
            return f"{text} = {_value(model, variable, ElementaryType('BOOL'))}"
        if kind == "area":
            value = _value(model, variable, ElementaryType("BYTE"))
            return f"{self._around.byte_name(number)} = {value}"
        return ""

    def declared(self, place: Path) -> tuple[str, Type] | None:
        """Return a variable's declared path and its type; None if it is not declared."""
        if place[:2] not in self._roots:
            return None
        text, kind = self._roots[place[:2]]
        for step in place[2:]:
            if isinstance(kind, ArrayType):
                indices = ",".join(map(str, indices_at(kind, int(step))))
                text, kind = f"{text}[{indices}]", kind.element
                continue
            inner = {name.upper(): (name, part) for name, part in members(kind)}
            if step not in inner:
                return None
            name, kind = inner[step]
            text = f"{text}.{name}"
        return text, kind


def _value(model: Any, term: Any, kind: Type) -> str:
    if isinstance(kind, ElementaryType) and kind.name in _REALS and z3.is_bv(term):
        raw = model.eval(term, model_completion=True).as_long()
        (number,) = struct.unpack(_REALS[kind.name], raw.to_bytes(term.size() // 8, "little"))
        return value_text(kind, number)
    if isinstance(kind, ArrayType):
        return "..."
    return value_text(kind, scalar_to_python(kind, value_of(model, term, kind)))
