"""Examples 04 to 07 move the robot to the right positions, also after a fault."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from typing import Any

import pytest

from example_runs import finished
from rcx_harness.cell import Cell
from rcx_harness.robot.ports import port
from rcx_tools.docs.examples import examples

_HAND = port("DO(20)")


def _build(name: str) -> Cell:
    return examples()[name].build("builtin")


def _hand(cell: Cell) -> bool:
    return bool(cell.robot.machine.ports.read(_HAND))


def _at_rest(cell: Cell, duration: str, look: Callable[[], Any] = lambda: None) -> list[Any]:
    """Run the cell, and list each stop of two scans or more: axes 1 to 3 and `look()`."""
    seen = []
    for _ in range(int(duration.removesuffix("s")) * 100):
        cell.scan()
        seen.append((*cell.robot.positions[:3], look()))
    return [one for one, group in groupby(seen) if len(list(group)) > 1]


def test_parts_are_picked_at_point_10_and_placed_at_point_20() -> None:
    """The hand closes only at point 10 and opens only at point 20, while the robot does not move.

    Source: guide 4.2.1 and 4.5.1; robot.toml of the example.
    """
    part, tray = (100_000, 20_000, 0), (-60_000, 80_000, 0)
    with _build("04_pick_and_place") as cell:
        stops = _at_rest(cell, "5s", lambda: _hand(cell))
        cycle = [(*part, False), (*part, True), (*tray, True), (*tray, False)]
        assert stops == [(0, 0, 0, False), *cycle * 3]
        assert cell["Main.Cycle.Count"] == 3, "Stop was pressed when the third part was fetched"
        assert cell["Main.Cycle.State"] == "WORK_IDLE"


def test_the_hand_keeps_its_part_through_an_emergency_stop_and_nothing_starts_by_itself() -> None:
    """After an emergency stop the hand is still closed, and nothing moves before Reset and Start.

    Source: guide 1.2 (12.600); chapter 5, 3.1.
    """
    with _build("04_pick_and_place") as cell:
        cell.run_until(lambda: cell["Main.Carry.Stage"] == "PICK_TO_TARGET", within="3s")
        cell.run("100ms")
        cell["Main.CellSafe"] = False
        cell.run_until(lambda: cell["Main.Cycle.State"] == "WORK_FAULT", within="100ms")
        where = list(cell.robot.positions)
        cell["Main.Reset"] = True
        cell.run("200ms")
        assert cell["Main.Cycle.State"] == "WORK_FAULT", (
            "Reset must have no effect while CellSafe is FALSE"
        )
        shown = [cell[f"Main.Cycle.{pin}"] for pin in ("ErrorID", "AlarmGroup", "AlarmCategory")]
        assert shown[:2] == [0x8020, 12]
        assert shown[2] in (400, 600), "the alarm is 12.400 or 12.600"
        cell["Main.CellSafe"] = True
        cell.run("200ms")
        held = "a button that was held before acknowledges nothing"
        assert cell["Main.Cycle.ErrorID"] == 0x8020, held
        cell["Main.Reset"] = False
        cell.scan()
        cell["Main.Reset"] = True
        cell.run("2s")
        assert cell["Main.Cycle.State"] == "WORK_IDLE"
        assert cell["Main.Cycle.ErrorID"] == 0
        assert not cell["Main.Robot.SO.SO02_ServoOn"]
        assert cell.robot.positions == where
        assert _hand(cell)
        cell["Main.Reset"] = False
        cell["Main.Start"] = True
        stops = _at_rest(cell, "2s", lambda: _hand(cell))
        assert stops[1] == (-60_000, 80_000, 0, True), (
            "the robot goes to the tray with the part in the hand"
        )
        assert cell["Main.Cycle.Count"] >= 1
        assert not cell.violations


def test_if_the_part_was_removed_from_the_hand_a_new_part_is_fetched() -> None:
    """If the part was removed from the hand, the cycle fetches a new part.

    Source: head of FB_PickPlace.
    """
    with _build("04_pick_and_place") as cell:
        cell.run_until(lambda: cell["Main.Carry.Stage"] == "PICK_TO_TARGET", within="3s")
        cell.robot.inject("alarm")
        cell.run_until(lambda: cell["Main.Cycle.State"] == "WORK_FAULT", within="1s")
        cell["Main.HandEmpty"] = cell["Main.Reset"] = True
        cell.run("100ms")
        cell["Main.Start"] = True
        cell.run_until(lambda: cell["Main.Carry.Stage"] == "PICK_TO_SOURCE", within="2s")
        assert not _hand(cell)


def test_a_held_start_button_does_not_start_after_a_fault() -> None:
    """A Start button that is held from before a fault has no effect after Reset.

    Source: design of the examples: nothing restarts by itself.
    """
    with _build("04_pick_and_place") as cell:
        cell.run("900ms")
        cell["Main.Start"] = True
        cell.run("200ms")
        cell.robot.inject("alarm")
        cell.run("100ms")
        cell["Main.Reset"] = True
        cell.run("1s")
        assert cell["Main.Cycle.State"] == "WORK_IDLE"


def test_a_jog_lasts_as_long_as_its_button_and_a_step_is_500_pulses() -> None:
    """A jog lasts 0.5 s at 10 %, a step is 500 pulses, and the soft limit ends a jog with a fault.

    Source: guide 4.2.6, 4.2.7, 4.2.8; 2.334 at the soft limit: guide 1.1.
    """
    with _build("05_jog_panel") as cell:
        cell.run("2400ms")
        jogged = cell.robot.positions[0]
        assert 40_000 < jogged < 50_000, "10 % of 1,000,000 pulses/s, less acceleration and braking"
        cell.run("500ms")
        assert cell.robot.positions[:2] == [jogged, -500]
        assert cell["Main.Shown"][:2] == [jogged, -500]
        cell.run("1s")
        assert cell.robot.positions[1] == -60_000
        assert (cell["Main.Stage"], cell["Main.Fault"]) == ("JOG_FAULT", 0x8020)
        cell.run("900ms")
        assert cell["Main.Stage"] == "JOG_AMOUNT", (
            "Reset and Start have no effect while the button is held"
        )
        assert cell.robot.positions[1] == -60_000
        cell.run("1s")
        assert -60_000 < cell.robot.positions[1] < 0
        assert not cell.violations


def test_while_both_jog_buttons_are_pressed_nothing_moves() -> None:
    """While both jog buttons are pressed, nothing moves.

    The second jog waits for the end of the first.

    Source: guide 4.2.6: SI(06) ends a jog.
    """
    with _build("05_jog_panel") as cell:
        cell.run("1400ms")
        cell["Main.Minus"] = True
        cell.run("100ms")
        stood = list(cell.robot.positions)
        cell.run("100ms")
        assert cell.robot.positions == stood
        cell["Main.Plus"] = False
        cell.run_until(lambda: cell["Main.JogMinus.Valid"], within="1s")
        assert not cell["Main.JogPlus.Valid"]
        cell.run("100ms")
        assert cell.robot.positions[0] < stood[0]
        assert not cell.violations


def test_points_are_stored_in_the_controller_with_their_names_and_copied_to_the_plc() -> None:
    """Taught points are in the controller with names, and are copied to the PLC.

    Source: guide 4.2.9, 4.3.1, 4.3.2; robot.toml of the example.
    """
    cell = finished("06_teach_points").cell
    points, memory = cell.robot.points, cell.robot.machine.memory
    there = cell.robot.positions[0]
    assert there > 15_000
    assert points[101].data[:2] == (15_000, -40_000)
    assert points[102].data[:2] == (there, -40_000)
    assert [memory.comment(number).rstrip("\0 ") for number in (101, 102)] == ["FEEDER", "TRAY"]
    copies = cell["Main.Copies"]
    assert [copy["Filled"] for copy in copies] == [True, True, False, False]
    assert [copy["Pulses"][0] for copy in copies[:2]] == [15_000, there]
    assert cell["Main.Fault"] == 0


def test_a_copy_is_written_back_to_a_controller_that_has_lost_the_point() -> None:
    """A point that the controller has lost is written back; a point that was never taught is not.

    Source: guide 4.3.1.
    """
    with _build("06_teach_points") as cell:
        cell.run("2900ms")
        taught = cell.robot.points[101]
        del cell.robot.points[101]
        cell.run("1s")
        assert cell.robot.points[101].data == taught.data
        before = dict(cell.robot.points)
        cell["Main.Selector"] = 4
        cell.run("20ms")
        cell["Main.PutBack"] = True
        cell.run("500ms")
        assert dict(cell.robot.points) == before
        assert not cell.violations


@pytest.mark.exhaustive
def test_the_pallet_is_filled_position_by_position_in_arches() -> None:
    """The six places are filled in the order X, then Y. Axis 3 rises to 0 on the way.

    Source: guide 4.2.5 and 4.3.3; points 101 to 105 of robot.toml.
    """
    places = [(x, y, 30_000) for y in (10_000, 50_000) for x in (40_000, 60_000, 80_000)]
    with _build("07_pallet") as cell:
        stops = [one[:3] for one in _at_rest(cell, "9s")]
        part = (0, 0, 20_000)
        assert [one for one in stops if one in places] == places
        assert stops.count(part) == 6, "after the fault the third part is in the hand"
        (broken_off,) = [one for one in stops if one not in (*places, part, (0, 0, 0))]
        assert broken_off[2] == 0, "the door was opened at the top of the arch"
        assert (cell["Main.Place"], cell["Main.Pallet.Full"]) == (0, True)
        pallet = cell.robot.machine.memory.pallets[1]
        assert (pallet.nx, pallet.ny, pallet.nz, pallet.first) == (3, 2, 1, 101)
        cell["Main.Start"] = True
        cell.run("200ms")
        assert cell["Main.Cycle.State"] == "WORK_IDLE", "the pallet is full"
        assert not cell.violations


def test_a_start_button_held_at_the_start_of_the_plc_starts_nothing() -> None:
    """A Start button that is stuck at the PLC's start starts nothing.

    Source: design of the examples.
    """
    with _build("13_pallet_by_table") as cell:
        cell["Main.Start"] = True
        seen = []
        for _ in range(200):
            cell.scan()
            seen.append((cell["Main.Stage"], cell["Main.Fault"]))
        assert set(seen) == {("FILL_IDLE", 0)}


def test_only_a_press_of_the_new_pallet_button_clears_the_count() -> None:
    """Only a press of NewPallet clears the count of places. A stuck button does not.

    Source: design of the examples: a stuck button is not a press.
    """

    def standing() -> tuple[int, int]:
        return cell["Main.Place"], cell["Main.Row"]

    with _build("13_pallet_by_table") as cell:
        cell["Main.Place"], cell["Main.Row"], cell["Main.NewPallet"] = 3, 2, True
        cell.run("100ms")
        assert standing() == (3, 2)
        cell["Main.NewPallet"] = False
        cell.scan()
        cell["Main.NewPallet"] = True
        cell.scan()
        assert standing() == (1, 0)
        cell["Main.Place"], cell["Main.Row"] = 4, 1
        cell.run("100ms")
        assert standing() == (4, 1)


def test_the_pallet_cycle_shows_the_alarm_of_its_interrupted_movement() -> None:
    """After an interrupted movement, the outputs show its alarm. Source: guide 1.2 (12.600)."""
    with _build("07_pallet") as cell:
        cell.run_until(lambda: cell["Main.Cycle.State"] == "WORK_FAULT", within="9s")
        shown = [cell[f"Main.Cycle.{pin}"] for pin in ("ErrorID", "AlarmGroup", "AlarmCategory")]
        assert shown[:2] == [0x8020, 12]
        assert shown[2] in (400, 600), "the alarm is 12.400 or 12.600"
