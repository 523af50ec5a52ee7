"""The network between a master and the controller's adapter: in lock-step, or in real time.

In lock-step every packet is a real exchange that ends before virtual time continues. In real time
both areas travel by cyclic I/O, as between a PLC and the controller.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rcx_harness.enip.cyclic.shared import SharedImages
from rcx_harness.enip.errors import CipError, EnipError, ProcessDiedError
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.spec.wire import SIZE, TO_MASTER, TO_ROBOT

__all__ = ["Class1Link", "LockstepLink"]


class _Link:
    """The common part of both links: the robot's end uses the adapter's memory."""

    name = "enip"

    def __init__(self, size: int, adapter: Adapter) -> None:
        self.size = size
        self.adapter = adapter

    def robot_read(self) -> bytes:
        """Return assembly 150, as the controller's adapter received it last."""
        return self.adapter.read_to_robot()

    def robot_write(self, image: bytes) -> None:
        """Set assembly 100, which the master reads or the next packets carry."""
        self.adapter.write_to_master(image)


class LockstepLink(_Link):
    """A `rcx_harness.cell.link.Link` over EtherNet/IP on the loopback interface.

    The two calls of the master are explicit messages to the adapter's process and return after its
    answer. The two calls of the robot access the adapter's memory. So every call sees the effect
    of all calls before it, as with a `DirectLink`.

    Raises:
        InputError: another size, or the adapter did not start.
        ProcessDiedError: from every call of the scanner's: the adapter's process has ended.
    """

    def __init__(self, size: int = SIZE) -> None:
        super().__init__(size, Adapter(size))
        try:
            self._client = Client(*self.adapter.address)
        except BaseException:
            self.adapter.close()
            raise

    def scanner_write(self, image: bytes) -> None:
        """Set assembly 150 by Set_Attribute_Single."""
        with self._telling_of_its_end():
            self._client.set_assembly(TO_ROBOT, image)

    def scanner_read(self) -> bytes:
        """Return assembly 100 by Get_Attribute_Single."""
        with self._telling_of_its_end():
            return self._client.get_assembly(TO_MASTER)

    def close(self) -> None:
        """End the session and the adapter's process; more than once does no harm."""
        self._client.close()
        self.adapter.close()

    @contextmanager
    def _telling_of_its_end(self) -> Iterator[None]:
        """Raise ProcessDiedError instead of a time-out if the adapter's process has died."""
        try:
            yield
        except CipError:
            raise
        except EnipError:
            if failure := self.adapter.wait_for_failure():
                raise ProcessDiedError(failure) from None
            raise


class Class1Link(_Link):
    """A `rcx_harness.cell.link.Link` over one exclusive-owner connection on the loopback interface.

    No call waits: it returns the data that arrived last, or sets the data to send next.
    `scanner.open()` opens the connection, also after a loss. `scanner.read().connected` (master)
    and `shared.status().owner` (robot) show whether it is alive.

    Args:
        multiplier: Connection time-out multiplier as coded: 0 to 7 for 4 to 512 intervals.
        address: Loopback address of the adapter and of the scanner; their ports are free ones.

    Attributes:
        shared: Both areas at the robot's end, and the state of the connection.
    """

    def __init__(
        self,
        size: int = SIZE,
        rpi_us: int = 10_000,
        multiplier: int = 2,
        address: str = "127.0.0.1",
    ) -> None:
        options = AdapterOptions(rpi_min_us=1_000)
        super().__init__(size, Adapter(size, host=address, cyclic=0, options=options))
        self.shared: SharedImages = self.adapter.shared
        try:
            self.scanner = Scanner(
                *(address, size, rpi_us),
                multiplier=multiplier,
                address=address,
                io_port=0,
                port=self.adapter.address[1],
            )
        except BaseException:
            self.adapter.close()
            raise

    @property
    def failure(self) -> str:
        """Return which process ended by itself, and how; empty while all run."""
        return self.adapter.failure or self.scanner.failure

    def scanner_write(self, image: bytes) -> None:
        """Set the data of the master's next packets, with the run state."""
        self.scanner.write(image)

    def scanner_read(self) -> bytes:
        """Return the data that the master received last."""
        return self.scanner.read().image

    def close(self) -> None:
        """Close the connection and end both processes; more than once does no harm."""
        self.scanner.close()
        self.adapter.close()
