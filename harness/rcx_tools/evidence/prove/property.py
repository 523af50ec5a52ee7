"""A property: a claim in words, its assumptions, and the goals that prove it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from rcx_tools.evidence.prove.library import Library

__all__ = ["Goal", "Property"]


@dataclass(frozen=True)
class Goal:
    """One question to the solver: `claim` holds wherever all of `assumed` holds.

    `show` are terms; their values explain a counterexample to people.
    """

    name: str
    assumed: tuple[Any, ...]
    claim: Any
    show: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Property:
    """A property that is proved for every program.

    Attributes:
        name: Short name, used in out/prove.json and in the seeded bugs.
        says: One sentence for people.
        section: Section of the manual, or a page of docs/.
        assumes: Names of entries of `assumptions.ASSUMPTIONS`.
        goals: Yields the goals of a part of the library; all of them must be proved.
        parts: Names of parts that are independent jobs (blocks, or parts of an induction).
        uses: Names of properties that this one relies on; their assumptions are included.
        rests_on: POUs that a part depends on, together with all POUs they use; None for all.
    """

    name: str
    says: str
    section: str
    assumes: tuple[str, ...]
    goals: Callable[[Library, str], Iterator[Goal]]
    parts: Callable[[Library], Iterable[str]] = lambda _: ("",)
    rests_on: Callable[[str], Iterable[str]] | None = None
    uses: tuple[str, ...] = ()
