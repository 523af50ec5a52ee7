"""Properties of the library: each is a claim in words, with assumptions and goals that prove it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from rcx_tools.evidence.prove.library import Library

__all__ = ["Goal", "Property"]


@dataclass(frozen=True)
class Goal:
    """One question to the solver: does `claim` follow from all of `assumed`?

    `show` has terms. Their values explain a counterexample to people.
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
        says: The claim as a sentence for people.
        section: Section of the manual, or page of docs/.
        assumes: Names of entries of `assumptions.ASSUMPTIONS`.
        goals: Function that yields the goals of a part. All of them must be proved.
        parts: Function that returns the names of the parts (blocks, or parts of an induction). Each
            part is an independent job.
        uses: Names of properties that the proof uses. Their assumptions are included.
        rests_on: Function that returns the POUs that a part is about. All POUs that they use are
            added. None means all POUs.
    """

    name: str
    says: str
    section: str
    assumes: tuple[str, ...]
    goals: Callable[[Library, str], Iterator[Goal]]
    parts: Callable[[Library], Iterable[str]] = lambda _: ("",)
    rests_on: Callable[[str], Iterable[str]] | None = None
    uses: tuple[str, ...] = ()
