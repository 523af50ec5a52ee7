"""`rcx export` reports each part of a program that a tool cannot have, and writes nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from exported import left_out
from exported_dialect import WITH_INITIAL_VALUES
from rcx_harness.cell.exports import export
from rcx_harness.cell.sources import source_files
from rcx_harness.cli.app import main
from structured_text.engines.load import build
from structured_text.export import TARGETS
from structured_text.export.output import write

Captured = pytest.CaptureFixture[str]

_CONFIGURED = """\
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Slow(INTERVAL := T#100ms, PRIORITY := 3);
    PROGRAM Main WITH Slow : Mine;
  END_RESOURCE
END_CONFIGURATION
"""

_ANEW = "RETAIN is not exported: a power loss resets it"
_PIN = "its initial value: set it where you call the block"
_CONFIGURATION = "93: CONFIGURATION Config0: TASK Slow (line 95), PROGRAM Main (line 96)"
_BLOCK = "FUNCTION_BLOCK FB_Mine"

#: For each target, the lines of the constructs that it cannot have, counted by hand.
_LOST = {
    "st": [],
    "plcopen": [],
    "twincat": [_CONFIGURATION],
    "scl": [f"86: VAR Old of PROGRAM Mine: {_ANEW}", _CONFIGURATION],
    "l5x": [f"39: {_BLOCK}: Kept has an initial value that is not a single number",
            "80: PROGRAM Mine: needs FB_Mine, which cannot be exported", _CONFIGURATION],
    "omron": [_CONFIGURATION, f"51: VAR_INPUT Setup of {_BLOCK}: {_PIN}",
              f"86: VAR Old of PROGRAM Mine: {_ANEW}"],
    "mitsubishi": [_CONFIGURATION, f"51: VAR_INPUT Setup of {_BLOCK}: {_PIN}",
                   f"86: VAR Old of PROGRAM Mine: {_ANEW}"],
    "keyence": [_CONFIGURATION, f"39: VAR Kept of {_BLOCK}: {_ANEW}",
                f"40: VAR Count of {_BLOCK}: {_ANEW}", f"51: VAR_INPUT Setup of {_BLOCK}: {_PIN}",
                f"58: VAR_OUTPUT Total of {_BLOCK}: {_ANEW}",
                f"86: VAR Old of PROGRAM Mine: {_ANEW}", f"87: VAR Hours of PROGRAM Mine: {_ANEW}"],
}  # fmt: skip

_OUTSIDE = """\
FUNCTION_BLOCK FB_Shared
  VAR_EXTERNAL
    Common : INT;
  END_VAR
  Common := Common + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Above
  VAR
    Shared : FB_Shared;
  END_VAR
  Shared();
END_FUNCTION_BLOCK
PROGRAM Located
  VAR
    Lamp AT %QX0.0 : BOOL;
    Above          : FB_Above;
  END_VAR
  Above();
  Lamp := NOT Lamp;
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    VAR_GLOBAL RETAIN
      Common : INT := 3; (* of all *)
    END_VAR
    VAR_GLOBAL
      Word3 AT %MW3 : WORD;
    END_VAR
    TASK Fast(INTERVAL := T#10ms);
    PROGRAM Main WITH Fast : Located;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """Write a user's program with initial values, and return its file."""
    file = tmp_path / "Mine.st"
    file.write_text(WITH_INITIAL_VALUES + _CONFIGURED)
    return file


def _export(target: str, file: Path, *options: str) -> int:
    place = file.parent / target
    return main(["export", target, "--needed", "--program", str(file), "-o", str(place), *options])


@pytest.mark.parametrize("target", TARGETS)
def test_each_lost_part_is_reported(target: str, mine: Path, capsys: Captured) -> None:
    """Each lost part is reported with file, line and declaration, and the exit code is 1."""
    place = mine.parent / target
    assert _export(target, mine) == (1 if _LOST[target] else 0)
    said = capsys.readouterr()
    named = [line for line in said.out.splitlines() if line.startswith("not carried: ")]
    wanted = [f"not carried: {mine}:{line}" for line in _LOST[target]]
    assert len(named) == len(wanted)
    assert all(line.startswith(one) for line, one in zip(named, wanted, strict=True)), named
    assert place.exists() == (not _LOST[target])
    if _LOST[target]:
        assert said.err == "rcx: nothing was written; --allow-missing writes the rest\n"
        assert _export(target, mine, "--allow-missing") == 0
        said = capsys.readouterr()
        again = [line for line in said.out.splitlines() if line.startswith("not carried: ")]
        assert again == named
        assert f"written: {place}" in said.out
        assert place.exists()


@pytest.mark.parametrize("target", ["scl", "l5x", "omron", "mitsubishi", "keyence"])
def test_the_users_of_a_part_that_is_left_out_are_reported(
    target: str, tmp_path: Path, capsys: Captured
) -> None:
    file = tmp_path / "Outside.st"
    file.write_text(_OUTSIDE)
    assert _export(target, file) == 1
    named = sorted(line for line in capsys.readouterr().out.splitlines() if "carried: " in line)
    assert len(named) == 4
    text = "\n".join(named)
    for said in (
        f"{file}:1: FUNCTION_BLOCK FB_Shared: ",
        f"{file}:7: FUNCTION_BLOCK FB_Above: needs FB_Shared, which cannot be exported",
        f"{file}:13: PROGRAM Located: ",
        "TASK Fast (line 29), PROGRAM Main (line 30), "
        "VAR_GLOBAL Common (line 24), VAR_GLOBAL Word3 (line 27): ",
    ):
        assert said in text
    assert "has global or located variables (Common)" in text
    place = tmp_path / target
    assert not place.exists()


@pytest.mark.exhaustive
def test_byte_arrays_of_the_library_do_not_stop_an_export(tmp_path: Path, capsys: Captured) -> None:
    out = tmp_path / "keyence"
    assert main(["export", "keyence", "-o", str(out)]) == 0
    assert "FUNCTION_BLOCK FB_ReadArea: has an array of BYTE" in capsys.readouterr().out
    file = tmp_path / "Mine.st"
    file.write_text(
        "PROGRAM Mine\n  VAR\n    Robot : RCX_REF;\n    Image : RCX_IMAGE;\n"
        "    Read : FB_ReadArea;\n  END_VAR\n"
        "  Read(Robot := Robot, Image := Image, Connected := TRUE);\nEND_PROGRAM\n"
    )
    assert _export("keyence", file) == 1
    assert f"{file}:1: PROGRAM Mine: " in capsys.readouterr().out


def test_the_first_call_sets_the_values_of_arrays_and_structures(mine: Path) -> None:
    """If the tool's tables have no initial values, the first statements of a block set them."""
    for target, colour in (("omron", "MINE_COLOUR#GREEN"), ("keyence", "1 (* GREEN *)")):
        body = export(target, program=[mine], only_needed=True).files["program/FB_Mine.st"]
        first = body.partition("IF NOT RcxStarted THEN")[2].partition("END_IF;")[0]
        for line in (
            *("Table[1] := 10;", "Table[4] := -3;", "Shown.Low := 3;", f"Shown.Tint := {colour};"),
            *(
                "All.Few[2] := 7;",
                "All.Pair.Low := 9;",
                "All.Pair.Top := 3;",
                "All.Text := 'it$27s';",
            ),
            *("All.Wait := T#2000ms;", "All.Part := 0.25;", f"Grid[1, 2].Tint := {colour};"),
            *("Plain[0] := TRUE;", "Plain[3] := TRUE;"),
        ):
            assert f"    {line}\n" in first, (target, line)
        assert "Plain[1]" not in first, "the variable has this initial value already"
        assert "Setup" not in first, "the caller may have set the variable"
        before = body.partition("IF NOT RcxStarted")[0]
        assert "  Short := 127;\n  Line[1] := 1;\n  Line[2] := 7;\n" in before, (
            "the value is set at each call"
        )


def test_scl_has_initial_values_in_declarations_or_in_the_first_call(mine: Path) -> None:
    text = export("scl", program=[mine], only_needed=True).files[""]
    for line in (
        "      Tint : INT := 1;",
        "      Few : Array[1..4] of INT := [1, 2(7), -3];",
        "      Wait : TIME := T#2000ms;",
        "      Table : Array[1..4] of INT := [10, 20, 30, -3];",
        "      Alias : DINT := 127;",
        "    #All.Pair.Low := 9;",
        "    #Kept.Low := 1;",
        "  #Line[2] := 7;",
        "  #Rows[4] := -3;",
    ):
        assert f"{line}\n" in text, line
    assert "#All.Pair.Top" not in text, "the value belongs to the data type"
    assert "      x : DINT;\n" in text, "an input of a function has no initial value"
    assert 'FC_Mine"(x := 1, y := 127)' in text


def test_retain_is_exported_if_the_tool_has_it(mine: Path) -> None:
    """RETAIN is exported to tools that have it, for example as a label class.

    Source: MELSEC iQ-R, label classes: VAR_RETAIN, VAR_OUTPUT_RETAIN; none for inputs.
    """
    omron = export("omron", program=[mine], only_needed=True).files
    assert "Count\tINT\t4\tTRUE\t\t\n" in omron["program/FB_Mine.internals.txt"]
    assert "Kept\tMINE_PAIR\t\tTRUE\t\t\n" in omron["program/FB_Mine.internals.txt"]
    assert "RcxStartedKept\tBOOL\t\tTRUE\t" in omron["program/FB_Mine.internals.txt"]
    assert "Total\tOutput\tDINT\t\t100\tTRUE\t\t\n" in omron["program/FB_Mine.inout.txt"]
    labels = export("mitsubishi", program=[mine], only_needed=True).files["program/FB_Mine.csv"]
    assert '"Count","Word [Signed]","VAR_RETAIN","4"' in labels
    assert '"Total","Double Word [Signed]","VAR_OUTPUT_RETAIN","100"' in labels


def test_l5x_does_not_initialise_retained_variables(tmp_path: Path) -> None:
    """The Prescan routine does not write retained variables, so they keep their values.

    Source: 1756-PM010, Prescan routine.
    """
    file = tmp_path / "Hours.st"
    file.write_text(
        "FUNCTION_BLOCK FB_Hours\n  VAR_OUTPUT RETAIN\n    Hours : DINT := 7;\n  END_VAR\n"
        "  VAR\n    Runs : DINT := 8;\n  END_VAR\n"
        "  Hours := Hours + 1;\n  Runs := Runs + 1;\nEND_FUNCTION_BLOCK\n"
    )
    text = export("l5x", program=[file], only_needed=True).files[""]
    prescan = text.partition('<Routine Name="Prescan"')[2]
    prescan = prescan[prescan.index("FB_Hours") :] if "FB_Hours" in prescan else prescan
    assert "Runs := 8;" in text
    assert "Hours := 7;" not in text


_WHOLE = """\
TYPE
  MINE_COLOUR : (RED, GREEN, BLUE) := GREEN;
  MINE_ALIAS  : DINT := 16#7F;
  MINE_FEW    : ARRAY [1..4] OF INT := [1, 2(7), -3];
  MINE_PAIR   : STRUCT
    Low, Top : INT := 3;
    Tint     : MINE_COLOUR;
    Raw      : WORD := WORD#16#FF00;
  END_STRUCT;
  MINE_PAIRS  : ARRAY [0..1] OF MINE_PAIR;
  MINE_SET : STRUCT
    Few  : MINE_FEW;
    Pair : MINE_PAIR := (Low := 9);
    Text : STRING := 'it$'s';
    Wait : TIME := T#1500ms;
    Part : REAL := 0.25;
    Lit  : BOOL := TRUE;
  END_STRUCT := (Wait := T#2s);
END_TYPE
FUNCTION FC_Mine : DINT
  VAR_INPUT
    x : DINT;
  END_VAR
  VAR
    Rows : MINE_FEW;
  END_VAR
  Rows[1] := Rows[1] + INT#1;
  FC_Mine := x + INT_TO_DINT(Rows[1] + Rows[2]);
END_FUNCTION
FUNCTION_BLOCK FB_Mine
  VAR CONSTANT
    Table : MINE_FEW := [10, 20, 30];
  END_VAR
  VAR_TEMP
    Line  : MINE_FEW;
  END_VAR
  VAR_OUTPUT
    Total : DINT := 100;
    Lit   : BOOL;
  END_VAR
  VAR
    All   : MINE_SET;
    Pairs : MINE_PAIRS;
    Alias : MINE_ALIAS;
    Timed : TIME;
  END_VAR
  Total := Total + INT_TO_DINT(All.Few[2] + All.Pair.Low + Pairs[1].Top);
  Total := Total + INT_TO_DINT(Line[1] + Line[4] + Table[2] + Table[4]) + Alias;
  Total := Total + FC_Mine(x := DINT#1);
  Line[1] := Line[1] + INT#1;
  All.Few[2] := All.Few[2] + INT#1;
  Timed := All.Wait;
  IF All.Lit AND All.Part = 0.25 AND Pairs[0].Raw = WORD#16#FF00 THEN
    Lit := TRUE;
  END_IF;
END_FUNCTION_BLOCK
PROGRAM Mine
  VAR
    It    : FB_Mine;
    Given : MINE_PAIR;
    Sum   : DINT := 1;
  END_VAR
  It();
  Sum := It.Total + INT_TO_DINT(Given.Low);
END_PROGRAM
"""


def test_l5x_sets_structures_and_arrays_when_the_controller_starts(tmp_path: Path) -> None:
    """A program with initial values, read back from L5X, has the values of the original.

    Source: 1756-PM010, Prescan routine.
    """
    file = tmp_path / "Mine.st"
    file.write_text(_WHOLE)
    output = export("l5x", program=[file], only_needed=True)
    assert output.missing == ()
    (made,) = write(output, tmp_path / "mine.L5X")
    files = (source_files([one], None).all for one in (file, made))
    original, back = (build(list(one), "builtin").program for one in files)
    for scan in range(3):
        original.scan(scan * 10_000)
        back.scan(scan * 10_000)
        for path in ("Main.Sum", "Main.It.Lit", "Main.It.Total", "Main.It.All.Text"):
            assert original.read(path) == back.read(path), path
    assert original.read("Main.It.Lit"), "All and Pairs have their values"
    assert back.read("Main.It.Timed") == 2000, "[ms]"


def test_twincat_lists_global_variables_and_drops_non_retain(tmp_path: Path) -> None:
    file = tmp_path / "Outside.st"
    file.write_text(_OUTSIDE.replace("VAR_GLOBAL\n", "VAR_GLOBAL NON_RETAIN (* NON_RETAIN *)\n"))
    output = export("twincat", program=[file], only_needed=True)
    assert left_out(output) == (
        "CONFIGURATION Config0: TASK Fast (line 29), PROGRAM Main (line 30): "
        "make a task in the project and let it call the program",
    )
    text = output.files["RCX3/program/Config0.TcGVL"]
    assert "VAR_GLOBAL RETAIN\n      Common : INT := 3; (* of all *)\n    END_VAR" in text
    assert "VAR_GLOBAL (* NON_RETAIN *)\n      Word3 AT %MW3 : WORD;\n    END_VAR" in text
    assert "RCX3\\program\\Config0.TcGVL" in output.files["RCX3.plcproj"]


@pytest.mark.parametrize(
    ("target", "statement", "message"),
    [
        ("twincat", "x := x ** i;", "** is not on the list for TwinCAT 3; write EXPT("),
        ("scl", "i := TIME_TO_INT(t);", "TIME_TO_INT is not on the list for SCL"),
        ("l5x", "i := MIN(i, LIMIT(1, i, 3));", "MIN is not on the list for Structured Text of"),
        ("omron", "s := INT_TO_STRING(i);", "INT_TO_STRING is not on the list for Sysmac"),
        ("omron", "i := MUX(i, 1, 2, 3, 4, 5, 6);", "MUX of 7 arguments is not on the list"),
        ("mitsubishi", "i := MUX(i, 1, 2);", "MUX is not on the list for GX Works3"),
        ("keyence", "i := SEL(TRUE, i, 3);", "SEL is not on the list for KV STUDIO"),
    ],
)
def test_a_function_that_the_tool_lacks_is_reported_with_its_line(
    target: str, statement: str, message: str, tmp_path: Path, capsys: Captured
) -> None:
    """A function that the tool lacks is reported with its line, as is the program that needs it."""
    file = tmp_path / "Word.st"
    file.write_text(
        "FUNCTION_BLOCK FB_Word\n  VAR\n    i : INT; x : REAL; s : STRING; t : TIME;\n  END_VAR\n"
        f"  i := i + 1;\n  {statement}\nEND_FUNCTION_BLOCK\n"
        "PROGRAM Mine\n  VAR\n    It : FB_Word;\n  END_VAR\n  It();\nEND_PROGRAM\n"
    )
    assert _export(target, file) == 1
    first, second = (one for one in capsys.readouterr().out.splitlines() if "carried" in one)
    assert first.startswith(f"not carried: {file}:6: FUNCTION_BLOCK FB_Word: {message}")
    assert second == f"not carried: {file}:8: PROGRAM Mine: needs FB_Word, which cannot be exported"
    place = tmp_path / target
    assert not place.exists()
    assert _export(target, file, "--allow-missing") == 0
    written = [place] if place.is_file() else [one for one in place.rglob("*") if one.is_file()]
    assert written
    assert "FB_Word" not in "".join(one.read_text() for one in written)


@pytest.fixture
def given(tmp_path: Path) -> Path:
    """Write a program that passes a structure with initial values to a function."""
    file = tmp_path / "Given.st"
    file.write_text(
        "TYPE\n  PAIR : STRUCT\n    Low, Top : INT := 3;\n  END_STRUCT;\nEND_TYPE\n"
        "FUNCTION FC_Low : INT\n  VAR_INPUT\n    x : PAIR;\n    y : INT := 4;\n  END_VAR\n"
        "  FC_Low := x.Low + y;\nEND_FUNCTION\n"
        "FUNCTION_BLOCK FB_Both\n  VAR\n    Total : INT;\n    Part : PAIR := (Low := 8);\n"
        "  END_VAR\n  Total := MUL(FC_Low(x := Part), Total);\nEND_FUNCTION_BLOCK\n"
    )
    return file


@pytest.mark.parametrize(
    ("target", "started", "called"),
    [
        ("st", "Part : PAIR := (Low := 8);", "Total := MUL(FC_Low(x := Part), Total);"),
        ("plcopen", '<simpleValue value="8"', "Total := MUL(FC_Low(x := Part), Total);"),
        ("twincat", "Part : PAIR := (Low := 8);", "Total := ((FC_Low(x := Part)) * (Total));"),
        ("scl", "    #Part.Low := 8;\n", '#Total := (("FC_Low"(x := #Part, y := 4)) * (#Total));'),
        ("omron", "    Part.Low := 8;\n", "Total := ((FC_Low(Part, 4)) * (Total));"),
        ("mitsubishi", "    Part.Low := 8;\n", "Total := ((FC_Low(Part, 4)) * (Total));"),
        ("keyence", "    Part.Low := 8;\n", "Total := ((FC_Low(Part, 4)) * (Total));"),
    ],
)
def test_initial_values_are_set_before_the_statements(
    target: str, started: str, called: str, given: Path
) -> None:
    output = export(target, program=[given], only_needed=True)
    assert output.missing == ()
    text = "".join(output.files.values())
    assert 0 < text.find(started) < text.find(called)


def test_l5x_passes_a_structure_with_initial_values_to_a_function(given: Path) -> None:
    """A structure with initial values is passed to a function as InOut parameter.

    Source: 1756-PM010.
    """
    output = export("l5x", program=[given], only_needed=True)
    assert output.missing == ()
    assert "<![CDATA[FC_Low(FC_Low_1, Part);]]>" in output.files[""]
    assert "<![CDATA[Part.Low := 8;]]>" in output.files[""]


def test_l5x_clears_a_structure_before_it_gets_its_values(tmp_path: Path) -> None:
    """In the Prescan routine, COP clears a structure before its initial values are set.

    Source: Studio 5000 help, FLL: for ladder only.
    """
    file = tmp_path / "Mine.st"
    file.write_text(_WHOLE)
    lines = export("l5x", program=[file], only_needed=True).files[""].splitlines()
    cleared = [at for at, line in enumerate(lines) if "COP(Zero_MINE_SET, All, 1);" in line]
    first = [at for at, line in enumerate(lines) if "All.Few[" in line and ":= 7;" in line]
    assert cleared
    assert first
    assert cleared[0] < first[0]
    assert not [line for line in lines if "FLL" in line or "S:FS" in line]


def test_l5x_leaves_out_a_structure_with_a_member_that_is_left_out(tmp_path: Path) -> None:
    """A structure is left out if the type of a member cannot be exported.

    Source: 1756-PM010: a member's data type must be in the project.
    """
    file = tmp_path / "Long.st"
    file.write_text(
        "TYPE\n  INNER : STRUCT\n    l : LREAL;\n  END_STRUCT;\n"
        "  ROWS : ARRAY [0..3] OF INNER;\n  OUTER : STRUCT\n    Rows : ROWS;\n  END_STRUCT;\n"
        "END_TYPE\n"
        "FUNCTION_BLOCK FB_Long\n  VAR\n    o : OUTER;\n    k : INT;\n  END_VAR\n  k := k + 1;\n"
        "END_FUNCTION_BLOCK\n"
    )
    output = export("l5x", program=[file], only_needed=True)
    assert [str(one) for one in output.missing] == [
        f"{file}:2: TYPE INNER: the type LREAL has no counterpart here",
        f"{file}:6: TYPE OUTER: needs INNER, which cannot be exported",
        f"{file}:10: FUNCTION_BLOCK FB_Long: needs OUTER, which cannot be exported",
    ]
    assert "INNER" not in output.files[""]
