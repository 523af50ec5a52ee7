"""FB_PickPlace refuses illegal inputs before any command, and keeps its state."""

from __future__ import annotations

import math
from typing import Any

import pytest

from both_engines import ENGINES
from pick_bench import picking
from tiers import sampled

_PULSES = 8_388_607.0
_ARCH = {"ArchAxis": 3, "ArchUnit": "UNIT_PULSES"}
_MM = {"ArchAxis": 3, "ArchUnit": "UNIT_MM"}
_ROW = {"SourcePallet": 0, "TargetPallet": 39}


def _numbers(low: int, high: int, *names: str) -> list[tuple[dict[str, Any], int]]:
    """Return values at and beyond the limits for each of these pins, with the expected ErrorID."""
    return [
        ({name: value}, 0x8044 * (not low <= value <= high))
        for name in names
        for value in (low, high, low - 1, high + 1)
    ]


#: Ports of DO are 2 to 7, 10 to 17 and 20 to 27. DI also has 0 and 1. Bits are 0 to 7.
_PORTS = {2, *range(20, 28), 77, *range(100, 108), 177, 200, 277}
_NO_PORTS = {-1, 8, 28, 29, 78, 80, 87, 90, 97, 99, 178, 180, 197, 278, 280, 300}
_OUTPUTS = [1, 2, 7, 10, 17]
_CASES: list[tuple[dict[str, Any], int]] = [
    *(({"RobotNumber": one}, 0x8040 * (one not in range(5))) for one in (-1, 0, 4, 5)),
    *(({"ArchAxis": one}, 0x8041 * (one not in range(7))) for one in (-1, 0, 6, 7)),
    *(
        ({name: one}, 0x8042 * (one not in (0.0, 1.0, 100.0)))
        for name in ("Speed", "Shifts__ApproachSpeed")
        for one in (0.0, 0.5, 1.0, 100.0, 100.5, -1.0, math.nan)
    ),
    *_numbers(0, 29_999, "SourcePoint", "TargetPoint"),
    *_numbers(-1, 39, "SourcePallet", "TargetPallet"),
    *(
        ({**_ROW, name: one}, 0x8044 * (one < 1))
        for name in ("SourcePosition", "TargetPosition")
        for one in (-1, 0, 1, 32_767)
    ),
    *(({name: -1}, 0) for name in ("SourcePosition", "TargetPosition")),
    *(({**_ROW, name: -1}, 0) for name in ("SourcePoint", "TargetPoint")),
    ({**_ROW, "Gripper__PartInput": 8}, 0x8044),
    *_numbers(
        0, 39, *(f"Shifts__{one}" for one in ("Source", "SourceAbove", "Target", "TargetAbove"))
    ),
    *_numbers(0, 39, "Shifts__Afterwards"),
    *(
        ({f"Gripper__{name}": one}, 0x8044 * (one in _NO_PORTS))
        for name in ("ClosedInput", "OpenedInput", "PartInput")
        for one in sorted(_PORTS | _NO_PORTS | {*_OUTPUTS} - {10, 17})
    ),
    *(
        ({"Gripper__OpenOutput": 30, f"Gripper__{name}": one}, 0x8044 * (one in _NO_PORTS))
        for name in ("CloseOutput", "OpenOutput")
        for one in sorted((_PORTS | _NO_PORTS) - {2, 20})
    ),
    *(
        ({f"Gripper__{name}": one}, 0x8044)
        for name in ("CloseOutput", "OpenOutput")
        for one in _OUTPUTS
    ),
    ({"Gripper__CloseOutput": 20}, 0),
    ({"Gripper__OpenOutput": 20}, 0x8044),
    ({"Gripper__OpenOutput": 21, "Gripper__CloseOutput": 21}, 0x8044),
    ({"Gripper__OpenOutput": 20, "Gripper__CloseOutput": 21}, 0),
    *(
        ({**arch, name: sign * size}, 0x8047 * wrong)
        for arch, last, more in ((_ARCH, _PULSES, _PULSES + 1), (_MM, 8191.999, 8192.0))
        for name in ("ArchPosition", "ArchDistance")
        for sign in (-1, 1)
        for size, wrong in ((last, False), (more, True), (math.nan, True))
    ),
    ({"ArchPosition": math.nan, "ArchDistance": 1e9}, 0),
]


@pytest.mark.parametrize(("pins", "error"), sampled(_CASES, 3), ids=str)
def test_an_illegal_input_is_refused_at_once(pins: dict[str, Any], error: int) -> None:
    """Source: remote command guide 4.2.1, 4.2.5, 4.2.17, 4.5.1; design of the library, 2."""
    plc = picking(**pins)
    plc.start()
    plc.scan(4)
    assert plc.end[:2] == (("Error", error) if error else ("Busy", 0))
    assert bool(plc.told) is not bool(error)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_refused_start_keeps_the_state(engine: str) -> None:
    """A refused start does not change the state: with a part in the hand, the block continues.

    HandEmpty has no effect here.

    Source: head of FB_PickPlace
    """
    plc = picking(engine)
    plc.refuses = "PTP 20 at 50"
    plc.work()
    assert plc.end == ("Error", 0x8020, "PICK_TO_TARGET", True)
    before = list(plc.told)
    plc["Pick.TargetPoint"] = 30_000
    for empty in (False, True):
        plc["Pick.HandEmpty"] = empty
        assert plc.work() == []
        assert plc.end == ("Error", 0x8044, "PICK_TO_TARGET", True)
    plc["Pick.TargetPoint"], plc["Pick.HandEmpty"] = 20, False
    assert plc.work() == ["DO2?", "PTP 20 at 50", "DO(20) OFF"]
    assert plc.told == [*before, "DO2?", "PTP 20 at 50", "DO(20) OFF"]
