"""A bench for FB_ScaraForward and FB_ScaraInverse with the arm of a YK400XE.

The arms have 225 and 175 mm (data sheet). Each axis has 1000 pulses per unit here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import pytest

from alone import Alone
from both_engines import ENGINES

UNIT = 1000
_ARM: dict[str, Any] = {"Arm1": 225.0, "Arm2": 175.0, "PulsesPerUnit": [float(UNIT)] * 6}

ON_BOTH = pytest.mark.parametrize("engine", ENGINES)


@cache
def scara(name: str, engine: str) -> Alone:
    """Return a bench for one of the two SCARA blocks. All tests share it."""
    return Alone(f"FB_Scara{name}", {}, engine)


def with_arm(block: Alone, arm: Mapping[str, Any]) -> None:
    """Restart the block with these arm data."""
    block.restart()
    for field, value in {**_ARM, **arm}.items():
        block[f"Block.Arm.{field}"] = value


def forward(
    joints: Sequence[float], engine: str = "auto", **arm: Any
) -> tuple[list[float], str, int]:
    """Return position, hand system and ErrorID that FB_ScaraForward calculates for these joints."""
    block = scara("Forward", engine)
    with_arm(block, arm)
    pulses = [round(UNIT * joint) for joint in joints]
    block["Block.Pulses"] = [*pulses, *[0] * (6 - len(pulses))]
    block.scan(0)
    assert block["Block.Valid"] is (not block["Block.Error"])
    assert block["Block.Error"] is (block["Block.ErrorID"] != 0)
    return block["Block.PositionMm"], block["Block.HandSystem"], block["Block.ErrorID"]


def inverse(
    position: Sequence[float], hand: str, engine: str = "auto", **arm: Any
) -> tuple[list[float], int]:
    """Return joints (degrees, mm) and ErrorID that FB_ScaraInverse calculates for this position."""
    block = scara("Inverse", engine)
    with_arm(block, arm)
    block["Block.PositionMm"] = [*position, *[0.0] * (6 - len(position))]
    block["Block.HandSystem"] = hand
    block.scan(0)
    assert block["Block.Valid"] is (not block["Block.Error"])
    assert block["Block.Error"] is (block["Block.ErrorID"] != 0)
    return [one / UNIT for one in block["Block.Pulses"]], block["Block.ErrorID"]
