"""A standstill of the handshake: the robot program runs, but nothing moves for a time.

    [[deadlock]]
    name = "handshake"
    within = "2s"
    while = "Main.State = CELL_RUNNING"

The property is broken if PLC and robot wait for each other.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.verify.handshakes.waits import waits
from rcx_harness.verify.properties import Areas, Declared, Follower
from structured_text.bench import Bench
from structured_text.engines.base import Program
from structured_text.engines.conditions import Condition
from structured_text.errors import InputError
from structured_text.output.toml_files import check_keys, line_of
from structured_text.output.units import format_us, parse_us

__all__ = ["Standstill", "standstills_in"]

_KEYS = ("name", "within", "while")


@dataclass(frozen=True)
class Standstill(Declared):
    """A demand that something moves while a robot program runs, as declared by `[[deadlock]]`.

    Attributes:
        during: A condition in Structured Text. The demand applies only while it is TRUE. Empty:
            always.
    """

    during: str = ""

    @property
    def kind(self) -> str:
        """Return the kind of the failures that this property reports."""
        return f"deadlock {self.name}"

    @property
    def texts(self) -> tuple[str, ...]:
        """Return the conditions of this property in Structured Text."""
        return (self.during,) if self.during else ()

    def follow(
        self, made: Iterator[Condition], program: Program, cell: Bench | None, areas: Areas | None
    ) -> Follower:
        """Return the property, ready to be evaluated scan by scan."""
        del program, areas
        if not isinstance(cell, Cell):
            text = f"{self.name}: a deadlock needs the program of a robot"
            raise InputError(text, file=self.shown_file, hint="name the robot file by --robot")
        return _Standing(self, next(made) if self.during else None, cell)


class _Standing:
    """The evaluation of a `Standstill`.

    A change of an output of the PLC or of a robot counts as movement, and so does a moving axis.
    Variables of the PLC and lines of the robot program do not count, because a program that only
    polls its inputs makes no progress.
    """

    has_before = False

    def __init__(self, declared: Standstill, during: Condition | None, cell: Cell) -> None:
        self.declared, self._during, self._cell = declared, during, cell
        self.paths = () if during is None else during.paths
        self.forget()

    def forget(self) -> None:
        """Reset the memory of the property, because the program restarts."""
        self._since_us: int | None = None
        self._seen: Hashable = None
        self._reported = False

    def scan(self, now_us: int) -> bool:
        """Evaluate a scan, and return whether nothing has moved for the time `within`."""
        seen = self._state()
        if seen is None or seen != self._seen:
            self._seen, self._reported = seen, False
            self._since_us = None if seen is None else now_us
            return False
        assert self._since_us is not None
        assert self.declared.within_us is not None
        if self._reported or now_us - self._since_us < self.declared.within_us:
            return False
        self._reported = True
        return True

    def _state(self) -> Hashable:
        """Return the state in which every change counts as movement.

        Return None if no movement is demanded now.
        """
        cell = self._cell
        machines = [robot.machine for robot in cell.robots]
        if not cell.connected or not any(machine.program.busy for machine in machines):
            return None
        if any(machine.motion.under_way or machine.origin_running for machine in machines):
            return None
        if self._during is not None and not self._during.holds():
            return None
        places = tuple(tuple(machine.positions) for machine in machines)
        return tuple(cell.exchanged()), places

    def told(self, program: Program) -> str:
        """Return the message, with the signals for which PLC and robot programs wait."""
        del program
        assert self.declared.within_us is not None
        still = f"nothing has moved for {format_us(self.declared.within_us)}"
        return ": ".join(filter(None, (still, waits(self._cell))))

    def snapshot(self) -> object:
        """Return a snapshot of the memory of the property."""
        return self._since_us, self._seen, self._reported

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the memory of the property."""
        self._since_us, self._seen, self._reported = snapshot

    def memory(self, now_us: int) -> Hashable:
        """Return the memory of the property without absolute times."""
        passed_us = None if self._since_us is None else now_us - self._since_us
        return passed_us, self._seen, self._reported

    def remember(self, memory: Any, now_us: int) -> None:
        """Restore the memory that `memory` returned; the time is now `now_us`."""
        passed_us, self._seen, self._reported = memory
        self._since_us = None if passed_us is None else now_us - passed_us


def standstills_in(table: Mapping[str, Any], file: Path) -> list[Standstill]:
    """Return the properties `[[deadlock]]` of a TOML file."""
    tables = table.get("deadlock", [])
    if not isinstance(tables, list) or not all(isinstance(one, dict) for one in tables):
        raise InputError("'deadlock' is not a list of tables", file=file, hint="write [[deadlock]]")
    found = []
    for number, one in enumerate(tables, 1):
        where, line = f"[[deadlock]] {number}", line_of(file, "deadlock", number)
        check_keys(one, _KEYS, where, file, every="keys are")
        for key, value in one.items():
            if not isinstance(value, str):
                raise InputError(f"{where}: {key} is not a text", file=file, line=line)
        if "within" not in one:
            hint = 'write within = "2s", longer than the longest movement'
            raise InputError(f"{where}: within is missing", file=file, line=line, hint=hint)
        try:
            within_us = parse_us(one["within"])
        except InputError as error:
            text = f"{where}: {error.message}"
            raise InputError(text, file=file, line=line, hint=error.hint) from None
        name = one.get("name", "handshake")
        found.append(Standstill(name, "", within_us, file=str(file), during=one.get("while", "")))
    return found
