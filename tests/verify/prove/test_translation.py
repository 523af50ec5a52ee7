"""The solver terms of a program give the same results as the built-in engine, in every variable.

The expected values come from the engine, which is compared with matiec in
tests/structured_text/engines/agreement.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_tools.evidence.prove.agreement.bench import Subject
from rcx_tools.evidence.prove.agreement.comparing import agree
from structured_text.language.dialects import using

_NUMBERS = ["SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT"]
_BITS = ["BYTE", "WORD", "DWORD", "LWORD"]


def _block(variables: str, body: str, types: str = "") -> str:
    return f"{types}\nFUNCTION_BLOCK FB_TRIED\n{variables}\n{body}\nEND_FUNCTION_BLOCK\n"


def _agrees(tmp_path: Path, source: str, scans: int = 80) -> None:
    """Check that the block of the source agrees, and that not every scan ends in a fault."""
    file = tmp_path / "tried.st"
    file.write_text(source, encoding="utf-8")
    subject = Subject.of([file])
    outcome = agree(subject, "FB_TRIED", scans)
    assert outcome.disagreement == ""
    assert outcome.scans > outcome.faults


def _operations(kind: str) -> str:
    """Return every operation of an integer type."""
    lines = ["R[0] := A + B;", "R[1] := A - B;", "R[2] := A * B;", "R[3] := A MOD B;",
             "R[4] := MAX(A, B, C);", "R[5] := MIN(A, B, C);", "R[6] := LIMIT(A, B, C);",
             "R[7] := SEL(A > B, A, C);", "R[8] := ABS(A);", "R[9] := ADD(A, B, C);",
             "R[10] := MUL(A, B, C);", "R[11] := (A + B - C) * (A - 1);",
             "IF B <> 0 THEN R[12] := A / B; END_IF;",
             "IF B <> 0 AND A / 3 > 0 THEN R[13] := DIV(A, B); END_IF;",
             "IF A > B OR A = C THEN R[14] := SUB(A, C); ELSE R[14] := MOD(A, C); END_IF;",
             "R[15] := MOVE(A);", "Q[0] := A < B; Q[1] := A <= B; Q[2] := A = B; Q[3] := A <> B;",
             "Q[4] := GT(A, B, C); Q[5] := GE(A, B); Q[6] := NE(A, B); Q[7] := LT(A, B, C);",
    ]  # fmt: skip
    if kind in ("SINT", "INT", "DINT", "LINT"):
        lines.append("R[16] := -A;")
    return "\n".join(lines)


@pytest.mark.parametrize("kind", _NUMBERS)
def test_arithmetic_of_every_integer_type_wraps_as_on_the_engine(tmp_path: Path, kind: str) -> None:
    variables = (
        f"VAR_INPUT A, B, C : {kind}; END_VAR\n"
        f"VAR R : ARRAY [0..16] OF {kind}; Q : ARRAY [0..7] OF BOOL; END_VAR"
    )
    _agrees(tmp_path, _block(variables, _operations(kind)), 150)


@pytest.mark.parametrize("kind", _BITS)
def test_bit_strings_are_joined_and_shifted_as_on_the_engine(tmp_path: Path, kind: str) -> None:
    """Bit strings are joined and shifted as on the engine.

    A shift may exceed the width. A negative shift stops the engine and the terms.
    """
    variables = (
        f"VAR_INPUT A, B : {kind}; N : INT; END_VAR\nVAR R : ARRAY [0..12] OF {kind}; END_VAR"
    )
    body = """
      R[0] := A AND B; R[1] := A OR B; R[2] := A XOR B; R[3] := NOT A; R[4] := AND(A, B, R[0]);
      R[5] := ROL(A, N); R[6] := ROR(A, N); R[7] := ROL(A, 3); R[8] := ROR(A, 70);
      R[9] := SHL(A, 5); R[10] := SHR(A, 64);
      R[11] := SHL(A, N); R[12] := SHR(B, N);
    """
    _agrees(tmp_path, _block(variables, body), 150)


def test_booleans_are_joined_and_shifted_as_on_the_engine(tmp_path: Path) -> None:
    variables = "VAR_INPUT A, B, C : BOOL; N : INT; END_VAR\nVAR R : ARRAY [0..11] OF BOOL; END_VAR"
    body = """
      R[0] := A AND B OR C; R[1] := A XOR B; R[2] := NOT (A OR B); R[3] := XOR(A, B, C);
      R[4] := SHL(A, N); R[5] := SHR(A, N); R[6] := ROL(A, N); R[7] := ROR(A, N);
      R[8] := A = B; R[9] := A < B; R[10] := SEL(A, B, C); R[11] := MUX(0, A, B);
    """
    _agrees(tmp_path, _block(variables, body))


@pytest.mark.parametrize("kind", ["REAL", "LREAL"])
def test_real_arithmetic_is_rounded_as_on_the_engine(tmp_path: Path, kind: str) -> None:
    """REAL arithmetic is rounded as on the engine.

    A division by 0.0 and the root of a negative number stop the engine and the terms.
    """
    variables = (
        f"VAR_INPUT A, B, C : {kind}; END_VAR\n"
        f"VAR R : ARRAY [0..15] OF {kind}; Q : ARRAY [0..8] OF BOOL; END_VAR"
    )
    body = f"""
      R[0] := A + B; R[1] := A - B; R[2] := A * B; R[3] := -A; R[4] := ABS(A);
      R[5] := A * 2.0; R[6] := A / 2.0; R[7] := A * 0.1 + B; R[8] := MAX(A, B); R[9] := MIN(A, B);
      R[10] := LIMIT(A, B, C); R[11] := SEL(A > B, A, B); R[12] := ADD(A, B, C);
      R[13] := A + {kind}#0.1; R[14] := ABS(-A) * 2.0 - B;
      Q[0] := A < B; Q[1] := A <= B; Q[2] := A = B; Q[3] := A <> B; Q[4] := A > 0.1;
      Q[5] := A >= 16777217.0; Q[6] := A = 0.1; Q[7] := A * 2.0 > B; Q[8] := A < -0.1;
      IF B > 0.0 THEN R[15] := SQRT(B) / B; END_IF;
      IF C = 0.5 THEN R[15] := A / B; ELSIF C = 1.5 THEN R[15] := SQRT(A); END_IF;
    """
    _agrees(tmp_path, _block(variables, body), 200)


@pytest.mark.parametrize("kind", [*_NUMBERS, *_BITS])
def test_numbers_are_converted_as_on_the_engine(tmp_path: Path, kind: str) -> None:
    """Numbers are converted as on the engine.

    The result for a REAL out of range is undetermined, because such a conversion must not
    happen.
    """
    others = [one for one in ("SINT", "UINT", "DINT", "ULINT", "WORD", "LWORD") if one != kind]
    both_ways = " ".join(f"To_{name} : {name}; Of_{name} : {kind};" for name in others)
    variables = f"""
      VAR_INPUT A : {kind}; R : REAL; L : LREAL; F : BOOL; END_VAR
      VAR {both_ways} END_VAR
      VAR As_REAL : REAL; As_LREAL : LREAL; As_BOOL : BOOL; Near : {kind}; END_VAR
    """
    body = [
        f"To_{name} := {kind}_TO_{name}(A); Of_{name} := {name}_TO_{kind}(To_{name});"
        for name in others
    ]
    body += [
        f"As_REAL := {kind}_TO_REAL(A); As_LREAL := {kind}_TO_LREAL(A);",
        f"As_BOOL := {kind}_TO_BOOL(A);",
        f"Near := BOOL_TO_{kind}(F);",
        f"IF R >= 0.0 AND R < 127.0 THEN Near := REAL_TO_{kind}(R); END_IF;",
        f"IF L >= -3.0 AND L < 127.0 AND F THEN Near := LREAL_TO_{kind}(L); END_IF;",
    ]
    _agrees(tmp_path, _block(variables, "\n".join(body)), 120)


def test_durations_are_calculated_as_on_the_engine(tmp_path: Path) -> None:
    """Durations are calculated as on the engine: sums, products, quotients and conversions."""
    variables = """
      VAR_INPUT A, B : TIME; N : INT; U : UDINT; R : REAL; L : LREAL; END_VAR
      VAR T : ARRAY [0..12] OF TIME; I : INT; D : DINT; W : ULINT; F : REAL; G : LREAL; END_VAR
      VAR Q : ARRAY [0..3] OF BOOL; END_VAR
    """
    body = """
      T[0] := A + B; T[1] := A - B; T[2] := A * N; T[3] := T#0s - A; T[4] := MAX(A, B);
      T[5] := LIMIT(T#0s, A, T#10s); T[6] := INT_TO_TIME(N); T[7] := UDINT_TO_TIME(U);
      T[8] := DINT_TO_TIME(D);
      I := TIME_TO_INT(A); D := TIME_TO_DINT(B); W := TIME_TO_ULINT(A);
      IF N <> 0 THEN T[9] := A / N; END_IF;
      IF A < T#1h AND A > T#0s THEN F := TIME_TO_REAL(A); G := TIME_TO_LREAL(A); END_IF;
      IF R > -1000.0 AND R < 1000.0 AND A < T#1h AND A > T#-1h THEN
        T[10] := A * R; T[11] := REAL_TO_TIME(R);
        IF ABS(R) > 0.001 THEN T[12] := A / R; END_IF;
      END_IF;
      Q[0] := A < B; Q[1] := A = B; Q[2] := A >= T#100ms; Q[3] := TIME_TO_BOOL(A);
    """
    _agrees(tmp_path, _block(variables, body), 200)


@pytest.mark.exhaustive
def test_texts_are_cut_joined_and_compared_as_on_the_engine(tmp_path: Path) -> None:
    """Texts are cut, joined and compared as on the engine.

    Counts may exceed 16 bits. A negative count stops the engine and the terms.
    """
    variables = """
      VAR_INPUT A, B : STRING; N, P : INT; D : DINT; END_VAR
      VAR R : ARRAY [0..5] OF STRING; S : STRING; Q : ARRAY [0..5] OF BOOL; I : INT; END_VAR
    """
    body = """
      Q[0] := A = B; Q[1] := A <> B; Q[2] := A < B; Q[3] := A <= B; Q[4] := A > 'M'; Q[5] := A >= B;
      S := LEFT(A, 6);
      I := LEN(A) + FIND(A, 'a') + FIND(S, LEFT(B, 1));
      R[0] := RIGHT('known', 2); R[1] := CONCAT(S, '-', LEFT(B, 4)); R[2] := MID(A, 2, 3);
      IF N >= 0 AND P >= 1 THEN R[3] := MID(S, N, P); END_IF;
      IF D >= 0 THEN R[4] := LEFT(A, D); END_IF;
      IF P = 17 THEN R[5] := MID(S, 1, N); END_IF;
    """
    _agrees(tmp_path, _block(variables, body), 60)


def test_exit_and_return_leave_statements_as_on_the_engine(tmp_path: Path) -> None:
    """Statements are left by EXIT and RETURN as on the engine.

    They are in loops in branches, CASE has ranges, and steps of FOR are negative or not constant.
    """
    variables = """
      VAR_INPUT A, B, Pace : INT; Mode : USINT; END_VAR
      VAR i, k, Sum, Rounds, Last, First1, Last1 : INT; END_VAR
    """
    body = """
      Sum := 0; Rounds := 0; Last := 0;
      First1 := LIMIT(0, A, 2); Last1 := LIMIT(0, B, 2);
      FOR i := First1 TO Last1 DO
        Sum := Sum + i;
        IF Sum > 2 THEN EXIT; END_IF;
        Rounds := Rounds + 1;
      END_FOR;
      FOR i := 2 TO First1 BY -2 DO
        k := 0;
        WHILE k < i DO
          k := k + 1;
          IF k = B THEN EXIT; END_IF;
          IF k + i = Pace THEN RETURN; END_IF;
        END_WHILE;
        Sum := Sum + k;
      END_FOR;
      IF Pace = 1 OR Pace = -1 OR Pace = 2 THEN
        FOR k := 1 TO Last1 BY Pace DO
          IF k < -1 THEN EXIT; END_IF;
          Sum := Sum + 10;
        END_FOR;
      END_IF;
      k := 0;
      REPEAT
        k := k + 1;
        CASE Mode OF
          0: EXIT;
          1, 2: Sum := Sum + 1;
          3..9, 12: IF k > 1 THEN Last := 7; RETURN; END_IF;
          10..11, 13..20: Sum := -1;
        ELSE
          Last := k;
        END_CASE;
      UNTIL k >= First1 END_REPEAT;
      Last := Last + 1;
    """
    _agrees(tmp_path, _block(variables, body), 200)


def test_functions_return_as_on_the_engine(tmp_path: Path) -> None:
    """Functions return as on the engine: from a loop, without a result, with defaults, nested."""
    functions = """
FUNCTION FIRST_OF : INT
  VAR_INPUT Wanted : INT; Start : INT := 3; END_VAR
  VAR k : INT; END_VAR
  FOR k := Start TO 5 DO
    IF k + k > Wanted THEN FIRST_OF := k; RETURN; END_IF;
    IF k = 4 THEN EXIT; END_IF;
  END_FOR;
END_FUNCTION
FUNCTION PAIRED : INT
  VAR_INPUT One : INT; Other : INT; END_VAR
  PAIRED := FIRST_OF(Wanted := One) * 1000;
  PAIRED := PAIRED + FIRST_OF(Wanted := Other, Start := MAX(FIRST_OF(Wanted := One), 2));
END_FUNCTION
"""
    variables = "VAR_INPUT A, B : INT; END_VAR\nVAR R : INT; END_VAR"
    _agrees(tmp_path, _block(variables, "R := PAIRED(A, B);", functions))


_TYPES = """
TYPE
  COLOUR : (RED, GREEN, BLUE);
  PART : STRUCT Size : INT; Hue : COLOUR; Marks : ARRAY [1..3] OF BYTE; END_STRUCT;
  PARTS : ARRAY [-1..2] OF PART;
  GRID : ARRAY [0..2, 1..3] OF INT;
  LONG_BYTES : ARRAY [0..99] OF BYTE;
END_TYPE
FUNCTION_BLOCK COUNTER
  VAR_INPUT Plus : INT; END_VAR
  VAR_OUTPUT Total : INT; END_VAR
  VAR_IN_OUT Shared : INT; Whole : PART; END_VAR
  VAR_TEMP Twice : INT; END_VAR
  Twice := Twice + Plus * 2;
  Total := Total + Twice;
  Shared := Shared + Total;
  Whole.Size := Whole.Size + 1;
  IF Shared > 1000 THEN RETURN; END_IF;
  Whole.Hue := GREEN;
END_FUNCTION_BLOCK
FUNCTION_BLOCK RAISER
  VAR_IN_OUT One : BYTE; Place : INT; END_VAR
  One := One XOR BYTE#16#FF;
  Place := Place + 1;
END_FUNCTION_BLOCK
"""


def test_structures_arrays_and_blocks_are_addressed_as_on_the_engine(tmp_path: Path) -> None:
    """Structures, arrays and blocks are addressed as on the engine, with variable indices.

    This includes long arrays and the variable behind a VAR_IN_OUT. An index outside of the array
    stops the engine and the terms.
    """
    variables = """
      VAR_INPUT I, K : INT; W : LINT; Tint : COLOUR; END_VAR
      VAR
        P : PARTS; G : GRID; L, M : LONG_BYTES; C1, C2 : COUNTER; R : RAISER;
        N : ARRAY [0..4] OF INT; Total : INT; Byte1 : BYTE; Place : INT;
      END_VAR
      VAR_IN_OUT Outside : PARTS; END_VAR
    """
    body = """
      P[0].Size := P[1].Size + 1;
      IF I >= -1 AND I <= 2 THEN
        P[I].Size := K;
        P[I].Marks[2] := BYTE#16#12;
        P[0] := P[I];
        Outside[I].Hue := Tint;
        Outside[2] := P[I];
      END_IF;
      IF I >= 1 AND I <= 3 AND K >= 0 AND K <= 2 THEN
        G[K, I] := G[2 - K, 4 - I] + 1;
        C1(Plus := K, Shared := N[K], Whole := P[K - 1], Total => Total);
        C2(Plus := I, Shared := N[K + I - 1], Whole := Outside[1]);
      END_IF;
      IF K >= 0 AND K < 100 THEN
        Byte1 := L[K];
        L[K] := INT_TO_BYTE(I);
        Place := K;
        R(One := L[Place], Place := Place);
        M := L;
      END_IF;
      IF Tint = BLUE THEN
        CASE Tint OF RED: Total := 1; GREEN, BLUE: Total := 2; END_CASE;
        L[W] := L[W] OR BYTE#1;
        P[K] := P[1];
      END_IF;
    """
    _agrees(tmp_path, _block(variables, body, _TYPES), 200)


@pytest.mark.parametrize("suffix", ["", "_DINT", "_LINT", "_UDINT", "_ULINT"])
def test_counters_count_as_on_the_engine(tmp_path: Path, suffix: str) -> None:
    kind = suffix.strip("_") or "INT"
    variables = f"""
      VAR_INPUT Up, Down, Reset, Load : BOOL; Preset : {kind}; END_VAR
      VAR A : CTU{suffix}; B : CTD{suffix}; C : CTUD{suffix}; N : {kind}; END_VAR
    """
    body = """
      A(CU := Up, R := Reset, PV := Preset); B(CD := Down, LD := Load, PV := Preset);
      C(CU := Up, CD := Down, R := Reset, LD := Load, PV := Preset, CV => N);
    """
    _agrees(tmp_path, _block(variables, body), 150)


def test_timers_triggers_and_bistables_run_as_on_the_engine(tmp_path: Path) -> None:
    variables = """
      VAR_INPUT In1, In2 : BOOL; Preset : TIME; END_VAR
      VAR A : TON; B : TOF; C : TP; D : R_TRIG; E : F_TRIG; F : SR; G : RS; Q : BOOL; END_VAR
    """
    body = """
      A(IN := In1, PT := Preset); B(IN := In2, PT := Preset); C(IN := In1, PT := Preset, Q => Q);
      D(CLK := In1); E(CLK := In2); F(S1 := In1, R := In2);
      IF Q THEN G(S := In1, R1 := In2); A(IN := In2); END_IF;
    """
    _agrees(tmp_path, _block(variables, body), 300)


def test_operands_that_are_skipped_stop_nothing(tmp_path: Path) -> None:
    """Operands that are skipped cannot stop the engine or the terms.

    They are right sides of AND and OR, and an ELSIF after a taken branch.
    """
    variables = "VAR_INPUT A, B, I : INT; END_VAR\nVAR N : ARRAY [0..3] OF INT; Q : BOOL; END_VAR"
    body = """
      Q := B <> 0 AND A / B > 1;
      Q := B = 0 OR A / B > 1 OR Q;
      IF I < 0 OR I > 3 THEN Q := FALSE; ELSIF N[I] = A THEN Q := TRUE; END_IF;
      WHILE I >= 0 AND I <= 3 AND N[I] > 0 DO N[I] := 0; END_WHILE;
    """
    _agrees(tmp_path, _block(variables, body), 150)


def test_known_arguments_are_calculated_as_by_the_engine(tmp_path: Path) -> None:
    """If all arguments are known, a standard function without terms is calculated by the engine."""
    variables = "VAR S : ARRAY [0..8] OF STRING; R : REAL; L : LREAL; I : INT; END_VAR"
    body = """
      S[0] := RIGHT('robot', 2); S[1] := INSERT('robot', 'XY', 2); S[2] := DELETE('robot', 2, 3);
      S[3] := REPLACE('robot', 'Z', 2, 1); S[4] := INT_TO_STRING(-12); S[5] := REAL_TO_STRING(0.5);
      S[6] := TIME_TO_STRING(T#1s500ms); S[7] := BOOL_TO_STRING(TRUE);
      S[8] := WORD_TO_STRING(WORD#18);
      R := SIN(REAL#0.5); L := EXP(LREAL#1.0); I := STRING_TO_INT('16#1F');
    """
    _agrees(tmp_path, _block(variables, body), 10)


# --- types of the third edition and implicit conversions ---


def test_numbers_widen_as_on_the_engine(tmp_path: Path) -> None:
    variables = """
      VAR_INPUT I : INT; U : UINT; S : SINT; D : DINT; W : WORD; B : BYTE; R : REAL; END_VAR
      VAR X : ARRAY [0..5] OF DINT; N : ARRAY [0..5] OF INT; V : ARRAY [0..4] OF WORD; END_VAR
      VAR Q : ARRAY [0..4] OF BOOL; F : REAL; L : LREAL; Z : ARRAY [0..1] OF BYTE; END_VAR
    """
    body = """
      X[0] := I; X[1] := U; X[2] := I + U; X[3] := W; X[4] := MAX(I, U); X[5] := S - B;
      N[0] := W; N[1] := I + U; N[2] := I AND 16#FF; N[3] := SHL(I, 3); N[4] := SHR(S, 2);
      N[5] := NOT I;
      V[0] := I; V[1] := W + 1; V[2] := W - B; V[3] := W AND I; V[4] := U;
      Z[0] := B + 1; Z[1] := B * 2;
      Q[0] := I < U; Q[1] := W > I; Q[2] := S = B; Q[3] := B < 300; Q[4] := U > -1;
      F := I; L := D; L := R;
    """
    _agrees(tmp_path, _block(variables, body))


def test_long_durations_and_dates_are_reckoned_as_on_the_engine(tmp_path: Path) -> None:
    variables = """
      VAR_INPUT A, B : LTIME; T : TIME; N : INT; D : LDT; E : DT; DAY1 : DATE; C : TOD; END_VAR
      VAR L : ARRAY [0..6] OF LTIME; Q : BOOL; I : LINT; M : ARRAY [0..2] OF LDT; END_VAR
      VAR K : DT; P : TON_LTIME; S : SR; END_VAR
    """
    body = """
      L[0] := A + B; L[1] := A - T; L[2] := A * N; L[3] := T; L[4] := MAX(A, B); L[5] := D - E;
      IF N <> 0 THEN L[6] := A / N; END_IF;
      I := LTIME_TO_LINT(A); Q := A > T; M[0] := D + A; M[1] := E + A; M[2] := E;
      K := CONCAT_DATE_TOD(DAY1, C);
      P(IN := Q, PT := A); S(SET1 := P.Q, RESET := Q);
    """
    _agrees(tmp_path, _block(variables, body), 120)


def test_texts_of_a_length_are_cut_as_on_the_engine(tmp_path: Path) -> None:
    variables = """
      VAR_INPUT A : STRING; N : INT; END_VAR
      VAR S5 : STRING[5]; S9 : STRING[9] := 'abcdefghi'; T : STRING; END_VAR
      VAR Q : BOOL; END_VAR
    """
    body = """
      S5 := A; S9 := S5; T := CONCAT(S5, S9); S5 := S9; Q := S5 = S9; T := CHAR#'c';
    """
    _agrees(tmp_path, _block(variables, body))


@pytest.mark.parametrize("name", ["WSTRING", "WCHAR"])
def test_wide_characters_are_refused_by_name(tmp_path: Path, name: str) -> None:
    variables = f"VAR_INPUT A, B : {name}; END_VAR VAR Q : BOOL; END_VAR"
    with pytest.raises(Exception, match=name):
        _agrees(tmp_path, _block(variables, "Q := A = B;"))


def test_statements_of_single_tools(tmp_path: Path) -> None:
    """Constructs that only some tools have are translated.

    They are EN and ENO, RETURN(condition), and counting down without a sign.
    """
    variables = """VAR_INPUT A : INT; U : USINT; E : BOOL; END_VAR
    VAR_OUTPUT N, M, Größe : INT; Ok : BOOL; F : BIT; END_VAR VAR I, J : USINT; END_VAR"""
    body = """N := 10#0; M := 0; F := E;
    FOR I := 5 TO 1 BY -2 DO N := N * 10 + 1; END_FOR;
    FOR J := U AND 3 TO 0 BY -1 DO M := M + 1; END_FOR;
    Größe := 7; Größe := ADD(EN := A > 0, IN1 := A, IN2 := 2, ENO => Ok);
    RETURN(E); N := 0;"""
    _agrees(tmp_path, _block(variables, body))


@pytest.mark.parametrize("dialect", ["openplc", "codesys", "tia"])
def test_a_dialect_is_translated_as_on_the_engine(tmp_path: Path, dialect: str) -> None:
    """The rules of a dialect are translated as on the engine.

    They are TIME as a number, counters, both operands of AND, short integers, and REAL / 0.
    """
    variables = """
      VAR_INPUT A, B : INT; T : TIME; N : UINT; X, Y : REAL; P, Q, R, L : BOOL; W : BYTE; END_VAR
      VAR Up : CTU; Down : CTD; Both : CTUD; D : DINT; M : TIME; F, G : REAL; H : BOOL; END_VAR
    """
    body = """
      D := TIME_TO_DINT(T); M := UINT_TO_TIME(N); F := INT_TO_REAL(A);
      IF T < T#1h AND T > T#0s THEN G := TIME_TO_REAL(T); END_IF;
      Up(CU := P, R := R, PV := A); Down(CD := Q, LD := L, PV := B);
      Both(CU := P, CD := Q, R := R, LD := L, PV := A);
      H := (B <> 0) AND (A / B > 1);
      D := A * B; F := (A + B) / 2; H := A + B > 30000; D := -A; N := W + W;
      IF X > 1.0 THEN G := X / Y; END_IF;
    """
    with using(dialect):
        _agrees(tmp_path, _block(variables, body), 150)
