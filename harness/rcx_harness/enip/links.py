"""The link between a master and the controller's adapter, in lock-step with virtual time.

Every packet is a real exchange that ends before virtual time continues.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rcx_harness.enip.errors import CipError, EnipError, ProcessDiedError
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.spec.wire import SIZE, TO_MASTER, TO_ROBOT

__all__ = ["AdapterLink", "LockstepLink"]


class AdapterLink:
    """The robot's end of a link to an adapter; it accesses the adapter's memory."""

    name = "enip"

    def __init__(self, size: int, adapter: Adapter) -> None:
        self.size = size
        self.adapter = adapter

    def robot_read(self) -> bytes:
        """Return the content of assembly 150 that the adapter has received last."""
        return self.adapter.read_to_robot()

    def robot_write(self, image: bytes) -> None:
        """Set assembly 100. The master reads it, or the next packets carry it to the master."""
        self.adapter.write_to_master(image)


class LockstepLink(AdapterLink):
    """A `rcx_harness.cell.link.Link` over EtherNet/IP on the loopback interface.

    The methods `scanner_...` send explicit messages to the adapter's process and return after its
    answer. The methods `robot_...` access the adapter's memory. As with a `DirectLink`, each call
    therefore uses the results of all earlier calls.

    Raises:
        InputError: the size is wrong, or the adapter did not start.
        ProcessDiedError: the adapter's process has ended (raised by the methods `scanner_...`).
    """

    def __init__(self, size: int = SIZE) -> None:
        super().__init__(size, Adapter(size))
        try:
            self._client = Client(*self.adapter.address)
        except BaseException:
            self.adapter.close()
            raise

    def scanner_write(self, image: bytes) -> None:
        """Set assembly 150 with a Set_Attribute_Single request."""
        with self._telling_of_its_end():
            self._client.set_assembly(TO_ROBOT, image)

    def scanner_read(self) -> bytes:
        """Return assembly 100, read with a Get_Attribute_Single request."""
        with self._telling_of_its_end():
            return self._client.get_assembly(TO_MASTER)

    def close(self) -> None:
        """End the session and the adapter's process; a second call does nothing."""
        self._client.close()
        self.adapter.close()

    @contextmanager
    def _telling_of_its_end(self) -> Iterator[None]:
        """Raise ProcessDiedError instead of EnipError if the adapter's process has ended."""
        try:
            yield
        except CipError:
            raise
        except EnipError:
            if failure := self.adapter.wait_for_failure():
                raise ProcessDiedError(failure) from None
            raise
