"""Printing never fails, whatever characters the console can show."""

from __future__ import annotations

import ast
import io
import sys
from pathlib import Path

import pytest

from imports import shipped
from structured_text.output.console import draws, escaped, quoted, spare_no_character


@pytest.mark.parametrize(
    ("encoding", "expected"),
    [
        ("utf-8", True),
        ("UTF-8", True),
        ("utf-16", True),
        ("cp1252", False),
        ("cp437", False),
        ("latin-1", False),
        ("ascii", False),
        (None, False),
        ("no such thing", False),
    ],
)
def test_lines_need_all_their_characters(encoding: str | None, expected: bool) -> None:
    assert draws(encoding) is expected


def test_an_unknown_character_is_shown_by_its_number(monkeypatch: pytest.MonkeyPatch) -> None:
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, "cp1252"))
    spare_no_character()
    print("Müller ●", end="", flush=True)
    assert written.getvalue() == b"M\xfcller \\u25cf"


def test_a_choice_of_the_user_is_respected(monkeypatch: pytest.MonkeyPatch) -> None:
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, "ascii", errors="replace"))
    spare_no_character()
    print("●", end="", flush=True)
    assert written.getvalue() == b"?"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("plc", "plc"),
        ("out/prove-1/ü.toml", "out/prove-1/ü.toml"),
        (r"C:\cell\plc", r"C:\cell\plc"),
        ("my cell", '"my cell"'),
        (r"C:\Program Files (x86)\plc", r'"C:\Program Files (x86)\plc"'),
        ("a&b;c", '"a&b;c"'),
        ("", '""'),
    ],
)
def test_a_name_is_quoted_where_a_shell_would_take_it_apart(name: str, expected: str) -> None:
    """A file name is quoted if the shell of the system would split it.

    Source: quoting of POSIX shells, of cmd and of PowerShell.
    """
    assert quoted(name) == expected


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("RCX3 virtual controller", "RCX3 virtual controller"),
        ("\x1b[2J\x1b]0;PWN\x07", r"\x1b[2J\x1b]0;PWN\x07"),
        ("\r\nrcx: fake\t", r"\r\nrcx: fake\t"),
        ("\x9b31m\x85", r"\x9b31m\x85"),  # C1 control characters of ISO 8859-1
        ("Größe \u65e5\u672c", "Größe \u65e5\u672c"),
        ("\u202eevil\u2028", r"\u202eevil\u2028"),  # a right-to-left mark and a line separator
    ],
)
def test_unprintable_characters_are_shown_as_codes(text: str, shown: str) -> None:
    assert escaped(text) == shown


@pytest.mark.exhaustive
def test_lines_count_as_drawn_only_with_every_character_that_is_printed(repository: Path) -> None:
    """Every special character that is printed counts as needed.

    Pages and pictures are UTF-8 files, so they do not count. Some modules only search for their
    characters, or answer an editor in UTF-8. Drawings of networks have a form in ASCII.
    """
    searched = (
        "structured_text.projects.plcopen.tasks",
        "structured_text.output.junit",
        "structured_text.editor.diagnostics",
        "structured_text.editor.texts",
        "structured_text.projects.diagrams.networks.draw.svg",
        "structured_text.projects.diagrams.networks.draw.text",
    )
    texts = {
        name: "".join(_texts(ast.parse(file.read_text(encoding="utf-8"))))
        for name, file in shipped(repository).items()
        if not name.startswith("structured_text.coverage.html") and name not in searched
    }
    known = {one for one in texts.pop("structured_text.output.console") if not one.isascii()}
    assert len(known) == 17
    assert {one for text in texts.values() for one in text if not one.isascii()} == known


def _texts(tree: ast.Module) -> list[str]:
    """Return all strings except docstrings."""
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in alone
    ]
