"""A client for explicit messages to one adapter, one message at a time."""

from __future__ import annotations

import itertools
import socket
import struct
import time
from collections.abc import Callable

from rcx_harness.enip.closing import Closing
from rcx_harness.enip.codec import cip
from rcx_harness.enip.codec.encapsulation import (
    HEADER_SIZE,
    PROTOCOL_VERSION,
    Command,
    Frame,
    next_frame,
    unconnected,
    unconnected_items,
)
from rcx_harness.enip.errors import CipError, EnipError

__all__ = ["PORT", "Client"]

PORT = 44818
_DATA = 3
_CHUNK = 65536 + HEADER_SIZE


class Client(Closing):
    """A registered session with an adapter.

    Any failure except a refusal closes the connection, because a late answer could be taken for the
    answer to the next request.

    Args:
        timeout_s: Longest wait for the connection and for each answer, in seconds.
        source: IPv4 address of this machine from which to connect; empty: the system chooses.

    Raises:
        EnipError: no connection, no answer in time, or an invalid answer; every method can raise
            this error.
    """

    def __init__(
        self,
        host: str,
        port: int = PORT,
        timeout_s: float = 5.0,
        source: str = "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._name = f"{host}:{port}"
        self._timeout_s = timeout_s
        self._clock = clock
        self._contexts = itertools.count(1)
        self._received = bytearray()
        self._session = 0
        try:
            self.socket = socket.create_connection((host, port), timeout_s, (source, 0))
        # A bad port or host name also raises one of these errors.
        except (OSError, OverflowError, UnicodeError) as error:
            raise EnipError(
                f"no connection to the EtherNet/IP adapter at {self._name}: {error}",
                hint="check that it is running and that this is its address",
            ) from error
        # Each message is one small TCP segment. Without this option the system may wait up to 40 ms
        # for more data before it sends the segment.
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        version = struct.pack("<HH", PROTOCOL_VERSION, 0)
        self._session = self._exchange(Command.REGISTER_SESSION, version).session

    @property
    def local_host(self) -> str:
        """Return our IPv4 address on the TCP connection to the adapter."""
        return str(self.socket.getsockname()[0])

    @property
    def remote_host(self) -> str:
        """Return the IPv4 address of the adapter."""
        return str(self.socket.getpeername()[0])

    def get_assembly(self, instance: int) -> bytes:
        """Return the data of an Assembly instance."""
        return self.get_attribute(cip.ClassId.ASSEMBLY, instance, _DATA)

    def set_assembly(self, instance: int, image: bytes) -> None:
        """Set the data of an Assembly instance."""
        self.set_attribute(cip.ClassId.ASSEMBLY, instance, _DATA, image)

    def get_attribute(self, class_id: int, instance: int, attribute: int) -> bytes:
        """Return the value of an attribute."""
        path = cip.encode_path(class_id, instance, attribute)
        return self.request(cip.Service.GET_ATTRIBUTE_SINGLE, path)

    def set_attribute(self, class_id: int, instance: int, attribute: int, value: bytes) -> None:
        """Set the value of an attribute."""
        path = cip.encode_path(class_id, instance, attribute)
        self.request(cip.Service.SET_ATTRIBUTE_SINGLE, path, value)

    def request(self, service: int, path: bytes, data: bytes = b"") -> bytes:
        """Send any CIP request; return the data of its reply."""
        return self.exchange(cip.encode_request(service, path, data))[0].data

    def exchange(
        self, message: bytes, *items: tuple[int, bytes]
    ) -> tuple[cip.Reply, list[tuple[int, bytes]]]:
        """Send a CIP request with further items, such as socket addresses.

        Returns:
            The reply, and the items that have arrived with the reply.
        """
        answer = self._exchange(Command.SEND_RR_DATA, unconnected(message, *items))
        content = unconnected_items(answer.data)
        reply = cip.decode_reply(content[0]) if content is not None else None
        if content is None or reply is None or reply.service != message[0]:
            raise self._failed("an answer that does not belong to the request")
        if reply.status != cip.Status.SUCCESS:
            path = message[2 : 2 + 2 * message[1]]
            request = f"service 0x{reply.service:02X} for path {path.hex(' ')}"
            raise CipError(request, reply.status, reply.extended)
        return reply, content[1]

    def close(self) -> None:
        """End the session and its TCP connection; do nothing if they have already ended."""
        if self.socket.fileno() == -1:
            return
        try:
            self.socket.sendall(Frame(Command.UNREGISTER_SESSION, self._session).encode())
        except OSError:
            pass  # the adapter has already closed the connection
        finally:
            self.socket.close()

    def _exchange(self, command: Command, data: bytes) -> Frame:
        context = struct.pack("<Q", next(self._contexts))
        question = Frame(command, self._session, context=context, data=data)
        try:
            deadline = self._clock() + self._timeout_s
            self.socket.settimeout(self._timeout_s)
            self.socket.sendall(question.encode())
            while (answer := next_frame(self._received)) is None:
                # Compute the deadline once, because the time limit applies to the complete answer,
                # not to each part.
                if (left := deadline - self._clock()) <= 0:
                    raise TimeoutError
                self.socket.settimeout(left)
                received = self.socket.recv(_CHUNK)
                if not received:
                    raise self._failed("the end of the connection")
                self._received += received
        except TimeoutError:
            raise self._failed(f"nothing within {self._timeout_s:g} s") from None
        except OSError as error:
            raise self._failed(str(error)) from error
        if (answer.command, answer.context) != (command, context):
            raise self._failed("an answer that does not belong to the request")
        if answer.status:
            raise self._failed(f"encapsulation status 0x{answer.status:02X}")
        return answer

    def _failed(self, got: str) -> EnipError:
        self.socket.close()
        return EnipError(f"the EtherNet/IP adapter at {self._name} failed to answer: {got}")
