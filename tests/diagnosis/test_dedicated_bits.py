"""FB_DedicatedBits gives the dedicated bits as words, with the same bit numbers as in the areas."""

from __future__ import annotations

from functools import cache

import pytest

from alone import Alone
from head_rules import bits_of
from rcx_harness import spec


@cache
def _block() -> Alone:
    return Alone("FB_DedicatedBits", {"Robot": "RCX_REF"})


@pytest.mark.parametrize(
    ("direction", "signal"),
    [
        *(("SO", signal) for signal in spec.signals().output),
        *(("SI", signal) for signal in spec.signals().input),
    ],
    ids=lambda part: getattr(part, "short", str(part)),
)
def test_each_bit_has_the_same_position_as_in_the_area(direction: str, signal: spec.Signal) -> None:
    """Each bit has its number in the area. Source: manual chapter 5, 1, bytes 32 and 33."""
    block = _block()
    block.restart()
    block[f"Robot.{direction}.{signal.name}"] = True
    block.scan(0)
    expected = bits_of({signal.name: True})
    words = {"SO": block["Block.Outputs"], "SI": block["Block.Inputs"]}
    assert words.pop(direction) == expected
    assert [*words.values()] == [0]
