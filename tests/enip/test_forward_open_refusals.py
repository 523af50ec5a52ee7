"""Each wrong Forward Open is refused with the right status, triad and path size."""

from __future__ import annotations

from typing import Any

import pytest

from forward_open_bytes import TRIAD, forward_close, forward_open, opened, refused

INPUT_ONLY = {"o_to_t": "0248", "path": "2004 2405 2C03 2C64"}
LISTEN_ONLY = {"o_to_t": "0248", "path": "2004 2405 2C04 2C64"}


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        # 0x123, 0x124: connection types that the device does not have
        ({"o_to_t": "3608"}, "2301"),  # connection type null, to the adapter
        ({"o_to_t": "3628"}, "2301"),  # connection type multicast, to the adapter
        ({"o_to_t": "3668"}, "2301"),  # reserved type, to the adapter
        ({"t_to_o": "3208"}, "2401"),  # connection type null, from the adapter
        ({"t_to_o": "3268"}, "2401"),  # reserved type, from the adapter
        # 0x132: a null Forward Open (both types null)
        ({"o_to_t": "3608", "t_to_o": "3208"}, "3201"),
        # 0x133: the multiplier is too large
        ({"multiplier": "08"}, "3301"),
        # 0x11C: transport classes 0, 2 and 4 to 6
        ({"transport": "00"}, "1C01"),
        ({"transport": "02"}, "1C01"),
        ({"transport": "04"}, "1C01"),
        ({"transport": "06"}, "1C01"),
        # 0x11D: triggers other than cyclic: change of state, application, reserved
        ({"transport": "11"}, "1D01"),
        ({"transport": "21"}, "1D01"),
        ({"transport": "31"}, "1D01"),
        ({"transport": "B3", "path": "2002 2401"}, "1D01"),
        # 0x11E: the direction bit does not fit the transport class
        ({"transport": "81"}, "1E01"),
        ({"transport": "23", "path": "2002 2401"}, "1E01"),
        # 0x125: a redundant owner is not supported
        ({"o_to_t": "36C8"}, "2501"),
        # electronic keys with a wrong vendor or product code (0x114), device type (0x115), revision
        # (0x116)
        ({"path": "3404 7D02 2B00 0500 0101 2004 2405 2C96 2C64"}, "1401"),
        ({"path": "3404 7C02 2B00 0600 0101 2004 2405 2C96 2C64"}, "1401"),
        ({"path": "3404 7C02 2C00 0500 0101 2004 2405 2C96 2C64"}, "1501"),
        ({"path": "3404 7C02 2B00 0500 0201 2004 2405 2C96 2C64"}, "1601"),
        ({"path": "3404 7C02 2B00 0500 0102 2004 2405 2C96 2C64"}, "1601"),
        # 0x12F: path segments that do not belong together
        ({"path": "2004 2C96"}, "2F01"),
        ({"path": "2004 2405 2C96 2C64 2C64"}, "2F01"),
        ({"path": "2002 2401"}, "2F01"),
        ({"path": "2005 2405 2C96 2C64"}, "2F01"),
        ({"path": "2004 2405 2005 2C96 2C64"}, "2F01"),
        # wrong instances: configuration (0x129), consuming (0x12A), producing (0x12B)
        ({"path": "2004 2402 2C96 2C64"}, "2901"),
        ({"path": "2004 2405 2C64 2C96"}, "2A01"),
        ({"path": "2004 2405 2C65 2C64"}, "2A01"),
        ({"path": "2004 2405 2C96 2C65"}, "2B01"),
        ({"path": "2004 2405 2C96 2C96"}, "2B01"),
        # 0x126: configuration data where none are allowed
        ({"path": "2004 2405 2C96 2C64 8001 1234"}, "2601 0000"),
        # 0x127, 0x128: wrong sizes; the reply has the required size
        ({"o_to_t": "3548"}, "2701 3600"),
        ({"o_to_t": "3748"}, "2701 3600"),
        ({"o_to_t": "3248"}, "2701 3600"),  # without the run/idle header
        ({"o_to_t": "0248"}, "2701 3600"),
        ({"t_to_o": "3148"}, "2801 3200"),
        ({"t_to_o": "3648"}, "2801 3200"),  # with a run/idle header
        ({**INPUT_ONLY, "o_to_t": "3648"}, "2701 0200"),
        ({**INPUT_ONLY, "t_to_o": "3348"}, "2801 3200"),
        # 0x112: wrong intervals; the reply has a code for each direction (2 too low, 3 too high),
        # then the accepted intervals
        ({"o_to_t_rpi": "CF070000"}, "1201 0200 D0070000 10270000"),
        ({"t_to_o_rpi": "CF070000"}, "1201 0002 10270000 D0070000"),
        ({"o_to_t_rpi": "00000000"}, "1201 0200 D0070000 10270000"),
        ({"t_to_o_rpi": "01D43000"}, "1201 0003 10270000 00D43000"),
        ({"o_to_t_rpi": "FFFFFFFF", "t_to_o_rpi": "00000000"}, "1201 0302 00D43000 D0070000"),
        # 0x11B: the production inhibit time is longer than the interval
        ({"path": "430B 2004 2405 2C96 2C64"}, "1B01"),
        # 0x119: there is no other connection to which a listener could listen
        (LISTEN_ONLY, "1901"),
    ],
)
def test_a_refused_forward_open_says_why_and_opens_nothing(
    bench: Any, fields: dict[str, str], words: str
) -> None:
    assert bench.ask(forward_open(**fields)) == refused(words)
    assert bench.cyclic.added == []
    assert bench.ask(forward_open()) == opened(), "the next request is accepted"


@pytest.mark.parametrize(
    ("path", "remaining"),
    [
        # the first segment is a port segment, so all five words remain
        ("0100 2004 2405 2C96 2C64", "05"),
        ("2004 9104 41424344 2C96", "04"),  # a symbol segment
        ("2004 2405 2C96 3003", "01"),  # an attribute segment
        ("2004 2405 2C96 2D00", "01"),  # a segment that is cut off
        ("2004 2405 2C96 3404", "01"),  # an electronic key after the class
        # an electronic key with an unknown format
        ("3405 0000 0000 0000 0000 2004 2C96 2C64", "08"),
        ("3404 7C02", "02"),  # an incomplete electronic key
        ("2405 2004 2C96 2C64", "04"),  # an instance before its class
        ("2004 2405 2C96 2C64 8002 1234", "02"),  # incomplete data
        ("4100 2004 2405 2C96 2C64", "05"),  # a schedule segment
        ("5001 1027 2004 2405 2C96 2C64", "06"),  # an inhibit time with a wrong length
        ("4305", "00"),  # no class segment
        ("", "00"),
    ],
)
def test_an_unknown_segment_is_reported_with_the_remaining_words(
    bench: Any, path: str, remaining: str
) -> None:
    """An unknown path segment gets extended status 0x315 and the number of remaining words."""
    assert bench.ask(forward_open(path=path, words="00" if not path else "")) == refused(
        "1503", remaining=remaining
    )


@pytest.mark.parametrize(
    ("request_", "reply"),
    [
        ("54 02 2006 2401", "D400 1300"),
        ("54 02 2006 2401 0A0E 00000000 78563412 0100 4D00 EFBEAD", "D400 1300"),
        ("54 02 2006 2401 0A0E 00000000 78563412 " + TRIAD, f"D400 1300 {TRIAD} 00 00"),
        (forward_open(words="05"), f"D400 1300 {TRIAD} 00 00"),
        (forward_open(words="03"), f"D400 1500 {TRIAD} 00 00"),
        (forward_open() + "00", f"D400 1500 {TRIAD} 00 00"),
        (forward_open(service="5B"), f"DB00 1300 {TRIAD} 00 00"),
        ("4E 02 2006 2401", "CE00 1300"),
        ("4E 02 2006 2401 0A0E " + TRIAD, f"CE00 1300 {TRIAD} 00 00"),
        (forward_close() + "00", f"CE00 1500 {TRIAD} 00 00"),
    ],
)
def test_a_request_of_a_wrong_length_is_refused(bench: Any, request_: str, reply: str) -> None:
    assert bench.ask(request_) == bytes.fromhex(reply)
    assert bench.cyclic.added == []
