"""Coverage of the robot's own programs: the lines and branches that run in a cell.

If coverage is requested (`counting`), each controller of a new cell gets an observer that counts.
The observer changes no state, so a run with coverage has the same trace.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from rcx_harness.robot import Controller
from rcx_harness.robot.config import RobotProgram
from rcx_harness.robot.program.expressions import evaluate, number_of
from rcx_harness.robot.program.syntax import NEXT, Instruction, Program
from rcx_harness.robot.program.task import RobotTask
from structured_text.engines.builtin.collector import CountedText, TextBranch, collecting

__all__ = ["Plan", "count_programs", "plan_of"]

#: Kinds of instructions after which a task never continues with the next instruction.
_LEAVES = (
    *("goto", "jump", "leave", "return_", "exit_sub", "exit_task", "halt", "halt_all", "end"),
    *("resume", "resume_next", "resume_at"),
)
_REASON = re.compile(r"'\s*unreachable:\s*(.*?)\s*$", re.IGNORECASE)


class Plan(NamedTuple):
    """The counters of a program: one for each instruction, then the counters of branches.

    Attributes:
        size: Number of counters.
        branches: The branches of the program, with line numbers of the file.
        ways: Maps the position of an instruction with branches to the indices of two counters. The
            first counter counts how often the condition holds, the second how often it does not
            hold. -1: the counter of the first instruction in the branch is used instead.
    """

    size: int
    branches: tuple[TextBranch, ...]
    ways: dict[int, tuple[int, int]]


def count_programs(controllers: Sequence[Controller]) -> None:
    """If coverage is requested, count the instructions of these controllers from now on."""
    collector = collecting()
    if collector is None:
        return
    for robot in controllers:
        counted: dict[str, tuple[Plan, CountedText]] = {}
        for task in robot.program.tasks:
            program = task.program
            if program.path:
                plan = plan_of(task.code, program.offset)
                text = collector.text(program.path, program.name, lambda: _text(task, plan))  # noqa: B023
                if text is not None:
                    counted[program.name] = plan, text
        if counted:
            robot.program.observers.append(_Counter(robot, counted))


def _text(task: RobotTask, plan: Plan) -> dict[str, Any]:
    """Return the lines of a program, as fields of CountedText."""
    program: RobotProgram = task.program
    lines = dict(enumerate(task.code.texts, program.offset + 1))
    begins = task.code.begins.items()
    return {
        "line": program.offset + 1,
        "lines": lines,
        "reasons": _reasons(lines),
        "statements": [(line + program.offset, at) for at, line in begins],
        "branches": plan.branches,
        "counters": [0] * plan.size,
    }


def _reasons(lines: dict[int, str]) -> dict[int, str]:
    """Return the reasons in comments `' unreachable: reason`, by the line that a comment explains.

    A comment in a line of its own explains the next line that is not a comment.
    """
    found: dict[int, str] = {}
    for number, text in lines.items():
        if comment := _REASON.search(text):
            at = number
            while at in lines and not lines[at].partition("'")[0].strip():
                at += 1
            found[at] = comment[1]
    return found


class _Counter:
    """An observer that counts the instructions of one controller."""

    def __init__(self, robot: Controller, counted: dict[str, tuple[Plan, CountedText]]) -> None:
        self._robot, self._counted = robot, counted
        self._before: dict[int, int] = {}  # maps a task to its last instruction

    def begins(self, task: RobotTask, at: int) -> None:
        """Count the execution of an instruction."""
        if found := self._counted.get(task.program.name):
            found[1].counters[at] += 1

    def ends(self, task: RobotTask, at: int, to: int) -> None:
        """Count the branch that a task has taken at the end of an instruction."""
        found, one = self._counted.get(task.program.name), task.code.code[at]
        before, self._before[task.number] = self._before.get(task.number, -1), at
        if found is None or at not in found[0].ways or to not in (NEXT, one.jump):
            return  # an error in the condition: no branch was taken
        holds, fails = found[0].ways[at]
        held = self._holds(task, one, to)
        counter = holds if held else fails
        if one.kind == "for_test" and not held and before > at:
            return  # the loop has already run, so its end is not a branch
        if counter >= 0:
            found[1].counters[counter] += 1

    def _holds(self, task: RobotTask, one: Instruction, to: int) -> bool:
        """Return whether the condition of an instruction that has just ended holds.

        After a time-out a WAIT also continues with the next instruction. Its condition is therefore
        evaluated once more; the inputs have not changed in the meantime.
        """
        if one.kind != "wait":
            return to == NEXT
        value = evaluate(one.args[0], self._robot.program, task)
        return number_of(value, self._robot.config) != 0


# --- branches -----------------------------------------------------------------------------------


def plan_of(program: Program, offset: int = 0) -> Plan:
    """Plan the counters of a program that begins in line `offset` + 1 of its file.

    Branches are: the conditions of IF, ELSEIF and WHILE; each CASE of a SELECT; whether a FOR with
    variable limits runs at least once; whether a WAIT with a time limit ends in time.
    """
    alone = _reached_alone(program)
    size, branches, ways = len(program.code), list[TextBranch](), dict[int, tuple[int, int]]()
    forks: dict[int, int] = {}
    for at, one in enumerate(program.code):
        shown = list(_ways(program, at, one))
        if not shown:
            continue
        fork = forks.get(at, len(set(forks.values())))
        forks[at] = fork
        if _case_follows(program, one):
            forks[one.jump] = fork
        counters = [-1, -1]
        for place, target, text in shown:
            own = target not in alone or one.kind in ("wait", "for_test")
            counter = size if own else target
            line = one.line if own else program.code[target].line
            if own:
                counters[place], size = size, size + 1
            begin = program.code[_begin_of(one, at)].line + offset
            branches.append(TextBranch(line + offset, begin, counter, fork, text))
        ways[at] = counters[0], counters[1]
    return Plan(size, tuple(branches), ways)


def _ways(program: Program, at: int, one: Instruction) -> Iterator[tuple[int, int, str]]:
    """Yield each branch of an instruction: 0 (condition true) or 1 (false), target and text."""
    text = program.texts[one.line - 1].partition("'")[0].strip() if program.texts else one.kind
    if one.kind == "unless":
        yield 0, at + 1, f"{text}: true"
        yield 1, one.jump, f"{text}: false"
    elif one.kind == "case":
        yield 0, at + 1, text
        if not _case_follows(program, one):
            before = program.code[one.jump - 1]
            otherwise = before.kind == "leave" and before.line > one.line
            yield 1, one.jump, "CASE ELSE" if otherwise else "SELECT without a CASE that fits"
    elif one.kind == "for_test" and not _constant(program.code[at - 3 : at]):
        yield 0, at + 1, f"{text}: a round"
        yield 1, one.jump, f"{text}: no round"
    elif one.kind == "wait" and one.args[1] is not None:
        yield 0, at + 1, f"{text}: in time"
        yield 1, at + 1, f"{text}: time-out"


def _constant(assignments: Sequence[Instruction]) -> bool:
    """Return whether first value, limit and step of a FOR are constants, so that it always runs."""
    values = (one.args[1] for one in assignments)
    signless = (one.args[0] if one.kind == "negative" else one for one in values)
    return all(one.kind == "number" for one in signless)


def _begin_of(one: Instruction, at: int) -> int:
    """Return the position of the branching statement; for a CASE, the position of its SELECT."""
    return int(one.args[0].args[0].partition("@")[2]) if one.kind == "case" else at


def _case_follows(program: Program, one: Instruction) -> bool:
    """Return whether the instruction is a CASE and another CASE of the same SELECT follows."""
    if one.kind != "case" or one.jump >= len(program.code):
        return False
    other = program.code[one.jump]
    return other.kind == "case" and other.args[0] == one.args[0]


def _reached_alone(program: Program) -> set[int]:
    """Return the positions that exactly one other instruction can reach."""
    count = [0] * (len(program.code) + 1)
    count[0] += 1
    for at, one in enumerate(program.code):
        if one.kind not in _LEAVES:
            count[at + 1] += 1
        if one.jump >= 0:
            count[one.jump] += 1
    for at in (*program.labels.values(), *(sub.at for sub in program.subs.values())):
        count[at] += 2
    return {at for at, number in enumerate(count[:-1]) if number == 1}
