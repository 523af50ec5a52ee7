"""Events that end a movement before its target, for every kind of movement.

The default axis has 1000 pulses/mm, 1 000 000 pulses/s and 5 000 000 pulses/s^2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from rcx_harness.robot import Axis, Point
from robot_master import Master, abnormal_end, servos_on

PULSE_OUTPUT = 0x4000
POINTS = {
    19: Point((60_000, 80_000, 0, 0, 0, 0)),
    20: Point((0, 160_000, 0, 0, 0, 0)),
    21: Point((80_000, 80_000, 0, 0, 0, 0)),
}
#: Each movement takes more than a second, and moves axis 1 or 2 within the first 200 ms.
MOVEMENTS = {
    "PTP": (0x0001, PULSE_OUTPUT | 0x0004, 0, 5, 19),
    "arch": (0x0002, PULSE_OUTPUT | 0x0004, 0x0200, 5, 19, 0, 0, 0, 0x86A0, 0x0001),
    "line": (0x0003, PULSE_OUTPUT | 0x0006, 0, 50, 19),
    "arc": (0x0004, PULSE_OUTPUT | 0x0006, 0, 50, 21, 20),
    "MOVEI": (0x0009, PULSE_OUTPUT | 0x0004, 0, 5, 19),
    "DRIVE": (0x0013, PULSE_OUTPUT | 0x0005, 0x0001, 5, 0x86A0, 0x0001),
    "DRIVEI": (0x0017, PULSE_OUTPUT | 0x0005, 0x0001, 5, 0x86A0, 0x0001),
    "PUSH": (0x004D, PULSE_OUTPUT | 0x0005, 0x0001, 5, 0x86A0, 0x0001),
    "MOVET": (0x0045, PULSE_OUTPUT | 0x0004, 0, 5, 19),
    "inching": (0x0024, PULSE_OUTPUT, 0x0001),
}


def _mover(**config: Any) -> Master:
    return servos_on(**{"points": POINTS, "manual_speed": 1, "inching_amount": 10_000, **config})


def _unplug(master: Master) -> None:
    master.connected = False


STOPS: dict[str, tuple[Callable[[Master], object], str]] = {
    "stop input": (lambda master: master.turn("SI06", False), "12.400"),
    "emergency stop input": (lambda master: master.turn("SI00", False), "12.600"),
    "emergency stop of the programming box": (
        lambda master: master.robot.inject("emergency_stop"), "12.600",
    ),
    "link loss": (_unplug, "12.552"),
    "alarm": (lambda master: master.robot.inject("alarm", group=17, category=4), "17.4"),
}  # fmt: skip


@pytest.mark.parametrize("what", STOPS)
@pytest.mark.parametrize("name", MOVEMENTS)
def test_a_stopped_movement_ends_where_it_is_and_shows_no_position(name: str, what: str) -> None:
    """The movement ends in the cycle of the stop, and does not continue by itself afterwards.

    Rule: halt, stop-in-motion.
    Source: remote command guide 1.2, code 0x4000
    """
    stop, alarm = STOPS[what]
    master = _mover()
    master.send(*MOVEMENTS[name])
    master.run(200)
    assert master.status == 0x0100
    before = list(master.robot.positions)
    assert any(before)
    stop(master)
    master.run(5)
    assert master.words == abnormal_end(alarm)
    stopped_at = list(master.robot.positions)
    assert math.dist(before, stopped_at) < 3_000
    master.connected = True
    master.robot.inject("emergency_stop_release")
    master.turn("SI00", True)
    master.turn("SI06", True)
    master.run(1000)
    assert master.words == abnormal_end(alarm)
    assert master.robot.positions == stopped_at


@pytest.mark.parametrize("name", [*MOVEMENTS, "jog"])
def test_a_snapshot_in_motion_goes_on_as_the_original_does(name: str) -> None:
    """Copy and original send the same bytes in every cycle until the command ends."""
    master = _mover(manual_speed=10)
    master.send(*MOVEMENTS.get(name, (0x0021, PULSE_OUTPUT, 0x0001)))
    master.run(90)
    snapshot, now_us, si = master.robot.snapshot(), master.now_us, bytes(master.si)
    first, words = _areas(master), master.words
    assert words[0] != 0x0100
    master.robot.restore(snapshot)
    master.now_us, master.si[:] = now_us, si
    assert _areas(master) == first


def _areas(master: Master) -> list[bytes]:
    """Return the area that the master receives in every cycle until the end status."""
    seen = []
    for _ in range(3_000):
        master.run(5)
        seen.append(master.so)
        if master.status in (0x0200, 0x4000):
            break
    return seen


@pytest.mark.parametrize("where", [200, 600, 1000, 1400])
def test_a_line_is_stopped_on_the_line(where: int) -> None:
    """Source: remote command guide 4.2.1, linear interpolation."""
    master = _mover()
    master.send(*MOVEMENTS["line"])
    master.run(where)
    master.turn_and_wait("SI06", False, 5)
    x, y, *_ = master.robot.positions
    assert 0 < x < 60_000
    assert y == pytest.approx(x * 4 / 3, abs=2)


@pytest.mark.parametrize("where", [200, 1200, 2400, 4800])
def test_an_arc_is_stopped_on_the_arc(where: int) -> None:
    """The arc has its centre at (0, 80) mm and a radius of 80 mm, and goes to the right.

    Source: remote command guide 4.2.1, circular interpolation
    """
    master = _mover()
    master.send(*MOVEMENTS["arc"])
    master.run(where)
    master.turn_and_wait("SI06", False, 5)
    x, y, *_ = master.robot.positions
    assert x > 0
    assert math.dist((x, y), (0, 80_000)) == pytest.approx(80_000, abs=2)


def _interrupted(master: Master, name: str) -> None:
    """Return a master whose movement was stopped after 200 ms, and which is ready for a command."""
    master.send(*MOVEMENTS[name])
    master.run(200)
    master.turn_and_wait("SI06", False)
    master.send()
    master.turn_and_wait("SI06", True)


def _power_cycle(master: Master) -> None:
    master.robot.inject("power_cycle")
    master.turn("SI00", False)
    master.turn("SI06", False)
    master.servo_on()


ENDS_THE_MEMORY: dict[str, Callable[[Master], object]] = {
    "inching of axis 3": lambda master: master.execute(0x0024, 0, 0x0004),
    "return to origin": lambda master: master.pulse("SI17", 1500),
    "power cycle": _power_cycle,
}


@pytest.mark.parametrize("name", ["MOVEI", "DRIVEI"])
@pytest.mark.parametrize("what", ENDS_THE_MEMORY)
def test_the_same_command_starts_anew_after_an_event_that_ends_its_memory(
    what: str, name: str
) -> None:
    """The interrupted movement does not affect the next command.

    The return-to-origin ends at 0 pulses.

    Rule: relative-kept.
    Source: remote command guide 4.2.2, note
    """
    master = _mover(axes=(Axis(start=700), Axis(), Axis()))
    _interrupted(master, name)
    stands = 0 if what == "return to origin" else master.robot.positions[0]
    ENDS_THE_MEMORY[what](master)
    assert master.robot.positions[0] == stands
    assert master.execute(*MOVEMENTS[name])[0] == 0x0200
    assert master.robot.positions[0] == stands + (60_000 if name == "MOVEI" else 100_000)


@pytest.mark.parametrize("name", ["MOVEI", "DRIVEI"])
@pytest.mark.parametrize("what", ["emergency stop input", "alarm"])
def test_after_an_emergency_stop_the_original_target_is_kept_too(name: str, what: str) -> None:
    """Rule: relative-kept. Source: remote command guide 4.2.2, note."""
    master = _mover()
    master.send(*MOVEMENTS[name])
    master.run(200)
    STOPS[what][0](master)
    master.run(150)
    master.send()
    master.turn_and_wait("SI00", True)
    master.pulse("SI16")
    master.pulse("SI01")
    assert master.execute(*MOVEMENTS[name])[0] == 0x0200
    assert master.robot.positions[0] == (60_000 if name == "MOVEI" else 100_000)


@pytest.mark.parametrize(
    ("name", "parameter", "left"),
    [("PTP", "TOLE", 0), ("line", "TOLE", 0), ("arch", "OUTPOS", 0)],
)
def test_a_command_may_end_within_the_tolerance(name: str, parameter: str, left: int) -> None:
    """The axis continues to its target while the end status is shown.

    Rule: arrival.
    Source: remote command guide 4.2.1, arch designation, step 4
    """
    master = _mover(end_in_tolerance=True, parameters={"TOLE": 1, "OUTPOS": 1, parameter: 3_000})
    master.send(*MOVEMENTS[name])
    words = master.finish()
    assert words[0] == 0x0200
    x, y = (words[k] | words[k + 1] << 16 for k in (4, 6))
    assert max(60_000 - x, abs(80_000 - y)) in range(100, 3_001)
    master.run(500)
    assert master.robot.positions == [60_000, 80_000, left, 0]
