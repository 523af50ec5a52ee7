"""The sentences of chapter 5, 2, about SI(14) and SI(17), the return-to-origin by axis type."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from chapter_cell import ChapterCell
from rcx_harness.robot import Axis
from robot_master import servos_on

Start = Callable[..., ChapterCell]

ABSOLUTE, INCREMENTAL = Axis(start=700), Axis(start=700, type="incremental")
SEMI, MARK = Axis(start=700, type="semi_absolute"), Axis(start=700, origin_method="mark")


def test_si14_returns_incremental_and_semi_absolute_axes(start: Start) -> None:
    """Absolute axes do not move. Source: manual chapter 5, 2, SI(14)."""
    cell = start(axes=(ABSOLUTE, INCREMENTAL, SEMI))
    cell.robot.origins[1:] = [False, False]
    cell.servo_on()
    assert cell.return_to_origin("ORIGIN_INCREMENTAL") == 0
    assert cell.robot.origins == [True, True, True]
    assert cell.robot.positions[0] == 700


def test_at_si14_incremental_axes_return_and_semi_absolute_axes_search(start: Start) -> None:
    """After SI(14) the incremental axis is at 0. The semi-absolute axis is where it was before.

    Source: manual chapter 5, 2, SI(14)
    """
    cell = start(axes=(INCREMENTAL, SEMI), origin_complete=False).servo_on()
    since = cell.from_now()
    assert cell.return_to_origin("ORIGIN_INCREMENTAL") == 0
    assert cell.steps(since)[:2] == ["SI14 ON", "SO11 ON"]
    assert cell.robot.positions == [0, 700]


@pytest.mark.parametrize("method", ["sensor", "stroke_end", "mark"])
def test_si14_is_for_axes_with_the_sensor_or_stroke_end_method(start: Start, method: str) -> None:
    """Source: manual chapter 5, 2, SI(14)."""
    axis = Axis(start=700, type="incremental", origin_method=method)
    cell = start(axes=(axis,), origin_complete=False).servo_on()
    assert (cell.return_to_origin("ORIGIN_INCREMENTAL") == 0) is (method != "mark")
    assert (cell.robot.positions == [0]) is (method != "mark")


def test_the_axes_that_si17_moves_depend_on_the_parameter_di17_mode(start: Start) -> None:
    """SI(17) is for absolute axes only, or for absolute and incremental axes.

    Source: manual chapter 5, 2, SI(17)
    """
    cell = start(axes=(ABSOLUTE, INCREMENTAL), di17_mode="ABS").servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    assert cell.robot.positions == [0, 700]


def test_si17_moves_absolute_and_incremental_axes_in_the_dual_mode(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(17)."""
    cell = start(axes=(ABSOLUTE, INCREMENTAL), di17_mode="ABS/ORG").servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    assert cell.robot.positions == [0, 0]


def test_with_abs_si17_on_performs_the_return_to_origin_of_absolute_axes(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(17), ABS."""
    cell = start(axes=(ABSOLUTE,), origin_complete=False, di17_mode="ABS").servo_on()
    cell["Axes"] = "ORIGIN_ABSOLUTE"
    assert cell.steps_of("ReturnToOrigin") == ["SI17 ON", "SO11 ON", "SI17 OFF"]


@pytest.mark.parametrize(("mode", "groups"), [("ABS", 1), ("ABS/ORG", 2)])
def test_si17_acts_when_it_is_switched_from_off_to_on(mode: str, groups: int) -> None:
    """If SI(17) stays ON, the axis moves once.

    Source: manual chapter 5, 2, SI(17), ABS and ABS/ORG.
    """
    master = servos_on(axes=(ABSOLUTE, INCREMENTAL), origin_time=200, di17_mode=mode)
    master.turn_and_wait("SI17", True, 200 * groups + 50)
    assert master.robot.positions[0] == 0
    master.robot.positions[0] = 99
    master.run(2000)
    assert master.robot.positions[0] == 99


def test_with_abs_an_axis_with_the_mark_method_does_not_perform_the_return(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(17), ABS."""
    cell = start(axes=(MARK, ABSOLUTE), di17_mode="ABS").servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    assert cell.robot.positions == [700, 0]


def test_with_abs_nothing_moves_while_a_mark_axis_is_not_complete(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(17), ABS."""
    cell = start(axes=(MARK, ABSOLUTE), di17_mode="ABS", origin_complete=False).servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0x8010
    assert cell.robot.positions == [700, 700]
    cell.robot.origins[0] = True
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    assert cell.robot.positions == [700, 0]


@pytest.mark.parametrize(
    ("axes", "positions"),
    [
        ((ABSOLUTE, ABSOLUTE), [0, 0]),
        ((INCREMENTAL, INCREMENTAL), [0, 0]),
        ((INCREMENTAL, SEMI), [0, 700]),
        ((ABSOLUTE, INCREMENTAL, SEMI), [0, 0, 700]),
    ],
)
def test_with_abs_org_si17_performs_the_return_of_all_axis_types(
    start: Start, axes: tuple[Axis, ...], positions: list[int]
) -> None:
    """SI(17) returns all axes of a robot, whatever their types. A semi-absolute axis searches.

    Source: manual chapter 5, 2, SI(17), ABS/ORG
    """
    cell = start(axes=axes, origin_complete=False, di17_mode="ABS/ORG").servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    assert cell.robot.positions == positions
    assert all(cell.robot.origins)


def test_with_abs_org_the_absolute_axes_move_before_the_other_axes(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(17), ABS/ORG."""
    cell = start(axes=(INCREMENTAL, SEMI, ABSOLUTE), origin_complete=False).servo_on()
    cell["Axes"] = "ORIGIN_ABSOLUTE"
    cell["ReturnToOrigin.Execute"] = True
    cell.cell.run_until(lambda: cell.robot.origins[2], within="2s")
    assert cell.robot.origins == [False, False, True]
    assert cell.robot.positions == [700, 700, 0]
    cell.wait("SO11")
    assert cell.robot.positions == [0, 700, 0]


def test_si17_can_serve_as_both_inputs_of_older_robots(start: Start) -> None:
    """In the mode ABS/ORG, SI(17) alone performs the return-to-origin of all axes.

    Source: manual chapter 5, 2, SI(17), first note
    """
    cell = start(origin_complete=False, di17_mode="ABS/ORG").servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    assert cell.on("SO11")


def test_with_abs_org_si17_returns_absolute_axes_each_time(start: Start) -> None:
    """In the mode ABS/ORG, absolute axes return to origin again although their origin is complete.

    Source: manual chapter 5, 2, SI(17), second note.
    """
    cell = start(axes=(ABSOLUTE, INCREMENTAL, SEMI), di17_mode="ABS/ORG")
    cell.robot.origins[1:] = [False, False]
    cell.servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    assert cell.robot.positions[0] == 0


def test_with_mixed_axes_si17_and_si14_are_used_separately(start: Start) -> None:
    """If SI(17) serves absolute axes and SI(14) the others, SI(14) does not move absolute axes.

    Source: manual chapter 5, 2, SI(17), last note
    """
    cell = start(axes=(ABSOLUTE, INCREMENTAL, SEMI), di17_mode="ABS").servo_on()
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0
    cell.robot.positions[0] = 55
    assert cell.return_to_origin("ORIGIN_INCREMENTAL") == 0
    assert cell.robot.positions == [55, 0, 700]
