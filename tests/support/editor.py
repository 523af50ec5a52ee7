"""A debugging editor that sends Debug Adapter Protocol requests and waits for messages."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any

from rcx_harness.cli.debug import launched
from structured_text.debug.protocol import Client
from structured_text.debug.session import Session

#: Longest wait for a message [s]. A test that hangs fails after this time.
_LONGEST = 60


class RefusedError(Exception):
    """An error for a request that was answered with a message for the user."""


class _Mail:
    """The stream to which the adapter writes its messages."""

    def __init__(self) -> None:
        self.messages: Queue[dict[str, Any]] = Queue()
        self._rest = b""

    def write(self, data: bytes) -> int:
        self._rest += data
        while b"\r\n\r\n" in self._rest:
            head, _, rest = self._rest.partition(b"\r\n\r\n")
            length = int(head.split(b":")[1])
            if len(rest) < length:
                break
            self.messages.put(json.loads(rest[:length]))
            self._rest = rest[length:]
        return len(data)

    def flush(self) -> None:
        """Do nothing, because this stream has no buffer."""


class Editor:
    """A client of `rcx debug`; the adapter runs in a thread of its own.

    Attributes:
        output: The output in the console.
        exit_code: Exit code of the adapter, once it has ended.
    """

    def __init__(self, launch: Callable[[Mapping[str, Any]], Any] | None = None) -> None:
        self._mail = _Mail()
        self._client = Client(None, self._mail)  # type: ignore[arg-type]
        self._launch = launch or (lambda arguments: launched(arguments, []))
        self._events: list[dict[str, Any]] = []
        self._seq = 0
        self.output: list[str] = []
        self.exit_code: int | None = None
        self.session = Session(self._client, self._launch)
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        self.exit_code = self.session.run()

    def request(self, command: str, **arguments: Any) -> dict[str, Any]:
        """Send a request.

        Returns:
            The body of the answer.

        Raises:
            RefusedError: the request was refused; the error has the message.
        """
        self._seq += 1
        message = {"seq": self._seq, "type": "request", "command": command}
        found = self.answer_to({**message, "arguments": arguments})
        assert found["request_seq"] == self._seq
        if not found["success"]:
            raise RefusedError(found["message"])
        return found.get("body") or {}

    def answer_to(self, message: dict[str, Any]) -> dict[str, Any]:
        """Send any message, and return the complete answer."""
        self._client.inbox.put(message)
        while True:
            found = self._next()
            if found["type"] == "response":
                return found
            self._events.append(found)

    def event(self, name: str) -> dict[str, Any]:
        """Return the next event of this name, and discard the events before it."""
        while True:
            found = self._events.pop(0) if self._events else self._next()
            if found.get("event") == name:
                return found.get("body") or {}

    def _next(self) -> dict[str, Any]:
        found = self._mail.messages.get(timeout=_LONGEST)
        if found.get("event") == "output":
            self.output.append(found["body"]["output"].rstrip("\n"))
        return found

    # --- frequent actions ---

    def start(
        self, breakpoints: Mapping[str | Path, list[Any]] | None = None, **launch: Any
    ) -> Any:
        """Launch a program, run to its first stop, and return the reason of the stop.

        Args:
            breakpoints: For each file, lines or breakpoints of the protocol.
            launch: Arguments of the launch request. A `_` at the end of a name is removed (`for_`).
        """
        self.request("initialize", adapterID="rcx", linesStartAt1=True)
        self.request("launch", **{name.rstrip("_"): value for name, value in launch.items()})
        self.event("initialized")
        for file, wanted in (breakpoints or {}).items():
            self.set(file, *wanted)
        self.request("configurationDone")
        return self.event("stopped")

    def set(self, file: str | Path, *wanted: Any) -> list[dict[str, Any]]:
        """Set the breakpoints of a file."""
        every = [one if isinstance(one, dict) else {"line": one} for one in wanted]
        body = self.request("setBreakpoints", source={"path": str(file)}, breakpoints=every)
        found: list[dict[str, Any]] = body["breakpoints"]
        return found

    def go(self, command: str = "continue", thread: int = 1, **arguments: Any) -> dict[str, Any]:
        """Continue forwards or backwards until the next stop, and return the stop event."""
        self.request(command, threadId=thread, **arguments)
        return self.event("stopped")

    def stack(self, thread: int = 1) -> list[tuple[str, int]]:
        """Return the titles and lines of the stack, beginning with the innermost frame."""
        frames = self.request("stackTrace", threadId=thread)["stackFrames"]
        return [(one["name"], one["line"]) for one in frames]

    @property
    def line(self) -> int:
        """Return the line of the innermost stack frame."""
        return self.stack()[0][1]

    def value(
        self, expression: str, level: int = 0, context: str = "watch", thread: int = 1
    ) -> str:
        """Return the value of an expression in a frame of the stack."""
        frames = self.request("stackTrace", threadId=thread)["stackFrames"]
        asked = {"expression": expression, "frameId": frames[level]["id"], "context": context}
        return str(self.request("evaluate", **asked)["result"])

    def say(self, text: str) -> str:
        """Enter a line in the debug console."""
        return self.value(text, context="repl")

    def scope(self, name: str, level: int = 0, thread: int = 1) -> dict[str, dict[str, Any]]:
        """Return the variables of a scope, by name."""
        frames = self.request("stackTrace", threadId=thread)["stackFrames"]
        scopes = self.request("scopes", frameId=frames[level]["id"])["scopes"]
        (found,) = [one for one in scopes if one["name"] == name]
        return self.below(found)

    def below(self, of: Mapping[str, Any], **page: int) -> dict[str, dict[str, Any]]:
        """Return the members or elements of a variable, by name."""
        asked = {"variablesReference": of["variablesReference"], **page}
        return {one["name"]: one for one in self.request("variables", **asked)["variables"]}

    def close(self) -> None:
        """End the session, and check that the adapter ends."""
        self._client.inbox.put(None)
        self._thread.join(_LONGEST)
        assert not self._thread.is_alive(), "the adapter still runs after the end of the session"
