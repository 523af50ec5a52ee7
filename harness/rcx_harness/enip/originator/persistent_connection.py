"""A master's connection that is opened again after every loss."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection

from rcx_harness.enip.errors import CipError
from rcx_harness.enip.originator.opening import Opener, refusal_hint
from rcx_harness.enip.originator.scanner import Received, Scanner, ScannerStatistics
from structured_text.errors import InputError

__all__ = ["WAITS", "PersistentConnection"]

WAITS = "no packets have arrived yet"


class PersistentConnection:
    """An exclusive-owner connection that is opened again after every loss.

    Reading and writing never wait; only the thread of the opener waits. Each new connection begins
    with zeros, because its first packet must not request anything.

    Args:
        connect: Function that returns a new scanner, or raises EnipError if the adapter does not
            answer.
        options: Options of the command that a hint in a message may name.

    Attributes:
        opener: The object that opens the connection again after each loss.
    """

    def __init__(
        self,
        name: str,
        size: int,
        connect: Callable[[], Scanner],
        options: Collection[str] = ("--size", "--rpi"),
    ) -> None:
        self.name = name
        self.opener = Opener(self._opened)
        self._connect, self._options = connect, options
        self._scanner: Scanner | None = None
        self._state = f"{name}: not connected yet"
        self._image = bytes(size)
        self._lock = threading.Lock()

    def received(self) -> Received | str:
        """Return the received data while packets arrive, otherwise the reason why none arrive."""
        with self._lock:
            if self._scanner is None:
                return self.opener.reason or self._state
            received = self._scanner.read()
            ended, failure = self._scanner.ended, self._scanner.failure
            drops = "" if received.connected else self._scanner.drops()
        if received.connected:
            return received
        reason = WAITS if ended is None else f"the connection has ended: {ended.value}"
        if ended is None and drops:
            reason = f"packets arrive, but cannot be used: they are {drops}"
        if failure:
            reason = f"{failure}; it is started again"
        return f"{self.name}: {reason}"

    def write(self, image: bytes, valid_us: int | None) -> None:
        """Set the data of the next packets.

        If `write` is not called again within `valid_us` microseconds, the packets stop. With None
        they never stop.
        """
        with self._lock:
            if self._scanner is not None:
                self._scanner.write(image, valid_us=valid_us)

    def look(self) -> tuple[ScannerStatistics, int | None] | None:
        """Return packet counters and the age of the last packet [us]; None without a scanner."""
        with self._lock:
            scanner = self._scanner
            return None if scanner is None else (scanner.statistics(), scanner.read().age_us)

    def close(self) -> None:
        """Close the connection: the robot loses its master (manual chapter 1, 5.2)."""
        with self._lock:
            scanner, self._scanner = self._scanner, None
        if scanner is not None:
            scanner.close()

    def _opened(self) -> Scanner:
        """Close the previous scanner, and return a new scanner with an open connection."""
        self._state = f"{self.name}: the connection is being opened"
        self.close()
        scanner = self._connect()
        scanner.write(self._image)
        try:
            scanner.open()
        except CipError as error:
            scanner.close()
            hint = refusal_hint(error, len(self._image), self._options)
            raise InputError(f"{self.name}: {error.message}", hint=hint) from None
        except BaseException:
            scanner.close()
            raise
        with self._lock:
            self._scanner = scanner
        return scanner
