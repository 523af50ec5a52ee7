"""The operators `__POUNAME()` and `__POSITION()`: the name and the position of a POU as a text.

Both are operators of CODESYS and TwinCAT. Their results are known when a source is read, so each
call becomes a literal. Inside a GET or SET, the text is the names of block, property and accessor:
`Axis.Speed.Get`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from lark import Token

from structured_text.language.constructs import Use
from structured_text.language.source import title_of
from structured_text.language.syntax import Position

__all__ = ["with_names"]

_OPERATORS = ("__POUNAME", "__POSITION")
_OUTER = frozenset(
    ("FUNCTION", "FUNCTION_BLOCK", "PROGRAM", "INTERFACE", "METHOD", "PROPERTY", "ACTION", "CLASS")
)
_INNER = ("METHOD", "PROPERTY", "ACTION")
_ACCESSORS = {"GET": "Get", "SET": "Set"}
_HEADS = frozenset(("WORD", "FINAL", "ABSTRACT"))


def with_names(found: list[Token], file: Path, uses: list[Use]) -> list[Token]:
    """Replace the calls of both operators in the tokens of a source by literals.

    `uses` receives a note for each call. A list of global variables is named after its file.
    """
    if not any(token.type == "IDENT" and token.upper() in _OPERATORS for token in found):
        return found
    return list(_replaced(found, file, uses))


def _replaced(found: list[Token], file: Path, uses: list[Use]) -> Iterator[Token]:
    outer, inner, accessor, declares = title_of(file), "", "", False
    at = 0
    while at < len(found):
        token = found[at]
        kind = token.type
        if kind in _OUTER:
            name = _name_behind(found[at + 1 :])
            inner = name if kind in _INNER else ""
            accessor = ""
            outer = outer if kind in _INNER else name
        elif kind == "STRUCT" and at >= 2 and found[at - 1].type == "COLON":
            outer, inner, accessor = str(found[at - 2]), "", ""
        elif kind in _ACCESSORS:
            accessor = _ACCESSORS[kind]
        elif kind in ("END_METHOD", "END_PROPERTY", "END_ACTION"):
            inner = accessor = ""
        elif kind in ("END_GET", "END_SET"):
            accessor = ""
        declares = (
            kind.startswith("VAR")
            or kind == "STRUCT"
            or (declares and kind not in ("END_VAR", "END_STRUCT"))
        )
        called = [one.type for one in found[at + 1 : at + 3]] == ["LPAR", "RPAR"]
        if kind == "IDENT" and called and token.upper() in _OPERATORS:
            text = ".".join(part for part in (outer, inner, accessor) if part)
            if token.upper() == "__POSITION":
                text = f"Line {token.line} (Decl)"
                if not declares:
                    text = f"Line {token.line}, Column {token.column} (Impl)"
            place = Position(token.line or 1, token.column or 1)
            uses.append(Use("the name of a POU as a text", file, place))
            yield Token.new_borrow_pos("STRING", f"'{text}'", token)
            at += 3
            continue
        yield token
        at += 1


def _name_behind(rest: Iterable[Token]) -> str:
    """Return the name of the element that a word such as METHOD begins, behind the access words."""
    return next((str(token) for token in rest if token.type not in _HEADS), "")
