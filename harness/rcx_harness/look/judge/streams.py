"""Encapsulation frames from captured TCP segments, which may be repeated, late or missing."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator

from rcx_harness.enip.codec.encapsulation import Command, Frame, decode_header, next_frame
from rcx_harness.look.judge.capture import Packet

__all__ = ["Streams"]

_FIN, _SYN, _RST = 0x01, 0x02, 0x04
_COMMANDS = set(Command)
_NUMBERS = 0xFFFFFFFF
_HALF = 0x80000000
#: Greatest number of stored directions of connections, and of segments that wait for earlier
#: segments.
_MOST_STREAMS, _MOST_WAITING = 512, 32
_LONGEST = 0xFFFF


class Streams:
    """All TCP connections of a capture, each direction separately.

    A capture may begin in the middle of a connection, and it may lack segments. In both cases the
    data up to the next segment that begins a frame are skipped.

    Attributes:
        gaps: How often segments were missing. The stream continues after each gap.
    """

    def __init__(self) -> None:
        self.gaps = 0
        self._streams: OrderedDict[tuple[bytes, int, bytes, int], _Stream] = OrderedDict()

    def take(self, packet: Packet) -> Iterator[Frame]:
        """Add a segment, and yield the frames that it completes."""
        key = (packet.source, packet.source_port, packet.destination, packet.destination_port)
        if packet.flags & _SYN:
            self._streams.pop(key, None)
        stream = self._streams.get(key)
        if stream is None:
            first = packet.sequence + bool(packet.flags & _SYN) & _NUMBERS
            stream = self._streams[key] = _Stream(first)
            if len(self._streams) > _MOST_STREAMS:
                self._streams.popitem(last=False)
        self._streams.move_to_end(key)
        if packet.payload:
            self.gaps += stream.take(packet.sequence, packet.payload)
            yield from stream.frames()
        if packet.flags & (_FIN | _RST):
            self._streams.pop(key, None)


class _Stream:
    """The bytes of one direction of a TCP connection, put into order."""

    def __init__(self, first: int) -> None:
        self._next = first
        self._buffer = bytearray()
        # Position in the buffer at which the latest segment begins. A frame may begin there, so
        # older data are dropped only up to this position.
        self._latest = 0
        self._waiting: dict[int, bytes] = {}

    def take(self, sequence: int, payload: bytes) -> bool:
        """Add a segment. Return True if missing earlier segments are no longer awaited."""
        gap = False
        ahead = (sequence - self._next) & _NUMBERS
        if 0 < ahead < _HALF:
            self._waiting[sequence] = payload
            if len(self._waiting) <= _MOST_WAITING:
                return False
            gap = True
            sequence = min(self._waiting, key=lambda one: (one - self._next) & _NUMBERS)
            payload = self._waiting.pop(sequence)
            self._next, self._buffer = sequence, bytearray()
        self._append(sequence, payload)
        while (due := next(filter(self._is_due, self._waiting), None)) is not None:
            self._append(due, self._waiting.pop(due))
        return gap

    def frames(self) -> Iterator[Frame]:
        """Yield complete frames and remove them.

        If data are not a frame, drop them up to the latest segment.
        """
        while (head := decode_header(self._buffer)) is not None:
            frame, length = head
            if frame.command not in _COMMANDS or frame.options or length > _LONGEST:
                del self._buffer[: self._latest or len(self._buffer)]
                self._latest = 0
                continue
            before, whole = len(self._buffer), next_frame(self._buffer)
            if whole is None:
                return
            self._latest = max(0, self._latest - before + len(self._buffer))
            yield whole

    def _is_due(self, sequence: int) -> bool:
        return (self._next - sequence) & _NUMBERS < _HALF

    def _append(self, sequence: int, payload: bytes) -> None:
        # number of bytes of the segment that an earlier segment has already contained
        known = (self._next - sequence) & _NUMBERS
        if known < len(payload):
            self._latest = len(self._buffer)
            self._buffer += payload[known:]
            self._next = (sequence + len(payload)) & _NUMBERS
