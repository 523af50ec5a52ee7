"""`rcx scan` prints lines for areas, changes, telegrams and the identity of a device."""

from __future__ import annotations

import pytest

from rcx_harness.look.look import output_image
from rcx_harness.look.text import (
    area_lines,
    byte_change_lines,
    change_lines,
    identity_lines,
    telegram_lines,
)

#: Bytes 32 and 33: CPU_OK, MP RDY, AUTO mode. Bit 0 of byte 34: SO(20). Word 2: 0x1234.
OUTPUTS = bytes([0, 0, 0, 0, 0x34, 0x12]) + bytes(26) + bytes([0x12, 0x01, 0x01]) + bytes(13)


def test_changed_bytes_are_shown_by_their_number() -> None:
    assert list(byte_change_lines(bytes(3), b"\x00\x0a\xff")) == ["byte 1 = 0x0A", "byte 2 = 0xFF"]


def test_changes_are_shown_with_their_names() -> None:
    after = bytearray(OUTPUTS)
    after[32] ^= 0x06
    after[0:2] = b"\x00\x02"
    after[35] = 0x80
    assert list(change_lines(OUTPUTS, bytes(after), "O")) == [
        "SO(01) off  CPU_OK status output",
        "SO(02) ON  Servo ON status output",
        "SOW(0) = 16#0200",
        "SO(37) = 1",
    ]
    assert list(change_lines(OUTPUTS, OUTPUTS, "O")) == []


def test_an_area_lists_every_dedicated_bit_and_what_is_not_0() -> None:
    lines = list(area_lines(bytes(48), "I"))
    assert lines[0] == "  SI(00) off  Emergency stop input"
    assert lines[-1] == "  all others 0"
    area = bytearray(48)
    area[45] = 0x81
    assert list(area_lines(bytes(area), "I"))[-1] == "  not 0: SI(150) = 1, SI(157) = 1"


def test_the_last_telegram_is_shown_as_text() -> None:
    """Source: guide chapter 2, example: to point 19 at 50 %."""
    words = ["SIW(0)=1", "SIW(2)=4", "SIW(3)=50", "SIW(4)=19"]
    request = output_image(words, 48)
    assert list(telegram_lines(bytes(48), request)) == [
        "  MovePtp (16#R001): MOVE, PTP, point designation; axes 4, speed 50, point 19",
        "  not taken yet",
    ]
    answered = b"\x00\x02" + bytes(46)
    assert list(telegram_lines(answered, request))[1] == "  normal end"
    assert list(telegram_lines(bytes(48), bytes(48))) == ["  no command, ready for a command"]
    alarm = b"\x00\x40\x0c\x00\x58\x02" + bytes(42)
    (line,) = telegram_lines(alarm, None)
    assert line.startswith("  remote status 16#4000: abnormal end, alarm 12.600")


_TAIL = ": vendor 636, device type 43, product code 5, revision 1.1, serial number 16#12345678"
_ESCAPES = b"\x1b[2J\r\nrcx: fake\x9b31m\xe9"
_NO_MASTER = "owned by no master, no I/O connection"


@pytest.mark.parametrize(
    ("status", "name", "lines"),
    [
        ("3000", b"RCX", [f"RCX{_TAIL}", f"status 16#0030: {_NO_MASTER}"]),
        ("6100", b"RCX",
         [f"RCX{_TAIL}", "status 16#0061: owned by a master, an I/O connection is in run"]),
        ("0000", b"RCX", [f"RCX{_TAIL}", "status 16#0000: owned by no master"]),
        ("3000", b"", [f"(no name){_TAIL}", f"status 16#0030: {_NO_MASTER}"]),
        # A name is ISO 8859-1 text from an unknown device.
        ("3000", _ESCAPES,
         [f"\\x1b[2J\\r\\nrcx: fake\\x9b31m\u00e9{_TAIL}", f"status 16#0030: {_NO_MASTER}"]),
        ("", b"", ["identity: 7c 02"]),
    ],
    ids=["no connection", "a master in run", "no master", "no name", "escapes", "cut short"],
)  # fmt: skip
def test_the_identity_is_shown_in_words(status: str, name: bytes, lines: list[str]) -> None:
    attributes = bytes.fromhex("7C02")
    if status:
        attributes += bytes.fromhex(f"2B00 0500 0101 {status} 78563412")
        attributes += bytes([len(name)]) + name
    assert list(identity_lines(attributes)) == lines
    assert all(line.isprintable() for line in lines)
