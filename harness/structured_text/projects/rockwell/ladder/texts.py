"""Instructions for texts. Source: Rockwell 1756-RM003, ASCII string and conversion instructions."""

from __future__ import annotations

from structured_text.language.source import Line
from structured_text.projects.rockwell.body import translated
from structured_text.projects.rockwell.ladder.call import Call, Entry

__all__ = ["TEXTS", "as_structured_text"]

_INDENT = 2


def as_structured_text(call: Call) -> None:
    """Translate an instruction that is written alike in Structured Text."""
    operands = [call.raw(number) for number in range(len(call.instruction.operands))]
    for number in range(len(operands)):
        call.operand(number)  # to refuse a missing operand by its name
    line = Line(f"{call.entry.name}({', '.join(operands)});", call.instruction.at)
    lines = translated([line], call.body.routine)
    call.when(*(line.text[_INDENT:] for line in lines))


def _dtos(call: Call) -> None:
    """Write the digits of a number; of a negative one with its sign."""
    value = call.number(0)
    text = call.operand(0).converted(value, "LINT" if value[1] == "LINT" else "DINT")
    kind = "LINT" if value[1] == "LINT" else "DINT"
    call.when(call.assigned(1, (f"{kind}_TO_STRING({text})", "STRING")))


def _rtos(call: Call) -> None:
    value = call.number(0)
    text = call.operand(0).converted(value, "REAL")
    call.when(call.assigned(1, (f"REAL_TO_STRING({text})", "STRING")))


_SEARCH = ("Source", "Search", "Start", "Result")
_PART = ("Source", "Quantity", "Start", "Destination")

TEXTS = (
    Entry(
        "CONCAT",
        ("Source A", "Source B", "Destination"),
        as_structured_text,
        "1756-RM003, CONCAT",
    ),
    Entry("DELETE", _PART, as_structured_text, "1756-RM003, DELETE"),
    Entry("FIND", _SEARCH, as_structured_text, "1756-RM003, FIND"),
    Entry(
        "INSERT",
        ("Source A", "Source B", "Start", "Destination"),
        as_structured_text,
        "1756-RM003, INSERT",
    ),
    Entry("MID", _PART, as_structured_text, "1756-RM003, MID"),
    Entry("DTOS", ("Source", "Destination"), _dtos, "1756-RM003, DTOS"),
    Entry("RTOS", ("Source", "Destination"), _rtos, "1756-RM003, RTOS; its digits are assumed"),
)
