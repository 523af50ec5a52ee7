"""What there is to cover in a file of the library, with lines and as text."""

from __future__ import annotations

import operator
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from rcx_harness.engine.builtin.coverage import Decision, Plan
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.lexer import tokens
from rcx_harness.engine.frontend.scalars import ANY_CHARS, ANY_DURATION
from rcx_harness.engine.types import ElementaryType, EnumType, ReferenceType

__all__ = ["Branch", "Listing", "Point", "listing", "text_of"]

_OPENS = ("IF", "CASE", "WHILE", "FOR", "REPEAT")
_REASON = re.compile(r"\(\*\s*unreachable:\s*(.*?)\s*\*\)", re.DOTALL)
_COMPARE = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


@dataclass(frozen=True)
class Point:
    """A statement: its line and its counter."""

    line: int
    counter: int


@dataclass(frozen=True)
class Branch:
    """One way out of an IF, CASE or WHILE.

    `fork` numbers these; `line` is where the way begins, or ends where it has no statements.
    """

    line: int
    counter: int
    fork: int
    text: str


@dataclass
class Listing:
    """Everything that counts in one POU.

    Attributes:
        file: Its source.
        name: Its name.
        line: Where it begins.
        plan: Its numbers in the engine.
        statements: In the order of the source.
        branches: In the order of the source, those left out that the source itself excludes: a
            CASE of an enumeration whose members are all labels, and a WHILE whose condition is
            TRUE for the constant that its counter was given in the statement before it.
        decisions: Line and decision.
        reasons: Why a line is not reachable, by its number.
    """

    file: Path
    name: str
    line: int
    plan: Plan
    statements: list[Point] = field(default_factory=list)
    branches: list[Branch] = field(default_factory=list)
    decisions: list[tuple[int, Decision]] = field(default_factory=list)
    reasons: dict[int, str] = field(default_factory=dict)


@dataclass
class _Words:
    """Lines of the words of one IF, CASE or WHILE."""

    branches: list[int]
    otherwise: int = 0
    end: int = 0


def listing(pou: t.Pou) -> Listing:
    """List what there is to cover in a POU."""
    file = Path(pou.file)
    text = file.read_text(encoding="utf-8")
    first = next(
        k for k, line in enumerate(text.splitlines(), 1) if re.match(rf"\s*{pou.kind}\b", line)
    )
    found = Listing(file, pou.name, first, Plan.of(pou), reasons=_reasons(text))
    _Lister(found, _words(text, file)).statements(pou.body)
    return found


def _reasons(text: str) -> dict[int, str]:
    """Reasons by the line they are for: their own, or the next one with code."""
    found = {}
    for comment in _REASON.finditer(text):
        before = text[: comment.start()].rpartition("\n")[2].strip()
        after = text[comment.end() :]
        line = text.count("\n", 0, comment.end()) + 1
        if not before:
            line += after[: len(after) - len(after.lstrip())].count("\n")
        found[line] = " ".join(comment[1].split())
    return found


def _words(text: str, file: Path) -> dict[tuple[int, int], _Words]:
    """Where the parts of each IF, CASE or loop are, by the position of its first word."""
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
    """Walks through a body in the order in which the plan numbers it."""

    def __init__(self, found: Listing, words: dict[tuple[int, int], _Words]) -> None:
        self._found = found
        self._words = words
        self._forks = 0
        found.decisions += [(decision.line, decision) for decision in found.plan.decisions]

    def statements(self, body: tuple[t.Statement, ...]) -> None:
        """List the statements of a body and what is in them."""
        before: t.Statement | None = None
        for node in body:
            self._found.statements.append(Point(node.at.line, self._found.plan.run[id(node)]))
            if isinstance(node, t.If):
                self._if(node)
            elif isinstance(node, t.Case):
                self._case(node)
            elif isinstance(node, t.While):
                self._while(node, before)
            elif isinstance(node, (t.For, t.Repeat)):
                self.statements(node.body)
            before = node

    def _branches(self, ways: Iterator[tuple[int, int, str]]) -> None:
        fork = self._forks
        self._forks += 1
        self._found.branches += [Branch(line, n, fork, text) for line, n, text in ways]

    def _run(self, body: tuple[t.Statement, ...]) -> int:
        return self._found.plan.run[id(body[0])]

    def _if(self, node: t.If) -> None:
        words = self._words[node.at.line, node.at.column]
        self._branches(self._ways_of_if(node, words))
        plan = self._found.plan
        for line, (condition, body) in zip(words.branches, node.branches, strict=True):
            number = plan.number.get(id(condition))
            if number is not None:
                self._found.decisions[number] = line, plan.decisions[number]
            self.statements(body)
        self.statements(node.otherwise)

    def _ways_of_if(self, node: t.If, words: _Words) -> Iterator[tuple[int, int, str]]:
        for k, (line, (condition, body)) in enumerate(
            zip(words.branches, node.branches, strict=True)
        ):
            yield line, self._run(body), f"{'ELSIF' if k else 'IF'} {text_of(condition)}"
        if node.otherwise:
            yield words.otherwise, self._run(node.otherwise), "ELSE"
        else:
            yield words.end, self._found.plan.empty[id(node)], "none of the IF (no ELSE)"

    def _case(self, node: t.Case) -> None:
        words = self._words[node.at.line, node.at.column]
        self._branches(self._ways_of_case(node, words))
        for _, body in node.branches:
            self.statements(body)
        self.statements(node.otherwise)

    def _ways_of_case(self, node: t.Case, words: _Words) -> Iterator[tuple[int, int, str]]:
        kind = node.selector.type
        labelled: set[int] = set()
        for labels, body in node.branches:
            shown = []
            for low, high in labels:
                labelled |= set(range(low, high + 1))
                ends = [
                    kind.members[end] if isinstance(kind, EnumType) else str(end)
                    for end in dict.fromkeys((low, high))
                ]
                shown.append("..".join(ends))
            yield body[0].at.line, self._run(body), f"CASE {', '.join(shown)}"
        if node.otherwise:
            yield words.otherwise, self._run(node.otherwise), "CASE ELSE"
        elif not isinstance(kind, EnumType) or len(labelled) < len(kind.members):
            yield words.end, self._found.plan.empty[id(node)], "CASE without a label that fits"

    def _while(self, node: t.While, before: t.Statement | None) -> None:
        self._branches(self._ways_of_while(node, before))
        self.statements(node.body)

    def _ways_of_while(
        self, node: t.While, before: t.Statement | None
    ) -> Iterator[tuple[int, int, str]]:
        yield node.at.line, self._run(node.body), "WHILE with a round"
        if not _begins(node.condition, before):
            yield node.at.line, self._found.plan.empty[id(node)], "WHILE without a round"


def _begins(condition: t.Expression, before: t.Statement | None) -> bool:
    """Whether the statement before a WHILE makes its condition TRUE, by constants alone."""
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


_STRENGTH = {
    "OR": 1,
    "XOR": 2,
    "AND": 3,
    **dict.fromkeys(("=", "<>", "<", ">", "<=", ">="), 4),
    **dict.fromkeys(("+", "-"), 5),
    **dict.fromkeys(("*", "/", "MOD"), 6),
    "**": 8,
}
_UNARY = 7
_BITS = {"BYTE": 2, "WORD": 4, "DWORD": 8, "LWORD": 16}


def text_of(node: t.Expression, within: int = 0) -> str:
    """An expression as one would write it, in parentheses if its place binds more strongly.

    Args:
        node: The expression.
        within: How strongly the operator binds whose operand it is.
    """
    if isinstance(node, t.Constant):
        return _constant(node)
    if isinstance(node, t.Use):
        return node.symbol.name
    if isinstance(node, t.Member):
        return f"{text_of(node.base)}.{node.name}"
    if isinstance(node, t.Index):
        return f"{text_of(node.base)}[{', '.join(map(text_of, node.indices))}]"
    if isinstance(node, t.Unary):
        word = "NOT " if node.op == "NOT" else node.op
        return f"{word}{text_of(node.operand, _UNARY)}"
    if isinstance(node, t.Binary):
        strength = _STRENGTH[node.op]
        left, right = text_of(node.left, strength), text_of(node.right, strength + 1)
        text = f"{left} {node.op} {right}"
        return f"({text})" if strength < within else text
    if not isinstance(node, (t.CallFunction, t.Standard)):
        return _pointing(node)
    name = node.function if isinstance(node, t.CallFunction) else node.name
    given = [text_of(item) for item in node.arguments if item is not None]
    return f"{name}({', '.join(given)})"


def _pointing(node: t.Expression) -> str:
    """The text of a method's call, a pointer or a reference."""
    if isinstance(node, t.This):
        return "THIS^"
    if isinstance(node, t.Null):
        return "0"
    if isinstance(node, t.Same):
        return f"{text_of(node.left)} {node.op} {text_of(node.right)}"
    if isinstance(node, t.Valid):
        return f"__ISVALIDREF({text_of(node.reference)})"
    if isinstance(node, t.Recast):
        return text_of(node.base)
    if isinstance(node, t.Address):
        return f"ADR({text_of(node.variable)})"
    if isinstance(node, t.Offset):
        return f"{text_of(node.base)} {'+' if node.sign > 0 else '-'} {text_of(node.bytes)}"
    if isinstance(node, t.Deref):
        if node.offset is not None:
            return f"{text_of(node.base)}[{text_of(node.offset)}]"
        kind = node.base.type
        reference = isinstance(kind, ReferenceType) and kind.kind == "REFERENCE"
        return text_of(node.base) if reference else f"{text_of(node.base)}^"
    assert isinstance(node, t.CallMethod)
    _, name, *accessor = node.method.name.split(".")
    called = f"{'SUPER^' if node.final else text_of(node.instance)}.{name}"
    if accessor:
        return called
    given = [text_of(item) for item in node.arguments if item is not None]
    return f"{called}({', '.join(given)})"


def _constant(node: t.Constant) -> str:
    kind, value = node.type, node.value
    if isinstance(kind, EnumType):
        return kind.members[int(value)]
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name in _BITS:
        return f"{name}#16#{int(value):0{_BITS[name]}X}"
    if name == "BOOL":
        return "TRUE" if value else "FALSE"
    if name in ANY_DURATION:
        prefix = "T" if name == "TIME" else "LTIME"
        return f"{prefix}#{int(value) // 1_000_000}ms"
    return f"'{value}'" if name in ANY_CHARS else str(value)
