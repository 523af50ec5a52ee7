"""The connection of the probe to the controller: functions to write, to read and to wait."""

from __future__ import annotations

import time

from rcx_harness.enip.codec.cip import ClassId, Service, encode_path
from rcx_harness.enip.errors import EnipError, ProcessDiedError
from rcx_harness.enip.originator.client import PORT
from rcx_harness.enip.originator.scanner import Scanner, no_packet
from rcx_harness.look.text import identity_lines
from rcx_harness.spec.wire import CYCLE_US

__all__ = ["LostError", "NetworkLine", "NotConnectedError"]

#: Written data are sent for this time, and then only if they are written again. If the probe
#: hangs, no packets are sent after this time and the robot stops.
_LEASE_US = 1_000_000
_LOOK_US = 1_000
_FIRST_US = 5_000_000


class LostError(Exception):
    """The error if the connection ends although the probe has not closed it."""


class NotConnectedError(LostError):
    """The error for a connection that could not be opened.

    `text` is the reason, and `hint` the remedy.
    """

    def __init__(self, text: str, hint: str = "") -> None:
        self.text, self.hint = text, hint
        super().__init__(f"{text}; {hint}" if hint else text)


class NetworkLine:
    """The connection to a controller on the network; the probe is its exclusive owner.

    Args:
        rpi_us: Packet interval.
        address: IPv4 address of this machine to send from; empty: the system chooses.

    Attributes:
        step_us: Time between two reads. Reads at a shorter interval return nothing new.
        tolerance_us: Time by which a measured time may be too long.
        identity: Identity of the controller, line by line.
    """

    def __init__(
        self, host: str, size: int, rpi_us: int, port: int = PORT, address: str = ""
    ) -> None:
        self._scanner = Scanner(host, size, rpi_us, port=port, address=address, multiplier=3)
        self.size, self.step_us = size, _LOOK_US
        self.tolerance_us = 2 * rpi_us + 2 * CYCLE_US
        path = encode_path(ClassId.IDENTITY, 1)
        reply = self._scanner.client.request(Service.GET_ATTRIBUTES_ALL, path)
        self.identity = list(identity_lines(reply))
        self._begin = time.monotonic()
        self._open = False
        self._written = bytes(size)
        self._rpi_us = rpi_us

    @property
    def now_us(self) -> int:
        """Return the time since the probe began [us]."""
        return round((time.monotonic() - self._begin) * 1e6)

    @property
    def sent(self) -> int:
        """Return the number of sent packets.

        A packet contains the data that were written before the packet was prepared.
        """
        return self._scanner.shared.status().sent

    def open(self, first: bytes) -> None:
        """Connect, with these bytes in the first packet.

        Raises:
            NotConnectedError: the controller does not answer, or refuses.
        """
        self.write(first)
        try:
            self._scanner.open()
        except EnipError as error:
            raise NotConnectedError(error.message, error.hint) from None
        deadline_us = self.now_us + _FIRST_US
        while self._scanner.read().age_us is None or not self._scanner.read().connected:
            if self.now_us > deadline_us:
                silence = no_packet(self._scanner.drops(), _FIRST_US / 1e6)
                raise NotConnectedError(silence.message, silence.hint)
            self.wait(_LOOK_US)
        self._open = True

    def drop(self) -> None:
        """Stop sending without closing, as if the cable were cut."""
        self._open = False
        self._scanner.stop()

    def write(self, area: bytes, *, run: bool = True) -> None:
        """Send this area from now on. If `run` is False, send the idle header."""
        self._written = area
        self._scanner.write(area, run, _LEASE_US)

    def read(self) -> bytes:
        """Return the area that was received last.

        Raises:
            LostError: no packets arrive any more.
        """
        received = self._scanner.read()
        if self._open:
            if failure := self._scanner.failure:
                raise ProcessDiedError(failure)
            if not received.connected:
                raise LostError("no packets arrive any more")
            self._scanner.write(self._written, self._scanner.shared.run, _LEASE_US)
        return received.image

    def wait(self, us: int) -> None:
        """Wait for this time, and continue to send and receive."""
        end_us = self.now_us + us
        while (left_us := end_us - self.now_us) > 0:
            if self._open:
                self.read()  # each write extends the time for which the data are sent
            time.sleep(min(left_us, 100_000) / 1e6)

    def close(self) -> None:
        """Send some packets with zeros, then a Forward Close.

        This works in any state of the connection.
        """
        if self._open:
            self._scanner.write(bytes(self.size), True, _LEASE_US)
            self._open = False
            time.sleep(5 * self._rpi_us / 1e6)
        self._scanner.close()
