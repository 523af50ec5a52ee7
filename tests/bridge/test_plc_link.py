"""The bridge reads and writes registers over Modbus TCP. The PLC is a pymodbus server."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from pymodbus.constants import ExcCodes

from modbus_plc import ModbusPlc
from rcx_harness.bridge.core import Registers
from rcx_harness.bridge.plc import PlcError, PlcLink

_LONG_S = 30.0
_SHORT_S = 0.05


@pytest.fixture(scope="module")
def server() -> Iterator[ModbusPlc]:
    with ModbusPlc() as made:
        yield made


@pytest.fixture
def plc(server: ModbusPlc) -> ModbusPlc:
    """Return the Modbus server with empty registers and no pending faults."""
    server.holds.clear()
    server.requests.clear()
    server.refuses, server.deaf = None, False
    return server


@pytest.fixture
def link_to(plc: ModbusPlc) -> Iterator[Callable[..., PlcLink]]:
    """Return a function that makes connected links. They are closed after the test."""
    links: list[PlcLink] = []

    def make(*registers: int, unit: int = 1, timeout_s: float = _LONG_S) -> PlcLink:
        area = Registers(*registers)
        link = PlcLink("127.0.0.1", plc.port, area, unit=unit, timeout_s=timeout_s)
        link.connect()
        links.append(link)
        return link

    yield make
    for link in links:
        link.close()


def test_the_plcs_outputs_are_read_and_its_memory_is_written_by_one_request_each(
    plc: ModbusPlc, link_to: Callable[..., PlcLink]
) -> None:
    """In OpenPLC, %QW0 is holding register 0 and %MW0 is holding register 1024."""
    plc.holds.update({0: 0x1234, 23: 0xFFFF, 24: 7})
    link = link_to()
    assert link.read() == (0x1234, *[0] * 22, 0xFFFF, 7)
    link.write(range(100, 125))
    assert [plc.holds[1024 + k] for k in range(25)] == list(range(100, 125))
    assert plc.requests == [(3, 0, 25), (16, 1024, 25)]


def test_256_bytes_take_two_requests_and_the_life_word_comes_last(
    plc: ModbusPlc, link_to: Callable[..., PlcLink]
) -> None:
    plc.holds.update({2 + k: k for k in range(129)})
    link = link_to(2, 1030, 256)
    assert link.read() == tuple(range(129))
    link.write(range(1000, 1129))
    assert [plc.holds[1030 + k] for k in range(129)] == list(range(1000, 1129))
    assert plc.requests == [(3, 2, 120), (3, 122, 9), (16, 1030, 120), (16, 1150, 9)]


def test_registers_that_the_plc_does_not_have_are_named(link_to: Callable[..., PlcLink]) -> None:
    link = link_to(190)
    with pytest.raises(PlcError) as refused:
        link.read()
    assert "reading of holding registers 190 to 214 was refused: Modbus exception 2, " in str(
        refused.value
    )
    assert "illegal data address; check that the PLC has these registers" in str(refused.value)
    link = link_to(0, 1210)
    with pytest.raises(PlcError, match="writing of holding registers 1210 to 1234 was refused"):
        link.write(range(25))


def test_after_a_refusal_the_connection_stays(
    plc: ModbusPlc, link_to: Callable[..., PlcLink]
) -> None:
    link = link_to()
    plc.refuses = ExcCodes.DEVICE_BUSY
    with pytest.raises(PlcError, match="Modbus exception 6, device busy"):
        link.read()
    assert link.connected
    plc.refuses = None
    assert link.read() == (0,) * 25


def test_a_plc_may_refuse_another_unit_identifier(link_to: Callable[..., PlcLink]) -> None:
    with pytest.raises(PlcError, match="was refused: Modbus exception"):
        link_to(unit=9).read()


def test_a_late_answer_closes_the_connection(
    plc: ModbusPlc, link_to: Callable[..., PlcLink]
) -> None:
    """After a late answer the link is closed, so the answer cannot be used for the next request."""
    link = link_to(timeout_s=_SHORT_S)
    plc.deaf = True
    with pytest.raises(PlcError, match="holding registers 0 to 24: no answer within 50 ms"):
        link.read()
    assert not link.connected
    plc.deaf = False
    with pytest.raises(PlcError, match="no Modbus TCP connection"):
        link.read()
    link.connect()
    link.connect()


def test_the_link_reconnects_to_a_plc_that_restarts(
    plc: ModbusPlc, link_to: Callable[..., PlcLink]
) -> None:
    link = link_to()
    assert link.read() == (0,) * 25
    plc.stop()
    with pytest.raises(PlcError):
        link.read()
    with pytest.raises(PlcError, match=r"no Modbus TCP connection to 127\.0\.0\.1:.*refused"):
        link.connect()
    plc.start()
    link.connect()
    assert link.read() == (0,) * 25


@pytest.mark.parametrize("host", ["no.such.host.invalid", "x" * 300])
def test_an_invalid_host_name_is_reported(host: str) -> None:
    with pytest.raises(PlcError, match="no Modbus TCP connection to"):
        PlcLink(host, 502, Registers()).connect()
