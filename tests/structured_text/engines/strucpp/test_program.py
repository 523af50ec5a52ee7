"""The engine STruC++ checks bounds and reports a wrong initial state."""

from __future__ import annotations

from pathlib import Path

import pytest

from both_engines import needs
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.errors import InputError

pytestmark = needs("strucpp")


def _program(tmp_path: Path, variables: str, body: str) -> Program:
    source = tmp_path / "program.st"
    source.write_text(f"PROGRAM PROBE\n  VAR\n{variables}\n  END_VAR\n  {body}\nEND_PROGRAM\n")
    return build([source], "strucpp").program


def test_an_index_out_of_range_ends_the_scan_and_the_next_one_runs(tmp_path: Path) -> None:
    """An index outside of an array ends the scan, and the next scan runs.

    Source: IEC 61131-3, 6.4.4.5.
    """
    program = _program(
        tmp_path, "A : ARRAY [1..3] OF INT; K : INT := 4; N : INT;", "N := N + 1; A[K] := 1;"
    )
    with pytest.raises(InputError, match="an index of the program is out of range"):
        program.scan(0)
    program.write("Main.K", 3)
    program.scan(10_000)
    assert (program.read("Main.N"), program.read("Main.A")) == (2, [0, 0, 1])


def test_a_first_value_that_strucpp_leaves_out_has_its_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not start Main") as caught:
        _program(
            tmp_path, "    N : INT := 3;\n    Table : ARRAY [1..2] OF INT := [5, 6];", "N := 0;"
        )
    assert (caught.value.file, caught.value.line) == (str(tmp_path / "program.st"), 4)


def test_a_text_of_each_length_is_read_and_written(tmp_path: Path) -> None:
    program = _program(
        tmp_path, "A : STRING := 'abc'; B : STRING; L : INT;", "B := A; L := LEN(B);"
    )
    for text in ("", "x", "y" * 126):
        program.write("Main.A", text)
        program.scan(0)
        assert (program.read("Main.B"), program.read("Main.L")) == (text, len(text))


def test_time_is_that_of_the_scan(tmp_path: Path) -> None:
    program = _program(tmp_path, "T : TON;", "T(IN := TRUE, PT := T#30ms);")
    seen = []
    for now_us in (5_000, 30_000, 34_999, 35_000):
        program.scan(now_us)
        seen.append(program.read("Main.T.Q"))
    assert seen == [False, False, False, True]
