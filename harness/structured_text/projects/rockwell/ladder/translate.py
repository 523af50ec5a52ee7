"""The translation of a ladder routine to Structured Text.

Each rung becomes the statements of its output instructions, in the order in which the controller
executes them: from left to right, and the legs of a branch from top to bottom.
"""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap

from structured_text.errors import InputError, near
from structured_text.language.source import Line
from structured_text.projects.model import Lines, in_comment
from structured_text.projects.rockwell.ladder.add_on import add_on_entry
from structured_text.projects.rockwell.ladder.call import Body, Call
from structured_text.projects.rockwell.ladder.jumps import arranged
from structured_text.projects.rockwell.ladder.model import (
    Instruction,
    LadderError,
    Rung,
    Series,
    instructions,
)
from structured_text.projects.rockwell.ladder.power import TRUE, Flow, Power
from structured_text.projects.rockwell.ladder.program_flow import END_OF_ROUTINE
from structured_text.projects.rockwell.ladder.table import TABLE

__all__ = ["translated_rungs"]

_INDENT = "  "
#: Longest line of a rung's comment.
_WIDTH = 80


def translated_rungs(rungs: Sequence[Rung], body: Body) -> Lines:
    """Return the statements of a routine, or raise LadderError that names the rung."""
    for number, rung in enumerate(rungs):
        for place, instruction in enumerate(instructions(rung.series)):
            if instruction.name == "LBL":
                _know_label(instruction, place, number, rung, body)
    body.labels[END_OF_ROUTINE] = len(rungs)
    parts = [_lines(rung, number, body) for number, rung in enumerate(rungs)]
    return arranged(parts, body)


def _know_label(instruction: Instruction, place: int, number: int, rung: Rung, body: Body) -> None:
    label = instruction.operands[0].upper() if instruction.operands else ""
    if place:
        text = f"{rung.title}: LBL is not the first instruction"
        raise LadderError(text, instruction.at, "move it to the left end of a rung")
    if label in body.labels:
        text = f"{rung.title}: there are two labels {instruction.operands[0]}"
        raise LadderError(text, instruction.at, "give each label a name of its own")
    body.labels[label] = number


def _lines(rung: Rung, number: int, body: Body) -> Lines:
    body.rung = number
    flow = Flow(body.zone or TRUE)
    try:
        _through(rung.series, flow.start, flow, body)
    except LadderError as error:
        raise LadderError(f"{rung.title}: {error.message}", error.at, error.hint) from None
    except InputError as error:
        text = f"{rung.title}: {error.message}"
        raise LadderError(text, error.line or rung.at, error.hint) from None
    texts = (*_comment(rung), *flow.lines(lambda place: body.variable(f"Power_{place}")))
    return tuple(Line(f"{_INDENT}{text}", rung.at, network=rung.title) for text in texts)


def _comment(rung: Rung) -> list[str]:
    """Return the lines of a comment with the number of a rung and its comment."""
    title = rung.title.capitalize()
    said = in_comment(rung.comment).splitlines()
    wrapped = [text for line in said for text in wrap(line, _WIDTH)]
    if not wrapped:
        return [f"(* {title} *)"]
    first, *others = wrapped
    lines = [f"(* {title}: {first}", *(f"   {text}" for text in others)]
    return [*lines[:-1], f"{lines[-1]} *)"]


def _through(series: Series, power: Power, flow: Flow, body: Body) -> Power:
    """Translate a series, and return the power behind it."""
    for node in series:
        if isinstance(node, Instruction):
            power = _instruction(node, power, flow, body)
        else:
            legs = [_through(leg, power, flow, body) for leg in node.legs]
            power = flow.joined(power, legs)
    return power


def _instruction(instruction: Instruction, power: Power, flow: Flow, body: Body) -> Power:
    entry = TABLE.get(instruction.name)
    types = body.routine.types
    if instruction.name in types.protected:
        text = f"the source of {instruction.name} is protected and not in the file"
        hint = "write it in Structured Text, and call that"
        raise LadderError(text, instruction.at, hint)
    if entry is None and instruction.name in types.instructions:
        entry = add_on_entry(instruction.name)
    if entry is None:
        text = f"the instruction {instruction.name} is not supported"
        raise LadderError(text, instruction.at, near(instruction.name, TABLE, "similar:"))
    call = Call(body, instruction, entry, flow, power)
    before = flow.count
    entry.run(call)
    body.traces.setdefault(body.rung, []).append(flow.trace(power, call.power, before))
    return call.power
