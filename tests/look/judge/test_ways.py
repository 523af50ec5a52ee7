"""The packets of one direction of a connection are checked.

The checks concern packet numbers, sequence counts, lengths, and pauses.
"""

from __future__ import annotations

import pytest

from rcx_harness.enip.cyclic.exchange import Packet
from rcx_harness.look.judge.ways import Arrival, Way


def _numbers(way: Way, numbers: list[int]) -> list[int]:
    """Pass packets with these numbers to the monitor, and return the numbers that it accepts."""
    used = []
    for at, number in enumerate(numbers):
        content = (at & 0xFFFF).to_bytes(2, "little") + at.to_bytes(4, "little")
        packet = Packet(7, number & 0xFFFFFFFF, content)
        if way.take(at * 10_000, packet, False) is not None:
            used.append(number)
    return used


@pytest.mark.parametrize("first", [1, 0xFFFFFFF0 - 6, 0x7FFFFFFA, 0xFFFA])
def test_packets_are_counted_as_lost_doubled_and_late(first: int) -> None:
    """Lost, doubled and late packets are counted: 4 comes after 5, 7 never, and 8 twice.

    The number of 32 bits may wrap in between.

    Source: EtherNet/IP adaptation of CIP (volume 2), chapter 3: a number is newer if it is
    ahead by less than half of all numbers.
    """
    way = Way(4, header=False)
    steps = [0, 1, 2, 3, 5, 4, 6, 8, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20]
    used = _numbers(way, [first + step for step in steps])
    assert used == [first + step for step in [0, 1, 2, 3, 5, 6, *range(8, 21)]]
    assert (way.packets, way.lost, way.doubled, way.late) == (21, 1, 1, 1)


def test_doubled_packets_are_not_lost() -> None:
    """A packet that is captured twice counts as doubled, not as lost.

    A mirror port of both directions, or the interface `any`, shows a packet twice.
    """
    way = Way(4, header=False)
    assert len(_numbers(way, [n for n in range(100) for _ in range(2)])) == 100
    assert (way.packets, way.lost, way.doubled, way.late) == (200, 0, 100, 0)


@pytest.mark.parametrize("begin", [1, 0x40000000])
def test_restarted_packet_numbers_are_accepted(begin: int) -> None:
    """If a restarted device continues with other numbers, the numbers between are not lost."""
    way = Way(4, header=False)
    used = _numbers(way, [*range(5000, 5020), *range(begin, begin + 40)])
    assert used[-30:] == list(range(begin + 10, begin + 40))
    assert (way.lost, way.late, way.restarts) == (0, 0, 1)


def test_new_data_come_with_the_gap_before_them() -> None:
    way = Way(2, header=True, timeout_us=40_000)

    def take(t_us: int, number: int, content: str) -> Arrival | None:
        return way.take(t_us, Packet(7, number, bytes.fromhex(content)), False)

    assert take(0, 1, "0100 01000000 AABB") == (b"\xaa\xbb", True, False)
    assert take(10_000, 2, "0100 00000000 AABB") == (b"\xaa\xbb", False, False)
    assert take(20_000, 4, "0200 01000000 AACC") == (b"\xaa\xcc", True, True)
    assert take(60_000, 5, "0200 01000000 AACC") == (b"\xaa\xcc", True, False)
    assert way.silent_us == 0
    assert take(100_001, 6, "0200 01000000 AACC") == (b"\xaa\xcc", True, True)
    assert way.silent_us == way.longest_us == 40_001


def test_the_sequence_count_wraps_and_stale_counts_are_reported() -> None:
    """The sequence count of 16 bits wraps, and new data with an old count are reported.

    The count changes with new data. After 0xFFFF comes 0.

    Source: CIP volume 1, chapter 3, transport class 1.
    """
    way = Way(1, header=False)
    contents = ["FEFF 01", "FFFF 02", "FFFF 02", "0000 03", "0000 04", "0100 05"]
    for number, content in enumerate(contents):
        assert way.take(0, Packet(7, number, bytes.fromhex(content)), False) is not None
    assert way.stale == 1


def test_other_lengths_are_no_data() -> None:
    way = Way(2, header=False)
    assert way.take(0, Packet(7, 1, bytes(5)), False) is None
    assert way.take(0, Packet(7, 2, None), True) is None
    assert way.take(0, Packet(7, 3, bytes(4)), False) == (bytes(2), True, False)
    assert (way.wrong, way.cut, way.lost) == (1, 1, 0)


def test_a_heartbeat_is_counted_whatever_is_in_it() -> None:
    way = Way(None, header=False)
    assert [way.take(0, Packet(7, n, bytes(n)), False) for n in range(3)] == [None] * 3
    assert (way.packets, way.lost, way.wrong) == (3, 0, 0)
