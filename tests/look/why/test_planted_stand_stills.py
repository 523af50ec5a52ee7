"""Stand-stills with a planted cause: the last link of the chain is what was planted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rcx_harness.look.why.chain import Chain, chains
from rcx_harness.look.why.recorded import facts_of_trace
from stand_still_runs import record
from stand_stills import STAND_STILLS, StandStill

_each = pytest.mark.parametrize("planted", STAND_STILLS, ids=lambda planted: planted.name)


def _chain(planted: StandStill, folder: Path) -> Chain:
    facts = facts_of_trace(record(planted, folder), None)
    found = {chain.controller: chain for chain in chains(facts, facts.last_us)}
    return found[planted.controller]


@pytest.mark.exhaustive
@_each
def test_the_last_link_is_what_was_planted(planted: StandStill, tmp_path: Path) -> None:
    """The expected link is in the table; it was derived from what was planted."""
    chain = _chain(planted, tmp_path)
    assert (chain.error or chain.cause.key) == planted.expected


@pytest.mark.exhaustive
@_each
def test_the_areas_alone_never_give_a_wrong_link(planted: StandStill, tmp_path: Path) -> None:
    """Without variables the cause may be unknown, but never another one."""
    chain = _chain(replace(planted, watch=""), tmp_path)
    allowed = {planted.expected, planted.alone, "unknown", "not-recorded"}
    assert (chain.error or chain.cause.key) in allowed


def test_forty_stand_stills_are_planted() -> None:
    """No two of them are the same."""
    assert len({planted.name for planted in STAND_STILLS}) == len(STAND_STILLS) >= 40
