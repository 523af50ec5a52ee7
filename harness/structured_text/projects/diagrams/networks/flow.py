"""The lines of a translation: headings of networks, and jumps as IF or as a loop over CASE.

The language has no jumps. If all jumps lead forward and one is not crossed by another, what is
skipped stands in an IF. Otherwise the parts between jumps and labels are the branches of a CASE in
a loop.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.model import Diagram, Element, Network
from structured_text.projects.diagrams.networks.statements import Jumped, Made, Statements
from structured_text.projects.model import Lines, in_comment

__all__ = ["arranged"]

_LONGEST = 100
_BREAK = re.compile(r" (?=(?:AND|OR|XOR|[-+*/]) )|(?<=,) ")


@dataclass(frozen=True)
class _Row:
    """A line without its heading: the text with its indent, and the element."""

    text: str
    at: int
    element: Element


def arranged(diagram: Diagram, statements: Statements) -> Lines:
    """Return the lines of a diagram's statements, with a heading for each network."""
    flow = _Flow(diagram, statements)
    return tuple(_with_headings(diagram, flow.rows()))


class _Flow:
    def __init__(self, diagram: Diagram, statements: Statements) -> None:
        self._items = statements.made
        self._statements = statements
        self._targets: dict[int, int] = {}
        places = {network.number: place for place, network in enumerate(diagram.networks)}
        labels = {one.label.upper(): places[one.number] for one in diagram.networks if one.label}
        for index, item in enumerate(self._items):
            if isinstance(item, Jumped) and item.label:
                place = labels[item.label.upper()]
                self._targets[index] = next(
                    (
                        number
                        for number, other in enumerate(self._items)
                        if places.get(other.element.network, 0) >= place
                    ),
                    len(self._items),
                )

    def rows(self) -> Iterator[_Row]:
        nested = all(
            index < target
            and all(
                inner <= index or inner >= target or end <= target
                for inner, end in self._targets.items()
            )
            for index, target in self._targets.items()
        )
        if nested:
            yield from self._within(0, len(self._items), "")
        else:
            yield from self._looped()

    def _within(self, first: int, end: int, indent: str) -> Iterator[_Row]:
        """Yield some items; what a jump skips is in an IF."""
        index = first
        while index < end:
            item = self._items[index]
            target = self._targets.get(index)
            index += 1
            if isinstance(item, Made):
                yield from _rows(item, indent)
            elif target is None:
                yield from _returned(item, indent)
            elif target > index:
                yield _Row(f"{indent}IF {item.inverse} THEN", item.element.at, item.element)
                yield from self._within(index, target, f"{indent}  ")
                last = self._items[target - 1].element
                yield _Row(f"{indent}END_IF;", last.at, last)
                index = target

    def _looped(self) -> Iterator[_Row]:
        """Yield a loop over a CASE with a branch for each part between jumps and labels."""
        count = len(self._items)
        starts = sorted({0, *self._targets.values(), *(one + 1 for one in self._targets)})
        starts = [start for start in starts if start < count]
        numbers = {start: number for number, start in enumerate(starts, 1)}
        following = self._statements.variable("Next", "", "INT")
        first, last = self._items[0].element, self._items[-1].element
        yield _Row(f"{following} := 1;", first.at, first)
        yield _Row(f"WHILE {following} > 0 DO", first.at, first)
        yield _Row(f"  CASE {following} OF", first.at, first)
        for start, number in numbers.items():
            end = starts[number] if number < len(starts) else count
            element = self._items[start].element
            yield _Row(f"    {number}:", element.at, element)
            indent = " " * 6
            for index in range(start, end):
                item = self._items[index]
                if isinstance(item, Made):
                    yield from _rows(item, indent)
                elif index not in self._targets:
                    yield from _returned(item, indent)
            final = self._items[end - 1]
            element = final.element
            normal = numbers.get(end, 0)
            yield _Row(f"{indent}{following} := {normal};", element.at, element)
            if isinstance(final, Jumped) and end - 1 in self._targets:
                number = numbers.get(self._targets[end - 1], 0)
                yield _Row(f"{indent}IF {final.text} THEN", element.at, element)
                yield _Row(f"{indent}  {following} := {number};", element.at, element)
                yield _Row(f"{indent}END_IF;", element.at, element)
        yield _Row("  END_CASE;", last.at, last)
        yield _Row("END_WHILE;", last.at, last)


def _rows(item: Made, indent: str) -> Iterator[_Row]:
    """Yield the lines of a statement."""
    element, inner = item.element, indent
    if item.condition:
        yield from _wrapped(f"{indent}IF {item.condition} THEN", element.at, element)
        inner = f"{indent}  "
    for text, at in item.lines:
        yield from _wrapped(f"{inner}{text}", at, element)
    if item.otherwise:
        yield _Row(f"{indent}ELSE", element.at, element)
        for text, at in item.otherwise:
            yield from _wrapped(f"{inner}{text}", at, element)
    if item.condition:
        yield _Row(f"{indent}END_IF;", element.at, element)


def _returned(item: Jumped, indent: str) -> Iterator[_Row]:
    element = item.element
    if item.text == "TRUE":
        yield _Row(f"{indent}RETURN;", element.at, element)
        return
    yield from _wrapped(f"{indent}IF {item.text} THEN", element.at, element)
    yield _Row(f"{indent}  RETURN;", element.at, element)
    yield _Row(f"{indent}END_IF;", element.at, element)


def _wrapped(text: str, at: int, element: Element) -> Iterator[_Row]:
    """Yield a text in lines of a readable length, unless it has comments."""
    indent = " " * (len(text) - len(text.lstrip()) + 2)
    while len(text) > _LONGEST and "//" not in text and "(*" not in text:
        places = [
            found.start()
            for found in _BREAK.finditer(text)
            if found.start() > len(indent) and not text[: found.start()].count("'") % 2
        ]
        if not places:
            break
        place = max((one for one in places if one <= _LONGEST), default=places[0])
        yield _Row(text[:place], at, element)
        text = f"{indent}{text[place + 1 :]}"
    yield _Row(text, at, element)


def _with_headings(diagram: Diagram, rows: Iterator[_Row]) -> Iterator[Line]:
    """Yield lines; a heading stands before the first line of each network."""
    networks = {network.number: network for network in diagram.networks}
    shown: set[int] = set()
    before = 0
    for row in rows:
        number = row.element.network
        if number != before and number and row.text.strip() not in ("END_IF;", "ELSE"):
            before = number
            indent = row.text[: len(row.text) - len(row.text.lstrip())]
            network = networks.get(number, Network(number, at=row.at))
            yield from _heading(network, indent, again=number in shown)
            shown.add(number)
        yield Line(row.text, row.at, 0, f"network {number}" if number else "")


def _heading(network: Network, indent: str, *, again: bool) -> Iterator[Line]:
    texts = [f"Network {network.number}"]
    title, comment = in_comment(network.title), in_comment(network.comment)
    if not again:
        texts[0] += f": {title}" if title else ""
        texts += [line.strip() for line in comment.splitlines() if line.strip()]
    name = f"network {network.number}"
    for text in texts:
        yield Line(f"{indent}(* {' '.join(text.split())} *)", network.at, 0, name)
