"""Every rule that is reported as broken names its section."""

from __future__ import annotations

import inspect
import re

import pytest

from rcx_harness.testing.settings import RULES
from rcx_harness.watch import answers
from rcx_harness.watch.sections import section_of

_OF_ANSWERS = set(re.findall(r'\("([a-z]+)", (?:f"|text|shown)', inspect.getsource(answers)))


@pytest.mark.parametrize(
    "rule", sorted({*(r for some in RULES.values() for r in some), *_OF_ANSWERS})
)
def test_every_rule_has_its_section(rule: str) -> None:
    assert section_of(rule)


@pytest.mark.parametrize(
    ("rule", "section"),
    [
        ("interval", "ch. 5, 3"),
        ("command held", "guide, 1.1"),
        ("data before code", "guide, 1.1"),
        ("ready before code", "guide, 1.2"),
        ("hold-command", "guide, 1.1"),
        ("contract", "docs/how-to/testing.md"),
        ("no rule", ""),
    ],
)
def test_each_rule_names_its_section_of_the_manual(rule: str, section: str) -> None:
    """Source: manual chapter 5, 3, caution; guide 1.1 (held; data first) and 1.2 (ready status)."""
    assert section_of(rule) == section
