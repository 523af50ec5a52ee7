"""Search for dedicated signals that are OFF and so explain why a request has no effect.

A chart leaves out all other signals that are always OFF.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache

from rcx_harness.spec import folder
from structured_text.engines.base import Program
from structured_text.language.types import BlockType, ElementaryType
from structured_text.output.toml_files import load_toml

__all__ = ["named", "of_alarms", "of_errors", "shown_errors", "unanswered"]

_SIGNAL = re.compile(r"\bS[IO]\(\d\d\)")
_WORD = ElementaryType("WORD")

#: The answer to each dedicated input, and its conditions (manual chapter 5, 2 and 3).
_REQUESTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "SI(01)": ("SO(02)", ("SI(00)",)),
    "SI(10)": ("SO(12)", ()),
    "SI(12)": ("SO(13)", ("SI(00)", "SI(06)", "SO(10)")),
    "SI(14)": ("SO(11)", ("SI(00)", "SI(06)")),
    "SI(15)": ("SO(14)", ("SO(10)",)),
    "SI(17)": ("SO(11)", ("SI(00)", "SI(06)")),
}
#: Maps an alarm to its signal. The names of the alarms are in spec/alarms.toml and
#: public_alarms.toml.
_ALARMS = {
    "0.20": "SO(10)",  # illegal mode
    "6.300": "SO(02)",  # alarm: the motor power is off
    "6.301": "SO(02)",  # servo off
    "6.302": "SO(11)",  # origin incomplete
    "12.400": "SI(06)",  # alarm: the stop input is active
    "12.600": "SI(00)",  # alarm: the emergency stop is active
}


def named(texts: Iterable[str]) -> set[str]:
    """Return the signals that occur in texts, in the form `SI(06)`."""
    return {one for text in texts for one in _SIGNAL.findall(text)}


def unanswered(ever_on: Collection[str]) -> set[str]:
    """Return answers that are missing although their input was ON, and missing conditions of them.

    SI(00) is included if SO(00) shows an emergency stop and SI(00) was never ON.
    """
    found = {
        signal
        for request, (answer, needs) in _REQUESTS.items()
        if request in ever_on and answer not in ever_on
        for signal in (answer, *(one for one in needs if one not in ever_on))
    }
    if "SO(00)" in ever_on and "SI(00)" not in ever_on:
        found.add("SI(00)")
    return found


def of_alarms(numbers: Iterable[str]) -> set[str]:
    """Return the signals that belong to alarms which have ended remote commands."""
    return {_ALARMS[number] for number in numbers if number in _ALARMS}


def of_errors(numbers: Iterable[int]) -> set[str]:
    """Return the signals that the causes of these ErrorIDs name (docs/reference/errors.md)."""
    causes = _causes()
    return {signal for number in numbers for signal in causes.get(number, ())}


def shown_errors(program: Program) -> set[int]:
    """Return the ErrorIDs that the blocks and the variables of a program contain now."""
    return {number for path in _words(program) if (number := int(str(program.read(path))))}


def _words(program: Program) -> Iterator[str]:
    for name, kind in program.instances().items():
        for variable in kind.variables if isinstance(kind, BlockType) else ():
            path = f"{name}.{variable.name}"
            if variable.type == _WORD:
                yield path
            elif isinstance(variable.type, BlockType):
                for pin in variable.type.variables:
                    if (pin.name, pin.type, pin.section) == ("ErrorID", _WORD, "VAR_OUTPUT"):
                        yield f"{path}.ErrorID"


@lru_cache(maxsize=1)
def _causes() -> dict[int, frozenset[str]]:
    table = load_toml(folder() / "errors.toml")["error"]
    return {entry["id"]: frozenset(named([entry["cause"]])) for entry in table}
