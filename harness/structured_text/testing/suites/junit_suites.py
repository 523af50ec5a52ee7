"""Results of unit tests as suites of a JUnit file; times are virtual."""

from __future__ import annotations

from collections.abc import Sequence

from structured_text.output.junit import JunitCase, JunitSuite, Problem
from structured_text.testing.suites.results import Case, Results, Suite

__all__ = ["junit_suites"]


def junit_suites(results: Results) -> list[JunitSuite]:
    """Return the results as suites; the last suite has the messages of the whole run."""
    suites = []
    for number, suite in enumerate(results.suites, 1):
        tests = list(suite.tests.values())
        cases = [_case(suite, test, results) for test in tests]
        output = "\n".join(results.messages) if number == len(results.suites) else ""
        suites.append(JunitSuite(suite.name, cases, _span_us(tests) / 1e6, output))
    return suites


def _span_us(tests: Sequence[Case]) -> int:
    begun = [test for test in tests if not test.skipped]
    ends = [test.began_us if test.ended_us is None else test.ended_us for test in begun]
    return max(ends) - min(test.began_us for test in begun) if begun else 0


def _case(suite: Suite, test: Case, results: Results) -> JunitCase:
    problems = []
    for failure in test.failures:
        kind = "error" if failure.expected is None else "failure"
        where = f"{failure.place}: " if failure.place else ""
        problems.append(Problem(kind, failure.message, f"{where}{failure.message}"))
    if test.unfinished and not any(one.kind == "error" for one in problems):
        text = f"has not finished: {results.ended}"
        problems.append(Problem("error", text, text))
    file, line = (test.place.file, test.place.line) if test.place else ("", 0)
    return JunitCase(
        test.name,
        suite.name,
        file,
        line,
        test.duration_us / 1e6,
        tuple(problems),
        "disabled" if test.skipped else "",
    )
