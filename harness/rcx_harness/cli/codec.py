"""Telegrams in words and in plain language (`rcx encode`, `rcx decode`)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated

import typer

from rcx_harness import spec
from rcx_harness.spec.plain import alarm_name
from rcx_harness.spec.telegram import intervals
from rcx_harness.spec.wire import ABNORMAL_END, STATUS_NAMES
from structured_text.errors import InputError
from structured_text.output.units import format_word

__all__ = ["decode", "encode"]

_WORDS = 16


def _names() -> list[tuple[str, str]]:
    """Return the names of all commands with their titles, for completion in a shell."""
    return [(command.name, command.title) for command in spec.commands().values()]


def encode(
    name: Annotated[
        str, typer.Argument(help="Command, e.g. MovePtp or 16#0001.", autocompletion=_names)
    ],
    fields: Annotated[list[str] | None, typer.Argument(help="Fields, e.g. point=19.")] = None,
    robot: Annotated[
        int | None, typer.Option(help="Robot number R, 0 to 4. Default: from the code, or 0.")
    ] = None,
) -> None:
    """Print the telegram of a remote command, in words and in plain language."""
    command = spec.command(name)
    types = {part.name: part.type for part in command.request}
    values: dict[str, spec.FieldValue] = {}
    for field in fields or ():
        key, equals, text = field.partition("=")
        if not equals:
            raise InputError(f"{field!r} is not a field", hint="write name=value")
        if key in values:
            raise InputError(f"{key} is given twice", hint="leave one of them out")
        values[key] = text if types.get(key) == "text" else _numbers(key, text)
    try:
        words = command.encode(values, _designated(name, robot))
        _check_effect(command, values)
    except InputError as error:
        raise InputError(error.message, file=f"guide {command.section}", hint=error.hint) from None
    _print_words("n", words)
    _print_request(command, words)


def _designated(name: str, robot: int | None) -> int:
    """Return the designated robot, from the option or from the upper digit of the code."""
    try:
        of_code = spec.whole_number(name) >> 12
    except ValueError:  # `name` is the name of a command, or a code with R such as 16#R001
        return robot or 0
    if robot is not None and of_code not in (0, robot):
        hint = "leave one of them out"
        raise InputError(f"{name} is for robot {of_code}, but --robot is {robot}", hint=hint)
    return of_code if robot is None else robot


def _check_effect(command: spec.Command, values: Mapping[str, spec.FieldValue]) -> None:
    """Raise InputError for a value that has no effect, because another field disables it."""
    fixed = {part.name: part.fixed or 0 for part in command.request}
    for part in command.request:
        value, selected = values.get(part.name), values.get(part.by, fixed.get(part.by, 0))
        if not part.by or not value or selected in part.ranges:
            continue
        text = f"{command.iec} {command.name}: {part.name} has no effect while {part.by} is"
        ways = []
        for key, limits in part.ranges.items():
            spans = " or ".join(f"{low} to {high}" for low, high in intervals(limits))
            ways.append(f"{part.by}={key}" + (f" ({spans})" if part.type != "text" else ""))
        raise InputError(f"{text} {selected}", hint=f"set {' or '.join(ways)}")


def decode(
    words: Annotated[list[str], typer.Argument(help="Words from n on, e.g. 16#0001 16#0004.")],
    response: Annotated[
        str,
        typer.Option(
            help="The words are the response to this command (from m on).", autocompletion=_names
        ),
    ] = "",
) -> None:
    """Explain the words of a telegram."""
    parts = [text for part in words for text in part.replace(",", " ").split()]
    values = [_word(text) for text in parts]
    if not 1 <= len(values) <= _WORDS:
        raise InputError(f"{len(values)} words are given", hint=f"give 1 to {_WORDS}")
    values += [0] * (_WORDS - len(values))
    command = spec.command(response or parts[0])
    _print_words("m" if response else "n", values)
    if response:
        _print_response(command, values)
    else:
        _print_request(command, values)


def _print_request(command: spec.Command, words: Sequence[int]) -> None:
    robot = words[0] >> 12
    print(f"{command.name} ({command.iec}), {command.title}; guide {command.section}")
    if command.robot:
        print(f"  robot {robot}" + (" (not designated: robot 1)" if not robot else ""))
    _print_fields(command.request, command.decode(words))
    problem = command.problem(words)
    if not problem and robot > (4 if command.robot else 0):
        problem = f"robot {robot} cannot be designated"
    if problem:
        print(f"  not allowed: {problem}")


def _print_response(command: spec.Command, words: Sequence[int]) -> None:
    status = words[0]
    print(f"answer to {command.name} ({command.iec}), {command.title}; guide {command.section}")
    print(f"  status {format_word(status)}: {STATUS_NAMES.get(status, 'no status of the manual')}")
    if status == ABNORMAL_END:
        number = f"{words[1]}.{words[2]}"
        name = alarm_name(number)
        print(f"  alarm {number}" + (f": {name}" if name else ""))
    elif status:
        _print_fields(command.response, command.read_response(words))


def _print_fields(fields: Sequence[spec.Field], values: Mapping[str, spec.FieldValue]) -> None:
    for part in fields:
        value = values[part.name]
        shown = ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)
        unit = f" {part.unit_among(values)}".rstrip()
        meaning = part.values.get(value) if isinstance(value, int) else None
        note = meaning or part.meaning
        print(f"  {part.name} = {shown}{unit}" + (f"  ({note})" if note else ""))


def _print_words(address: str, words: Sequence[int]) -> None:
    used = max((k for k in range(_WORDS) if words[k]), default=0)
    for k in range(used + 1):
        place = address if not k else f"{address}+{2 * k}"
        print(f"{place:<5} {format_word(words[k])}")
    if used < _WORDS - 1:
        print(f"then to {address}+{2 * (_WORDS - 1)} {format_word(0)}")


def _word(text: str) -> int:
    try:
        value = spec.whole_number(text)
    except ValueError:
        value = -1
    if not 0 <= value <= 0xFFFF:
        raise InputError(f"{text!r} is not a word", hint="write 0 to 65535 or 16#0000 to 16#FFFF")
    return value


def _numbers(key: str, text: str) -> spec.FieldValue:
    try:
        parts = [spec.whole_number(part) for part in text.split(",")]
    except ValueError:
        try:
            reals = tuple(float(part) for part in text.split(","))
            if not text.isascii() or not all(map(math.isfinite, reals)):
                raise ValueError
        except ValueError:
            raise InputError(f"{key} = {text!r} is not a number") from None
        return reals if len(reals) > 1 else reals[0]
    return tuple(parts) if len(parts) > 1 else parts[0]
