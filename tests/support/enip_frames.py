"""EtherNet/IP frames of an attacker: valid frames of every kind, and damaged frames.

They are made with `struct` alone, so that an error in the harness's own encoders cannot hide here.
"""

from __future__ import annotations

import struct
from random import Random

HEADER = struct.Struct("<HHII8sI")
_NOP, _LIST_SERVICES, _LIST_IDENTITY, _LIST_INTERFACES = 0x00, 0x04, 0x63, 0x64
_REGISTER, _UNREGISTER, _SEND_RR, _SEND_UNIT = 0x65, 0x66, 0x6F, 0x70
_BORDERS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF)


def frame(command: int, data: bytes = b"", session: int = 0, options: int = 0) -> bytes:
    """Return an encapsulation frame whose length field is correct."""
    return HEADER.pack(command, len(data), session, 0, b"fuzzing!", options) + data


def send_rr(message: bytes, session: int) -> bytes:
    """Return an unconnected CIP message in its encapsulation frame."""
    items = struct.pack("<HHHHH", 2, 0x0000, 0, 0x00B2, len(message)) + message
    return frame(_SEND_RR, struct.pack("<IH", 0, 5) + items, session)


def forward_open(
    *,
    large: bool = False,
    serial: int = 1,
    rpi_us: int = 10_000,
    sizes: tuple[int, int] = (54, 50),
    points: tuple[int, int] = (150, 100),
    transport: int = 0x01,
    multiplier: int = 5,
) -> bytes:
    """Return a Forward Open, or a Large Forward Open.

    `sizes` are the connection sizes on the wire, with sequence count and header. The originator is
    vendor 0xBAD, serial number 0xBADBAD.
    """
    path = bytes((0x20, 0x04, 0x24, 0x01, 0x2C, points[0], 0x2C, points[1]))
    kind, form = (0x4800 << 16, "I") if large else (0x4800, "H")
    message = struct.pack("<BB4s", 0x5B if large else 0x54, 2, b"\x20\x06\x24\x01")
    message += struct.pack("<BBIIHHIB3x", 3, 250, 0, 0x0BAD0000 | serial, serial, 0xBAD, 0xBADBAD,
                           multiplier)  # fmt: skip
    message += struct.pack(f"<I{form}", rpi_us, kind | sizes[0])
    message += struct.pack(f"<I{form}", rpi_us, kind | sizes[1])
    return message + struct.pack("<BB", transport, len(path) // 2) + path


def _forward_close(serial: int) -> bytes:
    path = bytes((0x20, 0x04, 0x24, 0x01, 0x2C, 150, 0x2C, 100))
    head = struct.pack("<BB4s", 0x4E, 2, b"\x20\x06\x24\x01")
    return head + struct.pack("<BBHHIBx", 3, 250, serial, 0xBAD, 0xBADBAD, 4) + path


def _messages(draw: Random) -> list[bytes]:
    """Return CIP requests of every kind.

    The adapter refuses Set and Reset while an owner is connected.
    """
    inner = b"\x0e\x03\x20\x04\x24\x64\x30\x03"
    unconnected_send = b"\x52\x02\x20\x06\x24\x01" + struct.pack("<BBH", 3, 250, len(inner))
    serial = draw.randrange(1, 0xFFFF)
    return [
        inner,
        b"\x01\x02\x20\x01\x24\x01",
        b"\x03\x02\x20\x01\x24\x01" + struct.pack("<HHH", 2, 1, 7),
        b"\x0e\x03\x20\xf5\x24\x01\x30\x05",
        b"\x0e\x03\x20\xf6\x24\x01\x30\x03",
        b"\x0e\x04\x21\x00\x04\x00\x24\x64\x30\x04",
        b"\x10\x03\x20\x04\x24\x96\x30\x03" + draw.randbytes(48),
        b"\x10\x03\x20\x01\x24\x01\x30\x01\xff\xff",
        b"\x05\x02\x20\x01\x24\x01\x00",
        unconnected_send + inner + b"\x01\x00\x01\x00",
        forward_open(serial=serial),
        forward_open(large=True, serial=serial, sizes=(262, 258)),
        forward_open(serial=serial, sizes=(2, 50), points=(198, 100)),
        forward_open(serial=serial, rpi_us=draw.choice((0, 1, 999, 0xFFFFFFFF))),
        forward_open(serial=serial, transport=draw.randrange(256)),
        _forward_close(serial),
        b"\x0a\x02\x20\x02\x24\x01" + struct.pack("<HH", 1, 4) + inner,
        draw.randbytes(draw.randrange(2, 80)),
    ]


def valid_frames(draw: Random, session: int) -> list[bytes]:
    """Return one valid frame of every kind, partly with random values."""
    unit_items = struct.pack("<HHHIHHH", 2, 0x00A1, 4, draw.randrange(1 << 32), 0x00B1, 8, 1)
    unit = struct.pack("<IH", 0, 0) + unit_items + b"\x01\x02\x20\x01\x24\x01"
    return [
        frame(_NOP, draw.randbytes(8)),
        frame(_LIST_SERVICES),
        frame(_LIST_IDENTITY),
        frame(_LIST_INTERFACES),
        frame(_REGISTER, struct.pack("<HH", draw.choice((1, 0, 2)), 0)),
        frame(_UNREGISTER, session=draw.randrange(1 << 32)),
        frame(_SEND_UNIT, unit, session),
        frame(draw.randrange(0x10000), draw.randbytes(draw.randrange(64)), session),
        *(send_rr(message, session) for message in _messages(draw)),
    ]


#: Frames that never change the device, even if a peer sends them many times.
READ_ONLY = (frame(_LIST_IDENTITY), frame(_LIST_SERVICES), frame(_LIST_INTERFACES))


def mutate(draw: Random, good: bytes) -> bytes:
    """Damage a frame at one to four positions. Some frames stay unchanged."""
    data = bytearray(good)
    for _ in range(draw.choice((0, 1, 1, 1, 2, 4))):
        way = draw.randrange(8)
        at = draw.randrange(len(data)) if data else 0
        if way == 0 and data:
            data[at] ^= 1 << draw.randrange(8)
        elif way == 1 and data:
            data[at] = draw.randrange(256)
        elif way == 2:
            del data[at:]
        elif way == 3:
            data[at:at] = draw.randbytes(draw.randrange(1, 40))
        elif way == 4 and len(data) >= 4:  # the length field of the frame
            struct.pack_into("<H", data, 2, draw.choice((*_BORDERS, draw.randrange(0x10000))))
        elif way == 5 and at + 2 <= len(data):  # any length or number in the frame
            struct.pack_into("<H", data, at, draw.choice(_BORDERS))
        elif way == 6:
            data += draw.randbytes(draw.choice((1, 600, 4000)))
        elif way == 7 and len(data) > 1:
            del data[at : at + draw.randrange(1, 8)]
    return bytes(data)
