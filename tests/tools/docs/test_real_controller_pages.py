"""Pages for users of a real controller begin with safety and are short; probes.md is complete."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_harness.look.probe.catalogue import questions
from rcx_harness.spec.rules import rules
from rcx_tools.docs.probes import probes_page


@pytest.mark.parametrize(
    ("name", "most"),
    [("compare", 100), ("judge", 130), ("points", 100), ("probe", 100), ("real-controller", 100)],
)
def test_safety_comes_first_and_the_page_is_two_screens_at_most(
    repository: Path, name: str, most: int
) -> None:
    lines = (repository / f"docs/how-to/{name}.md").read_text(encoding="utf-8").splitlines()
    assert re.match(r"> \*\*Safety( first)?\.\*\*", lines[2])
    assert len(lines) <= most


def test_the_page_on_probes_has_every_question_and_every_assumed_rule() -> None:
    page = probes_page()
    for one in questions():
        assert f"| `{one.id}` | {one.risk.value} | {one.title} |" in page
    named = re.findall(r"^\| `([\w-]+)` \| [^|]+\|$", page, re.MULTILINE)
    assert named == [rule.id for rule in rules() if rule.basis == "assumed"]
