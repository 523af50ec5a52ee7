"""From text to tokens, with every construct that is not portable refused where it stands."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from pathlib import Path

from lark import Token

from rcx_harness.errors import InputError

__all__ = ["KEYWORDS", "PUNCTUATION", "tokens"]

KEYWORDS = frozenset(
    [
        "AND",
        "ARRAY",
        "AT",
        "BY",
        "CASE",
        "CONFIGURATION",
        "CONSTANT",
        "DO",
        "ELSE",
        "ELSIF",
        "END_CASE",
        "END_CONFIGURATION",
        "END_FOR",
        "END_FUNCTION",
        "END_FUNCTION_BLOCK",
        "END_IF",
        "END_PROGRAM",
        "END_REPEAT",
        "END_RESOURCE",
        "END_STRUCT",
        "END_TYPE",
        "END_VAR",
        "END_WHILE",
        "EXIT",
        "FALSE",
        "FOR",
        "FUNCTION",
        "FUNCTION_BLOCK",
        "IF",
        "MOD",
        "NON_RETAIN",
        "NOT",
        "OF",
        "ON",
        "OR",
        "PROGRAM",
        "REPEAT",
        "RESOURCE",
        "RETAIN",
        "RETURN",
        "STRUCT",
        "TASK",
        "THEN",
        "TO",
        "TRUE",
        "TYPE",
        "UNTIL",
        "VAR",
        "VAR_EXTERNAL",
        "VAR_GLOBAL",
        "VAR_IN_OUT",
        "VAR_INPUT",
        "VAR_OUTPUT",
        "VAR_TEMP",
        "WHILE",
        "WITH",
        "XOR",
    ]
)

PUNCTUATION = {
    ":=": "ASSIGN",
    "=>": "SENDTO",
    "<=": "LE",
    ">=": "GE",
    "<>": "NE",
    "**": "POWER",
    "..": "DOTDOT",
    "+": "PLUS",
    "-": "MINUS",
    "*": "STAR",
    "/": "SLASH",
    "&": "AMPERSAND",
    "=": "EQ",
    "<": "LT",
    ">": "GT",
    "(": "LPAR",
    ")": "RPAR",
    "[": "LSQB",
    "]": "RSQB",
    ",": "COMMA",
    ";": "SEMICOLON",
    ":": "COLON",
    ".": "DOT",
}

#: Words of other parts or editions of the standard, with what they belong to.
_UNSUPPORTED = {
    **dict.fromkeys(
        ("ACTION", "END_ACTION", "STEP", "INITIAL_STEP", "END_STEP", "TRANSITION", "FROM"),
        "Sequential Function Chart",
    ),
    "END_TRANSITION": "Sequential Function Chart",
    **dict.fromkeys(("POINTER", "REF_TO", "REFERENCE", "REF"), "pointers and references"),
    **dict.fromkeys(
        ("CLASS", "METHOD", "INTERFACE", "EXTENDS", "IMPLEMENTS", "PROPERTY", "NAMESPACE"),
        "object orientation",
    ),
    **dict.fromkeys(("R_EDGE", "F_EDGE"), "edge qualifiers; use an R_TRIG"),
    **dict.fromkeys(("EN", "ENO"), "the enable pins of calls; use IF"),
    **dict.fromkeys(("VAR_ACCESS", "VAR_CONFIG"), "access paths"),
    **dict.fromkeys(("JMP", "GOTO"), "jumps"),
    "CONTINUE": "the third edition of the standard",
    "UNION": "unions",
    "WSTRING": "wide strings",
    "READ_WRITE": "access paths",
    "READ_ONLY": "access paths",
}

#: A token and the white space before it.
_PATTERN = re.compile(
    r"""\s*(?:
      (?P<TYPED>
          (?:T|TIME)\#[-+]?[\w.]+
        | (?:D|DATE|TOD|TIME_OF_DAY|DT|DATE_AND_TIME)\#[\d:.\-_]+
        | [A-Z_]\w*\#[-+]?(?:\d+\#\w+|\d[\d_]*\.\d[\d_]*(?:E[-+]?\d+)?|\d\w*|[A-Z_]\w*)
      )
    | (?P<IDENT>[A-Z_]\w*)
    | (?P<comment>\(\*)
    | (?P<line_comment>//|/\*)
    | (?P<punctuation>:=|=>|<=|>=|<>|\*\*|\.\.|[-+*/&=<>()\[\],;:.])
    | (?P<REALNUM>\d[\d_]*\.\d[\d_]*(?:E[-+]?\d+)?)
    | (?P<INTEGER>(?:2|8|16)\#\w+|\d[\d_]*)
    | (?P<STRING>'(?:\$.|[^$'\n])*')
    | (?P<DIRECT>%[A-Z]*[\d.]+)
    | (?P<wide>")
    | (?P<pragma>[{}])
    | (?P<unknown>\S)
    )""",
    re.VERBOSE | re.IGNORECASE | re.ASCII,
)

_LITERALS = ("TYPED", "INTEGER", "REALNUM", "STRING", "DIRECT")
_LABEL_FOLLOWS = re.compile(r"(?:\s|\(\*.*?\*\))*(?::(?!=)|,|\.\.)", re.DOTALL)

#: Makes the error for a message, an offset in the text and a hint.
_Refuse = Callable[[str, int, str], InputError]


def tokens(text: str, file: Path) -> Iterator[Token]:
    """Split a source into tokens.

    Args:
        text: The whole source.
        file: Where it comes from, for messages.

    Yields:
        Tokens of lark with line and column. An identifier that begins a CASE label is a
        LABEL, because only the character after it tells it from a statement.

    Raises:
        InputError: a character or construct that is no portable Structured Text.
    """
    starts = [0, *(match.end() for match in re.finditer("\n", text))]

    def refuse(message: str, offset: int, hint: str) -> InputError:
        line = bisect_right(starts, offset)
        return InputError(
            message, file=file, line=line, column=offset - starts[line - 1] + 1, hint=hint
        )

    behind, cases, previous = 0, 0, ""
    while found := _PATTERN.match(text, behind):
        kind = str(found.lastgroup)
        offset, behind = found.span(kind)
        if kind == "comment":
            behind = _behind_comment(text, offset, refuse)
            continue
        value = text[offset:behind]
        if kind == "punctuation":
            kind = PUNCTUATION[value]
        elif kind == "IDENT":
            word = value.upper()
            if word in _UNSUPPORTED:
                raise refuse(f"{word} is not supported ({_UNSUPPORTED[word]})", offset, "")
            if word in KEYWORDS:
                kind = word
                cases += {"CASE": 1, "END_CASE": -1}.get(word, 0)
            elif cases and previous in ("SEMICOLON", "OF"):
                kind = "LABEL" if _LABEL_FOLLOWS.match(text, behind) else "IDENT"
            if "__" in word or word.endswith("_"):
                raise refuse(
                    f"{value} is no portable name", offset, "no double or trailing underscore"
                )
        elif kind not in _LITERALS:
            raise _unsupported(kind, value, offset, refuse)
        elif kind in ("INTEGER", "REALNUM") and text[behind : behind + 1].isalnum():
            raise refuse("a malformed number", offset, "write reals as 1.0E3, hexadecimal as 16#FF")
        line = bisect_right(starts, offset)
        yield Token(kind, value, offset, line, offset - starts[line - 1] + 1)
        previous = kind


def _behind_comment(text: str, offset: int, refuse: _Refuse) -> int:
    """Where the comment that begins there has ended."""
    end = text.find("*)", offset + 2)
    if end < 0:
        raise refuse("this comment is never closed", offset, "end it with *)")
    nested = text.find("(*", offset + 2, end)
    if nested >= 0:
        raise refuse("a comment inside a comment", nested, "comments do not nest on every PLC")
    return end + 2


def _unsupported(kind: str, value: str, offset: int, refuse: _Refuse) -> InputError:
    """What to say of characters that begin nothing that is known."""
    if kind == "line_comment":
        return refuse(f"{value} does not begin a comment on every PLC", offset, "write (* ... *)")
    if kind == "pragma":
        return refuse("pragmas are not supported", offset, "remove what is in { }")
    if kind == "wide":
        return refuse("wide strings are not supported", offset, "write 'text'")
    if value == "'":
        return refuse("this string is never closed", offset, "end it with ' on the same line")
    if value in "^@":
        return refuse(f"{value} is not supported (pointers and references)", offset, "")
    return refuse(f"the character {value!r} has no meaning here", offset, "")
