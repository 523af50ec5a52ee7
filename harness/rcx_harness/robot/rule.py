"""One rule of the virtual controller."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Rule", "assumed", "manual"]


@dataclass(frozen=True)
class Rule:
    """One rule; `section` for what the manual says, `knobs` for what is assumed."""

    id: str
    text: str
    section: str = ""
    knobs: tuple[str, ...] = ()

    @property
    def from_manual(self) -> bool:
        """The manual says so."""
        return bool(self.section)


def manual(name: str, section: str, text: str) -> Rule:
    """What the manual says."""
    return Rule(name, text, section=section)


def assumed(name: str, knobs: str, text: str) -> Rule:
    """What is assumed; the knobs by name, with spaces between them."""
    return Rule(name, text, knobs=tuple(knobs.split()))
