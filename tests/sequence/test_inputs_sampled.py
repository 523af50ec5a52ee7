"""The sequence blocks sample their inputs only on the rising edge of Execute."""

from __future__ import annotations

from datetime import timedelta

import pytest

from plc_bench import PlcBench
from sequence_bench import pins, sequences
from structured_text.engines.base import Value

#: Maps each block to controller outputs with which it stays Busy.
_BLOCKS = {
    "AlarmReset": ["SO03"],
    "AutoStart": ["SO02", "SO14"],
    "EmergencyStop": ["SO02"],
    "Origin": ["SO02"],
    "ProgramReset": ["SO02"],
    "ProgramStop": ["SO02", "SO13"],
    "ServoOn": [],
}
every_block = pytest.mark.parametrize(
    "block", _BLOCKS, ids=lambda name: f"FB_{'ReturnToOrigin' if name == 'Origin' else name}"
)


def _plc(block: str) -> PlcBench:
    plc = PlcBench() if block == "AlarmReset" else sequences()
    plc.power_up()
    plc.outputs(scans=1, **dict.fromkeys(_BLOCKS[block], True))
    return plc


def _held(plc: PlcBench, block: str) -> list[Value]:
    names = ["Job.Longest", *(["Chosen"] if block == "Origin" else [])]
    return [plc[f"{block}.{name}"] for name in names]


def _change(plc: PlcBench, block: str) -> None:
    plc[f"{block}.Timeout"] = timedelta(seconds=7)
    if block == "Origin":
        plc["Origin.Axes"] = "ORIGIN_ABSOLUTE"


@every_block
def test_inputs_that_change_after_the_end_have_no_effect(block: str) -> None:
    """Source: design of the library, 3: inputs are sampled on the rising edge."""
    plc = _plc(block)
    plc["Connected"] = False
    plc.change(f"{block}.Execute", to=True, scans=2)
    assert pins(plc, block) == "Error", "there is no link"
    before = _held(plc, block)
    _change(plc, block)
    plc.scan()
    assert _held(plc, block) == before


@every_block
def test_an_edge_while_the_block_is_busy_has_no_effect(block: str) -> None:
    """Source: design of the library, 3: a rising edge while busy is ignored."""
    plc = _plc(block)
    plc.change(f"{block}.Execute", to=True)
    before = _held(plc, block)
    plc.change(f"{block}.Execute", to=False)
    _change(plc, block)
    plc.change(f"{block}.Execute", to=True)
    assert pins(plc, block).startswith("Busy")
    assert _held(plc, block) == before
