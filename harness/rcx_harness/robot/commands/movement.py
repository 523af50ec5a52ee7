"""Category 1: movements (guide, 4.2)."""

from __future__ import annotations

from rcx_harness.robot.alarms import EMERGENCY_STOP, SOFT_LIMIT, STOP
from rcx_harness.robot.commands.base import Call, CommandError, Response, last
from rcx_harness.robot.config import AXES, Point
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.motion import AxisMove

__all__ = ["MovePtp", "positions_of"]

_DIRECT = 1  # speed in 0.01 % of the maximum speed
_PERCENT = 2


def positions_of(machine: Machine, robot: int, *, mm: bool) -> tuple[int, ...]:
    """Current position of a robot for the response: six axes in pulses or 0.001 mm.

    Axes that the robot does not have are 0, as in the guide's examples.
    """
    values = [0] * AXES
    for k, index in enumerate(machine.config.axes_of(robot)):
        pulses = machine.positions[index]
        per_mm = machine.config.axes[index].pulses_per_mm
        value = round(pulses * 1000 / per_mm) if mm else pulses
        values[k] = max(-(2**31), min(2**31 - 1, value))
    return tuple(values)


def check_movable(machine: Machine) -> None:
    """Refuse a movement in emergency stop, in stop, with the servos off, or beside another one."""
    if machine.emergency:
        raise CommandError(EMERGENCY_STOP)
    if machine.stopped:
        raise CommandError(STOP)
    if not machine.servo_on:
        raise CommandError(machine.config.servo_off_alarm)
    program = machine.program.running and not machine.config.motion_during_program
    if machine.origin_running or program:
        raise CommandError(machine.config.busy_alarm)


@last(0x001)
class MovePtp:
    """MOVE with PTP to a point (4.2.1); ends when the position is reached."""

    stoppable = False

    def __init__(self, machine: Machine, call: Call) -> None:
        self._call = call
        check_movable(machine)
        point = machine.points.get(call.values["point"])
        if point is None:
            raise CommandError(machine.config.undefined_point_alarm)
        self._movement = machine.move(_moves(machine, call, point))

    def step(self, machine: Machine) -> Response | None:
        """The position at the end, if it was asked for."""
        if self._movement.stopped_by:
            raise CommandError(self._movement.stopped_by)
        if not self._movement.done:
            return None
        values = self._call.values
        asked = values["position_pulses"] or values["position_mm"]
        if not asked and machine.config.unasked_positions_zero:
            return {}
        mm = bool(values["position_mm"])
        return {"positions": positions_of(machine, self._call.robot, mm=mm)}

    def interim(self, machine: Machine) -> Response:
        """Nothing is shown before the end."""
        return {}


def _moves(machine: Machine, call: Call, point: Point) -> list[AxisMove]:
    """The ways of all axes that take part, within the soft limits."""
    config, values = machine.config, call.values
    every = config.axes_of(call.robot)
    chosen = values["axes"] if values["axis_designation"] else (1 << len(every)) - 1
    if chosen >> len(every):
        raise CommandError(config.no_axis_alarm)
    share = _speed_share(machine, call)
    up = values["acceleration"] if values["acceleration_flag"] else 100
    down = values["deceleration"] if values["deceleration_flag"] else 100
    moves = []
    for k, index in enumerate(every):
        if not chosen >> k & 1:
            continue
        axis = config.axes[index]
        scale = axis.pulses_per_mm / 1000 if point.mm else 1
        target = round(point.data[k] * scale)
        if not axis.soft_low <= target <= axis.soft_high:
            raise CommandError(SOFT_LIMIT)
        moves.append(
            AxisMove(
                axis=index,
                start=machine.positions[index],
                target=target,
                speed=axis.max_speed * share,
                acceleration=axis.max_acceleration * up / 100,
                deceleration=axis.max_acceleration * down / 100,
            )
        )
    return moves


def _speed_share(machine: Machine, call: Call) -> float:
    """Speed as a part of the maximum speed."""
    mode, speed = call.values["speed_mode"], call.values["speed"]
    if mode == _DIRECT:
        return float(speed / 10000)
    percent = speed if mode == _PERCENT else machine.config.program_speed
    return float(machine.config.auto_speed / 100 * percent / 100)
