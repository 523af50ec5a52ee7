"""matiec differs from the standard in known points. The built-in engine follows the standard.

The library and the probes avoid these points, because programs with them behave differently on the
two engines.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.load import build


def _values(tmp_path: Path, variables: str, body: str) -> dict[str, object]:
    source = tmp_path / "program.st"
    source.write_text(f"PROGRAM PROBE\n  VAR {variables} END_VAR\n  {body}\nEND_PROGRAM\n")
    program = build([source], "builtin").program
    program.scan(0)
    return {path.removeprefix("Main."): program.read(path) for path, _ in program.walk()}


def test_a_for_loop_from_0_to_0_runs_once(tmp_path: Path) -> None:
    """Matiec of 2024 or later skips the last iteration if start plus step is beyond the end."""
    seen = _values(
        tmp_path,
        "I : INT; Rounds : INT; Single : INT;",
        "FOR I := 0 TO 0 DO Rounds := Rounds + 1; END_FOR;\n"
        "FOR I := 5 TO 6 BY 3 DO Single := Single + 1; END_FOR; I := 0;",
    )
    assert (seen["Rounds"], seen["Single"]) == (1, 1)


def test_sums_of_durations_that_give_whole_seconds_compare_correctly(tmp_path: Path) -> None:
    """In matiec, T#500ms + T#500ms has 0 s and 1000 ms, and compares as less than 1 s."""
    seen = _values(
        tmp_path,
        "Reached : BOOL; Same : BOOL; Below : BOOL;",
        "Reached := T#750ms + T#250ms >= T#1s;\n"
        "Same := T#750ms + T#250ms = T#1s;\n"
        "Below := T#750ms + T#250ms < T#1s;",
    )
    assert (seen["Reached"], seen["Same"], seen["Below"]) == (True, True, False)


@pytest.mark.parametrize("literal", ["T#1ms", "T#64ms", "T#1s300ms"])
def test_a_duration_is_what_its_literal_says(literal: str, tmp_path: Path) -> None:
    """In matiec, many durations are one nanosecond too short, so that sums and `=` are wrong."""
    doubled = {"T#1ms": "T#2ms", "T#64ms": "T#128ms", "T#1s300ms": "T#2600ms"}[literal]
    seen = _values(tmp_path, "Same : BOOL;", f"Same := {literal} + {literal} = {doubled};")
    assert seen["Same"] is True


def test_a_string_literal_may_hold_a_line_feed(tmp_path: Path) -> None:
    """Matiec copies the line feed into its C text, and C compilers refuse this text."""
    seen = _values(tmp_path, "Text : STRING := 'a$Lb';", "Text := CONCAT(Text, '$N');")
    assert seen["Text"] == "a\nb\n"
