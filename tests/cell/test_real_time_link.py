"""A link over cyclic I/O has the same four calls as other links, and no call waits."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import Link
from rcx_harness.cell.live import RealTimeLink
from rcx_harness.enip.cyclic.connections import OwnerState
from structured_text.errors import InputError


def made(size: int, rpi_us: int) -> RealTimeLink:
    return RealTimeLink(size, Timing(10_000, rpi_us, 0, 512 * rpi_us))


@pytest.fixture
def link() -> Iterator[RealTimeLink]:
    link = made(48, 4_000)
    yield link
    link.close()


def eventually(link: RealTimeLink, condition: Callable[[], bool]) -> None:
    """Send requests to the adapter until the condition is true."""
    for _ in range(100_000):
        if condition():
            return
        link.scanner.client.get_attribute(1, 1, 1)
    raise AssertionError("the condition was not true within 100,000 requests")


def test_images_arrive_when_the_connection_is_open(link: RealTimeLink) -> None:
    assert isinstance(link, Link)
    assert (link.name, link.size) == ("enip-realtime", 48)
    assert link.scanner_read() == link.robot_read() == bytes(48)
    link.scanner_write(bytes(range(48)))
    link.robot_write(bytes(range(100, 148)))
    assert not link.scanner.read().connected
    link.scanner.open()
    eventually(link, lambda: link.robot_read() == bytes(range(48)))
    eventually(link, lambda: link.scanner_read() == bytes(range(100, 148)))
    # The connection state may lag behind the image, because it is written later.
    eventually(link, lambda: link.scanner.read().connected)
    assert link.shared.owner is OwnerState.RUN


def test_one_millisecond_is_accepted() -> None:
    link = made(256, 1_000)
    try:
        link.scanner.open()
        assert link.scanner.connection is not None
        assert link.scanner.connection.t_to_o_api_us == 1_000
        eventually(link, lambda: link.scanner.read().connected)
    finally:
        link.close()
        link.close()


def test_a_refused_interval_leaves_no_process() -> None:
    with pytest.raises(InputError, match="a packet interval of 10 us"):
        made(48, 10)
