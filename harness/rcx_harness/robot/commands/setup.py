"""Category 1 except movements: teaching, origins, servos, settings (guide, 4.2.8 to 4.2.22)."""

from __future__ import annotations

from collections.abc import Sequence

from rcx_harness.robot.alarms import EMERGENCY_STOP, CommandError
from rcx_harness.robot.arm import BRAKE, FREE, SERVO
from rcx_harness.robot.commands.base import Call, Execution, Response, act, takes_time
from rcx_harness.robot.commands.moves import Moving
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.motion import OriginRun
from rcx_harness.robot.paths import Pace, plan_ptp
from rcx_harness.robot.stored import ROBOTS, Point

_QUARTERS = 4  # number of absolute reset positions in a rotation of the motor
_OFF = 0x035
_WITH_SERVOS = 0x042
#: Maps each command to the setting that it changes, and to the field with the new value.
_SETTINGS = {
    0x027: ("inching_amount", "amount"),
    0x038: ("manual_speed", "speed"),
    0x039: ("auto_speed", "speed"),
    0x03A: ("program_speed", "speed"),
}


@act(*_SETTINGS)
def change_setting(machine: Machine, call: Call) -> None:
    """Change a speed or the inching amount of a robot (4.2.8, 4.2.14 to 4.2.16)."""
    setting, field = _SETTINGS[call.code]
    setattr(call.arm.settings, setting, call.values[field])


@act(0x03B)
def select_shift(machine: Machine, call: Call) -> None:
    """Select the shift of a robot (4.2.17)."""
    number = call.values["shift"]
    # This call raises the alarm of the shift reference if the shift is not defined.
    machine.memory.shift(number)
    call.arm.settings.shift = number


@act(0x03C)
def select_hand(machine: Machine, call: Call) -> None:
    """Select the hand of a robot (4.2.18)."""
    number = call.values["hand_number"]
    # This call raises the alarm of the hand reference if the hand is not defined.
    machine.memory.hand(call.arm.number, number)
    call.arm.settings.hand = number


@act(0x03D)
def select_arm(machine: Machine, call: Call) -> None:
    """Change the arm designation of a SCARA robot (4.2.19), for its next movements."""
    if not call.arm.scara:
        raise CommandError(machine.config.not_scara_alarm)
    call.arm.settings.arm = call.values["arm"]


@act(0x048)
def set_max_torque(machine: Machine, call: Call) -> None:
    """Change the max. torque command value of an axis (4.2.22), for its next movement."""
    (index,) = call.indices
    machine.settings.torque[index] = call.values["torque"]


@act(0x028)
def teach_point(machine: Machine, call: Call) -> None:
    """Store the current position as a point; axes that the robot does not have are 0.

    The point has no hand system and no arm rotation, as in the current position reference.
    """
    mm = bool(call.values["unit"])
    machine.points[call.values["point"]] = Point(call.arm.shown(mm=mm), mm=mm)


@takes_time(0x030)
def move_to_absolute_reset(machine: Machine, call: Call) -> Execution:
    """Move a mark method axis to the next position for an absolute reset (4.2.10)."""
    arm, place = call.arm, _mark_axis(call)
    machine.check_movable(arm, (place,))
    quarter = arm.axes[place].motor_rotation // _QUARTERS
    here = arm.here[place]
    down = bool(call.values["direction"])
    target = here // quarter * quarter if down else -(-here // quarter) * quarter
    path = plan_ptp(arm, {place: target}, Pace(share=arm.settings.manual_speed / 100))
    return Moving(call, machine.move(arm.number, path))


@act(0x031)
def absolute_reset(machine: Machine, call: Call) -> None:
    """Set the origin of a mark method axis to its current position (4.2.11)."""
    place = _mark_axis(call)
    if call.arm.here[place] % (call.arm.axes[place].motor_rotation // _QUARTERS):
        raise CommandError(machine.config.absolute_reset_alarm)
    index = call.arm.indices[place]
    machine.positions[index] = 0
    machine.origins.complete[index] = True


@takes_time(0x032)
def return_robot_to_origin(machine: Machine, call: Call) -> Execution:
    """Return all axes, or the axes that a flag selects, to their origins (4.2.12).

    Robot 0 means all robots.
    """
    config, values = machine.config, call.values
    wanted = (call.designated,) if call.designated else range(1, ROBOTS + 1)
    indices = [index for robot in wanted for index in config.axes_of(robot)]
    if values["incremental_flag"]:
        chosen: Sequence[int] = config.axes_of_type(indices, "incremental")
    elif values["absolute_flag"]:
        chosen = config.axes_of_type(indices, "absolute")
    elif values["incomplete_flag"]:
        chosen = [index for index in indices if not machine.origins.complete[index]]
    else:
        chosen = indices
    return _return_to_origin(machine, call, chosen)


@takes_time(0x033)
def return_axis_to_origin(machine: Machine, call: Call) -> Execution:
    """Return one axis to its origin (4.2.12)."""
    return _return_to_origin(machine, call, call.indices)


@takes_time(0x034)
def servo_on(machine: Machine, call: Call) -> Execution:
    """Switch ON the servo of an axis, or of all axes of the robot (4.2.13)."""
    indices = call.indices or call.arm.indices
    _check_power(machine)
    if not machine.servos.motor_power and machine.config.servo_needs_motor_power:
        raise CommandError(machine.config.motor_power_alarm)
    return _SwitchOn(machine, indices)


@act(0x035, 0x036)
def release(machine: Machine, call: Call) -> None:
    """Switch servos OFF, with brakes applied or free (4.2.13); movements of these axes end."""
    indices = call.indices or call.arm.indices
    machine.halt_axes(indices, machine.config.servo_off_alarm)
    machine.servos.set(indices, BRAKE if call.code == _OFF else FREE)


@act(0x041)
def motor_power_off(machine: Machine, call: Call) -> None:
    """Switch motor power and all servos OFF, and apply all brakes (4.2.20)."""
    config = machine.config
    programs = config.motor_power_stops_program
    machine.switch_servos_off(config.servo_off_alarm, lock=True, stop_programs=programs)


@takes_time(0x042, 0x043)
def motor_power_on(machine: Machine, call: Call) -> Execution:
    """Switch motor power ON, with or without all servos (4.2.20)."""
    _check_power(machine)
    every = range(len(machine.config.axes))
    return _SwitchOn(machine, every if call.code == _WITH_SERVOS else ())


def _return_to_origin(machine: Machine, call: Call, chosen: Sequence[int]) -> Execution:
    """Start a return-to-origin: first absolute axes, then other axes, but no mark method axes."""
    config = machine.config
    for robot in range(1, ROBOTS + 1):
        arm = machine.arm(robot)
        places = [place for place, index in enumerate(arm.indices) if index in chosen]
        if places:
            machine.check_movable(arm, places, by_program=call.by_program)
    if machine.origin_running:
        raise CommandError(config.moving_alarm)
    marked = [index for index in chosen if config.axes[index].origin_method == "mark"]
    if not all(machine.origins.complete[index] for index in marked):
        raise CommandError(config.origin_method_alarm)
    moving = [index for index in chosen if index not in marked]
    absolute = tuple(index for index in moving if config.axes[index].type == "absolute")
    others = tuple(index for index in moving if index not in absolute)
    return _Returning(machine, [group for group in (absolute, others) if group])


class _Returning(Execution):
    """A running return-to-origin command; it ends when all groups of axes have arrived."""

    def __init__(self, machine: Machine, groups: list[tuple[int, ...]]) -> None:
        run = machine.return_to_origin(groups, by_command=True) if groups else None
        self._run: OriginRun | None = run

    def step(self, machine: Machine) -> Response | None:
        if self._run and self._run.stopped_by:
            raise CommandError(self._run.stopped_by)
        return {} if self._run is None or self._run.done else None


def _mark_axis(call: Call) -> int:
    (place,) = call.places
    if call.arm.axes[place].origin_method != "mark":
        raise CommandError(call.arm.config.origin_method_alarm)
    return place


def _check_power(machine: Machine) -> None:
    """Raise CommandError if an emergency stop, a serious alarm or no main power blocks servo ON."""
    if machine.emergency:
        raise CommandError(EMERGENCY_STOP)
    if not machine.may_switch_servo_on():
        serious = (alarm.number for alarm in machine.alarms.active if alarm.serious)
        raise CommandError(next(serious, machine.config.motor_power_alarm))


class _SwitchOn(Execution):
    """A running command that switches motor power and servos ON after `servo_on_delay`."""

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
