"""The sections of the manual that state the rules."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from rcx_harness.spec.rules import rules

__all__ = ["section_of"]

#: The rules that this package checks. The rules of the controller are in spec/rules.toml.
_SECTIONS = {
    "start against stop": "ch. 5, 2 and 3.2",
    "data before code": "guide, 1.1",
    "command held": "guide, 1.1",
    "ready before code": "guide, 1.2",
    "status": "guide, 1.2",
    "response": "guide, 2",
    "contract": "docs/how-to/testing.md",
    "calls": "docs/how-to/testing.md",
}


def section_of(rule: str) -> str:
    """Return the section of the manual (or our page) that states a rule; empty if it is unknown."""
    return _SECTIONS.get(rule) or _of_controller().get(rule, "")


@lru_cache(maxsize=1)
def _of_controller() -> Mapping[str, str]:
    return {one.id: one.section for one in rules()}
