"""The properties of a user's program that are proved, and the conditions that break them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from structured_text.language.printer import expression_text
from structured_text.language.project import Project
from structured_text.language.standard import BLOCKS
from structured_text.language.types import ArrayType, BlockType, Type
from structured_text.language.values import array_length
from structured_text.language.walk import calls_of, root_of, statements, targets
from structured_text.prove.assertions import STOPS, Copies
from structured_text.prove.logic import Bool, both, either, negated
from structured_text.prove.machine import Obligation
from structured_text.prove.program import ProgramMachine
from structured_text.prove.symbolic_memory import Path

__all__ = ["ONCE", "STEADY", "Key", "Library", "Watch", "inner_written", "title"]

#: The identity of a property: its kind, and its file and line (if it has none: "" and 0).
Key = tuple[str, str, int]

ONCE: Key = ("once", "", 0)
STEADY: Key = ("steady", "", 0)

_TITLES = {
    "once": "no block of the library is called twice in a scan",
    "steady": "no block of the library is left out while it is Busy",
    "index": "each index is inside its array",
    "division": "nothing is divided by 0",
    "conversion": "each converted value fits its target type",
    "argument": "each argument of a function is legal",
    "shift": "nothing is shifted by a number below 0",
    "text": "lengths and positions in texts are legal",
    "time": "no duration leaves its range",
    "overflow": "arithmetic stays in its type",
}


def title(key: Key, copies: Copies) -> str:
    """Return the text of a property for messages and reports."""
    for one in copies.assertions:
        if key[0] == "assert" and (one.file, one.line) == key[1:]:
            return one.text
    return _TITLES[key[0]]


@dataclass(frozen=True)
class Library:
    """The requirements of a library on the programs that call it, and facts about its functions.

    Attributes:
        areas: Blocks that begin (`read`) and end (`write`) the scan of their user, by upper-case
            name. A program may call each of them only once in a scan. In a scan that calls `write`,
            every busy block must be called.
        reference: The name of a structure that only the library may write; empty if there is none.
        milliseconds: The name of a function that counts the milliseconds of a duration in a long
            loop.
        counts: The assumption about that function's result, as text for reports.
        calls: The assumption about a call of the library, as text for reports.
    """

    areas: Mapping[str, str] = field(default_factory=dict)
    reference: str = ""
    milliseconds: str = ""
    counts: str = ""
    calls: str = "A call of the library's blocks may change its arguments in any way."


@dataclass(frozen=True)
class Watch:
    """An observer of scans; it returns the conditions under which a scan breaks properties."""

    project: Project
    copies: Copies
    library: Library = field(default_factory=Library)

    @cached_property
    def _asserted(self) -> set[tuple[str, int]]:
        return {(one.file, one.line) for one in self.copies.assertions}

    @cached_property
    def _busy(self) -> list[Path]:
        """Return the Busy pins of the library blocks that the user's own code calls."""
        return [
            (*path, "BUSY")
            for name, block in self.project.instances.items()
            for path in self._instances((name.upper(),), block)
        ]

    def _instances(self, path: Path, block: BlockType) -> Iterator[Path]:
        pou = self.project.pous[block.name.upper()]
        roots = [root_of(one.instance) for one in calls_of(pou.body)]
        for symbol in pou.symbols.values():
            if symbol.section != "VAR" or symbol not in roots:
                continue
            for place, kind in _blocks((*path, symbol.name.upper()), symbol.type):
                if kind.name in BLOCKS:
                    continue
                if self.project.pous[kind.name.upper()].file in self.copies.originals:
                    yield from self._instances(place, kind)
                elif any(pin.name.upper() == "BUSY" for pin in kind.variables):
                    yield place

    def broken(self, machine: ProgramMachine, before: Mapping[Path, Any]) -> dict[Key, Bool]:
        """Return the condition under which each property is broken in the scan that has just run.

        `before` is the memory before that scan.
        """
        found: dict[Key, Bool] = dict.fromkeys(self.always, False)
        if self.library.areas:
            found |= {ONCE: self._twice(machine), STEADY: self._left_out(machine, before)}
        for one in machine.obligations:
            if one.file in self.copies.originals:
                key = self._key(one)
                found[key] = either(found.get(key, False), one.when)
        return found

    def wraps(self, machine: ProgramMachine) -> dict[Key, tuple[str, Bool]]:
        """Return text and overflow condition of the user's arithmetic, by line."""
        found: dict[Key, tuple[str, Bool]] = {}
        for one in machine.operations:
            when = one.when() if one.file in self.copies.originals else False
            if when is not False:
                key: Key = ("overflow", one.file, one.line)
                told, before = found.get(key, ("", False))
                text = expression_text(one.node)
                known = told.split("; ") if told else []
                both_told = told if text in known else "; ".join([*known, text])
                found[key] = both_told, either(before, when)
        return found

    @property
    def always(self) -> list[Key]:
        """Return the properties that are reported in any case.

        These are the rules for calls of the library, and the assertions of the program.
        """
        rules = [ONCE, STEADY] if self.library.areas else []
        return [*rules, *(("assert", *place) for place in sorted(self._asserted))]

    def alone(self, key: Key, when: Bool, machine: ProgramMachine) -> Bool:
        """Return the condition that a property is broken and no other obligation is broken."""
        others = [one.when for one in machine.obligations if self._key(one) != key]
        return both(when, *map(negated, others))

    def stops(self, machine: ProgramMachine) -> list[Bool]:
        """Return the conditions under which an engine would not reach the end of the last scan."""
        return [one.when for one in machine.obligations if one.when is not True]

    def _key(self, one: Obligation) -> Key:
        asserted = one.kind == STOPS and (one.file, one.line) in self._asserted
        return ("assert" if asserted else one.kind, one.file, one.line)

    def _left_out(self, machine: ProgramMachine, before: Mapping[Path, Any]) -> Bool:
        """Return the condition that a busy block is not called in a scan that writes an area."""
        called: dict[Path, Bool] = {}
        writes: Bool = False
        for call in machine.own:
            pin = (*call.instance, "BUSY")
            called[pin] = either(called.get(pin, False), call.when)
            if self.library.areas.get(call.block.upper()) == "write":
                writes = either(writes, call.when)
        return either(
            *(both(writes, before[pin], negated(called.get(pin, False))) for pin in self._busy)
        )

    def _twice(self, machine: ProgramMachine) -> Bool:
        """Return the condition that a block with Busy, or an area block, is called twice."""
        times: dict[Path, list[Bool]] = {}
        for call in machine.own:
            busy = (*call.instance, "BUSY") in machine
            if busy or call.block.upper() in self.library.areas:
                times.setdefault(call.instance, []).append(call.when)
        return either(
            *(
                both(one, other)
                for calls in times.values()
                for number, one in enumerate(calls)
                for other in calls[:number]
            )
        )


def _blocks(path: Path, kind: Type) -> Iterator[tuple[Path, BlockType]]:
    """Yield the block instances inside a variable, each with its path."""
    if isinstance(kind, BlockType):
        yield path, kind
    elif isinstance(kind, ArrayType) and isinstance(kind.element, (ArrayType, BlockType)):
        for place in range(array_length(kind)):
            yield from _blocks((*path, place), kind.element)


def inner_written(
    project: Project, copies: Copies, reference: str
) -> Iterator[tuple[str, int, str]]:
    """Yield the places where the program's own code writes into a structure of the library.

    `reference` is the type of that structure.

    Yields:
        File, line and the name of the variable.
    """
    for pou in project.pous.values():
        if pou.file not in copies.originals:
            continue
        for one in statements(pou.body):
            for variable in targets(one):
                if (found := _into_reference(variable, reference, one)) is not None:
                    yield pou.file, one.at.line, found


def _into_reference(variable: Any, reference: str, statement: Any) -> str | None:
    """Return the name of the reference through which an access writes, or None.

    Passing a whole reference as VAR_IN_OUT does not count as a write.
    """
    kind = getattr(variable.type, "name", "")
    passed = any(variable is given for _, given in getattr(statement, "in_outs", ()))
    node = variable
    while node is not None:
        if getattr(node.type, "name", "").upper() == reference.upper():
            whole = node is variable
            if whole and passed and isinstance(statement.block, BlockType):
                return None
            symbol = root_of(variable)
            return symbol.name if symbol is not None else kind
        node = getattr(node, "base", None)
    return None
