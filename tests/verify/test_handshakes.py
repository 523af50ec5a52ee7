"""The predefined properties of a handshake, such as stable data, are checked and reported."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rcx_harness.cell import Cell
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.config import RobotProgram
from rcx_harness.verify.handshakes.waits import waits
from rcx_harness.verify.properties import judge_run
from rcx_harness.verify.storm.demands import Demands
from structured_text.errors import InputError

#: Program of a handshake. The test writes each variable before a scan.
_PROGRAM = """PROGRAM Wire
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Strobe, Taken : BOOL;
    Data : INT;
  END_VAR
  Taken := Taken;
  IF OutputArea[32] = BYTE#0 THEN
    OutputArea[32] := BYTE#0;
  END_IF;
END_PROGRAM
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "Wire.st").write_text(_PROGRAM, encoding="utf-8")
    return tmp_path


def _cell(folder: Path, properties: str, program: str = "", **options: object) -> Cell:
    """Return a cell with these properties and this robot program."""
    config = RobotConfig(booted=True)
    if program:
        config = RobotConfig(booted=True, programs=(RobotProgram(name="MAIN", text=program),))
    cell = Cell.build(folder / "Wire.st", engine="builtin", robot=config, **options)  # type: ignore[arg-type]
    file = folder / "properties.toml"
    file.write_text(properties, encoding="utf-8")
    judge_run(cell, Demands.load([file]).properties)
    return cell


_VARIABLES = """[[stable]]
name = "data"
strobe = "Main.Strobe"
data = ["Main.Data"]
acknowledge = "Main.Taken"
{more}
"""


def _found(cell: Cell, rows: Iterator[tuple[int, int, int]]) -> list[str]:
    """Run a scan for each row (strobe, data, acknowledge), and return the broken properties."""
    for strobe, data, taken in rows:
        cell["Main.Strobe"], cell["Main.Data"], cell["Main.Taken"] = bool(strobe), data, bool(taken)
        cell.scan()
    return [one.text.partition(": property: ")[2] for one in cell.violations]


@pytest.mark.parametrize(
    ("more", "rows", "said"),
    [
        # Data and strobe change in one scan and so in one packet.
        ("", "001 000 010 110 110 111 121 020", ""),
        # The data change in the next scan, before the acknowledge.
        ("", "000 110 120", "changed 1 scan after Main.Strobe became ON, before Main.Taken has"),
        ("", "000 110 110 120", "changed 2 scans after Main.Strobe became ON"),
        ("", "000 110 110 110 110 120", "changed 3 or more scans after Main.Strobe became ON"),
        # The acknowledge is read in the scan of the change.
        ("", "000 110 121", ""),
        # The strobe is withdrawn with the change.
        ("", "000 110 020", ""),
        # A strobe that is ON in the first scan has no edge.
        ("", "110 120", ""),
        ("before = 1", "000 010 110", ""),
        ("before = 1", "000 000 110", "changed less than 1 scan before Main.Strobe became ON"),
        ("before = 2", "010 020 020 120", ""),
        ("before = 2", "010 010 020 120", "changed less than 2 scans before Main.Strobe"),
        # After this number of scans the data may change without an acknowledge.
        ("after = 2", "000 110 110 110 120", ""),
        ("after = 2", "000 110 110 120", "changed 2 scans after"),
    ],
)
def test_data_are_stable_from_the_edge_of_the_strobe_to_the_acknowledge(
    folder: Path, more: str, rows: str, said: str
) -> None:
    """Data must be stable from the edge of the strobe to the acknowledge.

    Each row is a scan: strobe, data, acknowledge. The expected results were found by hand.
    """
    with _cell(folder, _VARIABLES.format(more=more)) as cell:
        found = _found(cell, (tuple(map(int, row)) for row in rows.split()))  # type: ignore[misc]
    assert len(found) == bool(said)
    assert not said or found[0].startswith("stable data: Main.Data from ")
    assert not said or said in found[0]


def test_a_change_is_told_with_both_values(folder: Path) -> None:
    with _cell(folder, _VARIABLES.format(more="")) as cell:
        found = _found(cell, iter([(0, 0, 0), (1, 3, 0), (1, 4, 0)]))
    assert found == [
        "stable data: Main.Data from 3 to 4: changed 1 scan after Main.Strobe became ON, "
        "before Main.Taken has acknowledged it"
    ]


_TO_ROBOT = '[[stable]]\nname = "place"\nstrobe = "SI(20)"\ndata = ["SIW(2)"]\n'
_TO_PLC = (
    '[[stable]]\nname = "count"\nstrobe = "SO(20)"\ndata = ["SOW(2)"]\nacknowledge = "SI(20)"\n'
)


def _started(cell: Cell) -> Cell:
    """Run the robot program without servos, because it only reads and writes."""
    for inputs in (0x40, 0x41):  # SI(06), then SI(00)
        cell["Main.OutputArea[32]"] = inputs
        cell.run("150ms")
    for task in cell.robot.program.tasks:
        task.go(cell.now_us)
    cell.robot.write_port("SO(77)", 0)  # the controller must not skip its next cycle
    return cell


@pytest.mark.parametrize(
    ("first", "said"),
    [
        ("WAIT SI(20)=1\nN%=SIW(2)", ""),
        (
            "N%=SIW(2)\nWAIT SI(20)=1",
            "robot program MAIN reads SIW(2) in line 1 while SI(20) is OFF",
        ),
        (  # the rule is broken in each iteration, but reported once
            "*L:\nN%=SIW(2)\nIF SI(20)=0 THEN GOTO *L",
            "robot program MAIN reads SIW(2) in line 2 while SI(20) is OFF",
        ),
    ],
)
def test_the_robot_reads_the_data_while_the_strobe_is_on(
    folder: Path, first: str, said: str
) -> None:
    """A robot program may read the word of the PLC only while the strobe bit is ON."""
    with _started(_cell(folder, _TO_ROBOT, f"{first}\nWAIT SI(27)=1")) as cell:
        cell.scan(5)
        cell["Main.OutputArea[34]"] = 1
        cell.scan(5)
        found = [one.text.partition(": property: ")[2] for one in cell.violations]
    assert found == ([f"stable place: {said}"] if said else [])


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("SOW(2)=7\nSO(20)=1\nWAIT SI(20)=1\nSOW(2)=8", ""),
        (
            "SO(20)=1\nSOW(2)=7\nWAIT SI(20)=1",
            "robot program MAIN changes SOW(2) in line 2 while SO(20) is ON and SI(20) is OFF",
        ),
    ],
)
def test_the_robot_writes_the_data_before_its_strobe(folder: Path, program: str, said: str) -> None:
    """A robot program must write its data before its strobe.

    Data and strobe arrive in one packet in either order. Only the statements show the order.
    """
    with _started(_cell(folder, _TO_PLC, f"{program}\nWAIT SI(27)=1")) as cell:
        cell.scan(5)
        cell["Main.OutputArea[34]"] = 1
        cell.scan(5)
        found = [one.text.partition(": property: ")[2] for one in cell.violations]
    assert found == ([f"stable count: {said}"] if said else [])


_STILL = '[[deadlock]]\nwithin = "500ms"\n'


def test_a_standstill_is_reported_once_after_its_time(folder: Path) -> None:
    """A standstill (deadlock) is reported once, after its time.

    The PLC of this cell does not wait, so the message names only the robot.
    """
    with _started(_cell(folder, _STILL, "WAIT SI(20)=1 ' part")) as cell:
        cell.run("490ms")
        assert not cell.violations
        cell.run("2s")
        (found,) = cell.violations
    assert found.text.partition(": property: ")[2] == (
        "deadlock handshake: nothing has moved for 500 ms: "
        "robot program MAIN waits in line 1 for SI(20)=1"
    )


@pytest.mark.parametrize(
    ("properties", "program"),
    [
        (_STILL, "*L:\nSO(21)=1\nDELAY 200\nSO(21)=0\nDELAY 200\nGOTO *L"),  # it moves
        (_STILL, "HALT"),  # no program runs
        (f'{_STILL}while = "Main.Strobe"\n', "WAIT SI(20)=1"),  # no movement is expected
    ],
)
def test_a_cell_that_moves_or_need_not_has_no_deadlock(
    folder: Path, properties: str, program: str
) -> None:
    with _started(_cell(folder, properties, program)) as cell:
        cell.run("2s")
        assert not cell.violations


def test_a_program_that_polls_its_inputs_stands_still(folder: Path) -> None:
    """A robot program that only polls its inputs counts as standing still."""
    program = "*L:\nDELAY 10\nIF SI(20)=0 THEN GOTO *L"
    with _started(_cell(folder, _STILL, program)) as cell:
        cell.run("2s")
        (found,) = cell.violations
    assert "nothing has moved for 500 ms: robot program MAIN is in line 2: DELAY 10" in found.text


def test_two_bits_for_which_the_plc_waits_are_reported_together(folder: Path) -> None:
    """If the PLC waits for two bits, both are reported.

    It waits for SO(20) OFF together with SO(21) ON. One of them alone has no effect.
    """
    (folder / "Wire.st").write_text(
        _PROGRAM.replace(
            "  Taken := Taken;",
            "OutputArea[35] := SEL((InputArea[34] AND BYTE#3) = BYTE#2, BYTE#0, BYTE#1);",
        ),
        encoding="utf-8",
    )
    program = "SO(20)=1\nSO(21)=0\nWAIT SI(20)=1\nSO(20)=0\nSO(21)=1"
    with _started(_cell(folder, _STILL, program)) as cell:
        cell.run("200ms")
        before = cell["Main.OutputArea[35]"], cell["Main.InputArea[34]"]
        assert waits(cell) == (
            "PLC waits for SO(20) OFF and SO(21), robot program MAIN waits in line 3 for SI(20)=1"
        )
        assert (cell["Main.OutputArea[35]"], cell["Main.InputArea[34]"]) == before


_IN_A_BRANCH = """PROGRAM Wire
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Always : BOOL := TRUE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
  END_VAR
  IF Always THEN
    ReadArea(Robot := Robot, Image := InputArea, Connected := TRUE);
  END_IF;
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


def test_trial_scans_of_the_plc_do_not_count_for_other_rules(folder: Path) -> None:
    """The trial scans that find the bits for which the PLC waits do not count for other rules.

    Calls in a branch are counted at run time, but not in a trial.
    """
    (folder / "Wire.st").write_text(_IN_A_BRANCH, encoding="utf-8")
    with _cell(folder, _STILL, "WAIT SI(20)=1\nSO(21)=1") as cell:
        cell.run("2s")
        for task in cell.robot.program.tasks:
            task.go(cell.now_us)
        cell.robot.write_port("SO(77)", 0)
        cell.run("1s")
        assert [one.rule for one in cell.violations] == ["property"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[stable]]\ndata = "SIW(2)"', r"\[\[stable\]\] 1: strobe is missing"),
        ('[[stable]]\nstrobe = "SI(20)"', r"\[\[stable\]\] 1: data is missing"),
        ('[[stable]]\nstrobe = "SI(20)"\ndata = []', "data is not a list"),
        ('[[stable]]\nstrobe = "SI(20)"\ndata = "SIW(2)"\nbefore = -1', "before is not a number"),
        ('[[stable]]\nstrobe = "SI(20)"\ndata = "SIW(2)"\nafter = true', "after is not a number"),
        ('[[stable]]\nstrobe = 20\ndata = "SIW(2)"', "strobe is not a text"),
        ('[[stable]]\nstrobe = "SI(20)"\ndata = "SIW(2)"\nack = ""', "unknown key 'ack'"),
        ("stable = 3", "'stable' is not a list of tables"),
        ("[[deadlock]]", r"\[\[deadlock\]\] 1: within is missing"),
        ('[[deadlock]]\nwithin = "soon"', r"\[\[deadlock\]\] 1: "),
        ('[[deadlock]]\nwithin = "1s"\nduring = "x"', "unknown key 'during'"),
    ],
)
def test_a_table_that_cannot_be_read_is_one_message(folder: Path, text: str, message: str) -> None:
    file = folder / "wrong.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        Demands.load([file])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[stable]]\nstrobe = "SIW(2)"\ndata = "SIW(4)"', r"SIW\(2\) is not a bit"),
        ('[[stable]]\nstrobe = "SI(20)"\ndata = "Main.Nobody"', "Nobody"),
        ('[[stable]]\nstrobe = "SI(20)"\ndata = "SIW(30)"', r"needs the extended area"),
        ('[[stable]]\nstrobe = "SI(99)"\ndata = "SIW(2)"', r"SI\(99\)"),
        ('[[stable]]\nstrobe = "SI(20)"\ndata = "SIW(2)"\ncontroller = 2', "no controller 2"),
        ('[[deadlock]]\nwithin = "1s"\nwhile = "Main.Nobody"', "Nobody"),
    ],
)
def test_a_property_that_the_cell_does_not_have_is_one_message(
    folder: Path, text: str, message: str
) -> None:
    with pytest.raises(InputError, match=message) as found:
        _cell(folder, text)
    assert str(found.value.file).endswith("properties.toml")
