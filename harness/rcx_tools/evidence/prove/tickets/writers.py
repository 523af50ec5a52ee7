"""Checks of the syntax tree: the POUs that write the variables of turns, and the inputs of jobs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.property import Goal
from structured_text.language import tree as t
from structured_text.language.syntax import Position
from structured_text.language.types import BlockType, StructType
from structured_text.language.walk import statements

__all__ = ["goals"]

_ROBOT = "ROBOT.INNER."
#: Maps each field of RCX_REF that the turns depend on to the POUs that write it.
OWNERS = {
    "COMMAND": {"FB_RCXHANDSHAKE"},
    "SEQUENCE": {"FB_RCXDEDICATEDINPUTS"},
    "SCAN": {"FB_RCXTAKEHEAD"},
    "ELAPSED": {"FB_RCXTAKEHEAD"},
    "ANSWER": {"FB_RCXTAKEHEAD"},
    "INSCAN": {"FB_RCXTAKEHEAD", "FB_WRITEAREA", "FB_WRITEAREAWORDS"},
    "PHASE": {"FB_RCXHANDSHAKE"},
    "RUNNING": {"FB_RCXHANDSHAKE"},
}
#: The text of each input in a call of a job on a channel of a robot. None: the call does not assign
#: the pin, so the pin keeps its initial value.
_PINS: dict[str, dict[str, str | None]] = {
    "COMMAND": {
        "SCAN": "ROBOT.INNER.SCAN",
        "INSCAN": "ROBOT.INNER.INSCAN",
        "ELAPSED": "ROBOT.INNER.ELAPSED",
        "ANSWER": "ROBOT.INNER.ANSWER",
        "REMOTE": "1",
        "APPLIED": "(ROBOT.INNER.PHASE = 3)",
    },
    "SEQUENCE": {
        "SCAN": "ROBOT.INNER.SCAN",
        "INSCAN": "ROBOT.INNER.INSCAN",
        "ELAPSED": "ROBOT.INNER.ELAPSED",
        "REMOTE": None,
    },
}
#: Blocks to which a channel of a robot may be passed.
_TAKERS = {"FB_RCXJOB", "FB_RCXCHANNELTURN"}


def _text(node: Any) -> str:
    """Return the text of an expression in upper case.

    Only the expressions in the checks are supported.
    """
    if isinstance(node, t.Use):
        return node.symbol.name.upper()
    if isinstance(node, t.Member):
        return f"{_text(node.base)}.{node.name.upper()}"
    if isinstance(node, t.Index):
        return f"{_text(node.base)}[]"
    if isinstance(node, t.Constant):
        return str(int(node.value)) if isinstance(node.value, (bool, int)) else str(node.value)
    if isinstance(node, t.Binary):
        return f"({_text(node.left)} {node.op} {_text(node.right)})"
    return type(node).__name__


def _prefixes(variable: t.Variable) -> Iterator[t.Variable]:
    """Yield the path of a variable and of all variables that contain it."""
    yield variable
    if isinstance(variable, (t.Member, t.Index)):
        yield from _prefixes(variable.base)


def _root(variable: t.Variable) -> t.Symbol:
    while isinstance(variable, (t.Member, t.Index)):
        variable = variable.base
    assert isinstance(variable, t.Use)
    return variable.symbol


def _named(variable: t.Variable, name: str) -> bool:
    kind = variable.type
    return isinstance(kind, (StructType, BlockType)) and kind.name.upper() == name


def _written(pou: t.Pou) -> Iterator[tuple[t.Variable, Position]]:
    for statement in statements(pou.body):
        if isinstance(statement, t.Assign):
            yield statement.target, statement.at
        elif isinstance(statement, t.For):
            yield statement.counter, statement.at
        elif isinstance(statement, t.CallBlock):
            for _, target in statement.outputs:
                yield target, statement.at


def _bad_writes(name: str, pou: t.Pou) -> Iterator[str]:
    """Yield each statement of a POU that writes a variable of another POU."""
    inputs = {"LONGEST", "EXECUTE", "HOLDER", "TROUBLE"}
    for target, at in _written(pou):
        text = _text(target)
        for field, owners in OWNERS.items():
            inside = f"{text}.".startswith(f"{_ROBOT}{field}.")
            whole = f"{_ROBOT}{field}.".startswith(f"{text}.") and text != f"{_ROBOT}{field}"
            if (inside or whole) and name not in owners:
                yield f"{pou.name} line {at.line} writes {text}"
        if name != "FB_RCXJOB" and text.startswith("CHANNEL."):
            yield f"{pou.name} line {at.line} writes {text}"
        for part in _prefixes(target):
            of_job = isinstance(part, t.Member) and _named(part.base, "FB_RCXJOB")
            if of_job and _text(part).rpartition(".")[2] not in inputs:
                yield f"{pou.name} line {at.line} writes {text}"


def _bad_calls(pou: t.Pou) -> Iterator[str]:
    """Yield each wrong argument in the calls of jobs in a POU."""
    for statement in statements(pou.body):
        if not isinstance(statement, t.CallBlock):
            continue
        where = f"{pou.name} line {statement.at.line}"
        callee = statement.block.name.upper()
        for pin, variable in statement.in_outs:
            text = _text(variable)
            if _named(variable, "RCX_REF") and (pin.upper(), text) != ("ROBOT", "ROBOT"):
                yield f"{where} hands over {text} as {pin}"
            if not _named(variable, "RCX_CHANNEL"):
                continue
            if callee not in _TAKERS:
                yield f"{where} hands {text} to {statement.block.name}"
            if callee == "FB_RCXJOB" and _root(variable).section != "VAR":
                yield from _bad_pins(where, text, statement)
        if callee == "FB_RCXJOB" and _root(statement.instance).section != "VAR":
            yield f"{where} calls a job that is not its own"


def _bad_pins(where: str, channel: str, call: t.CallBlock) -> Iterator[str]:
    given = {pin.upper(): _text(value) for pin, value in call.inputs}
    wanted = _PINS.get(channel.removeprefix(_ROBOT))
    if wanted is None:
        yield f"{where} takes a ticket on {channel}"
        return
    for pin, value in wanted.items():
        if given.get(pin) != value:
            yield f"{where} gives {pin} := {given.get(pin)}, not {value}"


def goals(library: Library, part: str) -> Iterator[Goal]:
    """Yield two goals: one about the writers of variables, one about the arguments of jobs."""
    writes: list[str] = []
    calls: list[str] = []
    for name, pou in library.project.pous.items():
        writes += _bad_writes(name, pou)
        calls += _bad_calls(pou)
    for told, found in (
        ("channel, number of the scan, phase and work of a job have one writer each", writes),
        ("each job receives its channel, scan and answer unchanged", calls),
    ):
        yield Goal(told, (), not found, dict.fromkeys(found, 1))
