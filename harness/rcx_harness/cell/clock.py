"""The three clocks of a cell on one virtual time: PLC scan, packets, controller cycle.

At equal times the order is fixed: actions of the test or the stimulus, controller cycles, packets
produced, packets delivered, PLC scan. A run is therefore the same on every machine.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from random import Random

from rcx_harness.spec.wire import CYCLE_US
from structured_text.bench import agenda
from structured_text.bench.agenda import Duration
from structured_text.errors import InputError
from structured_text.output.units import whole, within_us

__all__ = ["LONGEST_RPI_US", "PHASES", "SHORTEST_RPI_US", "Kind", "Timing"]

#: Names of the phases: controller cycle, packets to the robot, packets to the PLC, PLC scan.
PHASES = ("cycle", "to_robot", "to_plc", "scan")

#: Packet intervals: the range of the vendor's earlier adapter [us].
SHORTEST_RPI_US, LONGEST_RPI_US = 1_000, 3_200_000


class Kind(IntEnum):
    """The kinds of events on the virtual clock, in the order in which they run at equal times."""

    STIMULUS = agenda.STIMULUS
    CYCLE = 1
    PRODUCE_TO_PLC = 2
    PRODUCE_TO_ROBOT = 3
    DELIVER = 4
    SCAN = agenda.SCAN


@dataclass(frozen=True)
class Timing:
    """Periods and phases of a cell, all in microseconds.

    Attributes:
        rpi_us: Requested packet interval, the same in both directions.
        jitter_us: Greatest delay of a packet; the order of the packets does not change.
        timeout_us: Time after the last packet at which a side considers the connection lost.
        phases: Time of the first event of each clock, in the order of `PHASES`.
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
        """Check and convert the times that a user gave.

        Args:
            scan: Period of the scan, 100 us to 10 s.
            rpi: Packet interval, 1 ms to 3.2 s.
            jitter: Greatest delay of a packet, up to 10 s.
            timeout: Default: the longer of 4 RPI (the scanner's usual multiplier) and 100 ms.
            phases: `"zero"`, `"random"` (drawn from the seed), or some of `PHASES` with a time.
            seed: Seed of the drawn phases.
        """
        scan_us = agenda.scan_us(scan)
        rpi_us = within_us("the RPI", rpi, SHORTEST_RPI_US, LONGEST_RPI_US)
        jitter_us = within_us("the jitter", jitter, 0, 10_000_000)
        default = max(4 * rpi_us, 100_000)
        timeout_us = (
            default if timeout is None else within_us("the time-out", timeout, 1_000, 10**9)
        )
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
        """Return a copy of the timing with another packet interval."""
        return replace(self, rpi_us=whole("rpi_us", rpi_us, SHORTEST_RPI_US, LONGEST_RPI_US))


def _named(
    phases: Mapping[str, Duration], periods: tuple[int, int, int, int]
) -> tuple[int, int, int, int]:
    for name in phases:
        if name not in PHASES:
            raise InputError(f"unknown phase {name!r}", hint="phases are " + ", ".join(PHASES))
    cycle, to_robot, to_plc, scan = (
        within_us(f"the phase of {name}", phases.get(name, 0), 0, period - 1)
        for name, period in zip(PHASES, periods, strict=True)
    )
    return cycle, to_robot, to_plc, scan
