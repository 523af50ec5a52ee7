"""The three clocks of a cell on one virtual time: PLC scan, packets, controller cycle.

At equal times the order is fixed: what the test or the stimulus does, the controllers' cycles,
packets produced, packets delivered, the PLC's scan. A change therefore never travels through two
participants in no time the wrong way round, and a run is the same on every machine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from datetime import timedelta
from enum import IntEnum
from heapq import heapify, heappop, heappush, heapreplace
from random import Random
from typing import Any

from rcx_harness.spec.wire import CYCLE_US
from structured_text.errors import InputError
from structured_text.units import format_us, parse_us, whole

__all__ = ["LONGEST_RPI_US", "PHASES", "SHORTEST_RPI_US"]
__all__ += ["Action", "Agenda", "Duration", "Kind", "Snapshot", "Timing"]

#: Names under which a phase can be given: controller cycle, packets to the robot and to the
#: PLC, PLC scan.
PHASES = ("cycle", "to_robot", "to_plc", "scan")

#: Packet intervals: the range of the vendor's earlier adapter [us].
SHORTEST_RPI_US, LONGEST_RPI_US = 1_000, 3_200_000

Duration = str | int | timedelta


class Kind(IntEnum):
    """What can happen, in the order in which it happens at equal times."""

    STIMULUS = 0
    CYCLE = 1
    PRODUCE_TO_PLC = 2
    PRODUCE_TO_ROBOT = 3
    DELIVER = 4
    SCAN = 5


@dataclass(frozen=True)
class Timing:
    """Periods and phases of a cell, all in microseconds.

    Attributes:
        scan_us: Period of the PLC's scan.
        rpi_us: Requested packet interval, the same in both directions.
        jitter_us: A packet arrives 0 to this long after it was produced; the order is kept.
        timeout_us: Either side takes the connection as lost this long after its last packet.
        phases: First occurrence of each clock, in the order of `PHASES`.
    """

    scan_us: int
    rpi_us: int
    jitter_us: int
    timeout_us: int
    phases: tuple[int, int, int, int] = (0, 0, 0, 0)

    @classmethod
    def make(
        cls,
        *,
        scan: Duration = "10ms",
        rpi: Duration = "10ms",
        jitter: Duration = 0,
        timeout: Duration | None = None,
        phases: str | Mapping[str, Duration] = "zero",
        seed: int = 0,
    ) -> Timing:
        """Check and convert what a user gave.

        Args:
            scan: Period of the scan, 100 us to 10 s.
            rpi: Packet interval, 1 ms to 3.2 s.
            jitter: Greatest delay of a packet, up to 10 s.
            timeout: Default: the longer of 4 RPI (the scanner's usual multiplier) and 100 ms.
            phases: `"zero"`, `"random"` (drawn from the seed), or some of `PHASES` with a time.
            seed: Seed of the drawn phases.

        Raises:
            InputError: a time out of its range, or an unknown phase.
        """
        scan_us = _within("the scan", scan, 100, 10_000_000)
        rpi_us = _within("the RPI", rpi, SHORTEST_RPI_US, LONGEST_RPI_US)
        jitter_us = _within("the jitter", jitter, 0, 10_000_000)
        default = max(4 * rpi_us, 100_000)
        timeout_us = default if timeout is None else _within("the time-out", timeout, 1_000, 10**9)
        periods = (CYCLE_US, rpi_us, rpi_us, scan_us)
        if phases == "zero":
            drawn = (0, 0, 0, 0)
        elif phases == "random":
            random = Random(f"phases {seed}")
            drawn = tuple(random.randrange(period) for period in periods)  # type: ignore[assignment]
        elif isinstance(phases, str):
            raise InputError(
                f"unknown phases: {phases!r}", hint="use zero, random, or scan=3ms,to_robot=1ms"
            )
        else:
            drawn = _named(phases, periods)
        return cls(scan_us, rpi_us, jitter_us, timeout_us, drawn)

    def with_rpi(self, rpi_us: int) -> Timing:
        """Return the same with another packet interval (InputError: it is out of its range)."""
        return replace(self, rpi_us=whole("rpi_us", rpi_us, SHORTEST_RPI_US, LONGEST_RPI_US))


def _within(what: str, value: Duration, low: int, high: int) -> int:
    try:
        given = parse_us(value)
    except InputError as error:
        span = f"{what} can be {format_us(low)} to {format_us(high)}"
        raise InputError(f"{what}: {error.message}", hint=span) from None
    if not low <= given <= high:
        raise InputError(
            f"{what} is {format_us(given)}; it must be {format_us(low)} to {format_us(high)}"
        )
    return given


def _named(
    phases: Mapping[str, Duration], periods: tuple[int, int, int, int]
) -> tuple[int, int, int, int]:
    for name in phases:
        if name not in PHASES:
            raise InputError(f"unknown phase {name!r}", hint="phases are " + ", ".join(PHASES))
    cycle, to_robot, to_plc, scan = (
        _within(f"the phase of {name}", phases.get(name, 0), 0, period - 1)
        for name, period in zip(PHASES, periods, strict=True)
    )
    return cycle, to_robot, to_plc, scan


#: What happens at an event; it is given the time.
Action = Callable[[int], None]

#: State of an agenda, for `Agenda.restore`.
Snapshot = tuple[tuple[Any, ...], int, dict[int, int]]


class Agenda:
    """What happens next in a cell: a queue ordered by time, then by `Kind`, then by controller.

    Of one controller's events of a kind the first come is the first served.

    Attributes:
        periods: How long after one event of a kind the next one comes by itself; 0 for never.
    """

    def __init__(self) -> None:
        self.periods: dict[int, int] = dict.fromkeys(Kind, 0)
        self._queue: list[tuple[int, int, int, int, Action]] = []
        self._count = 0

    @property
    def notice(self) -> str:
        """Something to tell at the end of a run; in virtual time there is nothing."""
        return ""

    def add(self, t_us: int, kind: Kind, action: Action, controller: int = 1) -> None:
        """Let `action` happen at `t_us`."""
        self._count += 1
        heappush(self._queue, (t_us, kind, controller, self._count, action))

    def repeat(
        self, t_us: int, kind: Kind, period_us: int, action: Action, controller: int = 1
    ) -> None:
        """Let `action` happen at `t_us` and every `period_us`, the same for all of its kind."""
        self.periods[kind] = period_us
        self.add(t_us, kind, action, controller)

    def delay(self, kind: Kind, late_us: int) -> None:
        """Let the next events of a kind, and with them all that follow, come later."""
        self._queue = [
            (t_us + late_us * (one == kind), one, controller, number, action)
            for t_us, one, controller, number, action in self._queue
        ]
        heapify(self._queue)

    def first(self) -> tuple[int, int]:
        """Time and kind of the next event; an agenda of a cell is never empty."""
        return self._queue[0][:2]

    def pop(self) -> tuple[int, Action]:
        """Take the next event: its time and what happens."""
        t_us, kind, controller, number, action = self._queue[0]
        if period_us := self.periods[kind]:
            heapreplace(self._queue, (t_us + period_us, kind, controller, number, action))
        else:
            heappop(self._queue)
        return t_us, action

    def snapshot(self) -> Snapshot:
        """All that is pending."""
        return tuple(self._queue), self._count, dict(self.periods)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to what `snapshot` gave."""
        queue, self._count, periods = snapshot
        self._queue, self.periods = list(queue), dict(periods)
