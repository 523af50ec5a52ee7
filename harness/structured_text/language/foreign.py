"""Sources that are not Structured Text of IEC 61131-3, and words that have no meaning in it.

Each such source or word is reported with a single message, instead of many messages about its
parts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from lark import Token

from structured_text.errors import InputError
from structured_text.language.lexer import KEYWORDS

__all__ = ["LABELS", "corrected", "not_structured_text", "one_for_all"]

#: Words that open a block in SCL only. The second list has words before a name in double quotes.
_SCL_ONLY = frozenset(("DATA_BLOCK", "ORGANIZATION_BLOCK"))
_SCL_QUOTED = frozenset(("FUNCTION_BLOCK", "FUNCTION", "TYPE", *_SCL_ONLY))
#: Endings of SCL files.
_SCL_ENDING = {"DATA_BLOCK": ".db", "TYPE": ".udt"}
#: Words of other languages, with the equivalent in Structured Text.
_MISSPELT = {
    "BREAK": "EXIT",
    "ELSEIF": "ELSIF",
    "ELIF": "ELSIF",
    "ENDIF": "END_IF",
    "ENDCASE": "END_CASE",
    "ENDFOR": "END_FOR",
    "ENDWHILE": "END_WHILE",
    "ENDREPEAT": "END_REPEAT",
    "ENDVAR": "END_VAR",
}
#: Tokens that may stand before the first word of a statement. The second list has tokens that may
#: follow this word if it is a name.
_BEFORE = frozenset(("SEMICOLON", "THEN", "ELSE", "DO", "OF", "REPEAT", "END_VAR"))
_BEHIND_NAMES = frozenset(("ASSIGN", "DOT", "LSQB", "COLON", "COMMA", "CARET", "LATCH"))
#: Messages about jumps. `one_for_all` merges all such messages of a file into one.
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
    """Return the tokens with corrected keywords; `report` gets the errors.

    The rest of the source is then read without further errors about these words.
    """
    joined = _joined(found, file, report)
    named = _named(joined, file, report)
    return [_right(named, at, file, report) for at in range(len(named))]


def _joined(found: list[Token], file: Path, report: Callable[[InputError], None]) -> list[Token]:
    """Return the tokens with `END IF` and `: =` in one piece; `report` gets the errors."""
    result: list[Token] = []
    at = 0
    while at < len(found):
        token, behind = found[at], found[at + 1] if at + 1 < len(found) else None
        at += 1
        if behind is not None and behind.line == token.line:
            if token.upper() == "END" and f"END_{behind.type}" in KEYWORDS:
                word = f"END_{behind.type}"
                report(_written(token, f"{token} {behind} is written as one word", word, file))
                token = Token.new_borrow_pos(word, word, token)
                at += 1
            elif token.type == "COLON" and behind.type == "EQ":
                report(_written(token, "there is a blank in :=", ":=", file))
                token = Token.new_borrow_pos("ASSIGN", ":=", token)
                at += 1
                if result and result[-1].type == "LABEL":
                    result[-1] = Token.new_borrow_pos("IDENT", str(result[-1]), result[-1])
        result.append(token)
    return result


def _named(found: list[Token], file: Path, report: Callable[[InputError], None]) -> list[Token]:
    """Return the tokens, in which each keyword that is declared as a name is a name."""
    result = list(found)
    declares = names = False
    for at, token in enumerate(found):
        before = found[at - 1].type if at else ""
        follows = _type(found, at + 1)
        if token.type.startswith("VAR"):
            declares = names = True
        elif token.type == "END_VAR" and follows != "COLON":
            declares = names = False
        elif token.type == "SEMICOLON":
            names = declares
        elif token.type in ("COLON", "ASSIGN"):
            names = False  # the type and the initial value follow, such as [TRUE, FALSE]
        begins = before in ("SEMICOLON", "COMMA", "CONSTANT", "RETAIN") or before.startswith("VAR")
        if names and token.type in KEYWORDS and follows in ("COLON", "COMMA") and begins:
            text = f"{token} is a keyword and cannot be a name"
            report(_error(token, text, "choose another name", file))
            result[at] = Token.new_borrow_pos("IDENT", str(token), token)
    return result


def _written(token: Token, message: str, instead: str, file: Path) -> InputError:
    return _error(token, message, f"write {instead}", file)


def _error(token: Token, message: str, hint: str, file: Path) -> InputError:
    return InputError(message, file=file, line=token.line, column=token.column, hint=hint)


def _right(
    found: Sequence[Token], at: int, file: Path, report: Callable[[InputError], None]
) -> Token:
    """Return a token unchanged, or the keyword that a wrong word stands for."""
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
    """Return the errors; a single error, with a count, replaces all errors about jumps."""
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
