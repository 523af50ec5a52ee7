"""The formatter: Structured Text in the layout of the library."""

from __future__ import annotations

from pathlib import Path

from structured_text.editor.format.columns import align, align_comments
from structured_text.editor.format.items import items_of
from structured_text.editor.format.lines import lines_of, place, written
from structured_text.editor.format.same import check_same
from structured_text.editor.format.structure import structure_of
from structured_text.language.parser import parse_text

__all__ = ["formatted"]


def formatted(text: str, file: Path) -> str:
    """Return a source in the layout of the library.

    The result has the same tokens and comments, and the same syntax tree. Formatting the result
    again does not change it. `file` is for messages; a file is not read.

    Args:
        text: The source, with line feeds as line ends.
        file: The file of the source.

    Raises:
        InputError: The source has a syntax error.
    """
    source = parse_text(text, file)
    items = items_of(text, file)
    lines = lines_of(structure_of(items))
    align(lines)
    place(lines)
    align_comments(lines)
    result = "".join(f"{line}\n" for line in written(lines))
    if result != text:
        check_same(source, items, result, file)
    return result
