"""judge.md names all rules that `rcx judge` checks."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest

from rcx_harness.trace.chart import MOST_INSTANTS
from rcx_harness.watch import answers, wire


@pytest.fixture
def page(repository: Path) -> str:
    return (repository / "docs/how-to/judge.md").read_text(encoding="utf-8")


def test_every_rule_that_is_judged_is_named(page: str) -> None:
    rules = {
        rule
        for module in (wire, answers)
        for rule in re.findall(r'\("([a-z ]+)", (?:f"|text|f\'|shown)', inspect.getsource(module))
    }
    assert {"interval", "command held", "status", "response", "reserved"} <= rules
    judged = rules - {"data before code"}
    assert {rule for rule in judged if f"`{rule}`" not in page} == set()


def test_the_page_says_how_many_instants_are_drawn(page: str) -> None:
    assert f"{MOST_INSTANTS} instants" in page
