"""The items to cover in a POU, with the lines of its file and as text."""

from __future__ import annotations

import operator
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from structured_text.engines.builtin.coverage import Plan, Postfix
from structured_text.language import tree as t
from structured_text.language.lexer import tokens
from structured_text.language.printer import expression_text, label_text
from structured_text.language.source import NetworkLine, origin, source_text
from structured_text.language.types import EnumType
from structured_text.language.walk import bodies

__all__ = ["Branch", "Listed", "Listing", "Point", "Text", "listing"]

_OPENS = ("IF", "CASE", "WHILE", "FOR", "REPEAT")
_REASON = re.compile(r"\(\*\s*unreachable:\s*((?s:.*?))\s*\*\)|//[ \t]*unreachable:[ \t]*(.*)")
_COMPARE = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


class Point(NamedTuple):
    """A statement: its line, its counter, and its text if it was translated from a drawing."""

    line: int
    counter: int
    text: str = ""


class Branch(NamedTuple):
    """A branch of an IF, CASE, WHILE or FOR.

    `fork` is the number of the IF, CASE or loop, and `at` its line. `line` is the first line of the
    branch, or the last line of the statement if the branch is empty.
    """

    line: int
    at: int
    counter: int
    fork: int
    text: str


class Listed(NamedTuple):
    """A decision: its line, its statement's line, its conditions, and the operators in `code`."""

    line: int
    at: int
    text: str
    conditions: Sequence[str]
    code: Postfix


@dataclass
class Listing:
    """All items to cover in one POU.

    Attributes:
        line: The first line of the POU.
        statements: The statements in source order.
        branches: The branches in source order, without branches that the source excludes. Excluded
            are "no label fits" of a CASE with labels for all members of an enumeration, and "no
            round" of a loop if constants ensure a round.
        decisions: The decisions in the order of the engine.
    """

    name: str
    line: int
    statements: list[Point] = field(default_factory=list)
    branches: list[Branch] = field(default_factory=list)
    decisions: list[Listed] = field(default_factory=list)


@dataclass
class _Words:
    """The lines of the keywords of one IF, CASE or loop."""

    branches: list[int]
    otherwise: int = 0
    end: int = 0


class Text:
    """The text of a file, or of the parts that were extracted from a project file.

    A file of Structured Text is its own source.

    Attributes:
        lines: The text by line number.
        reasons: The reasons why lines are unreachable, by line number.
        networks: The rungs or networks that lines were translated from, such as `Main, rung 3`, by
            line number. The text of such a line is the translation.
        words: The keyword lines of each IF, CASE or loop, by the position of its first word.

    Raises:
        InputError: The file cannot be read any more.
    """

    def __init__(self, file: Path, sources: Sequence[Path]) -> None:
        self.lines: dict[int, str] = {}
        self.reasons: dict[int, str] = {}
        self.networks: dict[int, str] = {}
        self.words: dict[tuple[int, int], _Words] = {}
        own = file.read_text(encoding="utf-8", errors="replace").splitlines()
        for source in sources:
            text = source_text(source)
            drawn: dict[int, list[str]] = {}
            names: dict[int, list[str]] = {}
            for number, shown in enumerate(text.splitlines(), 1):
                at, _ = origin(source, number, 1)
                if isinstance(at, NetworkLine):
                    drawn.setdefault(int(at), []).append(shown)
                    names.setdefault(int(at), []).append(at.place)
                # A line of the source may be assembled from several parts of the file. Then the
                # line of the file is shown.
                elif self.lines.setdefault(at, shown) != shown:
                    self.lines[at] = own[at - 1] if at <= len(own) else shown
            # An element of a drawing may become several statements.
            self.lines |= {at: "\n".join(texts) for at, texts in drawn.items()}
            self.networks |= {at: "; ".join(dict.fromkeys(some)) for at, some in names.items()}
            for number, reason in _reasons(text).items():
                self.reasons[origin(source, number, 1)[0]] = reason
            self.words |= _words(text, source)


def listing(pou: t.Pou, plan: Plan, text: Text) -> Listing:
    """Return the items to cover in a POU."""
    found = Listing(pou.name, pou.at.line)
    _Lister(found, plan, text.words).statements(pou.body)
    return found


def _reasons(text: str) -> dict[int, str]:
    """Return each reason by the line that it covers: its own line, or the next line with code."""
    found = {}
    for comment in _REASON.finditer(text):
        before = text[: comment.start()].rpartition("\n")[2].strip()
        after = text[comment.end() :]
        line = text.count("\n", 0, comment.end()) + 1
        if not before:
            line += after[: len(after) - len(after.lstrip())].count("\n")
        found[line] = " ".join((comment[1] or comment[2] or "").split())
    return found


def _words(text: str, file: Path) -> dict[tuple[int, int], _Words]:
    """Return the keyword lines of each IF, CASE or loop, by the position of its first word."""
    found: dict[tuple[int, int], _Words] = {}
    open_: list[_Words] = []
    for token in tokens(text, file):
        line = token.line or 1
        if token.type in _OPENS:
            open_.append(_Words([line]))
            found[line, token.column or 1] = open_[-1]
        elif token.type == "ELSIF":
            open_[-1].branches.append(line)
        elif token.type == "ELSE":
            open_[-1].otherwise = line
        elif token.type.removeprefix("END_") in _OPENS:
            open_.pop().end = line
    return found


class _Lister:
    """A walk through a body in the order in which the plan numbers statements and branches."""

    def __init__(self, found: Listing, plan: Plan, words: dict[tuple[int, int], _Words]) -> None:
        self._found = found
        self._plan = plan
        self._words = words
        self._forks = 0
        for one in plan.decisions:
            texts = [expression_text(condition) for condition in one.conditions]
            line = one.line
            found.decisions.append(Listed(line, line, expression_text(one.root), texts, one.code))

    def statements(self, body: tuple[t.Statement, ...]) -> None:
        """List the statements of a body and the items inside them."""
        before: t.Statement | None = None
        for node in body:
            line = node.at.line
            text = line.text if isinstance(line, NetworkLine) else ""
            self._found.statements.append(Point(line, self._plan.run[id(node)], text))
            if isinstance(node, t.If):
                self._if(node)
            elif isinstance(node, t.Case):
                self._branches(node, self._ways_of_case(node))
                for _, inner in node.branches:
                    self.statements(inner)
                self.statements(node.otherwise)
            elif isinstance(node, (t.While, t.For)):
                self._branches(node, self._ways_of_loop(node, before))
                self.statements(node.body)
            elif isinstance(node, t.Try):
                for inner in bodies(node):
                    self.statements(inner)
            elif isinstance(node, t.Repeat):
                self.statements(node.body)
            before = node

    def _branches(self, node: t.Statement, ways: Iterator[tuple[int, int, str]]) -> None:
        at, fork = node.at.line, self._forks
        self._forks += 1
        self._found.branches += [Branch(line, at, n, fork, text) for line, n, text in ways]

    def _words_of(self, node: t.If | t.Case) -> _Words:
        """Return the keyword lines of a node.

        A latch such as `S=` is translated to an IF without keywords. Then the line of the latch
        stands in place of all keyword lines.
        """
        line = node.at.line
        return self._words.get((line, node.at.column)) or _Words([line], line, line)

    def _bodies(
        self, node: t.If | t.Case, bodies: Sequence[tuple[t.Statement, ...]]
    ) -> Iterator[int]:
        """Yield the number of the counter of each branch of an IF or CASE."""
        blank = 0
        for body in bodies:
            yield self._plan.body(node, body, blank)
            blank += not body

    def _if(self, node: t.If) -> None:
        words = self._words_of(node)
        self._branches(node, self._ways_of_if(node, words))
        if (node.at.line, node.at.column) not in self._words:
            return  # The generated assignment of a latch `S=` is not listed.
        for line, (condition, body) in zip(words.branches, node.branches, strict=True):
            number = self._plan.number.get(id(condition))
            if number is not None:
                listed = self._found.decisions[number]
                self._found.decisions[number] = listed._replace(line=line)
            self.statements(body)
        self.statements(node.otherwise)

    def _ways_of_if(self, node: t.If, words: _Words) -> Iterator[tuple[int, int, str]]:
        counters = self._bodies(node, [body for _, body in node.branches])
        ways = zip(words.branches, node.branches, counters, strict=True)
        for k, (line, (condition, _), counter) in enumerate(ways):
            yield line, counter, f"{'ELSIF' if k else 'IF'} {expression_text(condition)}"
        if node.otherwise:
            yield words.otherwise, self._plan.body(node, node.otherwise), "ELSE"
        else:
            yield words.end, self._plan.empty[id(node)], "no condition of the IF was TRUE (no ELSE)"

    def _ways_of_case(self, node: t.Case) -> Iterator[tuple[int, int, str]]:
        words = self._words_of(node)
        kind = node.selector.type
        members = (
            set(kind.values or range(len(kind.members))) if isinstance(kind, EnumType) else {0}
        )
        counters = self._bodies(node, [body for _, body in node.branches])
        for (labels, body), counter in zip(node.branches, counters, strict=True):
            shown = []
            for low, high in labels:
                members = {value for value in members if not low <= value <= high}
                shown.append("..".join(label_text(kind, end) for end in dict.fromkeys((low, high))))
            line = body[0].at.line if body else node.at.line
            yield line, counter, f"CASE {', '.join(shown)}"
        if node.otherwise:
            yield words.otherwise, self._plan.body(node, node.otherwise), "CASE ELSE"
        elif members or not isinstance(kind, EnumType):
            yield words.end, self._plan.empty[id(node)], "no label of the CASE fits"

    def _ways_of_loop(
        self, node: t.While | t.For, before: t.Statement | None
    ) -> Iterator[tuple[int, int, str]]:
        line, name = node.at.line, "FOR" if isinstance(node, t.For) else "WHILE"
        yield line, self._plan.body(node, node.body), f"{name} with a round"
        begins = _counts(node) if isinstance(node, t.For) else _begins(node.condition, before)
        if not begins:
            yield line, self._plan.empty[id(node)], f"{name} without a round"


def _counts(node: t.For) -> bool:
    """Return whether the constants of a FOR ensure at least one round."""
    start, end, step = node.start, node.end, node.step
    if not all(isinstance(one, t.Constant) for one in (start, end, step)):
        return False
    assert isinstance(start, t.Constant)
    assert isinstance(end, t.Constant)
    assert isinstance(step, t.Constant)
    low, high = int(start.value), int(end.value)
    return low <= high if int(step.value) > 0 else low >= high


def _begins(condition: t.Expression, before: t.Statement | None) -> bool:
    """Return whether the statement before a WHILE makes its condition TRUE, by constants alone."""
    if not isinstance(before, t.Assign) or not isinstance(condition, t.Binary):
        return False
    counter, start, end = before.target, before.value, condition.right
    return (
        isinstance(counter, t.Use)
        and isinstance(condition.left, t.Use)
        and counter.symbol is condition.left.symbol
        and isinstance(start, t.Constant)
        and isinstance(end, t.Constant)
        and condition.op in _COMPARE
        and bool(_COMPARE[condition.op](start.value, end.value))
    )
