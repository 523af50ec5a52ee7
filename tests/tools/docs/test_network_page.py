"""The EtherNet/IP adapter behaves as docs/how-to/network.md says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_harness.enip.codec.encapsulation import MAX_DATA
from rcx_harness.enip.cyclic.connections import ConnectionKind
from rcx_harness.enip.options import (
    CONFIGURATIONS,
    INACTIVITY_S,
    KINDS,
    RPI_MAX_US,
    AdapterOptions,
    Identity,
)
from rcx_harness.enip.target.connection_manager import (
    MAX_CYCLIC,
    MAX_EXPLICIT,
    MAX_EXPLICIT_OF_PEER,
)
from rcx_harness.enip.target.device import MAX_SESSIONS
from rcx_harness.enip.target.servers import (
    MAX_CONNECTIONS,
    MAX_CONNECTIONS_OF_PEER,
    MAX_DELAYED,
    MAX_DELAYED_OF_PEER,
)


@pytest.fixture
def page(repository: Path) -> str:
    return (repository / "docs/how-to/network.md").read_text(encoding="utf-8")


def row(page: str, head: str) -> list[str]:
    """Return the cells of the row with this name, except the first cell."""
    (found,) = re.findall(rf"^\| {re.escape(head)} \|(.*)\|$", page, re.MULTILINE)
    return [cell.strip() for cell in found.split("|")]


def test_connection_points_and_numbers_are_the_adapters(page: str) -> None:
    points = [f"{point} (heartbeat)" for point in list(KINDS)[1:]]
    assert row(page, "O→T connection point") == ["150", *points]
    kinds = (ConnectionKind.EXCLUSIVE_OWNER, ConnectionKind.INPUT_ONLY, ConnectionKind.LISTEN_ONLY)
    assert row(page, "At once") == [str(MAX_CYCLIC[kind]) for kind in kinds]
    numbers = list(map(str, CONFIGURATIONS))
    named = f"none, {', '.join(numbers[:-1])} or {numbers[-1]}, without data"
    assert row(page, "Configuration instance") == [named]
    (interval,) = row(page, "RPI")
    least, greatest = AdapterOptions().rpi_min_us / 1e3, RPI_MAX_US / 1e6
    assert interval.startswith(f"{least:g} ms to {greatest:g} s, ")


def test_the_electronic_key_is_the_identity(page: str) -> None:
    one = Identity()
    assert row(page, "Electronic key") == [
        f"none, or the identity's: vendor {one.vendor}, type {one.device_type}, product code "
        f"{one.product_code}, revision {one.major_revision}.{one.minor_revision}"
    ]


def test_the_limits_are_the_adapters(page: str) -> None:
    assert row(page, "TCP connections") == [
        f"{MAX_CONNECTIONS}, of one peer {MAX_CONNECTIONS_OF_PEER}"
    ]
    assert row(page, "Sessions") == [str(MAX_SESSIONS)]
    assert row(page, "Class 3 connections") == [
        f"{MAX_EXPLICIT}, of one peer {MAX_EXPLICIT_OF_PEER}"
    ]
    assert row(page, "Delayed answers to broadcasts")[0].startswith(
        f"{MAX_DELAYED}, of one peer {MAX_DELAYED_OF_PEER}; "
    )
    first_s = AdapterOptions().first_packet_us // 1_000_000
    assert row(page, "Time-out multiplier")[0].endswith(f"; the first packet has {first_s} s")
    assert row(page, "Data of a frame")[0].startswith(f"{MAX_DATA:,} bytes; ")
    silence = row(page, "Silence on a TCP connection")[0]
    assert silence.startswith(f"{INACTIVITY_S} s ")


def test_every_test_that_it_names_is_there(page: str, repository: Path) -> None:
    for file in re.findall(r"`(tests/[\w/.]+)`", page):
        assert (repository / file).exists(), file
