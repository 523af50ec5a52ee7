"""A jog moves until the stop input goes OFF, in pulses, Cartesian or tool coordinates.

The default axis has 1000 pulses/mm, 1 000 000 pulses/s, 5 000 000 pulses/s^2 and soft limits of +-1
000 000. The tool of a SCARA robot (the default) does at most 1000 mm/s. At 20 % manual speed, axis
and tool limits both give 200 000 pulses/s: 4000 pulses in the first 40 ms, then 1000 pulses in 5
ms.
"""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Axis
from rcx_harness.robot.stored import Hand
from robot_master import Master, abnormal_end, servos_on

PULSES, CARTESIAN, TOOL = 0x0020, 0x0021, 0x0022
FRAMES = [PULSES, CARTESIAN, TOOL]
PULSE_OUTPUT, MM_OUTPUT = 0x4000, 0x8000
STOPPED = (0x4000, 0x000C, 0x0190)
SOFT_LIMIT = (0x4000, 2, 334)
MINUS = 0x0080


def _jogger(**config: Any) -> Master:
    return servos_on(**{"manual_speed": 20, **config})


def _jog_for(master: Master, ms: float, *words: int) -> tuple[int, ...]:
    """Jog until the stop input goes OFF after `ms`, and return words m to m+30."""
    master.send(*words)
    master.run(ms)
    assert master.status == 0x0100
    master.turn_and_wait("SI06", False, 5)
    return master.words


@pytest.mark.parametrize("code", FRAMES)
@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize(("direction", "sign"), [(0, 1), (MINUS, -1)])
def test_a_jog_moves_one_axis(code: int, place: int, direction: int, sign: int) -> None:
    """Without a position output, m+8 to m+30 are 0.

    Rule: jog-frames.
    Source: remote command guide 4.2.6, tt and d
    """
    master = _jogger()
    assert _jog_for(master, 100, code, 0, 1 << place | direction) == abnormal_end("12.400")
    expected = [0, 0, 0, 0]
    expected[place] = sign * 16_000
    assert master.robot.positions == expected


@pytest.mark.parametrize("code", FRAMES)
def test_the_movement_speed_is_determined_by_the_manual_movement_speed(code: int) -> None:
    """At 50 % manual speed the axis does 2500 pulses in 5 ms (500 000/s) at any automatic speed.

    Rule: jog-speed.
    Source: remote command guide 4.2.6
    """
    master = _jogger(auto_speed=10, program_speed=10)
    master.execute(0x0038, 0, 50)
    master.send(code, 0, 0x0001)
    master.run(150)
    before = master.robot.positions[0]
    master.run(5)
    assert master.robot.positions[0] - before == 2_500


def test_a_jog_of_the_tool_runs_at_the_manual_speed_in_percent_of_its_limit() -> None:
    """At 20 % of 750 mm/s the tool moves 0.75 mm in 5 ms. Rule: path-speed."""
    master = _jogger(scara_robots=())
    master.send(CARTESIAN, 0, 0x0002)
    master.run(150)
    before = master.robot.positions[1]
    master.run(5)
    assert master.robot.positions[1] - before == 750


@pytest.mark.parametrize("code", FRAMES)
@pytest.mark.parametrize(("direction", "limit"), [(0, 300_000), (MINUS, -200_000)])
def test_a_jog_ends_at_the_soft_limit_with_2_334(code: int, direction: int, limit: int) -> None:
    """The axis brakes so that it stops at the limit. The alarm answer contains no position.

    Rule: jog-limit.
    Source: remote command guide 4.2.6, abnormal end (other cases)
    """
    master = _jogger(axes=(Axis(), Axis(soft_low=-200_000, soft_high=300_000)))
    answer = master.execute(code, PULSE_OUTPUT, 0x0002 | direction)
    assert answer == abnormal_end("2.334")
    assert master.robot.positions == [0, limit]
    assert master.on("SO02")


@pytest.mark.parametrize("code", FRAMES)
def test_a_jog_to_the_soft_limit_may_end_normally(code: int) -> None:
    """With the key jog_limit, a jog to the soft limit ends normally.

    Rule: jog-limit.
    Source: remote command guide 4.2.6, normal end.
    """
    master = _jogger(axes=(Axis(soft_high=0x12345), Axis(start=-1)), jog_limit="normal")
    answer = master.execute(code, PULSE_OUTPUT, 0x0001)
    assert answer == (0x0200, 0, 0, 0, 0x2345, 0x0001, 0xFFFF, 0xFFFF, *(0,) * 8)


@pytest.mark.parametrize("code", FRAMES)
@pytest.mark.parametrize("start", [300_000, 300_001])
def test_an_axis_at_its_soft_limit_can_only_jog_back(code: int, start: int) -> None:
    """An axis at its soft limit or beyond it can only jog back.

    Rule: jog-limit, limits-on-the-way.
    """
    master = _jogger(axes=(Axis(start=start, soft_high=300_000),))
    assert master.execute(code, PULSE_OUTPUT, 0x0001) == abnormal_end("2.334")
    assert master.robot.positions == [start]
    assert _jog_for(master, 100, code, 0, 0x0001 | MINUS)[:3] == STOPPED
    assert master.robot.positions == [start - 16_000]


@pytest.mark.parametrize("code", FRAMES)
def test_a_jog_that_an_emergency_stop_ends_shows_no_position(code: int) -> None:
    """Source: remote command guide 4.2.6, abnormal end (other cases)."""
    master = _jogger()
    master.send(code, PULSE_OUTPUT, 0x0001)
    master.run(100)
    master.turn_and_wait("SI00", False, 5)
    assert master.words == abnormal_end("12.600")
    assert 0 < master.robot.positions[0] < 20_000


@pytest.mark.parametrize("code", FRAMES)
def test_after_the_stop_input_is_on_again_the_next_command_moves(code: int) -> None:
    """The servos stay ON, and there is no alarm to reset.

    Source: remote command guide 4.2.6
    """
    master = _jogger()
    _jog_for(master, 100, code, 0, 0x0001)
    master.send()
    master.turn_and_wait("SI06", True)
    assert master.on("SO02")
    assert not master.on("SO03")
    assert _jog_for(master, 100, code, 0, 0x0001 | MINUS)[:3] == STOPPED
    assert master.robot.positions == [0, 0, 0, 0]


@pytest.mark.parametrize("code", FRAMES)
def test_a_jog_whose_command_is_cleared_goes_on_until_the_stop_input_is_off(code: int) -> None:
    """Rule: jog-cleared."""
    master = _jogger()
    master.send(code, 0, 0x0001)
    master.run(100)
    master.send()
    master.run(500)
    assert master.status == 0x0100
    assert master.robot.positions[0] == 4_000 + 555 * 200
    master.turn_and_wait("SI06", False, 5)
    assert master.status == 0x0000
    stopped_at = list(master.robot.positions)
    master.run(100)
    assert master.robot.positions == stopped_at
    assert len(master.robot.violations) == 1


def _coordinates(shift: tuple[int, int, int, int], hand: Hand, start: int) -> Master:
    """Return a master with axis 4 at `start`, and with shift 1 and hand 1 selected."""
    axes = (Axis(), Axis(), Axis(), Axis(start=start))
    master = _jogger(axes=axes, shifts={1: shift}, hands={(1, 1): hand})
    master.execute(0x003B, 0, 1)
    master.execute(0x003C, 0, 1)
    return master


def test_a_cartesian_jog_moves_along_the_shifted_coordinates() -> None:
    """The shift turns the coordinates by 90 degrees, so their X is the Y of the axes.

    Rule: coordinates.
    Source: remote command guide 4.2.6, Cartesian coordinate system jog movement
    """
    master = _coordinates((5_000, 0, 0, 90_000), Hand(), 0)
    _jog_for(master, 100, CARTESIAN, 0, 0x0001)
    assert master.robot.positions == [0, 16_000, 0, 0]
    master.send()
    master.turn_and_wait("SI06", True)
    _jog_for(master, 100, PULSES, 0, 0x0001)
    assert master.robot.positions == [16_000, 16_000, 0, 0]


@pytest.mark.parametrize(
    ("on_r", "expected"), [(1, [0, 16_000, 0, 90_000]), (0, [16_000, 0, 0, 90_000])]
)
def test_a_tool_jog_moves_along_the_hand_on_the_r_axis(on_r: int, expected: list[int]) -> None:
    """With R at 90 degrees, X of a hand on the R axis is Y of the axes.

    A hand that is not on the R axis does not turn with R.

    Rule: coordinates.
    Source: remote command guide 4.2.6, tool coordinate system jog movement
    """
    master = _coordinates((0, 0, 0, 0), Hand((10_000, 0, 0, on_r)), 90_000)
    _jog_for(master, 100, TOOL, 0, 0x0001)
    assert master.robot.positions == expected


@pytest.mark.parametrize("code", [CARTESIAN, TOOL])
def test_a_turn_of_the_hand_leaves_the_tool_where_it_is(code: int) -> None:
    """The tool is 10 mm from the R axis, so X and Y move to compensate while R turns.

    Rule: coordinates.
    """
    master = _coordinates((0, 0, 0, 0), Hand((10_000, 0, 0, 1)), 0)
    before = master.execute(0x0506)[4:10]
    assert before == (10_000, 0, 0, 0, 0, 0)
    _jog_for(master, 300, code, 0, 0x0008)
    x, y, z, r = master.robot.positions
    assert r == 4_000 + 260 * 200  # 56 degrees
    assert (x, y, z) == (10_000 - 5_592, -8_290, 0)  # cosine 0.5592, sine 0.8290
    master.send()
    master.run(50)
    assert master.execute(0x0506)[4:10] == before


def test_a_turn_of_the_hand_ends_where_an_axis_that_gives_way_is_at_its_limit() -> None:
    """At 30 degrees Y would have to compensate by 5 mm, which is its limit.

    Rule: coordinates, jog-limit.
    """
    axes = (Axis(), Axis(soft_low=-5_000), Axis(), Axis())
    master = _jogger(axes=axes, hands={(1, 0): Hand((10_000, 0, 0, 1))})
    assert master.execute(CARTESIAN, 0, 0x0008)[:3] == SOFT_LIMIT
    x, y, _, r = master.robot.positions
    assert y == -5_000
    assert r == pytest.approx(30_000, abs=4)
    assert x == pytest.approx(10_000 - 8_660, abs=2)


def test_a_turn_ends_where_an_axis_is_beyond_its_limit_for_a_third_of_a_degree_only() -> None:
    """The turn stops at a limit that it would exceed only for a third of a degree.

    With a hand of 1 m, starting at 0.25 degrees, Y would go down to 4.363 - 1000 mm at 90 degrees.
    The limit lies 0.0047 mm above this position. The path crosses the limit 0.175 degrees before 90
    degrees, and again after 90 degrees.

    Rule: coordinates, jog-limit.
    """
    axes = (Axis(soft_high=3_000_000), Axis(soft_low=-995_632), Axis(), Axis(start=250))
    master = _jogger(axes=axes, hands={(1, 0): Hand((1_000_000, 0, 0, 1))})
    master.send(CARTESIAN, 0, 0x0008)
    assert master.finish(within_ms=60_000)[:3] == SOFT_LIMIT
    _, y, _, r = master.robot.positions
    assert y == -995_632
    assert r == pytest.approx(89_825, abs=20)


def test_a_jog_moves_the_robot_that_is_designated() -> None:
    """Source: remote command guide 4.2.6, R."""
    master = _jogger(axes=(Axis(start=7), Axis(robot=2, start=1), Axis(robot=2, start=2)))
    answer = _jog_for(master, 100, 0x2020, PULSE_OUTPUT, 0x0002)
    assert master.robot.positions == [7, 1, 16_002]
    assert answer[4:10] == (1, 0, 16_002, 0, 0, 0)
