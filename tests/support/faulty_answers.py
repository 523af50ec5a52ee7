"""Recordings with one kind of wrong answer each, made from recordings of a correct controller."""

from __future__ import annotations

from collections.abc import Callable

from rcx_harness.look.compare.recording import Recording, of_cycles
from rcx_harness.spec import signals
from rcx_harness.spec.wire import ABNORMAL_END, DEDICATED_AT, NORMAL_END, RUN
from recorded_robot import RecordedMaster

Areas = list[bytearray]
_BITS = {one.short: (one.byte, 1 << one.bit) for one in signals().output}


def _set(area: bytearray, name: str, on: bool) -> None:
    at, mask = _BITS[name]
    area[at] = area[at] | mask if on else area[at] & 0xFF & ~mask


def _edges(areas: Areas, name: str, on: bool) -> list[int]:
    at, mask = _BITS[name]
    levels = [bool(area[at] & mask) for area in areas]
    return [k for k in range(1, len(areas)) if levels[k] is on and levels[k - 1] is not on]


def _turned(name: str, on: bool, first: int, end: int, by: str = "") -> Callable[[Areas], None]:
    """Return a change that shows a signal ON (or OFF) for some cycles.

    `first` and `end` count the cycles from the rising edge of the signal, or of the signal `by`.
    """

    def change(areas: Areas) -> None:
        for k in _edges(areas, by or name, True):
            for place in range(max(0, k + first), min(len(areas), k + end)):
                _set(areas[place], name, on)

    return change


def _ends(areas: Areas) -> list[tuple[int, int]]:
    """Return the normal ends: for each, its first cycle and the cycle after its last."""
    found: list[tuple[int, int]] = []
    for k, area in enumerate(areas):
        if int.from_bytes(area[:2], "little") == NORMAL_END:
            if found and found[-1][1] == k:
                found[-1] = (found[-1][0], k + 1)
            else:
                found.append((k, k + 1))
    return found


def _each_end(change: Callable[[Areas, int, int], None]) -> Callable[[Areas], None]:
    def every(areas: Areas) -> None:
        for first, end in _ends(areas):
            change(areas, first, end)

    return every


def _shift(areas: Areas, first: int, end: int) -> None:
    for area in areas[first:end]:
        area[4:DEDICATED_AT] = area[2 : DEDICATED_AT - 2]
        area[2:4] = bytes(2)


def _abnormal(areas: Areas, first: int, end: int) -> None:
    for area in areas[first:end]:
        area[:2] = ABNORMAL_END.to_bytes(2, "little")


def _not_cleared(areas: Areas, first: int, end: int) -> None:
    for area in areas[end : end + 6]:
        area[2:DEDICATED_AT] = areas[first][2:DEDICATED_AT]


def _too_short(areas: Areas, first: int, end: int) -> None:
    for area in areas[end - 1 : end]:
        area[:DEDICATED_AT] = bytes(DEDICATED_AT)


def _only_status_first(areas: Areas, first: int, end: int) -> None:
    areas[first][2:DEDICATED_AT] = bytes(DEDICATED_AT - 2)


def _stale(areas: Areas) -> None:
    before = bytes(30)
    for first, end in _ends(areas):
        mine = bytes(areas[first][2:DEDICATED_AT])
        for area in areas[first:end]:
            area[2:DEDICATED_AT] = before
        before = mine


def _run_again(areas: Areas, first: int, end: int) -> None:
    areas[end][:2] = RUN.to_bytes(2, "little")


def _follow(name: str, other: str) -> Callable[[Areas], None]:
    """Return a change that gives a signal the value of another signal."""

    def change(areas: Areas) -> None:
        at, mask = _BITS[other]
        for area in areas:
            _set(area, name, bool(area[at] & mask))

    return change


def _reserved(areas: Areas) -> None:
    for k in _edges(areas, "SO02", True):
        areas[k][DEDICATED_AT + 1] |= 0x40


def _stuck(name: str) -> Callable[[Areas], None]:
    """Return a change that delays the first OFF of a signal by one cycle."""

    def change(areas: Areas) -> None:
        k = _edges(areas, name, False)[0]
        _set(areas[k], name, True)

    return change


#: Maps the name of a fault to its change of a correct controller's areas.
WRONG: dict[str, Callable[[Areas], None]] = {
    "responses one word too late in the area": _each_end(_shift),
    "commands that are executed end abnormally, with their data": _each_end(_abnormal),
    "the response stays for 30 ms in the ready status": _each_end(_not_cleared),
    "the end status goes before the master resets it": _each_end(_too_short),
    "the response comes one cycle after its status": _each_end(_only_status_first),
    "each response is that of the command before": _stale,
    "run status once more between the end and the ready status": _each_end(_run_again),
    "SO(03) 40 ms after SO(00)": _turned("SO03", False, 0, 8),
    "SO(03) OFF for 25 ms, then ON again without a cause": _turned("SO03", False, 20, 25),
    "SO(02) toggles when it comes": _turned("SO02", False, 2, 3),
    "SO(02) ON 10 ms before it was asked": _turned("SO02", True, -14, 0),
    "SO(13) goes one cycle later than the program stops otherwise, for once": _stuck("SO13"),
    "SO(10) OFF for one cycle when servos come ON": _turned("SO10", False, 0, 1, by="SO02"),
    "SO(11) goes with the servos": _follow("SO11", "SO02"),
    "SO(15) is SO(03) as well": _follow("SO15", "SO03"),
    "a reserved bit comes with the servos": _reserved,
}


def recorded_wrong(master: RecordedMaster, name: str) -> Recording:
    """Return the recording of a master, changed by the fault of this name."""
    areas = [bytearray(so) for _, _, so in master.cycles]
    WRONG[name](areas)
    cycles = [(t, si, bytes(so)) for (t, si, _), so in zip(master.cycles, areas, strict=True)]
    return of_cycles(cycles, every=True)
