"""Capture files as UDP datagrams and TCP segments, read step by step by libpcap (package cypcap).

The IP header may follow an Ethernet header with VLAN tags, a cooked header of Linux, a loopback
header, or nothing. The names of the link types are from the registry at tcpdump.org.
"""

from __future__ import annotations

import os
import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from structured_text.errors import InputError
from structured_text.output.reading import check_file

__all__ = ["ENDINGS", "Capture", "Packet", "host_text"]

#: Endings of the names of capture files.
ENDINGS = (".pcapng", ".pcap", ".cap", ".ntar")

_IP, _IPV6 = 0x0800, 0x86DD
_TAGS = (0x8100, 0x88A8, 0x9100)
_TCP, _UDP = 6, 17
_HEAD = struct.Struct(">BxHxxHxB2x4s4s")
_UDP_HEAD = struct.Struct(">HHHxx")
_TCP_HEAD = struct.Struct(">HHIxxxxBB")
_FRAGMENT = 0x3FFF  # IP header: these bits are set in each fragment of a packet
#: Maps a link type to the offset of the protocol number, and to the offset of the packet behind it.
_ETHERNET, _COOKED, _COOKED_2 = 1, 113, 276
_PLACES = {_ETHERNET: (12, 14), _COOKED: (14, 16), _COOKED_2: (0, 20)}
_NULL, _LOOP = 0, 108
_FAMILY_IP = 2
_BARE = (12, 14, 101, 228)  # raw IP (systems use different numbers) and IPv4
_KNOWN = {*_PLACES, _NULL, _LOOP, *_BARE}
_PERHAPS = "save it with Wireshark from Ethernet, Linux cooked, loopback or raw IP"
#: Packets of several interfaces may be out of order by at most this time [us]. If the clock goes
#: back further, the file is damaged.
_MOST_BACK_US, _MOST_AHEAD_US = 1_000_000, 24 * 3600 * 1_000_000
_RECORD_HEADER = 32  # overhead of each packet in the file [bytes], to calculate the progress


class Packet(NamedTuple):
    """A UDP datagram or TCP segment; addresses are the four bytes of IPv4.

    `number` counts the packets of the file from 1, as Wireshark does. If `cut` is True, the capture
    has only the beginning of the packet. `sequence` and `flags` are from the TCP header.
    """

    t_us: int
    number: int
    tcp: bool
    source: bytes
    source_port: int
    destination: bytes
    destination_port: int
    payload: bytes
    cut: bool = False
    sequence: int = 0
    flags: int = 0


class Capture:
    """The packets of a capture file, one by one.

    Attributes:
        packets: Number of packets so far, of any kind.
        others: Number of packets of each kind that cannot be evaluated (`IPv6`, `IP fragments`
            ...).
        begin_us: Time of the first packet, in microseconds since 1970. All other times are relative
            to it.
        last_us: Time of the latest packet.
        damage: The damage of the file after the last packet. Empty if the file is undamaged.
        read_bytes: Approximate number of bytes read so far.

    Raises:
        InputError: the file does not exist, cannot be read, is not a capture or has an unknown link
            type, or the package that reads captures is not installed.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = Path(path)
        self._library = _library()
        if not os.path.lexists(self._path):
            raise InputError("there is no such file", file=path)
        check_file(path)
        # Request microseconds, because the package returns nanoseconds as if they were
        # microseconds.
        precision = self._library.TstampPrecision.MICRO
        try:
            self._file: Any = self._library.open_offline(self._path, precision)
        except self._library.Error as error:
            hint = "give an uncompressed pcapng or pcap file"
            raise InputError(f"not a capture: {error.args[-1]}", file=path, hint=hint) from None
        self.link = int(self._file.datalink())
        if self.link not in _KNOWN:
            name = getattr(self._file.datalink(), "name", "")
            text = f"link type {self.link}{f' ({name})' if name else ''} is not known here"
            raise InputError(text, file=path, hint=_PERHAPS)
        self.packets = self.read_bytes = 0
        self.begin_us: int | None = None
        self.last_us = 0
        self.others: Counter[str] = Counter()
        self.damage = ""

    def __iter__(self) -> Iterator[Packet]:
        """Yield all UDP datagrams and TCP segments; close the file at its end."""
        with self._file:
            try:
                for header, data in self._file:
                    t_us = round(header.ts * 1e6)
                    if self.begin_us is None:
                        self.begin_us = t_us
                    self.damage = self._damage(t_us - self.begin_us, header.len, len(data))
                    if self.damage:
                        return
                    # Packets of several network cards may be a little out of order.
                    self.last_us = max(self.last_us, t_us - self.begin_us)
                    self.packets += 1
                    self.read_bytes += len(data) + _RECORD_HEADER
                    found = self._packet(data, header.len > len(data))
                    if found is not None:
                        yield found
            except self._library.Error as error:
                self.damage = str(error.args[-1])

    def _damage(self, t_us: int, length: int, kept: int) -> str:
        """Return the damage of a packet that libpcap can read. Empty if it is undamaged."""
        if not length:
            return "a packet of 0 bytes follows"
        if length < kept:
            return f"a packet of {length} bytes follows, of which {kept} are there"
        if t_us < self.last_us - _MOST_BACK_US:
            return f"the clock goes back by {(self.last_us - t_us) / 1e6:.3f} s"
        if t_us > self.last_us + _MOST_AHEAD_US:
            return f"the clock goes ahead by {(t_us - self.last_us) / 1e6:.0f} s"
        return ""

    def trouble(self, what: str = "judged") -> InputError | None:
        """Return the error for a damaged file after it has been read; None if it is undamaged.

        `what` is the treatment of the packets before the damage, such as `judged`.
        """
        if not self.damage:
            return None
        how = "cut off" if "truncated" in self.damage else "damaged"
        at = f"packet {self.packets}, {self.last_us / 1e6:.3f} s"
        text = f"is {how} after {at}; the packets before it were {what}"
        return InputError(text, file=self._path, hint=self.damage)

    def _packet(self, data: bytes, cut: bool) -> Packet | None:
        at = self._at_ip(data)
        if at is None:
            return None
        if len(data) < at + 20 or data[at] >> 4 != 4:
            self.others["damaged IP headers" if not cut else "packets cut off by the capture"] += 1
            return None
        version, length, fragment, protocol, source, destination = _HEAD.unpack_from(data, at)
        if protocol not in (_TCP, _UDP):
            self.others["other protocols"] += 1
            return None
        if fragment & _FRAGMENT:
            self.others["IP fragments, which are not put together"] += 1
            return None
        begin = at + 4 * (version & 0x0F)
        # length 0: the network card splits the packet after the capture
        end = at + length if length else len(data)
        if len(data) < end and not cut:
            self.others["packets shorter than the length in their IP header"] += 1
            return None
        body = data[begin:end]
        least = _TCP_HEAD.size if protocol == _TCP else _UDP_HEAD.size
        if len(body) < least:
            self.others["packets cut off by the capture" if cut else "damaged IP headers"] += 1
            return None
        place = (self.last_us, self.packets)
        cut = cut and len(data) < end
        if protocol == _UDP:
            from_port, to_port, length = _UDP_HEAD.unpack_from(body)
            payload = body[_UDP_HEAD.size : length]
            return Packet(*place, False, source, from_port, destination, to_port, payload, cut)
        from_port, to_port, sequence, offset, flags = _TCP_HEAD.unpack_from(body)
        payload = body[offset >> 4 << 2 :]
        ends = (source, from_port, destination, to_port)
        return Packet(*place, True, *ends, payload, cut, sequence, flags)

    def _at_ip(self, data: bytes) -> int | None:
        """Return the offset of the IP header of a frame; None if there is none."""
        if self.link in _BARE:
            kind, at = _IP, 0
            if data and data[0] >> 4 == 6:
                kind = _IPV6
        elif self.link in (_NULL, _LOOP):
            family = {data[0:1], data[3:4]} - {b"\0"}  # byte order of the capturing machine
            kind, at = (_IP if family == {bytes([_FAMILY_IP])} else _IPV6), 4
        else:
            kind_at, at = _PLACES[self.link]
            kind = int.from_bytes(data[kind_at : kind_at + 2], "big")
            while kind in _TAGS:
                kind = int.from_bytes(data[at + 2 : at + 4], "big")
                at += 4
        if kind == _IP:
            return at
        self.others["IPv6, which EtherNet/IP does not use" if kind == _IPV6 else "no IP"] += 1
        return None


def host_text(address: bytes) -> str:
    """Return an IPv4 address as text."""
    return ".".join(map(str, address))


def _library() -> Any:
    """Import and return the package cypcap. If it is not usable, raise InputError."""
    try:
        import cypcap
    except ModuleNotFoundError:
        hint = "pip install 'rcx-harness[capture]'"
        raise InputError("reading captures needs the library cypcap", hint=hint) from None
    except ImportError as error:
        hint = "install Npcap on Windows, which comes with Wireshark"
        raise InputError(f"libpcap cannot be loaded: {error}", hint=hint) from None
    return cypcap
