"""The events of the adapter's processes: connections, refusals, drops, signs of life."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol

from rcx_harness.enip.cyclic.connections import ConnectionKind, OwnerState
from rcx_harness.enip.cyclic.journal import ConnectionEvent, Journal, RefusedOpen
from rcx_harness.enip.cyclic.shared import Drop, Status, Word, drops_text
from rcx_harness.serve.news import News, event_text
from rcx_harness.serve.watchdog import Watchdog

__all__ = ["DROPS_EVERY_US", "NetworkJournals", "NetworkNews"]

DROPS_EVERY_US = 5_000_000
"""Shortest time between two reports of dropped packets."""

#: Time for which a refusal is shown next to the state of the connection.
_REFUSED_FOR_US = 60_000_000
#: Processes with a sign of life in the shared memory.
_PARTS: dict[Literal[Word.CYCLIC_ALIVE, Word.ADAPTER_ALIVE], str] = {
    Word.ADAPTER_ALIVE: "the process of the EtherNet/IP adapter",
    Word.CYCLIC_ALIVE: "the process of the cyclic I/O",
}


class NetworkJournals(Protocol):
    """The members of `rcx_harness.enip.cyclic.shared.SharedImages` that this module uses."""

    @property
    def events(self) -> Journal:
        """Return the journal of changes of connections."""

    @property
    def refusals(self) -> Journal:
        """Return the journal of refused connections."""

    def status(self) -> Status:
        """Return the state of the cyclic connections."""

    def heard_us(self, part: Literal[Word.CYCLIC_ALIVE, Word.ADAPTER_ALIVE]) -> int:
        """Return the time of a process's last sign of life; 0: none yet."""


class NetworkNews:
    """A converter of the journals of the adapter's processes into events.

    Attributes:
        refused: The last refused connection, as a sentence; empty after a minute, or if a master
            has connected since.
    """

    def __init__(self, network: NetworkJournals, news: News) -> None:
        self._network, self._news = network, news
        self.refused = ""
        self._refused_us = 0
        self._drops: Sequence[int] = (0,) * len(Drop)
        self._drops_at_opening = self._drops
        self._drops_told_us = -DROPS_EVERY_US
        self._watchdogs = {part: Watchdog() for part in _PARTS}

    def look(self, now_us: int, begin_us: int) -> None:
        """Read the journals, and add their entries to the events.

        `begin_us` is the controller's time 0 on the clock of the adapter's processes.
        """

        def time_of(at_us: int) -> int:
            return max(0, min(at_us - begin_us, now_us))

        events, lost = self._network.events.read()
        for record in events:
            event = ConnectionEvent.from_record(record)
            if event.kind is ConnectionKind.EXCLUSIVE_OWNER and event.state == "waiting":
                self.refused = ""
                self._drops_at_opening = self._network.status().drops
            kind, text = event_text(event)
            if text:
                self._news.note(time_of(event.at_us), kind, text)
        refusals, lost_refusals = self._network.refusals.read()
        for record in refusals:
            refusal = RefusedOpen(**record)
            self.refused, self._refused_us = refusal.text, now_us
            self._news.note(time_of(refusal.at_us), "refused", refusal.text)
        if self.refused and now_us - self._refused_us >= _REFUSED_FOR_US:
            self.refused = ""
        for number, what in ((lost, "changes of connections"), (lost_refusals, "refusals")):
            if number:
                text = f"{number} {what} are not shown: there were too many at once"
                self._news.note(now_us, "lost", text)

    def note_drops(self, network: Status, now_us: int) -> None:
        """Report newly dropped packets, at most once every `DROPS_EVERY_US`."""
        if network.drops == self._drops or now_us - self._drops_told_us < DROPS_EVERY_US:
            return
        text = drops_text(network, _difference(network.drops, self._drops))
        self._drops, self._drops_told_us = network.drops, now_us
        self._news.note(now_us, "dropped", f"packets dropped: {text}")

    def untaken(self, network: Status) -> str:
        """Return the packets dropped since a waiting master has opened its connection, as text."""
        if network.owner is not OwnerState.WAITING:
            return ""
        return drops_text(network, _difference(network.drops, self._drops_at_opening))

    def stalled(self, now_us: int) -> tuple[str, ...]:
        """Return the processes that give no sign of life."""
        for part, watchdog in self._watchdogs.items():
            watchdog.look(self._network.heard_us(part), now_us)
        silent = [part for part, one in self._watchdogs.items() if one.silent_since_us is not None]
        return tuple(_PARTS[part] for part in silent)


def _difference(drops: Sequence[int], before: Sequence[int]) -> tuple[int, ...]:
    return tuple(now - then for now, then in zip(drops, before, strict=True))
