"""Charts in the text form of the standard, inside sources of Structured Text.

`with_charts` returns a source in which each chart is replaced by its translation. Everything behind
it, such as the checks and the engines, therefore sees plain statements at the lines of the chart.

Source: IEC 61131-3, annex B.1.6.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

from lark import Token

from structured_text.errors import InputError, near
from structured_text.language.lexer import Notes, tokens
from structured_text.language.source import Extract, Line, origin, source_text
from structured_text.projects.diagrams.sfc.check import ChartError, check
from structured_text.projects.diagrams.sfc.model import (
    QUALIFIERS,
    TIMED,
    Action,
    Association,
    Chart,
    Step,
    Transition,
    has_chart,
)
from structured_text.projects.diagrams.sfc.names import Names
from structured_text.projects.diagrams.sfc.translate import translate

__all__ = ["with_charts"]

_NAME = re.compile(r"[^\W\d]\w*")
_POUS = ("PROGRAM", "FUNCTION_BLOCK")
_ELEMENTS = ("INITIAL_STEP", "STEP", "TRANSITION", "ACTION")
#: Words that may stand behind a chart in its POU.
_MEMBERS = ("METHOD", "PROPERTY")


def with_charts(file: Path, *, final_scan: bool = True) -> Path:
    """Return the source with statements in place of its charts; the file itself if it has none.

    `final_scan`: see `translate`. Raise InputError if a chart cannot be read.
    """
    text = source_text(file)
    if not has_chart(text):
        return file
    found = list(tokens(text, file, Notes()))
    source = _Source(text, file)
    lines: list[Line] = []
    behind = 0
    for begin, end in _pous(found):
        first = next((k for k in range(begin, end) if _is_chart(found, k)), end)
        if first == end:
            continue
        reader = _Reader(source, found[first : end + 1])
        chart = reader.chart()
        pou = text[_start(found[begin]) : _start(found[end])]
        section, statements = translate(chart, Names(pou), final_scan=final_scan)
        lines += [*source.lines(behind, _start(found[first])), *section, *statements]
        lines += reader.others
        behind = reader.behind
    if not behind:
        return file
    lines += source.lines(behind, len(text))
    return Extract.make(file, tuple(lines), dialect=getattr(file, "dialect", ""))


def _start(token: Token) -> int:
    return token.start_pos or 0


def _pous(found: list[Token]) -> Iterator[tuple[int, int]]:
    """Yield the first and last token of each program and function block."""
    at = 0
    while at < len(found):
        word = found[at].type
        if word in _POUS:
            end = next((k for k in range(at + 1, len(found)) if found[k].type in _POU_ENDS), None)
            if end is not None and found[end].type == f"END_{word}":
                yield at, end
                at = end
        at += 1


#: An instance of a program, PROGRAM in a CONFIGURATION, ends at none of the first two.
_POU_ENDS = (*(f"END_{word}" for word in _POUS), *_POUS, "END_RESOURCE", "END_CONFIGURATION")


def _is_chart(found: list[Token], at: int) -> bool:
    return (
        found[at].upper() == "INITIAL_STEP"
        and at + 1 < len(found)
        and _NAME.fullmatch(str(found[at + 1])) is not None
    )


class _Source:
    """The text of a file, and the lines of its parts."""

    def __init__(self, text: str, file: Path) -> None:
        self.text, self.file = text, file
        self._starts = [0, *(found.end() for found in re.finditer("\n", text))]

    def at(self, offset: int) -> tuple[int, int]:
        """Return line and column in the file."""
        number = bisect_right(self._starts, offset)
        return origin(self.file, number, offset - self._starts[number - 1] + 1)

    def lines(self, begin: int, end: int) -> tuple[Line, ...]:
        """Return a part of the text as lines; lines without text at both ends are left out."""
        made: list[Line] = []
        offset = begin
        for text in self.text[begin:end].split("\n"):
            line, column = self.at(offset)
            made.append(Line(text, line, column - 1))
            offset += len(text) + 1
        while made and not made[-1].text.strip():
            made.pop()
        while made and not made[0].text.strip():
            del made[0]
        return tuple(made)


class _Reader:
    """Reads a chart from its tokens, the last of which ends the POU."""

    def __init__(self, source: _Source, found: list[Token]) -> None:
        self._source, self._found, self._at = source, found, 0
        self.behind = 0
        self.others: list[Line] = []

    def chart(self) -> Chart:
        """Return the chart; `behind` is then the offset behind its text."""
        steps: list[Step] = []
        transitions: list[Transition] = []
        actions: list[Action] = []
        begun: list[Token] = []
        while self._word in _ELEMENTS:
            token = self._next()
            begun.append(token)
            if token.upper() in ("INITIAL_STEP", "STEP"):
                steps.append(self._step(token))
            elif token.upper() == "TRANSITION":
                transitions.append(self._transition(token))
            else:
                actions.append(self._action(token))
            while self._word == ";":
                self._next()
        if self._at < len(self._found) - 1 and self._word not in _MEMBERS:
            self._fail(
                f"{str(self._token)!r} is not expected in a chart",
                self._token,
                "write STEP, TRANSITION or ACTION",
            )
        self.behind = _start(self._token)
        chart = Chart(tuple(steps), tuple(transitions), tuple(actions))
        try:
            check(chart)
        except ChartError as error:
            raise InputError(
                error.message, file=self._source.file, line=error.at, hint=error.hint
            ) from None
        used = {one.action.upper() for step in steps for one in step.associations}
        for action in actions:
            if action.name.upper() not in used:
                head, end = f"ACTION {action.name}:", "END_ACTION"
                self.others += [Line(head, action.at), *action.body, Line(end, action.at)]
        return chart

    # --- elements ---

    def _step(self, word: Token) -> Step:
        name = self._name("a step")
        self._expect(":")
        found: list[Association] = []
        while self._word != "END_STEP":
            found.append(self._association())
            self._expect(";")
        self._next()
        return Step(name, word.upper() == "INITIAL_STEP", tuple(found), self._line(word))

    def _association(self) -> Association:
        token = self._token
        name = self._name("an action or END_STEP")
        qualifier, time = "N", ""
        if self._word == "(":
            self._next()
            if self._word in QUALIFIERS:
                qualifier = self._next().upper()
                if qualifier in TIMED:
                    if self._word != ",":
                        text = f"the qualifier {qualifier} of {name} has no time"
                        self._fail(text, token, f"write {name} ({qualifier}, T#1s)")
                    self._next()
                    time = self._until(",", ")")
            elif self._word not in (")", ","):
                text = f"{self._token} is not a qualifier"
                self._fail(text, self._token, near(self._word, QUALIFIERS))
            self._until(")")  # names of indicators, which have no effect
            self._expect(")")
        return Association(name, qualifier, time, self._line(token))

    def _transition(self, word: Token) -> Transition:
        name = "" if self._word in ("FROM", "(") else self._name("a transition")
        priority: int | None = None
        if self._word == "(":
            for text in ("(", "PRIORITY", ":="):
                self._expect(text)
            if not self._word.isdigit():
                self._fail("a priority is a number", self._token, "write (PRIORITY := 1)")
            priority = int(self._next())
            self._expect(")")
        self._expect("FROM")
        sources = self._steps()
        self._expect("TO")
        targets = self._steps()
        if self._word == ":":
            text = "the condition of this transition is in Instruction List, which is not read"
            self._fail(text, self._token, "write := and an expression")
        self._expect(":=")
        begin = self._at
        while self._word not in (";", "END_TRANSITION"):
            self._advance(word, "END_TRANSITION")
        condition = self._lines(begin)
        if not condition:
            self._fail("this transition has no condition", word, "write := TRUE if it always fires")
        if self._word == ";":
            self._next()
        self._expect("END_TRANSITION")
        return Transition(sources, targets, condition, priority, name, self._line(word))

    def _steps(self) -> tuple[str, ...]:
        if self._word != "(":
            return (self._name("a step"),)
        self._next()
        names = [self._name("a step")]
        while self._word == ",":
            self._next()
            names.append(self._name("a step"))
        self._expect(")")
        return tuple(names)

    def _action(self, word: Token) -> Action:
        name = self._name("an action")
        self._expect(":")
        begin = self._at
        while self._word != "END_ACTION":
            self._advance(word, "END_ACTION")
        body = self._lines(begin)
        self._next()
        return Action(name, body, self._line(word))

    # --- tokens ---

    @property
    def _token(self) -> Token:
        return self._found[min(self._at, len(self._found) - 1)]

    @property
    def _word(self) -> str:
        return str(self._token).upper()

    def _next(self) -> Token:
        token = self._token
        self._at += 1
        return token

    def _advance(self, word: Token, end: str) -> None:
        """Skip a token of an element; raise InputError if the element has no end."""
        if self._at >= len(self._found) - 1 or self._word in ("STEP", "TRANSITION", "ACTION"):
            self._fail(f"the {word} of this line has no {end}", word, f"write {end}")
        self._next()

    def _expect(self, text: str) -> None:
        if self._word != text:
            self._fail(f"{str(self._token)!r} is not expected here", self._token, f"write {text}")
        self._next()

    def _name(self, what: str) -> str:
        token = self._token
        if _NAME.fullmatch(str(token)) is None or self._at >= len(self._found) - 1:
            self._fail(f"{str(token)!r} is not expected here", token, f"write the name of {what}")
        return str(self._next())

    def _until(self, *ends: str) -> str:
        """Return the text up to one of these signs outside of parentheses."""
        begin, depth = self._token, 0
        while depth or self._word not in ends:
            if self._at >= len(self._found) - 1 or self._word == "END_STEP":
                self._fail("this ( has no )", begin, "write )")
            depth += {"(": 1, ")": -1}.get(self._word, 0)
            self._next()
        return self._source.text[_start(begin) : _start(self._token)].strip()

    def _lines(self, begin: int) -> tuple[Line, ...]:
        """Return the text from a token to the present token."""
        first = self._found[begin]
        before = self._found[begin - 1]
        start = _start(before) + len(before)
        text = self._source.text[start : _start(self._token)]
        if first is self._token and not text.strip():
            return ()
        return self._source.lines(start, _start(self._token))

    def _line(self, token: Token) -> int:
        return self._source.at(_start(token))[0]

    def _fail(self, message: str, token: Token, hint: str) -> NoReturn:
        line, column = self._source.at(_start(token))
        raise InputError(message, file=self._source.file, line=line, column=column, hint=hint)
