"""Results of unit tests as JUnit XML, which CI systems show."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from structured_text.errors import InputError
from structured_text.output.paths import real
from structured_text.projects.sources import SourceFiles
from structured_text.testing.suites.results import Case, Results, Suite

__all__ = ["check_junit", "junit_xml"]

#: Length of the head of a file in which the root element of JUnit XML must be.
_HEAD, _ROOT = 200, b"<testsuite"

#: Characters that XML 1.0 does not allow.
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def check_junit(output: Path, files: SourceFiles) -> None:
    """Raise InputError if writing a file would destroy a source or a file of another kind."""
    if real(output) in {real(file) for file in files.all}:
        raise InputError("would be overwritten, but it is an input", file=output)
    if os.path.isdir(output):
        raise InputError("is a folder, not a file", file=output)
    if not os.path.isfile(output):
        return
    with output.open("rb") as stream:
        head = stream.read(_HEAD)
    if head and _ROOT not in head:
        raise InputError(
            "is there already, and is not a JUnit file; nothing was written",
            file=output,
            hint="name another file, or remove this one",
        )


def junit_xml(results: Results) -> str:
    """Return the results as JUnit XML; times are virtual."""
    every = [test for _, test in results.tests()]
    root = Element("testsuites", _counts(every, results.duration_us))
    for suite in results.suites:
        tests = list(suite.tests.values())
        duration_us = _span_us(tests)
        found = SubElement(root, "testsuite", {"name": suite.name, **_counts(tests, duration_us)})
        for test in tests:
            _case(found, suite, test, results)
    if results.messages:
        SubElement(root, "system-out").text = _plain("\n".join(results.messages))
    indent(root)
    written: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    return written.decode("utf-8") + "\n"


def _counts(tests: Iterable[Case], duration_us: int) -> dict[str, str]:
    tests = list(tests)
    errors = [test for test in tests if _is_error(test)]
    failed = [test for test in tests if test.failures and test not in errors]
    return {
        "tests": str(len(tests)),
        "failures": str(len(failed)),
        "errors": str(len(errors)),
        "skipped": str(sum(test.skipped for test in tests)),
        "assertions": str(sum(test.asserts for test in tests)),
        "time": f"{duration_us / 1e6:.6f}",
    }


def _span_us(tests: list[Case]) -> int:
    begun = [test for test in tests if not test.skipped]
    ends = [test.began_us if test.ended_us is None else test.ended_us for test in begun]
    return max(ends) - min(test.began_us for test in begun) if begun else 0


def _is_error(test: Case) -> bool:
    """Return whether a test has not ended, or has ended with an error of the program."""
    return test.unfinished or any(failure.expected is None for failure in test.failures)


def _case(suite: Element, of: Suite, test: Case, results: Results) -> None:
    about = {"classname": of.name, "name": _plain(test.name)}
    if test.place is not None:
        about |= {"file": _plain(test.place.file), "line": str(test.place.line)}
    about |= {"assertions": str(test.asserts), "time": f"{test.duration_us / 1e6:.6f}"}
    case = SubElement(suite, "testcase", about)
    if test.skipped:
        SubElement(case, "skipped", {"message": "disabled"})
    for failure in test.failures:
        kind = "error" if failure.expected is None else "failure"
        found = SubElement(case, kind, {"message": _plain(failure.message), "type": kind})
        where = f"{failure.place}: " if failure.place else ""
        found.text = _plain(f"{where}{failure.message}")
    if test.unfinished and not any(one.expected is None for one in test.failures):
        text = f"has not finished: {results.ended}"
        SubElement(case, "error", {"message": text, "type": "error"}).text = text


def _plain(text: str) -> str:
    return _FORBIDDEN.sub("?", text)
