"""A state machine for hypothesis: arbitrary actions of operator, network and robots on a cell.

`rcx_machine` of the plugin runs it on the cell of a test. Add rules in a subclass:

    class WithRecipe(CellMachine):
        @rule(recipe=st.integers(1, 9))
        def choose(self, recipe):
            self.set({"Main.Recipe": recipe})
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, note
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.sources import source_files
from rcx_harness.cell.stimulus import Entry
from rcx_harness.testing.cells import folder_of
from rcx_harness.testing.settings import artifacts, settings_of
from rcx_harness.verify.storm.cells import Cells
from rcx_harness.verify.storm.course import RECOVERY, Course
from rcx_harness.verify.storm.demands import Demands
from rcx_harness.verify.storm.replay import replay_of
from rcx_harness.verify.storm.storms import Failure
from rcx_harness.verify.storm.written import write
from structured_text.testing.settings import project

__all__ = ["CellMachine", "run_machine"]

#: Faults that have no duration.
_AT_ONCE = ("power_cycle", "alarm", "plc_overrun")
_QUIET = (HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much)
_HELD_MS = st.sampled_from((10, 20, 50, 100, 200, 500, 1000, 3000))


class CellMachine(RuleBasedStateMachine):
    """A cell with an operator, a network and robots that act in any order.

    `demands` has the possible actions and the required properties, in the form of the files of `rcx
    campaign`. After each step all rules and properties are checked. `recover` demands that the
    operator can restart the cell. A failing run is written as a stimulus that `rcx run` replays;
    the last file is from hypothesis's shortest run.
    """

    cells: Cells
    """The arguments with which `Cell.build` builds the cells."""
    replay_file: Path
    """Folder for the stimulus file of a failing run."""

    def __init__(self) -> None:
        super().__init__()
        self.demands = self.cells.demands
        self.cell = self.cells.cell(0)
        self._course = Course(self.cell, self.demands)

    @initialize()
    def begin(self) -> None:
        """Start the cell."""
        self._try(self._course.begin)

    @rule(scans=st.sampled_from((1, 2, 5, 10, 30, 100, 300)))
    def wait(self, scans: int) -> None:
        """Run the cell for some time."""
        self._try(lambda: self._course.let_pass(scans * self.cell.timing.scan_us))

    @precondition(lambda self: bool(self.demands.buttons))
    @rule(data=st.data(), held_ms=_HELD_MS)
    def press(self, data: st.DataObject, held_ms: int) -> None:
        """Press a button. It is released after `held_ms`."""
        button = data.draw(st.sampled_from(self.demands.buttons))
        self._plan(Entry(self.cell.now_us, values={button: True}, held_us=held_ms * 1000))

    @precondition(lambda self: bool(self.demands.switches))
    @rule(data=st.data(), to=st.booleans())
    def switch(self, data: st.DataObject, to: bool) -> None:
        """Switch a switch on or off."""
        self.set({data.draw(st.sampled_from(self.demands.switches)): to})

    @precondition(lambda self: bool(self.demands.values))
    @rule(data=st.data())
    def change(self, data: st.DataObject) -> None:
        """Set a variable to another value."""
        path = data.draw(st.sampled_from(list(self.demands.values)))
        self.set({path: data.draw(st.sampled_from(self.demands.values[path]))})

    @precondition(lambda self: bool(self.demands.faults))
    @rule(data=st.data(), held_ms=_HELD_MS)
    def fault(self, data: st.DataObject, held_ms: int) -> None:
        """Cause a fault that lasts `held_ms`."""
        name = data.draw(st.sampled_from(self.demands.faults))
        controller = 1
        if not name.startswith("plc_"):
            controller = data.draw(st.integers(1, len(self.cell.robots)))
        held_us = None if name in _AT_ONCE else held_ms * 1000
        args = {"by": f"{self.demands.late_us}us"} if name == "packets_late" else {}
        self._plan(
            Entry(self.cell.now_us, events=((name, args),), controller=controller, held_us=held_us)
        )

    @precondition(lambda self: self.demands.recovery is not None)
    @rule()
    def recover(self) -> None:
        """Wait for the end of all faults, and check that the recovery leads to a working cell."""
        course = self._course
        ends_us = [part.t_us for act in course.done for part in act.parts()]
        left_us = max(0, max(ends_us, default=0) + 1_000 - self.cell.now_us)
        self._try(lambda: course.let_pass(left_us))
        self._try(course.come_to_rest)
        self._try(course.recover)

    @invariant()
    def nothing_is_broken(self) -> None:
        """Check that no rule and no property is broken."""
        self._try(self._course.check)

    def set(self, values: Mapping[str, Any]) -> None:
        """Set variables, and run the cell for a short time."""
        self._plan(Entry(self.cell.now_us, values=values))

    def _plan(self, act: Entry) -> None:
        self._course.plan(act)
        self._try(lambda: self._course.let_pass(1_000))

    def _try(self, step: Callable[[], object]) -> None:
        try:
            step()
        except Failure as failure:
            note(self._written(failure))
            raise

    def _written(self, failure: Failure) -> str:
        course = self._course
        expect = course.expect if failure.kind == RECOVERY else course.judge.expected(failure.kind)
        replay = replay_of(course.done, failure, expect, 0, self.cell.timing.scan_us)
        write(self.replay_file.parent, {self.replay_file.name: replay.text})
        duration = f"{replay.duration_us // 1000}ms"
        shown = f"rcx run ... --stimulus {self.replay_file} --for {duration}"
        return f"{replay.text}replay: {shown}"


def run_machine(
    item: pytest.Item,
    demands: Sequence[str],
    machine: type[CellMachine] | None,
    settings: Mapping[str, Any],
    temporary: Path,
) -> None:
    """Run a state machine of hypothesis on cells with the settings of a test.

    `demands` are files relative to the project's folder. Without `machine`, `CellMachine` runs.
    `temporary` is the folder for a failing run if the project names none.
    """
    options = settings_of(item, {})
    home = project(item.config)
    replaced = options.pop("replace", None)
    dialect = options.pop("dialect", None)
    device = options.pop("device", "")
    named, lib = options.pop("program"), options.pop("lib", None)
    files = source_files(named, lib, replaced, dialect, device)
    compiled = Compiled(files, options.pop("engine", "auto"))
    options.pop("seed", None)
    made = Demands.load([home / one for one in demands])
    cells = Cells(compiled, options, made)
    parent = artifacts(item.config)
    folder = temporary if parent is None else parent / folder_of(item)
    base = machine or CellMachine
    attributes = {"cells": cells, "replay_file": folder / "replay.toml"}
    wanted: type[CellMachine] = type(base.__name__, (base,), attributes)
    given = {"deadline": None, "suppress_health_check": _QUIET, **settings}
    try:
        run_state_machine_as_test(wanted, settings=hypothesis_settings(**given))
    finally:
        compiled.close()
