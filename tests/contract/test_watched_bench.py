"""PlcBench, which simulates no robot, checks the contract of the blocks in every test."""

from __future__ import annotations

import pytest

import plc_bench
from plc_bench import PlcBench
from rcx_tools.evidence.broken import broken_library


def _servo_on(plc: PlcBench) -> None:
    """Run FB_ServoOn to its end, then reset Execute."""
    plc.power_up()
    plc["ServoOn.Execute"] = True
    plc.scan(15)
    plc.outputs(SO02=True)
    plc.scan(2)
    assert plc["ServoOn.Done"]
    plc["ServoOn.Execute"] = False
    plc.scan(3)


def _bench() -> PlcBench:
    return PlcBench(program=plc_bench.ROOT / "tests/data/library/Sequences.st", engine="builtin")


def test_a_correct_block_passes() -> None:
    _servo_on(_bench())


@pytest.mark.exhaustive
def test_a_broken_block_is_found_in_every_test_with_a_bench(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = "ELSIF NOT Execute OR NOT WasExecute THEN"
    with broken_library("core/FB_RcxJob.st", right, "ELSIF Execute AND NOT WasExecute THEN") as lib:
        monkeypatch.setattr(plc_bench, "LIBRARY", sorted(lib.rglob("*.st")))
        plc = _bench()
    with pytest.raises(AssertionError, match="Done is shown for more than one scan"):
        _servo_on(plc)
