"""The base of the Debug Adapter Protocol: messages in JSON behind their length, and the client.

https://microsoft.github.io/debug-adapter-protocol/overview, "Base Protocol".
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from queue import Empty, Queue
from threading import Lock, Thread
from typing import Any, BinaryIO

from rcx_harness.errors import InputError

__all__ = ["Client", "Message", "encoded", "read_message"]

#: A message as it comes out of JSON.
Message = dict[str, Any]

#: No message is longer; a length above it is none [bytes].
_LONGEST = 64 * 1024 * 1024


def encoded(message: Mapping[str, Any]) -> bytes:
    """A message as it goes over the wire."""
    body = json.dumps(message, ensure_ascii=False, separators=(",", ":")).encode()
    return b"Content-Length: %d\r\n\r\n%b" % (len(body), body)


def read_message(stream: BinaryIO) -> Message | None:
    """The next message; None at the end of the stream.

    Raises:
        InputError: what came is no message of the protocol.
    """
    length = -1
    while line := stream.readline():
        text = line.strip()
        if not text:
            if length >= 0:
                break
            continue
        name, _, value = text.partition(b":")
        if name.lower() == b"content-length" and value.strip().isdigit():
            length = int(value)
    if length < 0:
        return None
    if length > _LONGEST:
        raise InputError(f"a message of {length} bytes is none of the debug adapter protocol")
    body = stream.read(length)
    if len(body) < length:
        return None
    try:
        message = json.loads(body)
    except ValueError:
        message = None
    if not isinstance(message, dict):
        hint = "rcx debug talks to editors: see docs/debug.md"
        raise InputError("what came is no message of the debug adapter protocol", hint=hint)
    return message


class Client:
    """The editor at the other end: its messages in a queue, ours with their numbers.

    Args:
        reading: Where its messages come from; None where they are put into `inbox` otherwise.
        writing: Where ours go.
    """

    def __init__(self, reading: BinaryIO | None, writing: BinaryIO) -> None:
        self.inbox: Queue[Message | InputError | None] = Queue()
        self._writing, self._lock, self._seq = writing, Lock(), 0
        self._gone = False
        if reading is not None:
            Thread(target=self._read, args=(reading,), daemon=True).start()

    def _read(self, stream: BinaryIO) -> None:
        try:
            while (message := read_message(stream)) is not None:
                self.inbox.put(message)
        except InputError as error:
            self.inbox.put(error)
        except (OSError, ValueError):
            pass  # the client has gone
        self.inbox.put(None)

    def next(self, *, wait: bool) -> Message | None:
        """The next message of the client; None without one yet, or at the end of all.

        Raises:
            InputError: what came is no message.
            EOFError: the client has gone.
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

    def event(self, event: str, body: Mapping[str, Any] | None = None) -> None:
        """Tell the client what has happened."""
        self._send({"type": "event", "event": event}, body)

    def answer(self, request: Message, body: Mapping[str, Any] | None = None) -> None:
        """Answer a request that was fulfilled."""
        head = {"type": "response", "request_seq": request.get("seq", 0), "success": True}
        self._send({**head, "command": request.get("command", "")}, body)

    def refuse(self, request: Message, text: str) -> None:
        """Answer a request that cannot be fulfilled, with one message for the user."""
        head = {"type": "response", "request_seq": request.get("seq", 0), "success": False}
        error = {"id": 1, "format": text.replace("{", "{{"), "showUser": True}
        named = {"command": request.get("command", ""), "message": text}
        self._send({**head, **named}, {"error": error})

    def say(self, text: str, category: str = "console") -> None:
        """A line in the client's console."""
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
                self.inbox.put(None)  # the client has gone
