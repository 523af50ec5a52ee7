"""Coverage works for users' programs: methods, loops, skipped conditions, tool files, reports."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from rcx_harness.cell import Cell
from structured_text.coverage.formats import cobertura, tracefile
from structured_text.coverage.html import pages
from structured_text.coverage.measure import FileResult, judge, measure
from structured_text.coverage.output import write_report
from structured_text.coverage.parts import merge, part_of
from structured_text.coverage.report import conditions, gaps, missing, summary
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.engines.builtin.coverage import outcome
from structured_text.errors import InputError
from structured_text.language.load import load

#: The values of the variables in one scan.
Scan = dict[str, bool | int]
Run = Callable[..., FileResult]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Return a function that runs a program of these declarations and this body.

    `before` is the text above the program.
    """

    def run(body: str, declared: str, *scans: Scan, before: str = "") -> FileResult:
        text = f"{before}PROGRAM P\n  VAR\n{declared}  END_VAR\n{body}END_PROGRAM\n"
        (tmp_path / "P.st").write_text(text)
        collector = Collector()
        plc = BuiltinProgram.build(load([tmp_path / "P.st"]), collector)
        for number, values in enumerate(scans):
            for name, value in values.items():
                plc.write(f"Main.{name}", value)
            plc.scan(number * 10_000)
        (result,) = measure(merge([part_of(collector)]), tmp_path)
        return result

    return run


def _open(result: FileResult) -> list[str]:
    found = [*gaps([result]), *conditions(result)]
    return [f"{gap.line}: {gap.text}" for gap in sorted(found, key=lambda gap: gap.line)]


# --- conditions that are skipped ------------------------------------------------------------------

_POINTER = "    P : POINTER TO INT;\n    X : INT;\n    Take, Seen : BOOL;\n"
_GUARD = "  IF Take THEN\n    P := ADR(X);\n  END_IF;\n  Seen := P <> 0 AND_THEN P^ > 3;\n"


def test_a_pointer_after_and_then_is_used_only_if_it_is_not_0(run: Run) -> None:
    """A pointer after AND_THEN is used only if it is not 0.

    Each operand is a condition. The second is not evaluated if the first is FALSE.
    """
    result = run(_GUARD, _POINTER, {})
    (decision,) = [one for one in result.decisions if "AND_THEN" in one.text]
    assert decision.text == "P <> 0 AND_THEN P^ > 3"
    first, second = (one.judged for one in decision.conditions)
    assert (set(first.values), set(second.values)) == ({False}, set())
    assert _open(result)[-2:] == [
        "10: no MC/DC for P <> 0 in P <> 0 AND_THEN P^ > 3",
        "10: no MC/DC for P^ > 3 in P <> 0 AND_THEN P^ > 3",
    ]


def test_three_evaluations_give_mcdc_of_two_conditions(run: Run) -> None:
    """Three evaluations give MC/DC of two conditions: n conditions need n + 1 evaluations.

    They are: FALSE and skipped, TRUE and TRUE, TRUE and FALSE.

    Source: masking MC/DC of short-circuit forms (CAST-6, 10.3).
    """
    scans: list[Scan] = [{}, {"Take": True, "X": 4}, {"X": 3}]
    result = run(_GUARD, _POINTER, *scans)
    (decision,) = [one for one in result.decisions if "AND_THEN" in one.text]
    assert [one.judged.masking for one in decision.conditions] == [True, True]
    assert [one.judged.unique for one in decision.conditions] == [True, True]
    assert list(decision.vectors.values()).count(True) == 1


@pytest.mark.parametrize(
    ("code", "vectors", "deciding"),
    [
        # A OR_ELSE B: first A is TRUE and B is skipped, then both are FALSE. B is never TRUE.
        ([0, 1, "OR_ELSE"], [0b10_01, 0b00_00], "TF F"),
        # (A AND_THEN B) OR_ELSE C with A and C FALSE, and B skipped: A and C may have decided.
        ([0, 1, "AND_THEN", 2, "OR_ELSE"], [0b010_000], "F - F"),
        # The same decision with A and B TRUE: both have decided, and C is skipped.
        ([0, 1, "AND_THEN", 2, "OR_ELSE"], [0b100_011], "T T -"),
        # The same decision with A FALSE and C TRUE: only C has decided, whatever B is.
        ([0, 1, "AND_THEN", 2, "OR_ELSE"], [0b010_100], "- - T"),
        # A XOR B: each was TRUE and FALSE, but the outcome was TRUE both times, so no MC/DC.
        ([0, 1, "XOR"], [0b01, 0b10], "F F"),
    ],
)
def test_a_condition_has_decided_if_skipped_conditions_could_not_change_the_outcome(
    code: list[int | str], vectors: list[int], deciding: str
) -> None:
    """A condition has decided the outcome if no value of a skipped condition could change it.

    The results were calculated by hand. Bit k is condition k; the bits of skipped conditions are
    above.
    """
    size = sum(isinstance(one, int) for one in code)
    judged = judge(code, size, vectors)
    shown = ["".join("FT"[value] for value in sorted(one.deciding)[::-1]) for one in judged]
    assert " ".join(text or "-" for text in shown) == deciding


@pytest.mark.parametrize(
    ("code", "skipped", "expected"),
    [
        ([0, 1, "AND"], 0b10, False),
        ([0, 1, "OR"], 0b10, None),
        ([0, "NOT", 1, "OR"], 0b10, True),
        ([0, 1, "XOR"], 0b01, None),
        ([0, True, "OR_ELSE"], 0b01, True),
        ([0, "NOT", False, "AND_THEN"], 0b01, False),
    ],
)
def test_unknown_conditions_leave_some_outcomes_open(
    code: list[int | bool | str], skipped: int, expected: bool | None
) -> None:
    """If conditions are unknown, some outcomes stay open. All known conditions are FALSE."""
    assert outcome(code, 0, skipped) is expected


def test_coverage_does_not_stop_a_run(run: Run) -> None:
    """Coverage does not change whether a run stops.

    An index or a division after AND is evaluated in the same cases with and without coverage.
    """
    declared = "    A : ARRAY [1..3] OF INT;\n    i, n : INT;\n    Good : BOOL;\n"
    body = "  Good := i >= 1 AND A[i] = 0;\n  Good := n <> 0 AND 10 / n > 3;\n"
    result = run(body, declared, {"i": 0}, {"i": 2, "n": 2})
    assert [dict(one.vectors) for one in result.decisions] == [{0b11: True, 0b10_00: False}] * 2


def test_a_conversion_after_and_is_evaluated_and_a_root_is_not(run: Run) -> None:
    """After AND, a conversion is evaluated for coverage, but a root is not.

    A conversion of a whole number never ends a run, but the root of a negative number does.
    """
    declared = "    i : INT;\n    r : REAL;\n    Good : BOOL;\n"
    body = "  Good := i > 0 AND INT_TO_REAL(i) < 3.0;\n  Good := i > 0 AND SQRT(r) < 3.0;\n"
    result = run(body, declared, {"i": 0})
    assert [dict(one.vectors) for one in result.decisions] == [{0b10: False}, {0b10_00: False}]


def test_a_decision_evaluated_inside_itself_is_recorded_twice(run: Run) -> None:
    """If a decision is evaluated inside itself, both evaluations are recorded.

    A method in a condition runs the same decision for another instance.
    """
    before = (
        "FUNCTION_BLOCK F\n  VAR_INPUT Next : POINTER TO F; On : BOOL; END_VAR\n"
        "  METHOD All : BOOL\n"
        "    All := On AND_THEN (Next = 0 OR_ELSE Next^.All());\n"
        "  END_METHOD\nEND_FUNCTION_BLOCK\n"
    )
    declared = "    A, B : F;\n    Both : BOOL;\n"
    body = "  A.On := TRUE;\n  A.Next := ADR(B);\n  Both := A.All();\n"
    result = run(body, declared, {}, before=before)
    (decision,) = [one for one in result.decisions if "AND_THEN" in one.text]
    # Instance B: On is FALSE, so the other two conditions are skipped. Instance A: On is TRUE, Next
    # is not 0, and All of B returns FALSE.
    assert dict(decision.vectors) == {0b110_000: False, 0b000_001: False}


# --- statements and branches ----------------------------------------------------------------------


def test_a_for_may_have_no_round_unless_constants_give_it_one(run: Run) -> None:
    declared = "    i, n, Sum : INT;\n"
    body = (
        "  FOR i := 1 TO n DO\n    Sum := Sum + i;\n  END_FOR;\n"
        "  FOR i := 3 TO 1 BY -1 DO\n    Sum := Sum + i;\n  END_FOR;\n"
        "  FOR i := 3 TO 1 DO\n    Sum := 0;\n  END_FOR;\n"
    )
    result = run(body, declared, {})
    ways = [(item.line, item.text, item.hits) for item in result.branches]
    assert ways == [
        (5, "FOR with a round", 0),
        (5, "FOR without a round", 1),
        (8, "FOR with a round", 3),
        (11, "FOR with a round", 0),
        (11, "FOR without a round", 1),
    ]
    assert missing(result) == "6, 12"
    result = run(body, declared, {"n": 2}, {"n": 0})
    assert [item.hits for item in result.branches][:2] == [2, 1]


def test_a_round_that_goes_on_with_the_next_is_one(run: Run) -> None:
    body = "  FOR i := n TO 3 DO\n    IF i = 2 THEN\n      CONTINUE;\n    END_IF;\n  END_FOR;\n"
    result = run(body, "    i, n : INT;\n", {"n": 4}, {"n": 1})
    ways = [(item.text, item.hits) for item in result.branches if "FOR" in item.text]
    assert ways == [("FOR with a round", 3), ("FOR without a round", 1)]


def test_bodies_without_statements_are_branches(run: Run) -> None:
    declared = "    k, i : INT;\n"
    body = (
        "  CASE k OF\n    0: ;\n    1: k := 1;\n    2: ;\n  END_CASE;\n"
        "  IF k = 0 THEN ;\n  ELSIF k = 1 THEN ;\n  ELSE ;\n  END_IF;\n"
        "  WHILE i > k DO ; EXIT; END_WHILE;\n  FOR i := 1 TO 2 DO ; END_FOR;\n"
    )
    result = run(body, declared, {"k": 2}, {"k": 2}, {"k": 1})
    assert [(item.text, item.hits) for item in result.branches] == [
        ("CASE 0", 0),
        ("CASE 1", 1),
        ("CASE 2", 2),
        ("no label of the CASE fits", 0),
        ("IF k = 0", 0),
        ("ELSIF k = 1", 1),
        ("no condition of the IF was TRUE (no ELSE)", 2),
        ("WHILE with a round", 2),
        ("WHILE without a round", 1),
        ("FOR with a round", 6),
    ]


def test_a_case_of_an_enumeration_with_values_knows_its_members(run: Run) -> None:
    before = "TYPE E : (SLOW := 10, FAST := 20); END_TYPE\n"
    body = "  CASE Mode OF\n    SLOW: k := 1;\n    FAST: k := 2;\n  END_CASE;\n"
    result = run(body, "    Mode : E := SLOW;\n    k : INT;\n", {}, before=before)
    assert [item.text for item in result.branches] == ["CASE SLOW", "CASE FAST"]
    body = "  CASE n OF\n    -2000000000..2000000000: k := 1;\n  END_CASE;\n"
    result = run(body, "    n : DINT;\n    k : INT;\n", {})
    assert result.branches[0].text == "CASE -2000000000..2000000000"


def test_a_latch_is_one_statement_with_two_branches(run: Run) -> None:
    result = run("  Lit S= On;\n", "    Lit, On : BOOL;\n", {})
    assert [(item.line, item.hits) for item in result.statements] == [(5, 1)]
    assert [item.hits for item in result.branches] == [0, 1]
    assert missing(result) == "branches 5"


_METHODS = """\
FUNCTION F_Half : INT
  VAR_INPUT Value : INT; END_VAR
  IF Value < 0 THEN F_Half := 0; RETURN; END_IF;
  F_Half := Value / 2;
END_FUNCTION
FUNCTION_BLOCK FB_Axis
  VAR Place : INT; END_VAR
  METHOD MoveTo : BOOL
    VAR_INPUT Target : INT; END_VAR
    IF Target > 9 THEN
      RETURN;
    END_IF;
    Place := F_Half(Target);
    MoveTo := TRUE;
  END_METHOD
  PROPERTY Position : INT
    GET
      Position := Place;
    END_GET
    SET
      Place := Position;
    END_SET
  END_PROPERTY
  Place := Place + 1;
END_FUNCTION_BLOCK
"""


def test_functions_methods_and_properties_count_with_their_lines(run: Run) -> None:
    """Functions, methods and properties count with their lines, here in one file.

    Parts that are not called are reported with their own lines.
    """
    body = "  Axis.MoveTo(Target := n);\n  n := Axis.Position;\n"
    result = run(body, "    Axis : FB_Axis;\n    n : INT;\n", {"n": 4}, before=_METHODS)
    assert sorted(result.pous) == [("FB_Axis", 6, 0), ("FB_Axis.MoveTo", 8, 1),
                                   ("FB_Axis.Position.Get", 17, 1), ("FB_Axis.Position.Set", 20, 0),
                                   ("F_Half", 1, 1), ("P", 26, 1)]  # fmt: skip
    # A line with an IF and its statements counts as executed if all of them were executed.
    assert missing(result) == "3, 11, 21, 24"
    assert sorted(gap.line for gap in gaps([result])) == [3, 10, 21, 24]


def test_lines_of_different_parts_are_no_range(run: Run) -> None:
    result = run("  k := 1;\n", "    Axis : FB_Axis;\n    k : INT;\n", {}, before=_METHODS)
    assert missing(result) == "3-4, 10-14, 18, 21, 24; branches 3, 12"


def test_a_reason_may_be_a_line_comment(run: Run) -> None:
    body = "  IF k > 0 THEN // unreachable: never counted\n    k := 0;\n  END_IF;\n"
    result = run(body, "    k : INT;\n", {})
    assert [gap.reason for gap in gaps([result], justified=True)] == ["never counted"]
    assert gaps([result]) == []


# --- files of tools -------------------------------------------------------------------------------

_TCPOU = """\
<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="MAIN" Id="{1}" SpecialFunc="None">
    <Declaration><![CDATA[PROGRAM MAIN
VAR
  k : INT;
  InputArea, OutputArea : ARRAY [0..47] OF BYTE;
END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[k := k + 1;
IF k < 0 THEN
  k := 0;
END_IF
]]></ST>
    </Implementation>
  </POU>
</TcPlcObject>
"""


def test_a_file_of_a_tool_shows_its_own_text_and_lines(tmp_path: Path) -> None:
    (tmp_path / "MAIN.TcPOU").write_text(_TCPOU)
    collector = Collector(library=False)
    with counting(collector), Cell.build(tmp_path / "MAIN.TcPOU") as cell:
        cell.scan(2)
    (result,) = measure(merge([part_of(collector)]), tmp_path)
    assert result.path == "MAIN.TcPOU"
    assert missing(result) == "13"
    assert result.source[11] == "k := k + 1;"
    assert result.source[4] == "PROGRAM MAIN"
    page = pages([result], "cell")["MAIN.TcPOU.html"]
    assert '<tr id="L13" class="bad">' in page
    assert "TcPlcObject" not in page
    assert "DA:13,0" in tracefile([result]).splitlines()


def test_a_replaced_body_counts_in_its_own_file(tmp_path: Path) -> None:
    (tmp_path / "MAIN.TcPOU").write_text(_TCPOU)
    (tmp_path / "body.st").write_text("IF k = 0 THEN\n  k := 7;\nEND_IF\n")
    collector = Collector(library=False)
    replace = {"MAIN": tmp_path / "body.st"}
    with counting(collector), Cell.build(tmp_path / "MAIN.TcPOU", replace=replace) as cell:
        cell.scan(2)
    (result,) = measure(merge([part_of(collector)]), tmp_path)
    assert result.path == "body.st"
    assert result.source[1] == "IF k = 0 THEN"
    assert [(item.line, item.hits) for item in result.statements] == [(1, 2), (2, 1)]


# --- written reports ------------------------------------------------------------------------------

#: Maps the elements of coverage-04.dtd to their children in order, and required attributes.
_RATES = {"line-rate", "branch-rate", "complexity"}
_DTD = {"coverage": (["sources", "packages"], {"lines-covered", "lines-valid", "branches-covered",
                                               "branches-valid"} | {"version", "timestamp",
                                                                    *_RATES}),
        "sources": (["source"], set()), "source": ([], set()), "packages": (["package"], set()),
        "package": (["classes"], {"name", *_RATES}), "classes": (["class"], set()),
        "class": (["methods", "lines"], {"name", "filename", *_RATES}), "methods": ([], set()),
        "lines": (["line"], set()), "line": ([], {"number", "hits"})}  # fmt: skip


@pytest.fixture
def result(run: Run) -> FileResult:
    """Return a result of 11 lines with statements, of which 7 are executed completely."""
    body = "  Axis.MoveTo(Target := n);\n  n := Axis.Position;\n"
    declared = "    Axis : FB_Axis;\n    n : INT;\n"
    return run(body, declared, {"n": 4}, before=_METHODS)


def test_cobertura_is_as_its_dtd_wants_it(result: FileResult, tmp_path: Path) -> None:
    text = cobertura([result], tmp_path).decode()
    assert '<!DOCTYPE coverage SYSTEM "http://cobertura.sourceforge.net/xml/coverage-04.dtd">' in (
        text
    )
    root = ET.fromstring(text)
    for node in root.iter():
        children, attributes = _DTD[node.tag]
        assert set(node.attrib) - {"branch", "condition-coverage"} == attributes
        assert [name for name in children if node.find(name) is not None] == list(
            dict.fromkeys(child.tag for child in node)
        )
    lines = {line.get("number"): line.attrib for line in root.iter("line")}
    assert [number for number, line in lines.items() if line["hits"] == "0"] == [
        *("3", "11", "21", "24")
    ]
    assert lines["10"] == {
        "number": "10",
        "hits": "1",
        "branch": "true",
        "condition-coverage": "50% (1/2)",
    }
    # 11 lines have statements: 3, 4, 10, 11, 13, 14, 18, 21, 24 and two of P. Lines 3, 11, 21 and
    # 24 are not executed. Each IF has two branches, of which one is executed.
    assert (root.get("lines-covered"), root.get("lines-valid")) == ("7", "11")
    assert (root.get("branches-covered"), root.get("branches-valid")) == ("2", "4")
    assert root.get("line-rate") == "0.6364"


def test_records_of_lcov_are_at_lines_with_statements(result: FileResult) -> None:
    """Records of lcov are only at lines with statements.

    Readers report a branch or function of a line without data as an error.
    """
    rows = [line.partition(":") for line in tracefile([result]).splitlines()]
    of: dict[str, set[str]] = {}
    for kind, _, rest in rows:
        of.setdefault(kind, set()).add(rest.partition(",")[0])
    assert of["DA"] == {"3", "4", "10", "11", "13", "14", "18", "21", "24", "31", "32"}
    assert of["BRDA"] == {"3", "10"}
    blocks = {tuple(rest.split(",")[:2]) for kind, _, rest in rows if kind == "BRDA"}
    assert len(blocks) == len({block for _, block in blocks}) == 2, (
        "a branch for each IF of the file"
    )
    assert of["FN"] == {"3", "10", "18", "21", "24", "31"}
    assert {"LF": {"11"}, "LH": {"7"}, "BRF": {"4"}, "BRH": {"2"}}.items() <= of.items()
    assert "MCDC" not in of, "other readers refuse the file"


def test_lcov_shows_the_conditions_of_a_line_as_one_group(run: Run) -> None:
    """Lcov shows all conditions of a line as one group.

    The first decision has two conditions, the second has one. lcov 2.2 shows f and t of each
    condition.
    """
    body = "  X := A AND B; X := NOT A;\n"
    result = run(body, "    A, B, X : BOOL;\n", {"A": True, "B": True}, {"B": False})
    lines = tracefile([result], mcdc=True).splitlines()
    assert [line for line in lines if line.startswith("MC")] == [
        "MCDC:5,3,f,0,0,A in A AND B",
        "MCDC:5,3,t,1,0,A in A AND B",
        "MCDC:5,3,f,1,1,B in A AND B",
        "MCDC:5,3,t,1,1,B in A AND B",
        "MCDC:5,3,f,0,2,A",
        "MCDC:5,3,t,1,2,A",
        "MCF:6",
        "MCH:4",
    ]


def test_the_table_shows_names_as_they_are(result: FileResult) -> None:
    other = FileResult("[b]old[/b]/P.st", {1: ""}, statements=result.statements[:1])
    assert "[b]old[/b]/P.st" in summary([result, other], 120)


def test_pages_need_nothing_but_themselves(result: FileResult) -> None:
    other = FileResult("a/P.st", {1: "k < 1 & <b>"}, statements=result.statements[:1])
    twin = FileResult("a-P.st", {1: ""}, statements=result.statements[:1])
    found = pages([result, other, twin], "<cell>")
    assert list(found) == ["index.html", "P.html", "a-P.html", "a-P-2.html"]
    for page in found.values():
        assert "http" not in page.replace("http-equiv", "")
        assert "src=" not in page
        assert 'name="viewport"' in page
    assert "k &lt; 1 &amp; &lt;b&gt;" in found["a-P.html"]
    assert "Coverage of &lt;cell&gt;" in found["index.html"]


def test_a_report_writes_over_its_own_files_only(result: FileResult, tmp_path: Path) -> None:
    folder = tmp_path / "report"
    write_report([result], folder, "cell", tmp_path)
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    write_report([result], folder, "cell", tmp_path)
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    (folder / "P.html").write_text("mine")
    with pytest.raises(InputError, match=r"P\.html: already exists and is not a coverage report"):
        write_report([result], folder, "cell", tmp_path)
    assert (folder / "P.html").read_text() == "mine"
