"""The translation of a robot file's programs to code. A program is a text, steps or a duration."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Protocol

from rcx_harness.robot.program.reader import read_lines, read_program
from rcx_harness.robot.program.syntax import Instruction, Program
from structured_text.errors import InputError

__all__ = ["in_program", "program_code"]


class Given(Protocol):
    """The properties of a robot file's program that this module uses; see RobotProgram."""

    @property
    def duration(self) -> float:
        """Return the duration of a program without steps or text [ms]."""

    @property
    def steps(self) -> tuple[str, ...]:
        """Return the steps of the program; empty for a text or a duration."""

    @property
    def file(self) -> str:
        """Return the path of the file that contains the program's text."""

    @property
    def text(self) -> str:
        """Return the text of the program."""

    @property
    def name(self) -> str:
        """Return the name of the program."""


def program_code(program: Given, plain: str) -> Program:
    """Translate a program of a robot file to code.

    Args:
        program: The program.
        plain: Type of variables without a type character, `integer` or `real`. In steps these
            variables are always integers.

    Raises:
        InputError: a line cannot be read.
    """
    try:
        if program.text:
            return _text(program.text, plain == "integer")
        if program.steps:
            return _steps(program.steps)
    except InputError as error:
        raise in_program(program, error) from None
    duration = Instruction("duration", (round(program.duration * 1000),), 1)
    return Program((duration,), texts=("",), shared=True)


def in_program(program: Given, error: InputError) -> InputError:
    """Return the error with its location: the file or program with the line, or the step number."""
    if program.text and program.file:
        return InputError(error.message, file=Path(program.file), line=error.line, hint=error.hint)
    if program.text:
        where = f"program {program.name}, line {error.line}"
        return InputError(f"{where}: {error.message}", hint=error.hint)
    step = f"step {error.line} of 'steps'" if error.line else "'steps'"
    return InputError(f"{step}: {error.message}", hint=error.hint)


@cache
def _text(text: str, integers: bool) -> Program:
    program, errors = read_program(text, integers=integers)
    if program is None:
        raise errors[0]
    return program


@cache
def _steps(steps: tuple[str, ...]) -> Program:
    """Translate steps to code. HALT ends all tasks, and all programs share integer variables."""
    lines = ["HALTALL" if step.strip().upper() == "HALT" else step for step in steps]
    program, errors = read_lines(lines, integers=True, shared=True)
    if program is None:
        raise errors[0]
    return program
