"""`rcx test` runs suites with the interface of TcUnit, in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from junit_files import junit_root
from rcx_harness.cell.sources import source_files
from rcx_harness.cli.app import main
from rcx_harness.testing.suites import FRAMEWORK
from structured_text.errors import InputError
from structured_text.testing.suites.results import Case, Results
from structured_text.testing.suites.run import run_suites

_SUITE = """FUNCTION_BLOCK FB_Sum
VAR_INPUT one, two : UINT; END_VAR
VAR_OUTPUT result : UINT; END_VAR
result := one + two;
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Sum_Test EXTENDS TcUnit.FB_TestSuite
VAR
  Cycles : INT;
  Timer : TON;
END_VAR

METHOD Adds
VAR Sum : FB_Sum; Expected : UINT := 5; END_VAR
TEST('Adds');
Sum(one := 2, two := 2);
AssertEquals(Expected := Expected, Actual := Sum.result, Message := 'wrong sum');
AssertEquals_UINT(4, Sum.result, 'right');
TEST_FINISHED();
END_METHOD

METHOD WaitsFor
TEST('Waits');
Timer(IN := TRUE, PT := T#95ms);
AssertTrue(Condition := FALSE, Message := 'in each cycle');
IF Timer.Q THEN
  TEST_FINISHED_NAMED('Waits');
END_IF
END_METHOD

METHOD Second
IF TEST_ORDERED('First of two') THEN
  Cycles := Cycles + 1;
  IF Cycles = 3 THEN TEST_FINISHED(); END_IF
END_IF
IF TEST_ORDERED('Second of two') THEN
  AssertEquals_INT(3, Cycles, 'the first has finished');
  AssertFalse(IS_TEST_FINISHED('Second of two'), 'not yet');
  TEST_FINISHED();
END_IF
END_METHOD

METHOD Off
TEST('DISABLED_Off');
AssertTrue(FALSE, 'never');
TEST_FINISHED();
END_METHOD

METHOD Twice
TEST('Adds');
AssertTrue(FALSE, 'the second test of a name does not count');
TEST_FINISHED();
END_METHOD

Adds();
WaitsFor();
Second();
Off();
Twice();
END_FUNCTION_BLOCK

PROGRAM Main
VAR Sums : FB_Sum_Test; END_VAR
TcUnit.RUN();
END_PROGRAM
"""


def _run(folder: Path, text: str, **options: object) -> Results:
    file = folder / "suite.st"
    file.write_text(text, encoding="utf-8")
    return run_suites(source_files(file), FRAMEWORK, **options)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Return the results of the test suite `_SUITE`."""
    return _run(tmp_path_factory.mktemp("suite"), _SUITE)


def _tests(results: Results) -> dict[str, Case]:
    return {test.name: test for _, test in results.tests()}


def _suite_of(*statements: str, before: str = "", run: str = "RUN") -> str:
    body = "\n".join(statements)
    return f"""FUNCTION_BLOCK FB_Some EXTENDS FB_TestSuite
{before}
{body}
END_FUNCTION_BLOCK
PROGRAM Main
VAR Some : FB_Some; END_VAR
{run}();
END_PROGRAM
"""


def test_a_failed_assert_has_file_line_expected_and_actual_value(results: Results) -> None:
    """Source: TcUnit, API, AssertEquals."""
    test = _tests(results)["Adds"]
    assert (Path(test.place.file).name, test.place.line) == ("suite.st", 15) if test.place else 0
    (failure,) = test.failures
    assert failure.place is not None
    assert (Path(failure.place.file).name, failure.place.line) == ("suite.st", 17)
    assert failure.message == "expected 5, actual 4: wrong sum"
    assert test.asserts == 2


def test_suites_are_named_by_the_path_of_their_instance(results: Results) -> None:
    """Source: TcUnit, user guide, results."""
    assert [suite.name for suite in results.suites] == ["Main.Sums"]


def test_a_test_over_many_cycles_takes_virtual_time(results: Results) -> None:
    """A test over many cycles uses virtual time: a timer of 95 ms has ended in the scan at 100 ms.

    Source: TcUnit, user guide; docs/how-to/unit-tests.md.
    """
    test = _tests(results)["Waits"]
    assert (test.began_us, test.ended_us) == (0, 100_000)
    assert (results.scans, results.duration_us) == (11, 100_000)


def test_the_same_failure_in_the_next_cycle_is_not_reported_again(results: Results) -> None:
    """Source: TcUnit-Verifier, FB_AssertEveryFailedTestTwice."""
    test = _tests(results)["Waits"]
    assert [failure.t_us for failure in test.failures] == [0]
    assert test.asserts == 11


def test_ordered_tests_run_one_after_the_other(results: Results) -> None:
    """Ordered tests run one after the other: the second begins in the cycle after the first ends.

    Source: TcUnit, FAQ 7.
    """
    tests = _tests(results)
    assert tests["First of two"].ended_us == 20_000
    assert tests["Second of two"].ended_us == 30_000
    assert tests["Second of two"].passed


def test_a_disabled_test_is_skipped_and_named_without_the_prefix(results: Results) -> None:
    """Source: TcUnit, FAQ 2."""
    test = _tests(results)["Off"]
    assert test.skipped
    assert not test.failures


def test_of_two_tests_with_one_name_the_first_is_used_with_a_note(results: Results) -> None:
    """Source: TcUnit-Verifier, FB_CreateFourTestsWithSameName."""
    (note,) = results.notes
    assert note == "Main.Sums: there are several tests Adds; only the first one counts"


#: Type, expected value, actual value, and the text of both values in the result.
_VALUES = {
    "BOOL": ("TRUE", "FALSE", "TRUE", "FALSE"),
    "BYTE": ("16#AB", "16#C", "0xAB", "0x0C"),
    "WORD": ("16#EF01", "1", "0xEF01", "0x0001"),
    "DWORD": ("16#12345678", "0", "0x12345678", "0x00000000"),
    "LWORD": ("16#0123456789ABCDEF", "1", "0x0123456789ABCDEF", "0x0000000000000001"),
    "SINT": ("-128", "127", "-128", "127"),
    "INT": ("-32000", "15423", "-32000", "15423"),
    "DINT": ("-55555", "70000", "-55555", "70000"),
    "LINT": ("-451416345", "589532453", "-451416345", "589532453"),
    "USINT": ("3", "7", "3", "7"),
    "UINT": ("64322", "32312", "64322", "32312"),
    "UDINT": ("34124214", "52343244", "34124214", "52343244"),
    "ULINT": ("10000", "53685437234", "10000", "53685437234"),
    "REAL": ("1234.5", "2.0", "1234.5", "2.0"),
    "LREAL": ("1234567.89", "1234567.76", "1234567.89", "1234567.76"),
    "STRING": ("'This'", "''", "This", ""),
    "WSTRING": ('"ab"', '"b"', "ab", "b"),
    "DATE": ("D#1996-05-06", "D#2019-01-20", "D#1996-05-06", "D#2019-01-20"),
    "DATE_AND_TIME": (
        *("DT#1996-05-06-15:36:30", "DT#1972-03-29-00:00:00"),
        *("DT#1996-05-06-15:36:30", "DT#1972-03-29-00:00:00"),
    ),
}


def test_each_type_has_its_assert_and_the_general_assert_selects_it(tmp_path: Path) -> None:
    """Source: TcUnit-Verifier, FB_PrimitiveTypes and FB_AnyPrimitiveTypes (texts)."""
    declared, called = [], []
    for kind, (expected, actual, _, _) in _VALUES.items():
        declared.append(f"e_{kind} : {kind} := {expected}; a_{kind} : {kind} := {actual};")
        delta = "0.0, " if "REAL" in kind else ""
        called.append(f"TEST('{kind}');")
        called.append(f"AssertEquals_{kind}(e_{kind}, a_{kind}, {delta}'m');")
        called.append(f"AssertEquals_{kind}(e_{kind}, e_{kind}, {delta}'m');")
        called.append(f"AssertEquals(e_{kind}, a_{kind}, 'm');")
        called.append(f"AssertEquals(a_{kind}, a_{kind}, 'm'); TEST_FINISHED();")
    before = "\n".join(["VAR", *declared, "END_VAR"])
    tests = _tests(_run(tmp_path, _suite_of(*called, before=before)))
    for kind, (_, _, expected, actual) in _VALUES.items():
        found = [(one.expected, one.actual) for one in tests[kind].failures]
        assert found == [(expected, actual)] * 2, kind


_OTHERS = """VAR
  State : (Idle, Busy) := Busy;
  i : INT := 3; u : UINT := 3; t : TIME := T#1s;
  r : REAL := 1.0; low : ARRAY[1..3] OF INT := [1, 2, 3]; high : ARRAY[5..7] OF INT := [1, 9, 3];
  two : ARRAY[0..1] OF INT;
  grid, other : ARRAY[0..1, 1..2] OF REAL; long : ARRAY[0..2, 1..2] OF REAL;
END_VAR
other[1, 2] := 0.5;"""


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("AssertEquals(i, u, 'm')", "expected (Type class = INT), actual (Type class = UINT): m"),
        ("AssertEquals(t, i, '')", "expected (Type class = TIME), actual (Type class = INT)"),
        ("AssertEquals(4, i, 'm')", "expected 4, actual 3: m"),
        ("AssertEquals(Idle, State, 'm')", "expected 0, actual 1: m"),
        ("AssertEquals(Actual := i, Expected := i + 1, Message := '')", "expected 4, actual 3"),
        ("AssertEquals_REAL(1.5, r, 0.4, 'm')", "expected 1.5, actual 1.0: m"),
        ("AssertEquals_REAL(1.5, r, 0.5, 'm')", ""),
        ("AssertTrue(i = 4, 'm')", "expected TRUE, actual FALSE: m"),
        ("AssertFalse(i = 3, 'm')", "expected FALSE, actual TRUE: m"),
        (
            "AssertArrayEquals_INT(low, high, 'm')",
            "expected ARRAY[2] = 2, actual ARRAY[6] = 9: m",
        ),
        ("AssertArrayEquals_INT(Expecteds := low, Actuals := low, Message := 'm')", ""),
        (
            "AssertArrayEquals_INT(low, two, 'm')",
            "expected SIZE = 3, actual SIZE = 2: m, size of arrays not matching.",
        ),
        (
            "AssertArray2dEquals_REAL(grid, other, 0.1, 'm')",
            "expected ARRAY[1,2] = 0.0, actual ARRAY[1,2] = 0.5: m",
        ),
        ("AssertArray2dEquals_REAL(grid, other, 0.5, 'm')", ""),
        (
            "AssertArray2dEquals_REAL(grid, long, 0.0, 'm')",
            "expected SIZE = [0..1,1..2] (2x2), actual SIZE = [0..2,1..2] (3x2): "
            "m, size of arrays not matching.",
        ),
    ],
)
@pytest.mark.exhaustive
def test_asserts_fail_with_both_values(tmp_path: Path, statement: str, expected: str) -> None:
    """Source: TcUnit, API; TcUnit-Verifier, FB_ArrayPrimitiveTypes (texts)."""
    text = _suite_of("TEST('x');", f"{statement};", "TEST_FINISHED();", before=_OTHERS)
    test = _tests(_run(tmp_path, text))["x"]
    assert [failure.message for failure in test.failures] == ([expected] if expected else [])
    assert test.asserts == 1


def test_asserts_with_arrays_and_with_values_of_other_types(tmp_path: Path) -> None:
    """Source: TcUnit, API; TcUnit-Verifier, FB_ArrayPrimitiveTypes (texts)."""
    body = (
        *("TEST('x');", "AssertEquals(i, u, 'm');", "AssertEquals(Idle, State, 'm');"),
        *("AssertArrayEquals_INT(low, high, 'm');", "AssertArrayEquals_INT(low, two, 'm');"),
        *("AssertArray2dEquals_REAL(grid, other, 0.1, 'm');", "TEST_FINISHED();"),
    )
    test = _tests(_run(tmp_path, _suite_of(*body, before=_OTHERS)))["x"]
    assert [failure.message for failure in test.failures] == [
        "expected (Type class = INT), actual (Type class = UINT): m",
        "expected 0, actual 1: m",
        "expected ARRAY[2] = 2, actual ARRAY[6] = 9: m",
        "expected SIZE = 3, actual SIZE = 2: m, size of arrays not matching.",
        "expected ARRAY[1,2] = 0.0, actual ARRAY[1,2] = 0.5: m",
    ]


_TWO_SUITES = """FUNCTION_BLOCK FB_Slow EXTENDS FB_TestSuite
VAR Count : INT; END_VAR
IF TEST('Slow') THEN
  Count := Count + 1;
  IF Count = 3 THEN TEST_FINISHED(); END_IF
END_IF
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Quick EXTENDS FB_TestSuite
TEST('Quick');
AssertTrue(FALSE, 'm');
TEST_FINISHED();
END_FUNCTION_BLOCK
PROGRAM Main
VAR Slow : FB_Slow; Quick : FB_Quick; END_VAR
RUN_IN_SEQUENCE();
END_PROGRAM
"""


def test_suites_are_computed_with_the_rules_of_the_projects_tool(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A suite is computed with the rules of the tool of the project.

    In TwinCAT, a number as a TIME is in milliseconds.

    The source of the suite uses the namespace of the library.

    Source: docs/reference/language.md, dialects.
    """
    file = tmp_path / "suite.st"
    compared = "AssertEquals_TIME(T#500ms, UDINT_TO_TIME(500), 'm');"
    text = _suite_of("TEST('A');", compared, "TEST_FINISHED();", run="TcUnit.RUN")
    file.write_text(text.replace("EXTENDS FB", "EXTENDS TcUnit.FB"))
    assert main(["test", str(file), "--dialect", "twincat"]) == 0
    capsys.readouterr()
    assert main(["test", str(file), "--dialect", "iec"]) == 1


def test_suites_in_sequence_begin_after_the_previous_suite_has_finished(tmp_path: Path) -> None:
    """Source: TcUnit, FAQ 7."""
    tests = _tests(_run(tmp_path, _TWO_SUITES))
    assert (tests["Slow"].began_us, tests["Slow"].ended_us) == (0, 20_000)
    assert tests["Quick"].began_us == 30_000


@pytest.mark.exhaustive
def test_of_several_programs_without_tasks_those_run_that_call_the_suites(tmp_path: Path) -> None:
    """Source: docs/how-to/unit-tests.md."""
    other = "PROGRAM Other\nVAR i : INT; END_VAR\n// RUN();\ni := 1 / i;\nEND_PROGRAM\n"
    results = _run(tmp_path, other + _suite_of("TEST('A');", "TEST_FINISHED();"))
    assert [suite.name for suite in results.suites] == ["Main.Some"]
    assert results.passed


@pytest.mark.parametrize("name", ["Quick", "main.quick", "Quick.Quick", "*.Qu*"])
def test_only_the_named_tests_run(tmp_path: Path, name: str) -> None:
    """Source: docs/how-to/unit-tests.md."""
    results = _run(tmp_path, _TWO_SUITES, only=[name])
    assert list(_tests(results)) == ["Quick"]
    assert results.scans == 2


def test_a_name_that_selects_no_test_is_refused(tmp_path: Path) -> None:
    """Source: docs/how-to/unit-tests.md."""
    with pytest.raises(InputError, match="--only Quik: no test or suite of this name has begun"):
        _run(tmp_path, _TWO_SUITES, only=["Quick", "Quik"])


def test_the_command_prints_failures_writes_junit_and_exits_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Source: docs/how-to/unit-tests.md."""
    monkeypatch.chdir(tmp_path)
    Path("suite.st").write_text(_TWO_SUITES)
    assert main(["test", "suite.st", "--junit", "found.xml", "--scan", "5ms"]) == 1
    out = capsys.readouterr().out
    assert out.splitlines() == [
        "FAILED Main.Quick.Quick",
        "  suite.st:10: expected TRUE, actual FALSE: m",
        "2 suites, 2 tests: 1 passed, 1 failed, 0 skipped; 4 scans in 15 ms of virtual time",
        "written: found.xml",
    ]
    root = junit_root(Path("found.xml"))
    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("2", "1", "0")
    case = root.findall(".//testcase")[1]
    assert (case.get("classname"), case.get("name")) == ("Main.Quick", "Quick")
    assert (case.get("file"), case.get("line")) == ("suite.st", "9")
    failure = case.find("failure")
    assert failure is not None
    assert failure.get("message") == "expected TRUE, actual FALSE: m"
    assert failure.text == "suite.st:10: expected TRUE, actual FALSE: m"
    assert main(["test", "suite.st", "--only", "Slow"]) == 0


def test_a_suite_that_never_finishes_is_given_up_with_a_message(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/how-to/unit-tests.md."""
    file = tmp_path / "suite.st"
    file.write_text(_suite_of("TEST('For ever');"))
    assert main(["test", str(file), "--for", "1s", "--junit", str(tmp_path / "j.xml")]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "UNFINISHED Main.Some.For ever"
    assert lines[1].endswith("suite.st:3: has begun here and not finished")
    assert lines[2] == "given up after 100 scans (1000 ms of virtual time); --for gives more"
    case = junit_root(tmp_path / "j.xml").find(".//testcase/error")
    assert case is not None
    assert "given up after 100 scans" in str(case.get("message"))


_ERRORS = """FUNCTION_BLOCK FB_Methods EXTENDS FB_TestSuite
VAR Zero, Index, Cycles, Ordered : INT; Items : ARRAY[1..3] OF INT; END_VAR
METHOD Divides
TEST('Divides');
Index := 1 / Zero;
TEST_FINISHED();
END_METHOD
METHOD Leaves
TEST('Leaves');
Helper(4);
AssertTrue(FALSE, 'not reached');
TEST_FINISHED();
END_METHOD
METHOD Helper
VAR_INPUT Place : INT; END_VAR
Items[Place] := 1;
END_METHOD
METHOD Prepares
Index := 1 / Zero;
TEST('Prepares');
END_METHOD
METHOD Off
TEST('DISABLED_Off');
Index := 1 / Zero;
END_METHOD
METHOD Second
IF TEST_ORDERED('First of two') THEN Index := 1 / Zero; END_IF
END_METHOD
METHOD Third
IF TEST_ORDERED('Second of two') THEN TEST_FINISHED(); END_IF
END_METHOD
METHOD Lasts
TEST('Lasts');
Cycles := Cycles + 1;
IF Cycles = 4 THEN TEST_FINISHED(); END_IF
END_METHOD
Divides(); AssertTrue(FALSE, 'of the test that has ended');
Leaves(); Prepares(); Off(); Second(); Third(); Lasts();
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Inline EXTENDS FB_TestSuite
VAR Zero, Index : INT; END_VAR
TEST('Waits');
TEST('Divides');
Index := 1 / Zero;
TEST_FINISHED();
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Good EXTENDS FB_TestSuite
TEST('Good');
TEST_FINISHED();
END_FUNCTION_BLOCK
PROGRAM Main
VAR Inlined : FB_Inline; Methods : FB_Methods; Good : FB_Good; END_VAR
RUN();
END_PROGRAM
"""


def test_an_error_at_run_time_ends_its_test_and_no_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run-time error in a method ends only the test of this method; elsewhere it ends the suite.

    Source: docs/how-to/unit-tests.md.
    """
    monkeypatch.chdir(tmp_path)
    Path("suite.st").write_text(_ERRORS)
    assert main(["test", "suite.st", "--junit", "j.xml"]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "FAILED Main.Inlined.Waits",
        "  suite.st:42: has not finished, because an error has ended the suite: division by zero",
        "FAILED Main.Inlined.Divides",
        "  suite.st:44: division by zero",
        "FAILED Main.Methods.Divides",
        "  suite.st:5: division by zero",
        "FAILED Main.Methods.Leaves",
        "  suite.st:16: index 4 is outside 1..3",
        "FAILED Main.Methods.Prepares",
        "  suite.st:19: division by zero",
        "SKIPPED Main.Methods.Off",
        "FAILED Main.Methods.First of two",
        "  suite.st:27: division by zero",
        "3 suites, 10 tests: 3 passed, 6 failed, 1 skipped; 4 scans in 30 ms of virtual time",
        "written: j.xml",
    ]
    root = junit_root(Path("j.xml"))
    assert (root.get("errors"), root.get("failures")) == ("6", "0")
    assert main(["test", "suite.st", "--only", "Good", "--only", "Lasts"]) == 1
    assert "FAILED Main.Methods.Prepares" in capsys.readouterr().out


def test_an_error_outside_of_the_suites_ends_the_run(tmp_path: Path) -> None:
    """Source: docs/how-to/unit-tests.md."""
    text = _suite_of("TEST('Waits');").replace("RUN();", "RUN(); Zero := 1 / Zero;")
    results = _run(tmp_path, text.replace("Some : FB_Some;", "Some : FB_Some; Zero : INT;"))
    assert not results.passed
    assert results.ended.endswith("suite.st:7: division by zero")


def test_a_finished_test_that_does_not_exist_ends_the_run(tmp_path: Path) -> None:
    """Source: TcUnit-Verifier, FB_TestFinishedNamedDoesNotExist."""
    body = ("TEST('A');", "TEST_FINISHED_NAMED('B');")
    results = _run(tmp_path, _suite_of(*body))
    assert results.ended == "a wrong call has ended the run"
    assert results.scans == 1
    (failure,) = _tests(results)["A"].failures
    assert failure.message == "a test that the suite does not have has been finished: B"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "PROGRAM Main\nVAR i : INT; END_VAR\ni := 1;\nEND_PROGRAM\n",
            "there is no instance of a block that extends FB_TestSuite",
        ),
        (_suite_of("TEST('A');", run="// RUN"), "no program has called RUN or RUN_IN_SEQUENCE"),
        (
            "FUNCTION_BLOCK FB_TestSuite\n;\nEND_FUNCTION_BLOCK\n",
            "the program declares FB_TestSuite itself",
        ),
        (_suite_of("TEST('A');", "AssertEquals(1, Nothing, '');"), "Nothing is not declared"),
        (
            _suite_of("AssertEquals(A, A, '');", before="VAR A : ARRAY[1..2] OF INT; END_VAR"),
            "AssertEquals takes no value of ARRAY",
        ),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, expected: str
) -> None:
    """Source: docs/how-to/unit-tests.md."""
    file = tmp_path / "suite.st"
    file.write_text(text)
    assert main(["test", str(file)]) == 2
    captured = capsys.readouterr()
    assert expected in captured.err
    assert len(captured.err.splitlines()) == 1


def test_a_junit_file_replaces_no_file_of_another_kind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/how-to/unit-tests.md."""
    file, other = tmp_path / "suite.st", tmp_path / "notes.txt"
    file.write_text(_suite_of("TEST('A');", "TEST_FINISHED();"))
    other.write_text("mine")
    assert main(["test", str(file), "--junit", str(other)]) == 2
    assert "is not a JUnit file" in capsys.readouterr().err
    assert other.read_text() == "mine"


@pytest.mark.exhaustive
def test_coverage_counts_the_program_without_the_framework(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Source: docs/how-to/unit-tests.md."""
    monkeypatch.chdir(tmp_path)
    Path("suite.st").write_text(_suite_of("TEST('A');", "TEST_FINISHED();"))
    assert main(["test", "suite.st", "--coverage"]) == 0
    out = capsys.readouterr().out
    assert "suite.st" in out
    assert "RcxTest" not in out
    assert "100.0 % 3/3" in out


_OBJECT = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="{name}" Id="{{8328f7d8-1dbc-4e08-98b0-eb6438d2b355}}" SpecialFunc="None">
    <Declaration><![CDATA[{head}]]></Declaration>
    <Implementation>
      <ST><![CDATA[{body}]]></ST>
    </Implementation>
  </POU>
</TcPlcObject>
"""


@pytest.mark.exhaustive
def test_a_twincat_project_runs_without_changes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A TwinCAT project runs without changes, and failures have the lines of its files.

    Names of the library TcUnit are qualified. A number as a TIME is in milliseconds.

    Source: docs/how-to/unit-tests.md.
    """
    monkeypatch.chdir(tmp_path)
    head = "FUNCTION_BLOCK FB_Sum_Test EXTENDS TcUnit.FB_TestSuite"
    body = (
        "TcUnit.TEST('TcUnit.RUN');\nAssertTrue(FALSE, 'm'); // TcUnit.x\n"
        "AssertEquals_TIME(T#500ms, UDINT_TO_TIME(500), 'ms');\nTcUnit.TEST_FINISHED();"
    )
    Path("FB_Sum_Test.TcPOU").write_text(_OBJECT.format(name="FB_Sum_Test", head=head, body=body))
    head = "PROGRAM PRG_TEST\nVAR\n  Sum : FB_Sum_Test;\nEND_VAR"
    Path("PRG_TEST.TcPOU").write_text(
        _OBJECT.format(name="PRG_TEST", head=head, body="TcUnit . RUN();")
    )
    assert main(["test", "."]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "FAILED PRG_TEST.Sum.TcUnit.RUN",
        "  FB_Sum_Test.TcPOU:7: expected TRUE, actual FALSE: m",
        "1 suite, 1 test: 0 passed, 1 failed, 0 skipped; 1 scan in 0 ms of virtual time",
    ]
