"""The telegrams that the manual prints for these commands, word by word.

Each is sent as printed; the answer must be the printed one. What the example takes for granted
(positions, points) is set before.
"""

from __future__ import annotations

import pytest

from rcx_harness.robot import Point
from robot_master import Master

NO_MORE = (0,) * 15


def _telegram(text: str) -> tuple[int, ...]:
    words = tuple(int(word, 16) for word in text.split())
    return words + (0,) * (16 - len(words))


def _exchange(master: Master, command: str) -> tuple[int, ...]:
    return master.execute(*_telegram(command))


def test_move_ptp_to_point_100_at_50_percent_with_the_position_in_pulses() -> None:
    """Axis 1 = 123456, axis 2 = -123, others 0.

    Source: remote command guide 4.2.1, PTP designation, example
    """
    master = Master(points={100: Point((123456, -123, 0, 0, 0, 0))})
    master.servo_on()
    answer = _exchange(master, "0001 4004 0000 0032 0064")
    assert answer == _telegram("0200 0000 0000 0000 E240 0001 FF85 FFFF")


def test_move_ptp_to_point_19_at_50_percent() -> None:
    """No position is asked for, so all response words are 0.

    Source: remote command guide chapter 2, example
    """
    master = Master(points={19: Point((100000, 0, 0, 0, 0, 0))})
    master.servo_on()
    assert _exchange(master, "0001 0004 0000 0032 0013") == (0x0200, *NO_MORE)
    assert master.robot.positions == [100000, 0, 0, 0]


def test_point_data_definition_in_pulses() -> None:
    """Point 100 = 10000, -20000, 5000, -18000.

    Source: remote command guide 4.3.1, point data definition, example
    """
    master = Master()
    master.power_up()
    command = "0100 0000 0064 0000 2710 0000 B1E0 FFFF 1388 0000 B9B0 FFFF"
    assert _exchange(master, command) == (0x0200, *NO_MORE)
    assert master.robot.points[100] == Point((10000, -20000, 5000, -18000, 0, 0))


def test_point_data_reference_in_millimetres() -> None:
    """Point 50 = 10.000, -20.000, 5.000, -18.000.

    Source: remote command guide 4.3.1, point data reference, example
    """
    master = Master(points={50: Point((10000, -20000, 5000, -18000, 0, 0), mm=True)})
    master.power_up()
    answer = _exchange(master, "0101 0000 0032")
    expected = "0200 0000 0032 0001 2710 0000 B1E0 FFFF 1388 0000 B9B0 FFFF"
    assert answer == _telegram(expected)


def test_version_information() -> None:
    """V1.08, R0048, FPGA V1.001, four drivers V1.01.

    Rule: versions.
    Source: remote command guide 4.7.1, example
    """
    master = Master()
    master.power_up()
    answer = _exchange(master, "0501")
    assert answer == _telegram("0200 0000 0108 0030 1001 0101 0101 0101 0101")


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("0505", "0200 0000 0000 0000 4E21 0000 0000 0000 CFC7 FFFF"),
        ("0506", "0200 0000 0000 0001 4E21 0000 0000 0000 CFC7 FFFF"),
    ],
)
def test_current_position_in_pulses_and_millimetres(command: str, expected: str) -> None:
    """Axis 1 = 20001 or 20.001, axis 3 = -12345 or -12.345.

    Rule: flag-bit-0, millimetres.
    Source: remote command guide 4.7.4, examples
    """
    master = Master()
    master.power_up()
    master.robot.positions[:] = [20001, 0, -12345, 0]
    assert _exchange(master, command) == _telegram(expected)


def test_alarm_reset_command() -> None:
    """Source: remote command guide 4.8.3, example."""
    master = Master()
    master.power_up()
    assert _exchange(master, "0604") == (0x0200, *NO_MORE)
