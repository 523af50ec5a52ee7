"""Remote commands and alarms in plain language, as lines of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rcx_harness import spec
from rcx_harness.spec.wire import ABNORMAL_END, NORMAL_END, RUN
from structured_text.output.units import format_word

__all__ = ["alarm_name", "alarm_text", "request_text", "response_text"]

_LONGEST = 160


def request_text(words: Sequence[int]) -> str:
    """Return a request as text: `MovePtp (16#R001) robot 1: MOVE, PTP, ...; axes 3, point 19`."""
    command = spec.commands().get(words[0] & 0x0FFF)
    if command is None or not command.code:
        return f"{format_word(words[0])}: no command of the manual"
    robot = f" robot {words[0] >> 12}" if command.robot and words[0] >> 12 else ""
    fields = _fields(command.request, command.decode(words))
    return _cut(f"{command.name} ({command.iec}){robot}: {command.title}{_after(fields)}")


def response_text(request: int, words: Sequence[int]) -> str:
    """Return the end or the state of a command as text.

    `request` is the code of the command, with or without the robot's digit.
    """
    status = words[0]
    if status == ABNORMAL_END:
        return f"abnormal end, alarm {alarm_text(f'{words[1]}.{words[2]}')}"
    command = spec.commands().get(request & 0x0FFF)
    known = {RUN: "running", NORMAL_END: "normal end"}
    state = known.get(status, f"status {format_word(status)}")
    if command is None or status not in known:
        return state
    return _cut(state + _after(_fields(command.response, command.read_response(words))))


def alarm_text(number: str) -> str:
    """Return an alarm as `12.600 Emergency stop on`; only the number if its name is unknown."""
    return f"{number} {alarm_name(number)}".rstrip()


def alarm_name(number: str) -> str:
    """Return the name of an alarm in the manual, else in a public list.

    The result is empty if it is in neither.
    """
    alarm = spec.alarms().get(number)
    return alarm.name if alarm else spec.public_alarms().get(number, "")


def _fields(fields: Sequence[spec.Field], values: Mapping[str, spec.FieldValue]) -> list[str]:
    """Return the fields with information: not fixed, not 0 and not an empty text."""
    shown = []
    for part in fields:
        value = values[part.name]
        some = any(value) if isinstance(value, tuple) else bool(value)
        if part.fixed is None and some:
            shown.append(f"{part.name} {_value(part, value, part.unit_among(values))}")
    return shown


def _value(part: spec.Field, value: spec.FieldValue, unit: str) -> str:
    if isinstance(value, int) and value in part.values:
        return f"{value} ({part.values[value]})"
    if isinstance(value, str):
        return repr(value)
    if isinstance(value, tuple):
        text = ", ".join(f"{one:g}" if isinstance(one, float) else str(one) for one in value)
    else:
        text = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{text} {unit}".rstrip()


def _after(fields: Sequence[str]) -> str:
    return f"; {', '.join(fields)}" if fields else ""


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else text[: _LONGEST - 4] + " ..."
