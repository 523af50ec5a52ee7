"""Types of the third edition and implicit conversions: the formulas agree with the engine."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_tools.evidence.prove.agreement.bench import Subject
from rcx_tools.evidence.prove.agreement.comparing import agree


def _agrees(tmp_path: Path, variables: str, body: str, scans: int = 80) -> None:
    file = tmp_path / "tried.st"
    file.write_text(f"FUNCTION_BLOCK FB_TRIED\n{variables}\n{body}\nEND_FUNCTION_BLOCK\n")
    outcome = agree(Subject.of([file]), "FB_TRIED", scans)
    assert outcome.disagreement == ""
    assert outcome.scans > outcome.faults


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
    _agrees(tmp_path, variables, body)


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
    _agrees(tmp_path, variables, body, 120)


def test_texts_of_a_length_are_cut_as_on_the_engine(tmp_path: Path) -> None:
    variables = """
      VAR_INPUT A : STRING; N : INT; END_VAR
      VAR S5 : STRING[5]; S9 : STRING[9] := 'abcdefghi'; T : STRING; END_VAR
      VAR Q : BOOL; END_VAR
    """
    body = """
      S5 := A; S9 := S5; T := CONCAT(S5, S9); S5 := S9; Q := S5 = S9; T := CHAR#'c';
    """
    _agrees(tmp_path, variables, body)


@pytest.mark.parametrize("name", ["WSTRING", "WCHAR"])
def test_wide_characters_are_refused_by_name(tmp_path: Path, name: str) -> None:
    with pytest.raises(Exception, match=name):
        _agrees(tmp_path, f"VAR_INPUT A, B : {name}; END_VAR VAR Q : BOOL; END_VAR", "Q := A = B;")
