"""One robot program as a task: its state, its progress and its variables."""

from __future__ import annotations

import copy
from typing import Any

from rcx_harness.robot.config import RobotProgram
from rcx_harness.robot.program.code import program_code
from rcx_harness.robot.program.execution import Frame
from rcx_harness.robot.program.movements import Statement
from rcx_harness.robot.program.syntax import Program
from rcx_harness.robot.program.values import Value

__all__ = ["MAIN_PRIORITY", "NEXT_LINE", "RUN", "STEP", "RobotTask"]

#: The modes of a start: run all lines, run one line, or run one line with the subroutines that it
#: calls.
RUN, STEP, NEXT_LINE = "run", "step", "next"

#: The default priority of a task: the main program, and programs that START starts.
MAIN_PRIORITY = 32


class RobotTask:
    """One program as a task.

    `elapsed_us` is the time for which the task has run; stops do not count. `state` is `ready`
    (reset, or not yet started), `running`, `stopped`, `suspended` or `ended`.

    Attributes:
        number: Number of the task in the table of tasks; 0 while the program is not registered.
        priority: 1 (first in each cycle) to 64.
        temporary: Whether START has registered the task. Such a task leaves the table at its end or
            reset.
        variables: The variables of the program by name; elements of arrays as `A%(3)`.
        begun: Position of the instruction that has begun and has not ended yet; -1 if there is
            none.
        full_cycles: Number of cycles in which the task has used up its statements, for example in
            an endless loop.
        full_line: The line of the task at the end of the last cycle that `full_cycles` counts.
    """

    def __init__(self, program: RobotProgram, variables: dict[str, Value], plain: str) -> None:
        self.program = program
        self.code: Program = program_code(program, plain)
        self.state = "ready"
        self.number = 0
        self.priority = MAIN_PRIORITY
        self.temporary = False
        self.full_cycles, self.full_line = 0, 0
        self.variables = variables if self.code.shared else {}
        self.rewind()
        self.since_us = 0

    def rewind(self) -> None:
        """Go back to the first instruction, and delete the program's own variables."""
        self.at = 0
        self.begun = -1
        self.elapsed_us = 0
        self.until_us: int | None = None
        """The end of the current wait, on the time scale of `elapsed_us`; None without a time
        limit."""
        self.waits = False
        """Whether only an input from the master can end the wait of the task."""
        self.frames: list[Frame] = []
        self.handler = -1
        self.error: tuple[str, int] | None = None
        self.error_at = -1
        self.execution: Statement | None = None
        self.passed: set[int] = set()
        self.moving_at = -1
        """The position of the movement statement that has begun and has not ended; -1: none."""
        self.interrupted = False
        self.mode = RUN
        self.depth = 0
        if not self.code.shared:
            self.variables.clear()

    @property
    def integers(self) -> bool:
        """Return whether variables without a type character are integers."""
        return self.code.integers

    @property
    def line(self) -> int:
        """Return the number of the current line, from 1."""
        return self.code.line(self.at)

    @property
    def stack(self) -> list[tuple[str, int]]:
        """Return the subroutines that have not returned and the current line of each.

        The innermost subroutine is first, the program itself is last. The name of a GOSUB is its
        label with the asterisk.
        """
        names = [self.program.name, *(self._called(frame) for frame in self.frames)]
        lines = [*(self.code.line(frame.back - 1) for frame in self.frames), self.line]
        return list(zip(names, lines, strict=True))[::-1]

    def _called(self, frame: Frame) -> str:
        """Return the name of the subroutine that a frame belongs to."""
        call = self.code.code[frame.back - 1]
        return str(call.args[0]) if call.kind in ("call", "gosub") else "GOSUB"

    @property
    def endless(self) -> bool:
        """Return whether the program is an endless duration, which executes no instruction."""
        return self.program.begins_again and not self.program.has_code and self.mode == RUN

    def variable(self, name: str) -> Value | None:
        """Return the value of a variable; None if the variable has no value yet."""
        variables, key = self._place(name, len(self.frames) - 1)
        return variables.get(key)

    def assign_variable(self, name: str, value: Value) -> None:
        """Assign a value to a variable; the value already has the type of the variable."""
        variables, key = self._place(name, len(self.frames) - 1)
        variables[key] = value

    def _place(self, name: str, depth: int) -> tuple[dict[str, Value], str]:
        """Return the dictionary of a variable for a call depth, and the variable's key in it."""
        base = name.partition("(")[0].removeprefix("DIM@")
        while depth >= 0:
            frame = self.frames[depth]
            if frame.variables is None:  # a GOSUB has no variables of its own
                depth -= 1
            elif base in frame.references:
                depth, other = frame.references[base]
                name, base = name.replace(base, other, 1), other
            elif base in frame.shared:
                break
            else:
                return frame.variables, name
        return self.variables, name

    def passed_us(self, now_us: int) -> int:
        """Return the time for which the task has run [us]; stops do not count."""
        return self.elapsed_us + now_us - self.since_us

    def go(self, now_us: int, mode: str = RUN) -> None:
        """Start the task, or continue it after a stop, in the mode RUN, STEP or NEXT_LINE."""
        self.state = "running"
        self.since_us = now_us
        self.mode = mode
        self.depth = len(self.frames)
        self.interrupted = True

    def pause(self, now_us: int, state: str = "stopped") -> None:
        """Stop or suspend the task. The time until the task continues does not count."""
        if self.state == "running":
            self.state = state
            self.elapsed_us += now_us - self.since_us

    def end(self) -> None:
        """End the task. The next start begins at the first instruction."""
        if self.state in ("running", "stopped", "suspended"):
            self.state = "ended"
            self.rewind()
        self._leave()

    def reset(self) -> None:
        """Reset the task to its first instruction, with the state `ready`."""
        self.rewind()
        self.state = "ready"
        self._leave()

    def skip(self) -> None:
        """Skip the current line without executing it."""
        self.until_us, self.waits, self.execution, self.moving_at = None, False, None, -1
        self.begun = -1
        self.state = "stopped"
        self.at = self.code.behind(self.line)
        self.come_round()

    def come_round(self) -> None:
        """If the task has passed its last line, go back to the first line or end the task."""
        if self.at < len(self.code.code):
            return
        self.rewind()
        if not self.program.begins_again:
            self.end()

    def has_done(self, at: int) -> bool:
        """Return whether the task was started for one line only and has finished it.

        Args:
            at: Position of the instruction that the task has just executed.
        """
        if self.mode == RUN or (at < self.at < len(self.code.code)
                                and self.line == self.code.line(at)):  # fmt: skip
            return False
        return self.mode == STEP or len(self.frames) <= self.depth

    def due_us(self, now_us: int) -> int | None:
        """Return when the task continues by itself [us]; None if it waits for input or start."""
        if self.state != "running" or self.endless:
            return None
        if self.until_us is None:
            return None if self.waits else now_us
        due_us = self.since_us + self.until_us - self.elapsed_us
        kind = self.code.code[self.at].kind if self.at < len(self.code.code) else ""
        return due_us if self.waits or kind in ("delay", "duration") else now_us

    def _leave(self) -> None:
        if self.temporary:
            self.number, self.temporary = 0, False

    def __deepcopy__(self, memo: dict[int, Any]) -> RobotTask:
        """Return a copy that shares the program, because programs never change."""
        copied = RobotTask.__new__(RobotTask)
        memo[id(self)] = copied
        copied.__dict__.update(self.__dict__)
        for name in ("variables", "frames", "execution", "passed"):
            setattr(copied, name, copy.deepcopy(getattr(self, name), memo))
        return copied
