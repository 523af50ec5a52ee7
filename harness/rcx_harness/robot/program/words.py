"""The words of the robot language, with those that this controller does not execute."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.toml_files import parse_toml

__all__ = ["Word", "explain", "words"]

#: Greatest length of a statement in a message [characters].
_LONGEST = 40
#: The pattern of the last part of a statement: a name with its brackets, a number or a sign.
_LAST = re.compile(r"[A-Z0-9_%!$.&*]+(?:\([^()]*\))?|[^\s\w]")
#: The pattern of a movement whose target is missing.
_NO_TARGET = re.compile(r"MOVE[IT]?\s*(\[\d\])?\s*[PLC]\s*,?")
_WORD = re.compile(r"[A-Z][A-Z0-9_]*[%!$]?")


@dataclass(frozen=True)
class Word:
    """A word of the language.

    Attributes:
        name: The word.
        group: The group of the word, such as `flow`.
        form: The notation of the word in a statement.
        source: The source of the effect: `guide`, `public` or `assumed`.
        text: The effect of the word in this controller.
        instead: The replacement for a word that is not executed.
    """

    name: str
    group: str
    form: str = ""
    source: str = "assumed"
    text: str = ""
    instead: str = ""


@cache
def words() -> Mapping[str, Word]:
    """Return all words by name."""
    text = files(__package__).joinpath("statements.toml").read_text(encoding="utf-8")
    return {
        entry["name"]: Word(**entry) for entry in parse_toml(text, Path("statements.toml"))["word"]
    }


def explain(text: str, column: int, missing: str = "") -> InputError:
    """Return the error for a statement that does not match the grammar.

    Args:
        text: The statement.
        column: Column of the first invalid character, from 1; below 1: the end of the statement.
        missing: The element that is missing at the end of the statement; empty if none is missing.
    """
    if not missing and _NO_TARGET.fullmatch(text):
        missing = "a target"
    match = _WORD.match(text)
    name = match[0] if match else ""
    word = words().get(name)
    if word and word.instead:
        return InputError(f"{name} is not executed by the virtual controller", hint=word.instead)
    if word and word.form:
        return InputError(
            f"cannot read {_shown(text)}: {_near(text, column, missing)}",
            hint=f"write {word.form}",
        )
    statement = not text[len(name) :].lstrip().startswith(("=", "("))
    if name and statement:
        near = get_close_matches(name, words(), 1)
        hint = f"did you mean {near[0]}?" if near else "see docs/reference/robot-language.md"
        return InputError(f"unknown statement {name}", hint=hint)
    hint = "write a statement, such as WAIT SI(20)=1 or SO(20)=1"
    return InputError(f"cannot read {_shown(text)}: {_near(text, column, missing)}", hint=hint)


def _shown(text: str) -> str:
    return f"'{text}'" if len(text) <= _LONGEST else f"'{text[:_LONGEST]}...'"


def _near(text: str, column: int, missing: str) -> str:
    """Return the part of a statement near an error, for the message."""
    if missing:
        return f"{missing} is missing after '{_LAST.findall(text)[-1]}'"
    rest = text[column - 1 :] if column > 0 else ""
    return f"'{rest[:20]}' was not expected" if rest else "something is missing at its end"
