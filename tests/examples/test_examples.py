"""The examples behave as their README says, on each engine and over each link."""

from __future__ import annotations

import json

import pytest

from both_engines import ENGINES
from example_runs import EXAMPLES, ROOT, changes, finished, recorded_trace
from rcx_harness.cell import Cell
from rcx_harness.trace import Violation
from rcx_tools.docs.examples import ChartSpec, Example, Recorder, chart_specs, examples, files
from structured_text.errors import InputError

_each = pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
#: The examples that run over EtherNet/IP as well: 48 bytes at offset 0, 256 bytes, words at
#: offsets, and two robots.
_NETWORKED = [one for one in EXAMPLES if one.name[:2] in ("01", "02", "03", "12")]


def _first(cell: Cell, byte: int, bit: int, on: bool = True) -> int:
    """Return the first time at which a bit of byte 32 or 33 of the PLC was `on` [us]."""
    return next(one.t_us for one in cell.trace.scans() if bool(one.si[byte] >> bit & 1) is on)


def test_every_folder_is_in_the_readme_with_its_command() -> None:
    folders = sorted(path.parent for path in (ROOT / "plc/examples").glob("*/Config.st"))
    assert sorted(example.folder for example in EXAMPLES) == folders


def test_every_example_has_its_chart_and_its_line_in_the_table() -> None:
    table = (ROOT / "plc/examples/README.md").read_text(encoding="utf-8")
    assert list(chart_specs()) == list(examples())
    for path in files():
        link = path.removeprefix("plc/examples/")
        assert f"[chart]({link}) |" in table


@pytest.mark.exhaustive(but=["01_power_up", "02_extended_area", "09_openplc"])
@_each
def test_an_example_runs_without_a_violation(example: Example) -> None:
    assert finished(example.name).cell.violations == []


@pytest.mark.exhaustive(
    but=[
        *("01_power_up", "02_extended_area", "03_general_io", "05_jog_panel", "06_teach_points"),
        *("08_program_by_name", "09_openplc", "11_emergency_stop"),
    ]
)
@_each
def test_the_chart_shows_the_run(example: Example) -> None:
    drawn = (example.folder / "chart.svg").read_text(encoding="utf-8")
    assert finished(example.name).chart == drawn, "the chart is out of date: run `make docs`"


def test_a_run_that_breaks_a_rule_gives_no_chart() -> None:
    recorder = Recorder(chart_specs()["02_extended_area"])
    with examples()["02_extended_area"].build("builtin", watch=recorder.watch) as cell:
        recorder.listen(cell)
        with pytest.raises(InputError, match="changed too early"):
            cell.trace.add(Violation(0, "interval", "changed too early"))


@pytest.mark.parametrize("lane", ["SI99 = nothing", "DO(98) = nothing", "curve = nothing"])
def test_a_lane_for_an_unknown_signal_is_refused(lane: str) -> None:
    with pytest.raises(InputError):
        Recorder(ChartSpec("a chart", 0, 1, (lane,)))


@_each
@pytest.mark.parametrize("engine", ENGINES)
def test_the_trace_is_the_one_recorded_from_matiec(example: Example, engine: str) -> None:
    recorded = recorded_trace(example).read_text(encoding="utf-8").splitlines()
    assert list(changes(finished(example.name, engine).cell.trace.lines())) == recorded[1:], (
        "record it anew if the library or the robot has changed: tests/examples/record_examples.py"
    )


@pytest.mark.exhaustive(but=["01_power_up"])
@pytest.mark.parametrize("example", _NETWORKED, ids=lambda example: example.name)
def test_over_ethernet_ip_the_trace_is_the_same(example: Example) -> None:
    with example.build("builtin", link="enip") as cell:
        cell.run("2s")
        enip = list(changes(cell.trace.lines()))
    recorded = recorded_trace(example).read_text(encoding="utf-8").splitlines()
    assert enip == [line for line in recorded[1:] if json.loads(line)["t_us"] < 2_000_000]
    assert len(enip) > 15


def test_the_power_up_goes_through_its_stages_and_reads_servo_and_position_back() -> None:
    """The example completes all stages, and reads the servo status and the position.

    Source: manual chapter 5, 3.1 and 3.2; guide chapter 2, example.
    """
    cell = finished("01_power_up").cell
    assert cell["Main.Stage"] == "STAGE_COMPLETE"
    assert cell["Main.Fault"] == 0
    assert cell["Main.Robot.SO.SO02_ServoOn"] is True
    assert cell["Main.Axis1"] == 120_000, "the robot must be at point 19 of robot.toml"
    order = [_first(cell, 32, 0), _first(cell, 32, 6), _first(cell, 32, 1)]
    order += [_first(cell, 33, 5), _first(cell, 33, 2)]
    assert order == sorted(order), "SI00, SI06, SI01, SI15, SI12"
    sent = [one.si[:10] for one in cell.trace.scans() if one.si[0] == 1]
    telegram = "0100 0400 0000 3200 1300"  # words n to n+8, low byte first: 1, 4, 0, 50, 19
    assert {bytes(words).hex() for words in sent} == {telegram.replace(" ", "")}


def test_the_power_up_keeps_its_fault_until_reset_and_then_start() -> None:
    """If Reset and Start are pressed together, the fault stays. Source: design of the examples."""
    with examples()["01_power_up"].build("builtin") as cell:
        cell.run("600ms")
        cell.robot.inject("emergency_stop")
        cell.run_until(lambda: cell["Main.Stage"] == "STAGE_FAULT", within="500ms")
        cell.run("500ms")
        assert cell["Main.Fault"] == 0x8003, "emergency stop"
        cell.robot.inject("emergency_stop_release")
        cell["Main.Start"] = cell["Main.Reset"] = True
        cell.run("100ms")
        assert cell["Main.Stage"] == "STAGE_FAULT"
        cell["Main.Start"] = cell["Main.Reset"] = False
        cell.scan()
        cell["Main.Reset"] = True
        cell.run("100ms")
        assert cell["Main.Stage"] == "STAGE_IDLE"
        assert cell["Main.Fault"] == 0
        cell["Main.Start"] = True
        cell.run_until(lambda: cell["Main.Stage"] == "STAGE_COMPLETE", within="4s")


def test_the_extended_area_is_written_and_read_at_its_offsets() -> None:
    """The PLC uses the area of 256 bytes at m and n. Source: manual chapter 1, 4.2; guide 4.3.1."""
    cell = finished("02_extended_area").cell
    assert cell["Main.Complete"] is True
    assert cell["Main.Axis2"] == -20_000
    assert cell.robot.points[100].data == (10_000, -20_000, 0, 0, 0, 0)
    assert bytes(cell["Main.OutputArea"][:200]) == bytes(200)
    assert cell["Main.OutputArea[232]"] == 0x41


def test_a_part_goes_to_the_robot_program_and_back() -> None:
    """The robot program returns the values of the PLC. Source: manual chapter 5, 2, SIW and SOW."""
    cell = finished("03_general_io").cell
    assert cell["Main.Fault"] == 0
    assert cell["Main.Complete"] is True
    assert (cell["Main.PartBack"], cell["Main.HeightBack"]) == (0x0200, -20_000)
