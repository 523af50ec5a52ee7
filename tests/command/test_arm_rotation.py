"""Blocks read the arm rotation from four bits, of which the manual lists only three patterns."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from command_bench import bench_of

#: Patterns in the tables of the guide, and their values. Section 4.3.1 says that all others mean 0.
_LISTED = {0b0000: 0, 0b0001: 1, 0b1111: -1}


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", ["FB_ReadPoint", "FB_ReadPositionMm"])
def test_every_answer_gives_an_arm_rotation_of_minus_one_to_one(name: str, engine: str) -> None:
    """All patterns of bits 6 to 3 (arm 1) and bits 10 to 7 (arm 2) of m+6 give -1, 0 or 1.

    Source: remote command guide 4.3.1 (reference) and 4.7.4 (millimetres), tables of xr and yr.
    """
    bench = bench_of(name, engine)
    for first in range(16):
        second = (first + 7) % 16
        flags = first << 3 | second << 7
        bench.send({})
        bench.end(response=[0, 0, flags])
        shown = bench.pin("Arm1"), bench.pin("Arm2")
        assert shown == (_LISTED.get(first, 0), _LISTED.get(second, 0)), f"m+6 = 16#{flags:04X}"
        bench.finish()
