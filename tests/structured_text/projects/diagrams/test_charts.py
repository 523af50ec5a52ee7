"""Charts in text form behave as the standard says: evolution, action control, times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.projects.diagrams.sfc.text import with_charts

Run = Callable[..., list[list[int]]]

_VARIABLES = "VAR A, B, C : BOOL; V : BOOL; N, M : INT; END_VAR"


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Return a function that gives the values of variables behind each scan of 10 ms."""

    def values(
        chart: str, inputs: Sequence[str], shown: Sequence[str], *, final_scan: bool = True
    ) -> list[list[int]]:
        file = tmp_path / "chart.st"
        file.write_text(f"PROGRAM Main\n{_VARIABLES}\n{chart}\nEND_PROGRAM\n")
        program = BuiltinProgram.build(load([with_charts(file, final_scan=final_scan)]))
        found = []
        for scan, given in enumerate(inputs):
            for name in "ABC":
                program.write(f"Main.{name}", name in given)
            program.scan(scan * 10_000)
            found.append([int(program.read(f"Main.{name}")) for name in shown])
        return found

    return values


def _step(qualifier: str, body: str = "N := N + 1;", rest: str = "") -> str:
    """Return a chart with an action in the step S, which is active while A is TRUE."""
    return (
        f"INITIAL_STEP I: {rest} END_STEP STEP S: Work ({qualifier}); END_STEP "
        "TRANSITION FROM I TO S := A; END_TRANSITION "
        "TRANSITION FROM S TO I := NOT A; END_TRANSITION "
        f"ACTION Work: {body} END_ACTION"
    )


def test_a_transition_clears_the_steps_before_it_and_activates_those_behind_it(run: Run) -> None:
    """A step that becomes active in a scan is left in the next scan at the earliest.

    Source: IEC 61131-3, 2.6.5, rules of evolution.
    """
    chart = """
      INITIAL_STEP S1: N1 (N); END_STEP
      STEP S2: V (N); END_STEP
      STEP S3: A3 (N); END_STEP
      TRANSITION FROM S1 TO S2 := A; END_TRANSITION
      TRANSITION FROM S2 TO S3 := A; END_TRANSITION
      ACTION N1: N := 1; END_ACTION
      ACTION A3: N := 3; END_ACTION"""
    got = run(chart, ["", "A", "A", "A"], ["N", "V"], final_scan=False)
    assert got == [[1, 0], [1, 1], [3, 0], [3, 0]]


def test_simultaneous_sequences_begin_and_end_together(run: Run) -> None:
    """Source: IEC 61131-3, table 46, feature 3: divergence and convergence of sequences."""
    chart = """
      INITIAL_STEP S: END_STEP
      TRANSITION FROM S TO (L, R) := A; END_TRANSITION
      STEP L: V (N); END_STEP
      STEP R: END_STEP
      STEP R2: Right (N); END_STEP
      TRANSITION FROM R TO R2 := B; END_TRANSITION
      TRANSITION FROM (L, R2) TO S := C; END_TRANSITION
      ACTION Right: N := N + 1; END_ACTION"""
    got = run(chart, ["A", "C", "BC", "", "C"], ["V", "N"], final_scan=False)
    # C alone does not end the sequences: R2 is not active before the third scan.
    assert got == [[1, 0], [1, 0], [1, 1], [1, 2], [0, 2]]


def test_of_several_true_transitions_the_one_with_the_lowest_number_fires(run: Run) -> None:
    """Source: IEC 61131-3, table 46, feature 2b: a lower number has the higher priority."""
    chart = """
      INITIAL_STEP S: END_STEP
      STEP L: N1 (N); END_STEP
      STEP R: M1 (N); END_STEP
      TRANSITION (PRIORITY := 2) FROM S TO L := A; END_TRANSITION
      TRANSITION (PRIORITY := 1) FROM S TO R := A; END_TRANSITION
      ACTION N1: N := 1; END_ACTION
      ACTION M1: M := 1; END_ACTION"""
    assert run(chart, ["A"], ["N", "M"]) == [[0, 1]]


def test_without_priorities_only_the_first_true_transition_fires(run: Run) -> None:
    """Source: IEC 61131-3, table 46, feature 2a: from left to right."""
    chart = """
      INITIAL_STEP S: END_STEP
      STEP L: N1 (N); END_STEP
      STEP R: M1 (N); END_STEP
      TRANSITION FROM S TO L := A; END_TRANSITION
      TRANSITION FROM S TO R := A; END_TRANSITION
      ACTION N1: N := 1; END_ACTION
      ACTION M1: M := 1; END_ACTION"""
    assert run(chart, ["A"], ["N", "M"]) == [[1, 0]]


@pytest.mark.parametrize(
    ("qualifier", "rest", "counts"),
    [
        # The step S is active in scans 1 to 6, at 0 to 50 ms of its time.
        ("N", "", "0 1 2 3 4 5 6 6 6"),
        ("S", "", "0 1 2 3 4 5 6 7 8"),
        ("S", "Work (R);", "0 1 2 3 4 5 6 6 6"),
        ("P", "", "0 1 1 1 1 1 1 1 1"),
        ("P1", "", "0 1 1 1 1 1 1 1 1"),
        ("P0", "", "0 0 0 0 0 0 0 1 1"),
        ("L, T#20ms", "", "0 1 2 2 2 2 2 2 2"),
        ("D, T#20ms", "", "0 0 0 1 2 3 4 4 4"),
        ("SD, T#60ms", "", "0 0 0 0 0 0 0 1 2"),
        ("SD, T#20ms", "Work (R);", "0 0 0 1 2 3 4 4 4"),
        ("DS, T#40ms", "", "0 0 0 0 0 1 2 3 4"),
        ("DS, T#60ms", "", "0 0 0 0 0 0 0 0 0"),
        ("SL, T#60ms", "", "0 1 2 3 4 5 6 6 6"),
        ("SL, T#70ms", "", "0 1 2 3 4 5 6 7 7"),
    ],
)
def test_a_qualifier_decides_when_an_action_is_executed(
    run: Run, qualifier: str, rest: str, counts: str
) -> None:
    """Source: IEC 61131-3, table 45, and figure 15 b) without the final scan."""
    got = run(_step(qualifier, rest=rest), ["", *["A"] * 6, "", ""], ["N"], final_scan=False)
    assert [n for (n,) in got] == [int(n) for n in counts.split()]


@pytest.mark.parametrize(
    ("qualifier", "counts"),
    [("N", "0 1 2 3 3"), ("P", "0 1 2 2 2"), ("P1", "0 1 1 1 1"), ("P0", "0 0 0 1 1")],
)
def test_the_final_scan_executes_an_action_once_more(run: Run, qualifier: str, counts: str) -> None:
    """The step is active in the scans 1 and 2. P1 and P0 have no final scan.

    Source: IEC 61131-3, figure 15 a).
    """
    got = run(_step(qualifier), ["", "A", "A", "", ""], ["N"])
    assert [n for (n,) in got] == [int(n) for n in counts.split()]


def test_the_flag_q_is_false_in_the_final_scan(run: Run) -> None:
    """Source: IEC 61131-3, 2.6.4.5: Q tells that an action is executed for the final time."""
    body = "IF Work.Q THEN N := N + 1; ELSE M := M + 1; END_IF;"
    assert run(_step("N", body), ["A", "A", "", ""], ["N", "M"]) == [[1, 0], [2, 0], [2, 1], [2, 1]]


def test_a_boolean_variable_as_an_action_has_the_value_of_its_control(run: Run) -> None:
    """Source: IEC 61131-3, 2.6.4.5: Q of the action control is the value of the variable."""
    chart = _step("N").replace("Work (N)", "V (N)")
    assert run(chart, ["", "A", "A", ""], ["V"]) == [[0], [1], [1], [0]]


def test_the_time_of_a_step_begins_at_0_and_stays_when_the_step_is_left(run: Run) -> None:
    """Source: IEC 61131-3, table 40, features 3 and 4."""
    body = "IF S.T >= T#20ms THEN N := N + 1; END_IF;"
    chart = _step("N", body, "Idle (N);") + (
        " ACTION Idle: IF S.T = T#30ms AND NOT S.X THEN M := M + 1; END_IF; END_ACTION"
    )
    got = run(chart, ["A", "A", "A", "", "", "A"], ["N", "M"], final_scan=False)
    assert got == [[0, 0], [0, 0], [1, 0], [1, 1], [1, 2], [1, 2]]


def test_a_transition_back_to_its_step_starts_the_time_again(run: Run) -> None:
    """Source: IEC 61131-3, 2.6.2: the time is reset when the step is activated."""
    chart = (
        "INITIAL_STEP S: END_STEP STEP Other: V (N); END_STEP "
        "TRANSITION FROM S TO Other := S.T > T#20ms; END_TRANSITION "
        "TRANSITION Again FROM S TO S := S.T >= T#20ms; END_TRANSITION"
    )
    assert run(chart, [""] * 9, ["V"]) == [[0]] * 9


@pytest.mark.parametrize(
    ("chart", "message"),
    [
        ("INITIAL_STEP I END_STEP", "2:1: 'END_STEP' is not expected here; write :"),
        ("INITIAL_STEP I: X (Z); END_STEP", "2:4: Z is not a qualifier"),
        ("INITIAL_STEP I: X (L); END_STEP", "2:1: the qualifier L of X has no time; write X (L"),
        ("INITIAL_STEP I: END_STEP STEP i: END_STEP", "2: there are two steps with the name i"),
        ("INITIAL_STEP I: END_STEP INITIAL_STEP J: END_STEP", "exactly one initial step"),
        (
            "INITIAL_STEP I: END_STEP TRANSITION FROM I TO J := A; END_TRANSITION",
            "2: there is no step J; the steps are I",
        ),
        (
            "INITIAL_STEP I: END_STEP TRANSITION FROM I TO I : LD A END_TRANSITION",
            "is in Instruction List, which is not read",
        ),
        ("INITIAL_STEP I: END_STEP ACTION W: N := 1;", "ACTION of this line has no END_ACTION"),
        ("INITIAL_STEP I: END_STEP N := 1;", "'N' is not expected in a chart"),
        ("INITIAL_STEP I: END_STEP TRANSITION FROM I TO I END_TRANSITION", "write :="),
    ],
)
def test_a_chart_that_cannot_be_read_has_a_message_with_its_line(
    tmp_path: Path, chart: str, message: str
) -> None:
    """Source: docs/reference/language.md, Sequential Function Chart."""
    file = tmp_path / "chart.st"
    words = chart.split(" ", 2)
    text = f"{words[0]} {words[1]}\n{words[2]}" if "2:" in message else chart
    file.write_text(f"PROGRAM Main {text}\nEND_PROGRAM\n")
    with pytest.raises(InputError) as caught:
        with_charts(file)
    assert message in str(caught.value)


def test_names_of_the_user_stay_his(run: Run) -> None:
    """The translation chooses another name if the program has a variable with its name.

    Source: docs/reference/language.md, Sequential Function Chart.
    """
    from structured_text.errors import VARIABLES

    chart = _step("N", f"N := {VARIABLES}Step_S;")
    got = run(f"VAR {VARIABLES}Step_S : INT := 5; END_VAR\n{chart}", ["A"], ["N"])
    assert got == [[5]]
