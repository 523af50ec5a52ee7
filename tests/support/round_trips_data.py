"""Round trips of data, variables, ports, programs and real time output (guide, 4.3 to 4.9)."""

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
    wait,
)
from stored_data import long_words, real_words, text_words

_TASKS, _LINE = (0x507,), (0x508,)
_STEP_1 = (0x403, 2, 0, 1)  # the time for one line of the program in task 1
_SGI1 = (0x214, 0, 1)
_DUTY = (0x701, 0, 24, 0, 13, 1, 1)


def _mo2(master: Master) -> int:
    return master.robot.read_port("MO2()")


def _alarm(category: int) -> Step:
    return lambda master: master.robot.inject("alarm", group=99, category=category)


def _serious(master: Master) -> bool:
    return master.on("SO03")


def _ways(master: Master) -> list[bool]:
    """Return for each axis whether its accumulated moving distance is above 0."""
    return [way > 0 for way in master.robot.machine.data.accumulated.distances]


def _counts(master: Master) -> tuple[int, int]:
    """Return how often power and motor power were switched ON."""
    data = master.robot.machine.data.accumulated
    return data.power_on_count, data.motor_power_on_count


def _real_time(master: Master) -> int:
    """Return SOW(24)."""
    return int.from_bytes(master.so[48:50], "little")


def _stored() -> list[Trip]:
    """Return the trips of definitions, references, parameters, points and elements (4.3, 4.4)."""
    trips: list[Trip] = []
    for number, unit in ((5, 0), (6, 1)):
        data = (100 * number, -7, 2**31 - 1, -(2**31), unit, -1)
        steps: tuple[Step, ...] = ((0x100, unit, number, 0, *long_words(*data)), (0x101, 0, number))
        trips += [Trip(code, steps, point_is(number, unit, *data)) for code in (0x100, 0x101)]
        text = text_words(f"NO {number}", "\0")
        steps = ((0x104, 0, number, 0, *text), (0x105, 0, number))
        trips += [Trip(code, steps, answer(number, 0, *text)) for code in (0x104, 0x105)]
        steps = ((0x108, 0, number, 4, 3, 2, 10 * number), (0x109, 0, number))
        shown = answer(number, 4, 3, 2, 10 * number)
        trips += [Trip(code, steps, shown) for code in (0x108, 0x109)]
        shift = long_words(number, -number, 90_000, -2)
        steps = ((0x10C, 0, number, 0, *shift), (0x10D, 0, number))
        trips += [Trip(code, steps, answer(number, 0, *shift)) for code in (0x10C, 0x10D)]
        hand = long_words(number, -number, 90_000, unit)
        steps = ((0x110, 0, number, 0, *hand), (0x111, 0, number))
        trips += [Trip(code, steps, answer(number, 1, *hand)) for code in (0x110, 0x111)]
    for parameter, axis, value in ((257, 2, 40), (2, 0, 1500)):
        steps = ((0x220, 0, parameter, axis, value), (0x224, 0, parameter, axis))
        trips += [Trip(code, steps, answer(parameter, axis, value)) for code in (0x220, 0x224)]
    for other, sign in ((1, 1), (2, 1), (1, -1), (2, -1)):
        code = 0x234 if sign > 0 else 0x235
        place = FIRST if other == 1 else SECOND
        total = [one + sign * two for one, two in zip((1000, 1000, 0, 0), place, strict=True)]
        trips.append(Trip(code, ((code, 0, 3, other), (0x101, 0, 3)), point_is(3, 0, *total)))
    for source, place in ((1, FIRST), (2, SECOND)):
        trips.append(Trip(0x230, ((0x230, 0, 5, source), READ_5), point_is(5, 0, *place)))
        element = (0x240, 0, 2, 1 << source, 11 * source)
        changed = list(SECOND)
        changed[source] = 11 * source
        trips.append(Trip(0x240, (element, (0x101, 0, 2)), point_is(2, 0, *changed)))
        element_mm = (0x241, 0, 5, 1 << source, 11 * source)
        define = (0x100, 1, 5, 0, *long_words(1, 2, 3))
        values = [1, 2, 3]
        values[source] = 11 * source
        trips.append(Trip(0x241, (define, element_mm, READ_5), point_is(5, 1, *values)))
        shift_element = (0x245, 0, 1, 1 << source, 11 * source)
        shifted = [1000, 0, 0, 0]
        shifted[source] = 11 * source
        read = (0x10D, 0, 1)
        trips.append(Trip(0x245, (shift_element, read), answer(1, 0, *long_words(*shifted))))
    for work, corner in ((2, (100, 0)), (20, (900, 800))):
        trips.append(Trip(0x238, ((0x238, 0, 5, 1, work), READ_5), point_is(5, 0, *corner)))
    return trips


def _variables() -> list[Trip]:
    """Return the trips of assignment and arithmetic (4.4.1). SGI1 is 12 at the start."""
    results = {
        0x200: {3: 3, 4: 4},
        0x204: {3: 15, 4: 16},
        0x208: {3: 9, 4: 8},
        0x20C: {3: 36, 4: 48},
        0x210: {3: 4, 4: 3},
    }
    trips: list[Trip] = []
    for code, by_value in results.items():
        for value, result in by_value.items():
            twelve, other = (0x200, 0, 1, 0, 12), (0x200, 0, 2, 0, value)
            shown = answer(1, 0, result)
            trips.append(Trip(code, (twelve, (code, 0, 1, 0, value), _SGI1), shown))
            by_variable = (code + 1, 0, 1, 0, 2)
            trips.append(Trip(code + 1, (twelve, other, by_variable, _SGI1), shown))
    for real in (1.5, -1e30):
        assign = (0x200, 0, 287, 0, *real_words(real))
        trips.append(Trip(0x214, (assign, (0x214, 0, 287)), answer(287, 0, *real_words(real))))
    return trips


def _programs_and_ports() -> list[Trip]:
    """Return the trips of I/O ports and program operation (4.5, 4.6, 4.7.5, 4.7.6)."""
    trips: list[Trip] = []
    for port, pattern in ((0x1020, 0xA5), (0x6120, 0x07)):
        steps: tuple[Step, ...] = ((0x300, 0, port | 0x0100, pattern), (0x304, 0, port | 0x0100))
        shown = answer(port | 0x0100, pattern)
        trips += [Trip(code, steps, shown) for code in (0x300, 0x304)]
    for bit, pattern in ((0, 1), (7, 0x80)):
        steps = ((0x301, 0, 0x2020 | bit, 1), (0x304, 0, 0x2020))
        trips.append(Trip(0x301, steps, answer(0x2020, pattern)))
    for task, priority in ((3, 10), (16, 64)):
        steps = ((0x401, 1, 2, task, priority), (0x408, 1, 2))
        shown = answer(2, task, 1, priority, *text_words("TWO", " "))
        trips += [Trip(code, steps, shown) for code in (0x401, 0x408)]
    register = (0x401, 1, 2, 2, 32)
    for task, states in ((1, (1, 0)), (2, (0, 1))):
        steps = (register, (0x402, 2, 0, task), wait, _TASKS)
        shown = answer(*states, *[9] * 6)
        trips += [Trip(code, steps, shown) for code in (0x402, 0x507)]
    for times in (1, 2):
        for code in (0x403, 0x404, 0x405):
            line = ((code, 2, 0, 1), wait) * times
            trips.append(Trip(code, (*line, _LINE), answer(1 + times)))
        done = (1 << times) - 1 if times else 0
        trips.append(Trip(0x403, (_STEP_1, wait) * times, done, look=_mo2))
        trips.append(Trip(0x508, ((_STEP_1, wait) * times) + (_LINE,), answer(1 + times)))
    both = (register, _STEP_1, wait, (0x403, 2, 0, 2), wait)
    trips.append(Trip(0x406, (*both, (0x406,), wait, _LINE), answer(1, 1)))
    trips.append(Trip(0x406, (*both, (0x406, 2, 0, 2), wait, _LINE), answer(2, 1)))
    return trips


def _data() -> list[Trip]:
    """Return the trips of data handling, utility and real time output (4.7 to 4.9)."""
    slots = answer(0x0401, 0x0100)
    steps: tuple[Step, ...]
    trips: list[Trip] = [
        Trip(0x501, ((0x501,),), answer(0x0108, 0x0030, 0x1001, *[0x0101] * 4)),
        Trip(0x502, ((0x502,),), answer(2000, 0, *[2000] * 4)),
        Trip(0x505, ((0x007, 0, 0, 0, *long_words(*FIRST)), PULSES), at(*FIRST)),
        Trip(0x505, ((0x007, 0, 0, 0, *long_words(*SECOND)), PULSES), at(*SECOND)),
        Trip(0x506, ((0x007, 0, 0, 0, *long_words(*FIRST)), IN_MM), at_mm(*FIRST)),
        Trip(0x506, ((0x007, 0, 0, 0, *long_words(*SECOND)), IN_MM), at_mm(*SECOND)),
        Trip(0x509, (_alarm(1), wait, (0x509, 0, 1)), (0x0200, 99, 1, 0x0101) + (0,) * 12),
        Trip(0x509, (_alarm(2), wait, (0x509, 0, 1)), (0x0200, 99, 2, 0x0101) + (0,) * 12),
        Trip(0x513, ((0x513, 0, 1),), slots),
        Trip(
            0x515,
            ((0x007, 1, 1, 0, 0, 0x7FFF), (0x515,)),
            (0x0200, 2, 334, 0x0001, 0x0101) + (0,) * 11,
        ),
        Trip(0x515, ((0x101, 0, 29), (0x515,)), (0x0200, 6, 204, 0x0101) + (0,) * 12),
        Trip(0x604, (_alarm(1), wait, (0x604,), wait), False, look=_serious),
    ]
    for year, month, day in ((24, 2, 29), (99, 12, 31)):
        steps = ((0x602, 0, year, month, day), (0x511,))
        trips += [Trip(code, steps, answer(year, month, day)) for code in (0x602, 0x511)]
    for hour, minute, second in ((0, 59, 1), (23, 0, 30)):
        steps = ((0x603, 0, hour, minute, second), (0x512,))
        trips += [Trip(code, steps, answer(hour, minute, second)) for code in (0x603, 0x512)]
    move = (0x001, 0, 0, 0, 1)
    for axis, left in ((0x01, [False, True, True, True]), (0x00, [False] * 4)):
        trips.append(Trip(0x605, (move, (0x605, 0, 3, axis)), left, look=_ways))
    for item, counts in ((1, (0, 1)), (2, (1, 0))):
        trips.append(Trip(0x606, ((0x606, 0, item),), counts, look=_counts))
    trips.append(Trip(0x607, (move, (0x607,)), [False] * 4, look=_ways))
    trips.append(Trip(0x607, ((0x607,),), (0, 0), look=_counts))
    for word, axis in ((24, 1), (127, 4)):
        definition = (word, 0, 13, 1, axis)
        steps = ((0x701, 0, *definition), (0x702, 0, word))
        trips += [Trip(code, steps, answer(*definition)) for code in (0x701, 0x702)]
    trips.append(Trip(0x703, (_DUTY, (0x703, 0, 1), wait), 450, look=_real_time))
    trips.append(Trip(0x703, (_DUTY, (0x703, 0, 1), wait, (0x703,), wait), 0, look=_real_time))
    return trips


#: All trips with data. If a command has two outcomes, two trips have different values.
DATA_TRIPS: tuple[Trip, ...] = (*_stored(), *_variables(), *_programs_and_ports(), *_data())
