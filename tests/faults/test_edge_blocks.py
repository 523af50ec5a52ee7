"""Nothing hangs, nothing restarts by itself, and every fault has its way back: all edge blocks."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from fault_cell import CaseFailure, library
from fault_run import FAULTS, rig
from fault_scenarios import SCENARIOS
from rcx_tools.library import files as generated

_TOLD = 3


def test_every_edge_triggered_block_has_a_scenario() -> None:
    """The generated blocks are alike (tests/tools/library/test_generated.py): two stand for all."""
    alike = {path.rpartition("/")[2].removesuffix(".st") for path in generated()}
    assert set(library().edge) - alike == set(SCENARIOS) - {"FB_MovePtp", "FB_ReadPoint"}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("block", sorted(set(library().edge) & set(SCENARIOS)))
def test_a_block_ends_lets_go_and_works_again(
    block: str, fault: str, record_property: Callable[[str, object], None]
) -> None:
    """Source: manual chapter 1, 5; chapter 5, 2 and 3."""
    count = 0
    failures = []
    for case in rig(block).cases(FAULTS[fault]):
        count += 1
        try:
            rig(block).run(case)
        except CaseFailure as failure:
            failures.append(str(failure))
    record_property("instances", count)
    assert count > 10
    assert not failures, f"{len(failures)} of {count} cases:\n" + "\n".join(failures[:_TOLD])
