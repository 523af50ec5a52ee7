"""The network as the cell uses it: a packet is a real exchange, over before time goes on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rcx_harness.enip.errors import CipError, EnipError, ProcessDiedError
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.target.adapter import Adapter

__all__ = ["LockstepLink"]

_TO_MASTER, _TO_ROBOT = 100, 150


class LockstepLink:
    """A `rcx_harness.cell.link.Link` over EtherNet/IP on the loopback interface.

    The master's two calls are explicit messages to the adapter's process and return when it has
    answered; the robot's two go to the adapter's memory. So every call sees the effect of all
    calls before it, as with a `DirectLink`.

    Args:
        size: Bytes of each area, 48 or 256.

    Raises:
        InputError: another size, or the adapter did not start.
        ProcessDiedError: from every call of the scanner's: the adapter's process has ended.
    """

    name = "enip"

    def __init__(self, size: int = 48) -> None:
        self.size = size
        self._adapter = Adapter(size)
        try:
            self._client = Client(*self._adapter.address)
        except BaseException:
            self._adapter.close()
            raise

    def scanner_write(self, image: bytes) -> None:
        """Set assembly 150 by Set_Attribute_Single."""
        with self._telling_of_its_end():
            self._client.set_assembly(_TO_ROBOT, image)

    def scanner_read(self) -> bytes:
        """Return assembly 100 by Get_Attribute_Single."""
        with self._telling_of_its_end():
            return self._client.get_assembly(_TO_MASTER)

    def robot_read(self) -> bytes:
        """Return assembly 150 from the adapter's memory."""
        return self._adapter.read_to_robot()

    def robot_write(self, image: bytes) -> None:
        """Set assembly 100 in the adapter's memory."""
        self._adapter.write_to_master(image)

    def close(self) -> None:
        """End the session and the adapter's process; more than once does no harm."""
        self._client.close()
        self._adapter.close()

    @contextmanager
    def _telling_of_its_end(self) -> Iterator[None]:
        """That the adapter's process has died says more than that it does not answer."""
        try:
            yield
        except CipError:
            raise
        except EnipError:
            if failure := self._adapter.wait_for_failure():
                raise ProcessDiedError(failure) from None
            raise
