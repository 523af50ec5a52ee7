"""Results as JUnit XML, which CI systems show: one writer for all commands.

Source of the form: the schema `junit-10.xsd` of Jenkins, which its plug-in xUnit checks. `file`
and `line` of a case are an addition that GitLab shows and other tools ignore.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from structured_text.errors import InputError
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["JunitCase", "JunitFile", "JunitSuite", "Problem", "junit_xml"]

#: Length of the head of a file in which the root element of JUnit XML must be.
_HEAD, _ROOT = 200, b"<testsuite"

#: Characters that XML 1.0 does not allow.
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class Problem(NamedTuple):
    """The reason why a case has not passed.

    Attributes:
        kind: `failure`, or `error` if the case did not come to a result.
        message: The reason in one line.
        text: The reason with its place, and how to replay it.
    """

    kind: str
    message: str
    text: str


@dataclass(frozen=True)
class JunitCase:
    """A case of a suite, such as a test, a seed, or a property.

    Attributes:
        group: The class of the case, by which CI systems group cases.
        file: The source; may be empty.
        line: Line in the source, from 1; 0 if unknown.
        seconds: Duration [s]; None if it was not measured.
        skipped: The reason why the case was not run; empty if it was.
    """

    name: str
    group: str
    file: str = ""
    line: int = 0
    seconds: float | None = None
    problems: tuple[Problem, ...] = ()
    skipped: str = ""

    @property
    def kind(self) -> str:
        """Return `skipped`, `error`, `failure`, or an empty text if the case has passed."""
        if self.skipped:
            return "skipped"
        kinds = {problem.kind for problem in self.problems}
        return "error" if "error" in kinds else "failure" if kinds else ""


@dataclass(frozen=True)
class JunitSuite:
    """A suite with its cases; `output` is what the program has logged."""

    name: str
    cases: Sequence[JunitCase]
    seconds: float | None = None
    output: str = ""


class JunitFile:
    """The JUnit file of a command, if the user has named it.

    Args:
        file: The file, or None.
        read: Files that the command reads; they are not overwritten.

    Raises:
        InputError: The file is an input, or is not a JUnit file.
    """

    def __init__(self, file: Path | None, read: Iterable[Path] = ()) -> None:
        self._file = file
        if file is None:
            return
        if real(file) in map(real, read):
            raise InputError("would be overwritten, but it is an input", file=file)
        if os.path.isdir(file):
            raise InputError("is a folder, not a file", file=file)
        if not os.path.isfile(file):
            return
        with file.open("rb") as stream:
            head = stream.read(_HEAD)
        if head and _ROOT not in head:
            raise InputError(
                "is there already, and is not a JUnit file; nothing was written",
                file=file,
                hint="name another file, or remove this one",
            )

    @property
    def wanted(self) -> bool:
        """Return whether the user has named a file."""
        return self._file is not None

    def write(self, suites: Sequence[JunitSuite], seconds: float | None = None) -> None:
        """Write the file; do nothing if no file is named. `seconds` is the time of all suites."""
        if self._file is not None:
            replace_files({self._file: junit_xml(suites, seconds)})

    def say(self) -> None:
        """Print the name of the written file; do nothing if no file is named."""
        if self._file is not None:
            print(f"written: {self._file}")


def junit_xml(suites: Sequence[JunitSuite], seconds: float | None = None) -> str:
    """Return suites as JUnit XML."""
    every = [case for suite in suites for case in suite.cases]
    counts = _counts(every, seconds)
    del counts["skipped"]  # the schema has this number in the suites only
    root = Element("testsuites", counts)
    for suite in suites:
        about = {"name": _plain(suite.name), **_counts(suite.cases, suite.seconds)}
        found = SubElement(root, "testsuite", about)
        for case in suite.cases:
            _add(found, case)
        if suite.output:
            SubElement(found, "system-out").text = _plain(suite.output)
    indent(root)
    written: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    return written.decode("utf-8") + "\n"


def _counts(cases: Sequence[JunitCase], seconds: float | None) -> dict[str, str]:
    kinds = [case.kind for case in cases]
    counts = {
        "tests": str(len(kinds)),
        "failures": str(kinds.count("failure")),
        "errors": str(kinds.count("error")),
        "skipped": str(kinds.count("skipped")),
    }
    # The schema of a suite allows three digits behind the point.
    return counts if seconds is None else {**counts, "time": f"{seconds:.3f}"}


def _add(suite: Element, case: JunitCase) -> None:
    about = {"classname": _plain(case.group), "name": _plain(case.name)}
    if case.file:
        about["file"] = _plain(case.file)
    if case.line:
        about["line"] = str(case.line)
    if case.seconds is not None:
        about["time"] = f"{case.seconds:.6f}"
    found = SubElement(suite, "testcase", about)
    if case.skipped:
        SubElement(found, "skipped", {"message": _plain(case.skipped)})
    for kind, message, text in case.problems:
        about = {"message": _plain(message), "type": kind}
        SubElement(found, kind, about).text = _plain(text)


def _plain(text: str) -> str:
    return _FORBIDDEN.sub("?", text)
