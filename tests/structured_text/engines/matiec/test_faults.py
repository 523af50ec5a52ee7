"""The known faults of matiec are detected in the programs that they affect.

Each row has a program: its declarations, variables and statements. `value` is the value of `V`
after one scan, calculated by hand from IEC 61131-3, or None if matiec cannot compile the program.
Tests with the installed matiec check that it has each fault, and that it runs the unaffected
programs as all engines do.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from structured_text.engines import load as chooser
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.load import build
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.detectors import DETECTORS
from structured_text.engines.matiec.durations import is_exact
from structured_text.engines.matiec.faults import faults, is_new, places, warnings
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.language.library import names_of
from structured_text.language.load import load


class Row(NamedTuple):
    """A program, and the correct value of its variable `V` after one scan."""

    variables: str
    body: str
    value: object
    before: str = ""


_THREE = "TYPE THREE : ARRAY [0..2] OF DINT; END_TYPE\n"
_POINT = "TYPE POINT : STRUCT X : INT; Y : INT; END_STRUCT; END_TYPE\n"

_TWICE = "C(CU := TRUE, PV := 1); C(CU := FALSE); C(CU := TRUE, PV := 1);"
_AGAIN = "C(CU := TRUE, R := FALSE, PV := 1);"

#: For each fault, programs that it affects.
AFFECTED = {
    "for_once": [
        Row("I : INT; V : INT;", "FOR I := 1 TO 1 DO V := V + 1; END_FOR;", 1),
        Row("I : INT; V : INT;", "FOR I := 5 TO 5 BY -1 DO V := V + 1; END_FOR;", 1),
        Row("I : INT; V : INT;", "FOR I := 0 TO 3 BY 5 DO V := V + 1; END_FOR;", 1),
        Row("I : INT; N : INT := 1; V : INT;", "FOR I := 1 TO N DO V := V + 1; END_FOR;", 1),
        Row("I : INT; N : INT := 7; V : INT;", "FOR I := N TO 7 DO V := V + 1; END_FOR;", 1),
    ],
    "for_counter": [
        Row("I : INT; V : INT;", "FOR I := 1 TO 3 DO V := 0; END_FOR; V := I;", 4),
        Row("I : INT; V : INT; B : BOOL;",
            "FOR I := 1 TO 3 DO IF B THEN EXIT; END_IF; END_FOR; IF I > 3 THEN V := 9; END_IF;", 9),
    ],
    "for_limit": [
        Row("U : USINT; V : INT;", "FOR U := 250 TO 255 DO V := V + 1; END_FOR;", 6),
        Row("I : SINT; V : INT;", "FOR I := -120 TO -128 BY -4 DO V := V + 1; END_FOR;", 3),
    ],
    "time_sum": [
        Row("V : BOOL;", "V := T#750ms + T#250ms >= T#1s;", True),
        Row("V : BOOL;", "V := T#1s <= T#750ms + T#250ms;", True),
        Row("V : BOOL; A : TIME;", "A := T#500ms; A := A + A; V := A = T#1s;", True),
        Row("V : BOOL; A : TIME; B : TIME := T#1s;",
            "A := T#500ms + T#500ms; IF FALSE THEN V := FALSE; ELSIF\n A >= B THEN V := TRUE;"
            " END_IF;", True),
        Row("V : BOOL; S : SUM; A : TIME;", "S(A := T#500ms); A := S.B; V := A < T#1s;", False,
            "FUNCTION_BLOCK SUM VAR_INPUT A : TIME; END_VAR VAR_OUTPUT B : TIME; END_VAR"
            " B := A + A; END_FUNCTION_BLOCK"),
        Row("V : INT;", "V := TIME_TO_INT(T#750ms + T#250ms);", 1),
    ],
    "time_literal": [
        Row("V : BOOL;", "V := T#1ms + T#1ms = T#2ms;", True),
        Row("V : BOOL; A : TIME;", "A := T#10ms - T#5ms; A := T#1s300ms + T#1s300ms; "
            "V := A = T#2600ms;", True),
    ],
    "time_product": [
        Row("V : TIME; A : TIME := T#250ms; N : INT := 10;", "V := A * N;", "2.5"),
        Row("V : TIME; A : TIME := T#999ms;", "V := MULTIME(A, 3);", "2.997"),
    ],
    "text_escape": [
        Row("V : STRING := 'a$Nb';", "V := V;", "a\nb"),
        Row("V : STRING;", "V := '$E4c';", "\u00e4c"),
        Row("V : STRING;", "V := 'x$0D1';", "x\r1"),
    ],
    "replace": [
        Row("V : STRING; T : STRING := 'hello';", "V := REPLACE(T, 'Z', 0, 2);", "hZello"),
        Row("V : STRING; T : STRING := 'hello';", "V := REPLACE(T, 'XYZ', 1, 1);", "XYZello"),
    ],
    "find": [Row("V : INT; T : STRING := 'aab';", "V := FIND(T, 'ab');", 2)],
    "limit": [Row("V : INT; A : INT := 5;", "V := LIMIT(10, A, 0);", 0)],
    "counters": [
        # The counter gets two edges in one scan.
        Row("C : CTU; V : INT;", f"{_TWICE} V := C.CV;", 2),
        Row("C : CTU; V : INT;", f"{_TWICE}\nC(CU := FALSE, CV => V);", 2),
        Row("C : CTUD; V : BOOL;", f"{_TWICE} C(CU := FALSE, CD := TRUE); V := C.QU;", True),
        Row("C : CTUD; V : BOOL;",
            "C(CD := TRUE, PV := 1); C(CU := TRUE, CD := FALSE); V := C.QD;", True),
        Row("C : CTD_DINT; V : DINT;", "C(CD := TRUE); V := C.CV;", -1),
        # PV rises after CV has passed it.
        Row("C : CTU; V : BOOL; N : INT := 1;",
            f"{_TWICE.replace('PV := 1', 'PV := N')} N := 2; C(CU := FALSE, PV := N); V := C.Q;",
            True),
        Row("C : CTU; V : BOOL;", f"{_TWICE} C(PV := 2); V := C.Q;", True),
        Row("C : CTU; V : BOOL;", "C(CU := TRUE); C(CU := FALSE, PV := 1); V := C.Q;", True),
        Row("C : CTU; V : BOOL;", f"{_TWICE} C.PV := 2; C(CU := FALSE); V := C.Q;", True),
        # In the first call, Q is FALSE and does not reset the counter, even with a PV of 0.
        Row("C : CTU; V : INT;",
            f"C(CU := TRUE, R := C.Q, PV := 1); C(CU := FALSE); {_AGAIN} V := C.CV;", 2),
        Row("C : CTU; V : INT;", "C(CU := TRUE, R := C.Q, PV := 0); V := C.CV;", 1),
    ],
    "function_array": [
        Row("A : THREE; V : DINT;", "A[1] := 4; V := SECOND_OF(A);", None, _THREE +
            "FUNCTION SECOND_OF : DINT VAR_INPUT L : THREE; END_VAR SECOND_OF := L[1];"
            " END_FUNCTION"),
    ],
    "temp_array": [
        Row("V : DINT; END_VAR VAR_TEMP L : THREE;", "L[1] := 4; V := L[1];", None, _THREE),
        Row("V : INT; END_VAR VAR_TEMP P : POINT;", "P.X := 4; V := P.X;", None, _POINT),
    ],
    "type_alias": [
        Row("V : INT; A : PLACE;", "A.X := 4; V := A.X;", None,
            _POINT + "TYPE PLACE : POINT; END_TYPE"),
    ],
    "nested_array": [
        Row("V : DINT; L : ROWS;", "L[1][2] := 4; V := L[1][2];", None,
            _THREE + "TYPE ROWS : ARRAY [0..1] OF THREE; END_TYPE"),
        Row("V : DINT; S : TABLE;", "S.L[1][2] := 4; V := S.L[1][2];", None,
            _THREE + "TYPE ROWS : ARRAY [0..1] OF THREE; END_TYPE"
            " TYPE TABLE : STRUCT L : ROWS; END_STRUCT; END_TYPE"),
    ],
    "three_blocks": [
        Row("V : BOOL; A, B, C : CTU;", "A(CU := TRUE, PV := 1); V := A.Q;", None),
    ],
    "text_line_feed": [Row("V : STRING;", "V := 'a$Lb';", None)],
}  # fmt: skip

#: Programs similar to affected programs, which no fault affects.
FINE = [
    Row("I : INT; V : INT;", "FOR I := 1 TO 2 DO V := V + 1; END_FOR;", 2),
    Row("I : INT; V : INT;", "FOR I := 1 TO 0 DO V := V + 1; END_FOR;", 0),
    Row("I : INT; V : INT;", "FOR I := 3 TO 1 BY -1 DO V := V + I; END_FOR; I := 0; V := V + I;",
        6),
    Row("I : INT; V : INT;", "FOR I := 1 TO 2 DO V := I; END_FOR; FOR I := 5 TO 6 DO V := V + I;"
        " END_FOR;", 13),
    Row("U : USINT; V : INT;", "FOR U := 250 TO 254 DO V := V + 1; END_FOR;", 5),
    Row("V : BOOL; C : TON;", "C(IN := TRUE, PT := T#100ms); V := C.ET >= T#100ms;", False),
    Row("V : BOOL; A : TIME;", "A := T#750ms + T#250ms; V := A > T#999ms;", True),
    Row("V : BOOL; A : TIME;", "A := T#750ms + T#250ms; V := A > T#1s;", False),
    Row("V : BOOL; A : TIME := T#2s;", "A := A - T#1s; V := A >= T#1s;", True),
    Row("V : BOOL; A : TIME := T#2s;", "V := A = T#2s;", True),
    Row("V : TIME; N : INT := 3000;", "V := T#2s * N;", "6000"),
    Row("V : TIME;", "V := T#250ms * 8;", "2"),
    Row("V : STRING := 'a$Nxb$$b$'1';", "V := V;", "a\nxb$b'1"),
    Row("V : STRING := '$41$42$R0$T9';", "V := V;", "AB\r0\t9"),
    Row("V : STRING; T : STRING := 'hello';", "V := REPLACE(T, 'XY', 2, 1);", "XYllo"),
    Row("V : INT; T : STRING := 'aab';", "V := FIND(T, 'b');", 3),
    Row("V : INT; A : INT := 5;", "V := LIMIT(0, A, 3);", 3),
    Row("A : POINT; V : INT;", "A.X := 4; V := X_OF(A);", 4, _POINT +
        "FUNCTION X_OF : INT VAR_INPUT P : POINT; END_VAR X_OF := P.X; END_FUNCTION"),
    Row("V : INT; END_VAR VAR_TEMP T : INT;", "T := 4; V := T;", 4),
    Row("V : BOOL; A, B : CTU;", "A(CU := TRUE, PV := 1); V := A.Q;", True),
    Row("V : INT; A, B, C : INT;", "A := 4; V := A;", 4),
    Row("V : DINT; L : GRID;", "L[1, 2] := 4; V := L[1, 2];", 4,
        "TYPE GRID : ARRAY [0..1, 0..2] OF DINT; END_TYPE"),
    Row("C : CTU; V : BOOL;", f"{_TWICE} V := C.Q;", True),
    Row("C : CTU; V : BOOL; N : INT := 2;", f"{_TWICE} C(CU := FALSE, Q => V);", True),
    Row("C : CTU; V : BOOL; END_VAR VAR CONSTANT N : INT := 1;",
        f"{_TWICE.replace('PV := 1', 'PV := N')} C(R := TRUE); V := C.Q;", False),
    Row("C : CTD; V : BOOL; N : INT;", "C(CD := TRUE, PV := N); V := C.Q;", True),
    Row("C : CTD_UDINT; V : UDINT;", "C(CD := TRUE); V := C.CV;", 0),
    Row("C : CTU; V : INT; B : BOOL;", "FOR V := 1 TO 5 DO C(CU := NOT B, R := B OR C.Q, PV := 1);"
        " B := NOT B; END_FOR; V := C.CV;", 1),
    Row("C : CTU; V : INT; B : BOOL := TRUE;", "C(CU := B AND NOT C.Q, PV := 1);"
        " C(CU := FALSE); C(CU := B AND NOT C.Q, PV := 1); V := C.CV;", 1),
    Row("V : DINT; A : LIST;", "A[1] := 4; V := A[1];", 4, _THREE +
        "TYPE LIST : THREE; END_TYPE"),
]  # fmt: skip

_ROWS = [pytest.param(name, row, id=f"{name}-{number}")
         for name, rows in AFFECTED.items() for number, row in enumerate(rows)]  # fmt: skip


def _file(row: Row, folder: Path) -> Path:
    file = folder / "program.st"
    text = f"{row.before}\nPROGRAM PROBE\nVAR {row.variables} END_VAR\n{row.body}\nEND_PROGRAM\n"
    file.write_text(text, encoding="utf-8")
    return file


def _shown(value: object) -> object:
    return f"{value.total_seconds():g}" if hasattr(value, "total_seconds") else value


def test_every_fault_has_a_program_that_shows_it() -> None:
    """Every fault that can be detected in the sources has a program.

    Faults that depend on values during the run have no detector.
    """
    assert set(AFFECTED) == set(DETECTORS)
    assert set(faults()) - set(DETECTORS) == {"shift", "int_arithmetic"}


@pytest.mark.parametrize(("name", "row"), _ROWS)
def test_a_program_with_a_fault_is_found_with_its_line(name: str, row: Row, tmp_path: Path) -> None:
    """Each program that a fault affects is reported with file and line.

    Source: issue of the users, and the C code that matiec makes.
    """
    file = _file(row, tmp_path)
    found = [place for place in places(load([file])) if place.fault.name == name]
    assert len(found) == 1
    words = {"for_once": "FOR", "for_limit": "FOR", "time_product": "V :=", "replace": "V :="}
    line = file.read_text(encoding="utf-8").splitlines()[found[0].at.line - 1]
    assert found[0].file == file
    assert words.get(name, "") in line


@pytest.mark.parametrize("row", FINE)
def test_a_program_that_is_not_affected_is_not_reported(row: Row, tmp_path: Path) -> None:
    """Similar programs that no fault affects are not reported.

    Source: the same constructs with other bounds, operators or characters.
    """
    assert [str(place) for place in places(load([_file(row, tmp_path)]))] == []


@pytest.mark.parametrize("row", [row for rows in AFFECTED.values() for row in rows] + FINE)
def test_the_built_in_engine_computes_what_the_standard_says(row: Row, tmp_path: Path) -> None:
    """The built-in engine gives the value that IEC 61131-3 requires.

    Source: IEC 61131-3 by hand.
    """
    if row.value is not None:
        program = BuiltinProgram.build(load([_file(row, tmp_path)]))
        program.scan(0)
        assert _shown(program.read("Main.V")) == row.value


@pytest.mark.exhaustive
@pytest.mark.parametrize(("name", "row"), _ROWS)
def test_matiec_has_the_fault(name: str, row: Row, tmp_path: Path, matiec: Matiec) -> None:
    """The installed matiec computes a wrong value, or its C code does not compile."""
    compiler, versions = find_c_compiler(), faults()[name].versions
    if compiler is None or versions == ("old" if is_new(matiec) else "new"):
        pytest.skip("this version does not have the fault")
    if name == "for_limit":
        pytest.skip("the loop would never end")
    project = load([_file(row, tmp_path)])
    if row.value is None:
        with pytest.raises(InputError, match=r"C code of .* does not compile|crashed"):
            MatiecProgram.build(project, matiec, compiler)
        return
    program = MatiecProgram.build(project, matiec, compiler)
    program.scan(0)
    assert _shown(program.read("Main.V")) != row.value
    program.close()


@pytest.mark.exhaustive
@pytest.mark.parametrize("row", FINE)
def test_matiec_computes_the_others_as_the_standard_says(
    row: Row, tmp_path: Path, matiec: Matiec
) -> None:
    """Matiec gives the standard's value for programs without a fault.

    Source: IEC 61131-3 by hand, on the installed matiec.
    """
    compiler = find_c_compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    program = MatiecProgram.build(load([_file(row, tmp_path)]), matiec, compiler)
    program.scan(0)
    assert _shown(program.read("Main.V")) == row.value
    program.close()


@pytest.mark.parametrize(
    ("nanoseconds", "exact"),
    [(1_000_000, False), (2_000_000, False), (10_000_000, True), (250_000_000, True),
     (1_000_000_000, True), (1_300_000_000, False)],
)  # fmt: skip
def test_durations_that_matiec_stores_inexactly_are_known(nanoseconds: int, exact: bool) -> None:
    """`is_exact` knows the durations that matiec stores one nanosecond too short.

    Source: `__time_to_timespec` of matiec, compiled by gcc on x86.
    """
    assert is_exact(nanoseconds) is exact


@pytest.fixture
def with_matiec(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Simulate an installed recent matiec, and run its programs on the built-in engine."""
    iec2c = tmp_path / "iec2c"
    iec2c.write_bytes(b"... int __do_increment = 0; ...")
    monkeypatch.setattr(chooser, "find_matiec", lambda: Matiec(iec2c, tmp_path, tmp_path))
    monkeypatch.setattr(chooser, "find_c_compiler", lambda: "cc")
    monkeypatch.setattr(MatiecProgram, "build", lambda project, *_: BuiltinProgram.build(project))


@pytest.mark.usefixtures("with_matiec")
def test_auto_runs_an_affected_program_on_the_built_in_engine(tmp_path: Path) -> None:
    """Engine auto runs a program with a matiec fault on the built-in engine and says why.

    Source: docs/reference/engines.md.
    """
    row = AFFECTED["for_once"][0]
    built = build([_file(row, tmp_path)])
    assert built.notice == (
        "FOR that runs once (program.st, line 4): matiec runs it zero times if it should run "
        "exactly once: running on the built-in engine"
    )


@pytest.mark.usefixtures("with_matiec")
def test_matiec_warns_of_an_affected_program(tmp_path: Path) -> None:
    """A program with a known fault of matiec gives a warning with all lines.

    Source: docs/reference/engines.md.
    """
    loop = "FOR I := 1 TO 1 DO V := V + 1; END_FOR;"
    file = _file(Row("I : INT; V : INT;", f"{loop}\n{loop}", 2), tmp_path)
    (line,) = build([file], "matiec").notice.splitlines()
    assert line.startswith(f"warning: {file}:4:1: FOR that runs once (FOR I; also line 5): matiec")


@pytest.mark.usefixtures("with_matiec")
def test_matiec_refuses_what_it_cannot_compile_with_the_line(tmp_path: Path) -> None:
    """Engine matiec refuses an array in VAR_TEMP with its line; auto uses the built-in engine.

    Source: docs/reference/engines.md.
    """
    file = _file(AFFECTED["temp_array"][0], tmp_path)
    with pytest.raises(InputError, match=r"array .*in VAR_TEMP \(L of PROBE\)") as caught:
        build([file], "matiec")
    assert (caught.value.file, caught.value.line) == (str(file), 4)
    assert build([file]).notice.endswith(": running on the built-in engine")


def test_a_library_that_is_tested_with_matiec_is_left_out(tmp_path: Path) -> None:
    """If library.toml has `tested = "matiec"`, faults in the library are not reported.

    Source: docs/reference/engines.md: the library was tested with matiec.
    """
    folder = tmp_path / "lib"
    folder.mkdir()
    file = _file(AFFECTED["time_sum"][0], folder)
    names_of.cache_clear()
    assert places(load([file])) != []
    (tmp_path / "library.toml").write_text('tested = "matiec"\n', encoding="utf-8")
    names_of.cache_clear()
    assert places(load([file])) == []


@pytest.mark.usefixtures("with_matiec")
def test_auto_continues_if_matiec_refuses_the_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If matiec cannot compile the program, auto runs it on the built-in engine and says why.

    Source: docs/reference/engines.md.
    """

    def refuse(*_: object) -> None:
        raise InputError("matiec: no such thing", file=tmp_path / "program.st", line=3)

    monkeypatch.setattr(MatiecProgram, "build", refuse)
    notice = build([_file(FINE[0], tmp_path)]).notice
    assert notice == (
        "matiec cannot compile the program (program.st, line 3): no such thing: running on the "
        "built-in engine"
    )


def test_a_version_is_recognised_by_its_code(tmp_path: Path) -> None:
    """A matiec whose code contains `__do_increment` is recent, any other is old.

    Source: matiec's commit 8a06b3b.
    """
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_bytes(b"while(")
    new.write_bytes(b"int __do_increment = 0;")
    assert not is_new(Matiec(old, tmp_path, tmp_path))
    assert is_new(Matiec(new, tmp_path, tmp_path))


def test_each_fault_is_one_warning_per_file(tmp_path: Path) -> None:
    """The two lines with the same fault give one warning that names both lines.

    Source: `rcx check` shows a construct once, with all its lines.
    """
    file = _file(Row("V : STRING;", "V := 'a$Nb';\nV := 'c$0Ad';", "x"), tmp_path)
    found = places(load([file]))
    assert [place.at.line for place in found] == [4, 5]
    assert [place.detail for place in warnings(found)] == ["$Nb; also line 5"]
