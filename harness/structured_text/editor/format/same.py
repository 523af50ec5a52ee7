"""The proof that a layout has changed nothing but white space and capitals."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from structured_text.editor.format.items import EXCLUDED, Item, items_of
from structured_text.errors import InputError
from structured_text.language.parser import parse_text
from structured_text.language.syntax import Position, Source

__all__ = ["check_same"]

#: Matches the literal that replaces `__POSITION()`. It depends on the layout.
_POSITION = re.compile(r"'Line \d+(?:, Column \d+ \(Impl\)| \(Decl\))'")


def check_same(source: Source, items: Sequence[Item], result: str, file: Path) -> None:
    """Raise InputError if the result has another tree, another token or another comment.

    Args:
        source: The parsed source.
        items: The items of the source.
        result: The text with the new layout.
        file: The file of the source, for messages.
    """
    hint = "report it with this file; the file has not been changed"
    try:
        again, parsed = items_of(result, file), parse_text(result, file)
    except InputError as error:
        text = f"the new layout cannot be read again ({error.message})"
        raise InputError(text, file=file, hint=hint) from None
    one, other = [_content(item) for item in items], [_content(item) for item in again]
    if one != other:
        first = next((b for a, b in zip(one, other, strict=False) if a != b), ("", "the end"))
        text = f"the new layout differs at {first[1].splitlines()[0][:40]!r}"
        raise InputError(text, file=file, hint=hint)
    for field in ("declarations", "pragmas", "namespaces", "entries"):
        if not _same(getattr(source, field), getattr(parsed, field)):
            raise InputError("the new layout has another meaning", file=file, hint=hint)


def _content(item: Item) -> tuple[str, str]:
    """Return kind and text of an item; the indentation of a comment's lines may differ."""
    if item.is_token or item.kind == EXCLUDED:
        return item.kind, item.text
    return item.kind, "\n".join(line.strip() for line in item.text.split("\n"))


def _same(one: Any, other: Any) -> bool:
    """Return whether two trees are equal apart from positions and capitals."""
    if type(one) is not type(other):
        return False
    if isinstance(one, Position):
        return True
    if isinstance(one, str):
        equal = one.upper() == other.upper()
        return equal or bool(_POSITION.fullmatch(one) and _POSITION.fullmatch(other))
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(_same, one, other))
    if is_dataclass(one):
        names = (field.name for field in fields(one))
        return all(_same(getattr(one, name), getattr(other, name)) for name in names)
    return bool(one == other)
