"""`rcx test` runs files with TEST blocks, as STruC++ has them."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.cell.sources import source_files
from rcx_harness.cli.app import main
from rcx_harness.testing.suites import FRAMEWORK
from rcx_harness.testing.suites.check import check_suites
from structured_text.testing.suites.results import Case, Results
from structured_text.testing.suites.run import run_suites

_SOURCES = """FUNCTION_BLOCK Counter
VAR_INPUT reset : BOOL; END_VAR
VAR_OUTPUT count : INT; END_VAR
IF reset THEN count := 0; ELSE count := count + 1; END_IF;
END_FUNCTION_BLOCK
FUNCTION Add : INT
VAR_INPUT a, b : INT; END_VAR
Add := a + b;
END_FUNCTION
PROGRAM Plant
VAR c : Counter; sum : INT; END_VAR
c(reset := FALSE);
sum := Add(1, 2);
END_PROGRAM
CONFIGURATION Config
  RESOURCE Plc ON PLC
    TASK Fast(INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM p WITH Fast : Plant;
  END_RESOURCE
END_CONFIGURATION
"""
_TESTS = """SETUP
VAR c : Counter; t : TON; END_VAR
  c(reset := FALSE);
END_SETUP

TEARDOWN
  c(reset := TRUE);
END_TEARDOWN

TEST "counts"
  c(reset := FALSE);
  ASSERT_EQ(c.count, 2);
  ASSERT_EQ(c.count, 4, "it's (not) four; really");
  ASSERT_EQ(c.count, 5);
END_TEST

TEST 'each test begins anew'
  VAR k : INT; END_VAR
  FOR k := 1 TO 3 DO
    (* ASSERT_EQ(1, 2); *)
    ASSERT_LE(c.count, 2);
    c();
  END_FOR;
END_TEST

TEST "timer"
  t(IN := TRUE, PT := T#100ms);
  ASSERT_FALSE(t.Q);
  ADVANCE_TIME(99_000_000 + 999_999);
  t(IN := TRUE, PT := T#100ms);
  ASSERT_FALSE(t.Q);
  ADVANCE_TIME(T#1ms);
  t(IN := TRUE, PT := T#100ms);
  ASSERT_TRUE(t.Q);
END_TEST

TEST "others"
  ASSERT_NEQ(1, 2); ASSERT_GT(2, 1); ASSERT_LT(1, 2); ASSERT_GE(2, 2); ASSERT_LE(2, 2);
  ASSERT_NEAR(3.149, 3.14, 0.01); ASSERT_EQ('a', 'a');
  ASSERT_NEAR(
    3.2, 3.14,
    0.01);
END_TEST

TEST "mocks"
  VAR m : Plant; END_VAR
  MOCK m.c;
  MOCK_FUNCTION Add RETURNS 42;
  m(); m();
  MOCK_VERIFY_CALLED(m.c);
  MOCK_VERIFY_CALL_COUNT(m.c, 2);
  ASSERT_EQ(m.c.count, 0);
  ASSERT_EQ(m.sum, 42);
END_TEST

TEST "mocks end with their test"
  VAR m : Plant; END_VAR
  m();
  ASSERT_EQ(m.c.count, 1);
  ASSERT_EQ(m.sum, 3);
  ASSERT_GT(m.sum, 3);
END_TEST
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """Return the results of the test file `_TESTS`."""
    folder = tmp_path_factory.mktemp("files")
    (folder / "plant.st").write_text(_SOURCES)
    (folder / "test_plant.st").write_text(_TESTS)
    return run_suites(source_files(folder), FRAMEWORK)


def _found(results: Results) -> dict[str, tuple[int, list[str]]]:
    """Return, for each test name, the number of asserts and the failures with their lines."""

    def told(test: Case) -> list[str]:
        return [f"{one.place.line}: {one.message}" for one in test.failures if one.place]

    return {test.name: (test.asserts, told(test)) for _, test in results.tests()}


def test_a_failed_assert_ends_its_test_with_line_and_message(results: Results) -> None:
    """Source: STruC++, docs/TESTING.md, assertions."""
    found = _found(results)
    assert found["counts"] == (2, ["13: expected 4, actual 2: it's (not) four; really"])
    assert [suite.name for suite in results.suites] == ["test_plant"]


def test_each_test_has_fresh_variables_and_runs_setup_before(results: Results) -> None:
    """Each test has new variables and runs SETUP before.

    A third call counts 3, so the counter was new.

    Source: STruC++, docs/TESTING.md, SETUP / TEARDOWN.
    """
    expected = ["21: expected <= 2, actual 3: ASSERT_LE(c.count, 2)"]
    assert _found(results)["each test begins anew"] == (3, expected)


def test_advance_time_takes_nanoseconds_or_a_time(results: Results) -> None:
    """Source: STruC++, docs/TESTING.md, time advancement; its timer tests."""
    assert _found(results)["timer"] == (3, [])


def test_all_asserts_are_known_even_on_several_lines(results: Results) -> None:
    """Source: STruC++, docs/TESTING.md, assertions."""
    expected = ["40: expected 3.14 within 0.01, actual 3.2: ASSERT_NEAR(3.2, 3.14, 0.01)"]
    assert _found(results)["others"] == (8, expected)


def test_an_error_at_run_time_ends_its_test_and_no_other(tmp_path: Path) -> None:
    """Source: docs/how-to/unit-tests.md."""
    file = tmp_path / "test.st"
    file.write_text(
        'TEST "divides"\nVAR z : INT; END_VAR\nz := 1 / z;\nASSERT_TRUE(FALSE);\nEND_TEST\n'
        'TEST "good"\nASSERT_TRUE(TRUE);\nEND_TEST\n'
        'TEST "mocks"\nVAR z : INT; END_VAR\nMOCK z;\nEND_TEST\n'
    )
    found = _found(run_suites(source_files(file), FRAMEWORK))
    assert found["divides"] == (0, ["3: division by zero"])
    assert found["good"] == (1, [])
    assert found["mocks"] == (0, ["11: MOCK z: it is not a function block"])


def test_a_mocked_instance_is_not_executed_and_a_mocked_function_returns_its_value(
    results: Results,
) -> None:
    """Source: STruC++, docs/TESTING.md, mocking."""
    found = _found(results)
    assert found["mocks"] == (4, [])
    expected = ["61: expected > 3, actual 3: ASSERT_GT(m.sum, 3)"]
    assert found["mocks end with their test"] == (3, expected)


def test_a_test_of_pytest_runs_suites_and_lists_what_fails(tmp_path: Path) -> None:
    """Source: docs/how-to/unit-tests.md."""
    file = tmp_path / "test.st"
    file.write_text('TEST "good"\nASSERT_TRUE(TRUE);\nEND_TEST\n')
    assert check_suites(file).passed
    file.write_text('TEST "bad"\nASSERT_TRUE(FALSE);\nEND_TEST\n')
    with pytest.raises(AssertionError, match=r"FAILED test.bad\n.*test.st:2: expected TRUE"):
        check_suites(file)


@pytest.mark.exhaustive
def test_mutants_are_judged_by_the_suites(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/how-to/unit-tests.md."""
    monkeypatch.chdir(tmp_path)
    block = "FUNCTION_BLOCK B\nVAR_OUTPUT y : INT; END_VAR\ny := y + 1;\nEND_FUNCTION_BLOCK\n"
    Path("b.st").write_text(block)
    test = 'TEST "counts"\nVAR b : B; END_VAR\nb();\nASSERT_EQ(b.y, 1);\nb();\nASSERT_EQ(b.y, 2);\n'
    Path("suite.st").write_text(f"{test}END_TEST\n")
    Path("test_b.py").write_text(
        "from rcx_harness.testing.suites.check import check_suites\n"
        "def test_suites():\n    check_suites(['b.st', 'suite.st'])\n"
    )
    assert main(["mutants", "b.st", "--", "pytest", "-q", "-p", "no:cacheprovider"]) == 0
    assert " survive: 100.0 %" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('TEST "a"\n', "test.st:1: this TEST is never closed; END_TEST"),
        ('TEST "a"\nASSERT_SAME(1, 2);\nEND_TEST\n', "test.st:2: ASSERT_SAME with 2 arguments"),
        ('TEST "a"\nASSERT_EQ(1, 2;\nEND_TEST\n', "test.st:2: this ASSERT_EQ has no end"),
        ('TEST "a"\nASSERT_EQ(none, 2);\nEND_TEST\n', "test.st:2:"),
        ('TEST "a"\nMOCK_FUNCTION F RETURNS 2;\nEND_TEST\n', "test.st:2: there is no function F"),
    ],
)
def test_an_error_in_a_test_file_has_file_and_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, expected: str
) -> None:
    """Source: docs/how-to/unit-tests.md."""
    file = tmp_path / "test.st"
    file.write_text(text)
    assert main(["test", str(file)]) == 2
    message = capsys.readouterr().err
    assert expected in message
    assert len(message.splitlines()) == 1
