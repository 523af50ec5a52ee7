"""The parser for one statement of a robot program. Each rule of grammar.lark gives a node."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from lark import Lark, Token, Transformer, Tree, UnexpectedInput, UnexpectedToken

from rcx_harness.robot.ports import Port, port
from rcx_harness.robot.program.syntax import Node
from rcx_harness.robot.program.words import explain
from structured_text.errors import InputError

__all__ = ["parse"]


#: A pattern for the parts of a statement. Texts, names, ports with their numbers, rows of numbers,
#: and hexadecimal and binary numbers stay unchanged. Marks replace labels after GOTO, GOSUB, THEN
#: and ELSE. Marks also replace all other numbers, including those of points, shifts and hands.
_PARTS = re.compile(
    r"""(?P<word>\b(?:GOTO|GOSUB|THEN|ELSE)\s+)(?P<label>\*[A-Z][A-Z0-9_]*)
    | "[^"]*" | (?:D[IO]|MO|LO|TO|S[IO][WD]?)\d*\s*\([^()]*\) | &[HB][0-9A-F]+
    | \d[\d.]*(?:\s+[+-]?\d[\d.]*)+ | (?![PSH]\d+(?![A-Z0-9_%!$(]))[A-Z_][A-Z0-9_]*[%!$]?
    | \[\s*\d+\s*\]
    | (?<![\w.])(?P<kind>[PSH]?)(?P<number>\d+)(?![\w.%!$(])""",
    re.VERBOSE,
)
#: The first number that serves as a mark, and the beginning of labels that serve as marks. No
#: program contains such numbers and labels.
_FIRST_MARK, _LABEL_MARK = 900_000_001, "*MARK_OF_A_LABEL_"


def parse(text: str) -> Node:
    """Return the node of a statement in upper case.

    Programs have many statements that differ only in numbers and labels, so these are parsed once.

    Raises:
        InputError: the statement cannot be read.
    """
    values: list[int | str] = []

    def mark(part: re.Match[str]) -> str:
        place = len(values)
        if part["label"] is not None:
            values.append(part["label"])
            return f"{part['word']}{_LABEL_MARK}{place}"
        if part["number"] is not None:
            values.append(int(part["number"]))
            return f"{part['kind']}{_FIRST_MARK + place}"
        return part[0]

    shape = _PARTS.sub(mark, text)
    node = _shape(shape, len(values)) if values else None
    return _parsed(text) if node is None else _filled(node, values)


@cache
def _shape(text: str, count: int) -> Node | None:
    """Parse a statement with marks; return None if its node does not contain each mark once."""
    try:
        node = _parsed(text)
    except InputError:
        return None
    parts = [part for one in node.walk() for part in one.args]
    marks = [place for part in parts if (place := _place(part)) is not None]
    return node if sorted(marks) == list(range(count)) else None


def _place(part: object) -> int | None:
    """Return the number of a mark; None if the part of the node is not a mark."""
    if isinstance(part, int) and part >= _FIRST_MARK:
        return part - _FIRST_MARK
    if isinstance(part, str) and part.startswith(_LABEL_MARK):
        return int(part.removeprefix(_LABEL_MARK))
    return None


def _filled(node: Node, values: Sequence[int | str]) -> Node:
    """Return a copy of a node in which the marks are replaced by their values."""
    args: list[Any] = []
    for part in node.args:
        place = None if isinstance(part, Node) else _place(part)
        if place is not None:
            part = values[place]
        args.append(_filled(part, values) if isinstance(part, Node) else part)
    return Node(node.kind, tuple(args))


def _parsed(text: str) -> Node:
    """Parse one statement.

    Raises:
        InputError: the statement cannot be read.
    """
    try:
        node = _parser().parse(text)
    except UnexpectedInput as error:
        raise explain(text, error.column, _missing(error)) from None
    assert isinstance(node, Node)
    return node


def _missing(error: UnexpectedInput) -> str:
    """Return a text for the element that is missing at the end of a statement; else empty."""
    if not isinstance(error, UnexpectedToken) or error.token.type != "$END":
        return ""
    possible = error.accepts or set()
    if len(possible) == 1:
        (name,) = possible
        return _MISSING.get(name, "something")
    return next((text for name, text in _MISSING.items() if name in possible), "something")


#: Maps a terminal that the parser expects to the text for the missing element. The message uses the
#: first match.
_MISSING = {
    "NUMBER": "a value",
    "POINT": "a target",
    "RPAR": "')'",
    "RSQB": "']'",
    "RBRACE": "'}'",
    "LABEL": "a label such as *LOOP",
    "EQUAL": "'='",
    "TASK": "a task such as T2",
    "THEN": "THEN",
    "TO": "TO",
    "NAME": "a name",
    "COMMA": "','",
}


@cache
def _parser() -> Lark:
    grammar = files(__package__).joinpath("grammar.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", maybe_placeholders=True, transformer=_Builder())


class _Builder(Transformer[Token, Node]):
    """Translates each rule of grammar.lark to a Node with the name of the rule."""

    def __default__(self, data: Any, children: list[Any], meta: Any) -> Any:
        if data.startswith("_"):  # a repetition, whose children belong to its parent rule
            return Tree(data, children)
        return Node(str(data), tuple(_plain(child) for child in children))

    def start(self, children: list[Any]) -> Node:
        (statement,) = children
        return statement if isinstance(statement, Node) else Node("label")

    def number(self, children: list[Token]) -> Node:
        return Node("number", (_number(children[0]),))

    def text(self, children: list[Token]) -> Node:
        return Node("text", (children[0][1:-1],))

    def robot(self, children: list[Any]) -> int:
        robot = int(children[0]) if children[0] else 1
        if not 1 <= robot <= 4:
            raise InputError(f"there is no robot {robot}", hint="use 1 to 4")
        return robot

    def param(self, children: list[Token]) -> str:
        return str(children[0])

    def point(self, children: list[Any]) -> Node:
        return _numbered("point", children)

    def shift(self, children: list[Any]) -> Node:
        return _numbered("shift", children)

    def hand(self, children: list[Any]) -> Node:
        return _numbered("hand", children)

    def data(self, children: list[Any]) -> Node:
        texts = tuple(str(children[0]).split())
        mm = any("." in text for text in texts)
        return Node("data", (tuple(float(text) for text in texts), mm, bool(children[1])))

    def port(self, children: list[Any]) -> Node:
        kind, *numbers = children
        return Node("port", _ports(str(kind), [str(one) for one in numbers if one is not None]))

    def plain_port(self, children: list[Token]) -> Node:
        return Node("port", (port(str(children[0])),))


def _plain(child: Any) -> Any:
    """Convert a token of the parser to a text or a number; return any other value unchanged."""
    if not isinstance(child, Token):
        return child
    return _number(child) if child.type == "NUMBER" else str(child)


def _numbered(kind: str, children: list[Any]) -> Node:
    (number,) = children
    if isinstance(number, Token):
        return Node(kind, (Node("number", (int(number[1:]),)),))
    return Node(kind, (number,))


def _number(text: str) -> int | float:
    if text.startswith("&"):
        return int(text[2:], 16 if text[1] == "H" else 2)
    text = text.rstrip("!")
    return int(text) if text.isdecimal() else float(text)


def _ports(kind: str, numbers: Sequence[str]) -> tuple[Port, ...]:
    """Return the ports of a text such as `DO(20)` or `DO2(3,1)`; the first port is the MSB."""
    name = kind.rstrip("0123456789")
    octet = kind[len(name) :]
    if name[-1] in "WD":
        if octet or len(numbers) != 1:
            raise InputError(f"{kind} needs one number in brackets", hint=f"write {name}(2)")
        return (port(f"{name}({numbers[0]})"),)
    if not octet:
        if not numbers:
            raise InputError(f"{kind}() names no port", hint=f"write {name}(20) or {name}2()")
        return tuple(port(f"{name}({number})") for number in numbers)
    if not numbers:
        return (port(f"{kind}()"),)
    return tuple(port(f"{name}({octet}{number})") for number in numbers)
