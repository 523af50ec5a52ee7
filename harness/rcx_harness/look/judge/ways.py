"""One direction of a class 1 connection in a capture: the order and the number of its packets."""

from __future__ import annotations

import struct
from typing import NamedTuple

from rcx_harness.enip.cyclic.connections import RUN_IDLE_SIZE, SEQUENCE_SIZE
from rcx_harness.enip.cyclic.exchange import Packet

__all__ = ["Arrival", "Way"]

_COUNT = struct.Struct("<H")
_NUMBERS, _HALF = 0xFFFFFFFF, 0x80000000
#: Number of the latest sequence numbers that are stored. A number before these can be neither late
#: nor doubled.
_KNOWN = 64
#: A larger jump forward counts as a restart of the sequence numbers. So does this number of old
#: numbers in succession.
_FARTHEST, _MOST_OLD = 1_000_000, 8


class Arrival(NamedTuple):
    """An accepted packet: its data, the run state, and the number of lost packets before it."""

    data: bytes
    run: bool
    gap: bool


class Way:
    """The judgement of the packets of a connection id by their sequence numbers of 32 bits.

    Args:
        size: Bytes of data; None: packets are only counted.
        header: Whether a run/idle header precedes the data.
        timeout_us: A longer silence ends the connection. 0 if the time-out is unknown.

    Attributes:
        lost: Number of sequence numbers that never arrived.
        doubled: Number of packets that repeat a sequence number.
        late: Number of packets that arrived after a newer packet. A receiver ignores these packets
            as well.
        restarts: How often the sequence numbers began anew.
        cut: Number of packets that the capture contains only in part.
        wrong: Number of packets whose length differs from the agreed length.
        stale: Number of packets with new data but the sequence count (16 bits) of the packet
            before.
        longest_us: The longest time between two packets.
    """

    def __init__(self, size: int | None, header: bool, timeout_us: int = 0) -> None:
        self.size, self.timeout_us = size, timeout_us
        self._data_at = SEQUENCE_SIZE + (RUN_IDLE_SIZE if header else 0)
        self._header = header
        self.packets = self.lost = self.doubled = self.late = self.restarts = 0
        self.cut = self.wrong = self.stale = self.longest_us = 0
        self.first_us: int | None = None
        self.last_us = 0
        self.silent_us = 0
        """Length of the silence before this packet, if longer than the time-out; else 0."""
        self._newest: int | None = None
        self._seen = self._old = 0
        self._count = -1
        self._data = b""

    def take(self, t_us: int, packet: Packet, cut: bool) -> Arrival | None:
        """Judge the next packet. Return None if its data cannot be used.

        If `cut` is True, the capture contains only a part of the packet.
        """
        self.packets += 1
        passed_us = 0 if self.first_us is None else t_us - self.last_us
        self.first_us = t_us if self.first_us is None else self.first_us
        self.last_us = t_us
        self.longest_us = max(self.longest_us, passed_us)
        self.silent_us = passed_us if 0 < self.timeout_us < passed_us else 0
        missing = self._order(packet.number)
        if missing is None or self.size is None:
            return None
        content = packet.content
        if content is None or len(content) != self._data_at + self.size:
            if cut:
                self.cut += 1
            else:
                self.wrong += 1
            return None
        (count,) = _COUNT.unpack_from(content)
        data = content[self._data_at :]
        self.stale += count == self._count and data != self._data
        self._count, self._data = count, data
        run = not self._header or bool(content[SEQUENCE_SIZE] & 1)
        return Arrival(data, run, missing > 0 or self.silent_us > 0)

    def _order(self, number: int) -> int | None:
        """Return how many sequence numbers are missing before `number`.

        Return None if `number` is not newer than all earlier numbers.
        """
        newest, self._newest = self._newest, number
        if newest is None:
            self._seen = 1
            return 0
        ahead = (number - newest) & _NUMBERS
        if 0 < ahead < _FARTHEST:
            self._seen = (self._seen << ahead | 1) & ((1 << _KNOWN) - 1) if ahead < _KNOWN else 1
            self.lost += ahead - 1
            self._old = 0
            return ahead - 1
        back = -ahead & _NUMBERS
        if back < _KNOWN:
            self._newest = newest
            if self._seen >> back & 1:
                self.doubled += 1
            else:
                self._seen |= 1 << back
                self.late += 1
                self.lost = max(0, self.lost - 1)
            return None
        self._old += 1
        if back < _HALF and self._old < _MOST_OLD:
            self._newest = newest
            self.late += 1
            return None
        self.restarts += 1
        self.late -= min(self._old - 1, self.late)
        self._seen, self._old = 1, 0
        return 1
