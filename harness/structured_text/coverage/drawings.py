"""Drawings of the networks of a page, with what was energised at some time."""

from __future__ import annotations

import re

from structured_text.coverage.measure import FileResult
from structured_text.projects.diagrams.networks.draw.drawing import State
from structured_text.projects.diagrams.networks.draw.svg import network_svg
from structured_text.projects.diagrams.networks.model import Coil, Contact, Diagram
from structured_text.projects.diagrams.networks.stored import from_data

__all__ = ["picture"]


def picture(result: FileResult, place: str, name: str) -> str:
    """Return the drawing of a network as SVG; `name` is the beginning of its ids.

    A contact that was closed at some time, and a coil that was TRUE or executed at some time, is
    thick. A text beside the name says which value did not occur.
    """
    diagram = from_data(result.drawings[place])
    number = diagram.networks[0].number
    return network_svg(diagram, number, _state(result, place, diagram), name=name, styled=False)


def _state(result: FileResult, place: str, diagram: Diagram) -> State:
    values = _values(result, place)
    energised, texts = {}, {}
    for element in diagram.elements:
        if not isinstance(element, (Contact, Coil)):
            continue
        if isinstance(element, Coil) and element.storage:
            hits = _executed(result, place, element)
            if hits is not None:
                energised[element.id] = hits
                texts[element.id] = "" if hits else f"never {element.storage}"
            continue
        key = _plain(element.variable) + (":=" if isinstance(element, Coil) else "")
        seen = values.get(key, set())
        if element.edge or not seen:
            continue
        # A negated coil is written with the inverse of the power.
        energised[element.id] = (not element.negated) in seen
        if len(seen) == 1:
            texts[element.id] = f"never {'FALSE' if True in seen else 'TRUE'}"
    return State(energised, texts, ": ")


def _values(result: FileResult, place: str) -> dict[str, set[bool]]:
    """Return the values of the conditions of a network, and those that it assigned (`Name:=`)."""
    found: dict[str, set[bool]] = {}
    lines = {line for line, name in result.networks.items() if place in name.split("; ")}
    for decision in result.decisions:
        if decision.line not in lines:
            continue
        for condition in decision.conditions:
            found.setdefault(_plain(condition.text), set()).update(condition.judged.values)
        for text in result.source.get(decision.line, "").splitlines():
            target, assigned, value = text.partition(":=")
            if assigned and _bare(value) == _bare(decision.text):
                key = f"{_plain(target)}:="
                found.setdefault(key, set()).update(decision.vectors.values())
    return found


def _executed(result: FileResult, place: str, coil: Coil) -> bool | None:
    """Return whether the statement of a coil that sets or resets was executed; None: unknown."""
    value = "TRUE" if coil.storage == "set" else "FALSE"
    wanted = _plain(f"{coil.variable}:={value};")
    hits = [
        item.hits
        for item in result.statements
        if place in result.networks.get(item.line, "").split("; ") and _plain(item.text) == wanted
    ]
    return max(hits) > 0 if hits else None


def _plain(text: str) -> str:
    """Return a text without blanks and in upper case."""
    return re.sub(r"\s+", "", text).upper()


def _bare(text: str) -> str:
    """Return an expression without blanks, parentheses and semicolon, to compare two of them."""
    return re.sub(r"[();]", "", _plain(text))
