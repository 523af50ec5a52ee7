"""The web page: static files, the state as JSON, the chart as SVG, and events by POST."""

from __future__ import annotations

import json
import logging
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Any

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

from rcx_harness.errors import InputError
from rcx_harness.serve.history import live_chart
from rcx_harness.serve.host import Host
from rcx_harness.serve.view import view

__all__ = ["FILES", "WEB_HOST", "WebServer", "application"]

WEB_HOST = "127.0.0.1"
"""The page is for this machine only."""

_PAGE = Path(__file__).parent / "page"
#: What is served besides the interface: path, file and type of content.
FILES = {
    "/": ("index.html", "text/html"),
    "/page.css": ("page.css", "text/css"),
    "/page.js": ("page.js", "text/javascript"),
    "/chart.js": ("chart.js", "text/javascript"),
    "/monitor.js": ("monitor.js", "text/javascript"),
}
_OWN_NAMES = ("127.0.0.1", "localhost")
_CHARSETS = ("utf-8", "utf8", "us-ascii")
_SECONDS = (1.0, 60.0)
_LARGEST_REQUEST = 4096
_HEADERS = {
    "Cache-Control": "no-store",
    # The charts carry their style sheet in themselves; nothing comes from elsewhere.
    "Content-Security-Policy": (
        "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
        "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
_HOSTS: web.AppKey[Sequence[Host]] = web.AppKey("hosts", Sequence)
#: What a sender does wrong is answered; only mistakes of this program belong in the log.
_SENDERS_FAULTS = (HttpProcessingError, web.RequestPayloadError, ConnectionError)
_LOG = logging.getLogger(__name__)
_LOG.addFilter(lambda record: not isinstance((record.exc_info or (0, 0))[1], _SENDERS_FAULTS))
_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def application(hosts: Sequence[Host]) -> web.Application:
    """The web application for these controllers."""
    app = web.Application(middlewares=[_guard], client_max_size=_LARGEST_REQUEST)
    app[_HOSTS] = hosts
    for path in FILES:
        app.router.add_get(path, _file)
    app.router.add_get("/api/robots", _robots)
    app.router.add_get("/api/robots/{id}", _robot)
    app.router.add_get("/api/robots/{id}/chart.svg", _chart)
    app.router.add_post("/api/robots/{id}/events", _event)
    return app


class WebServer:
    """Serves the page on the loopback interface.

    Args:
        hosts: The controllers.
        port: TCP port, 0 for any free one.
    """

    def __init__(self, hosts: Sequence[Host], port: int) -> None:
        self._runner = web.AppRunner(
            application(hosts), access_log=None, logger=_LOG, auto_decompress=False
        )
        self.port = port

    @property
    def address(self) -> str:
        """Where to find the page."""
        return f"http://{WEB_HOST}:{self.port}/"

    async def start(self) -> None:
        """Listen.

        Raises:
            InputError: the port is taken.
        """
        await self._runner.setup()
        try:
            await web.TCPSite(self._runner, WEB_HOST, self.port).start()
        except (OSError, OverflowError) as error:
            await self.close()
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(
                f"the web page cannot be served on {WEB_HOST}:{self.port}: {reason}",
                hint="choose a free port with --web",
            ) from None
        self.port = self._runner.addresses[0][1]

    async def close(self) -> None:
        """Stop it."""
        await self._runner.cleanup()


@web.middleware
async def _guard(request: web.Request, handler: _Handler) -> web.StreamResponse:
    """Only pages of this server may ask, and each answer says what a page may do."""
    host, _, _port = request.host.rpartition(":")
    if (host or request.host) not in _OWN_NAMES:
        # Another name that leads here is another site's (DNS rebinding).
        response: web.StreamResponse = _error(403, "this page is for this machine only")
    elif request.method == "POST" and request.headers.get("Origin") != f"http://{request.host}":
        response = _error(403, "only the page itself may do this (another origin, or none)")
    else:
        try:
            response = await handler(request)
        except InputError as error:
            response = _error(400, str(error))
        except web.RequestPayloadError:
            response = _error(400, "the request does not come whole, or not as it says")
        except web.HTTPException as error:
            response = _error(error.status, error.reason)
    response.headers.update(_HEADERS)
    return response


def _error(status: int, text: str) -> web.Response:
    return web.json_response({"error": text}, status=status)


async def _file(request: web.Request) -> web.Response:
    name, kind = FILES[request.path]
    return web.Response(body=(_PAGE / name).read_bytes(), content_type=kind, charset="utf-8")


async def _robots(request: web.Request) -> web.Response:
    hosts = request.app[_HOSTS]
    every = [view(number, host) for number, host in enumerate(hosts)]
    wanted = ("id", "name", "size", "running", "connected", "leds", "alarms")
    return web.json_response([{key: one[key] for key in wanted} for one in every])


async def _robot(request: web.Request) -> web.Response:
    return web.json_response(view(*_host(request)))


async def _chart(request: web.Request) -> web.Response:
    """The last `?seconds=10`."""
    _, host = _host(request)
    history = host.history
    text = request.query.get("seconds", "10")
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not _SECONDS[0] <= seconds <= _SECONDS[1]:
        raise InputError(f"seconds={text:.20} is not {_SECONDS[0]:g} to {_SECONDS[1]:g}")
    svg = live_chart(history.lanes(), history.now_us, seconds)
    return web.Response(text=svg, content_type="image/svg+xml")


async def _event(request: web.Request) -> web.Response:
    """`{"event": "alarm", "args": {"group": 12, "category": 600}}`."""
    _, host = _host(request)
    charset = request.charset or "utf-8"
    if charset.lower() not in _CHARSETS:
        raise InputError(f"the charset {charset[:20]!r} is not taken", hint="send UTF-8")
    if request.headers.get("Content-Encoding", "identity") != "identity":
        raise InputError("a packed request is not taken", hint="send it as it is")
    try:
        message: Any = json.loads(await request.read())
    except (ValueError, RecursionError):
        message = None
    if not isinstance(message, dict) or not isinstance(message.get("event"), str):
        raise InputError('an event is expected: {"event": "emergency_stop"}')
    args = message.get("args", {})
    if not isinstance(args, dict) or not all(type(value) is int for value in args.values()):
        raise InputError("the arguments of an event are whole numbers by name")
    await host.happen(message["event"], args)
    return web.json_response({"done": message["event"]})


def _host(request: web.Request) -> tuple[int, Host]:
    hosts = request.app[_HOSTS]
    text = request.match_info["id"]
    for number, host in enumerate(hosts):
        if text == str(number):
            return number, host
    raise web.HTTPNotFound(reason=f"there is no controller {text!r:.20}")
