"""The process of the cyclic part: one UDP socket, class 1 packets in and out, nothing else.

`rcx_harness.enip.cyclic.control` starts the process with its settings as JSON. On standard output
the process reports where it listens (or why it cannot listen) and which connections have ended. It
reads orders from standard input, one JSON object per line, and ends when standard input ends, at
the latest with its parent. It is a separate process because a thread beside other threads would
miss its deadlines.
"""

from __future__ import annotations

import gc
import json
import select
import signal
import socket

from rcx_harness.enip import child
from rcx_harness.enip.child import be_punctual, tell
from rcx_harness.enip.cyclic.connections import ConnectionParameters, EndReason
from rcx_harness.enip.cyclic.exchange import Exchange, Role
from rcx_harness.enip.cyclic.shared import Drop, LinkState, SharedImages, Word, now_us
from structured_text.output.system import StandardInput

__all__ = ["BEAT_US", "main"]

_DATAGRAM = 2048
_LOOK_US = 50_000
"""Longest time between two checks of the link state while there are connections."""
BEAT_US = 250_000
"""Longest time between two signs of life of this process while there are no connections."""
_AT_ONCE = 128
"""Largest number of packets that are read before the due packets are sent. Without this limit, many
received packets could delay the due packets."""
_TTL = 1


class _Cyclic:
    """The sockets and the loop around an `Exchange`."""

    def __init__(self, images: SharedImages, host: str, port: int, role: Role) -> None:
        self._images = images
        self._role = role
        self._exchange = Exchange(images, self._ended, role)
        # Never set SO_REUSEADDR. With it, a second process could take packets without any error.
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((host, port))
        self._host, self.port = self._socket.getsockname()
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, _TTL)
        if self._host != "0.0.0.0":
            interface = socket.inet_aton(self._host)
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, interface)
        self._dscp = 0
        self._input = StandardInput()
        self._orders = bytearray()
        self._parent_lives = True

    def run(self) -> None:
        """Send and receive until the parent closes our standard input."""
        due_us = self._poll()
        while self._parent_lives:
            wait_us = BEAT_US if due_us is None else max(0, due_us - now_us())
            # Without a connection, a scanner does not read packets. They stay in the socket until
            # the reply to the Forward Open has come.
            idle = due_us is None and self._role is Role.ORIGINATOR
            # Orders are executed before packets are read: an order may add the connection to which
            # a waiting packet belongs.
            waiting = (self._input,) if idle else (self._input, self._socket)
            ready = select.select(waiting, (), (), wait_us / 1e6)[0]
            if self._input in ready:
                self._obey()
            if self._socket in ready:
                self._receive(due_us)
            due_us = self._poll()
        # Publish the end of all connections, so that readers of the images do not wait for packets.
        self._exchange.clear(now_us())

    def _poll(self) -> int | None:
        link = self._images.link
        at_us = now_us()
        self._images.beat(Word.CYCLIC_ALIVE, at_us)
        if link is LinkState.OFF:
            self._exchange.clear(at_us)
        ends_us = self._images.sending_ends_us
        sends = link is LinkState.UP and (not ends_us or at_us < ends_us)
        due_us = self._exchange.poll(at_us, self._send if sends else _send_nothing)
        return None if due_us is None else min(due_us, at_us + _LOOK_US)

    def _receive(self, due_us: int | None) -> None:
        """Read one packet, or all waiting packets if a deadline has passed.

        A packet that has arrived must be read before the time-out of its connection is checked.
        Otherwise a connection would time out although its packet is waiting in the socket.
        """
        for _ in range(_AT_ONCE):
            try:
                datagram, (host, _) = self._socket.recvfrom(_DATAGRAM)
            except BlockingIOError:
                return
            except OSError:  # the system reports an earlier packet to a closed port
                continue
            at_us = now_us()
            if self._images.link is LinkState.UP:
                self._take(datagram, host, at_us)
            if due_us is None or at_us < due_us:
                return

    def _take(self, datagram: bytes, host: str, at_us: int) -> None:
        if self._exchange.receive(datagram, host, at_us):
            return
        # Execute waiting orders first, because one of them may add the packet's connection.
        if not (self._obey() and self._exchange.receive(datagram, host, now_us())):
            self._images.drop(Drop.UNKNOWN)

    def _send(self, packet: bytes, destination: tuple[str, int], dscp: int) -> None:
        if dscp != self._dscp:
            self._dscp = dscp
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_TOS, dscp << 2)
        try:
            self._socket.sendto(packet, destination)
        except OSError:  # no route or no buffer: the packet counts as lost on the network
            return

    def _obey(self) -> bool:
        """Execute the orders that have arrived; return whether there were any."""
        if not select.select((self._input,), (), (), 0)[0]:
            return False
        received = self._input.read()
        self._parent_lives = bool(received)
        self._orders += received
        *lines, self._orders = self._orders.split(b"\n")
        for line in lines:
            order = json.loads(line)
            if "add" in order:
                self._exchange.add(ConnectionParameters.from_message(order["add"]), now_us())
            else:
                self._exchange.remove(order["remove"], now_us())
        return bool(lines)

    def _ended(self, number: int, reason: EndReason) -> None:
        tell({"ended": number, "reason": reason.value})


def main(argument: str) -> None:
    """Run the cyclic part until the parent closes our standard input.

    Args:
        argument: JSON object with `memory` (name of the `SharedImages`), `host`, `port` (0: any
            free one) and `role`.
    """
    # Ctrl-C reaches the whole process group; the parent decides when we end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    settings = json.loads(argument)
    try:
        images = SharedImages.attach(settings["memory"])
    except FileNotFoundError:  # the parent has ended and its memory is gone
        return
    with images:
        try:
            cyclic = _Cyclic(images, settings["host"], settings["port"], Role(settings["role"]))
        # A bad port or host name also raises one of these errors.
        except (OSError, OverflowError, UnicodeError) as error:
            tell({"error": str(error)})
            return
        gc.disable()  # the loop creates no reference cycles, so no collection is needed
        be_punctual("first")
        tell({"port": cyclic.port})
        cyclic.run()


def _send_nothing(packet: bytes, destination: tuple[str, int], dscp: int) -> None:
    """Discard a packet instead of sending it, because the link is down."""


if __name__ == "__main__":
    child.run(main)
