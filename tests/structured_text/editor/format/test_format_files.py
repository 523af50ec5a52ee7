"""Formatting of a file keeps its encoding, byte order mark and line ends."""

from __future__ import annotations

from codecs import BOM_UTF8
from pathlib import Path

import pytest

from structured_text.editor.format.files import layout_of, write_layout
from structured_text.errors import InputError

_BEFORE, _AFTER = "PROGRAM P\nA:=1; // {}\nEND_PROGRAM", "PROGRAM P\n  A := 1; // {}\nEND_PROGRAM\n"


def _written(folder: Path, content: bytes) -> bytes:
    file = folder / "Main.st"
    file.write_bytes(content)
    write_layout(layout_of(file))
    return file.read_bytes()


@pytest.mark.parametrize("mark", [b"", BOM_UTF8])
def test_mark_and_line_ends_remain(tmp_path: Path, mark: bytes) -> None:
    """A file with CRLF and a byte order mark keeps both."""
    before = _BEFORE.format("ä").replace("\n", "\r\n").encode()
    after = _AFTER.format("ä").replace("\n", "\r\n").encode()
    assert _written(tmp_path, mark + before) == mark + after


def test_a_file_in_windows_1252_remains_one(tmp_path: Path) -> None:
    """Older tools write this encoding."""
    before, after = _BEFORE.format("5 µm"), _AFTER.format("5 µm")
    assert _written(tmp_path, before.encode("cp1252")) == after.encode("cp1252")


def test_bytes_of_no_encoding_are_not_lost(tmp_path: Path) -> None:
    """The byte 81 has no meaning in Windows-1252; the file stays as it is."""
    content = _BEFORE.format("x").encode() + b" // \x81"
    with pytest.raises(InputError, match="neither UTF-8 nor Windows-1252"):
        _written(tmp_path, content)
    assert (tmp_path / "Main.st").read_bytes() == content


def test_a_file_that_has_changed_meanwhile_is_not_overwritten(tmp_path: Path) -> None:
    """Somebody may save the file in an editor while it is formatted."""
    file = tmp_path / "Main.st"
    file.write_text(_BEFORE.format("x"), encoding="utf-8")
    layout = layout_of(file)
    file.write_text("PROGRAM Other END_PROGRAM", encoding="utf-8")
    with pytest.raises(InputError, match="has changed meanwhile"):
        write_layout(layout)
    assert file.read_text(encoding="utf-8") == "PROGRAM Other END_PROGRAM"


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("Main.TcPOU", "<TcPlcObject/>", "a project"),
        (
            "Main.st",
            "PROGRAM P\nINITIAL_STEP A:\nEND_STEP\nEND_PROGRAM",
            "a Sequential Function Chart",
        ),
    ],
)
def test_other_files_are_omitted(tmp_path: Path, name: str, text: str, reason: str) -> None:
    """Projects and charts are not plain Structured Text."""
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    layout = layout_of(file)
    assert reason in layout.omitted
    assert not layout.changes
