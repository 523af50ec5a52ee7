"""The translation of one instruction of a rung: its operands, its conditions and its statements."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial

from structured_text.errors import VARIABLES
from structured_text.projects.rockwell.data import Data, First
from structured_text.projects.rockwell.expression_reader import Routine, Value, bare
from structured_text.projects.rockwell.ladder.model import Instruction, LadderError
from structured_text.projects.rockwell.ladder.operands import BIT_STRINGS, OperandReader, Tag
from structured_text.projects.rockwell.ladder.paths import Path, paths_of
from structured_text.projects.rockwell.ladder.power import FALSE, TRUE, Action, Flow, Power, negated

__all__ = ["Body", "Call", "Entry", "Jump", "prescan_of"]

_ASSIGNMENT = re.compile(r"\s*([\w.]+(?:\[[^\]]*\][\w.]*)*)\s*:=")
_KEYWORD = re.compile(r"\s*(?:IF|ELSIF|ELSE|END_\w+|WHILE|RETURN)\b")
_CONTACT = re.compile(r"[\w.]+(?:\[[^\]]*\][\w.]*)*")


@dataclass(frozen=True)
class Jump:
    """A jump.

    Attributes:
        source: The number of its rung.
        target: The number of the rung behind its label.
        variable: The variable that is TRUE from the jump to its label.
    """

    source: int
    target: int
    variable: str

    @property
    def back(self) -> bool:
        """Return whether the label is not behind the jump, so that rungs are repeated."""
        return self.target <= self.source


@dataclass
class Body:
    """The routine that is translated: its scope, and the variables that the translation adds.

    Attributes:
        routine: The meaning of the names.
        variables: Variables of the body, which need no value from the last scan; each with its
            type.
        kept: Variables of the program or instruction that keep their values; each with its type.
        labels: The number of the rung behind each label, in upper case; counted from 0.
        rung: The number of the rung that is translated; counted from 0.
        zone: The variable of the MCR zone of the rung; empty outside a zone.
        jumps: The jumps that were translated.
        may_return: Whether a RETURN may leave the body; otherwise further statements follow it.
        first: The statements of the prescan, and the routines that it continues with.
        notes: What a user may miss, each with its line.
        traces: What each instruction became, by the number of its rung, in their order.
    """

    routine: Routine
    variables: dict[str, str] = field(default_factory=dict)
    kept: dict[str, str] = field(default_factory=dict)
    labels: dict[str, int] = field(default_factory=dict)
    rung: int = 0
    zone: str = ""
    jumps: list[Jump] = field(default_factory=list)
    may_return: bool = True
    first: list[First] = field(default_factory=list)
    notes: list[tuple[int, str]] = field(default_factory=list)
    traces: dict[int, list[str]] = field(default_factory=dict)

    def variable(self, name: str, kind: str = "BOOL", *, kept: bool = False) -> str:
        """Return a variable of the translation, and declare it."""
        full = f"{VARIABLES}{name}"
        while full.upper() in self.routine.tags:
            full += "_1"
        (self.kept if kept else self.variables)[full] = kind
        return full


@dataclass
class Call:
    """An instruction at its place in a rung.

    Attributes:
        body: The routine.
        instruction: The instruction with its operands.
        entry: The instruction's row in the table.
        flow: The power of the rung.
        power: The power in front of the instruction; afterwards, the power behind it.
        ranges: The indices of the operands that are not numbers, with the sizes of their arrays.
    """

    body: Body
    instruction: Instruction
    entry: Entry
    flow: Flow
    power: Power
    ranges: list[tuple[str, int]] = field(default_factory=list)

    # --- operands -------------------------------------------------------------------------

    def error(self, message: str, hint: str = "") -> LadderError:
        """Return the error for an unsupported instruction or operand."""
        return LadderError(message, self.instruction.at, hint)

    def raw(self, number: int) -> str:
        """Return the text of an operand; empty if the instruction has fewer operands."""
        operands = self.instruction.operands
        return operands[number] if number < len(operands) else ""

    def operand(self, number: int) -> OperandReader:
        """Return the reader of an operand, or raise LadderError if it is missing or `?`."""
        text = self.raw(number)
        if text in ("", "?"):
            names = self.entry.operands
            which = names[number] if number < len(names) else f"operand {number + 1}"
            raise self.error(
                f"{self.instruction.name} has no {which}", "complete the instruction in its tool"
            )
        reader = OperandReader(text, self.instruction.at, self.body.routine)
        reader.ranges = self.ranges
        return reader

    def value(self, number: int) -> Value:
        """Return the value of an operand: its text and its type."""
        return self.operand(number).value()

    def number(self, number: int) -> Value:
        """Return the value of an operand that is a number."""
        value = self.value(number)
        if value[1] in ("BOOL", "STRING"):
            raise self.error(f"{self.raw(number)} is a {value[1]}, {self._which(number)} a number")
        return value

    def bits(self, number: int) -> Value:
        """Return the value of an integer operand as DWORD or LWORD, filled with zeros."""
        reader = self.operand(number)
        return reader.bits(reader.value())

    def bit(self, number: int, *, written: bool = False) -> str:
        """Return the operand that is a BOOL tag or a bit of a tag."""
        reader = self.operand(number)
        text, data = reader.tag(written=written)
        if written and reader.varying_bit():
            raise self.error(
                f"{self.raw(number)} cannot be written here", "use a bit with a number"
            )
        if data != Data("BOOL"):
            raise self.error(f"{self.raw(number)} is not a BOOL, as {self._which(number)} is")
        return text

    def set_bit(self, number: int) -> Callable[[str], str]:
        """Return the function that makes the assignment of a value to the bit in an operand."""
        reader = self.operand(number)
        reader.tag(written=True)
        varying = reader.varying_bit()
        if varying is None:
            bit = self.bit(number, written=True)
            return lambda value: f"{bit} := {value};"
        return partial(_varying_assignment, *varying)

    def tag(self, number: int, *, written: bool = True, element: bool = True) -> Tag:
        """Return the operand that is a tag: its text and its type."""
        return self.operand(number).tag(written=written, element=element)

    def assigned(self, number: int, value: Value) -> str:
        """Return the assignment of a value to the tag in an operand, with its conversion."""
        reader = self.operand(number)
        return reader.assigned(reader.tag(written=True), value)

    def _which(self, number: int) -> str:
        names = self.entry.operands
        return f"{names[number] if number < len(names) else 'this operand'} of {self.entry.name}"

    # --- conditions and statements --------------------------------------------------------

    def condition(self, text: str) -> None:
        """Let power pass only if a condition is TRUE."""
        self.power = self.flow.both(self.power, _operand_of_and(text))

    def condition_not(self, text: str) -> None:
        """Let power pass only if a condition is FALSE."""
        self.condition(negated(bare(text)))

    def when(self, *statements: str, anything: bool = False, leaves: str = "") -> None:
        """Add statements that are executed while the instruction has power.

        Args:
            statements: The lines.
            anything: Whether they may write any variable, as the call of another routine does.
            leaves: The condition on which the rest of the rung is not executed.
        """
        self._act(lambda _: statements, guarded=True, anything=anything, leaves=leaves)

    def always(
        self,
        statements: Callable[[str], Iterable[str]],
        *,
        named: bool = False,
        anything: bool = False,
        leaves: str = "",
    ) -> None:
        """Add statements that are executed in each scan.

        Args:
            statements: The function from the expression of the power to the lines.
            named: Whether the lines use the power several times, so that it must be a variable or
                a single condition.
            anything: Whether they may write any variable.
            leaves: The condition on which the rest of the rung is not executed.
        """
        self._act(statements, guarded=False, named=named, anything=anything, leaves=leaves)

    def _act(
        self,
        statements: Callable[[str], Iterable[str]],
        *,
        guarded: bool,
        named: bool = False,
        anything: bool = False,
        leaves: str = "",
    ) -> None:
        writes = None if anything else _written(statements(TRUE))
        self.flow.act(Action(self.power, statements, guarded, writes, named, leaves))


@dataclass(frozen=True)
class Entry:
    """An instruction in the table.

    Attributes:
        name: The name in the neutral text.
        operands: The names of the operands, as the manual has them.
        translate: The function that adds the instruction's conditions and statements to the rung.
        source: The section of the manual, or `assumed`.
        optional: How many operands at the end may be missing; -1 for any number of operands.
        prescan: The function that yields the statements of the prescan, before the first scan.
    """

    name: str
    operands: tuple[str, ...]
    translate: Callable[[Call], None]
    source: str
    optional: int = 0
    prescan: Callable[[Call], Iterable[str]] | None = None

    def run(self, call: Call) -> None:
        """Translate the instruction, or raise LadderError if its operands do not fit."""
        given, most = len(call.instruction.operands), len(self.operands)
        if self.optional >= 0 and not most - self.optional <= given <= most:
            listed = ", ".join(self.operands) or "none"
            raise call.error(f"{self.name} has {given} operands, not {most}: {listed}")
        if self.prescan is not None:
            call.body.first += prescan_of(call, self.prescan)
        self.translate(call)


def prescan_of(call: Call, prescan: Callable[[Call], Iterable[str]]) -> list[First]:
    """Return the statements of an instruction's prescan.

    An index outside its array skips them; in a prescan, the controller ignores such an index.
    """
    call.ranges.clear()
    lines = tuple(prescan(call))
    inside = " AND ".join(
        f"{index} >= 0 AND {index} < {size}" for index, size in dict.fromkeys(call.ranges)
    )
    if inside:
        lines = (f"IF {inside} THEN", *(f"  {line}" for line in lines), "END_IF;")
    return [First(lines)]


def _varying_assignment(tag: str, data: Data, index: str, value: str) -> str:
    """Return the assignment of a value to the bit of a tag with a varying number."""
    bits = BIT_STRINGS[data.type]
    word, one = f"{data.type}_TO_{bits}({tag})", f"SHL({bits}#1, {bare(index)})"
    off, on = f"{word} AND NOT {one}", f"{word} OR {one}"
    chosen = {TRUE: on, FALSE: off}.get(value, f"SEL({value}, {off}, {on})")
    return f"{tag} := {bits}_TO_{data.type}({chosen});"


def _operand_of_and(text: str) -> str:
    inner = text[len("NOT ") :] if text.startswith("NOT ") else text
    if _CONTACT.fullmatch(inner) or bare(inner) != inner:
        return text
    return f"({text})"


def _written(statements: Iterable[str]) -> frozenset[Path]:
    """Return the variables that some lines may write; those of a call are all its variables."""
    found: set[Path] = set()
    for line in statements:
        keyword = _KEYWORD.match(line)
        if keyword is not None and ":=" not in line:
            continue
        target = _ASSIGNMENT.match(line)
        found |= paths_of(target[1] if target else line)
    return frozenset(found)
