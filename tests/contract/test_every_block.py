"""Every block keeps the rules of its pins in every scan, for all Execute patterns and answers.

Source: design of the library, 2 and 3; manual chapter 5, 3, caution; guide chapters 1 and 2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from contract_bench import BLOCKS, ContractBench, cases
from contract_cases import Case, one_of_each_kind
from fault_cell import CaseFailure, library

_MOST_SHOWN = 3


def test_there_are_more_than_ten_thousand_cases() -> None:
    assert sum(len(cases(block)) for block in BLOCKS) > 10_000


def test_no_case_occurs_twice() -> None:
    for block in ("FB_ReadPoint", "FB_ServoOn", "FB_PowerUp", "FB_Jog", "FB_Status"):
        told = [str(case) for case in cases(block)]
        assert len(set(told)) == len(told), block


def test_every_command_block_and_every_sequence_is_tested() -> None:
    """The contract is tested for all blocks with Execute or Enable in the library's folders."""
    assert {*BLOCKS} == {*library().edge, *library().level}
    assert len(BLOCKS) > 100


@pytest.mark.parametrize("block", BLOCKS)
def test_the_contract_holds_in_one_case_of_each_kind(block: str) -> None:
    """The contract holds in a small set of cases.

    Each loss, each stop, each answer and each missing answer occurs once for each block.
    """
    _run(block, one_of_each_kind(cases(block)))


@pytest.mark.exhaustive
@pytest.mark.parametrize("block", BLOCKS)
def test_the_contract_holds(block: str, record_property: Callable[[str, object], None]) -> None:
    """The block keeps the contract and the rules of the wire in every scan of all its cases."""
    every = cases(block)
    record_property("scans", _run(block, every))
    record_property("instances", len(every))


def _run(block: str, every: Sequence[Case]) -> int:
    """Run the given cases of a block, and return the number of checked scans."""
    bench = ContractBench(block)
    failures = []
    for case in every:
        try:
            bench.run(case)
        except CaseFailure as failure:
            failures.append(str(failure))
    assert not failures, f"{len(failures)} of {len(every)} cases:\n" + "\n".join(
        failures[:_MOST_SHOWN]
    )
    return bench.scans
