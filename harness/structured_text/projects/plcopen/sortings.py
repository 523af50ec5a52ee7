"""The order of elements without a number, which depends on the version of the editor.

A file does not say which version compiles it. So a diagram is translated in the order of each
version. If two statements that depend on each other change places, the order matters.

Source: PLCGenerator.py (SortInstances, ComputeProgram) of Beremiz before and since its version for
Python 3, and of xml2st, which OpenPLC Editor 4 executes.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from structured_text.errors import VARIABLES
from structured_text.projects.diagrams.networks.check import DiagramError
from structured_text.projects.diagrams.networks.model import SORTINGS, Coil, Diagram
from structured_text.projects.diagrams.networks.order import executed
from structured_text.projects.diagrams.networks.types import Callee, Types
from structured_text.projects.model import Lines, without_comments
from structured_text.projects.plcopen.conditions import statements_of
from structured_text.projects.xml import Element

__all__ = ["order_note", "sorting_of"]

#: How elements are ordered, as the end of a sentence.
_ORDERS = {
    "position": "by position, outputs before blocks",
    "file": "in the order of the file, outputs before blocks, as in Beremiz since 2022",
    "together": "by position, outputs and blocks together, as in OpenPLC Editor 4",
}
_HINT = "give blocks and output variables an execution order, and draw coils from top to bottom"
_PARALLEL = "lead no line on behind a coil that several lines lead to"
#: The number of networks that a note names.
_MOST = 4
#: Marks variables that blocks of the project may share.
_OUTSIDE = "*outside"

_QUOTED = re.compile(r"'(?:\$.|[^$'\n])*'|\"(?:\$.|[^$\"\n])*\"")
_MADE = re.compile(rf"\b({VARIABLES}\w*?)(?:_\d+)+\b")
_SIMPLE = re.compile(r";|\b(?:THEN|ELSE|DO)\b", re.IGNORECASE)
_NAME = re.compile(r"(?<![\w.#%])[^\W\d]\w*(?!\w*#)")
_FORMAL = re.compile(r"(?<![\w.])[^\W\d]\w*(?=\s*(?::=|=>))")
_ARGUMENT = re.compile(r"([^\W\d]\w*)\s*(:=|=>)\s*([^\W\d]\w*)")
_CALL = re.compile(r"\s*([^\W\d][\w.]*(?:\[[^\]]*\])?)\s*\((.*)\)\s*", re.DOTALL)
_CALLED = re.compile(r"(?<![\w.])([^\W\d]\w*)\s*\(")

#: Translates a diagram to the section of added variables and the statements.
Translate = Callable[[Diagram], tuple[Lines, Lines]]


def sorting_of(root: Element) -> str:
    """Return the order of a file's diagrams: `together` if the header names OpenPLC."""
    said = " ".join(
        header.get(name)
        for header in root.all("fileHeader")
        for name in ("companyName", "productName")
    )
    return "together" if "openplc" in said.lower() else "file"


def order_note(diagram: Diagram, translate: Translate, types: Callable[[Lines], Types]) -> str:
    """Return a note if the version of the editor matters for a diagram; otherwise empty.

    `types` returns the types with an added section.
    """
    if not diagram.by_position:
        return ""
    others = [replace(diagram, sorting=name) for name in SORTINGS if name != diagram.sorting]
    others = [other for other in others if _key(other) != _key(diagram)]
    if not others:
        return ""
    own = _Body.of(diagram, translate, types)
    swapped: set[str] = set()
    changed: set[str] = set()
    for other in others:
        try:
            body = _Body.of(other, translate, types)
        except DiagramError:
            continue  # this version of the editor does not compile it
        if body.normal() != own.normal():
            swapped.update(own.swapped(body))
            changed.update(own.changed(body))
    if not swapped and not changed:
        return ""
    if swapped:
        of = "of" if len(swapped) > 1 else "in"
        text, hint = f"the order of execution {of} {_networks(swapped)} depends", _HINT
    else:
        text = f"the result of {_networks(changed)} depends"
        hint = f"{_HINT}; {_PARALLEL}" if _has_parallel(diagram) else _HINT
    order = _ORDERS[diagram.sorting]
    return f"{text} on the version of the editor; here it is executed {order} ({hint})"


def _key(diagram: Diagram) -> object:
    """Return what a translation depends on: the order, and the power behind parallel lines."""
    order = [element.id for element in executed(diagram)]
    return order, _has_parallel(diagram) and diagram.sorting == "together"


def _has_parallel(diagram: Diagram) -> bool:
    return any(
        isinstance(element, Coil) and len(element.input.connections) > 1
        for element in diagram.elements
    )


def _networks(names: set[str]) -> str:
    """Return the names of networks, such as "networks 2 and 5"."""
    numbers = sorted(names, key=lambda name: (len(name), name))
    numbers = [name.removeprefix("network ") for name in numbers]
    if len(numbers) == 1:
        return f"network {numbers[0]}"
    if len(numbers) > _MOST:
        numbers = [*numbers[:_MOST], f"{len(numbers) - _MOST} more"]
    return f"networks {', '.join(numbers[:-1])} and {numbers[-1]}"


@dataclass(frozen=True)
class _Statement:
    """A statement without comments; names that the translation has made have no number."""

    text: str
    network: str
    reads: frozenset[str]
    writes: frozenset[str]

    def depends_on(self, other: _Statement) -> bool:
        return bool(self.writes & (other.writes | other.reads) or self.reads & other.writes)


@dataclass(frozen=True)
class _Body:
    statements: Sequence[_Statement]

    @classmethod
    def of(cls, diagram: Diagram, translate: Translate, types: Callable[[Lines], Types]) -> _Body:
        section, lines = translate(diagram)
        reader = _Effects(types(section))
        return cls([reader.statement(part) for part in statements_of(lines)])

    def normal(self) -> Counter[tuple[int, str]]:
        """Return the statements with their levels.

        The level is the length of the longest chain of statements before it that depend on each
        other. The order of statements that do not depend on each other does not change it.
        """
        written: dict[str, int] = {}
        read: dict[str, int] = {}
        found: Counter[tuple[int, str]] = Counter()
        for one in self.statements:
            before = [written.get(name, 0) for name in (*one.reads, *one.writes)]
            before += [read.get(name, 0) for name in one.writes]
            level = 1 + max(before, default=0)
            written.update((name, level) for name in one.writes)
            read.update((name, max(level, read.get(name, 0))) for name in one.reads)
            found[level, one.text] += 1
        return found

    def named(self) -> list[tuple[str, int]]:
        """Return the statements as keys: their text, and how often it occurred before."""
        seen: Counter[str] = Counter()
        keys = []
        for one in self.statements:
            keys.append((one.text, seen[one.text]))
            seen[one.text] += 1
        return keys

    def swapped(self, other: _Body) -> Iterator[str]:
        """Yield the networks of statements that depend on each other and change places."""
        places = {key: place for place, key in enumerate(other.named())}
        known = [
            (one, places[key])
            for one, key in zip(self.statements, self.named(), strict=True)
            if key in places
        ]
        for number, (one, place) in enumerate(known):
            for before, earlier in known[:number]:
                if earlier > place and one.depends_on(before):
                    yield from (before.network, one.network)

    def changed(self, other: _Body) -> Iterator[str]:
        """Yield the networks of statements with another text or another place."""
        there = other.normal()
        texts = {text for (_, text), _ in (self.normal() - there).items()}
        yield from (one.network for one in self.statements if one.text in texts)


class _Effects:
    """Finds what statements read and write. What is not known is taken as written."""

    def __init__(self, types: Types) -> None:
        self._types = types

    def statement(self, lines: Lines) -> _Statement:
        whole = without_comments("\n".join(line.text for line in lines))
        text = _MADE.sub(r"\1", re.sub(r"\s+", " ", whole).strip())
        plain = _QUOTED.sub(lambda found: found[0][0] * 2, whole)
        reads = {name.upper() for name in _NAME.findall(_unnamed(plain))}
        writes: set[str] = set()
        for part in _SIMPLE.split(plain):
            writes |= {name.upper() for name in self._written(part)}
        network = next((line.network for line in lines if line.network), "")
        return _Statement(text, network, frozenset(reads), frozenset(writes))

    def _written(self, text: str) -> Iterator[str]:
        for name in _CALLED.findall(text):
            callee = self._types.callee(name)
            if callee is not None and any(pin.section == "VAR_IN_OUT" for pin in callee.pins):
                yield from _NAME.findall(_unnamed(text))
        target, assigned, _ = _outside_of_brackets(text).partition(":=")
        if assigned:
            yield from _NAME.findall(target)[:1]
        call = _CALL.fullmatch(text)
        if call is None or assigned or call[1].upper() in ("IF", "ELSIF", "WHILE"):
            return
        callee = self._types.callee(self._types.of(call[1]) or call[1])
        yield from _NAME.findall(call[1])[:1]
        yield from _arguments(call[2], callee)
        if callee is None or not callee.standard:
            yield _OUTSIDE


def _arguments(text: str, callee: Callee | None) -> Iterator[str]:
    """Yield the variables that a call may write."""
    for name, arrow, variable in _ARGUMENT.findall(text):
        pin = callee.pin(name) if callee is not None else None
        if arrow == "=>" or pin is None or pin.section == "VAR_IN_OUT":
            yield variable


def _unnamed(text: str) -> str:
    """Return a text without the names of pins in brackets."""
    found, depth, start = [], 0, 0
    for place, letter in enumerate(f"{text})"):
        if letter in "()":
            part = text[start:place]
            found.append(_FORMAL.sub(" ", part) if depth else part)
            depth, start = max(0, depth + (1 if letter == "(" else -1)), place
    return "".join(found)


def _outside_of_brackets(text: str) -> str:
    """Return a text with blanks in place of what is in brackets."""
    depth, found = 0, []
    for letter in text:
        depth -= letter in ")]"
        found.append(" " if depth > 0 else letter)
        depth += letter in "(["
    return "".join(found)
