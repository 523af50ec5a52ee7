"""A run reports blocks that are called twice in a scan, for two robots, or not at all.

Source: docs/explanation/scan-model.md, one scan.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness import Cell

Build = Callable[[str], Cell]

READ = "ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);"
WRITE = "WriteArea(Robot := Robot, Image := OutputArea);"
ORIGIN = "Origin(Robot := Robot, Execute := Go);"
POWER = "PowerUp(Robot := Robot, Execute := Go, StartProgram := FALSE);"

TWICE = "was called 2 times in one scan; call it once, because otherwise its time limits are wrong"
TWO = "was called for two robots; declare an instance for each"
SKIPPED = (
    "was not called though it is busy: it loses its turn (16#8013); "
    "call it in every scan, outside of any IF"
)

HEAD = """PROGRAM P
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Robot, Other : RCX_REF;
    Robots : RCX_ROBOTS;
    Connected, Gate, Go : BOOL;
    k : INT := 1;
    ReadArea, ReadAgain : FB_ReadArea;
    WriteArea, WriteAgain : FB_WriteArea;
    Origin : FB_ReturnToOrigin;
    PowerUp : FB_PowerUp;
    Station, Second : FB_Station;
  END_VAR
"""
STATION = """FUNCTION_BLOCK FB_Station
  VAR_IN_OUT
    Robot : RCX_REF;
  END_VAR
  VAR_INPUT
    Go, Leave : BOOL;
  END_VAR
  VAR
    Origin : FB_ReturnToOrigin;
  END_VAR
  IF NOT Leave THEN
    Origin(Robot := Robot, Execute := Go);
  END_IF;
END_FUNCTION_BLOCK
TYPE
  RCX_ROBOTS : ARRAY [1..2] OF RCX_REF;
END_TYPE
"""


@pytest.fixture
def build(build_cell: Callable[..., Cell], tmp_path: Path) -> Build:
    """Return a cell after two scans of a program with this body.

    Its engine reports calls.
    """

    def built(body: str) -> Cell:
        file = tmp_path / "program.st"
        file.write_text(f"{HEAD}{body}\nEND_PROGRAM\n{STATION}", encoding="utf-8")
        cell = build_cell(file, engine="builtin", scan="10ms")
        cell.scan(2)
        return cell

    return built


def told(cell: Cell) -> list[str]:
    """Return the reports about calls as `scan: instance text`."""
    texts = [one.text for one in cell.violations if one.rule == "calls"]
    assert all(text.startswith("plc, scan ") for text in texts)
    return [text.removeprefix("plc, scan ").replace(": calls: Main.", ": ") for text in texts]


def test_calls_as_they_should_be_are_not_reported(build: Build) -> None:
    """Correct calls are not reported, even if their order or number depends on conditions."""
    cell = build(
        f"{READ} IF Gate THEN {ORIGIN} ELSE {ORIGIN} END_IF; {POWER}\n"
        f"Station(Robot := Robots[k], Go := Go); {WRITE}"
    )
    cell["Main.Go"] = True
    for gate in (True, False, False, True):
        cell["Main.Gate"] = gate
        cell.scan(3)
    assert told(cell) == []


def test_a_block_that_is_called_twice_is_reported_once_while_it_lasts(build: Build) -> None:
    cell = build(f"{READ} IF Gate THEN {ORIGIN} END_IF; {ORIGIN} {WRITE}")
    cell["Main.Gate"] = True
    cell.scan(3)
    cell["Main.Gate"] = False
    cell.scan(1)
    cell["Main.Gate"] = True
    cell.scan(1)
    assert told(cell) == [f"2: Origin {TWICE}", f"6: Origin {TWICE}"]
    assert [one.t_us for one in cell.violations] == [20_000, 60_000]


def test_three_calls_are_counted(build: Build) -> None:
    cell = build(f"{READ} FOR k := 1 TO 3 DO {ORIGIN} END_FOR; {WRITE}")
    assert told(cell) == [f"0: Origin {TWICE.replace('2', '3')}"]


@pytest.mark.parametrize(
    ("body", "text"),
    [
        (f"{READ} {READ} {WRITE}", f"0: ReadArea {TWICE}"),
        (f"{READ} {WRITE} {WRITE}", f"0: WriteArea {TWICE}"),
        (
            f"{READ} {READ.replace('ReadArea', 'ReadAgain')} {WRITE}",
            "0: ReadArea and Main.ReadAgain both read the area of one robot; call one of them",
        ),
        (
            f"{READ} {WRITE.replace('WriteArea', 'WriteAgain')} {WRITE}",
            "0: WriteAgain and Main.WriteArea both write the area of one robot; call one of them",
        ),
    ],
)
def test_area_blocks_called_twice_are_reported(build: Build, body: str, text: str) -> None:
    """A second call of an area block is reported, because Elapsed or a command would be wrong."""
    assert told(build(body)) == [text]


def test_two_area_blocks_for_two_robots_are_no_misuse(build: Build) -> None:
    cell = build(
        f"{READ} ReadAgain(Robot := Other, Image := InputArea, m := 48, Connected := Connected); "
        f"IF Gate THEN {ORIGIN} END_IF; {WRITE} "
        "WriteAgain(Robot := Other, Image := OutputArea, n := 48);"
    )
    assert told(cell) == []


def test_an_instance_for_two_robots_is_reported_where_an_index_chooses_them(build: Build) -> None:
    cell = build(f"{READ} Station(Robot := Robots[k], Go := Go); {WRITE}")
    cell["Main.k"] = 2
    cell.scan(3)
    cell["Main.k"] = 1
    cell.scan(1)
    both = ("Station", "Station.Origin")
    assert told(cell) == [f"{scan}: {name} {TWO}" for scan in (2, 5) for name in both]


def test_a_block_that_is_left_out_while_it_is_busy_is_reported(build: Build) -> None:
    cell = build(f"{READ} IF NOT Gate THEN {ORIGIN} END_IF; {WRITE}")
    cell["Main.Gate"] = True
    cell.scan(2)
    assert told(cell) == [], "the block is not Busy"
    cell["Main.Gate"], cell["Main.Go"] = False, True
    cell.run_until(lambda: cell["Main.Connected"], within="5s")
    cell.run_until(lambda: cell["Main.Origin.Error"], within="1s")
    cell["Main.Go"] = False
    cell.scan(2)
    cell["Main.Go"] = True
    cell.scan()
    assert cell["Main.Origin.Busy"]
    cell["Main.Gate"] = True
    at = cell.scans
    cell.scan(3)
    assert told(cell) == [f"{at}: Origin {SKIPPED}"]


def test_a_scan_without_any_block_of_the_robot_is_not_reported(build: Build) -> None:
    """If a scan skips all blocks of a robot, nothing is reported.

    Without FB_WriteArea no turn is lost.

    An example is a task that is slower than the others.
    """
    cell = build(f"IF NOT Gate THEN {READ} {ORIGIN} {WRITE} END_IF;")
    cell["Main.Go"] = True
    cell.scan()
    assert cell["Main.Origin.Busy"]
    cell["Main.Gate"] = True
    cell.scan(2)
    assert told(cell) == []


def test_blocks_inside_a_block_of_the_user_are_watched_each_by_itself(build: Build) -> None:
    cell = build(
        f"{READ} Station(Robot := Robot, Go := Go, Leave := Gate); Second(Robot := Robot); {WRITE}"
    )
    cell["Main.Go"] = True
    cell.scan()
    assert cell["Main.Station.Origin.Busy"]
    cell["Main.Gate"] = True
    cell.scan(1)
    assert told(cell) == [f"3: Station.Origin {SKIPPED}"]


def test_blocks_inside_blocks_of_the_library_are_not_judged(build: Build) -> None:
    """Blocks inside blocks of the library are not judged: FB_PowerUp calls some only if needed."""
    cell = build(f"{READ} {POWER} IF Gate THEN {ORIGIN} END_IF; {WRITE}")
    cell["Main.Go"] = True
    cell.run("1s")
    assert told(cell) == []


def test_two_cells_of_one_program_do_not_see_each_others_calls(build: Build) -> None:
    body = f"{READ} IF Gate THEN {ORIGIN} END_IF; {ORIGIN} {WRITE}"
    one, two = build(body), build(body)
    one["Main.Gate"] = True
    one.scan()
    two.scan()
    assert (told(one), told(two)) == ([f"2: Origin {TWICE}"], [])


def test_a_restored_cell_reports_the_same_again(build: Build) -> None:
    cell = build(f"{READ} Station(Robot := Robots[k], Go := Go); {WRITE}")
    before = cell.snapshot()
    for _ in range(2):
        cell.restore(before)
        cell["Main.k"] = 2
        cell.scan(2)
        assert told(cell) == [f"2: Station {TWO}", f"2: Station.Origin {TWO}"]
