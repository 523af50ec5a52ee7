"""Captures of a PLC and its controllers, built from bytes: headers, messages, cyclic packets.

Layouts: IPv4 (RFC 791), UDP (RFC 768), TCP (RFC 9293), 802.1Q; link types as tcpdump.org names
them; EtherNet/IP adaptation of CIP (volume 2), chapter 2. The encoders of the harness are not used.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

from enip_frames import send_rr
from forward_open_bytes import forward_close, forward_open, opened, refused

PLC, CONTROLLER = "192.168.0.1", "192.168.0.10"
ETHERNET, COOKED, COOKED_2, RAW, NULL, LOOP = 1, 113, 276, 101, 0, 108
TCP, UDP = 6, 17
Timed = tuple[int, bytes]


def _address(text: str) -> bytes:
    return bytes(int(part) for part in text.split("."))


def ip(source: str, destination: str, protocol: int, payload: bytes, fragment: int = 0) -> bytes:
    """Return an IPv4 packet with the checksum 0, as captured if the network card computes it."""
    head = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(payload), 7, fragment, 64, protocol, 0)
    return head + _address(source) + _address(destination) + payload


def udp(
    source: str, destination: str, payload: bytes, ports: tuple[int, int] = (2222, 2222)
) -> bytes:
    """Return a UDP datagram inside its IP packet."""
    head = struct.pack(">HHHH", *ports, 8 + len(payload), 0)
    return ip(source, destination, UDP, head + payload)


def tcp(
    source: str,
    destination: str,
    payload: bytes,
    sequence: int,
    ports: tuple[int, int] = (50000, 44818),
    flags: int = 0x18,
) -> bytes:
    """Return a TCP segment inside its IP packet."""
    head = struct.pack(">HHIIBBHHH", *ports, sequence & 0xFFFFFFFF, 0, 0x50, flags, 1024, 0, 0)
    return ip(source, destination, TCP, head + payload)


def framed(
    packet: bytes, link: int = ETHERNET, tags: Sequence[int] = (), kind: int = 0x0800
) -> bytes:
    """Return a packet with the header of this link type.

    Short Ethernet frames are padded to 60 bytes.
    """
    protocol = struct.pack(">H", kind)
    if link == ETHERNET:
        vlan = b"".join(struct.pack(">HH", tag, 5) for tag in tags)
        return (bytes(12) + vlan + protocol + packet).ljust(60, b"\0")
    if link == COOKED:
        return struct.pack(">HHH8s", 0, 1, 6, b"\x02") + protocol + packet
    if link == COOKED_2:
        return protocol + struct.pack(">HIHBB8s", 0, 1, 1, 0, 6, b"\x02") + packet
    if link == NULL:
        return struct.pack("<I", 2) + packet
    return struct.pack(">I", 2) + packet if link == LOOP else packet


def pcap(
    path: Path,
    packets: Iterable[Timed],
    link: int = ETHERNET,
    *,
    nano: bool = False,
    kept: int = 65535,
) -> Path:
    """Write a little-endian pcap file; packets longer than `kept` bytes are cut."""
    magic = 0xA1B23C4D if nano else 0xA1B2C3D4
    parts = [struct.pack("<IHHiIII", magic, 2, 4, 0, 0, kept, link)]
    for t_us, data in packets:
        seconds, rest = divmod(1_700_000_000_000_000 + t_us, 1_000_000)
        sizes = (min(kept, len(data)), len(data))
        parts.append(struct.pack("<IIII", seconds, rest * 1000 if nano else rest, *sizes))
        parts.append(data[:kept])
    path.write_bytes(b"".join(parts))
    return path


def pcapng(path: Path, packets: Iterable[Timed], links: Sequence[int] = (ETHERNET,)) -> Path:
    """Write a pcapng file with nanoseconds, as dumpcap does.

    All packets use the first interface.
    """
    section = struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)
    parts = [_block(0x0A0D0D0A, section)]
    resolution = struct.pack("<HHB3xHH", 9, 1, 9, 0, 0)
    parts += [_block(1, struct.pack("<HHI", link, 0, 65535) + resolution) for link in links]
    for number, (t_us, data) in enumerate(packets):
        time = (1_700_000_000_000_000 + t_us) * 1000
        which = number % len(links)
        head = struct.pack("<IIIII", which, time >> 32, time & 0xFFFFFFFF, len(data), len(data))
        parts.append(_block(6, head + data + bytes(-len(data) % 4)))
    path.write_bytes(b"".join(parts))
    return path


def _block(kind: int, body: bytes) -> bytes:
    length = struct.pack("<I", 12 + len(body))
    return struct.pack("<I", kind) + length + body + length


def cyclic(identifier: int, number: int, content: bytes) -> bytes:
    """Return a class 1 packet: a sequenced address item and a connected data item."""
    head = struct.pack(
        "<HHHIIHH", 2, 0x8002, 8, identifier, number & 0xFFFFFFFF, 0xB1, len(content)
    )
    return head + content


def area(words: dict[int, int] | None = None, dedicated: int = 0, size: int = 48) -> bytes:
    """Return an area.

    `words` maps the first byte of a word to its value. `dedicated` is the value of bytes 32 and 33.
    """
    made = bytearray(size)
    for at, value in {**(words or {}), 32: dedicated}.items():
        made[at : at + 2] = value.to_bytes(2, "little")
    return bytes(made)


class Story:
    """Packets of one PLC and one controller in the order of the calls.

    Args:
        plc: Address of the PLC.
        controller: Address of the controller.
        o_to_t: Connection id of packets to the controller.
        t_to_o: Connection id of packets to the PLC.
        group: The multicast group to which the controller sends; empty for unicast.

    Attributes:
        packets: The packets so far, each as its time [us] and the IP packet.
    """

    def __init__(
        self,
        plc: str = PLC,
        controller: str = CONTROLLER,
        o_to_t: int = 0x11,
        t_to_o: int = 0x22,
        group: str = "",
    ) -> None:
        self.packets: list[Timed] = []
        self.plc, self.controller, self.group = plc, controller, group
        self.ids = (o_to_t, t_to_o)
        self.triad = f"{o_to_t & 0xFFFF:04X} 4D00 EFBEADDE"
        self._sequence = {"to": 1000, "from": 5000}
        self._numbers = {"to": 0, "from": 0}
        self._counts = {"to": 0, "from": 0}
        self._last = {"to": b"", "from": b""}

    def message(self, t_us: int, message: bytes, to: bool = True) -> None:
        """Add an unconnected message or its answer on the TCP connection at a time [us]."""
        way = "to" if to else "from"
        data = send_rr(message, 1)
        ends = (self.plc, self.controller) if to else (self.controller, self.plc)
        ports = (50000, 44818) if to else (44818, 50000)
        self.packets.append((t_us, tcp(*ends, data, self._sequence[way], ports)))
        self._sequence[way] += len(data)

    def open(self, t_us: int, **fields: str) -> None:
        """Add a Forward Open and its answer at a time [us].

        The sizes are 48 bytes, the RPI is 10 ms, and the time-out is 16 intervals.
        """
        o_to_t, t_to_o = (identifier.to_bytes(4, "little").hex() for identifier in self.ids)
        if self.group:
            fields = {"t_to_o": "3228", **fields}
        asked = forward_open(ids=f"00000000 {t_to_o}", triad=self.triad, **fields)
        service = "DB" if fields.get("service") == "5B" else "D4"
        self.message(t_us, bytes.fromhex(asked))
        self.message(t_us + 500, opened(o_to_t, t_to_o, self.triad, service=service), to=False)
        self._numbers = {"to": 0, "from": 0}
        self._counts = {"to": 0, "from": 0}

    def refuse(self, t_us: int, words: str) -> None:
        """Add a Forward Open at a time [us], and an answer that refuses it with this status."""
        self.message(t_us, bytes.fromhex(forward_open(triad=self.triad)))
        self.message(t_us + 500, refused(words, triad=self.triad), to=False)

    def close(self, t_us: int) -> None:
        """Add a Forward Close and its answer at a time [us]."""
        self.message(t_us, bytes.fromhex(forward_close(self.triad)))
        answer = bytes.fromhex(f"CE 00 00 00 {self.triad} 00 00")
        self.message(t_us + 500, answer, to=False)

    def to_robot(
        self, t_us: int, si: bytes, *, run: bool = True, number: int | None = None
    ) -> None:
        """Add a packet of the PLC at a time [us]: sequence count, run/idle header, area."""
        count, number = self._next("to", si, number)
        content = struct.pack("<HI", count, run) + si
        self._cyclic(t_us, self.plc, self.controller, cyclic(self.ids[0], number, content))

    def to_plc(self, t_us: int, so: bytes, *, number: int | None = None) -> None:
        """Add a packet of the controller at a time [us]: sequence count, area."""
        count, number = self._next("from", so, number)
        content = struct.pack("<H", count) + so
        to = self.group or self.plc
        self._cyclic(t_us, self.controller, to, cyclic(self.ids[1], number, content))

    def both(self, t_us: int, si: bytes, so: bytes) -> None:
        """Add a packet of the PLC at a time [us], and one of the controller 0.5 ms later."""
        self.to_robot(t_us, si)
        self.to_plc(t_us + 500, so)

    def _next(self, way: str, data: bytes, number: int | None) -> tuple[int, int]:
        if data != self._last[way]:
            self._counts[way] = (self._counts[way] + 1) & 0xFFFF
        self._last[way] = data
        self._numbers[way] = self._numbers[way] + 1 if number is None else number
        return self._counts[way], self._numbers[way]

    def _cyclic(self, t_us: int, source: str, destination: str, payload: bytes) -> None:
        self.packets.append((t_us, udp(source, destination, payload)))

    def frames(self, link: int = ETHERNET, tags: Sequence[int] = ()) -> list[Timed]:
        """Return all packets with their times, each with the header of this link type."""
        return [(t_us, framed(packet, link, tags)) for t_us, packet in self.packets]
