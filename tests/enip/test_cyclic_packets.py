"""Class 1 packets are sent and accepted byte by byte as specified.

A packet contains the number of items and two items. The sequenced address (0x8002, 8 bytes) has the
connection id and a sequence number of 32 bits. The connected data (0x00B1) have a sequence count of
16 bits, a run/idle header in one direction, and the data. All numbers are little endian.
"""

from __future__ import annotations

import pytest

from rcx_harness.enip.cyclic.exchange import Arrival, Consumer, Packet, Producer, decode_packet
from rcx_harness.enip.cyclic.shared import Drop

hexa = bytes.fromhex


def producer(size: int = 4, run_idle: bool = False, api_us: int = 10_000) -> Producer:
    return Producer(0x11223344, size, run_idle, api_us, first_us=0)


def consumer(size: int = 4, run_idle: bool = True, timeout_us: int = 160_000) -> Consumer:
    return Consumer(size, run_idle, timeout_us, now_us=0)


@pytest.mark.parametrize(
    ("size", "run_idle", "run", "content"),
    [
        pytest.param(4, False, False, "0600 0100 A1A2A3A4", id="the robot's: no header, modeless"),
        pytest.param(4, True, True, "0A00 0100 01000000 A1A2A3A4", id="a running master's"),
        pytest.param(4, True, False, "0A00 0100 00000000 A1A2A3A4", id="an idle master's"),
        pytest.param(0, False, True, "0200 0100", id="a heartbeat: the sequence count alone"),
    ],
)
def test_a_packet_carries_a_sequence_count_the_header_and_the_data(
    size: int, run_idle: bool, run: bool, content: str
) -> None:
    out = producer(size, run_idle)
    out.renew(hexa("A1A2A3A4"), version=1, run=run)
    assert out.packet() == hexa(f"0200 0280 0800 44332211 01000000 B100 {content}")


def test_the_long_count_counts_packets_and_the_short_count_new_data() -> None:
    out = producer()
    out.renew(hexa("A1A2A3A4"), version=1, run=False)
    assert [out.packet()[10:14], out.packet()[10:14]] == [hexa("01000000"), hexa("02000000")]
    assert out.packet()[18:] == hexa("0100 A1A2A3A4")
    out.renew(hexa("B1B2B3B4"), version=2, run=False)
    assert out.packet()[10:] == hexa("04000000 B100 0600 0200 B1B2B3B4")


def test_both_counts_wrap_to_zero() -> None:
    out = producer()
    for version in range(0xFFFF):
        out.renew(bytes(4), version, run=False)
    assert out.packet()[18:20] == hexa("FFFF")
    out.renew(bytes(4), 0x10000, run=False)
    assert out.packet()[18:20] == hexa("0000")
    out.number = 0xFFFFFFFE
    assert out.packet()[10:14] == hexa("FFFFFFFF")
    assert out.packet()[10:14] == hexa("00000000")


def test_data_are_new_after_a_write_or_a_change_of_run() -> None:
    out = producer(run_idle=True)
    assert out.is_new(version=0, run=True)
    out.renew(bytes(4), version=0, run=True)
    assert not out.is_new(version=0, run=True)
    assert out.is_new(version=1, run=True)
    assert out.is_new(version=0, run=False)


def test_packets_are_due_at_multiples_of_the_interval_however_late_each_is() -> None:
    out = producer(api_us=2_000)
    due = []
    for late in (0, 600, 1_900, 3):
        due.append(out.due_us)
        assert out.advance(out.due_us + late) == 0
    assert due == [0, 2_000, 4_000, 6_000]


@pytest.mark.parametrize(("now_us", "lost", "due_us"), [(2_000, 1, 4_000), (7_900, 3, 8_000)])
def test_after_a_stall_overdue_packets_are_left_out(now_us: int, lost: int, due_us: int) -> None:
    """After a stall, overdue packets are left out, and the next packet is sent at its own time."""
    out = producer(api_us=2_000)
    assert out.advance(now_us) == lost
    assert out.due_us == due_us


def test_a_datagram_is_decoded() -> None:
    datagram = hexa("0200 0280 0800 44332211 05000000 B100 0600 0100 A1A2A3A4")
    assert decode_packet(datagram) == Packet(0x11223344, 5, hexa("0100 A1A2A3A4"))


@pytest.mark.parametrize(
    "datagram",
    [
        "",
        # the packet ends within the header of its second item
        "0200 0280 0800 44332211 05000000 B100 06",
        "0100 0280 0800 44332211 05000000 B100 0600 0100 A1A2A3A4",  # one item
        "0300 0280 0800 44332211 05000000 B100 0600 0100 A1A2A3A4",  # three items
        # a connected address item instead of a sequenced one
        "0200 A100 0800 44332211 05000000 B100 0600 0100 A1A2A3A4",
        "0200 0280 0400 44332211 05000000 B100 0600 0100 A1A2A3A4",  # wrong length of the address
        # an unconnected data item instead of a connected one
        "0200 0280 0800 44332211 05000000 B200 0600 0100 A1A2A3A4",
    ],
)
def test_an_invalid_datagram_is_not_a_packet(datagram: str) -> None:
    assert decode_packet(hexa(datagram)) is None


@pytest.mark.parametrize("tail", ["0100 A1A2A3", "0100 A1A2A3A4 00"])
def test_a_length_that_is_not_the_datagrams_leaves_no_content(tail: str) -> None:
    datagram = hexa("0200 0280 0800 44332211 05000000 B100 0600" + tail)
    assert decode_packet(datagram) == Packet(0x11223344, 5, None)


@pytest.mark.parametrize(
    ("header", "run"),
    [("01000000", True), ("00000000", False), ("FEFFFFFF", False), ("FFFFFFFF", True)],
)
def test_only_data_of_a_running_master_are_used(header: str, run: bool) -> None:
    """Data are used only if bit 0 of the run/idle header is 1.

    The other bits are reserved or concern redundant owners.
    """
    taken = consumer().take(7, hexa(f"0100 {header} A1A2A3A4"), 0)
    assert taken == Arrival(hexa("A1A2A3A4") if run else None, run, 0)


def test_the_same_short_count_is_no_new_data_but_keeps_the_connection() -> None:
    into = consumer()
    assert into.take(7, hexa("0100 01000000 A1A2A3A4"), 0)
    assert into.take(8, hexa("0100 01000000 B1B2B3B4"), 5_000) == Arrival(None, True, 0)
    assert into.deadline_us == 165_000
    assert into.take(9, hexa("0200 01000000 B1B2B3B4"), 6_000) == Arrival(hexa("B1B2B3B4"), True, 0)


def test_the_first_data_after_idle_are_new_with_any_count() -> None:
    into = consumer()
    assert into.take(7, hexa("0100 01000000 A1A2A3A4"), 0)
    assert into.take(8, hexa("0100 00000000 B1B2B3B4"), 0) == Arrival(None, False, 0)
    assert into.take(9, hexa("0100 01000000 B1B2B3B4"), 0) == Arrival(hexa("B1B2B3B4"), True, 0)


@pytest.mark.parametrize(
    ("last", "number"),
    [
        (7, 7),
        (7, 6),
        (7, 0xFFFFFFF0),
        (0, 0xFFFFFFFF),
        (5, 0x80000005),
        (0x10, 0xFFFFFC10),  # the number minus 1,024, across the wrap-around
    ],
)
def test_a_packet_with_an_old_number_does_not_extend_the_time_out(last: int, number: int) -> None:
    into = consumer()
    into.take(last, hexa("0100 01000000 A1A2A3A4"), 1_000)
    assert into.take(number, hexa("0200 01000000 B1B2B3B4"), 50_000) is Drop.OLD
    assert into.deadline_us == 161_000


@pytest.mark.parametrize(
    ("last", "number"),
    [
        (7, 7 + 1025),
        (7, 0x70000000),
        (5, 0x80000004),  # the largest jump forwards; a larger one would count as an old number
        (0xFFFFFFFF, 1024),  # a jump across the wrap-around
        (0xFFFFFE00, 0x201),
    ],
)
def test_a_packet_whose_number_jumps_is_dropped(last: int, number: int) -> None:
    """A packet whose number jumps by 1,024 or more is ignored. The owner's next one is accepted.

    The limit of 1,024 is twice the longest time-out in packets, 512 intervals (CIP volume 1,
    chapter 3, 5.5.1).
    """
    into = consumer()
    into.take(last, hexa("0100 01000000 A1A2A3A4"), 1_000)
    assert into.take(number, hexa("0200 01000000 B1B2B3B4"), 50_000) is Drop.JUMP
    assert into.deadline_us == 161_000
    following = (last + 1) & 0xFFFFFFFF
    taken = into.take(following, hexa("0200 01000000 C1C2C3C4"), 60_000)
    assert taken == Arrival(hexa("C1C2C3C4"), True, 0)


def test_packets_that_overtake_each_other_are_taken_once_and_the_late_one_is_dropped() -> None:
    into = consumer()
    took = [
        into.take(number, bytes([number, 0]) + hexa("01000000 A1A2A3A4"), 0)
        for number in (1, 2, 4, 3, 5, 5)
    ]
    reasons = [one if isinstance(one, Drop) else one.missing for one in took]
    assert reasons == [0, 0, 1, Drop.OLD, 0, Drop.OLD]


def test_losses_shorter_than_the_time_out_do_not_end_the_connection() -> None:
    """If 511 packets are lost and the time-out is 512 intervals, the connection continues."""
    into = consumer(timeout_us=5_120_000)
    into.take(100, hexa("0100 01000000 A1A2A3A4"), 0)
    taken = into.take(612, hexa("0002 01000000 B1B2B3B4"), 5_119_000)
    assert taken == Arrival(hexa("B1B2B3B4"), True, 511)


@pytest.mark.parametrize("first", [0, 1, 0x70000000, 0xFFFFFFFF])
def test_a_connection_begins_with_any_sequence_number(first: int) -> None:
    """The first packet of a connection may have any sequence number.

    After a restart, a scanner begins with 0 or continues the old numbers.
    """
    taken = consumer().take(first, hexa("0000 01000000 A1A2A3A4"), 0)
    assert taken == Arrival(hexa("A1A2A3A4"), True, 0)


def test_the_short_count_may_wrap_and_jump() -> None:
    """Any other value of the 16-bit sequence count than the last one means new data."""
    into = consumer()
    into.take(1, hexa("FFFF 01000000 A1A2A3A4"), 0)
    for number, count in enumerate(("0000", "0500", "0200"), 2):
        taken = into.take(number, hexa(f"{count} 01000000 B1B2B3B4"), 0)
        assert taken == Arrival(hexa("B1B2B3B4"), True, 0)


@pytest.mark.parametrize(
    ("last", "number", "missing"),
    [
        *((7, 8, 0), (7, 10, 2), (0xFFFFFFFF, 0, 0), (0xFFFFFFFE, 1, 2), (7, 7 + 1024, 1023)),
        (0xFFFFFFFF, 1023, 1023),
    ],
)
def test_a_gap_of_the_sequence_number_is_counted_also_across_its_end(
    last: int, number: int, missing: int
) -> None:
    into = consumer()
    into.take(last, hexa("0100 01000000 A1A2A3A4"), 0)
    taken = into.take(number, hexa("0200 01000000 B1B2B3B4"), 0)
    assert taken == Arrival(hexa("B1B2B3B4"), True, missing)


@pytest.mark.parametrize(
    "content", ["", "0100", "0100 01000000", "0100 01000000 A1A2A3", "0100 01000000 A1A2A3A4A5"]
)
def test_another_length_is_dropped(content: str) -> None:
    into = consumer()
    assert into.take(7, hexa(content), 0) is Drop.LENGTH
    assert into.deadline_us == 10_000_000


@pytest.mark.parametrize("content", ["", "0100"])
def test_a_heartbeat_comes_with_or_without_its_count(content: str) -> None:
    into = consumer(size=0, run_idle=False)
    assert into.take(7, hexa(content), 5_000) == Arrival(None, True, 0)
    assert into.deadline_us == 165_000


def test_a_heartbeat_may_carry_the_header_if_that_was_agreed() -> None:
    arrival = Arrival(None, True, 0)
    assert consumer(size=0, run_idle=True).take(7, hexa("0100 00000000"), 0) == arrival
    assert consumer(size=0, run_idle=False).take(7, hexa("0100 00000000"), 0) is Drop.LENGTH


@pytest.mark.parametrize(
    ("timeout_us", "options", "first_us"),
    [
        (160_000, {}, 10_000_000),
        (1_638_400_000, {"first_us": 10_000_000}, 10_000_000),  # a time-out of 512 times 3.2 s
        (12_800_000, {}, 12_800_000),
    ],
)
def test_the_first_packet_has_ten_seconds_or_the_time_out_the_next_ones_the_time_out(
    timeout_us: int, options: dict[str, int], first_us: int
) -> None:
    into = Consumer(4, True, timeout_us, now_us=0, **options)
    assert into.deadline_us == first_us
    assert into.take(7, hexa("0100 01000000 A1A2A3A4"), 9_999_999)
    assert into.deadline_us == 9_999_999 + timeout_us
