"""The base of the Debug Adapter Protocol: framed JSON messages, and the client.

https://microsoft.github.io/debug-adapter-protocol/overview, "Base Protocol".
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from contextlib import suppress
from queue import Empty, Queue
from threading import Lock, Thread
from typing import Any, BinaryIO

from structured_text.errors import COMMAND, InputError

__all__ = ["Client", "Message", "encoded", "read_message"]

#: A decoded JSON message.
Message = dict[str, Any]

#: Upper limits for the header and the body of a client's message in bytes.
_LONGEST_HEADER = 4096
_LONGEST = 1024 * 1024
#: Upper limit for queued messages. If the queue is full, messages stay in the client's stream.
_MOST_WAITING = 1000
#: Matches a field of a message's header. The first line of HTTP or TLS does not match.
_FIELD = re.compile(rb"([A-Za-z-]+)[ \t]*:[ \t]*(.*)", re.DOTALL)
_HINT = f"{COMMAND} debug talks to editors: see docs/how-to/debug.md"


def encoded(message: Mapping[str, Any]) -> bytes:
    """Return a message as bytes with its header."""
    body = json.dumps(message, ensure_ascii=False, separators=(",", ":")).encode()
    return b"Content-Length: %d\r\n\r\n%b" % (len(body), body)


def read_message(stream: BinaryIO) -> Message | None:
    """Return the next message; None at the end of the stream.

    Raise InputError if the stream does not contain messages, or a header or body is too long.
    """
    length, size = -1, 0
    while line := stream.readline(_LONGEST_HEADER):
        size += len(line)
        text = line.strip()
        if not text and length >= 0:
            break
        field = _FIELD.fullmatch(text)
        if size >= _LONGEST_HEADER or (text and field is None):
            raise InputError("this is not a header of the debug adapter protocol", hint=_HINT)
        if field is not None and field[1].lower() == b"content-length":
            if not field[2].isdigit():
                raise InputError("Content-Length is not a number", hint=_HINT)
            length = int(field[2])
    if length < 0:
        return None
    if length > _LONGEST:
        told = f"a message of {length:.3g} bytes is too long for the debug adapter protocol"
        raise InputError(told, hint=f"send at most {_LONGEST} bytes")
    body = stream.read(length)
    if len(body) < length:
        return None
    try:
        message = json.loads(body)
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict):
        raise InputError("this is not a message of the debug adapter protocol", hint=_HINT)
    return message


class Client:
    """The connected editor: its messages in a queue, and numbered messages to it."""

    def __init__(self, reading: BinaryIO | None, writing: BinaryIO) -> None:
        self.inbox: Queue[Message | InputError | None] = Queue(_MOST_WAITING)
        self._writing, self._lock, self._seq = writing, Lock(), 0
        self._gone = False
        if reading is not None:
            Thread(target=self._read, args=(reading,), daemon=True).start()

    def _read(self, stream: BinaryIO) -> None:
        try:
            while not self._gone and (message := read_message(stream)) is not None:
                self.inbox.put(message)
        except InputError as error:
            self.inbox.put(error)
        except (OSError, ValueError):
            pass  # the client has closed the connection
        self.inbox.put(None)

    def next(self, *, wait: bool) -> Message | None:
        """Return the next message of the client; None if there is none yet and `wait` is false.

        Raises:
            InputError: The client has sent something that is not a message.
            EOFError: The client has closed the connection.
        """
        if self._gone:
            raise EOFError
        try:
            message = self.inbox.get(block=wait)
        except Empty:
            return None
        if message is None:
            self._gone = True
            raise EOFError
        if isinstance(message, InputError):
            raise message
        return message

    def close(self) -> None:
        """Stop reading, and empty the queue so that a reader that waits for space can end."""
        self._gone = True
        with suppress(Empty):
            while True:
                self.inbox.get_nowait()

    def event(self, event: str, body: Mapping[str, Any] | None = None) -> None:
        """Send an event to the client."""
        self._send({"type": "event", "event": event}, body)

    def answer(self, request: Message, body: Mapping[str, Any] | None = None) -> None:
        """Send the successful response to a request."""
        self._send(_response(request, success=True), body)

    def refuse(self, request: Message, text: str) -> None:
        """Send a failed response to a request, with one message for the user."""
        error = {"id": 1, "format": text.replace("{", "{{"), "showUser": True}
        self._send({**_response(request, success=False), "message": text}, {"error": error})

    def say(self, text: str, category: str = "console") -> None:
        """Print a line in the client's console."""
        self.event("output", {"category": category, "output": f"{text}\n"})

    def _send(self, head: dict[str, Any], body: Mapping[str, Any] | None) -> None:
        with self._lock:
            self._seq += 1
            whole = {"seq": self._seq, **head}
            if body is not None:
                whole["body"] = body
            try:
                self._writing.write(encoded(whole))
                self._writing.flush()
            except (OSError, ValueError):
                self._gone = True


def _response(request: Message, *, success: bool) -> dict[str, Any]:
    """Return the head of a response.

    It repeats the number and the command of the request if they have the right type.
    """
    number, command = request.get("seq"), request.get("command")
    return {
        "type": "response",
        "request_seq": number if isinstance(number, int) else 0,
        "success": success,
        "command": command if isinstance(command, str) else "",
    }
