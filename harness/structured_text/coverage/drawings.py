"""Drawings of the networks of a page, with what was energised at some time."""

from __future__ import annotations

import re
from dataclasses import dataclass

from structured_text.coverage.measure import FileResult
from structured_text.projects.diagrams.networks.draw.drawing import State
from structured_text.projects.diagrams.networks.draw.svg import network_svg
from structured_text.projects.diagrams.networks.model import Block, Coil, Contact, Diagram
from structured_text.projects.diagrams.networks.stored import from_data

__all__ = ["picture"]

#: Last letters of the first line of statements; a condition has none of them.
_EXECUTED = (";", " THEN", " DO")


def picture(result: FileResult, place: str, name: str) -> str:
    """Return the drawing of a network as SVG; `name` is the beginning of its ids.

    A contact that was closed at some time, and a coil or box that was TRUE or executed at some
    time, is thick. A text beside the name says which value did not occur.
    """
    diagram = from_data(result.drawings[place])
    number = diagram.networks[0].number
    return network_svg(diagram, number, _state(result, place, diagram), name=name, styled=False)


def _state(result: FileResult, place: str, diagram: Diagram) -> State:
    found = _Found.of(result, place)
    energised, texts = {}, {}
    for element in diagram.elements:
        if isinstance(element, (Contact, Block)):
            seen = found.condition(_bare(_condition(element)))
            if isinstance(element, Block):
                seen = seen or found.statement(element.translation)
            elif element.edge:
                continue
        elif isinstance(element, Coil):
            seen = found.statement(_statement(element))
        else:
            continue
        if not seen:
            continue
        if isinstance(element, Coil) and element.storage:
            energised[element.id] = True in seen
            texts[element.id] = "" if True in seen else f"never {element.storage}"
            continue
        if isinstance(element, Coil) and element.edge:
            continue
        negated = not isinstance(element, Block) and element.negated
        # A negated coil is written with the inverse of the power.
        energised[element.id] = (not negated) in seen
        if isinstance(element, Block) and _is_guarded(element):
            texts[element.id] = "" if True in seen else "never executed"
        elif len(seen) == 1:
            texts[element.id] = f"never {'FALSE' if True in seen else 'TRUE'}"
    return State(energised, texts, ": ")


def _condition(element: Contact | Block) -> str:
    """Return the condition that an element became; empty for a block with statements."""
    if isinstance(element, Contact):
        return element.translation or element.variable
    return "" if _is_guarded(element) or "?" in element.translation else element.translation


def _is_guarded(block: Block) -> bool:
    """Return whether a block became statements that are executed only with power."""
    return "?" not in block.translation and block.translation.endswith(_EXECUTED)


def _statement(coil: Coil) -> str:
    """Return the statement that a coil became, with `?` in place of the power."""
    value = {"set": "TRUE", "reset": "FALSE"}.get(coil.storage, "?")
    return coil.translation or f"{coil.variable} := {value};"


@dataclass
class _Found:
    """What a run recorded of a network; texts of expressions are as `_bare` returns them.

    Attributes:
        conditions: The values of each condition.
        decisions: The values of each decision.
        lines: The lines of the translation, without blanks and in upper case.
        hits: How often each statement was executed, by its first line.
    """

    conditions: dict[str, set[bool]]
    decisions: dict[str, set[bool]]
    lines: list[str]
    hits: dict[str, int]

    @staticmethod
    def of(result: FileResult, place: str) -> _Found:
        """Return what was recorded of a network."""
        found = _Found({}, {}, [], {})
        lines = {line for line, name in result.networks.items() if place in name.split("; ")}
        for line in sorted(lines):
            found.lines += map(_plain, result.source.get(line, "").splitlines())
        for decision in result.decisions:
            if decision.line in lines:
                values = found.decisions.setdefault(_bare(decision.text), set())
                values.update(decision.vectors.values())
                for condition in decision.conditions:
                    seen = found.conditions.setdefault(_bare(condition.text), set())
                    seen.update(condition.judged.values)
        for item in result.statements:
            if item.line in lines:
                text = _plain(item.text)
                found.hits[text] = max(found.hits.get(text, 0), item.hits)
        return found

    def condition(self, text: str) -> set[bool]:
        """Return the values of a condition or decision."""
        return self.conditions.get(text) or self.decisions.get(text, set())

    def statement(self, text: str) -> set[bool]:
        """Return the values of the power in a statement, or whether it was executed."""
        text = _plain(text)
        if "?" not in text:
            return {self.hits[text] > 0} if text in self.hits else set()
        before, _, behind = text.partition("?")
        for line in self.lines:
            if line.startswith(before) and line.endswith(behind):
                power = line[len(before) : len(line) - len(behind)]
                return self._power(power, line)
        return set()

    def _power(self, power: str, line: str) -> set[bool]:
        """Return the values of the power that a line passes."""
        if power in ("TRUE", "FALSE"):
            return {power == "TRUE"} if self.hits.get(line) else set()
        kept = next((text for text in self.lines if text.startswith(f"{power}:=")), "")
        return self.condition(_bare(power)) or self.condition(_bare(kept.partition(":=")[2]))


def _plain(text: str) -> str:
    """Return a text without blanks and in upper case."""
    return re.sub(r"\s+", "", text).upper()


def _bare(text: str) -> str:
    """Return an expression without blanks, parentheses and semicolon, to compare two of them."""
    return re.sub(r"[();]", "", _plain(text))
