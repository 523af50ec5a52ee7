"""Parameters can be assigned and read, for each robot and each axis."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end
from stored_data import long_words, ready

WRITE, READ = 0x0220, 0x0224
#: The guide's table of parameters: the number of each, and the limits if it belongs to an axis.
AXIS_PARAMETERS = {
    257: (1, 100),
    258: (1, 100),
    259: (1, 16384),
    260: (1, 9999999),
    264: (1, 9999999),
    265: (1, 9999999),
    266: (-1000, 1000),
    267: (1, 32767),
    268: (0, 1),
    269: (0, 100),
    270: (1, 100),
}
WEIGHT, WEIGHTG, AXWGHT = 1, 2, 262
EVERY = [(WEIGHT, 0), (WEIGHTG, 0), (AXWGHT, 1), *((number, 1) for number in AXIS_PARAMETERS)]
FIVE_AXES = (Axis(), Axis(), Axis(robot=2), Axis(robot=2), Axis())


def _write(master: Master, number: int, axes: int, value: int, robot: int = 0) -> tuple[int, ...]:
    return master.execute(robot << 12 | WRITE, 0, number, axes, *long_words(value))


def _read(master: Master, number: int, axes: int, robot: int = 0) -> tuple[int, ...]:
    """Check the other response words, and return m+8 and m+10."""
    answer = master.execute(robot << 12 | READ, 0, number, axes)
    assert answer[:4] == (0x0200, 0, number, axes)
    assert answer[6:] == (0,) * 10
    return answer[4:6]


@pytest.mark.parametrize(("number", "limits"), AXIS_PARAMETERS.items())
def test_an_axis_parameter_takes_its_whole_range(number: int, limits: tuple[int, int]) -> None:
    """Source: remote command guide 4.4.2."""
    master = ready()
    for value in limits:
        assert _write(master, number, 0b1000, value) == NORMAL_END
        assert _read(master, number, 0b1000) == long_words(value)
    for value in (limits[0] - 1, limits[1] + 1, -(2**31), 2**31 - 1):
        assert _write(master, number, 0b1000, value) == abnormal_end("4.2")
    assert _read(master, number, 0b1000) == long_words(limits[1])


@pytest.mark.parametrize(
    ("number", "axes", "limit"), [(WEIGHT, 0, 30), (WEIGHTG, 0, 30_000), (AXWGHT, 1, 30)]
)
def test_a_payload_is_0_to_the_maximum_payload(number: int, axes: int, limit: int) -> None:
    """The maximum payload is 30 kg here. Rule: payload. Source: remote command guide 4.4.2."""
    master = ready(max_payload=30)
    for value in (0, limit):
        assert _write(master, number, axes, value) == NORMAL_END
        assert _read(master, number, axes) == long_words(value)
    for value in (-1, limit + 1, 2**31 - 1):
        assert _write(master, number, axes, value) == abnormal_end("4.2")
    assert _read(master, number, axes) == long_words(limit)


def test_the_payload_in_kg_and_in_g_is_the_same_value() -> None:
    """A payload of 7 kg is read as 7000 g. A payload of 7999 g is read as 7 kg.

    Rule: payload.
    Source: remote command guide 4.4.2.
    """
    master = ready()
    _write(master, WEIGHT, 0, 7)
    assert _read(master, WEIGHTG, 0) == long_words(7000)
    _write(master, WEIGHTG, 0, 7999)
    assert _read(master, WEIGHT, 0) == long_words(7)
    assert _read(master, AXWGHT, 1) == long_words(0)


def test_parameters_have_the_values_of_a_delivered_controller() -> None:
    """Parameters that nothing has set have the values of a delivered controller.

    Rule: parameter-defaults.
    Source: remote command guide 4.4.2.
    """
    expected = {1: 0, 2: 0, 257: 100, 258: 100, 259: 80, 260: 2000, 262: 0, 264: 2000, 265: 2000}
    expected |= {266: 100, 267: 1000, 268: 0, 269: 0, 270: 100}
    master = ready()
    for number, value in expected.items():
        assert _read(master, number, 0 if number < 257 else 2) == long_words(value)


@pytest.mark.parametrize("number", AXIS_PARAMETERS)
def test_each_axis_of_each_robot_has_its_own_value(number: int) -> None:
    """Axes 1, 2 and 5 of the controller belong to robot 1, axes 3 and 4 to robot 2.

    Robot 0 means robot 1.

    Source: remote command guide 4.4.2
    """
    master = ready(axes=FIVE_AXES)
    places = [(1, 0b001), (1, 0b010), (1, 0b100), (2, 0b01), (2, 0b10)]
    before = _read(master, number, 1)
    high = AXIS_PARAMETERS[number][1]
    other = high if before != long_words(high) else high - 1
    for robot, axes in places:
        assert _read(master, number, axes, robot) == before
        assert _write(master, number, axes, other, robot) == NORMAL_END
        values = [_read(master, number, a, r) for r, a in places]
        assert values.count(long_words(other)) == places.index((robot, axes)) + 1
    assert _read(master, number, 0b100, 0) == long_words(other)


def test_each_robot_has_its_own_payload() -> None:
    """Source: remote command guide 4.4.2."""
    master = ready(axes=FIVE_AXES)
    _write(master, WEIGHT, 0, 3, robot=1)
    _write(master, WEIGHT, 0, 4, robot=2)
    assert _read(master, WEIGHT, 0, robot=0) == long_words(3)
    assert _read(master, WEIGHT, 0, robot=2) == long_words(4)


@pytest.mark.parametrize(("number", "axes"), EVERY)
@pytest.mark.parametrize("code", [WRITE, READ])
def test_a_parameter_has_one_axis_or_none(code: int, number: int, axes: int) -> None:
    """Rule: parameter-axis. Source: remote command guide 4.4.2."""
    master = ready()
    value = (1, 0) if code == WRITE else ()
    for wrong in (0b11, 0b101, 0x40, 0x100, 0x8000, 1 - axes):
        assert master.execute(code, 0, number, wrong, *value) == abnormal_end("4.2")
    assert master.execute(code, 0, number, axes, *value)[0] == 0x0200


def test_a_single_number_in_a_robot_file_presets_all_axes_or_robots() -> None:
    """The controller has six axes, and robot 4 has the last of them.

    Source: remote command guide 4.4.2.
    """
    axes = (*[Axis()] * 5, Axis(robot=4))
    master = ready(axes=axes, parameters={"ACCEL": 30, "WEIGHT": 7})
    assert [_read(master, 257, 1 << place)[0] for place in range(5)] == [30] * 5
    assert _read(master, 257, 1, robot=4)[0] == 30
    assert [_read(master, WEIGHT, 0, robot)[0] for robot in (1, 4)] == [7, 7]
    alone = ready(axes=(Axis(), Axis(robot=4)), parameters={"WEIGHT": 7})
    assert [_read(alone, WEIGHT, 0, robot)[0] for robot in (1, 4)] == [7, 7]
