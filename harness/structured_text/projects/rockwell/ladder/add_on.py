"""Calls of Add-On Instructions in ladder.

Source: Rockwell 1756-PM010, scan modes. With power, the instruction executes its logic. Without
power, it executes its routine EnableInFalse; without this routine it only passes the values of its
inputs, and its outputs stay. Power passes if EnableOut is TRUE, which begins with the value of
EnableIn.
"""

from __future__ import annotations

import re

from structured_text.projects.rockwell.data import Data
from structured_text.projects.rockwell.expression_reader import bare, plain_tag
from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.power import TRUE, negated
from structured_text.projects.rockwell.uses import MODULE

__all__ = ["add_on_entry"]

_NAME = re.compile(r"[^\W\d]\w*(?:\.[^\W\d]\w*)*")


def add_on_entry(name: str) -> Entry:
    """Return the row for an Add-On Instruction."""
    return Entry(name, ("instance",), _call, "1756-PM010", optional=-1)


def _call(call: Call) -> None:
    name = call.entry.name
    types = call.body.routine.types
    block = types.instructions[name]
    instance, data = call.tag(0, written=False)
    if data.type.upper() != name or data.sizes:
        raise call.error(f"{call.raw(0)} is not a {name}")
    given = len(call.instruction.operands) - 1
    if given != len(block.parameters):
        listed = ", ".join(pin for pin, _ in block.parameters) or "none"
        raise call.error(
            f"{name} has {given} operands behind its instance, not {len(block.parameters)}: "
            f"{listed}",
            "complete the instruction in its tool",
        )
    inputs, others, behind = [], [], []
    for number, (pin, usage) in enumerate(block.parameters, 1):
        kind = types.members[name][pin.upper()]
        if usage == "Input":
            reader = call.operand(number)
            inputs.append((pin, bare(reader.converted(reader.value(), kind.type))))
        elif usage == "InOut":
            module = f"{call.raw(number)}:{MODULE}"
            if kind.type.upper() == MODULE and module.upper() in call.body.routine.tags:
                others.append(f"{pin} := {plain_tag(module)}")
                continue
            text, given_data = call.tag(number)
            _check_same(call, number, kind, given_data)
            others.append(f"{pin} := {text}")
        elif call.raw(number) not in ("", "?"):
            text, given_data = call.tag(number)
            if text.upper() == f"{instance}.{pin}".upper():
                continue  # the output of the instance itself is already there
            if given_data == kind and _NAME.fullmatch(text):
                others.append(f"{pin} => {text}")
            else:
                value = call.operand(0).read(f"{instance}.{pin}", kind)
                behind.append(call.assigned(number, value))
    passed = [f"{pin} := {text}" for pin, text in inputs]
    if block.false_routine:
        always = ", ".join([*passed, *others])

        def statements(power: str) -> list[str]:
            arguments = f"EnableIn := {power}{', ' if always else ''}{always}"
            return [f"{instance}({arguments});", *behind]

        call.always(statements)
    else:
        call.when(f"{instance}({', '.join([*passed, *others])});", *behind)
        _pass_inputs(call, instance, inputs)
    if block.enable_out:
        call.condition(f"{instance}.EnableOut")


def _pass_inputs(call: Call, instance: str, inputs: list[tuple[str, str]]) -> None:
    """Pass the inputs that a program reads from the instance without power, too."""
    seen = call.body.routine.types.read_members
    lines = [f"{instance}.{pin} := {text};" for pin, text in inputs if pin.upper() in seen]
    if lines and call.power.constant != TRUE:
        call.always(
            lambda power: [
                f"IF {negated(power)} THEN",
                *(f"  {line}" for line in lines),
                "END_IF;",
            ]
        )


def _check_same(call: Call, number: int, kind: Data, given: Data) -> None:
    if (given.type.upper(), given.sizes) != (kind.type.upper(), kind.sizes) or given.stored:
        sizes = "".join(f"[{size}]" for size in kind.sizes)
        raise call.error(
            f"{call.raw(number)} is not a {kind.type}{sizes}, as the in-out parameter of "
            f"{call.entry.name} is",
            "use a tag of the same type",
        )
