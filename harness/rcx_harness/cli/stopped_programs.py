"""The errors that have stopped robot programs in a run, as `rcx run` shows them."""

from __future__ import annotations

from collections.abc import Iterator

from rcx_harness.cell import Cell
from rcx_harness.spec.tables import public_alarms
from structured_text.output.units import format_us

__all__ = ["busy_programs", "program_errors", "stopped_program_count"]

_MOST = 5
#: Number of full controller cycles after which a program is reported. A long calculation may fill
#: fewer cycles.
_FULL_CYCLES = 20


def stopped_program_count(cell: Cell) -> int:
    """Return how often an error has stopped a robot program.

    A stop input, an emergency stop or an alarm of the controller is not an error of a program: a
    stimulus can have caused it on purpose.
    """
    return sum(len(robot.program.errors) for robot in cell.robots)


def busy_programs(cell: Cell) -> Iterator[str]:
    """Yield a line for each robot program that ran in a loop without a wait."""
    several = len(cell.robots) > 1
    for number, robot in enumerate(cell.robots, 1):
        which = f"controller {number}: " if several else ""
        for task in robot.program.tasks:
            if task.full_cycles >= _FULL_CYCLES:
                yield (
                    f"{which}robot program {task.program.name}: the loop at line {task.full_line} "
                    f"takes no time: {task.full_cycles} cycles ended at the limit of "
                    f"{robot.config.program_statements} statements; add a WAIT or a DELAY"
                )


def program_errors(cell: Cell) -> Iterator[str]:
    """Yield a line for each of the first errors, with time, program, line and alarm."""
    several = len(cell.robots) > 1
    for number, robot in enumerate(cell.robots, 1):
        config = robot.config
        ours = {
            config.program_type_alarm: "a value has a wrong type",
            config.program_stack_alarm: "too many nested GOSUB or CALL",
            config.program_path_alarm: "PATH: no path is defined, or the robot is not at its start",
        }
        which = f"controller {number}: " if several else ""
        for error in robot.program.errors[:_MOST]:
            name = ours.get(error.number) or public_alarms().get(error.number, "")
            yield (
                f"{which}robot program {error.program} stopped at {format_us(error.t_us)} in line "
                f"{error.line}: alarm {error.number}{f' ({name})' if name else ''}"
            )
        if (rest := len(robot.program.errors) - _MOST) > 0:
            yield f"{which}... and {rest} further errors of robot programs"
