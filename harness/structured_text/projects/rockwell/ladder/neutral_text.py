"""The parser for the neutral text of a rung.

Source: Rockwell 1756-RM084, neutral text: a series of instructions ends with a semicolon; the legs
of a branch are separated by commas within brackets.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from structured_text.language.source import Line
from structured_text.projects.rockwell.ladder.model import (
    Branch,
    Instruction,
    LadderError,
    Node,
    Series,
)

__all__ = ["read_rung"]

_NAME = re.compile(r"[^\W\d]\w*")
#: Instructions that may be written without a list of operands.
_ALONE = ("AFI", "MCR", "NOP", "RET", "SBR", "TND")
_QUOTES = "'\""
_OPENING = {"(": ")", "[": "]"}
#: Greatest nesting of branches and of brackets in an operand.
_DEEPEST = 100


def read_rung(lines: Sequence[Line]) -> Series:
    """Return the instructions of a rung's text, or raise LadderError."""
    return _Reader(lines).rung()


class _Reader:
    def __init__(self, lines: Sequence[Line]) -> None:
        self._lines = lines
        self._text = "\n".join(line.text for line in lines)
        self._place = 0

    def rung(self) -> Series:
        series = self._series(0)
        self._blank()
        if self._sign() == ";":
            self._place += 1
            self._blank()
        if self._sign():
            raise self._error(f"{self._sign()!r} is not expected here")
        return series

    # --- the text -------------------------------------------------------------------------

    def _at(self, place: int) -> int:
        number = self._text.count("\n", 0, place)
        return self._lines[min(number, len(self._lines) - 1)].at if self._lines else 1

    def _error(self, message: str, place: int | None = None) -> LadderError:
        at = self._at(self._place if place is None else place)
        return LadderError(message, at, "export the routine again from its tool")

    def _sign(self) -> str:
        return self._text[self._place : self._place + 1]

    def _blank(self) -> None:
        while self._sign().isspace():
            self._place += 1

    def _expect(self, sign: str, opened: int, what: str) -> None:
        self._blank()
        if self._sign() != sign:
            found = repr(self._sign()) if self._sign() else "the end"
            raise self._error(f"{sign} of {what} is expected, not {found}", opened)
        self._place += 1

    # --- instructions and branches --------------------------------------------------------

    def _series(self, depth: int) -> Series:
        found: list[Node] = []
        while True:
            self._blank()
            if self._sign() == "[":
                found.append(self._branch(depth + 1))
            elif name := _NAME.match(self._text, self._place):
                found.append(self._instruction(name[0]))
            else:
                return tuple(found)

    def _branch(self, depth: int) -> Branch:
        if depth > _DEEPEST:
            raise self._error(f"more than {_DEEPEST} nested branches")
        opened = self._place
        self._place += 1
        legs = [self._series(depth)]
        self._blank()
        while self._sign() == ",":
            self._place += 1
            legs.append(self._series(depth))
            self._blank()
        self._expect("]", opened, "a branch")
        return Branch(tuple(legs), self._at(opened))

    def _instruction(self, name: str) -> Instruction:
        opened = self._place
        self._place += len(name)
        self._blank()
        if self._sign() != "(" and name.upper() in _ALONE:
            return Instruction(name.upper(), (), self._at(opened), name)
        if self._sign() != "(":
            raise self._error(f"{name} has no list of operands", opened)
        self._place += 1
        operands = []
        while True:
            operands.append(self._operand(name, opened))
            if self._sign() != ",":
                break
            self._place += 1
        self._expect(")", opened, name)
        if operands == [""]:
            operands = []
        return Instruction(name.upper(), tuple(operands), self._at(opened), name)

    def _operand(self, name: str, opened: int) -> str:
        """Read an operand up to the comma or parenthesis behind it."""
        start, closing = self._place, [""]
        while sign := self._sign():
            if sign in _QUOTES:
                self._quoted(sign)
                continue
            if sign in _OPENING:
                closing.append(_OPENING[sign])
                if len(closing) > _DEEPEST:
                    raise self._error(f"more than {_DEEPEST} nested brackets")
            elif len(closing) == 1 and sign in ",)":
                break
            elif sign in ")]":
                if sign != closing.pop():
                    raise self._error(f"{sign} in an operand of {name} closes nothing")
            elif sign == ";" and len(closing) == 1:
                raise self._error(f"the operands of {name} have no )", opened)
            self._place += 1
        return " ".join(self._text[start : self._place].split())

    def _quoted(self, quote: str) -> None:
        end = self._text.find(quote, self._place + 1)
        while end > 0 and self._text[end - 1] == "$" and self._text[end - 2] != "$":
            end = self._text.find(quote, end + 1)
        if end < 0:
            raise self._error("a text has no end")
        self._place = end + 1
