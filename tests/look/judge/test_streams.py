"""Frames are read from TCP segments that are repeated, late, split or missing."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from enip_frames import frame
from rcx_harness.look.judge.capture import Packet
from rcx_harness.look.judge.streams import Streams

SYN, FIN, ACK = 0x02, 0x01, 0x10
ONE = frame(0x6F, b"first one")
TWO = frame(0x6F, b"second")
THREE = frame(0x65, b"the third of them")


def _segment(sequence: int, payload: bytes, flags: int = ACK, port: int = 50000) -> Packet:
    ends = (b"\x0a\0\0\1", port, b"\x0a\0\0\2", 44818)
    return Packet(0, 1, True, *ends, payload, False, sequence & 0xFFFFFFFF, flags)


def _data(streams: Streams, segments: Iterable[Packet]) -> list[bytes]:
    return [frame.data for one in segments for frame in streams.take(one)]


@pytest.mark.parametrize("first", [0, 1000, 0xFFFFFFF0])
def test_frames_are_read_whole_from_any_segments(first: int) -> None:
    """Frames are read whole, at whatever bytes the TCP segments divide them.

    Sequence numbers wrap at 32 bits.

    Source: RFC 9293, 3.4.
    """
    stream = ONE + TWO + THREE
    for size in (1, 7, 24, 40, len(stream)):
        segments = [
            _segment(first + 1 + at, stream[at : at + size]) for at in range(0, len(stream), size)
        ]
        found = _data(Streams(), [_segment(first, b"", SYN), *segments])
        assert found == [b"first one", b"second", b"the third of them"]


def test_a_repeated_segment_is_used_once_and_a_late_segment_in_order() -> None:
    """Source: RFC 9293, 3.10.7.4: bytes that were already received are removed."""
    at_two, at_three = 100 + len(ONE), 100 + len(ONE) + len(TWO)
    segments = [_segment(100, ONE), _segment(100, ONE), _segment(at_three, THREE),
                _segment(100 + 10, (ONE + TWO)[10:]), _segment(at_two, TWO)]  # fmt: skip
    streams = Streams()
    assert _data(streams, segments) == [b"first one", b"second", b"the third of them"]
    assert streams.gaps == 0


def test_behind_a_segment_that_never_comes_the_stream_is_taken_up_again() -> None:
    streams = Streams()
    assert _data(streams, [_segment(100, ONE)]) == [b"first one"]
    behind = 100 + len(ONE) + len(TWO)
    later = [_segment(behind + k * len(THREE), THREE) for k in range(40)]
    assert _data(streams, later) == [b"the third of them"] * 40
    assert streams.gaps == 1


def test_a_capture_that_begins_in_the_middle_of_a_frame_goes_on_at_the_next() -> None:
    streams = Streams()
    assert _data(streams, [_segment(500, ONE[11:])]) == []
    assert _data(streams, [_segment(500 + len(ONE) - 11, TWO)]) == [b"second"]


def test_each_direction_of_each_connection_is_by_itself() -> None:
    streams = Streams()
    halves = [_segment(1, ONE[:20], port=1), _segment(1, TWO[:20], port=2)]
    rest = [_segment(21, TWO[20:], port=2), _segment(21, ONE[20:], port=1)]
    assert _data(streams, halves + rest) == [b"second", b"first one"]


def test_a_new_connection_of_the_same_ports_begins_anew() -> None:
    streams = Streams()
    begun = [_segment(1, ONE[:30]), _segment(70, b"", SYN), _segment(71, TWO)]
    assert _data(streams, begun) == [b"second"]
    ended = [_segment(200, ONE[:30], FIN | ACK), _segment(9000, TWO)]
    assert _data(Streams(), ended) == [b"second"]


def test_memory_does_not_grow_with_incomplete_frames() -> None:
    """Connections with incomplete frames use limited memory: the oldest connections are dropped.

    A frame has 64 KiB at most. The test opens 2,000 connections with half a frame each.
    """
    streams = Streams()
    for port in range(2000):
        assert _data(streams, [_segment(1, ONE[:30], port=port)]) == []
    rest = [_segment(31, ONE[30:], port=port) for port in (1999, 0)]
    assert _data(streams, rest) == [b"first one"]
