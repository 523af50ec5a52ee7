"""The web page: static files, the state as JSON, the chart as SVG, and what is done by POST.

All of it stands below a token that nobody can guess; the address that is printed has it.
"""

from __future__ import annotations

import hmac
import json
import logging
import secrets
from collections.abc import Awaitable, Callable, Mapping, Sequence
from importlib.resources import files
from typing import Any

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

from rcx_harness.errors import InputError
from rcx_harness.serve.clicks import Clicks
from rcx_harness.serve.history import live_chart
from rcx_harness.serve.host import Host
from rcx_harness.serve.view import view

__all__ = ["FILES", "WEB_HOST", "WebServer", "application"]

WEB_HOST = "127.0.0.1"
"""The page is for this machine only."""

_OWN, _VIEW = "rcx_harness.serve", "rcx_harness.trace.view"
_SCRIPT = "text/javascript"
#: What is served besides the interface: path, package and file of its folder `page`, its type.
FILES = {
    "/": (_OWN, "index.html", "text/html"),
    "/page.css": (_OWN, "page.css", "text/css"),
    "/page.js": (_OWN, "page.js", _SCRIPT),
    "/chart.js": (_OWN, "chart.js", _SCRIPT),
    "/monitor.js": (_OWN, "monitor.js", _SCRIPT),
    "/operate.js": (_OWN, "operate.js", _SCRIPT),
    "/positions.js": (_OWN, "positions.js", _SCRIPT),
    "/robot.js": (_VIEW, "robot.js", _SCRIPT),
}
_TOKEN_BYTES = 16
_WITHOUT_TOKEN = "the address lacks its token: open the one that rcx serve printed at its start"
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
_TOKEN: web.AppKey[str] = web.AppKey("token", str)
_CLICKS: web.AppKey[Clicks] = web.AppKey("clicks", Clicks)
#: What a sender does wrong is answered; only mistakes of this program belong in the log.
_SENDERS_FAULTS = (HttpProcessingError, web.RequestPayloadError, ConnectionError)
_LOG = logging.getLogger(__name__)
_LOG.addFilter(lambda record: not isinstance((record.exc_info or (0, 0))[1], _SENDERS_FAULTS))
_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def application(hosts: Sequence[Host], token: str) -> web.Application:
    """The web application for these controllers; its paths begin with the token."""
    app = web.Application(middlewares=[_guard], client_max_size=_LARGEST_REQUEST)
    app[_HOSTS], app[_TOKEN], app[_CLICKS] = hosts, token, Clicks()
    for path in FILES:
        app.router.add_get(f"/{token}{path}", _file)
    robots = f"/{token}/api/robots"
    app.router.add_get(robots, _robots)
    for path, show in (
        ("", _robot),
        ("/model", _model),
        ("/chart.svg", _chart),
        ("/recording.jsonl", _recording),
    ):
        app.router.add_get(f"{robots}/{{id}}{path}", show)
    for path, act in (
        ("events", _event),
        ("outputs", _output),
        ("workpieces", _workpiece),
        ("recording", _record),
    ):
        app.router.add_post(f"{robots}/{{id}}/{path}", act)
    app.router.add_get(f"/{token}/api/stimulus.toml", _stimulus)
    app.router.add_post(f"/{token}/api/stimulus", _begin_stimulus)
    return app


class WebServer:
    """Serves the page on the loopback interface.

    Args:
        hosts: The controllers.
        port: TCP port, 0 for any free one.
        token: What the paths begin with; another one each time where it is not given.
    """

    def __init__(self, hosts: Sequence[Host], port: int, token: str = "") -> None:
        self._token = token or secrets.token_urlsafe(_TOKEN_BYTES)
        self._runner = web.AppRunner(
            application(hosts, self._token), access_log=None, logger=_LOG, auto_decompress=False
        )
        self.port = port

    @property
    def address(self) -> str:
        """Where to find the page, with its token."""
        return f"http://{WEB_HOST}:{self.port}/{self._token}/"

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
    """Only who knows the token may ask; each answer says what a page may do."""
    host, _, _port = request.host.rpartition(":")
    if (host or request.host) not in _OWN_NAMES:
        # Another name that leads here is another site's (DNS rebinding).
        response: web.StreamResponse = _error(403, "this page is for this machine only")
    elif not _has_token(request):
        response = _error(403, _WITHOUT_TOKEN)
    elif request.headers.get("Origin", _own_origin(request)) != _own_origin(request):
        response = _error(403, "only the page itself may do this: the origin is another")
    else:
        try:
            response = await handler(request)
        except InputError as error:
            response = _error(400, str(error))
        except web.RequestPayloadError:
            response = _error(400, "the request does not come whole, or not as it says")
        except web.HTTPRequestEntityTooLarge:
            response = _error(400, f"the request is longer than {_LARGEST_REQUEST} bytes")
        except web.HTTPException as error:
            response = _error(error.status, error.reason)
    response.headers.update(_HEADERS)
    return response


def _has_token(request: web.Request) -> bool:
    given = request.path.split("/")[1] if request.path.startswith("/") else ""
    return hmac.compare_digest(given.encode("utf-8", "replace"), request.app[_TOKEN].encode())


def _own_origin(request: web.Request) -> str:
    return f"http://{request.host}"


def _error(status: int, text: str) -> web.Response:
    return web.json_response({"error": text}, status=status)


async def _file(request: web.Request) -> web.Response:
    package, name, kind = FILES["/" + request.path.split("/", 2)[2]]
    body = files(package).joinpath("page").joinpath(name).read_bytes()
    return web.Response(body=body, content_type=kind, charset="utf-8")


async def _robots(request: web.Request) -> web.Response:
    hosts = request.app[_HOSTS]
    every = [view(number, host) for number, host in enumerate(hosts)]
    wanted = ("id", "name", "size", "running", "connected", "leds", "alarms")
    return web.json_response([{key: one[key] for key in wanted} for one in every])


async def _robot(request: web.Request) -> web.Response:
    return web.json_response(view(*_host(request)))


async def _model(request: web.Request) -> web.Response:
    """What its robots look like (`rcx_harness.robot.shape`)."""
    _, host = _host(request)
    return web.json_response({"robots": list(host.shapes), "drawn": host.drawn})


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
    message = await _message(request, '{"event": "emergency_stop"}', "an event", event=str)
    args = message.get("args", {})
    if not isinstance(args, dict) or not all(type(value) is int for value in args.values()):
        raise InputError("the arguments of an event are whole numbers by name")
    return await _do(request, {"event": message["event"], "args": args}, message["event"])


_OUTPUTS = ("hold", "release", "force")


async def _output(request: web.Request) -> web.Response:
    """`{"output": "SO(20)", "do": "force", "value": 1}`; `hold` and `release` have no value."""
    example = '{"output": "SO(20)", "do": "force", "value": 1}'
    message = await _message(request, example, "an output", output=str, do=str)
    if message["do"] not in _OUTPUTS:
        raise InputError(
            f"an output cannot {message['do']!r:.20}", hint="hold, release or force it"
        )
    wanted: dict[str, Any] = {"output": message["output"], "do": message["do"]}
    if message["do"] == "force":
        if type(message.get("value")) is not int:
            raise InputError("the value of an output is a whole number", hint=f"send {example}")
        wanted["value"] = message["value"]
    return await _do(request, wanted, message["do"])


async def _workpiece(request: web.Request) -> web.Response:
    """`{"axis": 3, "pulses": 90000}`; null for no workpiece any more."""
    example = '{"axis": 3, "pulses": 90000}'
    message = await _message(request, example, "a workpiece", axis=int)
    pulses = message.get("pulses")
    if pulses is not None and type(pulses) is not int:
        raise InputError("a workpiece stands at a whole number of pulses", hint=f"send {example}")
    return await _do(request, {"workpiece": message["axis"], "pulses": pulses}, "workpiece")


async def _record(request: web.Request) -> web.Response:
    """`{"do": "start"}` begins a recording, `{"do": "stop"}` ends it."""
    message = await _message(request, '{"do": "start"}', "a recording", do=str)
    if message["do"] not in ("start", "stop"):
        raise InputError("a recording can start and stop", hint='send {"do": "start"}')
    _, host = _host(request)
    await host.record(on=message["do"] == "start")
    return web.json_response({"done": message["do"]})


async def _recording(request: web.Request) -> web.StreamResponse:
    """The trace that was recorded, to keep."""
    _, host = _host(request)
    name = f"rcx-serve-{host.name.replace(':', '-')}.jsonl"
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return web.FileResponse(host.recording(), headers=headers)


async def _begin_stimulus(request: web.Request) -> web.Response:
    """`{"do": "begin"}`: what was done until now is forgotten, the time of the stimulus is 0."""
    message = await _message(request, '{"do": "begin"}', "a stimulus", do=str)
    if message["do"] != "begin":
        raise InputError("a stimulus can begin", hint='send {"do": "begin"}')
    request.app[_CLICKS].begin([host.status.t_us for host in request.app[_HOSTS]])
    return web.json_response({"done": "begin"})


async def _stimulus(request: web.Request) -> web.Response:
    """What was done since then, as a file."""
    headers = {"Content-Disposition": 'attachment; filename="stimulus.toml"'}
    return web.Response(text=request.app[_CLICKS].text(), headers=headers)


async def _do(request: web.Request, message: Mapping[str, Any], what: str) -> web.Response:
    """Let a controller do it, and note it for the stimulus."""
    number, host = _host(request)
    t_us = await host.ask(message)
    request.app[_CLICKS].add(number, t_us, message)
    return web.json_response({"done": what})


async def _message(
    request: web.Request, example: str, what: str, **needed: type[Any]
) -> dict[str, Any]:
    """The JSON object that was sent, whose entries `needed` have these types."""
    charset = request.charset or "utf-8"
    if charset.lower() not in _CHARSETS:
        raise InputError(f"the charset {charset[:20]!r} is not taken", hint="send UTF-8")
    if request.headers.get("Content-Encoding", "identity") != "identity":
        raise InputError("a packed request is not taken", hint="send it as it is")
    try:
        message: Any = json.loads(await request.read())
    except (ValueError, RecursionError):
        message = None
    fits = isinstance(message, dict) and all(
        type(message.get(name)) is kind for name, kind in needed.items()
    )
    if not fits:
        raise InputError(f"{what} is expected: {example}")
    found: dict[str, Any] = message
    return found


def _host(request: web.Request) -> tuple[int, Host]:
    hosts = request.app[_HOSTS]
    text = request.match_info["id"]
    for number, host in enumerate(hosts):
        if text == str(number):
            return number, host
    raise web.HTTPNotFound(reason=f"there is no controller {text!r:.20}")
