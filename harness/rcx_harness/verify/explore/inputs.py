"""The possible values of each input in an exploration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import timedelta
from typing import Any

from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.language.types import ElementaryType, EnumType, Type
from structured_text.output.units import parse_us

__all__ = ["values_of"]


def values_of(program: Program, path: str, texts: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield each possible value of an input as text and as value in the program."""
    kind = program.type_of(path)
    if not texts and kind == ElementaryType("BOOL"):
        texts = ("false", "true")
    if not texts:
        raise InputError(f"no values for {path}", hint=f"write --input {path}=1,2,3")
    before = program.read(path)
    for text in texts:
        shown, value = _value(kind, path, text.strip())
        program.write(path, value)  # raises InputError for a wrong value
        yield shown, program.read(path)
    program.write(path, before)


def _value(kind: Type, path: str, text: str) -> tuple[str, Any]:
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if isinstance(kind, EnumType) or name == "STRING":
        return f'"{text}"', text
    if name in ("TIME", "LTIME"):
        return f'"{text}"', timedelta(microseconds=parse_us(text))
    if name == "BOOL" and text.lower() in ("false", "true"):
        return text.lower(), text.lower() == "true"
    try:
        number = float(text) if name in ("REAL", "LREAL") else int(text, 0)
    except ValueError:
        hint = "write it as --input Main.Start=false,true"
        raise InputError(f"{text!r} is not a value for {path}", hint=hint) from None
    return repr(number), number
