"""The message for a refused Forward Open has the request, the code, the cause and the remedy."""

from __future__ import annotations

from typing import Any

import pytest

from forward_open_bytes import forward_close, forward_open
from rcx_harness.enip.target.connection_manager import Origin

PEER = "192.168.0.10"
ASKED = "192.168.0.10 asked for "
OWNER = f"{ASKED}an exclusive owner connection "
USUAL = f"{OWNER}(54 bytes to the controller, 50 from it, every 10 ms): refused with "
SIZE_TO = "0x0127, the size to the device does not fit the assembly; "
SIZE_FROM = "0x0128, the size from the device does not fit the assembly; "
ASSEMBLIES = (
    "the output is assembly 150 (only to read: 3 input only, 4 listen only), the input assembly 100"
)


def sized(to_robot: int, from_robot: int, every: str = "10 ms", what: str = OWNER) -> str:
    """Return the beginning of the message for a request with these sizes and this interval."""
    sizes = f"{to_robot} bytes to the controller, {from_robot} from it"
    return f"{what}({sizes}, every {every}): refused with "


INPUT_ONLY = {"o_to_t": "0248", "path": "2004 2405 2C03 2C64"}
OTHER = "0200 4D00 EFBEADDE"


def said(make_bench: Any, *requests: str, **settings: Any) -> list[str]:
    """Send requests to a new device, and return the messages about its refusals."""
    texts: list[str] = []
    bench = make_bench(on_refused=texts.append, **settings)
    for request in requests:
        bench.ask(request, Origin(PEER, "192.168.0.2", 1))
    return texts


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        # An area of 256 bytes has 262 bytes (0x106) with header and count, and 258 bytes (0x102)
        # with the count only.
        (
            {"o_to_t": "0649", "t_to_o": "0249"},
            f"{sized(262, 258)}{SIZE_TO}this controller has 48 bytes, 54 with the 32-bit run/idle "
            "header and the count: set 48 bytes with that header in the PLC, or start the "
            "controller with --size 256",
        ),
        (
            {"t_to_o": "0249"},
            f"{sized(54, 258)}{SIZE_FROM}this controller has 48 bytes, 50 with the count: set 48 "
            "bytes without a header in the PLC, or start the controller with --size 256",
        ),
        (
            {"o_to_t": "3248"},
            f"{sized(50, 50)}{SIZE_TO}the output needs the 32-bit run/idle header before its 48 "
            "bytes: choose it in the PLC",
        ),
        (
            {"t_to_o": "3648"},
            f"{sized(54, 54)}{SIZE_FROM}the input has no header before its 48 bytes: choose pure "
            "data in the PLC",
        ),
        (
            {"o_to_t": "4648"},
            f"{sized(70, 50)}{SIZE_TO}this controller has 48 bytes, 54 with the 32-bit run/idle "
            "header and the count: set 48 bytes with that header in the PLC",
        ),
        (
            {**INPUT_ONLY, "o_to_t": "3648"},
            f"{sized(54, 50, what=f'{ASKED}an input only connection ')}{SIZE_TO}a connection that "
            "only reads sends no data: set size 0 for its output",
        ),
        (
            {"o_to_t_rpi": "E8030000"},
            f"{sized(54, 50, '1 ms and 10 ms')}0x0112, the packet interval is not acceptable; set "
            "2 ms to 3200 ms in the PLC, or start the controller with a smaller --rpi-min",
        ),
        (
            {"o_to_t_rpi": "01D43000", "t_to_o_rpi": "01D43000"},
            f"{sized(54, 50, '3200.001 ms')}0x0112, the packet interval is not acceptable; set "
            "2 ms to 3200 ms in the PLC",
        ),
        (
            {"path": "3404 7D02 2B00 0500 0101 2004 2405 2C96 2C64"},
            f"{USUAL}0x0114, vendor or product code does not match the device; switch off the "
            "check of the electronic key in the PLC, or use its identity: vendor 636, "
            "device type 43, product code 5 (--product-code), revision 1.1 (--revision)",
        ),
        (
            {"path": "2004 2407 2C96 2C64"},
            f"{USUAL}0x0129, there is no such configuration instance; set its configuration "
            "instance to none or one of 1, 5, 151, with size 0",
        ),
        (
            {"path": "2004 2405 2C97 2C64"},
            f"{sized(54, 50, what=f'{ASKED}a connection ')}0x012A, there is no such consuming "
            f"connection point; it named 5, 151, 100; {ASSEMBLIES}",
        ),
        (
            {"path": "2004 9104 41424344 2C96"},
            f"{sized(54, 50, what=f'{ASKED}a connection ')}0x0315, a segment of the connection "
            f"path is not valid; it named no assembly; {ASSEMBLIES}",
        ),
        (
            {"transport": "02"},
            f"{USUAL}0x011C, the transport class is not supported; set transport class 1, cyclic, "
            "at the client's side",
        ),
        (
            {"transport": "A3", "path": "2004 2405 2C96 2C64"},
            f"{ASKED}a connection for explicit messages (class 3): refused with 0x012F, the "
            f"application paths do not belong together; it named 5, 150, 100; {ASSEMBLIES}",
        ),
    ],
)
def test_a_refusal_has_request_reason_and_remedy(
    make_bench: Any, fields: dict[str, str], text: str
) -> None:
    """The message says who requested what, why it was refused, and what to set.

    Source: CIP volume 1, chapter 3, 5.6 (codes); manual chapter 1, 4.2 (sizes).
    """
    assert said(make_bench, forward_open(**fields)) == [text]


def test_a_refusal_names_the_size_of_a_controller_with_256_bytes(make_bench: Any) -> None:
    (text,) = said(make_bench, forward_open(), size=256)
    assert "this controller has 256 bytes, 262 with" in text
    assert text.endswith("or start the controller with --size 48")


def test_a_refusal_of_a_second_master_names_the_first_master(make_bench: Any) -> None:
    texts = said(make_bench, forward_open(), forward_open(triad=OTHER))
    assert texts == [
        f"{USUAL}0x0106, another master owns the outputs; 192.168.0.10 is its master: disconnect "
        "it or wait for its time-out, or only read, by connection point 3 (input only)"
    ]


def test_a_refusal_of_a_multicast_request_has_the_right_interval(make_bench: Any) -> None:
    slow = {**INPUT_ONLY, "t_to_o": "3228", "t_to_o_rpi": "204E0000", "triad": OTHER}
    (text,) = said(make_bench, forward_open(t_to_o="3228"), forward_open(**slow))
    assert text.endswith("its multicast input is sent every 10 ms: set that, or point to point")


def test_an_incomplete_forward_open_is_reported_too(make_bench: Any) -> None:
    assert said(make_bench, "54 02 2006 2401 0A0E") == [
        "192.168.0.10 asked for a connection: refused with 0x13, not enough data"
    ]


def test_accepted_requests_give_no_message(make_bench: Any) -> None:
    assert said(make_bench, forward_open(), forward_close(), forward_close()) == []
