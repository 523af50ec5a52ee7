"""FB_ScaraForward and FB_ScaraInverse refuse values beyond limits, and accept the limits."""

from __future__ import annotations

import math
from typing import Any

import pytest

from for_each import for_each
from scara_bench import UNIT, forward, inverse, scara

_NAN = math.nan


@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize("sign", [-1, 1])
def test_pulses_beyond_a_thousand_million_are_refused(k: int, sign: int) -> None:
    """Pulses beyond 1,000,000,000 are refused: 16#8047 for axes, 16#8061 for zero positions.

    The difference of two legal numbers always fits into a double word.

    Source: comments of Pulses and Zero; docs/reference/errors.md, 16#8047 and 16#8061
    """
    last, per = 1_000_000_000, [1_000_000.0] * 6
    zero = [0] * 6
    for size, error in ((last, 0), (last + 1, 0x8061), (2**31 - 1, 0x8061)):
        zero[k] = sign * size
        pulses = [0.0] * 4
        pulses[k] = sign * last / UNIT
        assert forward(pulses, Zero=zero, PulsesPerUnit=per)[2] == error
        at = [0.0, 300.0, 0.0, 90.0]
        found = inverse(at, "HAND_RIGHT", Zero=zero)[1]
        assert found == error or (not error and found in (0, 0x8047))
    zero[k] = 0
    for size, error in ((last, 0), (last + 1, 0x8047), (2**31 - 1, 0x8047)):
        pulses[k] = sign * size / UNIT
        assert forward(pulses, PulsesPerUnit=per)[2] == error
    zero[k] = -last
    pulses[k] = 2_000_000_000 / UNIT
    assert forward(pulses, PulsesPerUnit=per, Zero=zero)[2] == 0x8047


@pytest.mark.parametrize(
    ("pulses", "arm"),
    [
        ((0, 4100, 0, 4100), {}),
        ((0, 0, 0, 0), {"Base": [8000.0, 0.0, 0.0, 0.0], "Shift": [-8000.0, 0.0, 0.0, 0.0]}),
        ((0, 0, 0, 0), {"Base": [0.0, 7800.0, 0.0, 0.0]}),
        ((0, 0, 0, 0), {"Base": [0.0, 0.0, 8000.0, 0.0], "HandData3": 8000.0}),
        ((0, 0, 0, 0), {"Shift": [0.0, 0.0, 0.0, -8150.0]}),
    ],
)
def test_a_position_beyond_8192_millimetres_or_degrees_is_too_large(
    pulses: tuple[float, ...], arm: dict[str, Any]
) -> None:
    """A position beyond 8192 mm or degrees is refused: a REAL cannot hold it to 0.001 mm.

    Source: docs/reference/errors.md, 16#8047
    """
    assert forward(pulses, **arm) == ([0] * 6, "HAND_NONE", 0x8047)


_LAST = 8191.9985
_WRONG: list[tuple[dict[str, Any], bool]] = [
    ({"Arm1": 0.99}, True),
    ({"Arm1": 1.0}, False),
    ({"Arm1": _NAN}, True),
    ({"Arm1": 8192.5}, True),
    ({"Arm2": -175.0}, True),
    ({"Arm2": 8192.5}, True),
    ({"HandData2": -174.0}, False),
    ({"HandData2": -174.01}, True),
    ({"HandMount": "HAND_ON_R_AXIS", "HandData2": -174.01}, False),
    ({"HandData1Integer": 360_000}, False),
    ({"HandData1Integer": 360_001}, True),
    ({"HandData1Integer": -360_001}, True),
    ({"HandMount": "HAND_ON_R_AXIS", "HandData1Integer": 360_001}, False),
    *[
        ({"HandMount": "HAND_ON_R_AXIS", f"HandData{k}": sign * size}, wrong)
        for k in (1, 2, 3)
        for sign in (-1, 1)
        for size, wrong in ((_LAST, False), (8192.5, True))
    ],
    *[
        ({field: [0.0] * k + [value] + [0.0] * (3 - k)}, wrong)
        for field in ("Base", "Shift")
        for k in range(4)
        for value, wrong in ((_LAST, field == "Base" and k == 3), (8192.5, True), (-8192.5, True))
    ],
    *[({"Base": [0.0, 0.0, 0.0, turn]}, abs(turn) > 180) for turn in (180.0, 180.1, -180.1)],
    *[
        ({"PulsesPerUnit": [1000.0] * k + [value] + [1000.0] * (5 - k)}, wrong)
        for k in range(6)
        for value, wrong in (
            *((0.0, k < 4), (0.09, k < 4), (1e6 + 1, k < 4), (_NAN, k < 4)),
            *((0.1, False), (-0.1, False), (1e6, False)),
        )
    ],
]


@for_each("name", ["Forward", "Inverse"])
@for_each("arm, wrong", _WRONG)
def test_an_impossible_arm_is_refused(name: str, arm: dict[str, Any], wrong: bool) -> None:
    """Axes 5 and 6 are ignored. Source: comments of RCX_SCARA; docs/how-to/position.md."""
    if name == "Forward":
        position, hand, error = forward([0, 1, 0, 0], **arm)
        if wrong:
            assert (position, hand) == ([0] * 6, "HAND_NONE")
    else:
        joints, error = inverse([0, 300, 0, 0], "HAND_RIGHT", **arm)
        if wrong:
            assert joints == [0] * 6
    assert (error == 0x8061) is wrong


@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize("sign", [-1, 1])
def test_pulses_beyond_8192_degrees_or_millimetres_are_too_many(k: int, sign: int) -> None:
    """Pulses that mean more than 8192 degrees or mm are refused.

    With a shift of 90 degrees, R is the sum of the turns of the axes.
    """
    own: dict[str, Any] = {"Shift": [0.0, 0.0, 0.0, 90.0]}
    for size, error in ((8191.0, 0), (8192.5, 0x8047)):
        found = forward([0.0] * k + [sign * size] + [0.0] * (3 - k), **own)
        assert found[2] == error
        assert (found[0] == [0] * 6) is bool(error)


@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize("value", [8192.5, -8192.5, _NAN, math.inf])
def test_a_position_that_is_none_is_refused(k: int, value: float) -> None:
    place = [0.0, 300.0, 0.0, 0.0]
    place[k] = value
    assert inverse(place, "HAND_RIGHT") == ([0] * 6, 0x8047)


@pytest.mark.parametrize("k", [0, 1, 2, 3])
def test_a_result_beyond_a_thousand_million_pulses_is_refused(k: int) -> None:
    """If pulses and zero position together exceed 1,000,000,000, the result is refused.

    The test has 1,000,000 pulses per unit.
    """
    per = [1000.0] * 6
    per[k] = 1e6
    zero = [0] * 6
    zero[k] = -1_000_000_000 if k in (1, 3) else 1_000_000_000
    assert inverse([0, 300, 5, 0], "HAND_LEFT", PulsesPerUnit=per, Zero=zero) == ([0] * 6, 0x8047)
    assert inverse([0, 300, 5, 0], "HAND_LEFT", PulsesPerUnit=per)[1] == 0


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize(("turned", "error"), [(990, 0), (1010, 0x8047), (8000, 0x8047)])
def test_an_axis_that_would_turn_beyond_a_thousand_million_pulses_is_refused(
    sign: int, turned: int, error: int
) -> None:
    """An axis that would need more than 1,000,000,000 pulses is refused.

    With 1,000,000 pulses per degree, up to 8,000,000,000 pulses would be needed, more than a double
    word holds.

    Source: docs/reference/errors.md, 16#8047
    """
    per = [1000.0, 1000.0, 1000.0, 1e6, 0.0, 0.0]
    place = [-175.0, 225.0, 0.0, 180.0 + sign * turned]
    joints, found = inverse(place, "HAND_RIGHT", PulsesPerUnit=per)
    assert found == error
    assert joints[3] == pytest.approx(0 if error else sign * turned * 1000, abs=10)


def test_an_illegal_arm_is_reported_before_too_many_pulses() -> None:
    """Source: docs/reference/errors.md, 16#8061 and 16#8047."""
    zero = [1_000_000_001, 0, 0, 0, 0, 0]
    pulses = [0.0, (2**31 - 1) / UNIT, 0.0, 0.0]
    assert forward(pulses, Zero=zero, PulsesPerUnit=[1e6] * 6)[2] == 0x8061


def test_the_next_call_after_an_error_has_no_error() -> None:
    """The block calculates in each call, so an error ends with its reason.

    Source: docs/reference/errors.md, 16#8061
    """
    assert (
        inverse([0.0, 300.0, 0.0, 90.0], "HAND_RIGHT", Zero=[1_000_000_001, *[0] * 5])[1] == 0x8061
    )
    block = scara("Inverse", "auto")
    block["Block.Arm.Zero"] = [0] * 6
    block.scan(0)
    assert (block["Block.Valid"], block["Block.ErrorID"]) == (True, 0)
