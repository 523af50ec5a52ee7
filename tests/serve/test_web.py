"""The web page's server: what it gives, what it takes, whom it refuses."""

from __future__ import annotations

import asyncio
import re
import sys
from collections.abc import Awaitable, Callable
from importlib.resources import files
from pathlib import Path

import pytest
from aiohttp.test_utils import TestClient, TestServer
from aiohttp.web import Application, Request

from rcx_harness.errors import InputError
from rcx_harness.serve import web
from rcx_harness.serve.run import serve
from served import ServedHost

_PAGE = Path(web.__file__).parent / "page"
Client = TestClient[Request, Application]


@pytest.fixture
def hosts() -> list[ServedHost]:
    """Two controllers, one of them connected."""
    first, second = ServedHost(), ServedHost(address="127.0.0.2")
    first.network.send(bytes(32) + b"\x41" + bytes(15))
    first.run(200)
    second.run(200)
    return [first, second]


def _with_client(hosts: list[ServedHost], use: Callable[[Client], Awaitable[None]]) -> None:
    async def run() -> None:
        async with TestClient(
            TestServer(web.application(hosts, "token"), host="127.0.0.1")
        ) as client:
            await use(client)

    asyncio.run(run())


def _origin(client: Client) -> dict[str, str]:
    return {"Origin": f"http://127.0.0.1:{client.port}"}


def test_the_page_and_all_it_asks_for_come_from_this_server(hosts: list[ServedHost]) -> None:
    async def use(client: Client) -> None:
        page = await (await client.get("/token/")).text()
        wanted = re.findall(r'(?:src|href)="([^":]+)"', page)
        assert wanted == ["page.css", "page.js"]
        wanted += [path for path in web.FILES if path != "/"]
        for name in wanted:
            answer = await client.get("/token/" + name.lstrip("/"))
            assert answer.status == 200
            assert "default-src 'self'" in answer.headers["Content-Security-Policy"]

    _with_client(hosts, use)


def test_no_file_of_the_page_names_another_server() -> None:
    own = sorted(_PAGE.iterdir())
    served = [files(package).joinpath("page", name) for package, name, _ in web.FILES.values()]
    assert {str(file) for file in own} <= {str(file) for file in served}
    for file in served:
        addresses = set(re.findall(r"(?:https?:)?//[\w.]+\S*", file.read_text(encoding="utf-8")))
        named = {one for one in addresses if "://" in one}
        assert named <= {'http://www.w3.org/2000/svg";'}, str(file)  # a name space, never fetched


def test_every_controller_has_its_tab_and_its_state(hosts: list[ServedHost]) -> None:
    async def use(client: Client) -> None:
        tabs = await (await client.get("/token/api/robots")).json()
        assert [(one["id"], one["name"], one["connected"]) for one in tabs] == [
            (0, "127.0.0.1", True),
            (1, "127.0.0.2", False),
        ]
        robot = await (await client.get("/token/api/robots/1")).json()
        assert robot["connection"] == "no master has connected yet"
        assert robot["alarms"] == ["12.551 EtherNet/IP link error"]

    _with_client(hosts, use)


def test_the_chart_is_an_svg_of_the_last_seconds(hosts: list[ServedHost]) -> None:
    async def use(client: Client) -> None:
        answer = await client.get("/token/api/robots/0/chart.svg?seconds=2")
        assert answer.content_type == "image/svg+xml"
        assert 'data-span="2000000"' in await answer.text()
        for text in ("0.5", "61", "nan", "x", ""):
            answer = await client.get(f"/token/api/robots/0/chart.svg?seconds={text}")
            assert answer.status == 400
            assert (await answer.json())["error"] == f"seconds={text} is not 1 to 60"

    _with_client(hosts, use)


def test_an_event_by_post_happens_to_its_controller(hosts: list[ServedHost]) -> None:
    async def use(client: Client) -> None:
        message = {"event": "emergency_stop"}
        answer = await client.post(
            "/token/api/robots/1/events", json=message, headers=_origin(client)
        )
        assert (answer.status, await answer.json()) == (200, {"done": "emergency_stop"})
        robots = [await (await client.get(f"/token/api/robots/{k}")).json() for k in (0, 1)]
        assert [one["switches"]["emergency_stop"] for one in robots] == [False, True]

    _with_client(hosts, use)


@pytest.mark.parametrize("origin", [None, "http://example.com", "https://127.0.0.1", "null"])
def test_an_event_of_another_origin_is_refused(hosts: list[ServedHost], origin: str | None) -> None:
    async def use(client: Client) -> None:
        headers = {"Origin": origin} if origin else {}
        message = {"event": "emergency_stop"}
        answer = await client.post("/token/api/robots/0/events", json=message, headers=headers)
        assert answer.status == 403
        assert not hosts[0].run(5).emergency_stop

    _with_client(hosts, use)


@pytest.mark.parametrize("name", ["example.com", "example.com:80", "127.0.0.1.example.com"])
def test_a_foreign_name_that_leads_here_is_refused(hosts: list[ServedHost], name: str) -> None:
    async def use(client: Client) -> None:
        headers = {"Host": name, "Origin": f"http://{name}"}
        assert (await client.get("/token/api/robots", headers=headers)).status == 403
        message = {"event": "emergency_stop"}
        answer = await client.post("/token/api/robots/0/events", json=message, headers=headers)
        assert answer.status == 403
        assert not hosts[0].run(5).emergency_stop

    _with_client(hosts, use)


def test_state_is_never_changed_by_get(hosts: list[ServedHost]) -> None:
    async def use(client: Client) -> None:
        answer = await client.get("/token/api/robots/0/events", headers=_origin(client))
        assert answer.status == 405

    _with_client(hosts, use)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("", 'an event is expected: {"event": "emergency_stop"}'),
        ("[]", 'an event is expected: {"event": "emergency_stop"}'),
        ('{"event": 5}', 'an event is expected: {"event": "emergency_stop"}'),
        ('{"event": "alarm", "args": [1]}', "the arguments of an event are whole numbers by name"),
        (
            '{"event": "alarm", "args": {"group": true, "category": 1}}',
            "the arguments of an event are whole numbers by name",
        ),
        ('{"event": "alarm", "args": {"group": 1}}', "event 'alarm' needs category"),
        ('{"event": "alarm", "args": {"event": 1}}', "event 'alarm' does not take event"),
        ('{"event": "alarm", "args": {"self": 1}}', "event 'alarm' does not take self"),
        ('{"event": "explode"}', "unknown event 'explode'"),
    ],
)
def test_a_wrong_event_is_refused_in_one_message(
    hosts: list[ServedHost], body: str, message: str
) -> None:
    async def use(client: Client) -> None:
        answer = await client.post(
            "/token/api/robots/0/events", data=body.encode(), headers=_origin(client)
        )
        assert answer.status == 400
        assert (await answer.json())["error"].startswith(message)

    _with_client(hosts, use)


def test_a_request_that_is_too_long_is_refused(hosts: list[ServedHost]) -> None:
    async def use(client: Client) -> None:
        answer = await client.post(
            "/token/api/robots/0/events", data=b" " * 5000, headers=_origin(client)
        )
        assert answer.status == 413

    _with_client(hosts, use)


@pytest.mark.parametrize("path", ["/api/robots/2", "/api/robots/x", "/api/robots/-1", "/x"])
def test_what_is_not_there_is_not_found(hosts: list[ServedHost], path: str) -> None:
    async def use(client: Client) -> None:
        answer = await client.get(path)
        assert answer.status == 404
        assert "error" in await answer.json()

    _with_client(hosts, use)


def test_a_port_that_is_taken_is_one_clear_message(hosts: list[ServedHost]) -> None:
    async def use() -> None:
        first = web.WebServer(hosts, 0)
        await first.start()
        assert first.address == f"http://127.0.0.1:{first.port}/"
        with pytest.raises(InputError, match=f"cannot be served on 127.0.0.1:{first.port}: "):
            await web.WebServer(hosts, first.port).start()
        await first.close()

    asyncio.run(use())


def test_without_aiohttp_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """The package is on no index; the library that is missing is."""
    monkeypatch.delitem(sys.modules, "rcx_harness.serve.web", raising=False)
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    with pytest.raises(InputError) as caught:
        asyncio.run(serve([], 0, quiet=True))
    assert str(caught.value) == "the web page needs the library aiohttp; pip install aiohttp"
