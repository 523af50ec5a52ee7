"""The return-to-origin depends on the axis type (chapter 5, 2)."""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Axis
from robot_master import Master, powered_up, servos_on

ABSOLUTE, INCREMENTAL = Axis(start=700), Axis(start=700, type="incremental")
SEMI, MARK = Axis(start=700, type="semi_absolute"), Axis(start=700, origin_method="mark")


def _master(*axes: Axis, **config: Any) -> Master:
    """Return a master with servos on and axes at 700 pulses.

    A return-to-origin takes 200 ms for each group of axes.
    """
    return servos_on(axes=axes, origin_time=200, **config)


@pytest.mark.parametrize(
    ("name", "mode", "positions"),
    [
        ("SI14", "ABS", [700, 0, 700]),
        ("SI14", "ABS/ORG", [700, 0, 700]),
        ("SI17", "ABS", [0, 700, 700]),
        ("SI17", "ABS/ORG", [0, 0, 700]),
    ],
)
def test_each_origin_input_moves_its_axes(name: str, mode: str, positions: list[int]) -> None:
    """SI(14) and SI(17) move the axes of their types.

    A semi-absolute axis searches its origin near its position.

    Rule: origin, origin-types, origin-model.
    Source: manual chapter 5, 2, SI(14) and SI(17)
    """
    master = _master(ABSOLUTE, INCREMENTAL, SEMI, di17_mode=mode)
    master.turn_and_wait(name, True, 1000)
    assert master.robot.positions == positions
    assert master.on("SO11")


@pytest.mark.parametrize(("clears", "shown"), [(True, False), (False, True)])
def test_a_key_decides_so11_during_a_return_to_origin(clears: bool, shown: bool) -> None:
    """Rule: origin-model."""
    master = _master(INCREMENTAL, origin_clears_complete=clears)
    master.turn_and_wait("SI14", True, 100)
    assert master.on("SO11") is shown
    master.run(150)
    assert master.on("SO11")


@pytest.mark.parametrize("clears", [True, False])
def test_a_return_to_origin_that_is_stopped_is_not_complete(clears: bool) -> None:
    """The stop is alarm 12.400. The axes of the second step do not move.

    Rule: origin-model, stop-alarm.
    """
    master = _master(ABSOLUTE, INCREMENTAL, origin_clears_complete=clears)
    master.turn_and_wait("SI17", True, 150)
    master.turn_and_wait("SI06", False, 500)
    assert master.robot.origins == [False, True]
    assert [alarm.number for alarm in master.robot.alarms.history] == ["12.400"]
    master.turn_and_wait("SI06", True, 500)
    assert not master.on("SO11")


def test_an_emergency_stop_ends_the_return_to_origin() -> None:
    """Rule: origin-model, emergency-stop."""
    master = _master(ABSOLUTE)
    master.turn_and_wait("SI17", True, 150)
    master.turn_and_wait("SI00", False, 500)
    assert not master.on("SO11")
    assert master.robot.positions == [700]


@pytest.mark.parametrize("name", ["SI14", "SI17"])
@pytest.mark.parametrize("mode", ["ABS", "ABS/ORG"])
def test_an_axis_with_the_mark_method_is_not_moved(name: str, mode: str) -> None:
    """Rule: origin-mark. Source: manual chapter 5, 2, SI(14) and SI(17)."""
    mark = Axis(start=700, type="incremental", origin_method="mark")
    master = _master(MARK, mark, ABSOLUTE, INCREMENTAL, di17_mode=mode)
    master.turn_and_wait(name, True, 1000)
    assert master.robot.positions[:2] == [700, 700]


def test_without_the_origin_of_a_mark_axis_si17_does_nothing() -> None:
    """The axis must first be brought to its mark, which is not possible over the network.

    Rule: origin-mark.
    Source: manual chapter 5, 2, SI(17), ABS
    """
    master = _master(MARK, ABSOLUTE, origin_complete=False)
    master.pulse("SI17", 400)
    assert master.robot.positions == [700, 700]
    master.robot.origins[0] = True
    master.pulse("SI17", 400)
    assert master.robot.positions == [700, 0]
    assert master.on("SO11")


def test_an_input_without_an_axis_to_move_does_nothing() -> None:
    """Rule: origin-model."""
    master = _master(ABSOLUTE)
    master.pulse("SI14", 400)
    assert master.on("SO11")
    assert master.robot.positions == [700]


@pytest.mark.parametrize(("loses", "complete"), [(True, [True, False, False]), (False, [True] * 3)])
def test_a_key_decides_which_axes_keep_their_origin_without_power(
    loses: bool, complete: list[bool]
) -> None:
    """Rule: origin-kept."""
    master = _master(ABSOLUTE, INCREMENTAL, SEMI, power_loses_origin=loses)
    master.robot.inject("power_cycle")
    master.run(300)
    assert master.robot.origins == complete
    assert master.on("SO11") is all(complete)


@pytest.mark.parametrize(("knob", "complete"), [(True, False), (False, True)])
def test_a_return_to_origin_needs_the_servos(knob: bool, complete: bool) -> None:
    """Rule: origin-model."""
    master = powered_up(origin_complete=False, origin_time=50, origin_needs_servo=knob)
    master.pulse("SI17")
    assert master.on("SO11") is complete


def test_a_second_input_during_a_return_to_origin_has_no_effect() -> None:
    """Rule: origin-model."""
    master = servos_on(axes=(ABSOLUTE, INCREMENTAL), origin_time=400, di17_mode="ABS")
    master.turn_and_wait("SI17", True, 150)
    master.turn_and_wait("SI14", True, 600)
    assert master.robot.positions == [0, 700]


@pytest.mark.parametrize("name", ["SI14", "SI17"])
def test_while_an_axis_moves_no_return_to_origin_begins(name: str) -> None:
    """The movement or return-to-origin that is already running continues.

    Rule: origin-model.
    """
    master = servos_on(origin_time=1000)
    master.send(0x0001, 0x0004, 0, 10, 19)  # at 10 % to point 19
    master.run(50)
    master.pulse(name)
    assert not master.robot.machine.origin_running
    assert master.finish()[0] == 0x0200
    master.send()
    master.run(10)
    master.pulse("SI14", 120)
    master.pulse(name, 120)
    assert master.robot.machine.origin_running
    master.run(540)  # 1,000 ms after the start of the first return
    assert not master.robot.machine.origin_running
