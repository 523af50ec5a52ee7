"""The connection of a cell to an external controller (`rcx serve` or a real controller).

With an external controller, the cell simulates only the PLC, in real time.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from rcx_harness.cell.clock import Timing
from rcx_harness.enip.originator.client import PORT
from rcx_harness.enip.originator.opening import multiplier_of
from rcx_harness.enip.originator.persistent_connection import PersistentConnection
from rcx_harness.enip.originator.scanner import Assemblies, Scanner
from rcx_harness.spec.wire import TO_MASTER, TO_ROBOT
from structured_text.bench.agenda import Agenda
from structured_text.errors import InputError
from structured_text.output.units import format_us

__all__ = ["NAME", "Elsewhere", "FarLink"]

#: The name of the link that a cell with an external controller has.
NAME = "enip-connect"

_LOOK_S, _REOPEN_S = 0.01, 0.1
#: Time limit of the wait for the last packets, which carry zeros: this number of packet intervals,
#: or this time [s] if it is longer.
_LAST_INTERVALS, _LAST_S = 4, 0.1
#: If the program writes no outputs for this number of scans, the packets to the robot end.
_WATCHDOG_SCANS = 4
#: The options that the hint for a refused connection may name.
_OPTIONS = ("--size", "--rpi", "--config-instance", "--config-data", "--input-instance")


def _silent(now_us: int, text: str) -> None:
    del now_us, text


@dataclass(frozen=True)
class Elsewhere:
    """The address of an external controller and the parameters of the connection.

    Attributes:
        configuration: Configuration instance in the connection path; None: the path names no
            instance.
        address: IPv4 address of this machine to send from; empty: chosen by the route to the host.
        tell: Function that is called with the cell's time [us] and a line when the connection is
            opened or lost.
    """

    host: str
    port: int = PORT
    input_instance: int = TO_MASTER
    output_instance: int = TO_ROBOT
    configuration: int | None = None
    configuration_data: bytes = b""
    address: str = ""
    tell: Callable[[int, str], None] = _silent

    @property
    def name(self) -> str:
        """Return the name that messages use for the controller."""
        return self.host if self.port == PORT else f"{self.host}:{self.port}"


class FarLink:
    """The PLC's end of the connection to an external controller."""

    name = NAME

    def __init__(self, size: int, timing: Timing, where: Elsewhere) -> None:
        self.size, self.where, self.timing = size, where, timing
        multiplier = multiplier_of(timing.timeout_us, timing.rpi_us)
        asked = Assemblies(
            size,
            size,
            where.input_instance,
            where.output_instance,
            configuration=where.configuration,
            configuration_data=where.configuration_data,
        )

        connect = partial(
            Scanner,
            *(where.host, asked, timing.rpi_us),
            multiplier=multiplier,
            address=where.address,
            port=where.port,
        )
        self.connection = PersistentConnection(where.name, size, connect, _OPTIONS)
        self._valid_us = max(timing.timeout_us, _WATCHDOG_SCANS * timing.scan_us)

    def open(self) -> None:
        """Open the connection, and open it again after every loss.

        Raises:
            InputError: the controller does not answer, or refuses the connection.
        """
        self.connection.opener.open()
        self.connection.opener.start(_LOOK_S, _REOPEN_S)

    def network(self, agenda: Agenda, *, matched: bool) -> FarNetwork:
        """Return the network of this link. The packets are real, so they do not use the agenda."""
        del agenda, matched
        return FarNetwork(self)

    def scanner_write(self, image: bytes) -> None:
        """Set the content of the next packets."""
        self.connection.write(image, self._valid_us)

    def scanner_read(self) -> bytes:
        """Return the content of the last packet; zeros without a connection."""
        received = self.connection.received()
        return bytes(self.size) if isinstance(received, str) else received.image

    def robot_read(self) -> bytes:
        """Return zeros, because the image inside an external controller is unknown."""
        return bytes(self.size)

    def robot_write(self, image: bytes) -> None:
        """Do nothing: the external controller writes its own image."""

    def close(self) -> None:
        """Send zeros, then close the connection; a second call has no effect.

        Zeros are the inputs that the controller assumes without a master: SI(00) and SI(06) OFF
        (manual chapter 1, 5.2). The robot has therefore stopped when the connection ends, even if
        the program had set outputs.
        """
        self.connection.opener.end()
        if not isinstance(self.connection.received(), str):
            self._send_zeros()
        self.connection.close()

    def _send_zeros(self) -> None:
        self.connection.write(bytes(self.size), None)
        before, patience_s = self._sent(), _LAST_INTERVALS * self.timing.rpi_us / 1e6
        until_s = time.monotonic() + max(patience_s, _LAST_S)
        # Wait for two packets, because the first packet may have been sent before the zeros were
        # written.
        while self._sent() < before + 2 and time.monotonic() < until_s:
            time.sleep(self.timing.rpi_us / 4e6)

    def _sent(self) -> int:
        look = self.connection.look()
        return 0 if look is None else look[0].sent


class FarNetwork:
    """The implementation of `rcx_harness.cell.link.Network` for an external controller."""

    def __init__(self, link: FarLink) -> None:
        self._link = link
        self._said = ""
        self.input = bytes(link.size)
        """The last image that the PLC has received."""

    def start(self, content: Callable[[], bytes]) -> None:
        """Open the connection; its first packets carry zeros until the program has run."""
        del content
        self._link.open()

    def set_cable(self, up: bool) -> None:
        """Do nothing, because the network cable is real."""

    def set_adapter(self, up: bool) -> None:
        """Do nothing, because the cell does not control the power of an external controller."""

    def robot_connected(self, now_us: int) -> bool:
        """Return the status at the PLC's end, because the controller's own status is unknown."""
        return self.plc_connected(now_us)

    def plc_connected(self, now_us: int) -> bool:
        """Return whether packets arrive, which is the status that a PLC's scanner shows."""
        received = self._link.connection.received()
        if isinstance(received, str):
            self._tell(now_us, received)
            return False
        self.input = received.image
        size, rpi = self._link.size, format_us(self._link.timing.rpi_us)
        self._tell(
            now_us, f"{self._link.connection.name}: connected, {size} bytes, packets every {rpi}"
        )
        return True

    def scanned(self, image: bytes) -> None:
        """Send the outputs of the finished scan from now on."""
        self._link.scanner_write(image)

    def snapshot(self) -> object:
        """Raise InputError: the state of an external controller cannot be restored."""
        raise InputError("an external controller has no snapshot", hint="leave out --connect")

    def restore(self, snapshot: Any) -> None:
        """Raise InputError, because there is no snapshot of an external controller."""
        self.snapshot()

    def _tell(self, now_us: int, text: str) -> None:
        if text != self._said:
            self._said = text
            self._link.where.tell(now_us, text)
