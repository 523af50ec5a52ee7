"""The public clients cpppo, pycomm3 and pylogix read the adapter's identity and assemblies.

The client of cpppo runs in a separate process. pycomm3 sends unconnected messages without a route,
except in one test. For pylogix, a device without a route is a Micro800.
"""

from __future__ import annotations

import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import pycomm3
import pylogix
import pytest

from rcx_harness.enip.target.adapter import Adapter

Pycomm = Callable[..., Any]

TO_MASTER = bytes(range(1, 49))
TO_ROBOT = bytes(range(101, 149))
GET_ALL, GET_LIST, GET_SINGLE, SET_SINGLE = 0x01, 0x03, 0x0E, 0x10
#: Get_Attributes_All of the Identity object: vendor 636 (0x027C), type 43 (0x2B), product 5,
#: revision 1.1, status 0x0030, serial number 1, product name with its length (0x17).
IDENTITY = bytes.fromhex("7C02 2B00 0500 0101 3000 01000000 17") + b"RCX3 virtual controller"


@pytest.fixture(scope="module")
def adapter() -> Iterator[Adapter]:
    with Adapter(48) as running:
        running.write_to_master(TO_MASTER)
        yield running


@pytest.fixture
def pycomm(adapter: Adapter) -> Iterator[Pycomm]:
    with pycomm3.CIPDriver(name_of(adapter)) as client:
        yield partial(client.generic_message, connected=False, route_path=False)


@pytest.fixture
def logix(adapter: Adapter) -> Iterator[Any]:
    host, port = adapter.address
    with pylogix.PLC(host, port=port, Micro800=True) as client:
        yield client


@pytest.fixture(autouse=True)
def _nothing_written(adapter: Adapter, pycomm: Pycomm) -> None:
    """Set assembly 150 to zero before each test."""
    pycomm(SET_SINGLE, 4, 150, 3, request_data=bytes(48))
    assert adapter.read_to_robot() == bytes(48)


def name_of(adapter: Adapter) -> str:
    host, port = adapter.address
    return f"{host}:{port}"


def cpppo_client(adapter: Adapter, *operations: str, simple: bool = True) -> list[str]:
    """Run cpppo's command line client, and return the result that it prints for each operation."""
    command = [sys.executable, "-m", "cpppo.server.enip.get_attribute"]
    command += ["--address", name_of(adapter), *(["--simple"] if simple else []), *operations]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    return [line.split("@", 1)[1] for line in done.stdout.splitlines() if "@" in line]


def logix_data(answer: Any) -> bytes:
    """Return the data of the CIP reply in an answer of pylogix."""
    assert answer.Status == "Success"
    frame: bytes = answer.Value
    # Header, interface handle and time-out, two items, then the four bytes of the reply.
    (length,) = struct.unpack_from("<H", frame, 38)
    assert len(frame) == 40 + length
    return frame[44:]


def test_cpppo_reads_the_identity(adapter: Adapter) -> None:
    (shown,) = cpppo_client(adapter, "@1/1")
    assert shown == f"0x0001/1 == {list(IDENTITY)}"


def test_cpppo_reads_by_unconnected_send_to_the_device_itself(adapter: Adapter) -> None:
    """Without --simple, cpppo sends an Unconnected Send with a route over port 1, address 0."""
    (shown,) = cpppo_client(adapter, "@4/100/4", simple=False)
    assert shown == "0x0004/100/4 == [48, 0]"


def test_cpppo_reads_and_writes_the_assemblies(adapter: Adapter) -> None:
    values = ",".join(map(str, TO_ROBOT))
    shown = cpppo_client(adapter, "@4/100/3", "@4/100/4", f"@4/150/3=(USINT){values}")
    assert shown == [
        f"0x0004/100/3 == {list(TO_MASTER)}",
        "0x0004/100/4 == [48, 0]",
        "0x0004/150/3 == True",
    ]
    assert adapter.read_to_robot() == TO_ROBOT


def test_pycomm3_lists_the_identity(adapter: Adapter) -> None:
    identity = pycomm3.CIPDriver.list_identity(name_of(adapter))
    assert identity is not None
    assert identity["product_name"] == "RCX3 virtual controller"
    assert identity["revision"] == {"major": 1, "minor": 1}
    assert (identity["product_code"], identity["serial"]) == (5, "00000001")
    assert identity["ip_address"] == adapter.address[0]


def test_pycomm3_reads_the_identity(pycomm: Pycomm) -> None:
    answer = pycomm(GET_ALL, 1, 1)
    assert (answer.error, answer.value) == (None, IDENTITY)


def test_pycomm3_reads_and_writes_the_assemblies(adapter: Adapter, pycomm: Pycomm) -> None:
    answer = pycomm(GET_SINGLE, 4, 100, 3)
    assert (answer.error, answer.value) == (None, TO_MASTER)
    assert pycomm(SET_SINGLE, 4, 150, 3, request_data=TO_ROBOT).error is None
    assert adapter.read_to_robot() == TO_ROBOT


def test_pycomm3_reads_the_assemblies_over_a_connection_of_class_3(adapter: Adapter) -> None:
    """pycomm3 opens a class 3 connection with a Large Forward Open, then sends SendUnitData."""
    with pycomm3.CIPDriver(name_of(adapter)) as client:
        answer = client.generic_message(GET_SINGLE, 4, 100, 3)
        assert client.connected
    assert (answer.error, answer.value) == (None, TO_MASTER)


@pytest.mark.parametrize("route", ["", "/bp/0"])
@pytest.mark.parametrize("wrapped", [False, True])
def test_pycomm3_reads_with_the_route_that_it_sends_by_default(
    adapter: Adapter, route: str, wrapped: bool
) -> None:
    """Reading works if pycomm3 appends a route to the request, or uses an Unconnected Send."""
    with pycomm3.CIPDriver(name_of(adapter) + route) as client:
        ask = partial(client.generic_message, connected=False, unconnected_send=wrapped)
        read = [ask(GET_SINGLE, 4, 100, 3), ask(GET_ALL, 1, 1)]
        listed = ask(GET_LIST, 1, 1, request_data=bytes.fromhex("0100 0100"))
    assert [(one.error, one.value) for one in read] == [(None, TO_MASTER), (None, IDENTITY)]
    assert (listed.error, listed.value) == (None, bytes.fromhex("0100 0100 0000 7C02"))


def test_pycomm3_reports_a_refusal(pycomm: Pycomm) -> None:
    assert "Destination unknown" in pycomm(GET_SINGLE, 4, 101, 3).error


def test_pylogix_reads_the_identity(logix: Any) -> None:
    assert logix_data(logix.Message(GET_ALL, 1, 1)) == IDENTITY
    device = logix.GetDeviceProperties().Value
    assert (device.VendorID, device.DeviceID, device.ProductCode) == (636, 43, 5)
    assert device.ProductName == "RCX3 virtual controller"


def test_pylogix_reads_and_writes_the_assemblies(adapter: Adapter, logix: Any) -> None:
    assert logix_data(logix.Message(GET_SINGLE, 4, 100, 3)) == TO_MASTER
    assert logix_data(logix.Message(SET_SINGLE, 4, 150, 3, TO_ROBOT)) == b""
    assert adapter.read_to_robot() == TO_ROBOT


def test_pylogix_reports_a_refusal(logix: Any) -> None:
    assert logix.Message(GET_SINGLE, 4, 101, 3).Status == "Path destination unknown"
