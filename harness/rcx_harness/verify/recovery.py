"""The steps with which an operator restarts a cell, and the check that the cell works again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from rcx_harness.cell import Cell, CellTimeout
from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.handshakes.waits import waits
from structured_text.bench.stimulus import typed
from structured_text.engines.conditions import Condition, conditions
from structured_text.errors import InputError
from structured_text.language.displayed import value_text
from structured_text.output.toml_files import check_keys
from structured_text.output.units import format_us, parse_us

__all__ = ["NotRecoveredError", "Operator", "Recovery", "recovery_of"]

_PRESSED_US = 100_000
#: Longest time until every controller is connected again after a fault [us].
_BACK_US = 20_000_000


@dataclass(frozen=True)
class RecoveryStep:
    """One step of the operator.

    Attributes:
        values: Variables that the operator sets.
        press: Buttons that the operator presses together.
        for_us: How long the buttons are pressed [us].
        until: A condition for which the operator waits after the actions. Empty: no condition.
        within_us: The condition must hold within this time [us].
        wait_us: A final waiting time [us].
    """

    values: Mapping[str, Any] = field(default_factory=dict)
    press: tuple[str, ...] = ()
    for_us: int = _PRESSED_US
    until: str = ""
    within_us: int = 0
    wait_us: int = 0


@dataclass(frozen=True)
class Recovery:
    """The recovery that a user demands.

    Attributes:
        steps: The steps of the operator.
        when: The condition that must hold after the steps. `BEFORE(x)` is the value of x at the
            beginning of the recovery. Empty: no condition.
        within_us: The condition must hold within this time [us].
        file: The file that contains the table.
    """

    steps: tuple[RecoveryStep, ...] = ()
    when: str = ""
    within_us: int = 0
    file: str | None = None


class NotRecoveredError(Exception):
    """The error if the cell does not recover; `expect` is the condition that did not hold."""

    def __init__(self, text: str, expect: str) -> None:
        super().__init__(text)
        self.expect = expect


class _Doing(Protocol):
    """The run on which an `Operator` acts: it schedules actions and lets time pass."""

    cell: Cell

    def plan(self, act: Entry) -> None: ...

    def let_pass(self, duration_us: int) -> None: ...


class Operator:
    """An operator who restarts a cell with the steps of a recovery."""

    def __init__(self, cell: Cell, recovery: Recovery) -> None:
        self._cell, self._recovery = cell, recovery
        texts = [step.until for step in recovery.steps if step.until]
        try:
            made = conditions(cell.program, [*texts, *filter(None, [recovery.when])])
            for step in recovery.steps:
                for path in (*step.values, *step.press):
                    cell.program.type_of(path)
        except InputError as error:
            text = f"[recover]: {error.message}"
            raise InputError(text, file=recovery.file, hint=error.hint) from None
        self._when = made.pop() if recovery.when else None
        self._until = made

    @property
    def paths(self) -> tuple[str, ...]:
        """Return the variables that the final condition names."""
        return () if self._when is None else self._when.paths

    def wait_for_controllers(self, run: _Doing) -> None:
        """Wait until all controllers are connected again, at most 20 s.

        The wait begins with twice the connection time-out. Until the time-out a connection without
        packets is still reported as connected.
        """
        run.let_pass(2 * run.cell.timing.timeout_us)
        end_us = run.cell.now_us + _BACK_US
        while not run.cell.connected and run.cell.now_us < end_us:
            run.let_pass(50_000)

    def act(self, run: _Doing) -> None:
        """Execute all steps of the recovery in order."""
        until = iter(self._until)
        for step in self._recovery.steps:
            program = run.cell.program
            values = {
                path: value
                for path, value in step.values.items()
                if program.read(path) != typed(run.cell, path, value)
            }
            if values:
                run.plan(Entry(run.cell.now_us, values=values))
            if step.press:
                pressed = dict.fromkeys(step.press, True)
                run.plan(Entry(run.cell.now_us, values=pressed, held_us=step.for_us))
                run.let_pass(step.for_us)
            if step.until:
                self._wait(run, next(until), step.within_us)
            if step.wait_us:
                run.let_pass(step.wait_us)

    def recover(self, run: _Doing) -> None:
        """Execute all steps, and wait for the final condition."""
        if self._when is not None:
            self._when.mark()
        self.act(run)
        if self._when is not None:
            self._wait(run, self._when, self._recovery.within_us)

    def _wait(self, run: _Doing, condition: Condition, within_us: int) -> None:
        program = run.cell.program
        try:
            run.cell.run_until(condition.holds, within=within_us)
            # The next action of the operator must be later than the last scan.
            run.let_pass(1_000 - run.cell.now_us % 1_000)
        except CellTimeout:
            before = [
                value_text(program.type_of(path), value)
                for path, value in zip(condition.before_paths, condition.before, strict=True)
            ]
            expect = condition.fixed(before)
            shown = ", ".join(
                f"{path} = {value_text(program.type_of(path), program.read(path))}"
                for path in condition.paths
            )
            text = f"{expect} has not come within {format_us(within_us)}; {shown}"
            if standing := waits(run.cell):
                text += f"; {standing}"
            raise NotRecoveredError(text, expect) from None


def recovery_of(table: Mapping[str, Any], file: Path) -> Recovery:
    """Return the recovery in the table `[recover]` of a file."""
    keys = ("set", "steps", "when", "within")
    check_keys(table, keys, "[recover]", file, every="keys are")
    steps = []
    if "set" in table:
        steps.append(RecoveryStep(values=_table(table["set"], "[recover]: set", file)))
    given = table.get("steps", [])
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
        hint = 'write steps = [ { press = "Main.Reset", wait = "2s" } ]'
        raise InputError("[recover]: steps is not a list of tables", file=file, hint=hint)
    steps += [_step(one, f"[recover]: step {number}", file) for number, one in enumerate(given, 1)]
    when = _text(table.get("when", ""), "[recover]: when", file)
    if bool(when) != ("within" in table):
        missing = "within" if when else "when"
        raise InputError(f"[recover]: {missing} is missing", file=file)
    within_us = _time(table["within"], "[recover]: within", file) if when else 0
    return Recovery(tuple(steps), when, within_us, str(file))


def _step(table: Mapping[str, Any], where: str, file: Path) -> RecoveryStep:
    keys = ("set", "press", "for", "until", "within", "wait")
    check_keys(table, keys, where, file, every="keys are")
    press = table.get("press", [])
    names = press if isinstance(press, list) else [press]
    if not all(isinstance(one, str) for one in names):
        hint = 'write press = "Main.Reset"'
        raise InputError(f"{where}: press is not an input", file=file, hint=hint)
    if ("until" in table) != ("within" in table):
        missing = "within" if "until" in table else "until"
        raise InputError(f"{where}: {missing} is missing", file=file)
    if "for" in table and not names:
        raise InputError(f"{where}: 'for' can be used only together with press", file=file)
    if not table:
        raise InputError(f"{where} is empty", file=file)

    def time(key: str, default_us: int) -> int:
        return _time(table[key], f"{where}: {key}", file) if key in table else default_us

    return RecoveryStep(
        _table(table.get("set", {}), f"{where}: set", file),
        tuple(names),
        time("for", _PRESSED_US),
        _text(table.get("until", ""), f"{where}: until", file),
        time("within", 0),
        time("wait", 0),
    )


def _table(value: object, what: str, file: Path) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{what} is not a table", file=file, hint='{ "Main.CellSafe" = true }')
    return value


def _text(value: object, what: str, file: Path) -> str:
    if not isinstance(value, str):
        raise InputError(f"{what} is not a text", file=file)
    return value


def _time(value: object, what: str, file: Path) -> int:
    return _checked(lambda: parse_us(_text(value, what, file)), what, file)


def _checked(read: Callable[[], int], what: str, file: Path) -> int:
    try:
        return read()
    except InputError as error:
        if error.file:
            raise
        raise InputError(f"{what}: {error.message}", file=file, hint=error.hint) from None
