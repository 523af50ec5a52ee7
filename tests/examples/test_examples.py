"""The examples do what their README says, on each engine and over each link."""

from __future__ import annotations

from pathlib import Path

import pytest

from example_runs import EXAMPLES, SECONDS, Example, changes
from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.engine.load import find_c_compiler, find_matiec

_BY_NAME = {example.folder.name: example for example in EXAMPLES}
_each = pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.folder.name)


def _first(cell: Cell, byte: int, bit: int, on: bool = True) -> int:
    """When the PLC first wrote (byte 32, 33 of the area to the robot) that bit so, in us."""
    return next(one.t_us for one in cell.trace.scans() if bool(one.si[byte] >> bit & 1) is on)


def test_every_folder_is_in_the_readme_with_its_command() -> None:
    folders = sorted(path.parent for path in (ROOT / "plc/examples").glob("*/Config.st"))
    assert sorted(example.folder for example in EXAMPLES) == folders


@_each
def test_an_example_runs_without_a_violation(example: Example) -> None:
    with example.build() as cell:
        cell.run(f"{SECONDS}s")
        assert not cell.violations
        assert cell["Main.Fault"] == 0


def test_the_power_up_goes_through_its_stages_and_reads_servo_and_position_back() -> None:
    """Servo on, program reset, program start, PTP to point 19, position.

    Source: manual chapter 5, 3.1 and 3.2; guide chapter 2, example.
    """
    with _BY_NAME["01_power_up"].build() as cell:
        cell.run(f"{SECONDS}s")
        assert cell["Main.Stage"] == "STAGE_COMPLETE"
        assert cell["Main.Robot.SO.SO02_ServoOn"] is True
        assert cell["Main.Axis1"] == 120_000, "point 19 of robot.toml"
        order = [_first(cell, 32, 0), _first(cell, 32, 6), _first(cell, 32, 1)]
        order += [_first(cell, 33, 5), _first(cell, 33, 2)]
        assert order == sorted(order), "SI00, SI06, SI01, SI15, SI12"
        sent = [one.si[:10] for one in cell.trace.scans() if one.si[0] == 1]
        telegram = "0100 0400 0000 3200 1300"  # n: 0x0001, n+2: 0x0004, n+6: 0x0032, n+8: 0x0013
        assert {bytes(words).hex() for words in sent} == {telegram.replace(" ", "")}


def test_the_extended_area_is_written_and_read_at_its_offsets() -> None:
    """Source: manual chapter 1, 4.2; guide 4.3.1."""
    with _BY_NAME["02_extended_area"].build() as cell:
        cell.run(f"{SECONDS}s")
        assert cell["Main.Complete"] is True
        assert cell["Main.Axis2"] == -20_000
        assert cell.robot.points[100].data == (10_000, -20_000, 0, 0, 0, 0)
        assert bytes(cell["Main.OutputArea"][:200]) == bytes(200)
        assert cell["Main.OutputArea[232]"] == 0x41


@_each
def test_over_ethernet_ip_the_trace_is_the_same(example: Example, tmp_path: Path) -> None:
    for link in ("direct", "enip"):
        with example.build(link=link, trace=tmp_path / link) as cell:
            cell.run(f"{SECONDS}s")
    direct, enip = ((tmp_path / link).read_bytes() for link in ("direct", "enip"))
    assert direct.partition(b"\n")[2] == enip.partition(b"\n")[2]


@_each
@pytest.mark.parametrize("engine", ["builtin", "matiec"])
def test_the_trace_is_the_one_recorded_from_matiec(
    example: Example, engine: str, tmp_path: Path
) -> None:
    if engine == "matiec" and (find_matiec() is None or find_c_compiler() is None):
        pytest.skip("matiec not found: set RCX_MATIEC or PATH")
    with example.build(engine, trace=tmp_path / "trace") as cell:
        cell.run(f"{SECONDS}s")
    recorded = example.recorded.read_text(encoding="utf-8").splitlines()
    assert list(changes(tmp_path / "trace")) == recorded[1:], (
        "record it anew if the library or the robot has changed: tests/examples/record_examples.py"
    )
