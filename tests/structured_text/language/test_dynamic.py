"""ANY, interface queries, __NEW and __DELETE give values that were calculated by hand."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.constructs import refuse

Build = Callable[..., BuiltinProgram]
Mistakes = Callable[..., list[InputError]]

_QUERIES = """
INTERFACE I_Base EXTENDS __SYSTEM.IQueryInterface
  METHOD M : INT END_METHOD END_INTERFACE
INTERFACE I_1 EXTENDS I_Base METHOD D : INT END_METHOD END_INTERFACE
INTERFACE I_2 EXTENDS I_Base END_INTERFACE
INTERFACE I_Alone END_INTERFACE
FUNCTION_BLOCK F1 IMPLEMENTS I_1
  VAR_OUTPUT N : INT := 7; END_VAR
  METHOD M : INT M := 1; END_METHOD METHOD D : INT D := 11; END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK F3 EXTENDS F1 IMPLEMENTS I_2 METHOD D : INT D := 33; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK F2 IMPLEMENTS I_2, I_Alone
  VAR Inner : ARRAY [0..1] OF F1; Found : I_1; END_VAR
  METHOD M : INT M := 2; END_METHOD
  METHOD Ask : INT VAR_INPUT X : I_Base; END_VAR
    IF __QUERYINTERFACE(X, Found) THEN Ask := Found.D(); ELSE Ask := -1; END_IF END_METHOD
END_FUNCTION_BLOCK
"""
_GENERIC = """
TYPE S1 : STRUCT X : BYTE := 5; Y : DINT; END_STRUCT; END_TYPE
TYPE Colour : (RED, GREEN := 3); END_TYPE
FUNCTION F_Class : DINT VAR_INPUT A : ANY; END_VAR
  F_Class := A.diSize; CASE A.TypeClass OF
  __SYSTEM.TYPE_CLASS.TYPE_BOOL: F_Class := F_Class + 1000;
  TYPE_CLASS.TYPE_INT, TYPE_CLASS.TYPE_UINT: F_Class := F_Class + 2000;
  __SYSTEM.TYPE_CLASS.TYPE_STRING: F_Class := F_Class + 3000;
  __SYSTEM.TYPE_CLASS.TYPE_ARRAY: F_Class := F_Class + 4000;
  __SYSTEM.TYPE_CLASS.TYPE_USERDEF: F_Class := F_Class + 5000;
  __SYSTEM.TYPE_CLASS.TYPE_ENUM: F_Class := F_Class + 6000;
  __SYSTEM.TYPE_CLASS.TYPE_POINTER: F_Class := F_Class + 7000;
  __SYSTEM.TYPE_CLASS.TYPE_LTIME: F_Class := F_Class + 8000; END_CASE END_FUNCTION
FUNCTION F_Same : BOOL VAR_INPUT A, B : ANY; END_VAR VAR I : DINT; END_VAR
  RETURN(A.TypeClass <> B.TypeClass OR A.diSize <> B.diSize);
  FOR I := 0 TO A.diSize - 1 DO RETURN(A.pValue[I] <> B.pValue[I]); END_FOR;
  F_Same := TRUE; END_FUNCTION
FUNCTION F_Clear : DINT VAR_INPUT A : ANY_INT; END_VAR VAR I : DINT; END_VAR
  FOR I := 0 TO A.diSize - 1 DO A.pValue[I] := 0; END_FOR; F_Clear := F_Class(A); END_FUNCTION
FUNCTION_BLOCK FB1 VAR_INPUT A : ANY; END_VAR VAR_OUTPUT First : BYTE; END_VAR
  METHOD Size : DINT VAR_INPUT V : ANY_STRING; END_VAR VAR K : __SYSTEM.TYPE_CLASS; END_VAR
    K := V.TypeClass; IF K = __SYSTEM.TYPE_CLASS.TYPE_STRING THEN Size := V.diSize; END_IF
    END_METHOD
  First := A.pValue^; END_FUNCTION_BLOCK
"""
_G_VARS = """ X, Y : INT := 3; R : REAL; B, C : BOOL; N, M : DINT; S : STRING := 'abc'; T : S1;
  E : Colour; P : POINTER TO INT; L : ARRAY [1..5] OF INT; F : FB1; W : WORD := 16#1234; U : UINT;
  D : LTIME; Z : ARRAY [0..1] OF S1; H : DINT := 1; """
_NEW = """
TYPE ST : STRUCT A : INT := 4; B : REAL; END_STRUCT; END_TYPE
VAR_GLOBAL Exits : INT; END_VAR
FUNCTION_BLOCK FBD
  VAR_INPUT A : INT; END_VAR VAR_OUTPUT B : INT; END_VAR VAR Data : POINTER TO ST; T : TON; END_VAR
  METHOD FB_init : BOOL VAR_INPUT R, C : BOOL; END_VAR Data := __NEW(ST); Data^.B := 2.5;
    END_METHOD
  METHOD FB_exit : BOOL VAR_INPUT C : BOOL; END_VAR __DELETE(Data); Exits := Exits * 10 + 1;
    END_METHOD
  METHOD Inc : INT B := B + 1; Inc := B; END_METHOD
  METHOD Leave __DELETE(THIS); END_METHOD
  B := A + Data^.A; END_FUNCTION_BLOCK
FUNCTION_BLOCK FBE EXTENDS FBD
  METHOD FB_exit : BOOL VAR_INPUT C : BOOL; END_VAR Exits := Exits * 10 + 2; END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FBA VAR N : INT; END_VAR
  METHOD FB_init : BOOL VAR_INPUT R, C : BOOL; K : INT; END_VAR N := K * 2; END_METHOD
  METHOD Get : INT Get := N; END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK ABSTRACT FBX METHOD ABSTRACT M : INT END_METHOD END_FUNCTION_BLOCK
TYPE Node : STRUCT Value : INT; Next : POINTER TO Node; END_STRUCT; END_TYPE
FUNCTION F_Sum : INT VAR_INPUT N : INT; END_VAR VAR P : POINTER TO INT; I : INT; END_VAR
  P := __NEW(INT, N); FOR I := 0 TO N - 1 DO P[I] := I; END_FOR;
  FOR I := 0 TO N - 1 DO F_Sum := F_Sum + P[I]; END_FOR; __DELETE(P); END_FUNCTION
"""
_N_VARS = """ D : POINTER TO FBD; Q : POINTER TO FBD; A : POINTER TO FBA; I, K, N : INT; B : BOOL;
  P : POINTER TO INT; S : POINTER TO STRING(10); T : POINTER TO ST; O, H : POINTER TO Node;
  X : FBD; J : INT; E : POINTER TO FBE; R : REFERENCE TO INT; Y : POINTER TO FBX;
  W : POINTER TO POINTER TO INT; V : POINTER TO ARRAY [2..3] OF INT; Z : PVOID; """


def _program(before: str, variables: str, body: str) -> str:
    return f"{before}PROGRAM P1\nVAR {variables} END_VAR\n{body}\nEND_PROGRAM\n"


def _values(build: Build, text: str, expected: dict[str, Any]) -> None:
    program = build(text)
    program.scan(0)
    found = {name: program.read(name if name == "Exits" else f"Main.{name}") for name in expected}
    assert found == expected


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("N := F_Class(B); M := F_Class(X);", {"N": 1001, "M": 2002}),
        ("N := F_Class(S); M := F_Class(L);", {"N": 3127, "M": 4010}),
        ("N := F_Class(T); M := F_Class(E);", {"N": 5008, "M": 6002}),
        ("N := F_Class(P); M := F_Class(A := D);", {"N": 7004, "M": 8008}),
        ("N := F_Class(L[2]); M := F_Class(Z[1].Y);", {"N": 2002, "M": 4}),
        ("P := ADR(L[3]); L[3] := 3; B := F_Same(P^, X); C := F_Same(L[1], X);",
         {"B": True, "C": False}),
        ("B := F_Same(X, Y); C := F_Same(X, U);", {"B": True, "C": False}),
        ("B := F_Same(Z[0], Z[1]); Z[0].Y := 1; C := F_Same(Z[0], Z[1]);",
         {"B": True, "C": False}),
        ("N := F_Clear(X); M := F_Clear(H);", {"N": 2002, "M": 4, "X": 0, "H": 0}),
        ("F(A := W); N := F.Size(S);", {"F.First": 0x34, "N": 127}),
        ("F(A := T.X);", {"F.First": 5}),
    ],
)  # fmt: skip
def test_an_input_of_any_type_gives_pointer_size_and_class(
    build: Build, body: str, expected: dict[str, Any]
) -> None:
    """The input has the pointer, the size and the type class of its argument.

    Source: CODESYS help, "Data Type: ANY, ANY_<type>".
    """
    _values(build, _program(_GENERIC, _G_VARS, body), expected)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("N := F_Class(3);", "ANY takes a variable, not a value"),
        ("N := F_Class(X + 1);", "ANY takes a variable, not a value"),
        ("N := F_Class(F_Class(X));", "ANY takes a variable, not a value"),
        ("N := F_Clear(R);", "ANY_INT does not take a REAL"),
        ("N := F_Clear(W);", "ANY_INT does not take a WORD"),
        ("N := F.Size(X);", "ANY_STRING does not take a INT"),
        ("N := F_Class(F);", "ANY does not take a FB1"),
        ("N := F_Class();", "F_Class takes 1 arguments, not 0"),
        ("N := F_Class(Q);", "Q is not declared"),
    ],
)
def test_a_wrong_argument_for_any_is_refused(
    mistakes_of: Mistakes, body: str, message: str
) -> None:
    text = _program(_GENERIC, _G_VARS, body)
    (found,) = mistakes_of(text)
    assert found.message.startswith(message)
    assert found.line == text.count("\n") - 1


@pytest.mark.parametrize("place", ["VAR A : ANY; END_VAR", "VAR_IN_OUT A : ANY_INT; END_VAR"])
def test_any_is_refused_except_for_inputs(mistakes_of: Mistakes, place: str) -> None:
    (found,) = mistakes_of(f"FUNCTION F9 : INT\n{place} F9 := 1; END_FUNCTION")
    assert re.match("ANY.* is for inputs of functions, methods", found.message)
    assert found.line == 2


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("Base := One; B := __QUERYINTERFACE(Base, First); N := First.D();", {"B": True, "N": 11}),
        ("Base := Two; First := One; B := NOT __QUERYINTERFACE(Base, First) AND First = 0;",
         {"B": True}),
        ("Base := Three; __QUERYINTERFACE(Base, First); N := First.D();", {"N": 33}),
        ("B := __QUERYINTERFACE(Base, First);", {"B": False}),
        ("N := Two.Ask(One); M := Two.Ask(Two);", {"N": 11, "M": -1}),
        ("N := Two.Ask(Three); B := __QUERYINTERFACE(Two.Found, Second);", {"N": 33, "B": True}),
        ("IF __QUERYINTERFACE(Many[1], First) AND_THEN First.M() = 1 THEN N := 5; END_IF;",
         {"N": 5}),
        ("Base := One; B := __QUERYPOINTER(Base, P); N := P^.N + P^.M();", {"B": True, "N": 8}),
        ("Base := Three; B := __QUERYPOINTER(Base, P); N := P^.D();", {"B": True, "N": 33}),
        ("P := ADR(One); Base := Two; B := __QUERYPOINTER(Base, P); M := BOOL_TO_INT(P = 0);",
         {"B": False, "M": 1}),
        ("Base := One; First ?= Base; N := First.D();", {"N": 11}),
        ("First := One; Base := Two; First ?= Base; B := First = 0;", {"B": True}),
        ("B := __QUERYPOINTER(One, Row[2]); N := Row[2]^.N;", {"B": True, "N": 7}),
    ],
)  # fmt: skip
def test_both_query_operators_lead_to_the_same_block(
    build: Build, body: str, expected: dict[str, Any]
) -> None:
    """Both query operators lead to the same block.

    Sources are the pages "Operator '__QUERYINTERFACE'" and "… '__QUERYPOINTER'" of CODESYS.
    """
    variables = """ One : F1; Two : F2; Three : F3; Base : I_Base; First : I_1; Second : I_2;
      B : BOOL; N, M : INT; P : POINTER TO F1; Many : ARRAY [0..1] OF F1;
      Row : ARRAY [1..2] OF POINTER TO F1; Z : REF_TO F1; """
    _values(build, _program(_QUERIES, variables, body), expected)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("B := __QUERYINTERFACE(Base);", "__QUERYINTERFACE takes 2 arguments, not 1"),
        ("B := __QUERYINTERFACE(N, Base);", "__QUERYINTERFACE needs an interface or block"),
        ("B := __QUERYINTERFACE(Base, N);", "__QUERYINTERFACE needs a variable of an interface"),
        ("B := __QUERYINTERFACE(Base, 0);", "__QUERYINTERFACE needs a variable for its result"),
        ("B := __QUERYINTERFACE(Base, Alone);", "__QUERYINTERFACE cannot query I_Alone"),
        ("B := __QUERYINTERFACE(Alone, Base);", "__QUERYINTERFACE cannot query I_Alone"),
        ("B := __QUERYPOINTER(Base, P);", "__QUERYPOINTER needs a POINTER TO a function block"),
        ("N := __QUERYPOINTER(Base, Q);", "a INT is expected here"),
    ],
)
def test_a_wrong_query_is_refused(mistakes_of: Mistakes, body: str, message: str) -> None:
    variables = " Base : I_Base; Alone : I_Alone; B : BOOL; N : INT; P : POINTER TO INT;"
    text = _program(_QUERIES, f"{variables} Q : POINTER TO F1; ", body)
    (found,) = mistakes_of(text)
    assert found.message.startswith(message)
    assert found.line == text.count("\n") - 1


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("D := __NEW(FBD); D^(A := 3, B => N); I := D^.Inc();", {"N": 7, "I": 8}),
        ("D := __NEW(FBD); __DELETE(D); IF D = 0 THEN N := 1; END_IF;", {"N": 1, "Exits": 1}),
        ("D := __NEW(FBE); N := D^.Inc(); E := __NEW(FBE); __DELETE(E);", {"N": 1, "Exits": 21}),
        ("D := __NEW(FBD); D^.Leave(); N := 1;", {"N": 1, "Exits": 1}),
        ("__DELETE(D); N := 1;", {"N": 1, "Exits": 0}),
        ("N := F_Sum(5); I := F_Sum(1);", {"N": 10, "I": 0}),
        ("A := __NEW(FBA(K := 21)); N := A^.Get(); A := __NEW(FBA(4)); I := A^.Get();",
         {"N": 42, "I": 8}),
        ("P := __NEW(INT); P^ := P^ + 5; N := P^; P := __NEW(INT); I := P^;", {"N": 5, "I": 0}),
        ("S := __NEW(STRING(10)); S^ := 'abcdefghijkl'; N := LEN(S^);", {"N": 10}),
        ("T := __NEW(ST, 3); T[2].A := 9; N := T[2].A * 10 + T[1].A; __DELETE(T);", {"N": 94}),
        ("W := __NEW(POINTER TO INT, 2); W[1] := ADR(J); J := 6; P := W[1]; N := P^;", {"N": 6}),
        ("V := __NEW(ARRAY [2..3] OF INT); V^[3] := 7; N := V^[3] + V^[2]; Z := __NEW(INT);"
         " B := Z <> 0;", {"N": 7, "B": True}),
        ("K := -1; P := __NEW(INT, K); B := P = 0;", {"B": True}),
        ("FOR I := 1 TO 3 DO H := __NEW(Node); H^.Value := I; H^.Next := O; O := H; END_FOR;"
         "WHILE H <> 0 DO N := N * 10 + H^.Value; O := H^.Next; __DELETE(H); H := O; END_WHILE;",
         {"N": 321}),
    ],
)  # fmt: skip
def test_new_makes_started_variables_and_delete_ends_them(
    build: Build, body: str, expected: dict[str, Any]
) -> None:
    """__NEW makes initialised variables, and __DELETE removes them.

    Source: CODESYS help, "Operator '__NEW'" and "Operator '__DELETE'".
    """
    _values(build, _program(_NEW, _N_VARS, body), expected)


def test_system_iqueryinterface_is_a_known_type(build: Build) -> None:
    _values(
        build, _program("", "I : __SYSTEM.IQueryInterface; B : BOOL;", "B := I = 0;"), {"B": True}
    )


def test_a_snapshot_has_the_variables_that_new_has_made(build: Build) -> None:
    """A snapshot contains variables that __NEW has made.

    By hand: the list is 3, 2, 1, and __NEW has initialised the block's data.
    """
    body = """IF J = 0 THEN D := __NEW(FBD); D^(A := 1);
      FOR I := 1 TO 3 DO H := __NEW(Node); H^.Value := I; H^.Next := O; O := H; END_FOR;
      P := __NEW(INT, 3); P[1] := 6; P := ADR(P[1]); Q := D;
    ELSE O^.Value := 5; D^(A := 7); P^ := P^ + 1; END_IF;
    J := J + 1; I := D^.B; H := O; N := 0;
    WHILE H <> 0 DO N := N * 10 + H^.Value; H := H^.Next; END_WHILE; K := P^; B := Q = D;"""
    program = build(_program(_NEW, _N_VARS, body))
    fresh = program.snapshot()
    other = program.instance()
    program.scan(0)
    held = program.snapshot()

    def values(one: BuiltinProgram) -> list[Any]:
        return [one.read(f"Main.{name}") for name in ("J", "N", "I", "K", "B")]

    assert values(program) == [1, 321, 5, 6, True]
    program.scan(0)
    assert values(program) == [2, 521, 11, 7, True]
    for one in (program, other):
        one.restore(held)
        assert values(one) == [1, 321, 5, 6, True]
        one.scan(0)
        assert values(one) == [2, 521, 11, 7, True]
    program.restore(held)
    program.scan(0)
    program.restore(fresh)
    program.scan(0)
    assert values(program) == [1, 321, 5, 6, True]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("P := ADR(N); __DELETE(P);", "__DELETE needs a pointer to a variable that __NEW"),
        ("D := __NEW(FBD); Q := D; __DELETE(D); __DELETE(Q);", "__DELETE needs a pointer to"),
        ("D := __NEW(FBD); __DELETE(D); N := D^.Inc();", "the pointer is 0"),
    ],
)
def test_a_wrong_pointer_stops_the_program(build: Build, body: str, message: str) -> None:
    text = _program(_NEW, _N_VARS, body)
    with pytest.raises(InputError, match=re.escape(message)) as found:
        build(text).scan(0)
    assert found.value.line == text.count("\n") - 1


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("N := 1 + __NEW(INT);", "__NEW cannot stand here"),
        ("__NEW(INT);", "__NEW cannot stand here"),
        ("N := __NEW(INT);", "__NEW needs a pointer to assign to, not a INT"),
        ("P := __NEW();", "__NEW takes a type"),
        ("P := __NEW(3);", "__NEW needs the name of a type"),
        ("P := __NEW(Nothing);", "there is no type Nothing"),
        ("D := __NEW(FBD, 3);", "__NEW makes one block at a time"),
        ("P := __NEW(INT, 2.5);", "a count must be|expected here"),
        ("A := __NEW(FBA);", "the argument K of FBA.FB_init is missing"),
        ("D := __NEW(FBD(K := 1));", "FBD has no FB_init that takes arguments"),
        ("D := __NEW(FBA(K := 1));", "cannot lead to a FBA"),
        ("Y := __NEW(FBX);", "FBX is ABSTRACT and has no instances"),
        ("N := ABS(POINTER TO INT);", "a type cannot stand here"),
        ("__DELETE(N);", "__DELETE needs a variable that is a pointer"),
        ("__DELETE();", "__DELETE needs a variable that is a pointer"),
        ("N := __DELETE(P);", "__DELETE cannot stand here"),
    ],
)
def test_a_wrong_new_or_delete_is_refused(mistakes_of: Mistakes, body: str, message: str) -> None:
    text = _program(_NEW, _N_VARS, body)
    found = mistakes_of(text)
    assert re.search(message, found[0].message), found[0].message
    assert found[0].line == text.count("\n") - 1


@pytest.mark.parametrize(
    ("construct", "text"),
    [
        ("ANY", _GENERIC + "PROGRAM P1 VAR I : INT; END_VAR I := 1; END_PROGRAM"),
        ("__NEW or __DELETE", _NEW + "PROGRAM P1 VAR I : INT; END_VAR I := 1; END_PROGRAM"),
        ("__QUERYINTERFACE or __QUERYPOINTER",
         _QUERIES + "PROGRAM P1 VAR I : INT; END_VAR I := 1; END_PROGRAM"),
    ],
)  # fmt: skip
def test_other_tools_refuse_the_construct_by_name(
    build: Build, project_of: Callable[..., Any], construct: str, text: str
) -> None:
    project = project_of(text)
    alone = [use for use in project.uses if use.construct == construct]
    with pytest.raises(InputError, match=re.escape(f"rcx prove does not take {construct}")):
        refuse(alone, "rcx prove")
