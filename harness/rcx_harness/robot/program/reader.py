"""The reader of robot programs. It translates lines to a Program, or reports all errors."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

from rcx_harness.robot.program.blocks import Line, link
from rcx_harness.robot.program.syntax import Node, Program
from structured_text.errors import InputError

__all__ = ["read_expression", "read_file", "read_lines", "read_program", "text_of"]

_LABEL = re.compile(r"(\*[A-Z][A-Z0-9_]*)\s*:?\s*")
_REMARK = re.compile(r"REM\b.*")
#: The pattern of a text in quotes, or of a character that ends a statement or begins a comment.
_PIECES = re.compile(r'"[^"]*"|[:\']')
_LONGEST = 255
#: The control characters that a text file cannot contain: all but tab, line feed, form feed and
#: return.
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0e-\x1f]")


def read_file(path: Path) -> Program:
    """Read a program file (.PGM).

    Raises:
        InputError: the file is not a text, or has an error. Only the first error is raised;
            `read_program` returns all errors.
    """
    program, errors = read_program(text_of(path), path)
    if errors:
        raise errors[0]
    assert program is not None
    return program


def text_of(path: Path) -> str:
    """Return the text of a file in UTF-8, or else in Windows-1252.

    Raises:
        InputError: the file cannot be read, or it is not a text.
    """
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read it: {error.strerror}", file=path) from error
    raw = raw.rstrip(b"\x1a")  # the character that ends a file that was received over a serial line
    if control := _CONTROL.search(raw):
        line = raw[: control.start()].count(b"\n") + 1
        raise InputError(
            f"this is not a text: it contains the byte {control[0][0]:02X}",
            file=path,
            line=line,
            hint="save the program as text in UTF-8",
        )
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")


def read_program(
    text: str, path: Path | None = None, *, first: int = 1, integers: bool = False
) -> tuple[Program | None, list[InputError]]:
    """Read a program.

    Args:
        text: The lines of the program.
        path: Path of the file, for error messages.
        first: Number of the first line in the file.
        integers: Whether variables without a type character are integers.

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
    """Read a program from a list of lines; see `read_program` for arguments and result."""
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


def read_expression(text: str) -> Node:
    """Parse an expression such as `N% > 3 AND SI(20) = 1`, and return its node.

    Raises:
        InputError: the text is not an expression.
    """
    try:
        node = _statement(f"WAIT {_upper(text).strip()}")
    except InputError:
        node = Node("label")
    if node.kind != "wait" or node.args[1] is not None:
        hint = "write it as N% > 3 AND SI(20) = 1"
        raise InputError(f"{text!r} is not an expression of the robot language", hint=hint)
    expression: Node = node.args[0]
    return expression


def _placed(error: InputError, path: Path | None, line: int) -> InputError:
    return InputError(error.message, file=path, line=line, hint=error.hint)


def _statements(text: str) -> Iterator[tuple[str, Node | None]]:
    """Yield label and statement of each part of a line; without a label, the label is empty."""
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

    The colon of a label does not end a statement, so a label stays with its statement.
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
    # Import the parser here, because a controller without programs does not need it.
    from rcx_harness.robot.program.parsing import parse

    return parse(text)
