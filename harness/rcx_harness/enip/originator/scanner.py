"""A scanner, which opens a class 1 connection and exchanges packets, as a PLC does.

A separate process (`cyclic.process`) sends and receives the packets, so that work of the caller
does not disturb their intervals.
"""

from __future__ import annotations

import itertools
import random
import secrets
import statistics
from contextlib import suppress
from dataclasses import dataclass

from rcx_harness.enip.closing import Closing
from rcx_harness.enip.codec.cip import ConnectionService
from rcx_harness.enip.codec.encapsulation import Item, decode_socket_address, socket_address
from rcx_harness.enip.codec.forward_open import OpenRequest, Triad, decode_open_reply
from rcx_harness.enip.cyclic.connections import (
    IO_PORT,
    RUN_IDLE_SIZE,
    SEQUENCE_SIZE,
    ConnectionKind,
    ConnectionParameters,
    EndReason,
    OwnerState,
)
from rcx_harness.enip.cyclic.control import CyclicControl
from rcx_harness.enip.cyclic.exchange import Role
from rcx_harness.enip.cyclic.shared import LinkState, SharedImages, drops_text, now_us
from rcx_harness.enip.errors import CipError, EnipError
from rcx_harness.enip.options import KINDS
from rcx_harness.enip.originator.client import PORT, Client
from rcx_harness.spec.wire import SIZE, TO_MASTER, TO_ROBOT, check_size
from structured_text.errors import InputError

__all__ = ["LARGEST", "Assemblies", "Received", "Scanner", "ScannerStatistics", "no_packet"]

LARGEST = 1400
"""Bytes of data that fit into one datagram of the Ethernet."""


@dataclass(frozen=True)
class Assemblies:
    """The assemblies of one connection; the defaults fit a controller with areas of 48 bytes.

    Args:
        input_instance: Connection point of the adapter that sends data to the scanner.
        heartbeat: Connection point that Input Only and Listen Only connections name instead of the
            output point; None: the usual heartbeat point.
        configuration: Configuration instance in the path; None: the path names no instance.
        configuration_data: Data for the configuration instance, an even number of bytes.
    """

    input_size: int = SIZE
    output_size: int = SIZE
    input_instance: int = TO_MASTER
    output_instance: int = TO_ROBOT
    heartbeat: int | None = None
    configuration: int | None = None
    configuration_data: bytes = b""

    def __post_init__(self) -> None:
        """Raise InputError for a size, number or data that cannot be requested."""
        for size in (self.input_size, self.output_size):
            if not 1 <= size <= LARGEST:
                hint = f"use 1 to {LARGEST}"
                raise InputError(f"an assembly of {size} bytes cannot be exchanged", hint=hint)
        numbers = (self.input_instance, self.output_instance, self.heartbeat, self.configuration)
        for number in numbers:
            if number is not None and not 1 <= number <= 0xFFFF:
                raise InputError(f"{number} is not an instance of an assembly; use 1 to 65535")
        if self.configuration_data and self.configuration is None:
            raise InputError("configuration data need a configuration instance")
        if len(self.configuration_data) % 2 or len(self.configuration_data) > 2 * 0xFF:
            raise InputError("configuration data must be an even number of bytes, at most 510")


def no_packet(drops: str, within_s: float) -> EnipError:
    """Return the error for an open connection on which no packet was accepted.

    `drops` has the reasons for dropped packets, from `Scanner.drops`.
    """
    if drops:
        return EnipError(
            f"connected, but none of the packets within {within_s:g} s can be used: they are "
            f"{drops}",
            hint="compare the size of the areas, and find out who else sends to this address",
        )
    return EnipError(
        f"connected, but no packet came within {within_s:g} s",
        hint="check that no firewall blocks UDP port 2222",
    )


_HEARTBEATS = {kind: point for point, kind in KINDS.items()}
_LARGEST_PLAIN = 0x1FF  # longest connection size without Large Forward Open
_SCHEDULED_DSCP = 47
_VENDOR = 0
_NAMES = {
    ConnectionService.FORWARD_OPEN: "the connection (Forward Open)",
    ConnectionService.LARGE_FORWARD_OPEN: "the connection (Large Forward Open)",
    ConnectionService.FORWARD_CLOSE: "the end of the connection (Forward Close)",
}


@dataclass(frozen=True)
class Received:
    """The data from the adapter.

    Attributes:
        image: The newest assembly 100; zero before the first packet.
        age_us: Microseconds since the last packet; None before the first.
        connected: Whether packets arrive, which a PLC's scanner shows as its status.
    """

    image: bytes
    age_us: int | None
    connected: bool


@dataclass(frozen=True)
class ScannerStatistics:
    """Packet counters since the creation of the scanner; gaps between packets in us, 0: none."""

    sent: int
    received: int
    missing: int
    dropped: int
    skipped: int
    gap_median_us: int
    gap_p99_us: int
    gap_max_us: int


class Scanner(Closing):
    """A connection to an adapter, with the session that opens it.

    Args:
        size: Bytes of each area of the controller (48 or 256), or an `Assemblies` object.
        rpi_us: Requested packet interval in microseconds.
        kind: Application type. Only an exclusive owner sends data; the other types send a
            heartbeat.
        multiplier: Connection time-out multiplier as coded: 0 to 7 for 4 to 512 intervals.
        address: IPv4 address of this machine to send from; empty: the system chooses.
        io_port: Our UDP port; None for 2222 or, if that is in use, any free port.

    Attributes:
        shared: Both areas, and the state of the cyclic connection.
        client: The session, for other requests. The connection stays open if the session ends.
        connection: The agreed parameters, also after a loss; None before the first `open` and after
            `close`.
        ended: The reason why the connection has ended by itself; None while it is open and after
            `close`.

    Raises:
        InputError: the controller does not have the size, or the interval or multiplier cannot be
            requested.
        EnipError: the adapter does not answer, or our UDP port is in use.
    """

    def __init__(
        self,
        host: str,
        size: int | Assemblies = SIZE,
        rpi_us: int = 10_000,
        *,
        kind: ConnectionKind = ConnectionKind.EXCLUSIVE_OWNER,
        multiplier: int = 2,
        address: str = "",
        io_port: int | None = None,
        port: int = PORT,
        large: bool = False,
        timeout_s: float = 5.0,
    ) -> None:
        _check(rpi_us, multiplier)
        if isinstance(size, int):
            check_size(size)
            size = Assemblies(size, size)
        self._asked = asked = size
        self._kind, self._rpi_us = kind, rpi_us
        self._multiplier, self._large = multiplier, large
        usual = _HEARTBEATS.get(kind, 0)
        self._heartbeat = usual if asked.heartbeat is None else asked.heartbeat
        self._adapter = (host, port, timeout_s, address)
        self._originator = random.getrandbits(32)
        # Each opening has a new serial number, because the adapter may still hold the old
        # connection.
        self._serials = itertools.count(random.getrandbits(16))
        self._request: OpenRequest | None = None
        self._number = 0
        self.connection: ConnectionParameters | None = None
        self.ended: EndReason | None = None
        self.client = Client(*self._adapter)
        self._host = self.client.remote_host
        self.shared = SharedImages.create(asked.input_size, asked.output_size)
        try:
            self._control = self._start(self.client.local_host, io_port)
        except BaseException:
            self.shared.close()
            self.client.close()
            raise
        finally:
            # The process has opened the memory. Once the name of the memory is removed, the system
            # frees the memory after its last use.
            self.shared.unlink()

    def open(self) -> None:
        """Close the previous connection, if there is one, and open a new connection.

        Raises:
            CipError: the adapter refused; `status` and `extended` of the error contain the reason.
            EnipError: the adapter does not answer.
        """
        with suppress(CipError):  # the adapter has already closed it
            self.close_connection()
        self.shared.link = LinkState.UP
        request = self._new_request()
        local_port = self._control.port
        items = []
        if local_port != IO_PORT:
            # The adapter sends to the usual port unless the request names another port.
            items.append((Item.T_TO_O_ADDRESS, socket_address("0.0.0.0", local_port)))
        reply, answered = self._ask(request.forward_open(), *items)
        self._request = request
        agreed = decode_open_reply(reply)
        if agreed is None or (problem := request.problem(agreed)):
            with suppress(EnipError):  # the adapter may still count the connection as open
                self.close_connection()
            text = "is too short" if agreed is None else problem
            raise EnipError(
                f"{self._adapter[0]}: the reply to the Forward Open {text}",
                hint="update or replace the adapter: it violates the protocol",
            )
        addresses = {kind: decode_socket_address(data) for kind, data in answered}
        _, destination_port = addresses.get(Item.O_TO_T_ADDRESS) or ("", IO_PORT)
        is_owner = self._kind is ConnectionKind.EXCLUSIVE_OWNER
        self._number += 1
        self.ended = None
        self.connection = ConnectionParameters(
            number=self._number,
            kind=self._kind,
            o_to_t_id=agreed.o_to_t_id,
            t_to_o_id=agreed.t_to_o_id,
            o_to_t_api_us=agreed.o_to_t_api_us,
            t_to_o_api_us=agreed.t_to_o_api_us,
            o_to_t_size=self._asked.output_size if is_owner else 0,
            t_to_o_size=self._asked.input_size,
            multiplier=self._multiplier,
            peer=self._host,
            destination=self._host,
            destination_port=destination_port,
            run_idle=is_owner,
            dscp=_SCHEDULED_DSCP,
        )
        self._control.add(self.connection)

    @property
    def pid(self) -> int:
        """Return the id of the process that sends and receives."""
        return self._control.pid

    @property
    def io_port(self) -> int:
        """Return the UDP port that this scanner receives at."""
        return self._control.port

    @property
    def alive(self) -> bool:
        """Return whether the process that sends and receives still runs."""
        return self._control.alive

    @property
    def failure(self) -> str:
        """Return a text about the unexpected end of the cyclic process; empty while it runs."""
        return self._control.failure

    def write(self, image: bytes, run: bool = True, valid_us: int | None = None) -> None:
        """Set the data and run state from the next packet on.

        `image` is the complete assembly 150. Without `run` the packets carry the idle state, so the
        adapter ignores their data. If `write` is not called again within `valid_us` microseconds,
        the packets stop, because data of a program that hangs must not stay valid. With None they
        never stop.
        """
        self.shared.to_robot.write(image)
        self.shared.run = run
        self.shared.sending_ends_us = 0 if valid_us is None else now_us() + valid_us

    def read(self) -> Received:
        """Return the last received data, and whether packets still arrive."""
        # The cyclic process writes the image, the time and the state, in this order. So read in the
        # reverse order: if the state is RUN, time and image are already valid, and the image is not
        # older than its time.
        connected = self._control.alive and self.shared.owner is OwnerState.RUN
        arrived_us = self.shared.arrived_us
        image = self.shared.to_master.read()
        age_us = max(0, now_us() - arrived_us) if arrived_us else None
        return Received(image, age_us, connected)

    def drops(self) -> str:
        """Return the reasons for dropped packets, in words; empty if no packet was dropped."""
        return drops_text(self.shared.status(), numbers=False)

    def statistics(self) -> ScannerStatistics:
        """Return the packet counters, and statistics of the last 8,192 gaps between packets."""
        status = self.shared.status()
        gaps = sorted(self.shared.gaps_us())
        return ScannerStatistics(
            sent=status.sent,
            received=status.received,
            missing=status.missing,
            dropped=status.dropped,
            skipped=status.skipped,
            gap_median_us=round(statistics.median(gaps)) if gaps else 0,
            gap_p99_us=gaps[len(gaps) * 99 // 100] if gaps else 0,
            gap_max_us=gaps[-1] if gaps else 0,
        )

    def stop(self) -> None:
        """Stop sending without closing, as if the cable were cut; `open` reconnects."""
        self.shared.link = LinkState.CUT

    def close_connection(self) -> None:
        """Close the connection with a Forward Close; do nothing without a connection.

        Raises:
            CipError: the adapter refused, for example because it had already closed the connection.
            EnipError: the adapter does not answer.
        """
        request = self._request
        self._forget()
        if request is not None:
            self._ask(request.forward_close())

    def close(self) -> None:
        """Close the connection and the session, and end the cyclic process.

        A second call does nothing.
        """
        with suppress(EnipError):  # our end is closed even if the adapter reports an error
            self.close_connection()
        self.client.close()
        self._control.close()
        self.shared.close()

    def _forget(self) -> None:
        """Remove the connection from the cyclic process, without a message to the adapter."""
        if self.connection is not None:
            with suppress(EnipError):  # the cyclic process has ended, so there is no connection
                self._control.remove(self.connection.number)
        self.connection = self._request = None

    def _ask(
        self, message: bytes, *items: tuple[int, bytes]
    ) -> tuple[bytes, list[tuple[int, bytes]]]:
        """Send a request and return its reply; use a new session if the old session is closed."""
        try:
            try:
                reply, answered = self.client.exchange(message, *items)
            except CipError:
                raise
            except EnipError:
                self.client.close()
                self.client = Client(*self._adapter)
                reply, answered = self.client.exchange(message, *items)
        except CipError as error:
            name = _NAMES[ConnectionService(message[0])]
            raise CipError(name, error.status, error.extended) from None
        return reply.data, answered

    def _start(self, host: str, io_port: int | None) -> CyclicControl:
        def start(port: int) -> CyclicControl:
            return CyclicControl(self.shared.name, host, port, self._note_end, Role.ORIGINATOR)

        if io_port is not None:
            return start(io_port)
        try:
            return start(IO_PORT)
        except EnipError:
            return start(0)

    def _note_end(self, number: int, reason: EndReason) -> None:
        # A thread calls this method, so the end of an earlier connection may be reported late.
        if number == self._number:
            self.ended = reason

    def _new_request(self) -> OpenRequest:
        is_owner, asked = self._kind is ConnectionKind.EXCLUSIVE_OWNER, self._asked
        o_to_t = SEQUENCE_SIZE + (RUN_IDLE_SIZE + asked.output_size if is_owner else 0)
        t_to_o = SEQUENCE_SIZE + asked.input_size
        return OpenRequest(
            triad=Triad(next(self._serials) & 0xFFFF, _VENDOR, self._originator),
            t_to_o_id=secrets.randbits(32),
            rpi_us=self._rpi_us,
            o_to_t_length=o_to_t,
            t_to_o_length=t_to_o,
            multiplier=self._multiplier,
            consuming=asked.output_instance if is_owner else self._heartbeat,
            producing=asked.input_instance,
            configuration=asked.configuration,
            configuration_data=asked.configuration_data,
            large=self._large or max(o_to_t, t_to_o) > _LARGEST_PLAIN,
        )


def _check(rpi_us: int, multiplier: int) -> None:
    if not 1_000 <= rpi_us <= 0xFFFFFFFF:
        raise InputError(f"a packet interval of {rpi_us} us cannot be requested; use at least 1 ms")
    if not 0 <= multiplier <= 7:
        raise InputError("the time-out multiplier must be 0 to 7, for 4 to 512 intervals")
