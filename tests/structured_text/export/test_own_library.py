"""The exports also work for a library from outside this repository."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.errors import BLOCKS
from structured_text.export import export
from structured_text.language.library import Names

_BLOCK = """TYPE WIRE : ARRAY [0..3] OF BYTE; END_TYPE
FUNCTION_BLOCK FB_Delay
  VAR_IN_OUT Bytes : WIRE; END_VAR
  VAR_OUTPUT Done : BOOL; END_VAR
  VAR Clock : TON; END_VAR
  Clock(IN := TRUE, PT := T#1s);
  Done := Clock.Q;
  Bytes[0] := BYTE#16#01;
END_FUNCTION_BLOCK
"""


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """Return a folder with a block and an array of bytes."""
    folder = tmp_path / "lib"
    folder.mkdir()
    (folder / "FB_Delay.st").write_text(_BLOCK)
    return folder


@pytest.mark.parametrize(("image", "element"), [("", "DINT"), ("WIRE", "SINT")])
def test_the_library_names_its_process_images(library: Path, image: str, element: str) -> None:
    """Only if the library names a type as process image, its arrays become SINT arrays in L5X.

    Source: docs/how-to/export.md, Rockwell: a scanner's arrays are of SINT.
    """
    (text,) = export("l5x", library, names=Names(byte_image=image)).files.values()
    assert f'Name="Bytes" TagType="Base" DataType="{element}" Dimensions="4"' in text
    assert f'Name="{BLOCKS}TON"' in text


def test_the_readme_of_an_export_contains_the_notes_of_the_library(library: Path) -> None:
    """README.txt contains the notes that the library has for the target.

    Source: docs/how-to/export.md, Keyence and Mitsubishi.
    """
    notes = {"keyence_first": "FB_Delay", "mitsubishi_times": "FB_Delay takes 1 s."}
    keyence, mitsubishi = (
        export(target, library, names=Names(notes=notes)).files["README.txt"]
        for target in ("keyence", "mitsubishi")
    )
    assert "try FB_Delay, and convert it." in keyence
    assert "3. Process image: there is no type for a byte, so make it of words." in keyence
    assert "\nFB_Delay takes 1 s.\n" in mitsubishi
