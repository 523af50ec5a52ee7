"""`rcx export l5x` translates Structured Text for Logix, or rejects what Logix lacks."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from exported import left_out
from rcx_harness.cell.exports import export
from rcx_harness.cell.sources import source_files
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.export.l5x import body as l5x_body
from structured_text.export.output import Output, write


def _exported(folder: Path, text: str) -> Output:
    source = folder / "Mine.st"
    source.write_text(text)
    return export("l5x", program=[source], only_needed=True)


def _lines(folder: Path, variables: str, statements: str, declared: str = "") -> list[str]:
    """Export a block with these variables and statements, and return its exported statements."""
    block = (
        f"FUNCTION_BLOCK FB_Mine\n  VAR\n{variables}\n  END_VAR\n{statements}\nEND_FUNCTION_BLOCK"
    )
    output = _exported(folder, f"{declared}\n{block}\n")
    assert left_out(output) == ()
    root = ET.fromstring(output.files[""])
    (routine,) = root.iterfind(
        ".//AddOnInstructionDefinition[@Name='FB_Mine']/Routines/Routine[@Name='Logic']"
    )
    return [(line.text or "").strip("\n") for line in routine.iter("Line")]


_DECLARATIONS = """\
TYPE
  FEW : (FEW_NONE, FEW_SOME);
END_TYPE
TYPE
  ROW : ARRAY [1..3] OF DINT;
END_TYPE
TYPE
  PAIR : STRUCT
    a, b : BOOL;
  END_STRUCT;
END_TYPE
"""


@pytest.mark.parametrize(
    ("variables", "statement", "wanted"),
    [
        ("w : WORD;", "w := NOT w;", ["w := ((NOT w) AND 16#FFFF);"]),
        ("u : UINT;", "u := u - UINT#1;", ["u := ((u - 1) AND 16#FFFF);"]),
        ("w : WORD;", "w := SHL(w, 12);", ["w := ((w * 4096) AND 16#FFFF);"]),
        ("w : WORD;", "w := SHR(w, 8);", ["w := (w / 256);"]),
        ("w : WORD; i : INT;", "w := INT_TO_WORD(i);", ["w := (i AND 16#FFFF);"]),
        ("w : WORD; i : INT;", "i := WORD_TO_INT(w);",
         ["i := ((w AND 16#7FFF) - (w AND 16#8000));"]),
        ("t : TIME;", "t := T#1m + T#5ms;", ["t := 60000 + 5;"]),
        ("e : FEW;", "e := FEW_SOME;", ["e := 1(*FEW_SOME*);"]),
        ("a, b, c : BOOL;", "c := a = b;", ["c := NOT (a XOR b);"]),
        ("a, b, c : BOOL;", "c := a <> b;", ["c := a XOR b;"]),
        ("a : BOOL;", "a := TRUE;", ["a := 1;"]),
        ("a : ROW; b : ROW;", "a := b;", ["COP(b[0], a[0], 4);"]),
        ("a : ROW;", "a[3] := a[1];", ["a[3] := a[1];"]),
        ("a : PAIR; b : PAIR;", "a := b;", ["COP(b, a, 1);"]),
        ("a : STRING;", "a := 'it$'s $$5$0A';", ["a := 'it$'s $$5$0A';"]),
        ("a : STRING; b : STRING;", "a := b;", ["COP(b, a, 1);"]),
        ("d : DINT; r : REAL;", "d := REAL_TO_DINT(r * 2.0);", ["d := r * 2.0;"]),
        ("d : DINT; r : REAL;", "r := DINT_TO_REAL(d) / 3.0;",
         ["Temp_R1 := d;", "r := Temp_R1 / 3.0;"]),
        ("a : BOOL; w : WORD;", "w := BOOL_TO_WORD(a);",
         ["Temp_D1 := 0;", "IF a THEN", "  Temp_D1 := 1;", "END_IF;", "w := Temp_D1;"]),
        ("i : DINT; a : BOOL;", "IF a THEN\n RETURN;\nEND_IF;\ni := 1;",
         ["IF NOT (a) THEN", "  i := 1;", "END_IF;"]),
        ("i : DINT;", "CASE i OF\n 1, 3..4: i := 2;\n ELSE\n i := 0;\nEND_CASE;",
         ["CASE i OF", "  1, 3..4:", "    i := 2;", "ELSE", "  i := 0;", "END_CASE;"]),
        ("Timer : TON; a : BOOL;", "Timer(IN := a, PT := T#5s);\na := Timer.Q;",
         ["Timer.IN := a;", "Timer.PT := 5000;", "RCX_TON(Timer);", "a := Timer.Q;"]),
        ("i : DINT; s : STRING;", "(* so *)\ni := LEN(IN := s);", ["(* so *)", "i := s.LEN;"]),
    ],
)  # fmt: skip
def test_a_statement_is_written_with_instructions_of_logix(
    tmp_path: Path, variables: str, statement: str, wanted: list[str]
) -> None:
    """Each statement is exported with the instructions and syntax of Logix.

    Source: 1756-PM007, Structured Text; 1756-RM003, COP and TONR.
    """
    assert _lines(tmp_path, variables, statement, _DECLARATIONS) == wanted


_DOUBLE = """\
FUNCTION FC_Limited : DINT
  VAR_INPUT
    Value : DINT;
    Most  : DINT := 9;
  END_VAR
  FC_Limited := Value;
  IF Value > Most THEN
    FC_Limited := Most;
  END_IF;
END_FUNCTION
"""


def test_a_function_is_called_before_the_statement_that_uses_it(tmp_path: Path) -> None:
    """In Logix, a function is called in a statement of its own.

    Omitted arguments get their defaults.
    """
    wanted = ["FC_Limited_1.Value := i;", "FC_Limited_1.Most := 9;", "FC_Limited(FC_Limited_1);"]
    wanted += ["Temp_D1 := FC_Limited_1.FcResult;", "i := Temp_D1 + 1;"]
    assert _lines(tmp_path, "i : DINT;", "i := FC_Limited(Value := i) + 1;", _DOUBLE) == wanted


def test_a_condition_with_a_function_is_calculated_in_each_cycle_of_a_loop(tmp_path: Path) -> None:
    body = "WHILE FC_Limited(Value := i) < 5 DO\n  i := i + 1;\nEND_WHILE;"
    lines = _lines(tmp_path, "i : DINT;", body, _DOUBLE)
    calls = [place for place, line in enumerate(lines) if "FC_Limited(" in line]
    assert lines[calls[0] + 2] == "WHILE Temp_D1 < 5 DO"
    assert [line.strip() for line in lines[calls[1] :]] == [
        "FC_Limited(FC_Limited_1);",
        "Temp_D1 := FC_Limited_1.FcResult;",
        "END_WHILE;",
    ]


def test_the_condition_of_repeat_is_calculated_after_each_cycle(tmp_path: Path) -> None:
    body = "REPEAT\n i := i + 1;\nUNTIL FC_Limited(Value := i) > 4\nEND_REPEAT;"
    lines = _lines(tmp_path, "i : DINT;", body, _DOUBLE)
    assert lines[:2] == ["REPEAT", "  i := i + 1;"]
    asked = ["  FC_Limited(FC_Limited_1);", "  Temp_D1 := FC_Limited_1.FcResult;"]
    assert lines[-4:] == [*asked, "UNTIL Temp_D1 > 4", "END_REPEAT;"]


def test_a_later_condition_is_calculated_only_if_needed(tmp_path: Path) -> None:
    body = "IF i > 3 THEN\n i := 0;\nELSIF FC_Limited(Value := i) < 5 THEN\n i := 1;\n"
    lines = _lines(tmp_path, "i : DINT;", f"{body}ELSE\n i := 2;\nEND_IF;", _DOUBLE)
    assert lines[:3] == ["IF i > 3 THEN", "  i := 0;", "ELSE"]
    asked = ["  IF Temp_D1 < 5 THEN", "    i := 1;", "  ELSE", "    i := 2;", "  END_IF;",
             "END_IF;"]  # fmt: skip
    assert lines[-6:] == asked


_PROBE = """\
PROGRAM Probe
  VAR
    InputArea  : RCX_IMAGE;
    OutputArea : RCX_IMAGE;
    k, i       : INT;
    d, back    : DINT;
    e, mixed   : DINT;
    lw, hw, w  : WORD;
    x, y, z    : WORD;
    b          : BYTE;
    u          : UINT;
    far        : BOOL;
    r, same    : REAL;
    bits       : DWORD;
    text       : STRING;
    code, part : WORD;
    wrong      : WORD;
    long       : WORD;
    slow       : TON;
    twice      : TON;
    slow_q     : BOOL;
    slow_et    : DINT;
    twice_q    : BOOL;
    edge       : R_TRIG;
    edges      : INT;
    n          : INT;
  END_VAR
  k := k + 1;
  d := d * 3 + 12345 - INT_TO_DINT(k);
  IF k MOD 9 = 0 THEN
    d := -2147483647;
  ELSIF k MOD 9 = 5 THEN
    d := 2147483647;
  ELSIF d > 100000000 THEN
    d := 0 - d / 7;
  END_IF;
  lw := FC_RcxLowWord(Value := d);
  hw := FC_RcxHighWord(Value := d);
  back := FC_RcxDoubleWord(LowWord := lw, HighWord := hw);
  mixed := FC_RcxDoubleWord(LowWord := lw XOR hw, HighWord := hw OR lw);
  i := WORD_TO_INT(lw);
  w := INT_TO_WORD(i) XOR NOT hw;
  x := SHL(w, 5) OR SHR(w, 9);
  y := SHR(lw, 1) XOR SHL(hw, 15);
  z := FC_RcxWord(LowByte := WORD_TO_BYTE(lw AND WORD#16#00FF), HighByte := b);
  b := FC_RcxByteWithBit(Value := b, Digit := k MOD 8, State := k MOD 3 = 0);
  u := u - UINT#1007;
  far := u > UINT#32767;
  r := DINT_TO_REAL(d) / 1024.0;
  e := REAL_TO_DINT(r);
  bits := FC_RcxRealBits(Value := r);
  same := FC_RcxBitsReal(Pattern := bits);
  code := FC_RcxCharCode(Text := 'Robot $7E 12$'', Position := k);
  part := FC_RcxTextWord(Text := 'ABCDE', Number := k MOD 4 + 1);
  text := FC_RcxText(Word1 := WORD#16#4241, Word2 := part, Word3 := WORD#16#2020);
  wrong := FC_RcxNameError(Text := text, Longest := k MOD 6);
  long := FC_RcxTextError(Text := text, Longest := 2 + k MOD 2);
  slow(IN := k MOD 13 <> 0, PT := T#45ms);
  slow_q := slow.Q;
  slow_et := FC_RcxMilliseconds(Value := slow.ET);
  twice(IN := TRUE, PT := T#20ms);
  twice_q := twice.Q;
  IF twice.Q THEN
    twice(IN := FALSE, PT := T#20ms);
    twice(IN := TRUE, PT := T#20ms);
  END_IF;
  edge(CLK := k MOD 4 < 2);
  n := 0;
  WHILE FC_RcxCharCode(Text := text, Position := n + 1) <> WORD#16#0020 AND n < 20 DO
    n := n + 1;
  END_WHILE;
  IF edge.Q THEN
    edges := edges + 1;
  END_IF;
  OutputArea[k] := b;
END_PROGRAM
"""


def _values(program: Program, scans: int) -> list[dict[str, object]]:
    names = _PROBE.partition("END_VAR")[0].partition("k, i")[2].replace(":", ",")
    watched = ["k", "i", *(one.strip() for one in names.replace(";", ",").split(","))]
    blocks = ("slow", "twice", "edge")
    watched = [one for one in watched if one.islower() and one not in blocks]
    found = []
    for scan in range(scans):
        program.scan(scan * 10_000)
        read = {one: program.read(f"Main.{one}") for one in watched}
        found.append({key: _unsigned(key, value) for key, value in read.items()})
        found[-1]["image"] = program.read_bytes("Main.OutputArea", 0, 64)
    return found


def _unsigned(key: str, value: object) -> object:
    """Convert a DINT to the DWORD with the same bits."""
    return value & 0xFFFFFFFF if key == "bits" and isinstance(value, int) else value


@pytest.fixture
def probe(tmp_path: Path) -> tuple[Program, Program]:
    """Return a program that is hard to export, and the same program read back from its L5X file."""
    source = tmp_path / "Probe.st"
    source.write_text(_PROBE)
    output = export("l5x", program=[source], only_needed=True)
    assert left_out(output) == ()
    (file,) = write(output, tmp_path / "probe.L5X")
    files = (source_files([one], None).all for one in (source, file))
    original, back = (build(list(one), "builtin").program for one in files)
    return original, back


def test_words_texts_reals_and_timers_keep_their_values(probe: tuple[Program, Program]) -> None:
    """The original and the program read back have equal values in 60 scans.

    The values show bit patterns, wrap-around, signs, rounding, characters and timers.
    """
    original, back = probe
    wanted = _values(original, 60)
    assert _values(back, 60) == wanted
    for one in wanted[0]:
        assert len({str(values[one]) for values in wanted}) > 1, f"{one} never changes"


@pytest.mark.parametrize(
    ("variables", "statement", "message"),
    [
        ("i : DINT;", "FOR i := 1 TO 3 DO\n i := i;\nEND_FOR;",
         "Mine.st:5: FUNCTION_BLOCK FB_Mine: a FOR loop"),
        ("l : LREAL;", "l := 1.0;",
         "Mine.st:3: FUNCTION_BLOCK FB_Mine: the type LREAL has no counterpart"),
        ("t : TIME;", "t := T#1ms / 2;", "a TIME cannot be multiplied or divided"),
        ("d : UDINT;", "d := UDINT#4000000000;", "does not fit a DINT"),
        ("c : CTU;", "c(CU := TRUE);",
         "Mine.st:3: FUNCTION_BLOCK FB_Mine: CTU is not on the list for Structured Text of "
         "Logix; count"),
        (f"{'n' * 41} : BOOL;", f"{'n' * 41} := TRUE;", "longer than 40 characters"),
        ("i : INT;", "i := MIN(i, 3);",
         "Mine.st:5: FUNCTION_BLOCK FB_Mine: MIN is not on the list for"),
        ("s : STRING;", f"s := '{'x' * 83}';", "more than 82 characters"),
        ("a : BOOL;", "IF a THEN\n a := FALSE;\n RETURN;\nEND_IF;", "a RETURN that is not the"),
        ("x : DWORD; i : INT;", "x := SHL(x, i);", "a DWORD cannot be shifted by a variable"),
        ("Temp_D1 : BOOL; i : INT;", "i := WORD_TO_INT(SHL(INT_TO_WORD(i), 2));", "uses a name"),
    ],
)  # fmt: skip
def test_a_part_that_is_not_carried_is_named(
    tmp_path: Path, variables: str, statement: str, message: str
) -> None:
    """A block that Logix cannot have is reported, and also the program that needs the block."""
    block = (
        f"FUNCTION_BLOCK FB_Mine\n  VAR\n{variables}\n  END_VAR\n{statement}\nEND_FUNCTION_BLOCK"
    )
    user = "PROGRAM Mine\n  VAR\n    It : FB_Mine;\n  END_VAR\n  It();\nEND_PROGRAM"
    output = _exported(tmp_path, f"{block}\n{user}\n")
    assert left_out(output)[0].startswith("FUNCTION_BLOCK FB_Mine: ")
    assert message in str(output.missing[0])
    assert left_out(output)[1] == "PROGRAM Mine: needs FB_Mine, which cannot be exported"
    assert "FB_Mine" not in output.files[""]


def test_an_instruction_that_logix_lacks_is_never_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If the translation contains an instruction that Logix lacks, the block is left out.

    Source: Studio 5000 help, FLL: for ladder only.
    """
    monkeypatch.setattr(l5x_body, "copied", lambda source, target, *_: f"FLL(0, {target}, 1);")
    body = "  VAR\n    a, b : PAIR;\n  END_VAR\n  (* MOV(a) *)\n  a := b;\n"
    output = _exported(
        tmp_path, f"{_DECLARATIONS}FUNCTION_BLOCK FB_Mine\n{body}END_FUNCTION_BLOCK\n"
    )
    said = "FUNCTION_BLOCK FB_Mine: Structured Text of Logix has no FLL: FLL(0, a, 1);"
    assert left_out(output) == (said,)
    assert "FLL" not in output.files[""]


def test_a_second_program_is_named_and_a_structure_begins_with_its_values(tmp_path: Path) -> None:
    text = "TYPE\n  T_A : STRUCT\n    a : INT := 3;\n  END_STRUCT;\nEND_TYPE\n"
    text += "PROGRAM One\n  VAR\n    a : T_A;\n  END_VAR\n  a.a := 1;\nEND_PROGRAM\n"
    text += "PROGRAM Two\n  VAR\n    b : BOOL;\n  END_VAR\n  b := TRUE;\nEND_PROGRAM\n"
    text += "PROGRAM Three\n  VAR\n    b : BOOL;\n  END_VAR\n  b := TRUE;\nEND_PROGRAM\n"
    text += "CONFIGURATION All\n  RESOURCE Res0 ON PLC\n"
    text += "    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 0);\n"
    for name in ("One", "Two", "Three"):
        text += f"    PROGRAM Run{name} WITH Cyclic : {name};\n"
    text += "  END_RESOURCE\nEND_CONFIGURATION\n"
    output = _exported(tmp_path, text)
    said = "\n".join(left_out(output))
    assert "PROGRAM Two: a file holds one program" in said
    assert "PROGRAM Three: a file holds one program" in said
    root = ET.fromstring(output.files[""])
    assert root.attrib["TargetName"] == "One"
    assert "PROGRAM One" not in said
    assert "  a.a := 3;" in output.files[""]
