"""The dedicated inputs and outputs have the effects of chapter 5."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from robot_master import Master, powered_up, servos_on


def _numbers(master: Master) -> list[str]:
    return [alarm.number for alarm in master.robot.alarms.active]


def test_servo_on_is_executed_when_si01_switches_from_off_to_on() -> None:
    """The answer comes after its delay and stays when SI(01) is withdrawn.

    Rule: servo-on, answers.
    Source: manual chapter 5, 2 and 3.1, initial servo ON process
    """
    master = powered_up(servo_on_delay=50)
    master.turn_and_wait("SI01", True, 50)
    assert not master.on("SO02")
    master.run(5)
    assert master.on("SO02")
    master.run(100)
    master.turn_and_wait("SI01", False)
    assert master.on("SO02")


def test_a_short_switch_off_of_si00_is_an_emergency_stop_too() -> None:
    """The stop counts even if SI(00) is ON again before the answer.

    Rule: emergency-stop.
    Source: manual chapter 5, 3.1
    """
    master = servos_on(emergency_stop_delay=30)
    master.turn_and_wait("SI00", False, 10)
    master.turn_and_wait("SI00", True, 200)
    assert not master.on("SO00")
    assert not master.on("SO02")
    assert master.on("SO03")


def test_servo_on_from_emergency_stop_goes_over_the_alarm_reset() -> None:
    """Rule: emergency-release, alarm-reset, servo-needs-reset.

    Source: manual chapter 5, 3.1, servo ON process from emergency stop status
    """
    master = servos_on()
    master.drop("SI00")
    assert not master.on("SO00")
    assert master.on("SO03")
    master.pulse("SI01")
    assert not master.on("SO02")
    master.pulse("SI16")
    assert not master.on("SO03")
    master.pulse("SI01")
    assert master.on("SO02")
    assert master.texts() == []


def test_an_emergency_stop_ends_a_servo_on_that_is_not_yet_answered() -> None:
    """After the alarm reset, the servos stay OFF until the next edge of SI(01).

    Rule: emergency-stop, answers.
    Source: manual chapter 5, 3.1
    """
    master = powered_up(servo_on_delay=2000)
    master.pulse("SI01")
    master.drop("SI00")
    master.pulse("SI16")
    assert not master.on("SO03")
    master.run(2000)
    assert not master.on("SO02")


@pytest.mark.parametrize(("knob", "alarm"), [(False, True), (True, False)])
def test_the_alarm_reset_needs_a_released_emergency_stop(knob: bool, alarm: bool) -> None:
    """Rule: reset-after-release."""
    master = servos_on(reset_in_emergency_stop=knob)
    master.turn_and_wait("SI00", False)
    master.pulse("SI16")
    assert master.on("SO03") is alarm


def test_a_key_decides_whether_servo_on_works_with_an_alarm() -> None:
    """Rule: servo-needs-reset."""
    master = servos_on(servo_on_with_alarm=True)
    master.drop("SI00")
    master.pulse("SI01")
    assert master.on("SO02")


def test_without_so04_the_servo_on_input_has_no_effect_whatever_the_knob() -> None:
    """Rule: servo-needs-reset, mp-ready-power, serious-alarm.

    Source: manual chapter 5, 2, SO(04): servo ON operation is enabled by the servo ON input signal
    """
    master = powered_up(servo_on_with_alarm=True)
    master.robot.inject("alarm")
    master.run(10)
    assert not master.on("SO04")
    master.pulse("SI01")
    assert not master.on("SO02")


def _turn_off(master: Master) -> None:
    master.drop("SI00")


def _lose_link(master: Master) -> None:
    master.connected = False
    master.run(50)
    master.connected = True
    master.run(50)


@pytest.mark.parametrize("stop", [_turn_off, _lose_link])
@pytest.mark.parametrize(("knob", "ready"), [(True, True), (False, False)])
def test_a_key_decides_mp_ready_in_an_emergency_stop(
    stop: Callable[[Master], None], knob: bool, ready: bool
) -> None:
    """In the literal reading of the manual, SO(04) is OFF while SO(03) is ON.

    A key selects this reading.

    Rule: mp-ready, link-loss-alarm.
    Source: manual chapter 5, 2, SO(03) and SO(04); 3.1, shift to emergency stop
    """
    master = Master(mp_ready_in_emergency_stop=knob)
    master.run(300)
    assert (master.on("SO03"), master.on("SO04")) == (False, ready)
    master.turn_and_wait("SI00", True)
    assert (master.on("SO03"), master.on("SO04")) == (False, True)
    stop(master)
    assert (master.on("SO00"), master.on("SO03"), master.on("SO04")) == (False, True, ready)
    master.pulse("SI16")
    assert (master.on("SO03"), master.on("SO04")) == (False, True)


def test_a_serious_error_turns_so03_on_and_so04_off() -> None:
    """The error also switches the servos off. An alarm reset clears it.

    Rule: serious-alarm, alarm-stops.
    Source: manual chapter 5, 2, SO(03) and SO(04)
    """
    master = servos_on()
    master.robot.inject("alarm", group=99, category=999)
    master.run(10)
    assert (master.on("SO02"), master.on("SO03"), master.on("SO04")) == (False, True, False)
    master.pulse("SI16")
    assert (master.on("SO02"), master.on("SO03"), master.on("SO04")) == (False, False, True)


def test_the_default_alarm_is_serious_and_an_alarm_reset_clears_it() -> None:
    """Rule: serious-alarm, alarm-reset."""
    master = powered_up()
    master.robot.inject("alarm")
    master.run(10)
    assert master.on("SO03")
    assert _numbers(master) == ["99.999"]
    master.pulse("SI16")
    assert not master.on("SO03")


def test_some_alarms_need_a_power_restart() -> None:
    """Rule: alarm-restart, alarm-reset. Source: manual chapter 5, 2, SI(16)."""
    master = powered_up(power_restart_alarms=("99.999",))
    master.robot.inject("alarm", group=99, category=999)
    master.pulse("SI16")
    assert _numbers(master) == ["99.999"]
    master.robot.inject("power_cycle")
    master.run(300)
    assert _numbers(master) == []


def test_a_warning_turns_so15_on() -> None:
    """Rule: warning. Source: manual chapter 5, 2, SO(15)."""
    master = powered_up()
    master.robot.inject("warning")
    master.run(5)
    assert master.on("SO15")
    assert not master.on("SO03")
    master.robot.inject("warning_clear")
    master.run(5)
    assert not master.on("SO15")


def test_delays_given_as_a_range_come_from_the_seed() -> None:
    """Rule: answers."""

    def answer_ms(seed: int) -> int:
        master = powered_up(seed=seed, servo_on_delay=(5, 400))
        master.turn("SI01", True)
        for count in range(100):
            master.run(5)
            if master.on("SO02"):
                return 5 * count
        raise AssertionError("the alarm ends the servo on before its answer")

    times = [answer_ms(seed) for seed in range(8)]
    assert times == [answer_ms(seed) for seed in range(8)]
    assert len(set(times)) > 3
    assert all(5 <= time <= 400 for time in times)
