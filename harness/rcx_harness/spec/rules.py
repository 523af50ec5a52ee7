"""Every rule that the virtual controller follows, as `spec/rules.toml` lists them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from rcx_harness.spec.tables import folder
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

__all__ = ["BASES", "Rule", "rules"]

#: What a rule can rest on, the surest first.
BASES = ("manual", "public", "measured", "assumed")


@dataclass(frozen=True)
class Rule:
    """One rule.

    Attributes:
        id: Its name.
        text: What it says.
        section: Of the manual, if that says it.
        basis: One of BASES; of the table's rows only those have it that are neither the manual's
            nor assumed.
        source: Where a public source stands, or who measured what, with which firmware.
        knobs: The keys of a robot file that change it.
    """

    id: str
    text: str
    section: str = ""
    basis: str = ""
    source: str = ""
    knobs: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a rule that rests on nothing that is named (InputError)."""
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
    """In the order of the areas: power and link, dedicated signals, remote commands."""
    table = load_toml(folder() / "rules.toml")["rule"]
    return tuple(Rule(**{**row, "knobs": tuple(row.get("knobs", ()))}) for row in table)
