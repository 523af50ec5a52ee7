"""What all commands that move have in common: may it, which axes, how fast, and the answer."""

from __future__ import annotations

from collections.abc import Iterable

from rcx_harness.robot.alarms import EMERGENCY_STOP, STOP
from rcx_harness.robot.commands.base import Call, CommandError, Response
from rcx_harness.robot.commands.planning import Pace, frame_of, here, line_speed
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.motion import Movement
from rcx_harness.robot.stored import AXES

__all__ = [
    "Moving",
    "Pace",
    "check_movable",
    "chosen_places",
    "pace",
    "position_output",
    "positions_of",
]

_DIRECT = 1  # speed in 0.01 % of the maximum speed
_PERCENT = 2
_MM_PER_S = 3


def positions_of(machine: Machine, robot: int, *, mm: bool) -> tuple[int, ...]:
    """Current position of a robot for the response: six axes in pulses or 0.001 mm.

    Axes that the robot does not have are 0, as in the guide's examples.
    """
    pulses = here(machine, robot)
    values = frame_of(machine, robot).to_mm(pulses) if mm else pulses
    fitting = [max(-(2**31), min(2**31 - 1, round(value))) for value in values]
    return tuple(fitting + [0] * (AXES - len(fitting)))


def position_output(machine: Machine, call: Call) -> Response:
    """The position in the unit that was asked for; nothing where the command has no such flags."""
    if "position_mm" not in call.values:
        return {}
    mm = bool(call.values["position_mm"])
    asked = mm or call.values["position_pulses"]
    if not asked and machine.config.unasked_positions_zero:
        return {}
    return {"positions": positions_of(machine, call.robot, mm=mm)}


def check_movable(machine: Machine, robot: int, places: Iterable[int] | None = None) -> None:
    """Refuse a movement in emergency stop, in stop, with servos off, or beside another one.

    Args:
        machine: The controller.
        robot: The robot that is to move.
        places: Its axes that are to move, 0 to 5; None: all.

    Raises:
        CommandError: with the alarm that says why.
    """
    config = machine.config
    every = config.axes_of(robot)
    indices = every if places is None else tuple(every[place] for place in places)
    if machine.emergency:
        raise CommandError(EMERGENCY_STOP)
    if machine.stopped:
        raise CommandError(STOP)
    if not machine.servos_on(indices):
        raise CommandError(config.servo_off_alarm)
    for alarm in machine.alarms.active:
        if alarm.serious:
            raise CommandError(alarm.number)
    program = machine.program.running and not config.motion_during_program
    if program or machine.motion.moving(robot) or machine.origins.moves(every):
        raise CommandError(config.busy_alarm)


def chosen_places(machine: Machine, call: Call) -> tuple[int, ...]:
    """The axes that a command names with `axis_designation` and `axes`, else all of the robot.

    Raises:
        CommandError: the robot does not have one of them.
    """
    count = len(machine.config.axes_of(call.robot))
    if not call.values.get("axis_designation", "axes" in call.values):
        return tuple(range(count))
    chosen = call.values["axes"]
    if chosen >> count:
        raise CommandError(machine.config.no_axis_alarm)
    return tuple(place for place in range(count) if chosen >> place & 1)


def pace(machine: Machine, call: Call) -> Pace:
    """Speed, acceleration and deceleration that a command gives, or those that count without.

    Raises:
        CommandError: more mm/s than such a robot may be told.
    """
    values, settings = call.values, machine.settings.of(call.robot)
    mode, speed = values.get("speed_mode", 0), values.get("speed", 0)
    up = values["acceleration"] / 100 if values.get("acceleration_flag") else None
    down = values["deceleration"] / 100 if values.get("deceleration_flag") else None
    if mode == _MM_PER_S:
        if speed > line_speed(machine, call.robot):
            raise CommandError(machine.config.format_alarm)
        return Pace(up=up, down=down, mm_per_s=speed)
    if mode == _DIRECT:
        return Pace(speed / 10000, up, down)
    percent = speed if mode == _PERCENT else settings.program_speed
    return Pace(settings.auto_speed / 100 * percent / 100, up, down)


class Moving:
    """A command that is done when its movement is."""

    stoppable = False

    def __init__(self, call: Call, movement: Movement) -> None:
        """`movement` is under way."""
        self.call = call
        self.movement = movement

    def step(self, machine: Machine) -> Response | None:
        """The position at the end, if it was asked for.

        Raises:
            CommandError: the movement was stopped.
        """
        if self.movement.stopped_by:
            raise CommandError(self.movement.stopped_by)
        return position_output(machine, self.call) if self.movement.done else None

    def interim(self, machine: Machine) -> Response:
        """Nothing is shown before the end."""
        return {}
