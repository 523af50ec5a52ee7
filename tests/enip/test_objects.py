"""The CIP objects of the device have the right attributes, and some attributes can be set."""

from __future__ import annotations

from typing import Any

import pytest

from forward_open_bytes import forward_close, forward_open
from rcx_harness.enip.target.connection_manager import Origin

TCP_IP = {
    1: "01000000",  # status: configured
    2: "00000000",  # configuration capability
    3: "00000000",  # configuration control: fixed
    4: "0000",  # physical link: two ports
    5: "0200A8C0 00FFFFFF 00000000 00000000 00000000 0000",  # 192.168.0.2, 255.255.255.0
    6: "0000",  # host name
    7: "000000000000",  # safety network number
    8: "01",  # TTL
    9: "00 00 0100 2001C0EF",  # one multicast address: 239.192.1.32
    10: "00",  # address conflict detection
    11: "00" * 35,  # last conflict
    12: "00",  # quick connect
    13: "7800",  # encapsulation inactivity: 120 s
}
COUNTERS = "00" * 44, "00" * 48
SPEEDS = "02000000 04 0A00 00 0A00 01 6400 00 6400 01"
PORT_1 = {
    1: "64000000",  # 100 Mbit/s
    2: "0F000000",  # link, full duplex, negotiated
    3: "02A0B0C0D0E0",
    4: COUNTERS[0],
    5: COUNTERS[1],
    6: "0100 0000",
    7: "02",  # twisted pair
    8: "01",
    9: "01",
    10: "06 506F72742031",  # Port 1
    11: SPEEDS,
}
PORT_2 = {**PORT_1, 1: "00000000", 2: "00000000", 8: "02", 10: "06 506F72742032"}
DSCP = {4: "37", 5: "2F", 6: "2B", 7: "1F", 8: "1B"}
ALL = [("F5", "01", TCP_IP), ("F6", "01", PORT_1), ("F6", "02", PORT_2), ("48", "01", DSCP)]


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (f"20{class_id} 24{instance} 30{number:02X}", value)
        for class_id, instance, values in ALL
        for number, value in values.items()
    ],
)
def test_each_attribute(bench: Any, path: str, value: str) -> None:
    assert bench.ask(f"0E03 {path}") == bytes.fromhex(f"8E00 0000 {value}")


@pytest.mark.parametrize(("class_id", "instance", "values"), ALL[:3])
def test_all_attributes_at_once(
    bench: Any, class_id: str, instance: str, values: dict[int, str]
) -> None:
    """Get_Attributes_All returns all attributes of an object, also for both network connectors.

    Source: manual chapter 1, 3.1
    """
    everything = " ".join(values.values())
    assert bench.ask(f"0102 20{class_id} 24{instance}") == bytes.fromhex(f"8100 0000 {everything}")


@pytest.mark.parametrize(
    ("class_id", "revision", "greatest", "number", "attributes"),
    [
        ("01", "0100", "0100", "0100", "0800"),
        ("02", "0100", "0100", "0100", "0000"),
        ("04", "0200", "9600", "0200", "0400"),
        ("06", "0100", "0100", "0100", "0000"),
        ("48", "0100", "0100", "0100", "0800"),
        ("F5", "0400", "0100", "0100", "0D00"),
        ("F6", "0400", "0200", "0200", "0B00"),
    ],
)
def test_class_attributes(
    bench: Any, class_id: str, revision: str, greatest: str, number: str, attributes: str
) -> None:
    """A class has the attributes revision (1), greatest instance (2) and number of instances (3).

    Attributes 6 and 7 are the greatest attribute numbers of class and instance.
    """
    values = {"01": revision, "02": greatest, "03": number, "06": "0700", "07": attributes}
    for attribute, value in values.items():
        reply = bench.ask(f"0E03 20{class_id} 2400 30{attribute}")
        assert reply == bytes.fromhex(f"8E00 0000 {value}"), attribute
    assert bench.ask(f"0E03 20{class_id} 2400 3008")[2] == 0x14
    assert bench.ask(f"1003 20{class_id} 2400 3001 0000")[2] == 0x0E


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("20F5 2401 3003", "00000000"),
        ("20F5 2401 300D", "0000"),
        ("20F5 2401 300D", "100E"),  # 3600 s
        ("2048 2401 3004", "00"),
        ("2048 2401 3005", "3F"),
        ("2048 2401 3006", "01"),
        ("2048 2401 3007", "02"),
        ("2048 2401 3008", "03"),
    ],
)
def test_a_settable_attribute_is_read_back(bench: Any, path: str, value: str) -> None:
    assert bench.ask(f"1003 {path} {value}") == bytes.fromhex("9000 0000")
    assert bench.ask(f"0E03 {path}") == bytes.fromhex(f"8E00 0000 {value}")


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        ("1003 20F5 2401 3003 02000000", 0x09),  # DHCP
        ("1003 20F5 2401 300D 110E", 0x09),  # 3601 s
        ("1003 2048 2401 3004 40", 0x09),  # 64
        ("1003 20F5 2401 300D 78", 0x13),
        ("1003 20F5 2401 300D 780000", 0x15),
        ("1003 2048 2401 3004", 0x13),
        ("1003 2048 2401 3004 0000", 0x15),
        ("1003 20F5 2401 3001 01000000", 0x0E),
        ("1003 20F5 2401 3005" + "00" * 22, 0x0E),
        ("1003 20F6 2401 3006 01000000", 0x0E),
        ("1003 20F5 2401 300E 00", 0x14),
        ("1003 2048 2401 3001 00", 0x14),
        ("0E03 20F6 2401 300C", 0x14),
        ("0E03 20F6 2403 3001", 0x05),
        ("0102 2048 2401", 0x08),
        ("0102 2006 2401", 0x08),
        ("0502 20F5 2401", 0x08),
    ],
)
def test_a_refused_request_changes_nothing(bench: Any, request_: str, status: int) -> None:
    service = bytes.fromhex(request_)[0]
    assert bench.ask(request_) == bytes([service | 0x80, 0, status, 0])
    assert bench.ask("0E03 20F5 2401 300D") == bytes.fromhex("8E00 0000 7800")
    assert bench.ask("0E03 2048 2401 3004") == bytes.fromhex("8E00 0000 37")


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("20F5 2401 300D", "0100"),  # TCP connections are closed after 1 s without messages
        ("20F5 2401 3003", "00000000"),
        ("2048 2401 3005", "00"),  # the code point of cyclic packets
        ("2048 2401 3008", "00"),
        ("2004 2496 3003", "00" * 48),
    ],
)
def test_while_a_master_owns_the_outputs_nothing_is_set(bench: Any, path: str, value: str) -> None:
    """While a master owns the outputs, setting an attribute gets status 0x0C for every client.

    Without a master, the attribute can be set.
    """
    before = bench.ask(f"0E03 {path}")
    bench.ask(forward_open())
    for peer in ("192.168.0.10", "192.168.0.99"):
        asked = bench.ask(f"1003 {path} {value}", Origin(peer, "192.168.0.2", 1))
        assert asked == bytes.fromhex("9000 0C00")
    assert bench.ask(f"0E03 {path}") == before
    bench.ask(forward_close())
    assert bench.ask(f"1003 {path} {value}") == bytes.fromhex("9000 0000")


def test_new_connections_have_the_code_points_that_were_set(bench: Any) -> None:
    objects = bench.device.objects
    assert [objects.dscp(priority) for priority in range(4)] == [31, 43, 47, 55]
    assert objects.explicit_dscp == 27
    for number, value in ((7, "01"), (6, "02"), (5, "03"), (4, "04"), (8, "05")):
        bench.ask(f"1003 2048 2401 30{number:02X} {value}")
    assert [objects.dscp(priority) for priority in range(4)] == [1, 2, 3, 4]
    assert objects.explicit_dscp == 5


def test_a_list_that_does_not_fit_into_a_reply_is_refused(bench: Any) -> None:
    """If a reply would be too long (1000 times 48 bytes), the request gets status 0x11."""
    assert bench.ask("0302 2004 2464 E803" + "0300" * 1000) == bytes.fromhex("8300 1100")
    assert len(bench.ask("0302 2004 2464 4B00" + "0300" * 75)) == 4 + 2 + 75 * 52
