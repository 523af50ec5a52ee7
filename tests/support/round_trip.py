"""A round trip: a remote command, and a later command that shows its effect.

All trips use the same controller: a SCARA robot of four axes with 1000 pulses per millimetre, an
extended area and two programs. Axes 2 and 4 have the mark method.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from rcx_harness.robot import Axis, Point, RobotProgram
from rcx_harness.robot.stored import Hand, Pallet
from robot_master import Master
from stored_data import long_words

Words = tuple[int, ...]
#: A step of a trip: a telegram, or a function that causes another event.
Step = Words | Callable[[Master], object]

_LINES = ("MO(20)=1", "MO(21)=1", "MO(22)=1", "DELAY 60000")
FIRST, SECOND = (1000, -2000, 3000, 4000), (-5000, 600, 700, 80)

#: Telegrams that request the current position in pulses, in mm, and point 5.
PULSES, IN_MM, READ_5 = (0x505,), (0x506,), (0x101, 0, 5)


@dataclass(frozen=True)
class Trip:
    """The steps of a trip, and its expected result.

    The result is the answer to the last telegram, or the result of `look` if it is given.
    """

    code: int
    steps: tuple[Step, ...]
    expected: object
    look: Callable[[Master], object] | None = None


@lru_cache(maxsize=1)
def _start() -> tuple[Master, object]:
    still = {"holding_torque": 90, "rated_torque": 20}
    axes = (
        Axis(**still),  # type: ignore[arg-type]
        Axis(origin_method="mark"),
        Axis(type="incremental", workpiece=2000),
        Axis(type="incremental", origin_method="mark"),
    )
    pallet = {10: (0, 0, 0, 0), 11: (900, 0, 0, 0), 12: (0, 800, 0, 0), 13: (900, 800, 0, 0)}
    points = {**pallet, 14: (0, 0, 700, 0), 1: FIRST, 2: SECOND, 3: (1000, 1000, 0, 0)}
    master = Master(
        size=256,
        axes=axes,
        points={number: Point((*data, 0, 0)) for number, data in points.items()},
        pallets={1: Pallet(10, 2, 1, 10)},
        shifts={1: (1000, 0, 0, 0), 2: (0, 250, 0, 0)},
        hands={(1, 1): Hand((0, 500, 0, 0)), (1, 2): Hand((0, 0, 700, 0))},
        programs=(RobotProgram("ONE", steps=_LINES), RobotProgram("TWO", steps=_LINES)),
        command_delay=0.0,
        servo_on_delay=0.0,
        origin_time=10.0,
        program_start_delay=0.0,
        program_reset_delay=0.0,
    )
    master.servo_on()
    return master, master.robot.snapshot()


def run_trip(trip: Trip) -> object:
    """Run the steps from the initial state; return the last answer, or the result of `look`."""
    master, snapshot = _start()
    master.robot.restore(snapshot)
    shown: Words = ()
    for step in trip.steps:
        if callable(step):
            step(master)
            continue
        master.send(*step)
        shown = master.finish()
        master.send()
        master.run(10)
        assert master.status == 0
    return trip.look(master) if trip.look else shown


def answer(*words: int) -> Words:
    """Return the expected words of a normal end; `words` are the words from m+4 on."""
    return (0x0200, 0, *words) + (0,) * (14 - len(words))


def at(*positions: int) -> Words:
    """Return the expected answer with a current position in pulses."""
    return answer(0, 0, *long_words(*positions))


def at_mm(*positions: int) -> Words:
    """Return the expected answer with a position in 0.001 mm.

    Bit 0 of m+6 is 1 as in the example of the guide.
    """
    return answer(0, 1, *long_words(*positions))


def point_is(number: int, flags: int, *data: int) -> Words:
    return answer(number, flags, *long_words(*data))


def states_are(*states: int) -> Words:
    """Return the expected answer with states of servo or origin.

    Axes 5 and 6 do not exist.
    """
    return answer(*states, 9, 9)


def wait(master: Master) -> None:
    master.run(50)
