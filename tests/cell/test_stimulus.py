from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness import Cell, InputError, RobotConfig
from rcx_harness.cell.stimulus import Stimulus

Build = Callable[..., Cell]
Schedule = Callable[[str], None]


@pytest.fixture
def cell(raw_cell: Build) -> Cell:
    return raw_cell(robot=RobotConfig(boot_time=0.0))


def load(folder: Path, text: str) -> Stimulus:
    file = folder / "stimulus.toml"
    file.write_text(text)
    return Stimulus.load(file)


@pytest.fixture
def schedule(cell: Cell, tmp_path: Path) -> Schedule:
    """Return a function that schedules the entries of a stimulus text in the cell."""
    return lambda text: load(tmp_path, text).schedule(cell)


def test_a_variable_is_set_before_the_scan_at_that_time(cell: Cell, schedule: Schedule) -> None:
    schedule('[[at]]\ntime = "20ms"\nset = { "Main.Bits0" = 1 }\n')
    cell.run("30ms")
    assert [one.si[32] for one in cell.trace.scans()] == [0, 0, 1]


def test_durations_can_be_set_in_structures_and_arrays(tmp_path: Path) -> None:
    """Durations can be set in structures and arrays. Other members keep their values."""
    program = tmp_path / "Timed.st"
    program.write_text(
        "TYPE\n  PART : STRUCT\n    Settle : TIME;\n    Name : STRING[8];\n  END_STRUCT;\n"
        "END_TYPE\n"
        "TYPE\n  PARTS : ARRAY [1..2] OF PART;\nEND_TYPE\n"
        "TYPE\n  WAITS : ARRAY [0..1, 0..1] OF TIME;\nEND_TYPE\n"
        "PROGRAM Timed\n  VAR\n    InputArea, OutputArea : RCX_IMAGE;\n    Parts : PARTS;\n"
        "    Waits : WAITS;\n    Robot : RCX_REF;\n  END_VAR\n"
        "  Robot.Connected := FALSE;\nEND_PROGRAM\n"
    )
    with Cell.build(program, scan="10ms", engine="builtin") as cell:
        load(
            tmp_path,
            '[[at]]\ntime = "0ms"\nset = { "Main.Parts" = [{ settle = "50ms" }, { Name = "5ms" }],'
            ' "Main.Waits" = [["1s", "2ms"], ["3us", "4s"]] }\n',
        ).schedule(cell)
        cell.scan(1)
        settle, name = cell["Main.Parts[1].Settle"], cell["Main.Parts[2].Name"]
        waits = [cell[f"Main.Waits[{place}]"].total_seconds() for place in ("0,0", "0,1", "1,0")]
    assert (settle.total_seconds(), name, waits) == (0.05, "5ms", [1, 0.002, 0.000003])


def test_entries_may_have_any_order(cell: Cell, schedule: Schedule) -> None:
    schedule(
        '[[at]]\ntime = "20ms"\nset = { "Main.Data" = 2 }\n'
        '[[at]]\ntime = "10ms"\nset = { "Main.Data" = 1 }\n'
        '[[at]]\ntime = "20ms"\nset = { "Main.Data" = 3 }\n'
    )
    cell.run("30ms")
    assert [one.si[2] for one in cell.trace.scans()] == [0, 1, 3]


def test_an_event_is_injected_into_the_robot(cell: Cell, schedule: Schedule) -> None:
    """The event `alarm` at 50 ms turns SO(03) ON in the same cycle.

    Source: manual chapter 5, 2.
    """
    schedule('[[at]]\ntime = "50ms"\nrobot = [{ event = "alarm", group = 12, category = 600 }]\n')
    cell.run("100ms")
    answers = {one.t_us: one.rcx_so[32] >> 3 & 1 for one in cell.trace.cycles()}
    assert (answers[45_000], answers[50_000]) == (0, 1)


def test_the_link_goes_down_and_up(cell: Cell, schedule: Schedule) -> None:
    schedule(
        '[[at]]\ntime = "100ms"\nrobot = "link_down"\n[[at]]\ntime = "400ms"\nrobot = "link_up"\n'
    )
    cell.run("300ms")
    assert not cell.connected
    cell.run("200ms")
    assert cell.connected


def test_an_output_is_held_and_released(cell: Cell, schedule: Schedule) -> None:
    schedule(
        '[[at]]\ntime = "50ms"\nhold = "SO03"\n[[at]]\ntime = "60ms"\nrobot = '
        '{ event = "alarm", group = 12, category = 600 }\n'
        '[[at]]\ntime = "100ms"\nrelease = ["SO03"]\n'
    )
    cell.run("120ms")
    answers = {one.t_us: one.rcx_so[32] >> 3 & 1 for one in cell.trace.cycles()}
    assert (answers[95_000], answers[100_000]) == (0, 1)


def test_an_output_is_forced_and_a_workpiece_is_placed(cell: Cell, schedule: Schedule) -> None:
    """A forced SO(20) is ON until it is released: bit 0 of byte m + 34 (manual chapter 1, 4.1)."""
    schedule(
        '[[at]]\ntime = "50ms"\nforce = { "SO(20)" = 1 }\nworkpieces = { 3 = -5, 4 = 7 }\n'
        '[[at]]\ntime = "100ms"\nrelease = "SO(20)"\nworkpieces = { 4 = "none" }\n'
    )
    cell.run("70ms")
    assert cell.robot.workpieces == {2: -5, 3: 7}
    cell.run("50ms")
    assert cell.robot.workpieces == {2: -5}
    answers = {one.t_us: one.rcx_so[34] for one in cell.trace.cycles()}
    assert (answers[45_000], answers[50_000], answers[95_000], answers[100_000]) == (0, 1, 1, 0)


AREA = """
[[at]]
time = "10ms"
area = "01a5 20"

[[at]]
time = "30ms"
area = "0700"
connected = false

[[at]]
time = "50ms"
area = "robot"
"""


def test_the_plc_reads_given_bytes_for_a_time(cell: Cell, schedule: Schedule) -> None:
    schedule(AREA)
    read, connected = [], []
    for _ in range(6):
        cell.scan()
        read.append(cell["Main.Status"])
        connected.append(cell["Main.Connected"])
    given = [one.so[:4].hex() for one in cell.trace.scans()]
    assert given == ["00000000", "01a52000", "01a52000", "07000000", "07000000", given[5]]
    assert read[:5] == [0, 0xA5, 0xA5, 0, 0]
    assert connected[1:] == [True, True, False, False, True]
    # The controller's dedicated outputs are in bytes 32 and 33.
    assert cell.trace.scans()[5].so[32:34] != b"\0\0"


def test_given_bytes_are_part_of_a_snapshot(cell: Cell, schedule: Schedule) -> None:
    schedule(AREA)
    cell.run("20ms")
    before = cell.snapshot()
    cell.run("40ms")
    cell.restore(before)
    cell.scan()
    assert cell.trace.scans()[-1].so[:3].hex() == "01a520"


def test_entries_after_the_end_are_reported(cell: Cell, tmp_path: Path) -> None:
    """An entry at exactly the end of a run has no effect, so it is reported as too late."""
    times = ("900ms", "1s", "50s")
    text = "".join(
        f'[[at]]\ntime = "{time}"\nset = {{ "Main.Data" = {number} }}\n'
        for number, time in enumerate(times, 1)
    )
    stimulus = load(tmp_path, text)
    stimulus.schedule(cell)
    cell.run("1s")
    assert cell["Main.Data"] == 1
    file = tmp_path / "stimulus.toml"
    assert stimulus.late(1_000_000) == f"2 entries of {file} are at or after the end (1 s)"
    assert stimulus.late(1_000_001) == f"1 entry of {file} is at or after the end (1 s)"
    assert stimulus.late(50_000_001) == ""


def test_checks_before_the_run_change_nothing(cell: Cell, schedule: Schedule) -> None:
    schedule('[[at]]\ntime = "1s"\nset = { "Main.Bits0" = 1 }\nrobot = "power_off"\n')
    assert cell["Main.Bits0"] == 0
    cell.run("100ms")
    assert cell.connected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[[at]]\ntime = 'soon'\n", ":1: 'soon' is not a duration"),
        ("\n\n[[at]]\nset = {}\n", ":3: the entry has no time"),
        ("[[at]]\ntime = 5\n", ":1: time is not a text"),
        ("[[at]]\ntime = '1s'\nrobots = 'x'\n", ":1: unknown key 'robots'; did you mean robot"),
        ("[[at]]\ntime = '1s'\nrobot = 'link_dwn'\n", ":1: unknown event 'link_dwn'; did you mean"),
        ("[[at]]\ntime = '1s'\nrobot = 5\n", ":1: robot is not an event"),
        ("[[at]]\ntime = '1s'\nset = 5\n", ":1: set is not a table"),
        ("[[at]]\ntime = '1s'\nhold = 5\n", ":1: hold is not a signal"),
        (
            "[[at]]\ntime = '1s'\nforce = 'SO03'\n",
            ":1: force must be a table of outputs and values",
        ),
        ("[[at]]\ntime = '1s'\nforce = { SO03 = true }\n", ":1: force must be a table of outputs"),
        ("[[at]]\ntime = '1s'\nworkpieces = 5\n", ":1: workpieces is not a table"),
        ("[[at]]\ntime = '1s'\nworkpieces = { x = 5 }\n", ":1: workpieces has no axis x"),
        ("[[at]]\ntime = '1s'\nworkpieces = { 3 = 1.5 }\n", ":1: the workpiece of axis 3 needs"),
        ("[[at]]\ntime = '1s'\narea = '012'\n", ":1: area is '012', which is not hexadecimal"),
        ("[[at]]\ntime = '1s'\narea = 'rob'\n", ":1: area is 'rob', which is not hexadecimal"),
        ("[[at]]\ntime = '1s'\narea = 5\n", ":1: area is 5, which is not hexadecimal"),
        ("[[at]]\ntime = '1s'\narea = '00'\nconnected = 0\n", ":1: connected is not true or"),
        ("[[at]]\ntime = '1s'\nconnected = true\n", ":1: connected can be used only together with"),
        (
            "[[at]]\ntime = '1s'\narea = 'robot'\nconnected = true\n",
            ":1: connected can be used only",
        ),
        ("[[att]]\ntime = '1s'\n", "unknown key 'att'; did you mean at"),
        ("at = 5\n", "'at' is not a list of tables"),
        ("[[at]\n", "not valid TOML"),
        (
            "[[at]]\ntime = '0ms'\nset = { 'Main.Go' = true, 'MAIN.GO' = false }",
            ":1: Main.Go is set twice, also as MAIN.GO",
        ),
        ("[[at]]\ntime = '0ms'\nworkpieces = { 3 = 1, 03 = 2 }", "workpieces has axis 3 twice"),
    ],
)
def test_a_wrong_entry_has_its_file_and_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        load(tmp_path, text)
    assert f"stimulus.toml{message}" in str(caught.value) or message in str(caught.value)
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("set = { 'Main.Go' = true }", "Main of type RawArea has no member Go"),
        ("set = { 'Main.Bits0' = 300 }", "300"),
        ("set = { 'Main.Bits0' = 'on' }", "on"),
        ("robot = { event = 'alarm', group = 12 }", "event 'alarm' needs category"),
        ("robot = { event = 'link_down', now = 1 }", "event 'link_down' takes no arguments"),
        ("hold = 'SO99'", "SO99"),
        ("force = { SO03 = 2 }", "SO03 is a bit and cannot be 2"),
        ("workpieces = { 5 = 1 }", "there is no axis 5; use 1 to 4"),
        ("workpieces = { 1 = 3000000000 }", "a workpiece stands at -2147483648 to 2147483647"),
        (f"area = '{'00' * 49}'", "area has 49 bytes, but the PLC's area has 48"),
        ("area = '00'\ncontroller = 2", "no controller 2; the cell has 1"),
        ("robot = { event = 'parallel_input', port = 20, on = 7 }", "on = 7"),
        ("robot = { event = 'packets_lost', to = ['robot'] }", "to = ['robot'] is not a direction"),
        ("robot = { event = 'packets_lost', share = nan }", "share = nan is not a share"),
        (f"hold = 'SOW({'9' * 5000})'", "no signal is called"),
    ],
)
def test_unknown_names_are_reported_before_the_run(
    cell: Cell, tmp_path: Path, entry: str, message: str
) -> None:
    stimulus = load(tmp_path, f"[[at]]\ntime = '0ms'\n\n[[at]]\ntime = '9s'\n{entry}\n")
    with pytest.raises(InputError) as caught:
        stimulus.schedule(cell)
    assert f"{tmp_path}/stimulus.toml:4: " in str(caught.value)
    assert message in str(caught.value)


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        Stimulus.load(tmp_path / "none.toml")
