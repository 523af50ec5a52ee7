"""Category 1: servo of an axis, motor power of the system (guide, 4.2.13 and 4.2.20)."""

from __future__ import annotations

from collections.abc import Sequence

from rcx_harness.robot.alarms import EMERGENCY_STOP
from rcx_harness.robot.arm import BRAKE, FREE, SERVO
from rcx_harness.robot.commands.base import (
    Call,
    CommandError,
    Execution,
    Lasting,
    Response,
    act,
    takes_time,
)
from rcx_harness.robot.machine import Machine

_OFF = 0x035
_WITH_SERVOS = 0x042


@takes_time(0x034)
def servo_on(machine: Machine, call: Call) -> Execution:
    """Servo ON of an axis, or of all axes of the robot (4.2.13)."""
    indices = call.indices or call.arm.indices
    _check_power(machine)
    if not machine.servos.motor_power and machine.config.servo_needs_motor_power:
        raise CommandError(machine.config.motor_power_alarm)
    return _SwitchOn(machine, indices)


@act(0x035, 0x036)
def release(machine: Machine, call: Call) -> Response:
    """Servo OFF with brakes, or free without (4.2.13); a movement of these axes ends."""
    indices = call.indices or call.arm.indices
    machine.halt_axes(indices, machine.config.servo_off_alarm)
    machine.servos.set(indices, BRAKE if call.code == _OFF else FREE)
    return {}


@act(0x041)
def motor_power_off(machine: Machine, call: Call) -> Response:
    """Motor power and all servos OFF, with all brakes (4.2.20)."""
    config = machine.config
    programs = config.motor_power_stops_program
    machine.switch_servos_off(config.servo_off_alarm, lock=True, stop_programs=programs)
    return {}


@takes_time(0x042, 0x043)
def motor_power_on(machine: Machine, call: Call) -> Execution:
    """Motor power ON, with all servos or alone (4.2.20)."""
    _check_power(machine)
    every = range(len(machine.config.axes))
    return _SwitchOn(machine, every if call.code == _WITH_SERVOS else ())


def _check_power(machine: Machine) -> None:
    """Refuse to switch on in emergency stop, at a serious alarm, or without main power."""
    if machine.emergency:
        raise CommandError(EMERGENCY_STOP)
    if not machine.may_switch_servo_on():
        serious = (alarm.number for alarm in machine.alarms.active if alarm.serious)
        raise CommandError(next(serious, machine.config.motor_power_alarm))


class _SwitchOn(Lasting):
    """Motor power and the servos of some axes come ON after `servo_on_delay`."""

    def __init__(self, machine: Machine, indices: Sequence[int]) -> None:
        self._indices = indices
        self._due_us = machine.now_us + machine.draw_us("servo_on_delay")

    def step(self, machine: Machine) -> Response | None:
        _check_power(machine)
        if machine.now_us < self._due_us:
            return None
        machine.servos.motor_power = True
        machine.servos.set(self._indices, SERVO)
        return {}
