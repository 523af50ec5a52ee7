"""Category 1: absolute reset and return-to-origin (guide, 4.2.10 to 4.2.12)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rcx_harness.robot.commands.base import (
    Call,
    CommandError,
    Execution,
    Lasting,
    Response,
    act,
    takes_time,
)
from rcx_harness.robot.commands.moves import Moving
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.origin import OriginRun
from rcx_harness.robot.planning import Pace, plan_ptp
from rcx_harness.robot.stored import ROBOTS

__all__ = ["axes_of_type"]

_QUARTERS = 4  # absolute reset positions per rotation of the motor


def axes_of_type(config: RobotConfig, indices: Iterable[int], kind: str) -> tuple[int, ...]:
    """Those of the axes that are of a type as the commands know it.

    Args:
        config: The robot.
        indices: Into its axes.
        kind: `absolute` or `incremental`.
    """
    kinds = {kind}
    if kind == "incremental" and config.semi_absolute_is_incremental:
        kinds.add("semi_absolute")
    return tuple(index for index in indices if config.axes[index].type in kinds)


@takes_time(0x030)
def move_to_absolute_reset(machine: Machine, call: Call) -> Execution:
    """Move a mark method axis to the nearest position that way where it can be reset (4.2.10)."""
    arm, place = call.arm, _mark_axis(call)
    machine.check_movable(arm, (place,))
    quarter = arm.axes[place].motor_rotation // _QUARTERS
    here = arm.here[place]
    down = bool(call.values["direction"])
    target = here // quarter * quarter if down else -(-here // quarter) * quarter
    path = plan_ptp(arm, {place: target}, Pace(share=arm.settings.manual_speed / 100))
    return Moving(call, machine.move(arm.number, path))


@act(0x031)
def absolute_reset(machine: Machine, call: Call) -> Response:
    """Where a mark method axis is becomes its origin (4.2.11)."""
    place = _mark_axis(call)
    if call.arm.here[place] % (call.arm.axes[place].motor_rotation // _QUARTERS):
        raise CommandError(machine.config.absolute_reset_alarm)
    index = call.arm.indices[place]
    machine.positions[index] = 0
    machine.origins.complete[index] = True
    return {}


@takes_time(0x032)
def return_robot_to_origin(machine: Machine, call: Call) -> Execution:
    """Return-to-origin of all axes, or of those that a flag chooses; robot 0 is all (4.2.12)."""
    config, values = machine.config, call.values
    wanted = (call.designated,) if call.designated else range(1, ROBOTS + 1)
    indices = [index for robot in wanted for index in config.axes_of(robot)]
    if values["incremental_flag"]:
        chosen: Sequence[int] = axes_of_type(config, indices, "incremental")
    elif values["absolute_flag"]:
        chosen = axes_of_type(config, indices, "absolute")
    elif values["incomplete_flag"]:
        chosen = [index for index in indices if not machine.origins.complete[index]]
    else:
        chosen = indices
    return _return_to_origin(machine, chosen)


@takes_time(0x033)
def return_axis_to_origin(machine: Machine, call: Call) -> Execution:
    """Return-to-origin of one axis (4.2.12)."""
    return _return_to_origin(machine, call.indices)


def _return_to_origin(machine: Machine, chosen: Sequence[int]) -> Execution:
    """Absolute axes first, as SI(17) does; mark method axes do not take part."""
    config = machine.config
    for robot in range(1, ROBOTS + 1):
        arm = machine.arm(robot)
        places = [place for place, index in enumerate(arm.indices) if index in chosen]
        if places:
            machine.check_movable(arm, places)
    if machine.origin_running:
        raise CommandError(config.busy_alarm)
    marked = [index for index in chosen if config.axes[index].origin_method == "mark"]
    if not all(machine.origins.complete[index] for index in marked):
        raise CommandError(config.origin_method_alarm)
    moving = [index for index in chosen if index not in marked]
    absolute = tuple(index for index in moving if config.axes[index].type == "absolute")
    others = tuple(index for index in moving if index not in absolute)
    return _Returning(machine, [group for group in (absolute, others) if group])


class _Returning(Lasting):
    """A return-to-origin, until all its groups of axes have arrived."""

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
