"""What a property is: a claim in words, what it rests on, and the goals that make it up."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from rcx_tools.evidence.prove.library import Library

__all__ = ["Goal", "Property"]


@dataclass(frozen=True)
class Goal:
    """One question to the solver: `claim` holds wherever all of `assumed` does.

    `show` are terms whose values tell people what a refutation looks like.
    """

    name: str
    assumed: tuple[Any, ...]
    claim: Any
    show: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Property:
    """Something that is proved for every program.

    Attributes:
        name: Short, as in out/prove.json and in the seeded bugs.
        says: One sentence for people.
        section: Of the manual, or of a page of docs/.
        assumes: Names of entries of `assumptions.ASSUMPTIONS`.
        goals: The goals of a part of the library; all of them have to be proved.
        parts: Names of parts that are independent jobs (blocks, or parts of an induction).
        uses: Names of properties of which it takes for granted what they prove; what they assume
            it assumes, too.
        rests_on: POUs whose sources, with all that they use, a part depends on; None for all.
    """

    name: str
    says: str
    section: str
    assumes: tuple[str, ...]
    goals: Callable[[Library, str], Iterator[Goal]]
    parts: Callable[[Library], Iterable[str]] = lambda _: ("",)
    rests_on: Callable[[str], Iterable[str]] | None = None
    uses: tuple[str, ...] = ()
