"""The last lines of a test run are short, and name the next command for the reader."""

from __future__ import annotations

from pathlib import Path

import pytest

from run_report import skip_lines

_TESTS = """
import pytest

@pytest.mark.exhaustive
@pytest.mark.parametrize("k", range(3))
def test_large(k): pass

@pytest.mark.external(reason="needs npm: make site-test")
def test_outside(): raise AssertionError("it must not run")

def test_red(): assert ORDER.append("red") or {red}
def test_last(): ORDER.append("last"); print(ORDER)

ORDER = []
"""


@pytest.fixture
def suite(pytester: pytest.Pytester, repository: Path) -> pytest.Pytester:
    """Return a folder with this repository's conftest.py and markers, and a few tests."""
    pytester.makeconftest((repository / "tests/conftest.py").read_text("utf-8"))
    marks = "exhaustive", "external(reason)"
    pytester.makeini("[pytest]\nmarkers =\n" + "".join(f"    {mark}\n" for mark in marks))
    return pytester


def test_reasons_that_mean_the_same_are_one_line() -> None:
    reasons = ["Skipped: matiec not found: set RCX_MATIEC", "needs matiec", "Skipped: no IPv6 here"]
    assert skip_lines(reasons) == [
        "       2 need matiec or STruC++: docs/reference/engines.md",
        "       1 no IPv6 here",
    ]


def test_a_run_without_failures_prints_what_was_left_out(suite: pytest.Pytester) -> None:
    """A run without failures prints what was left out.

    The seed 4 puts the last test first in every run.
    """
    suite.makepyfile(_TESTS.format(red=True))
    result = suite.runpytest_inprocess("-m", "not exhaustive", "-p", "no:xdist", "-s", "--order=4")
    result.stdout.fnmatch_lines(
        [
            "*['last']*",
            "skipped:",
            "*1 need the built site: make site-test",
            "3 exhaustive tests were left out: make test-all runs them, too",
        ]
    )
    result.assert_outcomes(passed=2, skipped=1, deselected=3)


def test_tests_of_a_missing_engine_are_counted_and_not_run(suite: pytest.Pytester) -> None:
    """Tests of a missing engine are counted and not run.

    A test that the user names is reported as skipped.
    """
    suite.makepyfile(
        """
        import pytest

        @pytest.mark.skipif(True, reason="matiec not found: set RCX_MATIEC")
        def test_compiled(): raise AssertionError("it must not run")

        @pytest.mark.skipif(False, reason="matiec not found: set RCX_MATIEC")
        def test_found(): pass
        """
    )
    line = "       1 need matiec or STruC++: docs/reference/engines.md"
    result = suite.runpytest_inprocess("-p", "no:xdist")
    result.stdout.fnmatch_lines(["skipped:", line])
    result.assert_outcomes(passed=1)
    name = "test_tests_of_a_missing_engine_are_counted_and_not_run.py::test_compiled"
    result = suite.runpytest_inprocess("-p", "no:xdist", name)
    result.stdout.fnmatch_lines(["skipped:", line])
    result.assert_outcomes(skipped=1)


def test_a_red_run_says_how_to_repeat_a_failure(suite: pytest.Pytester) -> None:
    suite.makepyfile(_TESTS.format(red=False))
    result = suite.runpytest_inprocess("-p", "no:xdist", "-s", "--order=reverse")
    result.stdout.fnmatch_lines(["*['last']*", "repeat one: * -n 0 '*::test_red'"])
    result.assert_outcomes(passed=4, skipped=1, failed=1)
