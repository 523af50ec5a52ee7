"""Forward Open and Forward Close as a scanner sends them, byte by byte.

Source: CIP volume 1, chapter 3, 5.5.2 and 5.5.3.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from rcx_harness.enip.codec.forward_open import OpenReply, OpenRequest, Triad, decode_open_reply

REQUEST = OpenRequest(
    triad=Triad(0x1234, 0x5678, 0x9ABCDEF0),
    t_to_o_id=0x11223344,
    rpi_us=10_000,
    o_to_t_length=54,
    t_to_o_length=50,
    multiplier=2,
    multicast=False,
    consuming=150,
    producing=100,
)
# Service, path of two words to the Connection Manager; priority and ticks; ids; triad; multiplier.
START = "54 02 2006 2401 0A0E 00000000 44332211 3412 7856 F0DEBC9A 02000000"
RPI = "10270000"
CLASS_1_CYCLIC = "01"


def hexa(text: str) -> bytes:
    return bytes.fromhex(text)


def test_an_owner_asks_for_both_assemblies_point_to_point() -> None:
    """Network parameters: type 2, scheduled, fixed, 54 and 50 bytes (0x36, 0x32)."""
    assert REQUEST.forward_open() == hexa(
        f"{START} {RPI} 3648 {RPI} 3248 {CLASS_1_CYCLIC} 03 2004 2C96 2C64"
    )


def test_a_configuration_instance_is_named_in_front_of_the_connection_points() -> None:
    request = replace(REQUEST, configuration=151)
    assert request.forward_open() == hexa(
        f"{START} {RPI} 3648 {RPI} 3248 {CLASS_1_CYCLIC} 04 2004 2497 2C96 2C64"
    )


def test_configuration_data_follow_the_connection_points_in_a_data_segment() -> None:
    """0x80, number of words, data.

    Source: CIP volume 1, appendix C, simple data segment
    """
    request = replace(REQUEST, configuration=151, configuration_data=hexa("01020304"))
    assert request.path() == hexa("2004 2497 2C96 2C64 8002 01020304")


def test_an_instance_above_255_takes_a_wide_segment() -> None:
    request = replace(REQUEST, consuming=0x0301)
    assert request.forward_open() == hexa(
        f"{START} {RPI} 3648 {RPI} 3248 {CLASS_1_CYCLIC} 04 2004 2D00 0103 2C64"
    )


def test_multicast_is_asked_for_in_the_direction_to_us_and_without_an_id() -> None:
    request = replace(REQUEST, multicast=True)
    without_id = START.replace("44332211", "00000000")
    assert request.forward_open() == hexa(
        f"{without_id} {RPI} 3648 {RPI} 3228 {CLASS_1_CYCLIC} 03 2004 2C96 2C64"
    )


def test_a_large_forward_open_has_parameters_of_32_bits() -> None:
    request = replace(REQUEST, large=True, o_to_t_length=262, t_to_o_length=258)
    start = START.replace("54", "5B", 1)
    assert request.forward_open() == hexa(
        f"{start} {RPI} 06010048 {RPI} 02010048 {CLASS_1_CYCLIC} 03 2004 2C96 2C64"
    )


def test_256_bytes_fit_into_the_parameters_of_16_bits() -> None:
    request = replace(REQUEST, o_to_t_length=262, t_to_o_length=258)
    assert request.forward_open() == hexa(
        f"{START} {RPI} 0649 {RPI} 0249 {CLASS_1_CYCLIC} 03 2004 2C96 2C64"
    )


def test_forward_close_names_the_connection_and_its_path() -> None:
    assert REQUEST.forward_close() == hexa(
        "4E 02 2006 2401 0A0E 3412 7856 F0DEBC9A 03 00 2004 2C96 2C64"
    )


def test_the_reply_tells_ids_and_actual_intervals() -> None:
    reply = hexa("01000000 44332211 3412 7856 F0DEBC9A 10270000 204E0000 00 00")
    assert decode_open_reply(reply) == OpenReply(1, 0x11223344, 10_000, 20_000, REQUEST.triad)
    assert REQUEST.problem(OpenReply(1, 0x11223344, 10_000, 20_000, REQUEST.triad)) == ""


@pytest.mark.parametrize(
    ("reply", "problem"),
    [
        (
            "01000000 44332211 0000 0000 00000000 10270000 10270000 00 00",
            "names another connection than the one that was asked for",
        ),
        (
            "01000000 44332211 3412 7856 F0DEBC9A 00000000 10270000 00 00",
            "sets a packet to it every 0 ms, where every 10 ms was asked for",
        ),
        (
            "01000000 44332211 3412 7856 F0DEBC9A 10270000 00000000 00 00",
            "sets a packet from it every 0 ms, where every 10 ms was asked for",
        ),
        (
            "01000000 44332211 3412 7856 F0DEBC9A 10270000 FFFFFFFF 00 00",
            "sets a packet from it every 4294967.295 ms, where every 10 ms was asked for",
        ),
    ],
)
def test_a_reply_that_cannot_be_meant_is_named(reply: str, problem: str) -> None:
    agreed = decode_open_reply(hexa(reply))
    assert agreed is not None
    assert REQUEST.problem(agreed) == problem


def test_an_interval_near_the_one_that_was_asked_for_is_the_devices_choice() -> None:
    """Twice as long, or as short as 0.5 ms; and as long as was asked for, however long that is."""
    for api_us in (500, 20_000, 10_000_000):
        assert REQUEST.problem(OpenReply(1, 2, api_us, api_us, REQUEST.triad)) == ""
    slow = replace(REQUEST, rpi_us=60_000_000)
    assert slow.problem(OpenReply(1, 2, 60_000_000, 60_000_000, REQUEST.triad)) == ""


@pytest.mark.parametrize("length", [0, 23])
def test_a_reply_that_is_too_short_is_none(length: int) -> None:
    assert decode_open_reply(bytes(length)) is None
