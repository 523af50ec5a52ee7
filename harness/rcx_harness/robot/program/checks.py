"""The checks of a robot program before it runs: ports, tasks, options, and loops without a wait."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rcx_harness.robot.program.syntax import MOVES, OPTIONS, Instruction, Node, Program
from rcx_harness.robot.program.types import type_errors
from structured_text.errors import InputError

__all__ = ["endless_loops", "problems"]

#: The kinds of instructions that take time, so that the controller cycle ends.
_TAKES_TIME = ("delay", "duration", "wait", "wait_arm", "servo", "motor", "origin", "hold",
               "hold_all", "halt", "halt_all", "exit_task", *MOVES)  # fmt: skip
_BRANCHES = ("unless", "case", "for_test", "goto", "jump", "leave")
_TASKS = range(1, 17)
_OF_PATHS = ("S", "SPEED", "DSPEED", "VEL", "ACC", "DEC")


def problems(program: Program, size: int, programs: Collection[str] = ()) -> list[InputError]:
    """Return the errors that can be found without running the program, in the order of the lines.

    Args:
        program: The program.
        size: Number of bytes of the areas, 48 or 256.
        programs: Names of all programs of the controller; empty if they are unknown.
    """
    found = []
    for one in program.code:
        for error in (
            *_ports(one, size), *_tasks(one, programs), *_options(one), *_switches(one)
        ):  # fmt: skip
            found.append(InputError(error.message, line=one.line, hint=error.hint))
    for line, error in type_errors(program):
        found.append(InputError(error.message, line=line, hint=error.hint))
    return sorted(found, key=lambda error: error.line or 0)


def endless_loops(program: Program) -> list[int]:
    """Return the first line of each endless loop that has no instruction that takes time.

    Such a loop uses up the statements of every controller cycle.
    """
    found = []
    for at, one in enumerate(program.code):
        back = one.kind in ("goto", "jump") and 0 <= one.jump <= at
        if not back:
            continue
        body = program.code[one.jump : at + 1]
        leaves = any(
            part.kind in _TAKES_TIME
            or part.kind in ("end", "return_", "exit_sub", "call", "gosub", "on_goto", "on_gosub")
            or (part.kind in _BRANCHES and not one.jump <= part.jump <= at)
            for part in body
        )
        if not leaves:
            found.append(program.code[one.jump].line)
    return found


def _ports(one: Instruction, size: int) -> Iterator[InputError]:
    for node in _all_nodes(one):
        if node.kind == "port":
            for place in node.args:
                try:
                    place.check(size)
                except InputError as error:
                    yield error
    if one.kind not in ("assign", "set_", "reset", "out"):
        return
    target = one.args[-2] if one.kind == "assign" else one.args[0]
    if target.kind == "port" and not all(place.output for place in target.args):
        hint = "set SO, DO, MO, LO or TO"
        yield InputError(f"{target.args[0].name} is an input of the robot", hint=hint)


def _tasks(one: Instruction, programs: Collection[str]) -> Iterator[InputError]:
    if one.kind not in ("start_task", "suspend", "restart", "cut"):
        return
    named = one.args[0]
    if named.kind == "program_name" and programs and named.args[0] not in programs:
        hint = f"use {', '.join(sorted(programs))}"
        yield InputError(f"there is no program {named.args[0]}", hint=hint)
    if named.kind == "program_number" and programs and not 1 <= named.args[0] <= len(programs):
        hint = f"write START 1 to START {len(programs)}"
        yield InputError(f"there is no program {named.args[0]}", hint=hint)
    texts = [part for part in one.args if isinstance(part, str)]
    texts += [part for part in named.args if named.kind == "task_number"]
    for text in texts:
        if int(text[1:]) not in _TASKS:
            yield InputError(f"there is no task {text}", hint="use T1 to T16")


def _options(one: Instruction) -> Iterator[InputError]:
    if one.kind not in (*MOVES, "path"):
        return
    targeted = one.kind in ("move", "movei", "movet", "path")
    options = one.args[3] if targeted else one.args[2:]
    for option in options:
        if one.kind == "path" and (option.kind != "option" or option.args[0] not in _OF_PATHS):
            hint = f"use {', '.join(_OF_PATHS)} in a path"
            yield InputError("this option cannot be used in a path", hint=hint)
            continue
        if option.kind == "option" and option.args[0] not in OPTIONS:
            hint = f"use {', '.join(OPTIONS)}, STOPON or CONT"
            yield InputError(f"{option.args[0]} is not an option of a movement", hint=hint)
        elif option.kind in ("point", "data"):
            yield InputError("a target follows an option", hint="write the targets first")
        elif option.kind == "axis_target" and one.kind not in ("drive", "drivei"):
            hint = "use DRIVE or DRIVEI for several axes"
            yield InputError(f"{one.kind.upper()} has one axis", hint=hint)
        elif option.kind == "output_at" and (one.kind != "move" or one.args[1] == "P"):
            yield InputError("an output on the way needs a line or an arc", hint="use MOVE L or C")


def _switches(one: Instruction) -> Iterator[InputError]:
    """Check the words after SERVO and MOTOR, because the grammar permits all words for both."""
    if one.kind == "servo" and one.args[1] == "PWR":
        yield InputError("SERVO PWR does not exist", hint="write MOTOR PWR")
    if one.kind == "motor" and one.args[0] == "FREE":
        yield InputError("MOTOR FREE does not exist", hint="write SERVO FREE")


def _all_nodes(one: Instruction) -> Iterator[Node]:
    """Yield all nodes of an instruction, also those in its lists of targets and options."""
    yield from one.nodes()
    for part in one.args:
        if isinstance(part, tuple):
            for node in part:
                if isinstance(node, Node):
                    yield from node.walk()
