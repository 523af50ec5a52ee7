"""Examples 12 and 14: two controllers on one PLC are independent, except for a shared area."""

from __future__ import annotations

import pytest

from example_runs import finished
from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.cli.app import main
from rcx_harness.spec import folder
from rcx_tools.docs.examples import examples
from structured_text.output.toml_files import load_toml

_PLACE = (150_000, 0), (-120_000, 30_000)
_TRAY = (-50_000, 100_000), (60_000, 90_000)


def _build(name: str = "12_two_robots") -> Cell:
    return examples()[name].build("builtin")


_UNDO_EVENTS = {"link_down": "link_up", "emergency_stop": "emergency_stop_release"}
_EXAMPLE_12 = ("12_two_robots", "Carry1", "Carry2")
_EXAMPLE_14 = ("14_one_table", "Placer", "Taker")


def _started(name: str) -> Cell:
    """Build the cell of an example, and press Start, so that both robots work."""
    folder = ROOT / "plc/examples" / name
    cell = Cell.build(
        sorted(folder.glob("*.st")),
        robot=[folder / "robot1.toml", folder / "robot2.toml"],
        m=(0, 48),
        n=(0, 48),
        engine="builtin",
    )
    cell["Main.CellSafe"] = True
    cell.run("500ms")
    _press(cell, name, "Start")
    return cell


def _press(cell: Cell, name: str, button: str) -> None:
    """Press and release a button of both robots. In example 14 both robots share one button."""
    for value in (True, False):
        for keys in ("Key1.", "Key2.") if name.startswith("12") else ("",):
            cell[f"Main.{keys}{button}"] = value
        cell.run("200ms")


def _placed(cell: Cell) -> tuple[int, int]:
    return cell["Main.Carry1.Cycle.Count"], cell["Main.Carry2.Cycle.Count"]


def _away(cell: Cell) -> list[tuple[int, ...]]:
    return [tuple(one.positions[:2]) for one in cell.robots]


def test_at_most_one_robot_is_away_from_its_place() -> None:
    """At most one robot is away from its point 10, so the other is not at the tray.

    Source: points 10 and 20 of robot1.toml and robot2.toml.
    """
    with _build() as cell:
        cell.run_until(lambda: all(_away(cell)[k] == _PLACE[k] for k in (0, 1)), within="2s")
        visits: list[int] = []
        while cell.now_us < 9_000_000:
            cell.scan()
            away = _away(cell)
            out = [k for k in (0, 1) if away[k] != _PLACE[k]]
            assert len(out) < 2, f"both robots are at the tray: {away}"
            visits += [k for k in (0, 1) if away[k] == _TRAY[k] and visits[-1:] != [k]]
        assert visits == [1, 0, 1, 0], "the second robot was faster at first, and lost its link"
        assert _placed(cell) == (3, 2)
        assert not cell.violations


def test_while_robot_2_has_no_link_robot_1_places_its_part_and_waits() -> None:
    """While robot 2 has no link, robot 1 places its part and waits. Later both continue.

    Source: manual chapter 1, 5.2 (link loss), for each controller by itself.
    """
    with _build() as cell:
        cell.run("2380ms")
        before = _placed(cell)
        cell.run("1550ms")
        assert cell["Main.Connected"] is cell["Main.Connected2"] is True, (
            "the cable is plugged in again"
        )
        assert cell["Main.Carry2.Cycle.State"] == "WORK_FAULT"
        assert cell["Main.Carry2.Cycle.ErrorID"] == 0x8001
        assert cell["Main.Carry1.Cycle.ErrorID"] == 0
        assert before == (0, 1)
        assert _placed(cell) == (1, 1)
        assert cell["Main.Carry1.Lock.Busy"], "the second robot may have been moved to the tray"
        servo = [cell[f"Main.Robot{k}.SO.SO02_ServoOn"] for k in (1, 2)]
        assert servo == [True, False]
        cell.run_until(lambda: _placed(cell) == (2, 2), within="4s")


@pytest.mark.exhaustive
@pytest.mark.parametrize(("name", "one", "other"), [_EXAMPLE_12, _EXAMPLE_14], ids=["12", "14"])
@pytest.mark.parametrize("fault", ["emergency_stop", "auto_input_off", "power_off"])
def test_the_shown_fault_is_always_in_the_list_of_errors(
    name: str, one: str, other: str, fault: str
) -> None:
    """The shown ErrorID is one of the list, even if two blocks end with an error in one scan.

    Source: docs/reference/errors.md.
    """
    known = {int(row["id"]) for row in load_toml(folder() / "errors.toml")["error"]}
    with _started(name) as cell:
        found = set()
        for _ in range(60):
            cell.scan(7)
            before = cell.snapshot()
            for controller in (1, 2):
                cell.inject(fault, controller=controller)
                cell.run("300ms")
                found |= {cell[f"Main.{block}.Cycle.ErrorID"] for block in (one, other)}
                cell.restore(before)
    assert len(found) > 1
    assert found - {0} <= known


def test_an_emergency_stop_of_one_controller_does_not_stop_the_other() -> None:
    """An emergency stop of controller 2 does not stop robot 1. Source: manual chapter 5, 3.1."""
    with _build() as cell:
        cell.run_until(lambda: cell["Main.Carry2.Fetch.Busy"], within="3s")
        cell.run("100ms")
        cell.inject("emergency_stop", controller=2)
        cell.run("100ms")
        assert cell["Main.Carry2.Cycle.State"] == "WORK_FAULT", (
            "robot 2 must be in the state of a fault"
        )
        assert not cell["Main.Robot1.SO.SO00_EmergencyStop"]
        assert cell["Main.Carry2.Lock.Kept"] is True
        cell.run("2s")
        assert cell["Main.Carry1.Lock.Busy"], "robot 1 must wait for the area"
        cell["Main.CellSafe"] = False
        cell.run("100ms")
        emergency = [cell[f"Main.Robot{k}.SO.SO00_EmergencyStop"] for k in (1, 2)]
        assert emergency == [True, True]


@pytest.mark.exhaustive
@pytest.mark.parametrize(("name", "first", "second"), [_EXAMPLE_12, _EXAMPLE_14])
@pytest.mark.parametrize("how", ["emergency_stop", "link_down", "power_cycle", "manual_mode"])
def test_a_robot_moved_by_hand_keeps_the_area_until_it_is_at_its_place(
    name: str, first: str, second: str, how: str
) -> None:
    """A robot that was moved by hand keeps the area until it is at its place again.

    Source: head of FB_Interlock: clear Outside when servos, link or AUTO mode are lost
    """
    with _started(name) as cell:
        cell.run_until(
            lambda: (
                bool(cell[f"Main.{first}.Lock.Valid"] and cell[f"Main.{second}.Home.Done"])
                and _away(cell)[1] == _PLACE[1]
            ),
            within="20s",
        )
        cell.inject(how, controller=2)
        cell.run_until(lambda: bool(cell[f"Main.{second}.Lock.Holds"]), within="500ms")
        if how in _UNDO_EVENTS:
            cell.run("200ms")
            cell.inject(_UNDO_EVENTS[how], controller=2)
        cell.robots[1].positions[:2] = _TRAY[1]
        cell.run_until(lambda: not cell[f"Main.{first}.Lock.Valid"], within="1s")
        cell.run_until(lambda: _away(cell)[0] == _PLACE[0], within="20s")
        cell.run("5s")
        assert _away(cell) == [_PLACE[0], _TRAY[1]], "the first robot waits at its place"
        if how == "manual_mode":
            cell.inject("auto_mode", controller=2)
        before = cell[f"Main.{first}.Cycle.Count"], cell[f"Main.{second}.Cycle.Count"]
        for button in ("Reset", "Start"):
            _press(cell, name, button)
        cell.run("20s")
        after = cell[f"Main.{first}.Cycle.Count"], cell[f"Main.{second}.Cycle.Count"]
        assert all(now > then for now, then in zip(after, before, strict=True)), (
            "both robots must continue"
        )


@pytest.mark.exhaustive(but=["14_one_table-Main.Placer"])
@pytest.mark.parametrize(
    ("name", "waits"), [("12_two_robots", "Main.Carry1"), ("14_one_table", "Main.Placer")]
)
def test_a_wait_of_more_than_a_minute_for_the_other_robot_is_no_fault(
    name: str, waits: str
) -> None:
    """Robot 1 waits more than a minute for robot 2 without a fault.

    The pendant of robot 2 is plugged in, so its position is not known yet.

    Source: head of TwoRobots.st: a fault of one robot is not a fault of the other robot.
    """
    folder = ROOT / "plc/examples" / name
    with Cell.build(
        sorted(folder.glob("*.st")),
        scan="100ms",
        robot=[folder / "robot1.toml", folder / "robot2.toml"],
        m=(0, 48),
        n=(0, 48),
        engine="builtin",
    ) as cell:
        cell.inject("pendant_on", controller=2)
        cell["Main.CellSafe"] = True
        cell.run("1s")
        start = "Main.Key1.Start" if name.startswith("12") else "Main.Start"
        cell[start] = True
        cell.run("75s")
        assert cell[f"{waits}.Lock.Busy"] is True
        assert cell[f"{waits}.Cycle.ErrorID"] == 0


def test_the_areas_of_both_controllers_are_adjacent() -> None:
    """The two areas of 48 bytes are adjacent in the image. Source: manual chapter 1, 4.1."""
    cell = finished("12_two_robots").cell
    one, two = cell.trace.scans()[-2:]
    assert (one.controller, two.controller) == (1, 2)
    image = bytes(cell["Main.OutputArea"])
    assert image[:96] == one.si + two.si
    assert image[96:] == bytes(len(image) - 96)
    assert bytes(cell["Main.InputArea"])[:96] == one.so + two.so


def test_a_part_is_taken_from_the_table_before_the_next_is_placed() -> None:
    """The table never has two parts, even if robot 2 has an emergency stop with a part in hand."""
    with _build("14_one_table") as cell:
        kept, there = False, list[bool]()
        while cell.now_us < 12_000_000:
            cell.scan()
            out = [k for k in (0, 1) if _away(cell)[k] != _PLACE[k]]
            if cell.now_us > 1_500_000:
                assert len(out) < 2, f"both robots are at the table: {_away(cell)}"
            kept = kept or cell["Main.Taker.Lock.Kept"]
            part = cell["Main.PartOnTable"]
            there += [part] if there[-1:] != [part] else []
        assert kept, "the emergency stop comes while the second robot has the table"
        moved = [cell[f"Main.{one}.Cycle.Count"] for one in ("Placer", "Taker")]
        assert moved == [3, 2], "Stop came while the second robot carried its part away"
        assert there == [False, True] * 3
        assert cell["Main.Placer.Cycle.State"] == cell["Main.Taker.Cycle.State"] == "WORK_IDLE"
        assert not cell.violations


@pytest.mark.exhaustive
@pytest.mark.parametrize("example", ["12_two_robots", "14_one_table"])
def test_the_cell_recovers_from_every_kind_of_fault_at_some_scans(
    example: str, tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    """The cell recovers from each kind of fault at every 311th scan. Source: tests/data/sweeps."""
    folder, sweeps = ROOT / "plc/examples" / example, ROOT / "tests/data/sweeps"
    robots = [f"--robot={folder / f'robot{k}.toml'}" for k in (1, 2)]
    faults = "emergency_stop,link_down,power_cycle,alarm,plc_stop,plc_power_off"
    code = main(
        [
            *("sweep", *map(str, sorted(folder.glob("*.st"))), *robots),
            *("--m=0", "--m=48", "--n=0", "--n=48", "--engine=builtin", "--workers=0"),
            f"--stimulus={sweeps / f'{example}_run.toml'}",
            f"--properties={sweeps / f'{example}.toml'}",
            *("--every=311", f"--inject={faults},Main.CellSafe=false", f"--out={tmp_path}"),
        ]
    )
    assert code == 0, capsys.readouterr().out
    assert "the cell recovers from all of them" in capsys.readouterr().out
