"""A synchronous client of an aiohttp application for tests."""

from __future__ import annotations

import asyncio
import json
from typing import Any, NamedTuple

from aiohttp.test_utils import TestClient, TestServer
from aiohttp.web import Application


class Answer(NamedTuple):
    """A complete HTTP answer of the server."""

    status: int
    headers: Any
    path: str
    text: str

    @property
    def json(self) -> Any:
        """Return the answer's JSON text as a Python value."""
        return json.loads(self.text)


class WebClient:
    """A client of an application that it serves itself on 127.0.0.1, in its own event loop."""

    def __init__(self, application: Application) -> None:
        self._loop = asyncio.new_event_loop()
        self._loop.run_until_complete(self._start(application))
        self.own = {"Origin": f"http://127.0.0.1:{self._client.port}"}

    async def _start(self, application: Application) -> None:
        self._client = TestClient(TestServer(application, host="127.0.0.1"))
        await self._client.start_server()

    def get(self, path: str, **options: Any) -> Answer:
        """Send a GET request."""
        return self._loop.run_until_complete(self._ask("GET", path, options))

    def post(self, path: str, **options: Any) -> Answer:
        """Send a POST request."""
        return self._loop.run_until_complete(self._ask("POST", path, options))

    async def _ask(self, method: str, path: str, options: dict[str, Any]) -> Answer:
        async with self._client.request(method, path, **options) as answer:
            text = await answer.text()
            return Answer(answer.status, answer.headers, answer.url.path, text)

    def close(self) -> None:
        """Close the server and the event loop."""
        self._loop.run_until_complete(self._client.close())
        self._loop.close()
