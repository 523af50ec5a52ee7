"""Sources that are not Structured Text of IEC 61131-3, and words that have no meaning in it.

Each gives one message in place of many about its parts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from lark import Token

from structured_text.errors import InputError

__all__ = ["LABELS", "corrected", "not_structured_text", "one_for_all"]

#: Words that open a block in SCL only, and words that are followed by a name in double quotes.
_SCL_ONLY = frozenset(("DATA_BLOCK", "ORGANIZATION_BLOCK"))
_SCL_QUOTED = frozenset(("FUNCTION_BLOCK", "FUNCTION", "TYPE", *_SCL_ONLY))
#: Endings of the files of SCL.
_SCL_ENDING = {"DATA_BLOCK": ".db", "TYPE": ".udt"}
#: Words of other languages, and what to write in Structured Text.
_MISSPELT = {
    "ELSEIF": "ELSIF",
    "ELIF": "ELSIF",
    "ENDIF": "END_IF",
    "ENDCASE": "END_CASE",
    "ENDFOR": "END_FOR",
    "ENDWHILE": "END_WHILE",
    "ENDREPEAT": "END_REPEAT",
    "ENDVAR": "END_VAR",
}
#: Tokens before the first word of a statement, and tokens behind it if it is a name.
_BEFORE = frozenset(("SEMICOLON", "THEN", "ELSE", "DO", "OF", "REPEAT", "END_VAR"))
_BEHIND_NAMES = frozenset(("ASSIGN", "DOT", "LSQB", "COLON", "COMMA", "CARET", "LATCH"))
#: Messages about jumps; there is one for each file.
LABELS, _JUMP = "labels for jumps are not supported", " is not supported (jumps)"


def not_structured_text(found: Sequence[Token], file: Path) -> InputError | None:
    """Return the error for a source in SCL of TIA Portal; None for any other source."""
    for token, follower in pairwise(found):
        word = token.upper()
        quoted = follower.type == "STRING" and follower.startswith('"')
        if (word in _SCL_QUOTED and quoted) or (word in _SCL_ONLY and follower.type == "IDENT"):
            name = file.with_suffix(_SCL_ENDING.get(word, ".scl")).name
            return InputError(
                f"this is SCL of TIA Portal ({word} {follower}), not Structured Text of "
                "IEC 61131-3",
                file=file,
                line=token.line,
                column=token.column,
                hint=f"name the file {name}, then it is read as SCL",
            )
    return None


def corrected(found: list[Token], file: Path, report: Callable[[InputError], None]) -> list[Token]:
    """Return the tokens with the right keywords; `report` gets the errors.

    The rest of the source is then read without further errors about these words.
    """
    return [_right(found, at, file, report) for at in range(len(found))]


def _right(
    found: Sequence[Token], at: int, file: Path, report: Callable[[InputError], None]
) -> Token:
    """Return a token, or the keyword that was meant."""
    token = found[at]
    meant = _MISSPELT.get(token.upper()) if token.type in ("IDENT", "LABEL") else None
    before = found[at - 1].type if at else ""
    if meant is None or _type(found, at + 1) in _BEHIND_NAMES:
        return token
    if before not in _BEFORE and not before.startswith("END_") and meant != "END_VAR":
        return token
    report(
        InputError(
            f"{token} is not a word of Structured Text",
            file=file,
            line=token.line,
            column=token.column,
            hint=f"write {meant}",
        )
    )
    return Token.new_borrow_pos(meant, meant, token)


def _type(found: Sequence[Token], at: int) -> str:
    return found[at].type if at < len(found) else ""


def one_for_all(errors: Iterable[InputError]) -> list[InputError]:
    """Return the errors with one in place of all about jumps; it has their number."""
    every = list(errors)
    jumps = [one for one in every if one.message == LABELS or one.message.endswith(_JUMP)]
    if len(jumps) < 2:
        return every
    first = jumps[0]
    labels = sum(one.message == LABELS for one in jumps)
    counts = [(labels, "label"), (len(jumps) - labels, "jump")]
    said = " and ".join(f"{n} {word}{'s' if n > 1 else ''}" for n, word in counts if n)
    merged = InputError(
        f"labels and jumps are not supported ({said} in this file)",
        file=first.file,
        line=first.line,
        column=first.column,
        hint="use IF, or a loop with EXIT",
    )
    return [merged if one is first else one for one in every if one is first or one not in jumps]
