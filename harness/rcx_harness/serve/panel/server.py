"""The web server of the faceplates: a thread, protected like the pages of rcx serve."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from threading import Thread

from aiohttp import web

from rcx_harness.serve.guard import TokenServer, add_files, guarded, read_message
from rcx_harness.serve.panel.plate import Plate
from structured_text.errors import InputError

__all__ = ["FILES", "PanelServer", "application"]

_OWN, _SERVE = "rcx_harness.serve.panel", "rcx_harness.serve"
#: Static files by their path: the package, the file in the package's folder `page`, and its type.
FILES = {
    "/": (_OWN, "index.html", "text/html"),
    "/panel.css": (_OWN, "panel.css", "text/css"),
    "/panel.js": (_OWN, "panel.js", "text/javascript"),
    "/page.css": (_SERVE, "page.css", "text/css"),
}
_PLATES: web.AppKey[Sequence[Plate]] = web.AppKey("plates", Sequence)


def application(plates: Sequence[Plate], token: str) -> web.Application:
    """Create the web application for these panels; its paths begin with the token."""
    app = guarded(token, "rcx run")
    app[_PLATES] = plates
    add_files(app, FILES)
    panels = f"/{token}/api/panels"
    app.router.add_get(panels, _panels)
    app.router.add_get(f"{panels}/{{id}}", _panel)
    app.router.add_post(f"{panels}/{{id}}/keys", _keys)
    app.router.add_post(f"{panels}/{{id}}/choices", _choice)
    return app


async def _panels(request: web.Request) -> web.Response:
    return web.json_response([one.path for one in request.app[_PLATES]])


async def _panel(request: web.Request) -> web.Response:
    return web.json_response(_plate(request).shown())


async def _keys(request: web.Request) -> web.Response:
    """Store all keys that a page holds: `{"page": "k3", "beat": 7, "keys": ["JogPlus"]}`."""
    example = '{"page": "k3", "beat": 7, "keys": ["JogPlus"]}'
    message = await read_message(request, example, "keys", page=str, beat=int, keys=list)
    keys = message["keys"]
    if not all(isinstance(key, str) for key in keys) or len(message["page"]) > 40:
        raise InputError(f"keys are expected: {example}")
    _plate(request).press(message["page"], message["beat"], keys)
    return web.json_response({"done": "keys"})


async def _choice(request: web.Request) -> web.Response:
    """Store a selection: `{"name": "Axis", "value": 2}`."""
    message = await read_message(request, '{"name": "Axis", "value": 2}', "a choice", name=str)
    _plate(request).choose(message["name"], message.get("value"))
    return web.json_response({"done": message["name"]})


def _plate(request: web.Request) -> Plate:
    plates = request.app[_PLATES]
    text = request.match_info["id"]
    for number, plate in enumerate(plates):
        if text == str(number):
            return plate
    raise web.HTTPNotFound(reason=f"there is no panel {text!r:.20}")


class PanelServer:
    """The server of the panels, which runs in a thread inside a `with` statement."""

    def __init__(self, plates: Sequence[Plate], port: int, token: str = "") -> None:
        self._make: Callable[[], TokenServer] = lambda: TokenServer(
            lambda own: application(plates, own), port, "--panel", token
        )
        self._started: Future[tuple[str, asyncio.AbstractEventLoop, asyncio.Event]] = Future()
        self._thread = Thread(target=lambda: asyncio.run(self._serve()), name="panel", daemon=True)

    def __enter__(self) -> PanelServer:
        self._thread.start()
        self._started.result()
        return self

    def __exit__(self, *of: object) -> None:
        _, loop, stop = self._started.result()
        loop.call_soon_threadsafe(stop.set)
        self._thread.join()

    @property
    def address(self) -> str:
        """Return the address of the page."""
        return self._started.result()[0]

    async def _serve(self) -> None:
        server, stop = self._make(), asyncio.Event()
        try:
            await server.start()
        except InputError as error:
            self._started.set_exception(error)
            return
        self._started.set_result((server.address, asyncio.get_running_loop(), stop))
        await stop.wait()
        await server.close()
