"""Programs with one construct each, as input of matiec.

They complete those in test_constructs.py.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

from structured_text.engines.matiec.build import find_matiec

_F = "FUNCTION_BLOCK FB1 {} END_FUNCTION_BLOCK"
_OWN = "VAR_INPUT X : INT; END_VAR VAR_OUTPUT Y : INT; END_VAR VAR K : INT; END_VAR {} K := X;"

#: For each construct: the text before the program, its variables and its statements.
HABITS: dict[str, tuple[str, str, str]] = {
    "VAR_IN_OUT CONSTANT": (
        _F.format("VAR_IN_OUT CONSTANT X : INT; END_VAR VAR K : INT; END_VAR K := X;"),
        "A : FB1; I : INT;",
        "A(X := I);",
    ),
    "a UNION": ("TYPE U1 : UNION A : INT; B : WORD; END_UNION END_TYPE", "I : INT;", "I := 1;"),
    "VAR_INST": (_F.format("VAR_INST K : INT; END_VAR K := 1;"), "A : FB1;", "A();"),
    "VAR_EXTERNAL in a FUNCTION": (
        "FUNCTION F1 : INT VAR_EXTERNAL G1 : INT; END_VAR VAR_INPUT A : INT; END_VAR"
        " F1 := G1 + A; END_FUNCTION",
        "I : INT;",
        "I := F1(2);",
    ),
    "a block in another section than VAR": (
        _F.format("VAR_INPUT T : TON; END_VAR VAR K : INT; END_VAR K := 1;"),
        "A : FB1;",
        "A();",
    ),
    "an ACTION": (
        "",
        "I : INT;",
        "I := 1; END_PROGRAM ACTION A1 : I := 2; END_ACTION"
        " PROGRAM P2 VAR J : INT; END_VAR J := 1;",
    ),
    "a PROGRAM called by its name": (
        "PROGRAM P2 VAR J : INT; END_VAR J := 1; END_PROGRAM",
        "I : INT;",
        "P2(); I := P2.J;",
    ),
    "an array of open length": (
        "FUNCTION F1 : INT VAR_IN_OUT X : ARRAY [*] OF INT; END_VAR F1 := X[1]; END_FUNCTION",
        "A : ARRAY [1..2] OF INT; I : INT;",
        "I := F1(A);",
    ),
    "the time as a function": ("", "T1 : TIME;", "T1 := TIME();"),
    "a calculated initial value": ("", "I : INT := ABS(-7);", "I := 1;"),
    "memory looked at as another type": (
        "",
        "P : POINTER TO DWORD; R : REAL;",
        "P := ADR(R); P^ := 1;",
    ),
    "pointers compared by < or >": (
        "",
        "A : ARRAY [0..3] OF INT; B : BOOL;",
        "B := ADR(A[1]) < ADR(A[3]);",
    ),
    "a character of a text by its number": ("", "S : STRING; B : BYTE;", "B := S[1];"),
    "a located array": ("", "A AT %QW4 : ARRAY [1..2] OF INT; I : INT;", "I := A[1];"),
    "a located structure": (
        "TYPE S1 : STRUCT A : INT; B : INT; END_STRUCT; END_TYPE",
        "A AT %QW4 : S1; I : INT;",
        "I := A.A;",
    ),
    "a METHOD": (
        _F.format("VAR K : INT; END_VAR METHOD M1 : INT M1 := 1; END_METHOD K := 1;"),
        "A : FB1; I : INT;",
        "I := A.M1();",
    ),
    "a PROPERTY": (
        _F.format("PROPERTY P : INT GET P := 1; END_GET END_PROPERTY"),
        "A : FB1; I : INT;",
        "I := A.P;",
    ),
    "an INTERFACE": ("INTERFACE I1 END_INTERFACE", "I : INT;", "I := 1;"),
    "EXTENDS": (
        _F.format(_OWN.format("")) + " FUNCTION_BLOCK FB2 EXTENDS FB1 VAR L : INT; END_VAR L := 1;"
        " END_FUNCTION_BLOCK",
        "A : FB2;",
        "A(X := 1);",
    ),
    "IMPLEMENTS": (
        "INTERFACE I1 END_INTERFACE FUNCTION_BLOCK FB1 IMPLEMENTS I1 VAR K : INT; END_VAR K := 1;"
        " END_FUNCTION_BLOCK",
        "A : FB1;",
        "A();",
    ),
    "THIS or SUPER": (_F.format("VAR K : INT; END_VAR THIS^.K := 1;"), "A : FB1;", "A();"),
    "POINTER TO": ("", "P : POINTER TO INT; I : INT;", "P^ := 1;"),
    "REFERENCE TO": ("", "P : REFERENCE TO INT; I : INT;", "I := P;"),
    "ADR or REF": ("", "D : DWORD; I : INT;", "D := ADR(I);"),
    "a NAMESPACE": ("NAMESPACE N1 END_NAMESPACE", "I : INT;", "I := 1;"),
    "arguments of FB_init": (_F.format(_OWN.format("")), "A : FB1(X := 1);", "A();"),
    "a written output of a block": (_F.format(_OWN.format("")), "A : FB1;", "A(); A.Y := 1;"),
    "pins as VAR_IN_OUT": (
        _F.format("VAR_IN_OUT Z : INT; END_VAR VAR K : INT; END_VAR K := Z;"),
        "A : FB1; C : CTU;",
        "A(Z := C.CV);",
    ),
    "an implicit conversion": ("", "D : DINT; I : INT;", "D := I;"),
    "arithmetic of bit strings": ("", "W : WORD;", "W := W + WORD#1;"),
    "a bitwise operation of integers": ("", "I : INT;", "I := I AND 3;"),
    "a number times a duration": ("", "T1 : TIME;", "T1 := 2 * T1;"),
    "a type of the third edition": ("", "L : LTIME;", "L := LTIME#1us;"),
    "a standard block of the third edition": ("", "X : LTON;", "X(IN := TRUE);"),
    "a standard function beyond the second edition": ("", "R : REAL; I : INT;", "I := TO_INT(R);"),
    "a standard function of dates or BCD": (
        "",
        "Day : DATE; Clock : TOD; Stamp : DT;",
        "Stamp := CONCAT_DATE_TOD(Day, Clock);",
    ),
    "another name of a pin": ("", "N : SR;", "N(SET1 := TRUE);"),
}


def iec2c_takes(
    before: str, variables: str, body: str, folder: Path, end: str = "END_PROGRAM"
) -> bool:
    """Return whether matiec's iec2c translates this program without an error."""
    matiec = find_matiec()
    assert matiec is not None
    file = folder / "program.st"
    file.write_text(
        f"{before}\nPROGRAM P1\nVAR {variables} END_VAR\n{body}\n{end}\n"
        "CONFIGURATION C1\nVAR_GLOBAL G1 : INT; END_VAR\nRESOURCE R1 ON PLC\n"
        "TASK T1(INTERVAL := T#10ms, PRIORITY := 0);\nPROGRAM Main WITH T1 : P1;\n"
        "END_RESOURCE\nEND_CONFIGURATION\n"
    )
    command = list(map(str, (matiec.iec2c, "-I", matiec.library, "-T", folder, file)))
    return subprocess.run(command, capture_output=True).returncode == 0
