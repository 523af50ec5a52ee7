"""The rungs of a ladder routine in an L5X.

Source: Rockwell 1756-RM084, ladder routines: attributes and types of rungs.
"""

from __future__ import annotations

from collections.abc import Callable

from structured_text.language.source import Line
from structured_text.projects.rockwell.ladder.model import LadderError, Rung
from structured_text.projects.rockwell.ladder.neutral_text import read_rung
from structured_text.projects.xml import Element

__all__ = ["read_rungs"]

#: Types of rungs that the controller executes: normal, and those that a pending edit would delete
#: or replace.
_EXECUTED = {"": "normal", "N": "normal", "D": "delete", "d": "pending delete", "R": "replace"}
_EXECUTED["rN"] = "pending replace of a normal rung"
#: Types of rungs that are not in the controller's program before the edits are accepted.
_EDITS = {
    "I": "insert",
    "IR": "insert with a replace",
    "rR": "pending replace of IR",
    "rI": "pending replace of I",
    "e": "pending insert",
    "er": "pending replace",
}


def read_rungs(routine: Element, note: Callable[[str, Element], None]) -> tuple[Rung, ...]:
    """Return the rungs that the controller executes, or raise LadderError.

    `note` takes a message about a rung that is left out because it is an edit that was not
    accepted, and its element.
    """
    found = []
    for place, element in enumerate(routine.all("RLLContent", "Rung")):
        number = element.get("Number")
        rung = int(number) if number.isdecimal() and len(number) < 10 else place
        kind = element.get("Type")
        name = routine.get("Name")
        if kind in _EDITS:
            text = f"rung {rung} of {name} is an edit that is not accepted ({kind}"
            note(f"{text}, {_EDITS[kind]}) and is left out", element)
            continue
        if kind not in _EXECUTED:
            text = f"rung {rung}: the type {kind!r:.20} of a rung is not known"
            raise LadderError(text, element.at, "accept or cancel all edits, and export it again")
        if _EXECUTED[kind] != "normal":
            text = f"rung {rung} of {name} has an edit that is not accepted ({kind}"
            note(f"{text}, {_EXECUTED[kind]}); its old form is read", element)
        found.append(_rung(element, rung))
    return tuple(found)


def _rung(element: Element, number: int) -> Rung:
    texts, comments = element.all("Text"), element.all("Comment")
    lines = texts[0].lines() if texts else []
    try:
        series = read_rung(lines or [Line("", element.at)])
    except LadderError as error:
        raise LadderError(f"rung {number}: {error.message}", error.at, error.hint) from None
    comment = comments[0].text() if comments else ""
    return Rung(number, series, comment, element.at)
