"""The network in real time: both areas go by cyclic I/O, as between a PLC and the controller."""

from __future__ import annotations

from rcx_harness.enip.cyclic.shared import SharedImages
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter

__all__ = ["Class1Link"]


class Class1Link:
    """A `rcx_harness.cell.link.Link` over one exclusive-owner connection on the loopback interface.

    Nothing here waits: a call gives what has arrived last, or sets what goes out next. The
    connection is opened by `scanner.open()`, and anew by the same call after a loss; whether it
    lives, `scanner.read().connected` says at the master and `shared.status().owner` at the robot.

    Args:
        size: Bytes of each area, 48 or 256.
        rpi_us: Packet interval of both directions in microseconds, from 1 ms.
        multiplier: Connection time-out multiplier as coded: 0 to 7 for 4 to 512 intervals.
        address: Loopback address of the adapter and of the scanner; their ports are free ones.

    Attributes:
        adapter: The robot's end.
        scanner: The master's end.
        shared: Both areas at the robot's end, and the state of the connection.

    Raises:
        InputError: another size, interval or multiplier, or a process did not start.
    """

    name = "enip"

    def __init__(
        self,
        size: int = 48,
        rpi_us: int = 10_000,
        multiplier: int = 2,
        address: str = "127.0.0.1",
    ) -> None:
        self.size = size
        options = AdapterOptions(rpi_min_us=1_000)
        self.adapter = Adapter(size, host=address, cyclic=0, options=options)
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
        """Which of its processes has ended by itself, and how; empty as long as all run."""
        return self.adapter.failure or self.scanner.failure

    def scanner_write(self, image: bytes) -> None:
        """Set what the master's next packets carry; its program runs."""
        self.scanner.write(image)

    def scanner_read(self) -> bytes:
        """What the master has received last."""
        return self.scanner.read().image

    def robot_read(self) -> bytes:
        """What the controller's adapter has received last: assembly 150."""
        return self.shared.to_robot.read()

    def robot_write(self, image: bytes) -> None:
        """Set what the robot's next packets carry: assembly 100."""
        self.shared.to_master.write(image)

    def close(self) -> None:
        """Close the connection and end both processes; more than once does no harm."""
        self.scanner.close()
        self.adapter.close()
