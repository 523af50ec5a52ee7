"""Capture files are read: link types, tags and times. Packets of other protocols are counted."""

from __future__ import annotations

from pathlib import Path

import pytest

from captures import COOKED, COOKED_2, ETHERNET, LOOP, NULL, RAW, framed, ip, pcap, pcapng, tcp, udp
from rcx_harness.look.judge.capture import Capture, Packet, host_text
from structured_text.errors import InputError

DATAGRAM = udp("10.0.0.1", "10.0.0.2", b"hello", (2222, 2223))
QINQ = (0x88A8, 0x8100)


def _read(path: Path) -> tuple[Capture, list[Packet]]:
    capture = Capture(path)
    return capture, list(capture)


@pytest.mark.parametrize(
    ("link", "tags"),
    [
        (ETHERNET, ()),
        (ETHERNET, (0x8100,)),
        (ETHERNET, QINQ),
        (COOKED, ()),
        (COOKED_2, ()),
        (RAW, ()),
        (NULL, ()),
        (LOOP, ()),
    ],
)
def test_every_link_type_is_read_alike(tmp_path: Path, link: int, tags: tuple[int, ...]) -> None:
    """All link types give the same packets. Ethernet padding after a datagram is ignored.

    Source: tcpdump.org, link-layer header types; IEEE 802.1Q; RFC 791, RFC 768.
    """
    file = pcap(tmp_path / "one.pcap", [(0, framed(DATAGRAM, link, tags))], link)
    capture, packets = _read(file)
    assert [(one.payload, one.tcp, one.cut) for one in packets] == [(b"hello", False, False)]
    (one,) = packets
    assert (host_text(one.source), one.source_port) == ("10.0.0.1", 2222)
    assert (host_text(one.destination), one.destination_port) == ("10.0.0.2", 2223)
    assert not capture.others


def test_a_segment_has_its_sequence_number_and_flags(tmp_path: Path) -> None:
    """Source: RFC 9293, 3.1."""
    segment = tcp("10.0.0.1", "10.0.0.2", b"abc", 0xFFFFFFFE, (1, 2), 0x12)
    _, (one,) = _read(pcap(tmp_path / "one.pcap", [(0, framed(segment))]))
    assert (one.tcp, one.sequence, one.flags, one.payload) == (True, 0xFFFFFFFE, 0x12, b"abc")


@pytest.mark.parametrize("kind", ["pcap", "nanoseconds", "pcapng"])
def test_times_are_microseconds_from_the_first_packet(tmp_path: Path, kind: str) -> None:
    """The times of a capture are microseconds since its first packet, whatever unit the file uses.

    Files use microseconds or nanoseconds. In pcapng, each interface has its own unit.

    Source: pcap and pcapng file formats (IETF opsawg drafts).
    """
    frames = [(t_us, framed(DATAGRAM)) for t_us in (250_000, 250_700, 3_000_000)]
    file = tmp_path / "times"
    if kind == "pcapng":
        pcapng(file, frames)
    else:
        pcap(file, frames, nano=kind == "nanoseconds")
    capture, packets = _read(file)
    assert [one.t_us for one in packets] == [0, 700, 2_750_000]
    assert [one.number for one in packets] == [1, 2, 3]
    assert capture.begin_us == 1_700_000_000_250_000
    assert capture.last_us == 2_750_000


@pytest.mark.parametrize(
    ("packet", "kind", "told"),
    [
        (bytes(40), 0x86DD, "IPv6, which EtherNet/IP does not use"),
        (bytes(28), 0x0806, "no IP"),
        (bytes(28), 0x8864, "no IP"),
        (ip("10.0.0.1", "10.0.0.2", 1, bytes(8)), 0x0800, "other protocols"),
        (DATAGRAM[:6] + b"\x20\x00" + DATAGRAM[8:], 0x0800,
         "IP fragments, which are not put together"),
        (DATAGRAM[:6] + b"\x00\x07" + DATAGRAM[8:], 0x0800,
         "IP fragments, which are not put together"),
        (b"\x65" + DATAGRAM[1:], 0x0800, "damaged IP headers"),
        (ip("10.0.0.1", "10.0.0.2", 17, bytes(3)), 0x0800, "damaged IP headers"),
    ],
)  # fmt: skip
def test_unread_packets_are_counted_by_protocol(
    tmp_path: Path, packet: bytes, kind: int, told: str
) -> None:
    """Packets that are not read are counted by protocol: 0x0806 is ARP, 0x8864 is PPPoE.

    The two IP fragments are a first one, with the flag "more fragments", and a later one.
    """
    file = pcap(tmp_path / "one.pcap", [(0, framed(packet, kind=kind)), (1, framed(DATAGRAM))])
    capture, packets = _read(file)
    assert [one.number for one in packets] == [2]
    assert dict(capture.others) == {told: 1}
    assert capture.packets == 2


def test_a_packet_that_the_capture_has_cut_off_says_so(tmp_path: Path) -> None:
    long = udp("10.0.0.1", "10.0.0.2", bytes(100))
    file = pcap(tmp_path / "short.pcap", [(0, framed(long)), (1, framed(long))], kept=60)
    _, packets = _read(file)
    assert [(one.cut, len(one.payload)) for one in packets] == [(True, 60 - 14 - 28)] * 2
    capture, packets = _read(pcap(tmp_path / "tiny.pcap", [(0, framed(long))], kept=30))
    assert not packets
    assert dict(capture.others) == {"packets cut off by the capture": 1}


@pytest.mark.parametrize("write", [pcap, pcapng])
def test_a_file_that_ends_too_early_gives_what_is_there(tmp_path: Path, write: object) -> None:
    assert write in (pcap, pcapng)
    frames = [(t_us, framed(DATAGRAM)) for t_us in range(3)]
    file = (pcap if write is pcap else pcapng)(tmp_path / "cut", frames)
    file.write_bytes(file.read_bytes()[:-10])
    capture, packets = _read(file)
    assert len(packets) == 2
    assert "truncated" in capture.damage


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a capture: truncated"),
        (b"this is no capture at all", "not a capture: unknown file format"),
        (b"\xd4\xc3\xb2\xa1\x02\x00", "not a capture: truncated"),
    ],
)
def test_a_wrong_capture_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "no.pcap"
    file.write_bytes(content)
    with pytest.raises(InputError, match=message):
        Capture(file)


def test_a_link_type_that_is_not_known_is_named(tmp_path: Path) -> None:
    """The error message names an unknown link type. Link type 105 is IEEE 802.11.

    Source: tcpdump.org, link-layer header types.
    """
    with pytest.raises(InputError, match=r"link type 105.*is not known"):
        Capture(pcap(tmp_path / "wlan.pcap", [(0, bytes(60))], 105))


def test_interfaces_of_two_link_types_in_one_file_are_refused(tmp_path: Path) -> None:
    """A file with interfaces of two link types is refused: libpcap reads one type per file."""
    frames = [(0, framed(DATAGRAM)), (1, framed(DATAGRAM, COOKED))]
    capture, _ = _read(pcapng(tmp_path / "two.pcapng", frames, (ETHERNET, COOKED)))
    assert "type" in capture.damage


def test_interfaces_of_one_link_type_may_be_several(tmp_path: Path) -> None:
    frames = [(0, framed(DATAGRAM)), (1, framed(DATAGRAM))]
    capture, packets = _read(pcapng(tmp_path / "two.pcapng", frames, (ETHERNET, ETHERNET)))
    assert len(packets) == 2
    assert not capture.damage


def test_a_packet_slightly_out_of_order_gets_the_latest_time_before_it(tmp_path: Path) -> None:
    """Source: docs/reference/limits.md, files."""
    hour = 3_600_000_000
    times = [10 * hour, 10 * hour + 100, 10 * hour + 90, 10 * hour + 150]
    file = pcap(tmp_path / "back.pcap", [(t_us, framed(DATAGRAM)) for t_us in times])
    capture, packets = _read(file)
    assert [one.t_us for one in packets] == [0, 100, 100, 150]
    assert not capture.damage


@pytest.mark.parametrize(
    ("seconds", "how"),
    [(-2, "the clock goes back by 2.000 s"), (400 * 86_400, "the clock goes ahead by 34560000 s")],
)
def test_a_clock_that_jumps_ends_the_capture(tmp_path: Path, seconds: int, how: str) -> None:
    """If the clock of a capture jumps, only the packets before the jump are read.

    Source: docs/reference/limits.md, files.
    """
    begin = 1_000_000_000
    times = [begin, begin + 1_000_000 * seconds]
    capture, packets = _read(pcap(tmp_path / "far.pcap", [(t, framed(DATAGRAM)) for t in times]))
    assert len(packets) == 1
    assert capture.damage == how
