"""The reader of robot programs: lines of text to a Program, with all errors at once."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from lark import Lark, Token, Transformer, Tree, UnexpectedInput

from rcx_harness.robot.ports import Port, port
from rcx_harness.robot.program.blocks import Line, link
from rcx_harness.robot.program.syntax import Node, Program
from rcx_harness.robot.program.words import explain
from structured_text.errors import InputError

__all__ = ["read_file", "read_lines", "read_program", "text_of"]

_LABEL = re.compile(r"(\*[A-Z][A-Z0-9_]*)\s*:?\s*")
_REMARK = re.compile(r"REM\b.*")
#: A text in quotes, else the character that ends a statement or begins a comment.
_PIECES = re.compile(r'"[^"]*"|[:\']')
_LONGEST = 255


def read_file(path: Path) -> Program:
    """Read a program file (.PGM).

    Raises:
        InputError: the file is no text, or its first error; see `read_program` for all errors.
    """
    program, errors = read_program(text_of(path), path)
    if errors:
        raise errors[0]
    assert program is not None
    return program


def text_of(path: Path) -> str:
    """Return the text of a file in UTF-8, or else in Windows-1252.

    Raises:
        InputError: the file cannot be read, or it is no text.
    """
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read it: {error.strerror}", file=path) from error
    if b"\0" in raw:
        raise InputError("it is no text: it contains a zero byte", file=path)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")


def read_program(
    text: str, path: Path | None = None, *, first: int = 1, integers: bool = False
) -> tuple[Program | None, list[InputError]]:
    """Read a program.

    Args:
        text: Its lines.
        path: The file, for messages.
        first: Number of the first line in the file.
        integers: Variables without a type character are integers.

    Returns:
        The program, or None if it has errors; and all errors in the order of their lines.
    """
    return read_lines(text.splitlines(), path, first=first, integers=integers)


def read_lines(
    texts: Sequence[str],
    path: Path | None = None,
    *,
    first: int = 1,
    integers: bool = False,
    shared: bool = False,
) -> tuple[Program | None, list[InputError]]:
    """Read a program from its lines; see `read_program` and Program."""
    errors: list[InputError] = []
    lines: list[Line] = []
    for number, text in enumerate(texts, first):
        try:
            lines += [Line(number, *part) for part in _statements(text)]
        except InputError as error:
            errors.append(_placed(error, path, number))
    program, linked = link(lines, tuple(texts), integers=integers, shared=shared)
    errors += [_placed(error, path, number) for number, error in linked]
    errors.sort(key=lambda error: error.line or 0)
    return (None if errors else program), errors


def _placed(error: InputError, path: Path | None, line: int) -> InputError:
    return InputError(error.message, file=path, line=line, hint=error.hint)


def _statements(text: str) -> Iterator[tuple[str, Node | None]]:
    """Yield label (or an empty text) and statement of each part of a line."""
    if len(text) > _LONGEST:
        raise InputError(f"the line has {len(text)} characters", hint=f"use at most {_LONGEST}")
    parts = _split(text)
    for number, part in enumerate(parts, 1):
        label = ""
        if match := _LABEL.match(part):
            label, part = match[1], part[match.end() :]
        if _REMARK.fullmatch(part):
            part = ""
        yield label, _statement(part) if part else None
        if part.startswith("IF ") and not part.endswith("THEN") and number < len(parts):
            raise InputError(
                "a statement follows an IF on the same line; it could belong to the IF or not",
                hint="write IF ... THEN, the statements, and ENDIF on lines of their own",
            )


def _split(text: str) -> list[str]:
    """Return the statements of a line in upper case, without the comment.

    The colon of a label does not end a statement, so that label and statement stay together.
    """
    parts, begin, upper = [], 0, _upper(text).strip()
    label = _LABEL.match(upper)
    at = label.end() if label else 0
    for match in _PIECES.finditer(upper, at):
        if match[0] == "'":
            upper = upper[: match.start()]
            break
        if match[0] == ":" and not _REMARK.match(upper[max(begin, at) :].lstrip()):
            parts.append(upper[begin : match.start()].strip())
            begin = match.end()
    return [*parts, upper[begin:].strip()]


def _upper(text: str) -> str:
    """Return a line in upper case, except for its texts in quotes."""
    pieces = re.split(r'("[^"]*")', text.expandtabs())
    return "".join(part if part.startswith('"') else part.upper() for part in pieces)


@cache
def _statement(text: str) -> Node:
    """Parse one statement; equal statements are parsed once."""
    try:
        node = _parser().parse(text)
    except UnexpectedInput as error:
        raise explain(text, error) from None
    assert isinstance(node, Node)
    return node


@cache
def _parser() -> Lark:
    grammar = files(__package__).joinpath("grammar.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", maybe_placeholders=True, transformer=_Builder())


class _Builder(Transformer[Token, Node]):
    """The rules of grammar.lark: each becomes a Node with the name of the rule."""

    def __default__(self, data: Any, children: list[Any], meta: Any) -> Any:
        if data.startswith("_"):  # a repetition, whose children belong to the rule around it
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
            raise InputError(f"there is no robot {robot}", hint="robots are 1 to 4")
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
    """Return a token as a plain text or number, everything else as it is."""
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
    """Return the ports of `DO(20)`, `DO(23,21)`, `DO2()` and `DO2(3,1)`; the first is the MSB."""
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
