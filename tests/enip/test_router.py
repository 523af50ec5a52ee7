"""CIP requests to the device's objects get the specified replies, byte by byte.

Request: service, path size in words, path, data. Reply: service + 0x80, 0, status, 0, data.
"""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.enip.options import Identity

NAME = b"RCX3 virtual controller".hex()
ATTRIBUTES_1_TO_7 = f"7C02 2B00 0500 0101 3000 01000000 17{NAME}"


def test_identity_gives_all_its_attributes(bench: Any) -> None:
    """Get_Attributes_All of the Identity object returns all seven attributes.

    They are vendor 636, device type 43, product code 5, revision 1.1, status, serial number and
    name.

    Source: manual chapter 5, 4 (device type)
    """
    assert bench.ask("0102 2001 2401") == bytes.fromhex(f"8100 0000 {ATTRIBUTES_1_TO_7}")


@pytest.mark.parametrize(
    ("attribute", "value"),
    [
        *(("01", "7C02"), ("02", "2B00"), ("03", "0500"), ("04", "0101"), ("05", "3000")),
        *(("06", "01000000"), ("07", f"17{NAME}"), ("08", "03")),
    ],
)
def test_identity_gives_each_attribute(bench: Any, attribute: str, value: str) -> None:
    assert bench.ask(f"0E03 2001 2401 30{attribute}") == bytes.fromhex(f"8E00 0000 {value}")


def test_a_list_of_attributes_is_answered_with_a_status_for_each(bench: Any) -> None:
    """The reply to a list has the number, status and value of each attribute.

    One attribute of the list does not exist, so its status is not 0.
    """
    assert bench.ask("0302 2001 2401 0300 0100 6300 0800") == bytes.fromhex(
        "8300 0A00 0300 0100 0000 7C02 6300 1400 0800 0000 03"
    )
    assert bench.ask("0302 2001 2401 0100 0200") == bytes.fromhex("8300 0000 0100 0200 0000 2B00")


@pytest.mark.parametrize(
    "request_", ["0302 2001 2401", "0302 2001 2401 01", "0302 2001 2401 0200 0100"]
)
def test_a_list_that_is_shorter_than_its_count_is_refused(bench: Any, request_: str) -> None:
    """A list with fewer attributes than its count gets status 0x13, not enough data."""
    assert bench.ask(request_) == bytes.fromhex("8300 1300")


@pytest.mark.parametrize("extra", ["00", "0000", "0100 0100", "FF" * 20])
@pytest.mark.parametrize(
    "request_", ["0E03 2004 2464 3004", "0102 2001 2401", "0302 2001 2401 0100 0100"]
)
def test_bytes_behind_a_read_request_are_ignored(bench: Any, request_: str, extra: str) -> None:
    """Bytes after a read request are ignored, because some clients append their route there.

    Source: OpENer (the open reference adapter), GetAttributeSingle and its siblings
    """
    assert bench.ask(request_ + extra) == bench.ask(request_)
    assert bench.ask(request_ + extra)[2] == 0


@pytest.mark.parametrize("route", ["0000", "0100 0100"])
def test_a_write_with_bytes_after_its_data_is_refused(bench: Any, route: str) -> None:
    """A write request with bytes after its data gets status 0x15, as in OpENer.

    The device cannot know where the data end.
    """
    asked = "1003 2004 2496 3003" + "11" * 48 + route
    assert bench.ask(asked) == bytes.fromhex("9000 1500")
    assert bench.to_robot == bytes(48)


def test_the_master_reads_what_the_robot_has_written(bench: Any) -> None:
    """The master reads the robot's 48 bytes from assembly 100.

    Source: manual chapter 1, 4.1
    """
    bench.master_image.data = bytes(range(48))
    assert bench.ask("0E03 2004 2464 3003") == bytes.fromhex("8E000000") + bytes(range(48))


def test_the_robot_finds_what_the_master_has_written(bench: Any) -> None:
    """The robot receives the 48 bytes that the master writes to assembly 150.

    Source: manual chapter 1, 4.1
    """
    image = bytes(range(100, 148))
    assert bench.ask("1003 2004 2496 3003" + image.hex()) == bytes.fromhex("9000 0000")
    assert bench.to_robot == image
    assert bench.ask("0E03 2004 2496 3003") == bytes.fromhex("8E000000") + image
    assert bench.to_master == bytes(48)


@pytest.mark.parametrize(
    "path",
    [
        "04 2100 0400 2464 3004",  # a class with 16 bits
        "04 2004 2500 6400 3004",  # an instance with 16 bits
        "04 2004 2464 3100 0400",  # an attribute with 16 bits
        "03 2004 2C64 3004",  # a connection point in place of an instance
        "08 3404 0000 0000 0000 0000 2004 2464 3004",  # an electronic key that fits any device
    ],
)
def test_a_path_may_be_written_in_other_ways(bench: Any, path: str) -> None:
    assert bench.ask(f"0E{path}") == bytes.fromhex("8E00 0000 3000")


@pytest.mark.parametrize(
    ("key", "status"),
    [
        ("7C02 2B00 0500 01 01", 0x00),
        ("7C02 0000 0000 01 00", 0x00),
        ("7C02 2B00 0500 81 00", 0x00),  # compatible with revision 1 and any minor revision
        ("7D02 2B00 0500 01 01", 0x25),
        ("7C02 2C00 0500 01 01", 0x25),
        ("7C02 2B00 0600 01 01", 0x25),
        ("7C02 2B00 0500 02 01", 0x25),
        ("7C02 2B00 0500 01 02", 0x25),
        ("7C02 2B00 0500 81 02", 0x25),  # compatible, but the key demands a newer minor revision
    ],
)
def test_an_electronic_key_must_fit_the_identity(bench: Any, key: str, status: int) -> None:
    reply = bench.ask(f"0E08 3404 {key} 2004 2464 3004")
    assert reply[:4] == bytes([0x8E, 0, status, 0])


@pytest.mark.parametrize(("major", "status"), [("81", 0x00), ("01", 0x25)])
def test_a_newer_device_matches_a_key_for_compatible_devices(
    make_bench: Any, major: str, status: int
) -> None:
    identity = Identity(minor_revision=3)
    reply = make_bench(identity=identity).ask(f"0E08 3404 7C02 2B00 0500 {major} 02 2004 2464 3004")
    assert reply[:4] == bytes([0x8E, 0, status, 0])


@pytest.mark.parametrize(
    ("why", "request_", "status"),
    [
        ("class unknown", "0E03 2005 2401 3001", 0x05),
        ("instance unknown", "0E03 2004 2465 3003", 0x05),
        ("no class in the path", "0E02 2464 3003", 0x05),
        ("no path", "0E00", 0x05),
        ("attribute unknown", "0E03 2004 2464 3005", 0x14),
        ("attribute 0", "0E03 2004 2464 3000", 0x14),
        ("no attribute in the path", "0E02 2004 2464", 0x14),
        ("attribute unknown, to be set", "1003 2004 2496 3007 00", 0x14),
        ("service unknown", "4C03 2004 2464 3003", 0x08),
        ("service unknown, on the router", "4C02 2002 2401", 0x08),
        ("reset of a class", "0502 2001 2400", 0x08),
        ("an assembly has no Get_Attributes_All", "0102 2004 2464", 0x08),
        ("class unknown and service unknown", "4C02 2005 2401", 0x05),
        ("path longer than the request", "0E04 2004 2464 3003", 0x04),
        ("symbolic segment", "0E03 9104 41424344", 0x04),
        ("port segment", "0E03 0100 2004 2464", 0x04),
        ("instance given twice", "0E04 2004 2464 2464 3003", 0x04),
        ("16-bit segment cut off", "0E03 2004 2464 3100", 0x04),
        ("key cut off", "0E02 3404 7C02", 0x04),
        ("key of another format", "0E08 3405 0000 0000 0000 0000 2004 2464 3004", 0x04),
        ("key behind the class", "0E06 2004 3404 0000 0000 0000 0000", 0x04),
        ("assembly 100 is the robot's", "1003 2004 2464 3003" + "00" * 48, 0x0E),
        ("the size is fixed", "1003 2004 2496 3004 3000", 0x0E),
        ("the identity is fixed", "1003 2001 2401 3001 0100", 0x0E),
        ("47 bytes", "1003 2004 2496 3003" + "11" * 47, 0x13),
        ("49 bytes", "1003 2004 2496 3003" + "11" * 49, 0x15),
        ("no bytes", "1003 2004 2496 3003", 0x13),
    ],
)
def test_a_refused_request_gets_its_status_and_changes_nothing(
    bench: Any, why: str, request_: str, status: int
) -> None:
    service = bytes.fromhex(request_)[0]
    assert bench.ask(request_) == bytes([service | 0x80, 0, status, 0]), why
    assert bench.to_master == bytes(48)
    assert bench.to_robot == bytes(48)


def test_a_path_without_an_instance_is_the_class(bench: Any) -> None:
    """A path with a class only is a path to the class object, here to its revision."""
    assert bench.ask("0E02 2004 3001") == bytes.fromhex("8E00 0000 0200")
