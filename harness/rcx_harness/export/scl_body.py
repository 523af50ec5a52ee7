"""Statements in Siemens SCL: the source's own text with its names marked as SCL wants them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from lark import Token

from rcx_harness.engine.frontend.lexer import tokens

__all__ = ["Names", "quoted", "scl_body"]

#: Functions whose parameters SCL wants by name.
_NAMED = {"SHL": ("IN", "N"), "SHR": ("IN", "N"), "ROL": ("IN", "N"), "ROR": ("IN", "N")}

#: Functions with one parameter, whose name SCL does not share.
_UNNAMED = ("LEN",)

#: Words of SCL that are names in IEC 61131-3.
_RESERVED = frozenset(
    (
        *("AUTHOR", "BEGIN", "BLOCK", "BLOCK_DB", "BLOCK_FB", "BLOCK_FC", "CHAR", "CONTINUE"),
        *("COUNTER", "DATA_BLOCK", "DATE", "DT", "DTL", "END", "FAMILY", "GOTO"),
        *("KNOW_HOW_PROTECT", "LABEL", "LDT", "LTIME", "LTOD", "NAME", "NIL", "OK"),
        *("ORGANIZATION_BLOCK", "POINTER", "REF", "REF_TO", "REGION", "S5TIME", "TIMER"),
        *("TITLE", "TOD", "VARIANT", "VERSION", "VOID", "WCHAR", "WSTRING"),
    )
)


@dataclass(frozen=True)
class Names:
    """What names mean in a POU, in upper case.

    Attributes:
        local: Variables, the function's own name, and members of enumerations: `#Name`.
        functions: Functions of the sources: `"Name"`; with their parameters that have a default.
    """

    local: Collection[str]
    functions: Mapping[str, Mapping[str, str]]


@dataclass
class _Call:
    """An open parenthesis: of a call of `function`, or of nothing (`""`)."""

    function: str
    argument: int = 0
    given: tuple[str, ...] = ()
    empty: bool = True


def scl_body(text: str, names: Names) -> str:
    """Rewrite statements; comments and line breaks stay.

    `Name` becomes `#Name`, a function `"Name"`; left-out arguments of functions, for which SCL has
    no defaults, are written out; shifts name their parameters.
    """
    found = list(tokens(text, Path("body")))
    return "".join(_pieces(text, found, names))


def quoted(name: str) -> str:
    """A name, in quotes if it is a word of SCL."""
    return f'"{name}"' if name.upper() in _RESERVED else name


def _pieces(text: str, found: list[Token], names: Names) -> Iterator[str]:
    calls: list[_Call] = []
    end, skip = 0, 0
    for index, token in enumerate(found):
        start = token.start_pos or 0
        gap, end = text[end:start], start + len(token)
        if skip:
            skip -= 1
            end = found[index + 1].start_pos or 0
            continue
        yield gap
        before = str(found[index - 1].type) if index else ""
        after = str(found[index + 1].type) if index + 1 < len(found) else ""
        inside = calls[-1] if calls else _Call("")
        if token.type == "LPAR":
            function = str(found[index - 1]).upper() if before == "IDENT" else ""
            calls.append(_Call(function))
            yield "("
            yield from _parameter(calls[-1], found, index)
            skip = _skipped(calls[-1], found, index)
        elif token.type == "RPAR":
            yield from _defaults(calls.pop(), names)
            yield ")"
        elif token.type == "COMMA" and inside.function and before != "LSQB":
            inside.argument += 1
            yield ","
            yield from (f" {part.rstrip()}" for part in _parameter(inside, found, index))
        elif token.type in ("IDENT", "LABEL"):
            if calls and after in ("ASSIGN", "SENDTO"):
                inside.given += (token.upper(),)
                yield quoted(str(token))
            else:
                yield _name(token, before, after, names)
        else:
            yield str(token)
    yield text[end:]


def _name(token: Token, before: str, after: str, names: Names) -> str:
    if before == "DOT":
        return quoted(str(token))
    if after == "LPAR" and token.upper() in names.functions:
        return f'"{token}"'
    return f"#{quoted(str(token))}" if token.upper() in names.local else str(token)


def _parameter(call: _Call, found: list[Token], index: int) -> Iterator[str]:
    """The name before a positional argument of a function that wants it."""
    parameters = _NAMED.get(call.function, ())
    if call.argument < len(parameters) and found[index + 2].type != "ASSIGN":
        yield f"{parameters[call.argument]} := "


def _skipped(call: _Call, found: list[Token], index: int) -> int:
    """How many tokens name a parameter that is not to be named: name and `:=`."""
    return 2 if call.function in _UNNAMED and found[index + 2].type == "ASSIGN" else 0


def _defaults(call: _Call, names: Names) -> Iterator[str]:
    for name, value in names.functions.get(call.function, {}).items():
        if name.upper() not in call.given:
            yield f", {name} := {value}"
