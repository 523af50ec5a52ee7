"""The example program in diagnosis.md compiles, runs, and finds the cause of a fault."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from rcx_harness import Cell, spec
from rcx_tools.docs.diagnosis import PROGRAM, diagnosis_page, panel, run_panel
from structured_text.output.toml_files import load_toml


@pytest.mark.parametrize("engine", ENGINES)
def test_the_program_of_the_page_records_a_fault_and_continues_after_reset(engine: str) -> None:
    """The program records alarm 2.334 for point 20, which is beyond the soft limit.

    After a reset it records further events. Source: guide 1.1.
    """
    robot = PROGRAM.with_name("robot.toml")
    with Cell.build([PROGRAM], scan="10ms", engine=engine, robot=robot) as cell:
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        assert cell["Main.Recorder.Fault.Kind"] == "LOG_NOTHING"
        cell["Main.Start"] = True
        cell.run_until(lambda: cell["Main.Recorder.Frozen"], within="3s")
        fault = cell["Main.Recorder.Fault"]
        assert (fault["Number"], fault["Result"]) == (0x0001, 0x4000)
        assert (fault["Group"], fault["Category"]) == (2, 334)
        assert cell["Main.Recorder.FaultData[4]"] == 20
        assert cell["Main.Why.Text.Name"] == "Over soft limit"
        total = cell["Main.Recorder.Total"]
        cell["Main.CellSafe"] = False
        cell.run("300ms")
        assert cell["Main.Recorder.Total"] == total
        cell["Main.Reset"] = True
        cell.scan()
        assert not cell["Main.Recorder.Frozen"]
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        assert cell["Main.Recorder.Total"] > total
        assert not cell.violations


def test_the_panel_of_the_page_shows_the_fault_the_events_before_it_and_both_channels() -> None:
    shown = panel()
    lines = [line.strip("|+- ") for line in shown.splitlines()]
    assert len({len(line) for line in shown.splitlines()[1:-1]}) == 1
    assert "Fault at 960 ms: MovePtp, 16#4000, 2.334" in lines
    for text in ("Over soft limit", "620  SI(01) Servo ON input", "Command channel: free"):
        assert any(line.startswith(text) for line in lines), text
    rows = run_panel()["Recorder"]["Rows"]
    assert all(row["Kind"] != "LOG_NOTHING" for row in rows)


def test_the_page_has_every_text_in_both_languages() -> None:
    page = diagnosis_page()
    for table, key in (("alarms", "alarm"), ("errors", "error")):
        for row in load_toml(spec.folder() / f"{table}.toml")[key]:
            assert row["name"] in page
            assert all(row[f"{part}_ja"] in page for part in ("name", "cause", "remedy"))
