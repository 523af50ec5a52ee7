"""The packets of one class 1 connection, one way: made by a producer, judged by a consumer.

A packet is two items of the common packet format: the sequenced address (connection id, sequence
number of 32 bits, counted with every packet) and the connected data (sequence count of 16 bits,
counted with new data only; from the originator the run/idle header of 32 bits; the data). Rules:
CIP volume 1, chapter 3, transport class 1; EtherNet/IP adaptation (volume 2), chapter 3.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from rcx_harness.enip.cyclic.connections import FIRST_PACKET_US, LONGEST_TIMEOUT_US

__all__ = ["Arrival", "Consumer", "Packet", "Producer", "decode_packet"]

_SEQUENCED_ADDRESS, _CONNECTED_DATA = 0x8002, 0x00B1
# Number of items; type, length, connection id, sequence number; type, length.
_HEADER = struct.Struct("<HHHIIHH")
_NUMBER = struct.Struct("<I")
_NUMBER_AT = 10
_COUNT = struct.Struct("<H")
_RUN_IDLE = struct.Struct("<I")
_RUN = 1


@dataclass(frozen=True)
class Packet:
    """One packet, taken apart.

    Attributes:
        connection_id: Whose it is.
        number: Its sequence number of 32 bits.
        content: Its connected data; None if the item's length is not that of the datagram.
    """

    connection_id: int
    number: int
    content: bytes | None


def decode_packet(datagram: bytes) -> Packet | None:
    """Take a datagram apart; None if it is not a packet of class 1."""
    if len(datagram) < _HEADER.size:
        return None
    items, address, size, identifier, number, kind, length = _HEADER.unpack_from(datagram)
    if (items, address, size, kind) != (2, _SEQUENCED_ADDRESS, 8, _CONNECTED_DATA):
        return None
    content = datagram[_HEADER.size :]
    return Packet(identifier, number, content if len(content) == length else None)


class Producer:
    """Makes the packets of one connection id, one every interval.

    Args:
        connection_id: Goes into every packet.
        size: Bytes of data in it, without sequence count and header.
        run_idle: The packets carry the run/idle header.
        api_us: Interval in microseconds.
        first_us: When the first packet is due.

    Attributes:
        due_us: When the next packet is due.
    """

    def __init__(
        self, connection_id: int, size: int, run_idle: bool, api_us: int, first_us: int
    ) -> None:
        self.api_us = api_us
        self.due_us = first_us
        self._size = size
        self._run_idle = run_idle
        length = _COUNT.size + (_RUN_IDLE.size if run_idle else 0) + size
        self._packet = bytearray(_HEADER.size + length)
        _HEADER.pack_into(
            self._packet, 0, 2, _SEQUENCED_ADDRESS, 8, connection_id, 0, _CONNECTED_DATA, length
        )
        self._number = self._count = 0
        self._last: tuple[int, bool] | None = None

    def is_new(self, version: int, run: bool) -> bool:
        """Has the application written since the last packet, or its program stopped or started?"""
        return self._last != (version, run)

    def renew(self, image: bytes, version: int, run: bool) -> None:
        """Take new data over: its first `size` bytes."""
        self._last = (version, run)
        self._count = (self._count + 1) & 0xFFFF
        _COUNT.pack_into(self._packet, _HEADER.size, self._count)
        at = _HEADER.size + _COUNT.size
        if self._run_idle:
            _RUN_IDLE.pack_into(self._packet, at, _RUN if run else 0)
            at += _RUN_IDLE.size
        self._packet[at:] = image[: self._size]

    def packet(self) -> bytes:
        """The next packet."""
        self._number = (self._number + 1) & 0xFFFFFFFF
        _NUMBER.pack_into(self._packet, _NUMBER_AT, self._number)
        return bytes(self._packet)

    def advance(self, now_us: int) -> int:
        """Set the time of the next packet: the interval's next one, never one that has passed.

        Returns:
            How many packets fell out because their time had passed.
        """
        skipped = max(0, now_us - self.due_us) // self.api_us
        self.due_us += (skipped + 1) * self.api_us
        return skipped


@dataclass(frozen=True)
class Arrival:
    """A packet that was taken.

    Attributes:
        data: The application's data; None where it brings none: a repetition, or idle.
        run: The other side's program runs.
        missing: So many packets before it never came.
    """

    data: bytes | None
    run: bool
    missing: int


class Consumer:
    """Judges the packets of one connection id.

    Args:
        size: Bytes of data expected; 0: a heartbeat, with or without a sequence count.
        run_idle: The packets carry the run/idle header.
        timeout_us: Longest silence; the first packet has at least 10 s.
        now_us: The connection is opened now.
        first_us: Longest wait for the first packet, where the time-out is longer.

    Attributes:
        deadline_us: The connection is lost at this time if no packet comes.
    """

    def __init__(
        self,
        size: int,
        run_idle: bool,
        timeout_us: int,
        now_us: int,
        first_us: int = LONGEST_TIMEOUT_US,
    ) -> None:
        self.deadline_us = now_us + min(max(timeout_us, FIRST_PACKET_US), first_us)
        self._size = size
        self._run_idle = run_idle
        self._timeout_us = timeout_us
        self._data_at = _COUNT.size + (_RUN_IDLE.size if run_idle else 0)
        lengths = {self._data_at + size}
        self._lengths = lengths if size else lengths | {0, _COUNT.size}
        self._number: int | None = None
        self._count: int | None = None

    def take(self, number: int, content: bytes, now_us: int) -> Arrival | None:
        """Take a packet of this connection.

        Args:
            number: Its sequence number of 32 bits.
            content: Its connected data.
            now_us: It arrived now.

        Returns:
            None for a wrong length or an old sequence number; time runs on then.
        """
        if len(content) not in self._lengths:
            return None
        missing = 0
        if self._number is not None:
            ahead = (number - self._number) & 0xFFFFFFFF
            if not 0 < ahead < 0x80000000:
                return None
            missing = ahead - 1
        self._number = number
        self.deadline_us = now_us + self._timeout_us
        if not self._size:
            return Arrival(None, True, missing)
        run = not self._run_idle or bool(content[_COUNT.size] & _RUN)
        if not run:
            # What comes first after it is new, whatever its count.
            self._count = None
            return Arrival(None, False, missing)
        (count,) = _COUNT.unpack_from(content)
        data = content[self._data_at :] if count != self._count else None
        self._count = count
        return Arrival(data, True, missing)
