"""`rcx format` formats files, and reports the files that it leaves as they are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_tools.bench.language import sources_of
from structured_text.editor.format.formatter import formatted
from structured_text.language.parser import read_text
from structured_text.language.source import source_text

Captured = pytest.CaptureFixture[str]

_PLC = Path(__file__).parents[2] / "plc"
_BEFORE, _AFTER = "PROGRAM P\nA:=1;\nEND_PROGRAM\n", "PROGRAM P\n  A := 1;\nEND_PROGRAM\n"
#: A sample with enumerations, wide declarations, long calls, CASE, and aligned comments.
_SAMPLE = [
    *("examples/05_jog_panel/JogPanel.st", "examples/09_openplc/OpenPlc.st"),
    *("lib/area/FB_WriteArea.st", "lib/motion/FB_Interlock.st", "lib/types/RCX_SERVO_STATE.st"),
]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder of the command, with a file that is not formatted."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "Main.st").write_text(_BEFORE, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("name", _SAMPLE)
def test_the_library_has_the_layout_of_the_formatter(name: str) -> None:
    """The formatter changes no file of the library and of the examples."""
    text = (_PLC / name).read_text(encoding="utf-8")
    assert formatted(text, _PLC / name) == text


@pytest.mark.exhaustive
def test_no_file_of_the_library_changes() -> None:
    """The formatter changes no file of the library and of the examples."""
    files = sorted(_PLC.rglob("*.st"))
    texts = [file.read_text(encoding="utf-8") for file in files]
    assert [f for f, text in zip(files, texts, strict=True) if formatted(text, f) != text] == []
    assert len(files) > 300


@pytest.mark.exhaustive
@pytest.mark.skipif("RCX_LIBRARIES" not in os.environ, reason="RCX_LIBRARIES names no libraries")
def test_public_libraries_are_formatted_once() -> None:
    """The second layout of each source is equal to the first; `formatted` compares the trees."""
    names = os.environ["RCX_LIBRARIES"].split(os.pathsep)
    different, seen = [], 0
    for source in (file for name in names for file in sources_of(Path(name))):
        text, file = source_text(source), Path(str(source))
        if not read_text(text, file).errors:
            once = formatted(text, file)
            different += [source] if formatted(once, file) != once else []
            seen += 1
    assert different == []
    assert seen > 0


def test_a_file_is_formatted_once(place: Path, capsys: Captured) -> None:
    """The second run finds nothing to do."""
    assert main(["format", "."]) == 0
    assert capsys.readouterr().out == "formatted: Main.st\n1 file formatted, no unchanged\n"
    assert (place / "Main.st").read_text(encoding="utf-8") == _AFTER
    assert main(["format", "Main.st"]) == 0
    assert capsys.readouterr().out == "no files formatted, 1 unchanged\n"


def test_check_and_diff_write_nothing(place: Path, capsys: Captured) -> None:
    """With --check the exit code tells whether a file would change."""
    assert main(["format", "Main.st", "--check"]) == 1
    assert capsys.readouterr().out.startswith("would be formatted: Main.st\n1 file would be")
    assert main(["format", "Main.st", "--diff"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert "-A:=1;" in printed
    assert "+  A := 1;" in printed
    assert (place / "Main.st").read_text(encoding="utf-8") == _BEFORE
    (place / "Main.st").write_text(_AFTER, encoding="utf-8")
    assert main(["format", "Main.st", "--check"]) == 0


def test_a_file_with_an_error_stays_and_others_are_formatted(place: Path, capsys: Captured) -> None:
    """Robot programs and projects are named and left out."""
    (place / "Faulty.st").write_text("PROGRAM P\nA:=;\nEND_PROGRAM\n", encoding="utf-8")
    (place / "MAIN.PGM").write_text("HALT\n", encoding="utf-8")
    (place / "plc.xml").write_text("<project/>\n", encoding="utf-8")
    assert main(["format", "Faulty.st", "Main.st", "MAIN.PGM", "plc.xml"]) == 2
    said = capsys.readouterr()
    assert said.err.startswith("error: Faulty.st:2:")
    assert said.err.count("\n") == 1
    assert "left out: MAIN.PGM: it is a robot program\n" in said.out
    assert "left out: plc.xml: it is a project of a PLC tool\n" in said.out
    assert "1 file formatted, no unchanged, 2 left out, 1 file with errors\n" in said.out
    assert (place / "Main.st").read_text(encoding="utf-8") == _AFTER
    assert (place / "Faulty.st").read_text(encoding="utf-8") == "PROGRAM P\nA:=;\nEND_PROGRAM\n"


def test_a_missing_file_is_bad_input(place: Path, capsys: Captured) -> None:
    """The message names the file."""
    assert main(["format", "Other.st"]) == 2
    assert capsys.readouterr().err == "rcx: Other.st: no such file\n"
    assert (place / "Main.st").read_text(encoding="utf-8") == _BEFORE
