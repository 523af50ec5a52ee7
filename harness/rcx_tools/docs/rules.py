"""Every rule that the virtual controller follows, as `spec/rules.toml` lists them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from rcx_harness import spec

__all__ = ["Rule", "rules"]


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


@lru_cache(maxsize=1)
def rules() -> tuple[Rule, ...]:
    """In the order of the areas: power and link, dedicated signals, remote commands."""
    table: list[dict[str, Any]] = spec.load_toml(spec.folder() / "rules.toml")["rule"]
    return tuple(Rule(**{**row, "knobs": tuple(row.get("knobs", ()))}) for row in table)
