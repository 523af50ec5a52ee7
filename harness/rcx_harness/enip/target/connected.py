"""Transport class 3: explicit messages with a sequence count, within a connection."""

from __future__ import annotations

from collections.abc import Callable

from rcx_harness.enip.codec.cip import Status, encode_reply
from rcx_harness.enip.codec.forward_open import ForwardOpen

__all__ = ["ExplicitConnection"]

_FIRST_S = 10.0
_SEQUENCE = 2


class ExplicitConnection:
    """One class 3 connection, as the server of its messages.

    A message that comes again with the same sequence count is answered with the same reply and
    not carried out again.

    Args:
        request: As it was opened.
        connection_id: Of the messages to us.
        session: Handle of the session it lives and dies with.
        peer: IPv4 address of the originator.
        now: Seconds of the clock that `answer` and `has_timed_out` use, too.
    """

    def __init__(
        self, request: ForwardOpen, connection_id: int, session: int, peer: str, now: float
    ) -> None:
        self.triad = request.triad
        self.connection_id = connection_id
        self.session = session
        self.peer = peer
        self.reply_id = request.t_to_o_id
        self._sizes = request.o_to_t.size, request.t_to_o.size
        self._timeout_s = request.o_to_t_rpi * (4 << request.multiplier) / 1e6
        self._deadline = now + max(self._timeout_s, _FIRST_S)
        self._last = b""
        self._reply = b""

    def has_timed_out(self, now: float) -> bool:
        """No message has come for its interval times its multiplier (at first, at least 10 s)."""
        return now >= self._deadline

    def answer(self, message: bytes, now: float, perform: Callable[[bytes], bytes]) -> bytes | None:
        """Reply to a message, both with the sequence count first.

        Args:
            message: As it came; longer than the connection's size it gets status 0x15.
            now: Seconds.
            perform: Gives the CIP reply to a CIP request.

        Returns:
            None if it is too short to be a message: no reply.
        """
        if len(message) < _SEQUENCE + 2:
            return None
        self._deadline = now + self._timeout_s
        sequence, service = message[:_SEQUENCE], message[_SEQUENCE]
        if sequence == self._last:
            return self._reply
        if len(message) > self._sizes[0]:
            reply = encode_reply(service, Status.TOO_MUCH_DATA)
        else:
            reply = perform(message[_SEQUENCE:])
        if _SEQUENCE + len(reply) > self._sizes[1]:
            reply = encode_reply(service, Status.REPLY_DATA_TOO_LARGE)
        self._last, self._reply = sequence, sequence + reply
        return self._reply
