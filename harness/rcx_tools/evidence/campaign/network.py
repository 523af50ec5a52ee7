"""A network that loses packets, delays and doubles them, and whose packet interval changes."""

from __future__ import annotations

from hashlib import blake2b

from rcx_harness.cell.clock import Action, Agenda, Kind, Timing
from rcx_harness.cell.link import DirectLink, PacketNetwork
from rcx_harness.spec.wire import SIZE

__all__ = ["BOTH", "FaultAgenda", "FaultLink", "FaultNetwork"]

#: To the robot, to the PLC.
BOTH = (0, 1)


class FaultAgenda(Agenda):
    """The clock of a PLC whose next scan may be late."""

    overrun_us = 0

    def pop(self) -> tuple[int, Action]:
        """Take the next event; the scan after one that overruns comes later."""
        late_us = self.overrun_us if self.first()[1] == Kind.SCAN else 0
        self.overrun_us -= late_us
        self.periods[Kind.SCAN] += late_us
        event = super().pop()
        self.periods[Kind.SCAN] -= late_us
        return event


class FaultNetwork(PacketNetwork):
    """Cyclic packets with faults that are switched on for a while.

    What becomes of a packet depends on the seed and on its time alone, so that a run stays the
    same before a fault that is taken out.

    Args:
        link: The two images.
        timing: Periods of the run.
        agenda: Of the cell.
        matched: As at `PacketNetwork`.
        seed: Of all that is drawn.
        latest_us: No packet arrives later than this after it was produced, whatever happens.
    """

    def __init__(
        self,
        link: DirectLink,
        timing: Timing,
        agenda: Agenda,
        *,
        matched: bool,
        seed: int,
        latest_us: int,
    ) -> None:
        super().__init__(link, timing, agenda, matched=matched, seed=seed)
        self._seed = seed
        self._latest_us = latest_us
        self._faults: dict[tuple[str, int], tuple[float, int]] = {}
        self.lost = self.late = self.doubled = 0

    def fault(self, kind: str, direction: int, share: float, until_us: int) -> None:
        """Let `share` of the packets of a direction be `lost`, `late` or `doubled`."""
        self._faults[kind, direction] = (share, until_us)

    def change_interval(self, timing: Timing) -> None:
        """Another packet interval, from the next packet on."""
        self._timing = timing
        for kind in (Kind.PRODUCE_TO_ROBOT, Kind.PRODUCE_TO_PLC):
            self._agenda.periods[kind] = timing.rpi_us

    def heal(self) -> None:
        """End all faults."""
        self._faults.clear()

    def _drawn(self, kind: str, direction: int, now_us: int) -> float:
        """A number below the share if the packet of this time is hit, else 0."""
        share, until_us = self._faults.get((kind, direction), (0.0, 0))
        if now_us >= until_us:
            return 0.0
        key = f"{kind} {direction} {now_us} {self._seed}".encode()
        draw = (int.from_bytes(blake2b(key, digest_size=4).digest(), "big") + 1) / 2**32
        return draw / share if draw < share else 0.0

    def _send(self, direction: int, now_us: int, content: bytes) -> None:
        if self._faults:
            if self._drawn("lost", direction, now_us):
                self.lost += 1
                return
            if late := self._drawn("late", direction, now_us):
                self.late += 1
                due_us = now_us + round(late * self._latest_us)
                self._due[direction] = max(due_us, self._due[direction])
        super()._send(direction, now_us, content)
        if self._faults and (twice := self._drawn("doubled", direction, now_us)):
            self.doubled += 1
            due_us = round(now_us + twice * self._latest_us)
            self._due[direction] = max(due_us, self._due[direction])
            self._queue(self._due[direction], direction, content)


class FaultLink(DirectLink):
    """Both images in one process, with a `FaultNetwork` between them.

    Args:
        timing: Periods of the run.
        seed: Of all that is drawn.
        latest_us: As at `FaultNetwork`.
        size: Bytes of each area.
    """

    def __init__(self, timing: Timing, seed: int, latest_us: int, size: int = SIZE) -> None:
        super().__init__(size)
        self._arguments = (timing, seed, latest_us)
        self.made: FaultNetwork | None = None

    def network(self, agenda: Agenda, *, matched: bool) -> FaultNetwork:
        """Its network in a cell."""
        timing, seed, latest_us = self._arguments
        self.made = FaultNetwork(
            self, timing, agenda, matched=matched, seed=seed, latest_us=latest_us
        )
        return self.made
