"""Coverage of ST counts the executed statements, and lists those that were not executed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_tools.evidence.coverage.__main__ import figures, reasons, uncounted
from rcx_tools.evidence.coverage.run import Run
from structured_text.coverage.formats import tracefile
from structured_text.coverage.html import pages
from structured_text.coverage.measure import FileResult, judge, measure
from structured_text.coverage.parts import merge, part_of
from structured_text.coverage.report import gaps
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector
from structured_text.engines.builtin.coverage import Decision, Plan
from structured_text.language.load import load
from structured_text.language.printer import expression_text
from structured_text.projects.needed import needed

_SIZE = """\
TYPE RCX_SIZE : (SIZE_SMALL, SIZE_MIDDLE, SIZE_LARGE); END_TYPE
"""

_BLOCK = """\
FUNCTION_BLOCK FB_Probe
  VAR_INPUT
    Level : INT;
    Ready : BOOL;
    Size  : RCX_SIZE;
  END_VAR
  VAR_OUTPUT
    Shown : INT;
    Good  : BOOL;
  END_VAR
  VAR
    k     : INT;
  END_VAR
  Shown := 0;
  IF Level > 10 AND Ready THEN
    Shown := 1;
  ELSIF Level > 5 THEN
    Shown := 2;
  END_IF;
  CASE Size OF
    SIZE_SMALL: Shown := Shown + 10;
    SIZE_LARGE:
      Shown := Shown + 20;
  END_CASE;
  k := 1;
  WHILE k <= 3 DO
    k := k + 1;
  END_WHILE;
  WHILE k < Level DO
    k := k + 1;
  END_WHILE;
  Good := Ready OR Shown > 2;
END_FUNCTION_BLOCK
"""

_PROGRAM = """\
PROGRAM Bench
  VAR
    Level : INT;
    Ready : BOOL;
    Size  : RCX_SIZE;
    Probe : FB_Probe;
  END_VAR
  Probe(Level := Level, Ready := Ready, Size := Size);
END_PROGRAM
"""

Give = tuple[int, bool, str]
Measure = Callable[..., FileResult]

_EVERYTHING: list[Give] = [
    (20, True, "SIZE_SMALL"),
    (20, False, "SIZE_LARGE"),
    (6, True, "SIZE_MIDDLE"),
    (0, False, "SIZE_MIDDLE"),
]


@pytest.fixture
def measured(tmp_path: Path) -> Measure:
    """Return a function that runs a block once per scan with (Level, Ready, Size)."""

    def run(scans: list[Give], block: str = _BLOCK, **options: object) -> FileResult:
        library = tmp_path / "lib"
        (library / "part").mkdir(parents=True, exist_ok=True)
        (library / "part/FB_Probe.st").write_text(block)
        (library / "part/RCX_SIZE.st").write_text(_SIZE)
        program = tmp_path / "Bench.st"
        program.write_text(_PROGRAM)
        collector = Collector(library)
        project = load([program, *library.rglob("*.st")])
        plc = BuiltinProgram.build(project, collector)
        for k, (level, ready, size) in enumerate(scans):
            for name, value in (("Level", level), ("Ready", ready), ("Size", size)):
                plc.write(f"Main.{name}", value)
            plc.scan(k * 10_000)
        merged = merge([part_of(collector)])
        (result,) = measure(merged, library, **options)  # type: ignore[arg-type]
        return result

    return run


def _open(result: FileResult) -> list[str]:
    return [f"{gap.line}: {gap.text}" for gap in gaps([result])]


def test_everything_executed_is_complete(measured: Measure) -> None:
    result = measured(_EVERYTHING)
    assert _open(result) == []
    assert result.statement_share.complete
    assert result.branch_share.complete
    assert result.pous == [("FB_Probe", 1, 4)]
    assert {item.line: item.hits for item in result.statements}[27] > 3, "rounds of a loop"


def test_a_branch_that_is_not_taken_is_named_with_its_line(measured: Measure) -> None:
    """A branch that is not taken is reported with its line.

    This includes a missing ELSE and a CASE without a match.
    """
    result = measured([(20, True, "SIZE_SMALL")])
    assert _open(result) == [
        "17: not taken: ELSIF Level > 5",
        "19: not taken: no condition of the IF was TRUE (no ELSE)",
        "23: not taken: CASE SIZE_LARGE",
        "24: not taken: no label of the CASE fits",
        "29: not taken: WHILE without a round",
    ]
    assert not result.statement_share.complete
    assert result.branch_share.covered == 4


def test_a_loop_without_a_round_counts_unless_constants_exclude_it(measured: Measure) -> None:
    result = measured([(20, True, "SIZE_SMALL")])
    loops = [(item.line, item.text) for item in result.branches if "WHILE" in item.text]
    assert loops == [
        (26, "WHILE with a round"),
        (29, "WHILE with a round"),
        (29, "WHILE without a round"),
    ]


@pytest.mark.parametrize(
    "loop",
    [
        "FOR k := 1 TO 3 DO\n{body}  END_FOR;\n",
        "k := 1;\n  REPEAT\n{body}    k := k + 1;\n  UNTIL k > 3 END_REPEAT;\n",
        "k := 1;\n  WHILE k <= 3 DO\n{body}    k := k + 1;\n  END_WHILE;\n",
    ],
    ids=["FOR", "REPEAT", "WHILE"],
)
def test_a_branch_not_taken_in_a_loop_is_found(measured: Measure, loop: str) -> None:
    """A branch that is never taken in a loop is reported.

    The loop counter is 1, 2 and 3, so the branch for 5 is not taken.
    """
    branch = "    IF k = {} THEN\n      Shown := 1;\n    END_IF;\n"
    body = loop.format(body=branch.format(2) + branch.format(5))
    start, end = _BLOCK.index("  k := 1;"), _BLOCK.index("  Good :=")
    block = f"{_BLOCK[:start]}  {body}{_BLOCK[end:]}"
    (dead,) = [k for k, line in enumerate(block.splitlines(), 1) if "IF k = 5" in line]
    assert _open(measured(_EVERYTHING, block)) == [f"{dead}: not taken: IF k = 5"]


def test_a_case_whose_labels_are_all_members_has_no_other_way(measured: Measure) -> None:
    block = _BLOCK.replace("    SIZE_LARGE:", "    SIZE_MIDDLE, SIZE_LARGE:")
    cases = [item.text for item in measured(_EVERYTHING, block).branches if "CASE" in item.text]
    assert cases == ["CASE SIZE_SMALL", "CASE SIZE_MIDDLE, SIZE_LARGE"]


def test_a_dead_line_in_a_block_is_found(measured: Measure) -> None:
    """A line in a block that no test can reach is reported.

    An earlier condition includes the condition of this line.
    """
    dead = "  ELSIF Level > 7 THEN\n    Shown := 3;\n  END_IF;\n  CASE"
    result = measured(_EVERYTHING, _BLOCK.replace("  END_IF;\n  CASE", dead))
    assert _open(result) == ["19: not taken: ELSIF Level > 7"]


def test_an_unreachable_line_is_justified_in_place(measured: Measure) -> None:
    dead = "  ELSIF Level > 7 THEN (* unreachable: above 5 *)\n    Shown := 3;\n  END_IF;\n  CASE"
    result = measured(_EVERYTHING, _BLOCK.replace("  END_IF;\n  CASE", dead))
    assert _open(result) == []
    assert [gap.reason for gap in gaps([result], justified=True)] == ["above 5"]
    assert result.branch_share.complete
    assert result.branch_share.justified == 1


def test_a_reason_may_stand_in_the_line_before(measured: Measure) -> None:
    block = _BLOCK.replace("  ELSIF Level", "  (* unreachable:\n     never low *)\n  ELSIF Level")
    result = measured([(20, True, "SIZE_SMALL"), (0, False, "SIZE_LARGE")], block)
    assert [gap.reason for gap in gaps([result], justified=True)] == ["never low"]


def test_a_reason_at_a_line_that_is_reached_is_an_error(measured: Measure) -> None:
    block = _BLOCK.replace("Shown := 2;", "Shown := 2; (* unreachable: nobody comes here *)")
    assert _open(measured(_EVERYTHING, block)) == ["18: marked as unreachable, but it was executed"]


def test_counts_of_another_version_do_not_count(measured: Measure, tmp_path: Path) -> None:
    measured(_EVERYTHING)
    library = tmp_path / "lib"
    collector = Collector(library)
    plc = BuiltinProgram.build(load([tmp_path / "Bench.st", *library.rglob("*.st")]), collector)
    plc.scan(0)
    file = library / "part/FB_Probe.st"
    before = part_of(collector)
    file.write_text(file.read_text() + "\n")
    for parts in ([before, uncounted(library)], [part_of(collector), uncounted(library)]):
        (result,) = measure(merge(parts), library)
        assert result.statement_share.covered == 0
        assert _open(result) == ["1: changed while the tests ran, or since: run again"]
    (result,) = measure(merge([part_of(collector)]), library)
    assert result.statement_share.covered == 0
    assert _open(result) == ["1: changed while the tests ran, or since: run again"]


def _decision(text: str, tmp_path: Path) -> Decision:
    """Return the decision `Z := text` over the BOOL variables A to D."""
    file = tmp_path / "Logic.st"
    file.write_text(
        f"PROGRAM Logic\n  VAR\n    A, B, C, D, Z : BOOL;\n  END_VAR\n  Z := {text};\nEND_PROGRAM\n"
    )
    (decision,) = Plan.of(load([file]).pous["LOGIC"]).decisions
    assert expression_text(decision.root) == text
    return decision


@pytest.mark.parametrize(
    ("text", "vectors", "masking", "unique"),
    [
        pytest.param("A AND B", [0b11, 0b10, 0b01], "AB", "AB", id="and"),
        pytest.param("A AND B", [0b11, 0b00], "", "", id="both at once prove nothing"),
        pytest.param("A AND B", [0b11, 0b10], "A", "A", id="one half of an and"),
        pytest.param("A OR B", [0b00, 0b10, 0b01], "AB", "AB", id="or"),
        pytest.param("A OR B", [0b00, 0b11], "", "", id="or, both at once"),
        pytest.param("A XOR B", [0b00, 0b01, 0b10], "AB", "AB", id="xor"),
        pytest.param("NOT A AND B", [0b10, 0b11, 0b00], "AB", "AB", id="not"),
        pytest.param("A AND B OR C AND D", [0b0011, 0b0010, 0b0001, 0b1110, 0b1001, 0b0110], "ABCD",
                     "ABD", id="masking takes two evaluations that differ in masked conditions"),
        pytest.param("A AND B OR C", [0b011, 0b111], "", "", id="C is masked"),
    ],
)  # fmt: skip
def test_mcdc_requires_that_each_condition_decides_both_outcomes(
    text: str, vectors: list[int], masking: str, unique: str, tmp_path: Path
) -> None:
    """Source: the definitions of masking and unique-cause MC/DC (CAST-6)."""
    decision = _decision(text, tmp_path)
    rows = judge(decision.code, len(decision.conditions), vectors)
    judged = dict(zip("ABCD", rows, strict=False))
    assert "".join(name for name, one in judged.items() if one.masking) == masking
    assert "".join(name for name, one in judged.items() if one.unique) == unique


def test_a_decision_has_its_outcome_for_each_vector(tmp_path: Path) -> None:
    """Each combination of conditions gives the outcome that was calculated by hand.

    A is bit 0.
    """
    decision = _decision("A XOR B AND NOT C", tmp_path)
    assert [decision.outcome(vector) for vector in range(8)] == [
        *(False, True, True, False),
        *(False, True, False, True),
    ]


def test_all_operands_are_evaluated_without_short_circuit(measured: Measure) -> None:
    """All operands are evaluated, because ST has no short-circuit evaluation.

    The second condition counts even after a FALSE.
    """
    result = measured([(0, True, "SIZE_SMALL")])
    (first,) = [one for one in result.decisions if one.line == 15]
    assert [one.text for one in first.conditions] == ["Level > 10", "Ready"]
    assert dict(first.vectors) == {0b10: False}


def test_conditions_are_demanded_of_some_folders_only(measured: Measure) -> None:
    scans = [*_EVERYTHING[:1], (20, True, "SIZE_LARGE"), *_EVERYTHING[2:]]
    assert _open(measured(scans)) == []
    assert _open(measured(scans, demanded=("part/",))) == [
        "15: no MC/DC for Ready in Level > 10 AND Ready",
        "32: no MC/DC for Shown > 2 in Ready OR Shown > 2",
    ]


def test_a_condition_without_mcdc_may_have_a_reason(measured: Measure) -> None:
    why = {
        ("FB_Probe", "Level > 10 AND Ready", "Ready"): "it always is",
        ("FB_Probe", "Ready OR Shown > 2", "Ready"): "but this one has it",
    }
    scans = [*_EVERYTHING[:1], (20, True, "SIZE_LARGE"), *_EVERYTHING[2:]]
    result = measured(scans, reasons=why, demanded=("part/",))
    assert [gap.reason for gap in gaps([result], justified=True)] == ["it always is"]
    assert _open(result) == [
        "32: there is a reason for missing MC/DC of Ready, but MC/DC is complete",
        "32: no MC/DC for Shown > 2 in Ready OR Shown > 2",
    ]


def test_counting_changes_nothing_of_what_the_blocks_do(repository: Path) -> None:
    program = repository / "tests/data/library/Bench.st"
    library = sorted((repository / "plc/lib").rglob("*.st"))
    project = load([program, *needed([program], library)])
    plain = BuiltinProgram.build(project)
    counting = BuiltinProgram.build(project, Collector(repository / "plc/lib"))
    for scan in range(300):
        for plc in (plain, counting):
            plc.write("Main.First.Execute", scan % 7 < 3)
            plc.write("Main.First.Code", 0x0501)
            plc.write_bytes("Main.InputArea", bytes([scan * k % 256 for k in range(48)]))
            plc.scan(scan * 10_000)
        assert counting.snapshot()[1:] == plain.snapshot()[1:]  # type: ignore[index]


def test_without_a_collector_nothing_counts(measured: Measure, tmp_path: Path) -> None:
    measured(_EVERYTHING)
    project = load([tmp_path / "Bench.st", *(tmp_path / "lib").rglob("*.st")])
    names = BuiltinProgram.build(project).module.names
    assert "n_FB_PROBE" not in names
    assert "n_FB_PROBE" in BuiltinProgram.build(project, Collector()).module.names
    elsewhere = BuiltinProgram.build(project, Collector(tmp_path / "other")).module.names
    assert "n_FB_PROBE" not in elsewhere


def test_the_reports_show_the_source_and_the_gaps(measured: Measure, tmp_path: Path) -> None:
    result = measured([(20, True, "SIZE_SMALL")])
    assert "part/FB_Probe.st:17: not taken: ELSIF Level > 5" in map(str, gaps([result]))
    found = pages([result], "lib")
    page = found["part-FB_Probe.html"]
    assert '<tr id="L18" class="bad">' in page
    assert "Level &gt; 10 AND Ready" in page
    assert 'href="part-FB_Probe.html#L17"' in found["index.html"]


def test_lcov_reads_the_tracefile(measured: Measure, tmp_path: Path) -> None:
    result = measured([(20, True, "SIZE_SMALL")])
    file = tmp_path / "coverage.lcov"
    file.write_text(tracefile([result], tmp_path / "lib"))
    text = file.read_text().splitlines()
    assert {"FN:14,FB_Probe", "DA:18,0", "DA:16,1", "LF:13", "LH:11", "BRF:9", "BRH:4",
            "FNDA:1,FB_Probe"} <= {*text}  # fmt: skip
    tool = shutil.which("lcov")
    if tool is None:
        pytest.skip("lcov not found: the summary by lcov itself is left out")
    shown = subprocess.run(
        [tool, "--summary", str(file), "--rc", "lcov_branch_coverage=1"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "84.6% (11 of 13 lines)" in shown.stdout
    assert "44.4% (4 of 9 branches)" in shown.stdout


def test_the_figures_are_met_only_without_gaps(measured: Measure) -> None:
    result = measured([(20, True, "SIZE_SMALL")])
    found = figures([result], Run(passed=3, failed=0, skipped=0, output=""))
    assert found["tests"] == 3
    assert found["gaps"] == 5
    assert found["all"]["branches"] == {"covered": 4, "total": 9, "justified": 0, "percent": 44.44}
    assert not Run(passed=0, failed=0, skipped=9, output="").clean
    assert not Run(passed=9, failed=1, skipped=0, output="").clean


def test_every_reason_names_a_condition_of_the_library(repository: Path, tmp_path: Path) -> None:
    """Every reason for missing MC/DC names a condition of the library that exists."""
    named = reasons(repository / "tests/tools/evidence/conditions.toml")
    program = tmp_path / "Bench.st"
    blocks = sorted({pou for pou, _, _ in named if pou.startswith("FB_")})
    declared = "".join(f"    B{k} : {name};\n" for k, name in enumerate(blocks))
    program.write_text(
        f"PROGRAM Bench\n  VAR\n    k : INT;\n{declared}  END_VAR\n  k := 0;\nEND_PROGRAM\n"
    )
    library = sorted((repository / "plc/lib").rglob("*.st"))
    known = {
        (pou.name, expression_text(decision.root), expression_text(condition))
        for pou in load([program, *needed([program], library)]).pous.values()
        for decision in Plan.of(pou).decisions
        for condition in decision.conditions
    }
    assert set(named) <= known
