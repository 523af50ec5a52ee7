"""The monitor reports each violation of the pin contract of blocks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import pytest

from rcx_harness import Cell
from rcx_harness.cell.sources import source_files
from rcx_harness.watch.calls_source import steady_instances
from rcx_harness.watch.contract import ContractMonitor
from structured_text.language.types import BlockType, ElementaryType, Variable

Build = Callable[..., Cell]


@pytest.fixture
def of_program(build_cell: Build, repository: Path, tmp_path: Path) -> Callable[[str], Cell]:
    """Return a cell of this program after two scans."""

    def built(name: str) -> Cell:
        file = repository / "tests" / "cell" / "programs" / name
        cell = build_cell(file, lib=tmp_path, scan="10ms")
        cell.scan(2)
        return cell

    return built


@pytest.fixture
def cell(of_program: Callable[[str], Cell]) -> Cell:
    """Return a cell with a program that calls blocks."""
    return of_program("Contract.st")


@pytest.fixture
def inside(of_program: Callable[[str], Cell]) -> Cell:
    """Return a cell with blocks with Enable, and with blocks inside blocks."""
    return of_program("ContractInside.st")


ONE = "are true together; expected at most one"
ID = "Error is true exactly when ErrorID is not 0"


_BOTH = ("Once", "Twice")


def one_job(cell: Cell) -> None:
    """Run a scan without Execute, ten with it, and five without."""
    cell.scan()
    cell["Main.Go"] = True
    cell.scan(10)
    cell["Main.Go"] = False
    cell.scan(5)


def test_a_block_that_keeps_the_contract_is_not_reported(cell: Cell) -> None:
    cell["Main.Gate"] = True
    one_job(cell)
    one_job(cell)
    assert not cell.violations


@pytest.mark.parametrize(
    ("fault", "finding"),
    [
        (1, f"Done and Error {ONE}"),
        (2, "Active is true without Busy"),
        (3, f"Error is FALSE with ErrorID 16#0012; {ID}"),
        (4, "Busy fell without an end; expected Done or Error for at least one scan"),
        (5, "no Busy, Done or Error in the call of the rising edge"),
        (6, "Done is gone while Execute is true"),
        (7, "Done is shown for more than one scan after Execute has fallen"),
        (8, "Busy without a rising edge of Execute"),
    ],
)
def test_each_broken_clause_is_reported(cell: Cell, fault: int, finding: str) -> None:
    cell["Main.Fault"] = fault
    one_job(cell)
    found = [one for one in cell.violations if "Main.Steady" in one.text]
    assert found
    assert found[0].rule == "contract"
    assert found[0].text.endswith(f": contract: Main.Steady: {finding}")


def test_a_block_that_is_not_called_is_not_reported(cell: Cell) -> None:
    """A block that is not called is not reported.

    Its outputs do not change while Execute is TRUE.
    """
    cell["Main.Gated.Execute"] = True
    cell.scan(10)
    assert not cell.violations


def test_a_block_whose_call_can_be_skipped_is_still_checked_for_what_always_holds(
    cell: Cell,
) -> None:
    cell["Main.Gate"] = True
    cell["Main.Fault"] = 4
    one_job(cell)
    assert any("Main.Gated: Busy fell without an end" in one.text for one in cell.violations)


def test_execute_may_be_withdrawn_after_the_call(cell: Cell) -> None:
    cell["Main.Own.Execute"] = True
    cell.scan(10)
    assert not cell["Main.Own.Execute"]
    assert not cell.violations


def test_the_source_shows_which_calls_are_certain(repository: Path) -> None:
    program = repository / "tests" / "cell" / "programs" / "Contract.st"
    assert steady_instances([program]) == {"CONTRACT.STEADY", "FB_FAULTY.EDGE"}


def test_level_blocks_and_blocks_inside_blocks_that_keep_the_contract_are_not_reported(
    inside: Cell,
) -> None:
    inside["Main.Gate"] = True
    one_job(inside)
    one_job(inside)
    assert not inside.violations


@pytest.mark.parametrize(
    ("fault", "findings"),
    [
        (
            1,
            {
                *(f"Outer.{name}: Error is TRUE with ErrorID 16#0000; {ID}" for name in _BOTH),
                *(f"Outer.{name}: Done and Error {ONE}" for name in _BOTH),
                f"Outer.Once: Busy and Error {ONE}",
            },
        ),
        (
            2,
            {
                "Outer.Once: no Busy, Done or Error in the call of the rising edge",
                "Outer.Once: the end is gone while Execute is true",
            },
        ),
        (3, {f"Level: Valid and Busy {ONE}"}),
        (4, {"Level: no Valid, Busy or Error while Enable is true"}),
        (5, {"Level: Valid is true while Enable is FALSE"}),
        (6, {f"Level: Error is FALSE with ErrorID 16#8001; {ID}"}),
        (7, {f"Plain: Error is TRUE with ErrorID 16#0000; {ID}"}),
    ],
)
def test_each_clause_broken_by_a_level_block_or_inside_a_block_is_reported(
    inside: Cell, fault: int, findings: set[str]
) -> None:
    if fault == 5:
        inside["Main.Fault"] = fault
    one_job(inside)
    inside["Main.Fault"] = fault
    one_job(inside)
    found = {one.text.split(": contract: Main.")[1] for one in inside.violations}
    assert findings <= found
    assert {text.split(":")[0] for text in findings} == {text.split(":")[0] for text in found}


def test_a_block_inside_a_block_whose_call_can_be_skipped_is_judged_by_what_always_holds(
    inside: Cell,
) -> None:
    inside["Main.Gate"] = True
    inside["Main.Fault"] = 2
    one_job(inside)
    assert not [one.text for one in inside.violations if "Gated" in one.text]
    inside["Main.Fault"] = 1
    one_job(inside)
    assert [one.text for one in inside.violations if "Gated.Once" in one.text]


def test_the_monitor_finds_level_blocks_and_blocks_inside_blocks(
    inside: Cell, repository: Path
) -> None:
    program = repository / "tests" / "cell" / "programs" / "ContractInside.st"
    monitor = ContractMonitor(inside.program, steady_instances([program]))
    assert [one.path for one in monitor.instances] == [
        *("Main.Outer.Once", "Main.Outer.Twice", "Main.Gated.Once", "Main.Gated.Twice"),
        *("Main.Level", "Main.Plain"),
    ]
    steady = [one.path for one in monitor.instances if one.steady]
    assert steady == ["Main.Outer.Once", "Main.Level", "Main.Plain"]


def test_the_monitor_sees_the_work_inside_the_blocks_of_the_library(
    build_cell: Build, repository: Path
) -> None:
    files = source_files(sorted((repository / "plc" / "examples" / "01_power_up").glob("*.st")))
    cell = build_cell(list(files.own))
    monitor = ContractMonitor(cell.program, steady_instances(files.own, files.lib))
    assert "Main.ServoOn.Job" in [one.path for one in monitor.instances]


class _Pins:
    """A program with one block. The test sets its pins: Execute, Busy, Done, Error."""

    def __init__(self) -> None:
        self.values = (False, False, False, False)
        self.monitor = ContractMonitor(cast(Any, self), {"MAIN.JOB"})

    def instances(self) -> dict[str, BlockType]:
        kind = ElementaryType("BOOL")
        names = ("Execute", "Busy", "Done", "Error")
        job = BlockType("FB_RcxJob", tuple(Variable(name, kind, "VAR_INPUT") for name in names))
        return {"Main": BlockType("Main", (Variable("Job", job, "VAR"),))}

    def reader(self, paths: list[str]) -> Callable[[], tuple[bool, ...]]:
        assert [path.rpartition(".")[2] for path in paths] == ["Execute", "Busy", "Done", "Error"]
        return lambda: self.values

    def scan(self, *values: bool) -> list[str]:
        """Run a scan with these values, and return its reports."""
        self.values = cast(Any, values)
        return [one.text.rpartition(": ")[2] for one in self.monitor.scan(0, 0)]


def test_an_end_shown_again_after_a_restore_must_not_last() -> None:
    """After a restore, an end that is shown again must not stay for more than one scan.

    The restore discards the state of checks made after the snapshot.
    """
    pins = _Pins()
    assert pins.scan(True, False, True, False) == []
    assert pins.scan(False, False, True, False) == []
    kept: Any = pins.monitor.snapshot()
    assert pins.scan(False, False, False, False) == []
    pins.monitor.restore(kept)
    found = ["Done is shown for more than one scan after Execute has fallen"]
    assert pins.scan(False, False, True, False) == found


def test_pins_that_were_idle_before_a_restore_are_judged_after_it() -> None:
    """Pins that were idle before a restore are judged after it.

    After the restore, the pins go from Busy directly to idle, without an end.
    """
    pins = _Pins()
    assert pins.scan(True, True, False, False) == []
    kept: Any = pins.monitor.snapshot()
    assert pins.scan(False, False, True, False) == []
    assert pins.scan(False, False, False, False) == []
    pins.monitor.restore(kept)
    found = ["Busy fell without an end; expected Done or Error for at least one scan"]
    assert pins.scan(False, False, False, False) == found


_TASKS = """CONFIGURATION C RESOURCE R ON PLC
TASK T1(INTERVAL := T#10ms, PRIORITY := 0); TASK T2(INTERVAL := T#15ms, PRIORITY := 1);
PROGRAM Main WITH T1 : P; END_RESOURCE END_CONFIGURATION"""


@pytest.mark.parametrize(
    ("body", "certain"),
    [
        ("A(); A.Timeout := T#5s; END_PROGRAM", True),
        ("A(); Other.Execute := TRUE; END_PROGRAM", True),
        ("A(); Jobs[1].Execute := TRUE; END_PROGRAM", True),
        ("A(); Box.A.Execute := TRUE; END_PROGRAM", True),
        ("A(); Execute := TRUE; END_PROGRAM", True),
        ("A(); A.Execute := FALSE; END_PROGRAM", False),
        ("A(); A.Enable := FALSE; END_PROGRAM", False),
        ("A(); IF k = 1 THEN A.execute := FALSE; END_IF; END_PROGRAM", False),
        ("A(Execute := TRUE); IF k = 1 THEN RETURN; END_IF; END_PROGRAM", True),
        ("IF k = 1 THEN RETURN; END_IF; A(Execute := TRUE); END_PROGRAM", False),
        pytest.param(f"A(); END_PROGRAM {_TASKS}", False, id="one of several tasks"),
    ],
)
def test_a_call_is_certain_unless_it_can_be_skipped_or_its_inputs_are_written_after_it(
    tmp_path: Path, body: str, certain: bool
) -> None:
    program = tmp_path / "P.st"
    program.write_text(f"PROGRAM P VAR A : FB_X; k : INT; END_VAR {body}\n")
    assert steady_instances([program]) == ({"P.A"} if certain else set())
