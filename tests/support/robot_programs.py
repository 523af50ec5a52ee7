"""A robot with a program in the robot language, and a master that starts the program."""

from __future__ import annotations

from typing import Any

from rcx_harness.robot import Point, RobotProgram
from robot_master import Master

__all__ = ["POINTS", "calculated", "running", "started"]

#: Two axes with 1000 pulses/mm that move 100 mm and 50 mm. Point 3 is in pulses.
POINTS = {
    1: Point((100_000, 50_000, 0, 0, 0, 0), mm=True),
    2: Point((20_000, 0, 0, 0, 0, 0), mm=True),
    3: Point((5_000, 6_000, 0, 0, 0, 0)),
}


def started(text: str, *others: RobotProgram, **config: Any) -> Master:
    """Return a master with its servos on, right after the start of the program `text`."""
    programs = (RobotProgram("MAIN", text=text), *others)
    given: dict[str, Any] = {"points": POINTS, "program_start_delay": 5.0, **config}
    master = Master(programs=programs, **given)
    master.servo_on()
    master.turn("SI12", True)
    master.run(120)
    master.turn("SI12", False)
    return master


def running(text: str, ms: float = 100, **config: Any) -> Master:
    """Return a master after the program has run for some time."""
    master = started(text, **config)
    master.run(ms)
    return master


def calculated(expression: str, *before: str, **config: Any) -> float:
    """Return the value of an expression, through the static variable SGR0."""
    text = "\n".join([*before, f"SGR0={expression}", "SO(20)=1"])
    master = running(text, **config)
    assert master.so[34] & 1, f"{expression} was not evaluated"
    value = master.robot.machine.memory.variables.value(256)
    return float(value)
