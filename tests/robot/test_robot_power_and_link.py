"""The controller powers on, boots, and gains and loses its connection."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Point
from robot_master import Master, powered_up, servos_on


def test_the_controller_starts_in_the_servo_off_state() -> None:
    """After power-on the servos are OFF. CPU_OK and MP RDY turn ON at the end of the boot.

    Rule: servo-off-at-power-on, boot, power-on-state.
    Source: manual chapter 1, 5 and chapter 5, 3.1
    """
    master = Master(boot_time=100, booted=False)
    master.run(100)
    assert master.so == bytes(48)
    master.run(20)
    outputs = {name for name in ("SO00", "SO01", "SO02", "SO03", "SO04", "SO10") if master.on(name)}
    assert outputs == {"SO00", "SO01", "SO04", "SO10"}


def test_the_controller_has_booted_at_time_0_by_default() -> None:
    """The controller answers in its first cycle. Rule: boot."""
    master = Master()
    master.run(5)
    assert master.on("SO01")
    assert master.robot.online
    master.robot.inject("power_cycle")
    master.run(150)
    assert master.so == bytes(48)
    assert not master.robot.online


def test_si00_off_at_power_on_is_an_emergency_stop_without_alarm() -> None:
    """The initial servo ON process has no alarm reset, so nothing may be latched.

    Rule: emergency-at-power-on.
    """
    master = Master()
    master.run(300)
    assert master.on("SO00")
    assert not master.on("SO03")
    latched = Master(power_on_emergency_alarm=True)
    latched.run(300)
    assert latched.on("SO03")


def test_a_loss_of_the_link_is_one_alarm_however_long_it_lasts() -> None:
    """A long loss of the link is a single alarm, also if the alarm is not serious.

    Rule: link-loss-alarm, minor-alarms.
    """
    master = powered_up(minor_alarms=("12.552",))
    master.connected = False
    master.run(100)
    master.robot.inject("warning")
    master.run(100)
    assert [alarm.number for alarm in master.robot.alarms.history] == ["12.552", "12.600"]


@pytest.mark.parametrize(("edges", "expected"), [(False, False), (True, True)])
def test_an_input_that_is_on_at_the_first_image_makes_no_edge(edges: bool, expected: bool) -> None:
    """Rule: link-first-image."""
    master = powered_up(recovery_edges=edges, program_needs_servo=False)
    master.connected = False
    master.run(100)
    master.turn("SI16", True)
    master.connected = True
    master.run(200)
    master.turn_and_wait("SI16", False)
    assert master.on("SO03") is not expected
    assert not master.on("SO14")


def test_an_input_that_comes_on_during_the_boot_makes_no_edge() -> None:
    """Rule: link-first-image."""
    master = servos_on()
    master.robot.inject("power_cycle")
    master.run(50)
    master.turn_and_wait("SI12", True, 500)
    assert not master.on("SO00")
    assert not master.on("SO13")


def test_power_off_turns_all_outputs_off_until_power_on() -> None:
    """Rule: boot."""
    master = powered_up(boot_time=50)
    master.pulse("SI12")
    master.robot.inject("power_off")
    assert not master.robot.program.running
    master.run(500)
    assert master.so == bytes(48)
    master.robot.inject("power_on")
    master.run(100)
    assert master.on("SO01")


def test_power_off_in_a_movement_leaves_the_axes_where_they_are() -> None:
    """Rule: halt."""
    master = servos_on(points={19: Point((100000, 0, 0, 0, 0, 0))})
    master.send(0x0001, 0x0004, 0, 10, 19)
    master.run(300)
    before = master.robot.positions[0]
    master.robot.inject("power_cycle")
    master.send()
    master.run(1000)
    assert 0 < before <= master.robot.positions[0] < 100000


def test_a_power_on_alarm_is_there_after_the_boot() -> None:
    """Rule: power-on-state."""
    master = Master(power_on_alarm="12.762")
    master.run(300)
    assert master.on("SO03")
    assert not master.on("SO04")


@pytest.mark.parametrize("names", [("SI15",), ("SI00", "SI06", "SI15")])
def test_the_image_of_the_very_first_cycle_has_levels_only(names: tuple[str, ...]) -> None:
    """In the first cycle the controller has booted and the master is connected.

    Inputs that are ON count as levels, not as edges.

    Rule: link-first-image.
    """
    master = Master()
    for name in names:
        master.turn(name, True)
    master.run(200)
    assert master.texts() == []
    assert not master.on("SO14")
    assert master.on("SO00") is ("SI00" not in names)
