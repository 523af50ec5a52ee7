"""Open a connection, open it again after each loss, and suggest a remedy for a refusal."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Collection

from rcx_harness.enip.codec.cip import ExtendedStatus
from rcx_harness.enip.errors import CipError
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.spec.wire import AREA_SIZES
from structured_text.errors import InputError
from structured_text.output.units import format_us

__all__ = ["Opener", "multiplier_of", "refusal_hint"]

_MOST = 7
_SIZES = (
    ExtendedStatus.INVALID_CONNECTION_SIZE,
    ExtendedStatus.O_TO_T_SIZE,
    ExtendedStatus.T_TO_O_SIZE,
)
_INTERVALS = (ExtendedStatus.RPI_NOT_SUPPORTED, ExtendedStatus.RPI_NOT_ACCEPTABLE)
#: Maps an extended status to the option that the remedy needs, and the remedy. A command without
#: this option does not show the remedy.
_REMEDIES: dict[int, tuple[str, str]] = {
    ExtendedStatus.CONNECTION_NOT_FOUND: ("", "the adapter has already closed the connection"),
    ExtendedStatus.ONLY_LISTENERS: (
        "--listen-only",
        "no other connection is open; leave --listen-only out",
    ),
    ExtendedStatus.CONFIGURATION_SIZE: (
        "--config-data",
        "its configuration has another size; give its data with --config-data",
    ),
    ExtendedStatus.CONFIGURATION_PATH: (
        "--config-instance",
        "it has a different configuration instance, or none; name it with --config-instance",
    ),
    ExtendedStatus.CONSUMING_PATH: (
        "--heartbeat",
        "it has a different heartbeat connection point; name it with --heartbeat",
    ),
    ExtendedStatus.PRODUCING_PATH: (
        "--input-instance",
        "it has a different assembly to the master; name it with --input-instance",
    ),
}
#: Maps the code of an interval in a refusal to the text of the hint.
_TOLD = {
    2: "the shortest interval that the device accepts",
    3: "the longest interval that the device accepts",
    4: "the only interval that the device accepts",
}


class Opener:
    """Keeps one connection open by opening it again after every loss.

    Args:
        first_s: Longest wait for the first packet, in seconds; None: the limit of the connection.

    Attributes:
        wanted: Whether to open a lost connection again. The value False does not close a
            connection.
        scanner: The scanner that was opened last, even if its connection is lost; None before the
            first opening.
        reason: Text about the failure of the last attempt; empty if the attempt succeeded.
    """

    def __init__(self, opened: Callable[[], Scanner], first_s: float | None = None) -> None:
        self.wanted = True
        self.scanner: Scanner | None = None
        self.reason = ""
        self._opened = opened
        self._first_s = math.inf if first_s is None else first_s
        self._until_s = 0.0
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def start(
        self, look_s: float, retry_s: float = 0.0, on_died: Callable[[], None] = lambda: None
    ) -> None:
        """Start a thread that keeps the connection open; only this thread waits for the adapter.

        The thread checks the connection every `look_s` seconds and waits `retry_s` more after a
        failed attempt. It calls `on_died` if it ends by itself.
        """

        def work() -> None:
            try:
                while not self._ended.wait(look_s):
                    if not self.keep():
                        self._ended.wait(retry_s)
            finally:
                if not self._ended.is_set():
                    on_died()

        self._thread = threading.Thread(target=work, daemon=True)
        self._thread.start()

    def end(self) -> None:
        """End the thread, but leave the connection open; do nothing if there is no thread."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def open(self) -> None:
        """Open the connection, which replaces an earlier connection."""
        self.reason = ""
        self.scanner = self._opened()
        self._until_s = time.monotonic() + self._first_s

    def keep(self) -> bool:
        """Open the connection again if it is wanted and lost; return False if the attempt fails."""
        if not self.wanted:
            self._until_s = 0.0
        elif self._is_lost():
            try:
                self.open()
            except (
                InputError,
                OSError,
            ) as error:  # the adapter is off, or has not noticed the loss yet
                self.reason = str(error)
                return False
        return True

    def _is_lost(self) -> bool:
        scanner = self.scanner
        if scanner is None or scanner.ended is not None or scanner.failure:
            return True
        return time.monotonic() >= self._until_s and not scanner.read().connected


def multiplier_of(timeout_us: int, rpi_us: int) -> int:
    """Return the smallest coded time-out multiplier that gives at least this time-out."""
    for coded in range(_MOST + 1):
        if rpi_us * (4 << coded) >= timeout_us:
            return coded
    longest = format_us(rpi_us * (4 << _MOST))
    raise InputError(
        f"a time-out of {format_us(timeout_us)} cannot be requested",
        hint=f"use at most {longest} at this packet interval",
    )


def refusal_hint(error: CipError, size: int, options: Collection[str]) -> str:
    """Return the remedy for a refused Forward Open; return an empty text if no remedy is known.

    `size` is the requested number of bytes from the adapter, `options` are options of the command
    that the remedy may name.
    """
    code = error.extended[0] if error.extended else 0
    if code == ExtendedStatus.OWNERSHIP_CONFLICT:
        beside = ", or leave --write out" if "--write" in options else ""
        return f"another master owns the robot: disconnect that master first{beside}"
    if code in _SIZES:
        if size in AREA_SIZES:
            return f"its areas have another size: try --size {sum(AREA_SIZES) - size}"
        return "its EDS file has the sizes; give them with --input-size and --output-size"
    if code in _INTERVALS:
        return _interval_hint(error.extended)
    option, remedy = _REMEDIES.get(code, ("", ""))
    return remedy if not option or option in options else ""


def _interval_hint(extended: tuple[int, ...]) -> str:
    """Return the hint about the packet interval, from the extended status words of the refusal."""
    if len(extended) < 6:
        return "try --rpi 10ms"
    kinds = (extended[1] & 0xFF, extended[1] >> 8)
    times_us = (extended[2] | extended[3] << 16, extended[4] | extended[5] << 16)
    told = {kind: each for kind, each in zip(kinds, times_us, strict=True) if kind in _TOLD}
    if not told:
        return "try --rpi 10ms"
    kind, time_us = next(iter(told.items()))
    shown = format_us(time_us)
    return f"{_TOLD[kind]} is {shown}; try --rpi {shown.replace(' ', '')}"
