"""`Program.reader` returns the same values as `Program.read` on every engine."""

from __future__ import annotations

from pathlib import Path

import pytest

from both_engines import ENGINES
from structured_text.engines.load import build
from structured_text.errors import InputError

_SOURCE = """TYPE
  MODE : (MODE_IDLE, MODE_BUSY);
END_TYPE
FUNCTION_BLOCK Counter
  VAR_INPUT Up : BOOL := TRUE; END_VAR
  VAR_OUTPUT N : INT; Late : BOOL; Code : WORD; END_VAR
  N := N + 1;
  Late := N > 2;
  Code := INT_TO_WORD(N);
END_FUNCTION_BLOCK
PROGRAM Plant
  VAR C : Counter; N : INT := 7; M : MODE; T : TIME; W : ARRAY [0..1] OF WORD; END_VAR
  C();
  T := T + T#10ms;
  W[1] := C.Code;
  IF C.Late THEN
    M := MODE_BUSY;
  END_IF;
END_PROGRAM
"""


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "paths",
    [
        ["Main.C.Up", "Main.C.N", "Main.C.Late", "Main.C.Code"],
        ["Main.C.Code", "Main.N", "Main.C.Up", "Main.C.Code"],
        ["Main.C.N"],
        ["Main.C.N", "Main.M", "Main.T", "Main.W", "Main.W[1]"],
        [],
    ],
)
def test_a_reader_gives_what_read_gives(engine: str, paths: list[str], tmp_path: Path) -> None:
    source = tmp_path / "Plant.st"
    source.write_text(_SOURCE, encoding="utf-8")
    program = build([source], engine).program
    start = program.snapshot()
    look = program.reader(paths)
    for scan in range(4):
        program.scan(scan * 10_000)
        assert look() == tuple(program.read(path) for path in paths)
    program.restore(start)
    assert look() == tuple(program.read(path) for path in paths)
    with pytest.raises(InputError):
        program.reader(["Main.C.Missing"])
    program.close()


_PLANT = """PROGRAM First
  VAR N : INT; Up : BOOL; END_VAR
  N := N + 1;
  Up := NOT Up;
END_PROGRAM
PROGRAM Second
  VAR_EXTERNAL Total : DINT; END_VAR
  VAR N : INT; END_VAR
  N := N + 10;
  Total := Total + 100;
END_PROGRAM
CONFIGURATION Plant
  VAR_GLOBAL Total : DINT := 7; END_VAR
  RESOURCE Cpu ON Plc
    TASK Cycle(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM A WITH Cycle : First;
    PROGRAM B WITH Cycle : Second;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.mark.parametrize("engine", ENGINES)
def test_a_reader_takes_variables_of_several_programs(engine: str, tmp_path: Path) -> None:
    """The values are in the order of the request, whatever program a variable belongs to.

    Source: engines.base.Program.reader.
    """
    source = tmp_path / "Plant.st"
    source.write_text(_PLANT, encoding="utf-8")
    program = build([source], engine).program
    look, both = program.reader(["B.N", "A.N", "A.Up", "Total"]), program.reader(["A.N", "B.N"])
    program.scan(0)
    program.scan(10_000)
    assert look() == (20, 2, False, 207)
    assert both() == (2, 20)
    program.close()
