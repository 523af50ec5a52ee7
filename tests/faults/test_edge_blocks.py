"""Edge-triggered blocks never hang or restart by themselves, and recover from every fault."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from fault_cell import CaseFailure, library
from fault_run import FAULTS, Case, rig
from fault_scenarios import SCENARIOS
from rcx_tools.library import files as generated

_MOST_SHOWN = 3


def test_every_edge_triggered_block_has_a_scenario() -> None:
    """Every edge-triggered block has a scenario.

    Two generated blocks represent all generated blocks.

    Source: tests/tools/library/test_generated.py.
    """
    alike = {path.rpartition("/")[2].removesuffix(".st") for path in generated()}
    assert set(library().edge) - alike == set(SCENARIOS) - {"FB_MovePtp", "FB_ReadPoint"}


_BLOCKS = sorted(set(library().edge) & set(SCENARIOS))


@pytest.mark.exhaustive(
    but=[
        "FB_ReadPoint",
        "FB_AlarmReset",
        "FB_ProgramStop",
        "FB_ReturnToOrigin",
        "FB_AutoStart",
        "FB_MovePtp",
        "FB_EmergencyStop",
        "FB_PickPlace",
    ]
)
@pytest.mark.parametrize("block", _BLOCKS)
def test_a_block_recovers_from_each_fault(block: str) -> None:
    """The block recovers from each fault in the middle of its work.

    Each answer of the controller is missing, late or withdrawn once.

    Source: manual chapter 1, 5; chapter 5, 2 and 3.
    """
    _run(block, rig(block).one_of_each())


@pytest.mark.exhaustive
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("block", _BLOCKS)
def test_a_block_ends_withdraws_its_requests_and_works_again(
    block: str,
    fault: str,
    record_property: Callable[[str, object], None],
    pytestconfig: pytest.Config,
) -> None:
    """The block recovers from a fault at any scan.

    Source: manual chapter 1, 5; chapter 5, 2 and 3.
    """
    cases = rig(block).cases(FAULTS[fault], every=pytestconfig.getoption("every_case"))
    record_property("instances", len(cases))
    _run(block, cases)


def _run(block: str, cases: list[Case]) -> None:
    assert len(cases) > 8
    failures = []
    for case in cases:
        try:
            rig(block).run(case)
        except CaseFailure as failure:
            failures.append(str(failure))
    assert not failures, f"{len(failures)} of {len(cases)} cases:\n" + "\n".join(
        failures[:_MOST_SHOWN]
    )
