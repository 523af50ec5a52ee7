"""Seeded bugs in blocks. The campaign must find each of these bugs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from rcx_harness.verify.storm.storms import Failure
from rcx_tools.evidence.broken import BUGS, Bug, broken_library, bugs
from rcx_tools.evidence.campaign.run import compiled, run_storms
from rcx_tools.evidence.campaign.schedule import draw_run

__all__ = ["SEEDED", "Found", "Seeded", "find"]


@dataclass(frozen=True)
class Seeded(Bug):
    """A seeded bug, with the kinds of findings that the campaign may report first."""

    kinds: tuple[str, ...]


class Found(NamedTuple):
    """The seed of the run that found a seeded bug, and the failure in that run."""

    seed: int
    failure: Failure


SEEDED = tuple(bugs([BUGS / "campaign.toml"], Seeded))


def find(
    seeded: Seeded,
    engine: str,
    *,
    storms: int = 2,
    most: int = 30,
    tried: Callable[[], None] = lambda: None,
) -> Found | None:
    """Run the broken library with one seed after the other until a run fails.

    Return None if no run fails.
    """
    with broken_library(seeded.file, seeded.old, seeded.new) as lib:
        program = compiled(engine, lib)
        for seed in range(most):
            conditions, acts = draw_run(seed, storms)
            try:
                run_storms(program, conditions, acts, seed)
            except Failure as failure:
                return Found(seed, failure)
            finally:
                tried()
    return None
