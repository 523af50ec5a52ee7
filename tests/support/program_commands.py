"""Telegrams of category 5, which handle programs and tasks, and the controller's answers."""

from __future__ import annotations

from typing import Any

from rcx_harness.robot import RobotProgram
from robot_master import Master

REGISTER, EXECUTE, STEP, SKIP, NEXT, RESET, INFO = 0x401, 0x402, 0x403, 0x404, 0x405, 0x406, 0x408
STATES, LINES = 0x507, 0x508
ALL, NUMBER, TASK, NAME = 0, 1, 2, 4
NO_TASK = 9

#: Two programs. Each waits for its own input, SI(20) or SI(21), and shows its progress at SO3().
FIRST = RobotProgram("FIRST", steps=("SO(30)=1", "WAIT SI(20)=1", "SO(31)=1"), loop=False)
SECOND = RobotProgram("SECOND", steps=("SO(32)=1", "WAIT SI(21)=1", "SO(33)=1"), loop=False)


def program_master(*programs: RobotProgram, **config: Any) -> Master:
    """Return a master with SI(00) and SI(06) ON. By default its programs are FIRST and SECOND."""
    master = Master(programs=programs or (FIRST, SECOND), **config)
    master.power_up()
    return master


def registered_master(task: int = 3, **config: Any) -> Master:
    """Return a master with FIRST in task 1 and SECOND in this task."""
    master = program_master(**config)
    master.execute(*telegram(REGISTER, NUMBER, program=2, task=task, priority=32))
    return master


def text_words(text: str) -> tuple[int, ...]:
    """Return 16 characters in n+12 to n+26, filled with spaces."""
    raw = text.encode().ljust(16)
    return tuple(raw[k] | raw[k + 1] << 8 for k in range(0, 16, 2))


def telegram(
    code: int, method: int, *, program: int = 0, task: int = 0, priority: int = 0, name: str = ""
) -> tuple[int, ...]:
    """Return the words of a command of category 5."""
    words = (code, method, program, task, priority, 0)
    return (*words, *text_words(name)) if name else words


def states(master: Master) -> list[int]:
    """Return the states of tasks 1 to 8."""
    return list(master.execute(STATES)[2:10])


def lines(master: Master) -> list[int]:
    """Return the current program lines of tasks 1 to 8."""
    return list(master.execute(LINES)[2:10])


def info(master: Master, program: int) -> tuple[int, int, int, int]:
    """Return program, task, line and priority from the program execution information."""
    answer = master.execute(*telegram(INFO, NUMBER, program=program))
    assert answer[0] == 0x0200
    return answer[2], answer[3], answer[4], answer[5]
