"""No edge-triggered block hangs or restarts by itself, and each recovers from every fault."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from fault_cell import CaseFailure, library
from fault_run import FAULTS, Case, rig
from fault_scenarios import SCENARIOS
from rcx_tools.library import files as generated

_MOST_SHOWN = 3


def test_every_edge_triggered_block_has_a_scenario() -> None:
    """Two generated blocks represent all, as these are similar.

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
        "FB_PointBackup",
        "FB_ServoOn",
        "FB_MovePtp",
        "FB_EmergencyStop",
        "FB_PickPlace",
    ]
)
@pytest.mark.parametrize("block", _BLOCKS)
def test_a_block_comes_back_from_each_fault_once(block: str) -> None:
    """Each fault comes in the middle of the work.

    Each answer is missing, late or withdrawn once.

    Source: manual chapter 1, 5; chapter 5, 2 and 3.
    """
    _run(block, rig(block).one_of_each())


@pytest.mark.exhaustive
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("block", _BLOCKS)
def test_a_block_ends_lets_go_and_works_again(
    block: str,
    fault: str,
    record_property: Callable[[str, object], None],
    pytestconfig: pytest.Config,
) -> None:
    """Source: manual chapter 1, 5; chapter 5, 2 and 3."""
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
