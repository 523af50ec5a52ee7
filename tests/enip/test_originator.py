"""A scanner sends Forward Open and Forward Close byte by byte as specified.

Source: CIP volume 1, chapter 3, 5.5.2 and 5.5.3.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from rcx_harness.enip.codec.forward_open import OpenReply, OpenRequest, Triad, decode_open_reply

REQUEST = OpenRequest(
    triad=Triad(0x1234, 0x5678, 0x9ABCDEF0),
    t_to_o_id=0x11223344,
    rpi_us=10_000,
    o_to_t_length=54,
    t_to_o_length=50,
    multiplier=2,
    consuming=150,
    producing=100,
)
# The beginning of a Forward Open: service; path of two words to the Connection Manager; priority
# and ticks; connection ids; triad; multiplier.
START = "54 02 2006 2401 0A0E 00000000 44332211 3412 7856 F0DEBC9A 02000000"
RPI = "10270000"
CLASS_1_CYCLIC = "01"
TRIAD = "3412 7856 F0DEBC9A"


hexa = bytes.fromhex


def test_configuration_data_follow_the_connection_points_in_a_data_segment() -> None:
    """Configuration data are sent in a segment with 0x80, the number of words, and the data.

    Source: CIP volume 1, appendix C, simple data segment
    """
    request = replace(REQUEST, configuration=151, configuration_data=hexa("01020304"))
    assert request.path() == hexa("2004 2497 2C96 2C64 8002 01020304")


LONG = {"o_to_t_length": 262, "t_to_o_length": 258}


@pytest.mark.parametrize(
    ("changes", "start", "o_to_t", "t_to_o", "path"),
    [
        pytest.param(
            *({}, START, "3648", "3248", "03 2004 2C96 2C64"),
            id="an owner: point to point, scheduled, fixed, 54 and 50 bytes",
        ),
        pytest.param(
            *({"configuration": 151}, START, "3648", "3248", "04 2004 2497 2C96 2C64"),
            id="a configuration instance, in front of the connection points",
        ),
        pytest.param(
            *({"consuming": 0x0301}, START, "3648", "3248", "04 2004 2D00 0103 2C64"),
            id="an instance above 255 in a wide segment",
        ),
        pytest.param(
            {"large": True, **LONG},
            START.replace("54", "5B", 1),
            *("06010048", "02010048", "03 2004 2C96 2C64"),
            id="a Large Forward Open with parameters of 32 bits",
        ),
        pytest.param(
            *(LONG, START, "0649", "0249", "03 2004 2C96 2C64"),
            id="256 bytes, which fit into parameters of 16 bits",
        ),
    ],
)
def test_a_forward_open_has_the_requested_parameters_and_path(
    changes: dict[str, Any], start: str, o_to_t: str, t_to_o: str, path: str
) -> None:
    asked = replace(REQUEST, **changes).forward_open()
    assert asked == hexa(f"{start} {RPI} {o_to_t} {RPI} {t_to_o} {CLASS_1_CYCLIC} {path}")


def test_forward_close_names_the_connection_and_its_path() -> None:
    assert REQUEST.forward_close() == hexa(
        "4E 02 2006 2401 0A0E 3412 7856 F0DEBC9A 03 00 2004 2C96 2C64"
    )


def test_the_reply_has_ids_and_actual_intervals() -> None:
    reply = hexa("01000000 44332211 3412 7856 F0DEBC9A 10270000 204E0000 00 00")
    assert decode_open_reply(reply) == OpenReply(1, 0x11223344, 10_000, 20_000, REQUEST.triad)
    assert REQUEST.problem(OpenReply(1, 0x11223344, 10_000, 20_000, REQUEST.triad)) == ""


@pytest.mark.parametrize(
    ("triad", "o_to_t", "t_to_o", "problem"),
    [
        (
            "0000 0000 00000000",
            RPI,
            RPI,
            "names another connection than requested",
        ),
        (TRIAD, "00000000", RPI, "sets a packet to it every 0 ms instead of every 10 ms"),
        (
            TRIAD,
            RPI,
            "00000000",
            "sets a packet from it every 0 ms instead of every 10 ms",
        ),
        (
            *(TRIAD, RPI, "FFFFFFFF"),
            "sets a packet from it every 4294967.295 ms instead of every 10 ms",
        ),
    ],
)
def test_an_implausible_reply_is_explained(
    triad: str, o_to_t: str, t_to_o: str, problem: str
) -> None:
    agreed = decode_open_reply(hexa(f"01000000 44332211 {triad} {o_to_t} {t_to_o} 00 00"))
    assert agreed is not None
    assert REQUEST.problem(agreed) == problem


def test_an_interval_near_the_requested_one_is_accepted() -> None:
    """The device may choose an interval from 0.5 ms to twice the requested interval.

    It may always choose the requested interval, even if this is very long.
    """
    for api_us in (500, 20_000, 10_000_000):
        assert REQUEST.problem(OpenReply(1, 2, api_us, api_us, REQUEST.triad)) == ""
    slow = replace(REQUEST, rpi_us=60_000_000)
    assert slow.problem(OpenReply(1, 2, 60_000_000, 60_000_000, REQUEST.triad)) == ""


@pytest.mark.parametrize("length", [0, 23])
def test_a_reply_that_is_too_short_is_not_decoded(length: int) -> None:
    assert decode_open_reply(bytes(length)) is None
