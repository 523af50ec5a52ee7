"""Commands assign values to single elements of points and shifts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rcx_harness.robot import Point
from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, ready

PULSES, MM, SHIFT = 0x0240, 0x0241, 0x0245
DATA = (10, 20, 30, 40, 50, 60)
POINT = Point(DATA)
MM_POINT = Point(DATA, mm=True, hand=2, arm1=1, arm2=-1)


def _but(place: int, value: int, data: tuple[int, ...]) -> tuple[int, ...]:
    """Return a copy of the data with another value at one index."""
    return (*data[:place], value, *data[place + 1 :])


@pytest.mark.parametrize(("code", "point"), [(PULSES, POINT), (MM, MM_POINT)])
@pytest.mark.parametrize("place", range(6))
def test_the_value_goes_to_the_designated_data_alone(code: int, point: Point, place: int) -> None:
    """Bit 0 selects data 1, bit 5 selects data 6. Hand system and arm rotation do not change.

    Source: remote command guide 4.4.4
    """
    for value in (1000, -(2**31), 2**31 - 1):
        master = ready(points={1: point, 2: point})
        assert master.execute(code, 0, 1, 1 << place, *long_words(value)) == NORMAL_END
        assert master.robot.points == {1: replace(point, data=_but(place, value, DATA)), 2: point}


@pytest.mark.parametrize(("code", "point"), [(PULSES, MM_POINT), (MM, POINT)])
def test_the_input_format_must_be_that_of_the_point(code: int, point: Point) -> None:
    """Rule: point-units. Source: remote command guide 4.4.4, note."""
    master = ready(points={1: point}, point_unit_alarm="6.1")
    assert master.execute(code, 0, 1, 1, 5) == abnormal_end("6.1")
    assert master.robot.points == {1: point}


def test_a_point_without_data_has_no_elements() -> None:
    """Source: remote command guide 4.4.4."""
    master = ready(undefined_point_alarm="6.5")
    assert master.execute(PULSES, 0, 1, 1, 5) == abnormal_end("6.5")
    assert master.execute(MM, 0, 1, 1, 5) == abnormal_end("6.5")
    assert not master.robot.points


@pytest.mark.parametrize("place", range(4))
def test_the_value_goes_to_the_designated_data_of_a_shift(place: int) -> None:
    """Bit 0 selects data 1, bit 3 selects data 4. Source: remote command guide 4.4.4."""
    for value in (1000, -(2**31), 2**31 - 1):
        master = ready(shifts={1: (10, 20, 30, 40), 2: (1, 2, 3, 4)})
        assert master.execute(SHIFT, 0, 1, 1 << place, *long_words(value)) == NORMAL_END
        expected = _but(place, value, (10, 20, 30, 40))
        assert master.robot.machine.memory.shifts == {1: expected, 2: (1, 2, 3, 4)}


def test_a_shift_that_was_never_defined_has_zeros_beside_the_value() -> None:
    """The other elements become 0. With another setting the command ends in an alarm.

    Rule: undefined-data.
    Source: remote command guide 4.4.4.
    """
    master = ready()
    assert master.execute(SHIFT, 0, 39, 2, 0x03E8) == NORMAL_END
    assert master.robot.machine.memory.shifts == {39: (0, 1000, 0, 0)}
    master = ready(undefined_data_alarm="6.5")
    assert master.execute(SHIFT, 0, 39, 2, 0x03E8) == abnormal_end("6.5")


@pytest.mark.parametrize("code", [PULSES, MM, SHIFT])
def test_several_data_numbers_get_the_value_and_a_command_without_one_is_refused(code: int) -> None:
    """With several data numbers, each gets the value. A setting can require exactly one number.

    Rule: several-elements.
    Source: remote command guide 4.4.4, tt
    """
    point = POINT if code == PULSES else MM_POINT
    shifts = {1: (10, 20, 30, 40)}
    master = ready(points={1: point}, shifts=shifts, several_elements=False)
    assert master.execute(code, 0, 1, 0b1001, 7) == abnormal_end("4.2")
    assert master.execute(code, 0, 1, 0b0000, 7) == abnormal_end("4.2")
    assert (master.robot.points[1], master.robot.machine.memory.shifts) == (point, shifts)
    master = ready(points={1: point}, shifts=shifts)
    assert master.execute(code, 0, 1, 0b0000, 7) == abnormal_end("4.2")
    assert master.execute(code, 0, 1, 0b1001, 7) == NORMAL_END
    changed = master.robot.points[1].data, master.robot.machine.memory.shifts[1]
    assert changed == (
        (DATA, (7, 20, 30, 7)) if code == SHIFT else ((7, 20, 30, 7, 50, 60), shifts[1])
    )
