"""Mutants are generated from a source, and are killed or survive."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from rcx_tools.evidence.mutants.library import sample
from rcx_tools.evidence.mutants.suite import in_suite, spread
from rcx_tools.evidence.mutants.workshop import Workshop
from structured_text.mutants.mutant import Mutant, Mutants
from structured_text.mutants.operators import OPERATORS
from structured_text.output.results import Results

_BLOCK = """(*
 * FB_Sample: a bit of everything.
 *
 * Tests: tests/area/test_sample.py
 *)
FUNCTION_BLOCK FB_Sample
  VAR_INPUT
    Execute : BOOL;
    Last    : INT := 15;
    Wait    : TIME := T#5s;
  END_VAR
  VAR_OUTPUT
    Done    : BOOL;
    Busy    : BOOL;
    ErrorID : WORD;
  END_VAR
  VAR
    Clock   : TON;
    Ticket  : UINT;
    Serving : UINT;
    Words   : RCX_SAMPLE_WORDS;
    State   : RCX_SAMPLE_STATE;
    k       : INT;
  END_VAR

  Clock(IN := Execute AND NOT Done, PT := Wait);
  Busy := Execute AND NOT Clock.Q;
  k := 1;
  WHILE k <= Last DO
    Words[k] := WORD#16#0000;
    k := k + 1;
  END_WHILE;
  IF Ticket <> Serving OR (Words[2] AND WORD#16#0030) = WORD#16#0010 THEN
    ErrorID := WORD#16#8010;
    Serving := Serving + UINT#1;
  ELSIF Busy THEN
    Done := FALSE;
  END_IF;
  CASE State OF
    SAMPLE_ONE: Words[1] := SHL(WORD#16#0001, 4);
    SAMPLE_TWO: Words[1] := FC_Sample(Low := Words[2], High := Words[3]);
  END_CASE;
END_FUNCTION_BLOCK
"""
_FUNCTION = """(*
 * FC_Sample: the larger part.
 *
 * Tests: tests/area/test_sample.py
 *)
FUNCTION FC_Sample : WORD
  VAR_INPUT
    Low  : WORD;
    High : WORD;
  END_VAR
  FC_Sample := Low;
  IF WORD_TO_INT(High) >= WORD_TO_INT(Low) THEN
    FC_Sample := High;
  END_IF;
END_FUNCTION
"""
_TYPES = {
    "RCX_SAMPLE_WORDS": "ARRAY [1..15] OF WORD",
    "RCX_SAMPLE_STATE": "(SAMPLE_ONE, SAMPLE_TWO, SAMPLE_THREE)",
}
_PROGRAM = """PROGRAM Sample
  VAR
    Low   : WORD := WORD#16#0002;
    High  : WORD := WORD#16#0002;
    Found : WORD;
    Block : FB_Sample;
  END_VAR
  Found := FC_Sample(Low := Low, High := High);
  Block(Execute := TRUE);
END_PROGRAM
"""
#: A test that detects most mutants of FC_Sample, but not the mutant for two equal words.
_TEST = """from pathlib import Path

from structured_text.engines import build

_ROOT = Path(__file__).resolve().parents[2]


def test_the_larger_part():
    files = [_ROOT / "tests/data/library/Sample.st", *sorted((_ROOT / "plc/lib").rglob("*.st"))]
    program = build(files, "builtin").program
    for low, high in ((1, 2), (2, 1)):
        program.write("Main.Low", low)
        program.write("Main.High", high)
        program.scan(0)
        assert program.read("Main.Found") == 2
"""


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """Return a repository with a library of two POUs, one test, and a program for it."""
    library = tmp_path / "plc" / "lib"
    files = {
        "plc/lib/area/FB_Sample.st": _BLOCK,
        "plc/lib/area/FC_Sample.st": _FUNCTION,
        "tests/area/test_sample.py": _TEST,
        "tests/data/library/Sample.st": _PROGRAM,
        "tests/support/nothing.py": "",
        "pyproject.toml": "[tool.pytest.ini_options]\n",
    }
    for name, spec in _TYPES.items():
        files[f"plc/lib/types/{name}.st"] = f"TYPE\n  {name} : {spec};\nEND_TYPE\n"
    for path, text in files.items():
        file = tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    assert library.is_dir()
    return tmp_path


def _mutants(house: Path, name: str) -> list[Mutant]:
    library = sorted((house / "plc" / "lib").rglob("*.st"))
    return list(Mutants(house, library).of(house / "plc" / "lib" / "area" / name))


def test_every_operator_makes_its_mistake_as_a_change_of_lines(house: Path) -> None:
    found = {(one.operator, one.before, one.after) for one in _mutants(house, "FB_Sample.st")}
    clock = "Clock(IN := Execute AND NOT Done, PT := Wait);"
    condition = "IF Ticket <> Serving OR (Words[2] AND WORD#16#0030) = WORD#16#0010 THEN"
    expected = {
        ("relational", "WHILE k <= Last DO", "WHILE k < Last DO"),
        ("wrap", condition, condition.replace("Ticket <>", "Ticket >")),
        ("boolean", clock, clock.replace("Execute AND NOT Done", "(Execute OR NOT Done)")),
        ("operand", clock, clock.replace("Execute AND NOT Done", "Execute")),
        ("operand", clock, clock.replace("Execute AND NOT Done", "NOT Done")),
        ("negation", clock, clock.replace("NOT Done", "Done")),
        ("negation", "ELSIF Busy THEN", "ELSIF NOT Busy THEN"),
        ("condition", "ELSIF Busy THEN", "ELSIF FALSE THEN"),
        ("arithmetic", "k := k + 1;", "k := k - 1;"),
        ("off-by-one", condition, condition.replace("Words[2]", "Words[3]")),
        ("off-by-one", "k := 1;", "k := 2;"),
        ("mask", condition, condition.replace("16#0030", "16#0060")),
        ("code", "Words[k] := WORD#16#0000;", "Words[k] := WORD#16#0001;"),
        ("error-id", "ErrorID := WORD#16#8010;", "ErrorID := WORD#16#8011;"),
        ("constant", "Done := FALSE;", "Done := TRUE;"),
        ("time-out", "Busy := Execute AND NOT Clock.Q;", "Busy := Execute AND NOT FALSE;"),
        ("dropped reset", "Done := FALSE;", "IF FALSE THEN Done := FALSE; END_IF;"),
        ("dropped assignment", "k := k + 1;", ""),
        ("dropped call", clock, ""),
        ("neighbour", "Done := FALSE;", "Busy := FALSE;"),
        ("swapped", "SAMPLE_ONE: Words[1] := SHL(WORD#16#0001, 4);", "SAMPLE_ONE: Words[1] := "
         "SHR(WORD#16#0001, 4);"),
        ("swapped", "SAMPLE_TWO: Words[1] := FC_Sample(Low := Words[2], High := Words[3]);",
         "SAMPLE_TWO: Words[1] := FC_Sample(Low := Words[3], High := Words[2]);"),
        ("cancel", "END_CASE;", "END_CASE;\nDone := Done AND Execute;"),
        ("default", "Last : INT := 15;", "Last : INT := 16;"),
        ("default", "Wait : TIME := T#5s;", "Wait : TIME := T#10s;"),
    }  # fmt: skip
    assert expected <= found
    assert {operator for operator, _, _ in found} == set(OPERATORS)


def test_a_mutant_exchanges_the_functions_of_the_low_and_the_high_word(house: Path) -> None:
    """A mutant calls the function for the high word in place of the low word, if both exist."""
    area = house / "plc" / "lib" / "area"
    functions = "".join(
        f"FUNCTION FC_My{half}Word : WORD\n  VAR_INPUT Value : DWORD; END_VAR\n"
        f"  FC_My{half}Word := WORD#16#0001;\nEND_FUNCTION\n"
        for half in ("Low", "High")
    )
    (area / "FC_Halves.st").write_text(
        f"{functions}FUNCTION FC_Both : WORD\n  VAR_INPUT Value : DWORD; END_VAR\n"
        "  FC_Both := FC_MyLowWord(Value := Value);\nEND_FUNCTION\n"
    )
    swapped = [one.after for one in _mutants(house, "FC_Halves.st") if one.operator == "swapped"]
    assert swapped == ["FC_Both := FC_MyHighWord(Value := Value);"]


def test_a_mutant_is_correct_and_differs_from_the_original_and_from_all_others(house: Path) -> None:
    library = sorted((house / "plc" / "lib").rglob("*.st"))
    mutants = Mutants(house, library)
    made = list(mutants.of(house / "plc" / "lib" / "area" / "FB_Sample.st"))
    assert len({one.text for one in made}) == len(made) > 60
    assert _BLOCK not in {one.text for one in made}
    assert mutants.counted.refused > 0  # for example, an index outside of the array
    assert not any("Words[0]" in one.text or "Words[16]" in one.text for one in made)


def test_a_change_that_compiles_to_the_same_is_no_mutant(house: Path) -> None:
    file = house / "plc" / "lib" / "area" / "FC_Sample.st"
    file.write_text(_FUNCTION.replace(":= Low;", ":= Low AND Low;"), encoding="utf-8")
    mutants = Mutants(house, sorted((house / "plc" / "lib").rglob("*.st")))
    operand = [one.after for one in mutants.of(file) if one.operator == "operand"]
    assert operand == ["FC_Sample := Low;"]  # whichever of the two is left out
    assert mutants.counted.equal > 0


def test_removing_an_assignment_without_effect_is_not_a_mutant(house: Path) -> None:
    """Removing an assignment without an effect is not a mutant.

    Variables of a function begin with their initial values in every call.

    Source: IEC 61131-3, 2.5.1: a function has no memory.
    """
    file = house / "plc" / "lib" / "area" / "FC_Sample.st"
    body = """  Kept := 0;
  FC_Sample := WORD#16#0000;
  IF High = Low THEN
    Fresh := 0;
    FC_Sample := Low;
  ELSIF High <> WORD#16#0007 THEN
    FC_Sample := WORD#16#0000;
    Given := 0;
  END_IF;
  Kept := Fresh + 1;
  WHILE Kept < Given DO
    Kept := 0;
    Given := 0;
  END_WHILE;
  FC_Sample := WORD#16#0000;
"""
    declared = "  VAR\n    Kept, Fresh : INT;\n    Given : INT := 3;\n  END_VAR\n"
    head, _, rest = _FUNCTION.partition("  FC_Sample := Low;")
    end = rest[rest.index("END_FUNCTION") :]
    file.write_text(head + declared + body + end, encoding="utf-8")
    library = sorted((house / "plc" / "lib").rglob("*.st"))
    found = [one for one in Mutants(house, library).of(file) if one.operator == "dropped reset"]
    lines = file.read_text(encoding="utf-8").splitlines()
    first = lines.index("  Kept := 0;") + 1
    every = [k for k, line in enumerate(body.splitlines()) if line.endswith((":= 0;", "0000;"))]
    assert every == [0, 1, 3, 6, 7, 11, 12, 14]
    assert [one.line - first for one in found] == [6, 7, 11, 12, 14]


def test_a_sample_has_each_operator_and_repeats_with_its_seed(house: Path) -> None:
    library = sorted((house / "plc" / "lib").rglob("*.st"))
    file = house / "plc" / "lib" / "area" / "FB_Sample.st"
    first, again, other = (sample(Mutants(house, library), file, 15, seed) for seed in (1, 1, 2))
    assert [one.identity for one in first] == [one.identity for one in again]
    assert {one.identity for one in first} != {one.identity for one in other}
    assert len({one.operator for one in first}) == len(first) == 15


@pytest.mark.parametrize("operator", ["relational", "default"])
def test_a_mutant_is_put_into_a_compiled_program(house: Path, operator: str) -> None:
    """A mutant is put into a compiled program.

    A change in a body is made in place. A change in a declaration needs a new program.
    """
    workshop = Workshop()
    paths = [house / "tests/data/library/Sample.st", *sorted((house / "plc/lib").rglob("*.st"))]
    project = workshop.load(paths)
    assert workshop.load(paths) is project
    name = "FC_Sample.st" if operator == "relational" else "FB_Sample.st"
    mutant = next(
        one
        for one in _mutants(house, name)
        if one.operator == operator and ("< WORD" in one.after or ":= 14" in one.after)
    )
    program = workshop.program(project)
    program.write("Main.High", 1)
    program.scan(0)
    assert program.read("Main.Found") == 2
    assert program.read("Main.Block.Last") == 15
    workshop.put_in(house / mutant.file, mutant.text, mutant.pou.upper(), mutant.body)
    changed = workshop.load(paths)
    assert (changed is project) == (operator == "relational")
    program = workshop.program(changed)
    program.write("Main.High", 1)
    program.scan(0)
    shown = (program.read("Main.Found"), program.read("Main.Block.Last"))
    assert shown == ((1, 15) if operator == "relational" else (2, 14))


def test_the_workshop_tells_which_pous_have_run(house: Path) -> None:
    workshop = Workshop()
    workshop.watch()
    paths = [house / "tests/data/library/Sample.st", *sorted((house / "plc/lib").rglob("*.st"))]
    program = workshop.program(workshop.load(paths))
    assert workshop.seen == set()
    program.scan(0)
    assert workshop.seen == {"FB_SAMPLE", "FC_SAMPLE"}
    workshop.watch()
    assert workshop.seen == set()
    program.scan(10_000)
    assert workshop.seen == {"FB_SAMPLE", "FC_SAMPLE"}


def _run(house: Path) -> tuple[int, str, dict[str, object]]:
    command = [sys.executable, "-m", "rcx_tools.evidence.mutants", "--root", str(house)]
    done = subprocess.run(
        [*command, "--jobs", "2"], capture_output=True, text=True, check=False, cwd=house
    )
    assert (house / "out/verification/mutants.json").is_file(), done.stdout + done.stderr
    report = json.loads((house / "out/verification/mutants.json").read_text("utf-8"))
    return done.returncode, done.stdout + done.stderr, report


@pytest.mark.exhaustive
def test_a_run_tells_killed_from_surviving_and_goes_on_where_it_ended(house: Path) -> None:
    (house / "plc/lib/area/FB_Sample.st").unlink()
    program = house / "tests/data/library/Sample.st"
    without = _PROGRAM.replace("    Block : FB_Sample;\n", "")
    program.write_text(without.replace("  Block(Execute := TRUE);\n", ""), encoding="utf-8")
    code, told, report = _run(house)
    figures = report["figures"]
    assert isinstance(figures, dict)
    survivors = {(row["before"], row["after"]) for row in figures["survivors"]}
    line = "IF WORD_TO_INT(High) >= WORD_TO_INT(Low) THEN"
    assert survivors == {(line, line.replace(">=", ">"))}, told
    assert figures["mutants"] == figures["killed"] + 1
    assert figures["mutants"] > 8
    assert (code, report["met"], report["command"]) == (1, False, "make mutants")
    assert "+ IF WORD_TO_INT(High) > WORD_TO_INT(Low) THEN" in told

    outcomes = house / "out/verification/mutants.jsonl"
    known = outcomes.read_text("utf-8").splitlines()
    outcomes.write_text("\n".join(known[:-3]) + '\n{"key": "cut o', encoding="utf-8")
    reason = "equivalent: both are the same where they are equal"
    table = house / "tests/tools/evidence/survivors.toml"
    table.parent.mkdir(parents=True)
    rows = (house / "out/verification/mutants-without-reason.toml").read_text("utf-8")
    row = f'block = "FC_Sample"\nline = "{line}"\nbecomes = "{line.replace(">=", ">")}"\n'
    assert rows == f'[[survivor]]\n{row}reason = ""\n'
    lost = rows.replace('becomes = "IF', 'becomes = "UNTIL').replace('""', '"of long ago"')
    table.write_text(rows.replace('""', f'"{reason}"') + lost, encoding="utf-8")
    _, told, report = _run(house)
    again = report["figures"]
    assert isinstance(again, dict)
    assert len(outcomes.read_text("utf-8").splitlines()) == len(known), told
    assert [row["reason"] for row in again["survivors"]] == [reason]
    gone = "FC_Sample: UNTIL WORD_TO_INT(High) > WORD_TO_INT(Low) THEN"
    assert again["rows_without_a_mutant"] == [gone]
    assert f"there is no such mutant now: {gone}" in " ".join(told.split())
    assert not (house / "out/verification/mutants-without-reason.toml").read_text("utf-8")
    assert again["killed"] == figures["killed"]


@pytest.mark.exhaustive
def test_tests_that_fail_at_first_judge_nothing(house: Path) -> None:
    test = house / "tests/area/test_sample.py"
    test.write_text(_TEST.replace("== 2", "== 3"), encoding="utf-8")
    code, told, report = _run(house)
    figures = report["figures"]
    assert isinstance(figures, dict)
    assert code == 1
    assert figures["killed"] == 0
    assert "fails with the original" in told


def test_the_suite_leaves_out_networks_and_most_of_the_long_fault_runs() -> None:
    faults = [f"tests/faults/test_edge_blocks.py::test_a[FB_X-{k}]" for k in range(9)]
    other = ["tests/area/test_a.py::test_b[3]", "tests/area/test_a.py::test_c[48-256-enip]"]
    assert in_suite([*faults, *other]) == [faults[0], faults[3], faults[6], other[0]]
    assert spread("abcdef", 9) == list("abcdef")


def test_a_line_that_was_cut_off_is_run_again(tmp_path: Path) -> None:
    file = tmp_path / "mutants.jsonl"
    Results(file).add({"key": "a", "killed": True})
    with file.open("a", encoding="utf-8") as stream:
        stream.write('{"key": "b", "kil')
    results = Results(file)
    assert results.get("a") == {"key": "a", "killed": True}
    assert results.get("b") is None
    assert Results(file, fresh=True).get("a") is None
