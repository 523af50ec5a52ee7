"""File names that are not valid text in any encoding are used, and printed escaped."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from structured_text.output.console import spare_no_character
from structured_text.output.files import encoded, replace_files

_PROGRAM = """\
PROGRAM Own
VAR InputArea, OutputArea : ARRAY [0..511] OF BYTE; x : INT; END_VAR
  x := x + 1;
END_PROGRAM
"""


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes on Linux only")
def test_a_run_in_a_folder_whose_name_is_not_text_writes_all_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run writes all its files into a folder whose name is not valid UTF-8.

    Example: a backup of a machine that used Shift_JIS, on a machine that uses UTF-8.

    Source: docs/reference/limits.md, files.
    """
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\x83e\x83X"))
    folder.mkdir()
    monkeypatch.chdir(folder)
    spare_no_character()  # the command `rcx` makes this call at its start
    program = Path(os.fsdecode(b"\x83v.st"))
    program.write_text(_PROGRAM, encoding="utf-8")
    words = ["run", os.fspath(program), "--for", "30ms", "--coverage", "--engine", "builtin"]
    for option in ("trace", "chart", "view", "vcd"):
        words += [f"--{option}", os.fspath(folder / f"{program.stem}.{option}")]
    assert main(words) == 0
    capsys.readouterr()
    page = (folder / f"{program.stem}.view").read_text(encoding="utf-8")
    assert "\\udc83v.st" in page
    assert main(["view", os.fspath(folder / f"{program.stem}.trace"), "-o", "page.html"]) == 0


def test_bytes_that_are_not_characters_are_printed_escaped(tmp_path: Path) -> None:
    r"""Source: PEP 383: Python reads the byte 0x83 as `\udc83`."""
    assert encoded("a\udc83\u30c6") == b"a\\udc83\xe3\x83\x86"
    replace_files({tmp_path / "a": "x\udc83", tmp_path / "b": b"\x83"})
    assert (tmp_path / "a").read_bytes() == b"x\\udc83"
    assert (tmp_path / "b").read_bytes() == b"\x83"
