"""Round trips of movements, axes and settings (guide, 4.2)."""

from __future__ import annotations

from robot_master import Master
from round_trip import (
    FIRST,
    IN_MM,
    PULSES,
    READ_5,
    SECOND,
    Step,
    Trip,
    answer,
    at,
    at_mm,
    point_is,
    states_are,
    wait,
)
from stored_data import long_words

_SERVOS, _ORIGINS = (0x503,), (0x150F,)
_ALL_OFF, _NO_POWER = (0x035,), (0x041,)
_ON, _ARCH = 0x0400, (0, 0, 0, *long_words(1500))  # axis 3 rises to 1500 first


def _stand(*positions: int) -> Step:
    return lambda master: master.robot.positions.__setitem__(slice(None), list(positions))


def _jog(code: int, axes: int) -> Step:
    """Jog for 100 ms, stop the jog by SI(06) OFF, and switch SI(06) ON again."""

    def jog(master: Master) -> None:
        master.send(code, 0, axes)
        master.run(100)
        master.turn("SI06", False)
        master.run(20)
        master.send()
        master.turn_and_wait("SI06", True)

    return jog


def _forget_origins(master: Master) -> None:
    master.robot.origins[1] = master.robot.origins[3] = False


def _way_of_axis_1(master: Master) -> int:
    """Return the sign of axis 1's position, which is the direction of its movement from 0."""
    place = master.robot.positions[0]
    return (place > 0) - (place < 0)


def _moves() -> list[Trip]:
    """Return the trips of movements. The current position shows the result."""
    trips: list[Trip] = []
    for point, place in ((1, FIRST), (2, SECOND)):
        by_point: dict[int, Step] = {
            **{code: (code, 0, 0, 0, point) for code in (0x001, 0x003, 0x009, 0x00A)},
            **{code: (code, 0, 0, 0, point) for code in (0x044, 0x045)},
            0x002: (0x002, 0, _ON, 0, point, *_ARCH),
            0x004: (0x004, 0, 0, 0, 3, point),
            **{code: (code, 0, 0, 0, *long_words(*place)) for code in (0x006, 0x007, 0x00E, 0x00F)},
        }
        trips += [Trip(code, (step, PULSES), at(*place)) for code, step in by_point.items()]
        to_point = [(code, 1, 4, 0, point) for code in (0x010, 0x014)]
        direct = [(code, 1, 4, 0, place[2]) for code in (0x012, 0x013, 0x016, 0x017)]
        trips += [Trip(one[0], (one, PULSES), at(0, 0, place[2])) for one in to_point + direct]
    for target, stops in ((700, 700), (3000, 2000)):  # the workpiece of axis 3 is at 2000
        points = {700: 2, 3000: 1}
        push_time = (0, 0, 0, 0, 20)  # [ms], n+18
        for code, data in ((0x04B, points[target]), (0x04C, target), (0x04D, target)):
            push = (code, 0x0101, 4, 0, data, *push_time)
            trips.append(Trip(code, (push, PULSES), at(0, 0, stops)))
    for work, corner in ((2, (100, 0)), (20, (900, 800))):
        trips.append(Trip(0x018, ((0x018, 0, 0, 0, 1, work), PULSES), at(*corner)))
        arch = (0x019, 0, _ON, 0, 1, work, 0, 0, *long_words(1500))
        trips.append(Trip(0x019, (arch, PULSES), at(*corner)))
    for sign, minus in ((1, 0x00), (-1, 0x80)):
        for code in (0x020, 0x021, 0x022):
            trips.append(Trip(code, (_jog(code, 1 | minus),), sign, look=_way_of_axis_1))
        for code in (0x024, 0x025, 0x026):
            trips.append(Trip(code, ((code, 0, 2 | minus), PULSES), at(0, 100 * sign)))
    return trips


def _axes() -> list[Trip]:
    """Return the trips for axes and servos, speeds and designations (4.2.8 to 4.2.22)."""
    trips: list[Trip] = [
        *(
            Trip(code, ((0x027, 0, amount), (0x514,)), answer(amount))
            for code in (0x027, 0x514)
            for amount in (50, 7)
        ),
        *(
            Trip(0x028, (_stand(*place), (0x028, 0, 5, 0), READ_5), point_is(5, 0, *place))
            for place in (FIRST, SECOND)
        ),
        Trip(0x030, (_stand(0, 5000, 0, 0), (0x030, 0, 0x82), PULSES), at(0, 4096)),
        Trip(0x030, (_stand(0, 5000, 0, 0), (0x030, 0, 0x02), PULSES), at(0, 8192)),
        *(
            Trip(
                code,
                (_forget_origins, _stand(0, 8192, 0, 4096), (0x031, 0, axis), _ORIGINS),
                states_are(*states),
            )
            for code in (0x031, 0x50F)
            for axis, states in ((0x02, (1, 1, 1, 0)), (0x08, (1, 0, 1, 1)))
        ),
        *(
            Trip(sent[0] & 0xFFF, (_stand(100, 0, 300, 0), sent, PULSES), at(*place))
            for sent, place in (
                ((0x1032, 0x0002), (100, 0, 0, 0)),
                ((0x1032, 0x0004), (0, 0, 300, 0)),
                ((0x033, 0, 0x04), (100, 0, 0, 0)),
                ((0x033, 0, 0x01), (0, 0, 300, 0)),
            )
        ),
        *(
            Trip(code, (_ALL_OFF, (0x034, 0, axis), _SERVOS), states_are(*states))
            for code in (0x034, 0x035, 0x503)
            for axis, states in ((0x01, (1, 0, 0, 0)), (0x08, (0, 0, 0, 1)))
        ),
        Trip(0x036, ((0x036, 0, 0x08), _SERVOS), states_are(1, 1, 1, 2)),
        Trip(0x036, ((0x036, 0, 0x00), _SERVOS), states_are(2, 2, 2, 2)),
        Trip(0x041, (_NO_POWER, _SERVOS), states_are(0, 0, 0, 0)),
        Trip(0x042, (_NO_POWER, (0x042,), _SERVOS), states_are(1, 1, 1, 1)),
        Trip(0x043, (_NO_POWER, (0x043,), (0x034, 0, 0x01), _SERVOS), states_are(1, 0, 0, 0)),
    ]
    for which, code in enumerate((0x039, 0x038, 0x03A)):  # the speeds: automatic, manual, program
        for speed in (33, 77):
            speeds = [100, 20, 100]
            speeds[which] = speed
            change = (code, 0, speed)
            shown = answer(*speeds)
            trips += [Trip(one, (change, (0x50A,)), shown) for one in (code, 0x50A)]
    for number, shift, hand in ((1, (-1000, 0, 0), (0, 500, 0)), (2, (0, -250, 0), (0, 0, 700))):
        trips.append(Trip(0x03B, ((0x03B, 0, number), IN_MM), at_mm(*shift)))
        trips.append(Trip(0x03C, ((0x03C, 0, number), IN_MM), at_mm(*hand)))
    for arms, arm_now in (((1,), 1), ((1, 0), 0)):
        changes = tuple((0x03D, 0, arm) for arm in arms)
        trips += [Trip(code, (*changes, (0x50B,)), answer(arm_now)) for code in (0x03D, 0x50B)]
        move = (0x001, 0, 0, 0, 1)
        trips.append(Trip(0x50C, (*changes, move, (0x50C,)), answer(arm_now)))
    for limit in (30, 60):  # holding axis 1 needs 90 %, and the rated torque is 20 %
        steps = ((0x048, 0, 1, limit), (0x001, 0, 0, 0, 1), wait)
        trips += [Trip(code, (*steps, (0x510,)), answer(limit)) for code in (0x048, 0x510)]
        trips.append(Trip(0x516, (*steps, (0x516,)), answer(5 * limit)))
    return trips


#: All trips with movements. If a command has two outcomes, two trips have different values.
MOTION_TRIPS: tuple[Trip, ...] = (*_moves(), *_axes())
