"""The rules that the virtual controller follows, from `spec/rules.toml`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from rcx_harness.spec.tables import folder
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

__all__ = ["BASES", "Rule", "rules"]

#: The kinds of evidence for a rule, the most certain first.
BASES = ("manual", "public", "measured", "assumed")


@dataclass(frozen=True)
class Rule:
    """A rule of the virtual controller.

    Attributes:
        section: Section of the manual that states the rule; empty if the manual is silent.
        basis: One of BASES. If a row of the table does not state the basis, it is `manual` with a
            section and `assumed` without one.
        source: The public source, or the person, device and firmware of a measurement.
        knobs: The keys of a robot file that change this behaviour.
    """

    id: str
    text: str
    section: str = ""
    basis: str = ""
    source: str = ""
    knobs: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Fill in the basis; raise InputError if basis, section and source do not fit together."""
        if not self.basis:
            object.__setattr__(self, "basis", "manual" if self.section else "assumed")
        if self.basis not in BASES or (self.basis == "manual") != bool(self.section):
            raise InputError(
                f"rule {self.id!r}: basis {self.basis!r} with section {self.section!r}"
            )
        if (self.basis in ("public", "measured")) != bool(self.source):
            raise InputError(f"rule {self.id!r}: basis {self.basis!r} with source {self.source!r}")


@lru_cache(maxsize=1)
def rules() -> tuple[Rule, ...]:
    """Return the rules by area: power and link, dedicated signals, remote commands."""
    table = load_toml(folder() / "rules.toml")["rule"]
    return tuple(Rule(**{**row, "knobs": tuple(row.get("knobs", ()))}) for row in table)
