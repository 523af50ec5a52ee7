"""A client of the language server, with messages as an editor writes them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import Any

from structured_text.editor.server import Server

#: Longest wait for a message [s]. A test that hangs fails after this time.
_LONGEST = 60


class LspError(Exception):
    """An error with which the server has answered a request."""


class LspClient:
    """A client that sends messages and waits for answers; the server runs in a thread.

    Attributes:
        capabilities: What the server says that it can do.
    """

    def __init__(self, server: Server, folder: Path, **options: Any) -> None:
        read, self._to_server = os.pipe()
        from_server, write = os.pipe()
        self._answers = os.fdopen(from_server, "rb")
        self._messages: Queue[dict[str, Any]] = Queue()
        self._waiting: list[dict[str, Any]] = []
        self._number = 0
        self._versions: dict[Path, int] = {}
        self._server = server
        reading, writing = os.fdopen(read, "rb"), os.fdopen(write, "wb")
        self._thread = Thread(target=self._serve, args=(reading, writing), daemon=True)
        self._thread.start()
        Thread(target=self._listen, daemon=True).start()
        found = self.request(
            "initialize",
            processId=None,
            rootUri=folder.as_uri(),
            workspaceFolders=[{"uri": folder.as_uri(), "name": folder.name}],
            capabilities={},
            initializationOptions={"pause": 0, **options},
        )
        self.capabilities = found["capabilities"]
        self.notify("initialized")

    def _serve(self, reading: Any, writing: Any) -> None:
        self._server.start_io(reading, writing)
        self._server.end()

    def _listen(self) -> None:
        while line := self._answers.readline():
            length = int(line.split(b":")[1])
            while self._answers.readline().strip():
                pass  # other headers
            self._messages.put(json.loads(self._answers.read(length)))

    def _send(self, message: dict[str, Any]) -> None:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        os.write(self._to_server, b"Content-Length: %d\r\n\r\n%s" % (len(data), data))

    def notify(self, method: str, **params: Any) -> None:
        """Send a message that has no answer."""
        self._send({"method": method, "params": params})

    def request(self, method: str, **params: Any) -> Any:
        """Send a request, and return the answer; raise LspError if it was refused."""
        self._number += 1
        number = self._number
        self._send({"id": number, "method": method, "params": params})
        answer = self.wait(lambda one: one.get("id") == number and "method" not in one)
        if "error" in answer:
            raise LspError(answer["error"]["message"])
        return answer["result"]

    def wait(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Wait for a message; other messages remain for later."""
        for message in self._waiting:
            if wanted(message):
                self._waiting.remove(message)
                return message
        while True:
            try:
                message = self._messages.get(timeout=_LONGEST)
            except Empty:
                raise AssertionError(f"no such message came, but {self._waiting}") from None
            if wanted(message):
                return message
            self._waiting.append(message)

    # --- documents ---

    def open(self, path: Path, text: str | None = None) -> None:
        """Open a document."""
        self._versions[path] = 1
        shown = path.read_text(encoding="utf-8") if text is None else text
        document = {"uri": path.as_uri(), "languageId": "structured-text", "version": 1}
        self.notify("textDocument/didOpen", textDocument={**document, "text": shown})

    def change(self, path: Path, text: str) -> None:
        """Replace the text of a document."""
        self._versions[path] += 1
        document = {"uri": path.as_uri(), "version": self._versions[path]}
        self.notify(
            "textDocument/didChange", textDocument=document, contentChanges=[{"text": text}]
        )

    def diagnostics(self, path: Path) -> list[dict[str, Any]]:
        """Wait for the next diagnostics of a file."""
        uri = path.as_uri()
        method = "textDocument/publishDiagnostics"
        message = self.wait(lambda one: one.get("method") == method and one["params"]["uri"] == uri)
        found: list[dict[str, Any]] = message["params"]["diagnostics"]
        return found

    def ask(self, method: str, path: Path, line: int = -1, character: int = 0, **more: Any) -> Any:
        """Send a request about a document, and a position in it if there is a line."""
        params: dict[str, Any] = {"textDocument": {"uri": path.as_uri()}, **more}
        if line >= 0:
            params["position"] = {"line": line, "character": character}
        return self.request(f"textDocument/{method}", **params)

    def close(self) -> None:
        """Shut the server down, and wait for its end."""
        self.request("shutdown")
        self.notify("exit")
        self._thread.join(_LONGEST)
        os.close(self._to_server)
        self._answers.close()
