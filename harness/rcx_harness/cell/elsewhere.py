"""A controller that runs elsewhere: `rcx serve`, or a real one, as a PLC's scanner has it.

The cell is the PLC alone, at the pace of the clock. Nothing of the controller is simulated.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rcx_harness.cell.clock import Agenda, Timing
from rcx_harness.enip.originator.client import PORT
from rcx_harness.enip.originator.kept import KeptConnection
from rcx_harness.enip.originator.opening import multiplier_of
from rcx_harness.enip.originator.scanner import Assemblies, Scanner
from rcx_harness.spec.wire import TO_MASTER, TO_ROBOT
from structured_text.errors import InputError
from structured_text.output.units import format_us

__all__ = ["NAME", "Elsewhere", "FarLink"]

#: The link of such a cell.
NAME = "enip-connect"

_LOOK_S, _REOPEN_S = 0.01, 0.1
#: Longest wait for the packets with zeros to go out: so many intervals, at least this time.
_LAST_INTERVALS, _LAST_S = 4, 0.1
#: A program that stops writing for so many scans is not to be believed: nothing is sent any more.
_WATCHDOG_SCANS = 4
#: What a refusal may tell to change.
_OPTIONS = ("--size", "--rpi", "--config-instance", "--config-data", "--input-instance")


def _silent(now_us: int, text: str) -> None:
    del now_us, text


@dataclass(frozen=True)
class Elsewhere:
    """Where a controller is, and how its connection is asked for.

    Attributes:
        host: Name or address.
        port: Its TCP port of explicit messages.
        input_instance: The assembly to receive from.
        output_instance: The assembly to send to.
        configuration: Configuration instance to name, None for none.
        configuration_data: Data for it.
        address: IPv4 address of this machine to work from; empty for the one that leads there.
        tell: Takes the cell's time in microseconds and a line when the connection comes or goes.
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
        """How messages call it."""
        return self.host if self.port == PORT else f"{self.host}:{self.port}"


class FarLink:
    """The PLC's end of a connection to a controller elsewhere.

    Args:
        size: Bytes of each area, 48 or 256.
        timing: RPI and time-out.
        where: The controller.

    Raises:
        InputError: what cannot be asked for.
    """

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

        def connect() -> Scanner:
            return Scanner(
                where.host,
                asked,
                timing.rpi_us,
                multiplier=multiplier,
                address=where.address,
                port=where.port,
            )

        self.kept = KeptConnection(where.name, size, connect, _OPTIONS)
        self._valid_us = max(timing.timeout_us, _WATCHDOG_SCANS * timing.scan_us)

    def open(self) -> None:
        """Open the connection, and from then on anew after every loss.

        Raises:
            InputError: the controller is not there, or refuses.
        """
        self.kept.opener.open()
        self.kept.opener.start(_LOOK_S, _REOPEN_S)

    def network(self, agenda: Agenda, *, matched: bool) -> FarNetwork:
        """Its network; the packets keep no agenda."""
        del agenda, matched
        return FarNetwork(self)

    def scanner_write(self, image: bytes) -> None:
        """Set what the next packets carry."""
        self.kept.write(image, self._valid_us)

    def scanner_read(self) -> bytes:
        """What the packets bring now; zeros where there are none."""
        received = self.kept.received()
        return bytes(self.size) if isinstance(received, str) else received.image

    def robot_read(self) -> bytes:
        """Zeros: what the controller has received, it knows alone."""
        return bytes(self.size)

    def robot_write(self, image: bytes) -> None:
        """Nothing: the controller writes its own."""

    def close(self) -> None:
        """Zeros go out, then the connection is closed; more than once does no harm.

        Zeros are what the controller assumes without a master: SI(00) and SI(06) OFF (manual
        chapter 1, 5.2). So it has stopped when the connection ends, whatever the program asked for.
        """
        self.kept.opener.end()
        if not isinstance(self.kept.received(), str):
            self._send_zeros()
        self.kept.close()

    def _send_zeros(self) -> None:
        self.kept.write(bytes(self.size), None)
        before, patience_s = self._sent(), _LAST_INTERVALS * self.timing.rpi_us / 1e6
        until_s = time.monotonic() + max(patience_s, _LAST_S)
        # The first of them may have been under way when the zeros were written.
        while self._sent() < before + 2 and time.monotonic() < until_s:
            time.sleep(self.timing.rpi_us / 4e6)

    def _sent(self) -> int:
        look = self.kept.look()
        return 0 if look is None else look[0].sent


class FarNetwork:
    """A `rcx_harness.cell.link.Network` over such a connection.

    Args:
        link: The connection.
    """

    def __init__(self, link: FarLink) -> None:
        self._link = link
        self._said = ""
        self.input = bytes(link.size)
        """What the PLC has received so far."""

    def start(self, content: Callable[[], bytes]) -> None:
        """Open the connection; its first packets carry zeros until the program has run.

        Raises:
            InputError: the controller is not there, or refuses.
        """
        del content
        self._link.open()

    def set_cable(self, up: bool) -> None:
        """Nothing: the cable is a real one."""

    def set_adapter(self, up: bool) -> None:
        """Nothing: the controller's power is its own matter."""

    def robot_connected(self, now_us: int) -> bool:
        """What the controller thinks of it is not known here."""
        return self.plc_connected(now_us)

    def plc_connected(self, now_us: int) -> bool:
        """Do packets come: the status that a PLC's scanner shows."""
        received = self._link.kept.received()
        if isinstance(received, str):
            self._tell(now_us, received)
            return False
        self.input = received.image
        size, rpi = self._link.size, format_us(self._link.timing.rpi_us)
        self._tell(now_us, f"{self._link.kept.name}: connected, {size} bytes, packets every {rpi}")
        return True

    def scanned(self, image: bytes) -> None:
        """The scan has ended: from now on its outputs are sent."""
        self._link.scanner_write(image)

    def snapshot(self) -> object:
        """Not possible: the controller cannot be set back.

        Raises:
            InputError: always.
        """
        raise InputError("a controller elsewhere has no snapshot", hint="run it without connect")

    def restore(self, snapshot: Any) -> None:
        """Not possible either.

        Raises:
            InputError: always.
        """
        self.snapshot()

    def _tell(self, now_us: int, text: str) -> None:
        if text != self._said:
            self._said = text
            self._link.where.tell(now_us, text)
