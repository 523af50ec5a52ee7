"""The place of the cursor in a text that somebody is typing, and that may be broken.

The parser cannot read `Pump.` or `Pump(Speed := `. Here the words in front of the cursor are read
backwards: the variable before the dot, the call around the cursor, and what the value is for. The
variables that are found so are complete expressions, which the parser and the checker can read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from structured_text.editor.structure import Region, Token, key_of, scanned, tokens_of
from structured_text.editor.texts import Text
from structured_text.language.parser import read_text

__all__ = ["Call", "Context", "callee_before", "context", "expression_of", "first_of_path"]

#: Tokens that end a statement or its head, so that no call reaches over them.
_STOPS = frozenset(
    (
        *(";", "THEN", "ELSE", "ELSIF", "DO", "OF", "REPEAT", "UNTIL", "IF", "WHILE", "FOR"),
        *("CASE", "RETURN", "EXIT", "CONTINUE", "END_IF", "END_CASE", "END_FOR", "END_WHILE"),
        *("END_REPEAT", "END_VAR", "VAR"),
    )
)
#: Words that are operators and so no part of a variable.
_OPERATORS = frozenset(("AND", "OR", "XOR", "NOT", "MOD", "AND_THEN", "OR_ELSE", "TO", "BY"))
_COMPARES = ("=", "<>", "<", ">", "<=", ">=")
_LABELS_BEHIND = frozenset((";", "OF", "END_IF", "END_CASE", "END_FOR", "END_WHILE", "END_REPEAT"))
#: Words and signs behind which a statement can begin.
_BEFORE_STATEMENTS = frozenset(
    (*_LABELS_BEHIND, "THEN", "ELSE", "DO", "REPEAT", "END_VAR", "END_TRY", "__TRY")
) - {"OF"}


@dataclass(frozen=True)
class Call:
    """A call around the cursor.

    Attributes:
        callee: The text of what is called.
        given: The upper-case names of the pins that have an argument.
        active: The upper-case name of the pin that the cursor's argument is for; empty if it has
            no name.
        place: The number of the cursor's argument, from 0.
    """

    callee: str
    given: frozenset[str]
    active: str
    place: int


@dataclass(frozen=True)
class Context:
    """The place of the cursor.

    Attributes:
        owner: The key of the POU, method or action; empty outside.
        part: `body`, `declaration` (in a section of variables), `type` or `outside`.
        begin: The offset of the word that the cursor is in or behind.
        word: This word up to the cursor.
        base: The text of the variable before a dot in front of the word; else empty.
        prefix: The name before `#` in front of the word; else empty.
        other: The text of the variable that the word is assigned to or compared with, or of the
            selector of the CASE that the word is a label of; else empty.
        is_label: Whether the word can be a label of a CASE.
        is_type: Whether the word is the name of a type in a declaration.
        is_start: Whether a statement can begin with the word.
        is_argument: Whether an argument of the call begins with the word.
        spec: The name of the type of the variable whose initial value the word is in; else empty.
        fields: The fields that lead from the variable to the word: `(Speed := ` of its initial
            value. The last one is empty where a field's name is expected.
        call: The call around the cursor, if there is one.
    """

    owner: str
    part: str
    begin: int
    word: str = ""
    base: str = ""
    prefix: str = ""
    other: str = ""
    is_label: bool = False
    is_type: bool = False
    is_start: bool = False
    is_argument: bool = False
    spec: str = ""
    fields: tuple[str, ...] = ()
    call: Call | None = None


def context(text: Text, offset: int) -> Context:
    """Return the place of an offset in a text."""
    begin = offset
    while begin and (text.plain[begin - 1].isalnum() or text.plain[begin - 1] == "_"):
        begin -= 1
    word = text.plain[begin:offset]
    before = tokens_of(text, 0, begin)
    regions = scanned(before)[1]
    owner, part = _place(regions)
    found: dict[str, Any] = {}
    last = before[-1].word if before else ""
    if last == ".":
        found["base"] = _slice(text, before, len(before) - 2, before[-1].begin)
    elif last == "#" and len(before) > 1:
        found["prefix"] = before[-2].text
    elif part == "body":
        found = _value(text, before, regions)
    elif part in ("declaration", "type"):
        behind = _last_of(before, (":", ";", "END_VAR"))
        found["is_type"] = behind == ":" and last in (":", "OF", "TO", "REF_TO", "EXTENDS")
        if behind == ":" and last in (":=", "(", ","):
            found |= _initial(before)
    if part == "outside":
        found["is_type"] = last in ("EXTENDS", "IMPLEMENTS", ":", ",")
    call = _call(text, before, offset) if part == "body" else None
    found["is_argument"] = call is not None and last in ("(", ",")
    return Context(owner, part, begin, word, call=call, **found)


def _value(text: Text, before: Sequence[Token], regions: Sequence[Region]) -> dict[str, Any]:
    """Return what a word in a body is for."""
    last = before[-1].word
    if last == ":=" or last in _COMPARES:
        return {"other": _slice(text, before, len(before) - 2, before[-1].begin)}
    cases = [one for one in regions if one.kind == "CASE"]
    start = {"is_start": last in _BEFORE_STATEMENTS or (last == ":" and bool(cases))}
    selector = _selector(text, before, cases[-1]) if cases else ""
    behind_label = last == "," and selector and _is_in_labels(before)
    if selector and (last in _LABELS_BEHIND or behind_label):
        return {**start, "other": selector, "is_label": True}
    return start


def _initial(before: Sequence[Token]) -> dict[str, Any]:
    """Return the type of the variable whose initial value a word is in, and the way to the word."""
    fields: list[str] = [] if before[-1].text == ":=" else [""]
    at, depth = len(before) - 1, 0
    while at > 1 and before[at].text not in (":", ";"):
        text = before[at].text
        depth += (text in (")", "]")) - (text in ("(", "["))
        if text == ":=" and depth <= 0:
            if before[at - 2].text == ":":
                return {"spec": before[at - 1].text, "fields": tuple(fields)}
            if not depth and not fields:
                fields.insert(0, before[at - 1].word)
            elif depth < 0:
                fields.insert(0, before[at - 1].word)
                depth = 0
        at -= 1
    return {}


def _place(regions: Sequence[Region]) -> tuple[str, str]:
    """Return the key of the POU or method of the innermost open region, and the part of it."""
    key = section = ""
    for one in regions:
        key = key_of(one, key)
        if one.is_section or one.kind == "TYPE":
            section = "type" if one.kind == "TYPE" else "declaration"
    return key, section or ("body" if key else "outside")


def _last_of(before: Sequence[Token], words: Sequence[str]) -> str:
    return next((one.word for one in reversed(before) if one.word in words), "")


def first_of_path(tokens: Sequence[Token], last: int) -> int:
    """Return the number of the first token of the variable that ends with token `last`.

    The result is greater than `last` if no variable ends there.
    """
    at = last
    while at >= 0:
        text = tokens[at].text
        if text in (")", "]"):
            at = _opening(tokens, at) - 1
        elif text == "^":
            at -= 1
        elif _is_name(tokens[at]):
            if at < 2 or tokens[at - 1].text != ".":
                return at
            at -= 2
        else:
            break
    return last + 1


def _is_name(token: Token) -> bool:
    """Return whether a token can be a part of a variable's path."""
    return token.is_word and token.word not in _STOPS and token.word not in _OPERATORS


def _opening(tokens: Sequence[Token], at: int) -> int:
    """Return the number of the bracket that the bracket at a token closes; -1 without one."""
    depth = 0
    while at >= 0:
        depth += (tokens[at].text in (")", "]")) - (tokens[at].text in ("(", "["))
        if not depth:
            return at
        at -= 1
    return -1


def _slice(text: Text, tokens: Sequence[Token], last: int, end: int) -> str:
    """Return the text of the variable that ends with a token; empty if there is none."""
    first = first_of_path(tokens, last)
    return text.plain[tokens[first].begin : end].strip() if 0 <= first <= last else ""


def callee_before(text: Text, tokens: Sequence[Token], number: int) -> str:
    """Return the text of what the parenthesis at a token calls; empty if it calls nothing."""
    return _slice(text, tokens, number - 1, tokens[number].begin)


def _call(text: Text, before: Sequence[Token], offset: int) -> Call | None:
    """Return the innermost call that is open in front of the cursor."""
    at, depth = len(before) - 1, 0
    while at > 0:
        token = before[at]
        if token.word in _STOPS:
            return None
        if token.text in (")", "]"):
            depth += 1
        elif token.text in ("(", "[") and depth:
            depth -= 1
        elif token.text == "(":
            callee = callee_before(text, before, at)
            if callee:
                return _arguments(text, callee, before[at + 1 :], offset)
        at -= 1
    return None


def _arguments(text: Text, callee: str, inside: Sequence[Token], offset: int) -> Call:
    place, active, depth = 0, "", 0
    given: set[str] = set()
    behind = tokens_of(text, offset)
    for number, token in enumerate((*inside, *behind)):
        every = (*inside, *behind)
        depth += (token.text in ("(", "[")) - (token.text in (")", "]"))
        if depth < 0 or (depth == 0 and token.word in _STOPS):
            break
        if depth:
            continue
        ahead = number < len(inside)
        if token.text == "," and ahead:
            place, active = place + 1, ""
        elif token.text in (":=", "=>") and number and _is_name(every[number - 1]):
            given.add(every[number - 1].word)
            active = every[number - 1].word if ahead else active
    return Call(callee, frozenset(given), active, place)


def _selector(text: Text, before: Sequence[Token], case: Region) -> str:
    """Return the text of the selector of a CASE; empty if it has none yet."""
    for token in before[case.first + 1 :]:
        if token.word == "OF":
            return text.plain[case.begin + len("CASE") : token.begin].strip()
    return ""


def _is_in_labels(before: Sequence[Token]) -> bool:
    """Return whether the tokens end in a list of labels: names and commas behind a statement."""
    for token in reversed(before):
        if token.word in _LABELS_BEHIND:
            return True
        if token.text != "," and not _is_name(token):
            return False
    return False


def expression_of(text: str) -> Any:
    """Return the syntax of an expression; None if it is not one."""
    source = read_text.__wrapped__(f"FUNCTION X\nX := {text}\n;END_FUNCTION", Path("expression"))
    if source.errors or not source.declarations:
        return None
    body: Any = getattr(source.declarations[0], "body", ())
    return body[0].value if len(body) == 1 and hasattr(body[0], "value") else None
