"""The robot's side of the bridge: a cyclic connection that is opened again after every loss."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Protocol

from rcx_harness.bridge.core import Lost, RobotSeen
from rcx_harness.enip.cyclic.connections import EndReason
from rcx_harness.enip.errors import CipError
from rcx_harness.enip.originator.scanner import Received, ScannerStatistics
from rcx_harness.errors import InputError

__all__ = ["MasterLink", "RobotLink", "open_hint"]

_WAITS = "packets have not come yet"


class MasterLink(Protocol):
    """What is needed of `rcx_harness.enip.originator.scanner.Scanner`."""

    ended: EndReason | None

    @property
    def failure(self) -> str: ...  # noqa: D102

    def open(self) -> None: ...  # noqa: D102

    def read(self) -> Received: ...  # noqa: D102

    def write(self, image: bytes, run: bool = True, valid_us: int | None = None) -> None: ...  # noqa: D102

    def statistics(self) -> ScannerStatistics: ...  # noqa: D102

    def close(self) -> None: ...  # noqa: D102


class RobotLink:
    """One exclusive-owner connection, as long as there is a robot.

    Reading and writing never wait. Whatever does (a connection is opened) is done by `keep`, which
    a thread of its own calls again and again.

    Args:
        name: Of the robot, in messages.
        size: Bytes of each area.
        connect: Makes the scanner; raises EnipError where the robot is not there.
    """

    def __init__(self, name: str, size: int, connect: Callable[[], MasterLink]) -> None:
        self.name = name
        self._connect = connect
        self._scanner: MasterLink | None = None
        self._reason = f"{name}: not connected yet"
        self._image = bytes(size)
        self._lock = threading.Lock()

    def open(self) -> None:
        """Connect and open; what was there before is closed.

        Raises:
            InputError: the robot is not there or refuses.
        """
        self._reason = f"{self.name}: the connection is being opened"
        self._drop()
        scanner = self._connect()
        scanner.write(self._image)  # zeros: the first packet must ask for nothing
        try:
            scanner.open()
        except CipError as error:
            scanner.close()
            raise InputError(f"{self.name}: {error.message}", hint=open_hint(error)) from None
        except BaseException:
            scanner.close()
            raise
        with self._lock:
            self._scanner = scanner

    def keep(self) -> None:
        """Open anew what has been lost; without a loss nothing happens."""
        scanner = self._scanner
        if scanner is not None and scanner.ended is None and not scanner.failure:
            return
        try:
            self.open()
        except (InputError, OSError) as error:
            self._reason = str(error)

    def read(self) -> RobotSeen | Lost:
        """What has come from the robot."""
        with self._lock:
            if self._scanner is None:
                return Lost(self._reason)
            received = self._scanner.read()
            ended, failure = self._scanner.ended, self._scanner.failure
        if received.connected:
            return RobotSeen(received.image)
        reason = _WAITS if ended is None else f"the connection has ended: {ended.value}"
        if failure:
            reason = f"{failure}; it is started again"
        return Lost(f"{self.name}: {reason}")

    def write(self, image: bytes, valid_us: int | None) -> None:
        """Set what the next packets carry.

        Args:
            image: The area to the robot.
            valid_us: The packets stop if nothing new is written for so long; None: they never do.
        """
        with self._lock:
            if self._scanner is not None:
                self._scanner.write(image, valid_us=valid_us)

    def look(self) -> tuple[ScannerStatistics, int | None] | None:
        """Figures of the packets, and the age of the last one [us]; None without a scanner."""
        with self._lock:
            scanner = self._scanner
            return None if scanner is None else (scanner.statistics(), scanner.read().age_us)

    def close(self) -> None:
        """Close the connection: to the robot its master is gone (manual chapter 1, 5.2)."""
        self._drop()

    def _drop(self) -> None:
        with self._lock:
            scanner, self._scanner = self._scanner, None
        if scanner is not None:
            scanner.close()


def open_hint(error: CipError) -> str:
    """What to do about a Forward Open that was refused; empty where that is not known."""
    if not error.extended:
        return ""
    return {
        0x106: "another master has it: disconnect that first",
        0x107: "it has lost the connection, too",
        0x109: "the robot's areas have another size: try the other --size",
        0x112: "the robot does not take this packet interval: try another --rpi",
        0x127: "the robot's areas have another size: try the other --size",
        0x128: "the robot's areas have another size: try the other --size",
    }.get(error.extended[0], "")
