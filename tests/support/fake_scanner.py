"""A scanner without a network, for tests of code that opens and watches connections."""

from __future__ import annotations

from rcx_harness.enip.cyclic.connections import EndReason
from rcx_harness.enip.errors import CipError
from rcx_harness.enip.originator.scanner import Received, Scanner, ScannerStatistics


class FakeScanner(Scanner):
    """A scanner that behaves as its attributes say.

    Attributes:
        ended: Reason for the end of its connection.
        failure: Reason for the end of its process.
        connected: Whether packets arrive.
        dropped: Why packets are dropped; empty if they are not.
        refusal: The error that `open` raises, if it is not None.
        done: The names of the calls in their order.
        written: The written images, each with the time until which it is valid.
    """

    failure = ""

    def __init__(self, refusal: CipError | None = None) -> None:
        self.ended: EndReason | None = None
        self.dropped = ""
        self.connected = False
        self.refusal = refusal
        self.done: list[str] = []
        self.written: list[tuple[bytes, int | None]] = []

    def open(self) -> None:
        """Record the call, or raise `refusal` if there is one."""
        self.done.append("open")
        if self.refusal is not None:
            raise self.refusal

    def read(self) -> Received:
        """Return an area in which every byte is 7."""
        return Received(bytes([7] * 48), 5, self.connected)

    def write(self, image: bytes, run: bool = True, valid_us: int | None = None) -> None:
        """Record the call."""
        assert run
        self.done.append("write")
        self.written.append((image, valid_us))

    def drops(self) -> str:
        """Return why packets are dropped."""
        return self.dropped

    def statistics(self) -> ScannerStatistics:
        """Return zeros."""
        return ScannerStatistics(0, 0, 0, 0, 0, 0, 0, 0)

    def close(self) -> None:
        """Record the call."""
        self.done.append("close")
