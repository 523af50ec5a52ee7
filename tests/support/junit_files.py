"""JUnit files: the form that CI systems read, written by hand from the schema of Jenkins."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

__all__ = ["junit_root"]

#: The required and the optional attributes of each element, and its children.
_FORM = {
    "testsuites": ("", "name time tests failures errors", "testsuite"),
    "testsuite": ("name tests failures errors", "time skipped", "testcase system-out"),
    # The schema of Jenkins lacks file and line, which GitLab shows.
    "testcase": ("name", "time classname file line", "skipped error failure"),
    "skipped": ("", "message type", ""),
    "error": ("", "message type", ""),
    "failure": ("", "message type", ""),
    "system-out": ("", "", ""),
}


def junit_root(file: Path) -> Element:
    """Return the root of a JUnit file; fail if it violates the schema or its numbers are wrong."""
    root = ElementTree.parse(file).getroot()
    assert root.tag == "testsuites"
    for element in root.iter():
        required, optional, children = (set(words.split()) for words in _FORM[element.tag])
        assert required <= set(element.keys()) <= required | optional, element.attrib
        assert {child.tag for child in element} <= children, element.tag
    for suite in (root, *root.iter("testsuite")):
        cases = list(suite.iter("testcase"))
        errors = [case for case in cases if case.find("error") is not None]
        failed = [case for case in cases if case.find("failure") is not None]
        numbers = [len(cases), len([case for case in failed if case not in errors]), len(errors)]
        assert [suite.get(name) for name in ("tests", "failures", "errors")] == [*map(str, numbers)]
        assert re.fullmatch(r"\d+\.\d{3}", suite.get("time", "0.000"))
    return root
