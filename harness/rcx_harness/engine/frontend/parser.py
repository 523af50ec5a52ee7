"""From one source file to its syntax tree."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from lark import Lark, Token
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.builder import Builder
from rcx_harness.engine.frontend.lexer import KEYWORDS, PUNCTUATION, tokens
from rcx_harness.errors import InputError

__all__ = ["parse", "parse_text"]

_SPELLING = {name: f"'{text}'" for text, name in PUNCTUATION.items()}
_ENDS = ("END_IF", "ELSE", "ELSIF", "END_CASE", "END_WHILE", "END_FOR", "UNTIL")
_LITERALS = ("INTEGER", "REALNUM", "STRING", "TYPED")
_INSTRUCTION_LIST = frozenset(
    ["LD", "LDN", "ST", "STN", "ANDN", "ORN", "XORN", "CAL", "CALC", "RET", "RETC"]
)


class _Tokens(Lexer):
    """Hands the tokens of `lexer.tokens` to lark."""

    def __init__(self, lexer_conf: Any) -> None:
        del lexer_conf

    def lex(self, lexer_state: Any, parser_state: Any = None) -> Iterator[Token]:
        del parser_state
        text, file = lexer_state
        return tokens(text, file)


@lru_cache(maxsize=1)
def _parser() -> Lark:
    grammar = files(__package__).joinpath("grammar.lark").read_text(encoding="utf-8")
    names = sorted({*KEYWORDS, *PUNCTUATION.values(), *_LITERALS, "IDENT", "LABEL", "DIRECT"})
    declared = f"\n%declare {' '.join(names)}\n"
    return Lark(
        grammar + declared,
        parser="lalr",
        lexer=_Tokens,
        transformer=Builder(),
        maybe_placeholders=True,
    )


def parse(file: Path) -> s.Source:
    """Read and parse one file.

    Raises:
        InputError: the file cannot be read, is not UTF-8, or has a syntax error.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read the file: {error.strerror}", file=file) from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"byte {error.start} is not UTF-8", file=file, hint="save the file as UTF-8"
        ) from None
    return parse_text(text, file)


@lru_cache(maxsize=1024)
def parse_text(text: str, file: Path) -> s.Source:
    """Parse a source; the same text of the same file is parsed once per process.

    Raises:
        InputError: a syntax error.
    """
    try:
        declarations: list[Any] = _parser().parse((text, file))  # type: ignore[assignment]
    except UnexpectedToken as error:
        raise _syntax_error(error, text, file) from None
    return s.Source(file, tuple(declarations))


def _syntax_error(error: UnexpectedToken, text: str, file: Path) -> InputError:
    token = error.token
    expected = set(error.accepts or error.expected)
    before = _before(token, text, file)
    if before.upper() in _INSTRUCTION_LIST and token.type != "ASSIGN":
        return _at("Instruction List is not supported", before, file, "write Structured Text")
    if "SEMICOLON" in expected:
        return _at("a ';' is missing", before, file, f"write it after {str(before)!r}", after=True)
    if token.type == "$END":
        return _at("the file ends in the middle", before, file, _expectation(expected))
    if token.type == "SEMICOLON" and "IDENT" in expected and "LPAR" not in expected:
        return _at("an empty statement", token, file, "remove the ';'")
    if token.type in _ENDS and "IDENT" in expected:
        return _at(f"no statement before {token}", token, file, "branches cannot be empty")
    if token.type == "INTEGER" and before.type == "DOT":
        return _at("bits by number are not supported", before, file, "use AND, SHL and SHR")
    if token.type in KEYWORDS and not token.startswith("END_") and "IDENT" in expected:
        message = f"{token} is a reserved word and cannot be used here"
        return _at(message, token, file, _expectation(expected))
    return _at(f"{str(token)!r} is not expected here", token, file, _expectation(expected))


def _before(token: Token, text: str, file: Path) -> Token:
    """The token before one, or the last where that is the end of the file."""
    found = token
    for candidate in tokens(text, file):
        if token.type != "$END" and (candidate.start_pos or 0) >= (token.start_pos or 0):
            break
        found = candidate
    return found


def _expectation(expected: set[str]) -> str:
    """What could stand there, if that is few enough to help."""
    words = {"IDENT": "a name", "LABEL": "a label", "INTEGER": "a number", "DIRECT": "an address"}
    if "LPAR" in expected and "INTEGER" in expected:
        return "an expression is expected"
    shown = sorted(_SPELLING.get(name) or words.get(name) or name for name in expected)
    return f"expected {' or '.join(shown)}" if len(shown) <= 6 else ""


def _at(
    message: str, token: Token, file: Path, hint: str = "", *, after: bool = False
) -> InputError:
    column = (token.column or 1) + (len(token) if after else 0)
    return InputError(message, file=file, line=token.line, column=column, hint=hint)
