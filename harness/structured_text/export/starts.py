"""Statements for initial values that a tool's declarations cannot contain.

A tool's table of variables often cannot contain initial values of structures and arrays. Statements
at the beginning of the body set them. A flag ensures that a block does so in its first call only.
The flag for retained variables is retained as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from structured_text.errors import VARIABLES
from structured_text.export.initial import differing, is_scalar
from structured_text.export.losses import missing
from structured_text.export.output import Missing
from structured_text.export.parts import Part
from structured_text.language import syntax as s
from structured_text.language.project import Project
from structured_text.language.tree import Symbol
from structured_text.language.types import BlockType, Type
from structured_text.language.walk import declared

__all__ = ["Starts", "each_call"]

#: Highest number of values that statements set; a larger table is not exported.
_MOST = 1024
#: Names of the flags that are TRUE after the statements have run: one for plain and one for
#: retained variables.
_FLAGS = (f"{VARIABLES}Started", f"{VARIABLES}StartedKept")


def each_call(node: s.Pou, section: s.Section) -> bool:
    """Return whether a variable is temporary, so that it gets its initial value at each call."""
    return section.kind == "VAR_TEMP" or (node.kind == "FUNCTION" and section.kind == "VAR")


@dataclass(frozen=True)
class Starts:
    """The writer of statements that set initial values, in a tool's words.

    Attributes:
        project: The checked project.
        variable: Returns the name of a variable in statements.
        field: Returns the name of a field in statements.
        literal: Returns the text of a scalar in statements.
        implicit: A function that returns the value of a variable of a type without an initial
            value.
        declared: Returns whether a declaration can contain the initial value of a type.
        kept: Returns whether a variable keeps its value when power is off.
    """

    project: Project
    variable: Callable[[str], str]
    field: Callable[[str], str]
    literal: Callable[[Any, Type], str]
    implicit: Callable[[Type], Any]
    declared: Callable[[Type], bool]
    kept: Callable[[s.Section, Symbol], bool]

    def symbol(self, node: s.Pou, name: s.Name) -> Symbol:
        """Return the symbol of a POU's variable."""
        return self.project.pous[node.name.key].symbols[name.key]

    def flags(self, node: s.Pou) -> dict[str, bool]:
        """Return the names of the BOOL flags that a block needs, and whether they are retained."""
        return {flag: kept for flag, (kept, _) in self._once(node).items()}

    def statements(self, node: s.Pou, scalar: Callable[[s.VarDecl, Symbol], str]) -> Iterator[str]:
        """Yield the statements that set initial values, for the beginning of a POU's body.

        `scalar` returns the text of a scalar's initial value.
        """
        for section, one, name in declared(node.sections):
            symbol = self.symbol(node, name)
            if not each_call(node, section):
                continue
            if not is_scalar(symbol.type):
                yield from (f"  {line}" for line in self._values(symbol, None))
            elif not symbol.constant:
                yield f"  {self.variable(name.text)} := {scalar(one, symbol)};"
        for flag, (_, lines) in self._once(node).items():
            flag = self.variable(flag)
            yield f"  IF NOT {flag} THEN (* initial values *)"
            yield from (f"    {line}" for line in (f"{flag} := TRUE;", *lines))
            yield "  END_IF;"

    def lost(self, part: Part, node: s.Pou) -> Iterator[Missing]:
        """Yield the variables of a POU that lose their initial values or RETAIN in the export."""
        for section, _, name in declared(node.sections):
            symbol = self.symbol(node, name)
            of, kind = f"{section.kind} {name.text}", symbol.type
            keeps = section.kind in ("VAR", "VAR_INPUT", "VAR_OUTPUT") and node.kind != "FUNCTION"
            if section.qualifier == "RETAIN" and keeps and not self.kept(section, symbol):
                why = "RETAIN is not exported: a power loss resets it"
                yield missing(part, why, of=of, at=name.at)
            given = node.kind == "FUNCTION" and section.kind == "VAR_INPUT"
            if isinstance(kind, BlockType) or section.kind == "VAR_IN_OUT" or given:
                continue
            always = each_call(node, section)
            pins = node.kind == "FUNCTION" and not always
            if is_scalar(kind) if always or pins else self.declared(kind):
                continue
            count = len(self._values(symbol, None if always else self.implicit(kind), cut=False))
            if count and section.kind == "VAR_INPUT":
                why = "its initial value: set it where you call the block"
                yield missing(part, why, of=of, at=name.at)
            elif count > _MOST:
                why = f"its initial value needs {count} statements, and the limit is {_MOST}"
                yield missing(part, why, of=of, at=name.at)

    def _once(self, node: s.Pou) -> dict[str, tuple[bool, list[str]]]:
        """Return the statements for the first call of a block, by the name of their flag."""
        taken = {name.key for _, _, name in declared(node.sections)}
        found = {}
        for wanted, flag in enumerate(_FLAGS):
            lines: list[str] = []
            for section, _, name in declared(node.sections):
                symbol = self.symbol(node, name)
                here = section.kind in ("VAR", "VAR_OUTPUT") and not each_call(node, section)
                whole = not isinstance(symbol.type, BlockType) and not self.declared(symbol.type)
                if here and whole and self.kept(section, symbol) == bool(wanted):
                    lines += self._values(symbol, self.implicit(symbol.type))
            if lines:
                while flag.upper() in taken:
                    flag += "1"
                found[flag] = (bool(wanted), lines)
        return found

    def _values(self, symbol: Symbol, other: Any, *, cut: bool = True) -> list[str]:
        """Return statements that set a structure or array where its value differs from `other`.

        If there are more than `_MOST` statements and `cut` is True, the result is empty.
        """
        name = self.variable(symbol.name)
        leaves = differing(name, symbol.initial, other, symbol.type, self.field)
        found = [f"{path} := {self.literal(value, kind)};" for path, value, kind in leaves]
        return [] if cut and len(found) > _MOST else found
