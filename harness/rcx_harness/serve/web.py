"""The web page: static files, the state as JSON, the chart as SVG, and actions by POST.

All paths begin with a random token, which the printed address contains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from aiohttp import web

from rcx_harness.serve.clicks import Clicks
from rcx_harness.serve.guard import TokenServer, add_files, guarded, read_message
from rcx_harness.serve.history import live_chart
from rcx_harness.serve.host import Host
from rcx_harness.serve.view import view
from structured_text.errors import InputError

__all__ = ["FILES", "WebServer", "application"]

_OWN, _VIEW = "rcx_harness.serve", "rcx_harness.trace.view"
_SCRIPT = "text/javascript"
#: Static files by their path: the package, the file in the package's folder `page`, and its type.
FILES = {
    "/": (_OWN, "index.html", "text/html"),
    "/page.css": (_OWN, "page.css", "text/css"),
    "/page.js": (_OWN, "page.js", _SCRIPT),
    "/chart.js": (_OWN, "chart.js", _SCRIPT),
    "/monitor.js": (_OWN, "monitor.js", _SCRIPT),
    "/operate.js": (_OWN, "operate.js", _SCRIPT),
    "/positions.js": (_OWN, "positions.js", _SCRIPT),
    "/programs.js": (_OWN, "programs.js", _SCRIPT),
    "/robot.js": (_VIEW, "robot.js", _SCRIPT),
    "/listing.js": (_VIEW, "listing.js", _SCRIPT),
}
_SECONDS, _WIDTHS = (1.0, 60.0), (200, 4000)
_HOSTS: web.AppKey[Sequence[Host]] = web.AppKey("hosts", Sequence)
_CLICKS: web.AppKey[Clicks] = web.AppKey("clicks", Clicks)


def application(hosts: Sequence[Host], token: str) -> web.Application:
    """Create the web application for these controllers; its paths begin with the token."""
    app = guarded(token, "rcx serve")
    app[_HOSTS], app[_CLICKS] = hosts, Clicks()
    add_files(app, FILES)
    robots = f"/{token}/api/robots"
    app.router.add_get(robots, _robots)
    for path, show in (
        ("", _robot),
        ("/model", _model),
        ("/programs", _programs),
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


class WebServer(TokenServer):
    """The server of the page on the loopback interface."""

    def __init__(self, hosts: Sequence[Host], port: int, token: str = "") -> None:
        super().__init__(lambda own: application(hosts, own), port, "--web", token)


async def _robots(request: web.Request) -> web.Response:
    hosts = request.app[_HOSTS]
    every = [view(number, host) for number, host in enumerate(hosts)]
    wanted = ("id", "name", "size", "running", "connected", "leds", "alarms")
    return web.json_response([{key: one[key] for key in wanted} for one in every])


async def _robot(request: web.Request) -> web.Response:
    return web.json_response(view(*_host(request)))


async def _model(request: web.Request) -> web.Response:
    """Return the geometry of a controller's robots (`rcx_harness.robot.shape`)."""
    _, host = _host(request)
    return web.json_response({"robots": list(host.shapes), "drawn": host.drawn})


async def _programs(request: web.Request) -> web.Response:
    """Return the robot programs of a controller (`rcx_harness.robot.listing`)."""
    _, host = _host(request)
    return web.json_response(list(host.listings))


async def _chart(request: web.Request) -> web.Response:
    """Return the chart of the last `?seconds=10`, `&width=1266` pixels wide."""
    _, host = _host(request)
    history = host.history
    text = request.query.get("seconds", "10")
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not _SECONDS[0] <= seconds <= _SECONDS[1]:
        raise InputError(f"seconds={text:.20} is not {_SECONDS[0]:g} to {_SECONDS[1]:g}")
    given = request.query.get("width", "1266")
    if not given.isascii() or not given.isdigit() or len(given) > 4:
        raise InputError(f"width={given:.20} is not a whole number of pixels")
    width = min(max(int(given), _WIDTHS[0]), _WIDTHS[1])
    svg = live_chart(history.lanes(), history.now_us, seconds, width)
    return web.Response(text=svg, content_type="image/svg+xml")


async def _event(request: web.Request) -> web.Response:
    """Trigger an event: `{"event": "alarm", "args": {"group": 12, "category": 600}}`."""
    message = await read_message(request, '{"event": "emergency_stop"}', "an event", event=str)
    args = message.get("args", {})
    if not isinstance(args, dict) or not all(type(value) is int for value in args.values()):
        raise InputError("the arguments of an event are whole numbers by name")
    return await _do(request, {"event": message["event"], "args": args}, message["event"])


_OUTPUTS = ("hold", "release", "force")


async def _output(request: web.Request) -> web.Response:
    """Hold, release or force an output: `{"output": "SO(20)", "do": "force", "value": 1}`.

    `hold` and `release` have no value.
    """
    example = '{"output": "SO(20)", "do": "force", "value": 1}'
    message = await read_message(request, example, "an output", output=str, do=str)
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
    """Place a workpiece: `{"axis": 3, "pulses": 90000}`; null removes it."""
    example = '{"axis": 3, "pulses": 90000}'
    message = await read_message(request, example, "a workpiece", axis=int)
    pulses = message.get("pulses")
    if pulses is not None and type(pulses) is not int:
        raise InputError("a workpiece stands at a whole number of pulses", hint=f"send {example}")
    return await _do(request, {"workpiece": message["axis"], "pulses": pulses}, "workpiece")


async def _record(request: web.Request) -> web.Response:
    """Start a recording on `{"do": "start"}`, end it on `{"do": "stop"}`."""
    message = await read_message(request, '{"do": "start"}', "a recording", do=str)
    if message["do"] not in ("start", "stop"):
        raise InputError("a recording can only start or stop", hint='send {"do": "start"}')
    _, host = _host(request)
    await host.record(on=message["do"] == "start")
    return web.json_response({"done": message["do"]})


async def _recording(request: web.Request) -> web.StreamResponse:
    """Return the recorded trace as a download."""
    _, host = _host(request)
    name = f"rcx-serve-{host.name.replace(':', '-')}.jsonl"
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return web.FileResponse(host.recording(), headers=headers)


async def _begin_stimulus(request: web.Request) -> web.Response:
    """Delete the recorded actions on `{"do": "begin"}`; the time of the stimulus is then 0."""
    message = await read_message(request, '{"do": "begin"}', "a stimulus", do=str)
    if message["do"] != "begin":
        raise InputError("a stimulus can only begin", hint='send {"do": "begin"}')
    request.app[_CLICKS].begin([host.status.t_us for host in request.app[_HOSTS]])
    return web.json_response({"done": "begin"})


async def _stimulus(request: web.Request) -> web.Response:
    """Return the actions since the last `begin` as a stimulus file."""
    headers = {"Content-Disposition": 'attachment; filename="stimulus.toml"'}
    return web.Response(text=request.app[_CLICKS].text(), headers=headers)


async def _do(request: web.Request, message: Mapping[str, Any], what: str) -> web.Response:
    """Send a message to a controller, and record it for the stimulus."""
    number, host = _host(request)
    t_us = await host.ask(message)
    request.app[_CLICKS].add(number, t_us, message)
    return web.json_response({"done": what})


def _host(request: web.Request) -> tuple[int, Host]:
    hosts = request.app[_HOSTS]
    text = request.match_info["id"]
    for number, host in enumerate(hosts):
        if text == str(number):
            return number, host
    raise web.HTTPNotFound(reason=f"there is no controller {text!r:.20}")
