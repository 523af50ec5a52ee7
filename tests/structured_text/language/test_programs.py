"""Tests of program calls by name, the choice among several programs, actions, and open arrays."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from mistakes import check
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load

Build = Callable[[str], BuiltinProgram]
Mistakes = Callable[[str], list[InputError]]

_COUNT = "PROGRAM {0} VAR N : INT; END_VAR N := N + 1; END_PROGRAM\n"


def test_a_program_named_by_several_pous_is_one_instance(build: Build) -> None:
    program = build(
        "FUNCTION_BLOCK FB1 VAR_OUTPUT Q : INT; END_VAR Other.N := Other.N + 10; Q := Other.N;"
        " END_FUNCTION_BLOCK\n"
        + _COUNT.format("Other")
        + "PROGRAM Start VAR F : FB1; Seen : INT; END_VAR Other(); F(); Seen := Other.N;"
        " END_PROGRAM\n"
    )
    program.scan(0)
    program.scan(10_000)
    # In each scan, the program adds 1 and the block adds 10.
    assert (program.read("Main.Seen"), program.read("Other.N")) == (22, 22)
    assert [path for path, _ in program.walk() if path.startswith("Other")] == ["Other", "Other.N"]
    copy = program.instance()
    copy.restore(program.snapshot())
    copy.scan(20_000)
    assert (copy.read("Other.N"), program.read("Other.N")) == (33, 22)


@pytest.mark.parametrize("name", ["MAIN", "PLC_PRG"])
def test_of_several_programs_the_usual_one_runs(name: str, build: Build) -> None:
    program = build(_COUNT.format("Other") + _COUNT.format(name))
    program.scan(0)
    assert program.read("Main.N") == 1
    assert [(one, kind.name) for one, kind in program.instances().items()] == [("Main", name)]


def test_several_programs_need_the_usual_name(mistakes_of: Mistakes) -> None:
    (error,) = mistakes_of(_COUNT.format("P1") + _COUNT.format("P2"))
    assert "several programs and no CONFIGURATION: P1, P2" in str(error)
    assert "MAIN or PLC_PRG" in str(error)


def test_a_program_with_two_instances_cannot_be_named(mistakes_of: Mistakes) -> None:
    (error,) = mistakes_of(
        "PROGRAM Start VAR Seen : INT; END_VAR Seen := Counter.N; END_PROGRAM\n"
        + _COUNT.format("Counter")
        + "CONFIGURATION C RESOURCE R ON PLC TASK T (INTERVAL := T#10ms, PRIORITY := 1);\n"
        "PROGRAM A WITH T : Counter; PROGRAM A2 WITH T : Counter; PROGRAM B WITH T : Start;\n"
        "END_RESOURCE END_CONFIGURATION\n"
    )
    assert "has the instances A and A2" in str(error)


def test_programs_that_call_each_other_are_one_message(build: Build) -> None:
    program = build(
        "PROGRAM MAIN Other(); END_PROGRAM\nPROGRAM Other Third(); END_PROGRAM\n"
        "PROGRAM Third Other(); END_PROGRAM\n"
    )
    with pytest.raises(InputError, match="calls itself"):
        program.scan(0)


def test_a_library_may_have_programs_that_nothing_runs(mistakes_of: Mistakes) -> None:
    source = _COUNT.format("Roots") + "FUNCTION_BLOCK F Roots(); END_FUNCTION_BLOCK\n"
    assert mistakes_of(source) == []


def test_an_action_is_run_for_the_instance_and_sees_its_pins(build: Build) -> None:
    program = build(
        "FUNCTION_BLOCK FB1 VAR_IN_OUT Io : INT; Row : ARRAY [0..1] OF INT; END_VAR\n"
        "VAR N : INT; END_VAR Step(); N := N + 1; END_FUNCTION_BLOCK\n"
        "ACTION Step: Io := Io + 5; Row[1] := Io; IF N > 0 THEN RETURN; END_IF; Io := Io + 100;"
        " END_ACTION\n"
        "PROGRAM P VAR F : FB1; X : INT; A : ARRAY [0..1] OF INT; END_VAR\n"
        "F(Io := X, Row := A); END_PROGRAM\n"
    )
    program.scan(0)
    assert (program.read("Main.X"), program.read("Main.A")) == (105, [0, 5])
    program.scan(10_000)  # RETURN ends the action, not the block.
    assert (program.read("Main.X"), program.read("Main.F.N")) == (110, 2)


def test_an_action_before_the_first_call_cannot_use_a_var_in_out(build: Build) -> None:
    program = build(
        "FUNCTION_BLOCK FB1 VAR_IN_OUT Io : INT; END_VAR Step(); END_FUNCTION_BLOCK\n"
        "ACTION Step: Io := Io + 5; END_ACTION\n"
        "PROGRAM P VAR F : FB1; END_VAR\nF.Step();\nEND_PROGRAM\n"
    )
    with pytest.raises(InputError, match="before the block is called"):
        program.scan(0)


@pytest.mark.parametrize(
    ("body", "message"),
    [("X[9] := 1;", "index 9 is outside 3..4"), ("X[I] := 1;", "index 0 is outside 3..4")],
)
def test_an_index_outside_of_an_open_array_ends_the_run(
    body: str, message: str, build: Build
) -> None:
    program = build(
        f"FUNCTION F1 : INT VAR_IN_OUT X : ARRAY [*] OF INT; END_VAR VAR I : INT; END_VAR\n{body}\n"
        "F1 := 0; END_FUNCTION\n"
        "PROGRAM P VAR A : ARRAY [3..4] OF INT; R : INT; END_VAR R := F1(A); END_PROGRAM\n"
    )
    with pytest.raises(InputError, match=message) as caught:
        program.scan(0)
    assert caught.value.line == 2


@pytest.mark.parametrize(
    ("declaration", "body", "message"),
    [
        ("VAR X : ARRAY [*] OF INT; END_VAR", "", "can only be a VAR_IN_OUT"),
        ("VAR_IN_OUT X : ARRAY [*, 1..2] OF INT; END_VAR", "", "of open length, or none"),
        ("VAR_INPUT X : ARRAY [*] OF INT; END_VAR", "X[1] := 2;", "X is CONSTANT"),
        ("VAR_IN_OUT X, Y : ARRAY [*] OF INT; END_VAR", "X := Y;", "cannot be assigned"),
        (
            "VAR_IN_OUT X : ARRAY [*] OF INT; END_VAR VAR P : POINTER TO INT; END_VAR",
            "P := ADR(X);",
            "has no address",
        ),
        ("VAR_IN_OUT X : ARRAY [*] OF INT; END_VAR", "F1 := SIZEOF(X);", "SIZEOF is not supported"),
        ("VAR_IN_OUT X : ARRAY [*] OF INT; END_VAR", "F1 := UPPER_BOUND(X, 2);", "from 1 to 1"),
    ],
)
def test_an_open_array_refuses_uses_that_need_its_length(
    declaration: str, body: str, message: str, mistakes_of: Mistakes
) -> None:
    errors = mistakes_of(f"FUNCTION F1 : DINT {declaration}\n{body} F1 := 0;\nEND_FUNCTION\n")
    assert errors, "nothing was refused"
    assert message in str(errors[0])


def test_an_open_array_refuses_arrays_of_another_type(mistakes_of: Mistakes) -> None:
    function = "FUNCTION F1 : INT VAR_IN_OUT X : ARRAY [*] OF INT; END_VAR F1 := 0; END_FUNCTION\n"
    for kind in ("ARRAY [1..2] OF DINT", "ARRAY [1..2, 1..2] OF INT", "INT"):
        errors = mistakes_of(
            f"{function}PROGRAM P VAR A : {kind}; I : INT; END_VAR I := F1(A); END_PROGRAM\n"
        )
        assert "needs a ARRAY [*] OF INT" in str(errors[0])


@pytest.mark.parametrize(
    ("declaration", "message"),
    [
        ("VAR X : INT REF= Y; Y : INT; END_VAR", "REF= needs a variable of REFERENCE TO"),
        ("VAR X : BOOL S= TRUE; END_VAR", "S= is not an initial value"),
        ("VAR CONSTANT X : INT := ABS(Y); END_VAR VAR Y : INT; END_VAR", "a constant is expected"),
        ("VAR_TEMP X : INT := ABS(Y); END_VAR VAR Y : INT; END_VAR", "a constant is expected"),
    ],
)
def test_a_wrong_initial_value_is_refused(
    declaration: str, message: str, mistakes_of: Mistakes
) -> None:
    errors = mistakes_of(f"PROGRAM P {declaration}\nY := 1; END_PROGRAM\n")
    assert message in str(errors[0])


_TWO = (
    "CONFIGURATION C RESOURCE R ON PLC TASK T (INTERVAL := T#10ms, PRIORITY := 1);\n"
    "PROGRAM A WITH T : Counter; PROGRAM B WITH T : Start; END_RESOURCE END_CONFIGURATION\n"
)
#: Cases: the source, the number of scans (every 10 ms, the first at 10 ms), and the values after
#: them.
_RUNS: dict[str, tuple[str, int, dict[str, Any]]] = {
    "a program name means its instance in the configuration": (
        "PROGRAM Start VAR Seen : INT; END_VAR Seen := Counter.N; END_PROGRAM\n"
        + _COUNT.format("Counter") + _TWO,
        2, {"A.N": 2, "B.Seen": 2},
    ),
    "a block in a named program starts once": (
        "FUNCTION_BLOCK FB1 VAR_OUTPUT Starts : INT; END_VAR\n"
        "METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR"
        " Starts := Starts + 1; END_METHOD\nEND_FUNCTION_BLOCK\n"
        "PROGRAM Counter VAR F : FB1; END_VAR F(); END_PROGRAM\n"
        "PROGRAM Start VAR Seen : INT; END_VAR Seen := Counter.F.Starts; END_PROGRAM\n" + _TWO,
        1, {"A.F.Starts": 1, "B.Seen": 1},
    ),
    "an array of open length has the bounds of its argument": (
        "FUNCTION Total : DINT VAR_INPUT Row : ARRAY [*] OF INT; END_VAR VAR I : DINT; END_VAR\n"
        "FOR I := LOWER_BOUND(Row, 1) TO UPPER_BOUND(Row, 1) DO Total := Total + Row[I]; END_FOR\n"
        "END_FUNCTION\n"
        "FUNCTION_BLOCK Fill VAR_IN_OUT G : ARRAY [*, *] OF INT; END_VAR VAR I, J : DINT; END_VAR\n"
        "FOR I := LOWER_BOUND(G, 1) TO UPPER_BOUND(G, 1) DO\n"
        "FOR J := LOWER_BOUND(G, 2) TO UPPER_BOUND(G, 2) DO\n"
        "G[I, J] := DINT_TO_INT(10 * I + J); END_FOR END_FOR\n"
        "END_FUNCTION_BLOCK\n"
        "PROGRAM P VAR A : ARRAY [-1..1] OF INT := [1, 2, 4]; B : ARRAY [5..6] OF INT := [8, 16];\n"
        "G : ARRAY [1..2, 0..1] OF INT; F : Fill; S, S2 : DINT; END_VAR\n"
        "S := Total(A); S2 := Total(B); F(G := G); END_PROGRAM\n",
        1, {"Main.S": 7, "Main.S2": 24, "Main.G": [[10, 11], [20, 21]]},
    ),
    "initial values are calculated in each call of a function, once for a program": (
        "FUNCTION Size : INT VAR_INPUT N : INT; END_VAR VAR M : INT := 2 * N; END_VAR\n"
        "M := M + 1; Size := M; END_FUNCTION\n"
        "PROGRAM P VAR A : INT := Size(4); B, C : INT; Own : INT := 3;\n"
        "R : REFERENCE TO INT REF= Own; END_VAR\n"
        "B := Size(1); C := Size(2); R := R + 1; END_PROGRAM\n",
        2, {"Main.A": 9, "Main.B": 3, "Main.C": 5, "Main.Own": 5},
    ),
    "a constant of another type fits if its value fits": (
        "TYPE Mood : (CALM := 1, WILD := 5); END_TYPE\n"
        "PROGRAM P VAR CONSTANT N : DINT := 5; END_VAR\n"
        "VAR I : INT := N; R : REAL := N; M : Mood := N; END_VAR I := I; END_PROGRAM\n",
        0, {"Main.I": 5, "Main.R": 5.0, "Main.M": "WILD"},
    ),
    "a variable may have the name of an edge qualifier": (
        "PROGRAM P VAR R_EDGE, F_EDGE : BOOL; END_VAR\nR_EDGE := TRUE; END_PROGRAM\n",
        1, {"Main.R_EDGE": True, "Main.F_EDGE": False},
    ),
    "all instances of a block share its static variables": (
        "FUNCTION_BLOCK FB1 VAR_STAT N : INT; END_VAR VAR_OUTPUT Q : INT; END_VAR\n"
        "N := N + 1; Q := N; END_FUNCTION_BLOCK\n"
        "PROGRAM P VAR A, B : FB1; END_VAR A(); B(); END_PROGRAM\n",
        1, {"Main.A.Q": 1, "Main.B.Q": 2},
    ),
    "the time in a function is also that of the scan": (
        "FUNCTION Since : TIME VAR_INPUT T0 : TIME; END_VAR Since := TIME() - T0; END_FUNCTION\n"
        "PROGRAM P VAR T1 : TIME; L : LTIME; END_VAR T1 := Since(T#5ms); L := LTIME();\n"
        "END_PROGRAM\n",
        2, {"Main.T1": timedelta(milliseconds=15), "Main.L": timedelta(milliseconds=20)},
    ),
    "outputs widen to their targets": (
        "FUNCTION G : BOOL VAR_OUTPUT N : USINT; END_VAR N := 200; G := TRUE; END_FUNCTION\n"
        "FUNCTION_BLOCK FB1 VAR_OUTPUT N : INT; END_VAR N := -3;\n"
        "METHOD M : BOOL VAR_OUTPUT K : SINT; END_VAR K := -4; M := TRUE; END_METHOD\n"
        "END_FUNCTION_BLOCK\n"
        "PROGRAM P VAR F : FB1; A : UDINT; B, C : DINT; R : REAL; END_VAR\n"
        "G(N => A); F(N => B); F.M(K => C); G(N => R); END_PROGRAM\n",
        1, {"Main.A": 200, "Main.B": -3, "Main.C": -4, "Main.R": 200.0},
    ),
    "a counter may be a bit string": (
        "PROGRAM P VAR B : BYTE; N : INT; END_VAR\n"
        "FOR B := 250 TO 255 DO N := N + 1; END_FOR END_PROGRAM\n",
        1, {"Main.N": 6},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", _RUNS)
def test_a_program_has_these_values_after_some_scans(build: Build, name: str) -> None:
    source, scans, values = _RUNS[name]
    program = build(source)
    for number in range(scans):
        program.scan(10_000 * (number + 1))
    assert {path: program.read(path) for path in values} == values


@pytest.mark.parametrize(
    ("call", "values"),
    [
        ("F(1, B := 2);", [1, 2]),
        ("F(B := 2, A := 1);", [1, 2]),
        ("F(A := 1, 2);", [1, 2]),
        ("R := G(1, B := 2);", [12]),
        ("R := G(A := 1, 2);", [12]),
        ("R := F.M(A := 1, 2);", [12]),
    ],
)
def test_an_unnamed_argument_has_its_place(call: str, values: list[int], build: Build) -> None:
    pins = "VAR_INPUT A : INT; B : INT; END_VAR"
    program = build(
        f"FUNCTION G : INT {pins} G := 10 * A + B; END_FUNCTION\n"
        f"FUNCTION_BLOCK FB1 {pins} METHOD M : INT {pins} M := 10 * A + B; END_METHOD\n"
        "END_FUNCTION_BLOCK\n"
        f"PROGRAM P VAR F : FB1; R : INT; END_VAR {call} END_PROGRAM\n"
    )
    program.scan(0)
    names = ["F.A", "F.B"] if len(values) == 2 else ["R"]
    assert [program.read(f"Main.{name}") for name in names] == values


@pytest.mark.parametrize(
    ("contents", "message"),
    [
        (b"\xff\xfeP\0R\0O\0", "the file is UTF-16"),
        (b"\xef\xbb\xbfPROGRAM P VAR A : INT; END_VAR (* \xe4 *) A := 1; END_PROGRAM", "not UTF-8"),
        (b"PROGRAM P VAR A : INT; END_VAR A := 1; (* no end", "this comment is never closed"),
        (
            b"PROGRAM P VAR A : INT; END_VAR A := " + b"(" * 1000 + b"1" + b")" * 1000
            + b"; END_PROGRAM",
            "",
        ),
        (b"PROGRAM P VAR A : INT; END_VAR A := 1" + b" + A" * 300 + b"; END_PROGRAM", ""),
        (
            b"PROGRAM P VAR A : INT; END_VAR " + b"IF A = 1 THEN " * 1000 + b"A := 2;"
            + b"END_IF; " * 1000 + b"END_PROGRAM",
            "statements inside each other",
        ),
        (b"TYPE A : STRUCT X : B; END_STRUCT END_TYPE TYPE B : STRUCT Y : A; END_STRUCT END_TYPE",
         "a type cannot contain itself: A uses B uses A"),
        (b"FUNCTION F : INT F := F(); END_FUNCTION", "recursion is not supported: F uses F"),
        (b"PROGRAM P A.B^.C(; END_PROGRAM", "is not expected here"),
    ],
)  # fmt: skip
def test_wrong_input_gives_a_message(contents: bytes, message: str, tmp_path: Path) -> None:
    file = tmp_path / "bad.st"
    file.write_bytes(contents)
    errors = check([file])
    assert len(errors) == (1 if message else 0)
    assert all(message in str(error) for error in errors)


def test_a_name_in_two_files_is_one_message(tmp_path: Path) -> None:
    files = [tmp_path / "one.st", tmp_path / "two.st"]
    for file in files:
        file.write_text(_COUNT.format("P"))
    (error,) = check(files)
    assert "P is declared twice" in str(error)
    assert "one.st, line 1" in str(error)


def test_a_mistake_in_a_call_leaves_the_rest_readable(tmp_path: Path) -> None:
    """After an error in a call, the parser reads the declarations that follow."""
    file = tmp_path / "wrong.st"
    file.write_text(
        "PROGRAM P VAR A : INT; END_VAR\nA.B(A)\n;\nTEST_OVER()\nEND_PROGRAM\n"
        "FUNCTION F : INT F := 1; END_FUNCTION\n"
    )
    assert check([file])
    with pytest.raises(InputError):
        load([file])
