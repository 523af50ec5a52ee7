"""Formatting of files: encoding, byte order mark and line ends remain as they are."""

from __future__ import annotations

import os
from codecs import BOM_UTF8
from dataclasses import dataclass
from pathlib import Path

from structured_text.editor.format.formatter import formatted
from structured_text.errors import InputError
from structured_text.language.source import source_text
from structured_text.output.files import replace_files
from structured_text.output.limits import SOURCE
from structured_text.output.reading import file_bytes
from structured_text.projects.diagrams.sfc.model import has_chart
from structured_text.projects.formats import is_project

__all__ = ["FileLayout", "layout_of", "write_layout"]


@dataclass(frozen=True)
class FileLayout:
    """A file before and after formatting.

    Attributes:
        file: The file.
        before: Its text, with line feeds as line ends.
        after: The text in the new layout.
        content: The bytes of the file.
        omitted: The reason why the file is not formatted; empty if it is.
    """

    file: Path
    before: str
    after: str
    content: bytes
    omitted: str = ""

    @property
    def changes(self) -> bool:
        """Return whether formatting changes the file."""
        return self.before != self.after


def layout_of(file: Path) -> FileLayout:
    """Read and format a file; nothing is written.

    Raises:
        InputError: The file cannot be read, or has a syntax error.
    """
    if is_project(file):
        return FileLayout(file, "", "", b"", "it is a project of a PLC tool")
    text = source_text(file)
    if has_chart(text):
        return FileLayout(file, text, text, b"", "it has a Sequential Function Chart")
    return FileLayout(file, text, formatted(text, file), file_bytes(file, SOURCE))


def write_layout(layout: FileLayout) -> None:
    """Write a file in its new layout; the old content is replaced in one step.

    Raises:
        InputError: The file cannot be written or has changed meanwhile, or its
            encoding is not known.
    """
    content = _encoded(layout)
    if file_bytes(layout.file, SOURCE) != layout.content:
        raise InputError("has changed meanwhile", file=layout.file, hint="format it again")
    if not os.access(layout.file, os.W_OK):
        raise InputError("cannot be written: it is read-only", file=layout.file)
    replace_files({layout.file: content})


def _encoded(layout: FileLayout) -> bytes:
    """Return the new content in encoding, byte order mark and line ends of the old content."""
    old = layout.content
    feeds, returns = old.count(b"\n"), old.count(b"\r\n")
    end = "\r\n" if 2 * returns > feeds else "\n" if feeds else "\r" if b"\r" in old else "\n"
    text = layout.after if end == "\n" else layout.after.replace("\n", end)
    mark = old.startswith(BOM_UTF8)
    encoding = "utf-8"
    if not mark:
        try:
            old.decode("utf-8")
        except UnicodeDecodeError:
            encoding = "cp1252"
    try:
        content = text.encode(encoding)
    except UnicodeEncodeError:
        text = "has bytes that are neither UTF-8 nor Windows-1252"
        raise InputError(text, file=layout.file, hint="save the file as UTF-8") from None
    return BOM_UTF8 + content if mark else content
