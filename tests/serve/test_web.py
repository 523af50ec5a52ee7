"""The server of the web page sends its pages, and refuses requests that it does not know."""

from __future__ import annotations

import asyncio
import re
import sys
from collections.abc import Iterator
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import pytest

from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.serve import web
from rcx_harness.serve.run import serve
from served import ServedHost
from structured_text.errors import InputError
from web_client import WebClient

_PAGE = Path(web.__file__).parent / "page"
EVENTS, STOP = "/token/api/robots/0/events", {"event": "emergency_stop"}


@pytest.fixture
def hosts() -> list[ServedHost]:
    """Return two controllers, of which the first one is connected."""
    first, second = ServedHost(), ServedHost(address="127.0.0.2")
    first.network.send(bytes(32) + b"\x41" + bytes(15))
    first.run(200)
    second.run(200)
    return [first, second]


@pytest.fixture
def client(hosts: list[ServedHost]) -> Iterator[WebClient]:
    """Return a client of the page of both controllers, with the token `token`."""
    client = WebClient(web.application(hosts, "token"))
    yield client
    client.close()


def test_the_page_and_all_it_asks_for_come_from_this_server(client: WebClient) -> None:
    page = client.get("/token/").text
    wanted = re.findall(r'(?:src|href)="([^":]+)"', page)
    assert wanted == ["page.css", "page.js", "api/stimulus.toml"]
    wanted += [path for path in web.FILES if path != "/"]
    for name in wanted:
        answer = client.get("/token/" + name.lstrip("/"))
        assert answer.status == 200
        assert "default-src 'self'" in answer.headers["Content-Security-Policy"]


def test_no_file_of_the_page_names_another_server() -> None:
    own = sorted(_PAGE.iterdir())
    served = [
        files(package).joinpath("page").joinpath(name) for package, name, _ in web.FILES.values()
    ]
    assert {str(file) for file in own} <= {str(file) for file in served}
    for file in served:
        addresses = set(re.findall(r"(?:https?:)?//[\w.]+\S*", file.read_text(encoding="utf-8")))
        named = {one for one in addresses if "://" in one}
        assert named <= {'http://www.w3.org/2000/svg";'}, str(file)  # an XML name space


def test_every_controller_has_its_tab_and_its_state(client: WebClient) -> None:
    tabs = client.get("/token/api/robots").json
    assert [(one["id"], one["name"], one["connected"]) for one in tabs] == [
        (0, "127.0.0.1", True),
        (1, "127.0.0.2", False),
    ]
    robot = client.get("/token/api/robots/1").json
    assert robot["connection"] == "no master has connected yet"
    assert robot["alarms"] == ["12.551 EtherNet/IP link error"]


def test_the_chart_is_an_svg_of_the_last_seconds(client: WebClient) -> None:
    answer = client.get("/token/api/robots/0/chart.svg?seconds=2")
    assert answer.headers["Content-Type"].startswith("image/svg+xml")
    assert 'data-span="2000000"' in answer.text
    for text in ("0.5", "61", "nan", "x", ""):
        answer = client.get(f"/token/api/robots/0/chart.svg?seconds={text}")
        assert answer.status == 400
        assert answer.json["error"] == f"seconds={text} is not 1 to 60"
    for text in ("-1", "1.5", "wide", ""):
        answer = client.get(f"/token/api/robots/0/chart.svg?width={text}")
        assert answer.status == 400
        assert answer.json["error"] == f"width={text} is not a whole number of pixels"


def test_a_report_has_the_positions_since_the_last_report(hosts: list[ServedHost]) -> None:
    """A report has the positions since the last report, so that the page draws a smooth path.

    While an axis moves, there is a sample every 20 ms.
    """
    served = hosts[0]
    served.run(100)
    positions = served.station.controller.positions
    for k in range(1, 11):
        positions[0] = 100 * k
        served.run(20)
    assert [pulses for _, pulses, *_ in served.way][-10:] == [100 * k for k in range(1, 11)]
    times = [t_us for t_us, *_ in served.way][-10:]
    assert {later - t_us for t_us, later in pairwise(times)} == {20_000}
    served.run(100)
    assert [t_us for t_us, *_ in served.way][-1] == times[-1], "the axis does not move"


def test_an_event_by_post_happens_to_its_controller(client: WebClient) -> None:
    answer = client.post("/token/api/robots/1/events", json=STOP, headers=client.own)
    assert (answer.status, answer.json) == (200, {"done": "emergency_stop"})
    robots = [client.get(f"/token/api/robots/{k}").json for k in (0, 1)]
    assert [one["switches"]["emergency_stop"] for one in robots] == [False, True]


@pytest.mark.parametrize("origin", ["", "http://example.com", "https://127.0.0.1", "null"])
def test_an_event_of_another_origin_is_refused(
    hosts: list[ServedHost], origin: str, client: WebClient
) -> None:
    headers = {"Origin": origin}
    answer = client.post(EVENTS, json=STOP, headers=headers)
    assert answer.status == 403
    assert not hosts[0].run(5).emergency_stop


@pytest.mark.parametrize("name", ["example.com", "example.com:80", "127.0.0.1.example.com"])
def test_a_foreign_name_that_leads_here_is_refused(
    hosts: list[ServedHost], name: str, client: WebClient
) -> None:
    headers = {"Host": name, "Origin": f"http://{name}"}
    assert client.get("/token/api/robots", headers=headers).status == 403
    answer = client.post(EVENTS, json=STOP, headers=headers)
    assert answer.status == 403
    assert not hosts[0].run(5).emergency_stop


_NO_TOKEN = "the address lacks its token: open the one that rcx serve printed at its start"


@pytest.mark.parametrize("path", ["/", "/api/robots", "/page.js", "/wrong/", "/tokens/"])
def test_without_the_token_nothing_is_shown(path: str, client: WebClient) -> None:
    answer = client.get(path)
    assert (answer.status, answer.json) == (403, {"error": _NO_TOKEN})


def test_without_the_token_nothing_happens(hosts: list[ServedHost], client: WebClient) -> None:
    for path in ("/api/robots/0/events", "/wrong/api/robots/0/events"):
        answer = client.post(path, json=STOP, headers=client.own)
        assert (answer.status, answer.json) == (403, {"error": _NO_TOKEN})
    assert not hosts[0].run(5).emergency_stop


def test_a_script_that_has_the_token_needs_no_origin(
    hosts: list[ServedHost], client: WebClient
) -> None:
    answer = client.post(EVENTS, json={"event": "warning"})
    assert answer.status == 200
    assert hosts[0].status.warning


def test_the_slash_at_the_end_of_the_address_may_be_forgotten(client: WebClient) -> None:
    assert client.get("/token").path == "/token/"


def test_each_server_has_another_token(hosts: list[ServedHost]) -> None:
    assert web.WebServer(hosts, 0).address != web.WebServer(hosts, 0).address


def test_outputs_are_held_forced_and_released(hosts: list[ServedHost], client: WebClient) -> None:
    """The page can hold, force and release outputs of the controller.

    SO(20) is bit 0 of byte m+34 (manual chapter 1, 4.1).
    """

    def ask(**message: object) -> int:
        path = "/token/api/robots/0/outputs"
        return client.post(path, json=message).status

    assert ask(output="SO(20)", do="force", value=1) == 200
    assert bytes.fromhex(hosts[0].run(10).so)[34] == 1
    shown = client.get("/token/api/robots/0").json
    assert shown["held"] == ["SO(20)"]
    assert ask(output="SO(20)", do="hold") == 200
    assert ask(output="SO(20)", do="release") == 200
    assert bytes.fromhex(hosts[0].run(10).so)[34] == 0
    assert hosts[0].status.held == ()


def test_a_workpiece_is_placed_and_taken_away(hosts: list[ServedHost], client: WebClient) -> None:
    path = "/token/api/robots/0/workpieces"
    assert client.post(path, json={"axis": 3, "pulses": 90000}).status == 200
    assert hosts[0].station.controller.workpieces == {2: 90000}
    shown = client.get("/token/api/robots/0").json
    assert shown["workpieces"] == [{"axis": 3, "pulses": 90000}]
    assert client.post(path, json={"axis": 3, "pulses": None}).status == 200
    assert hosts[0].station.controller.workpieces == {}


@pytest.mark.parametrize(
    ("path", "body", "message"),
    [
        ("outputs", "[]", "an output is expected: {"),
        ("outputs", '{"output": "SO(20)", "do": "break"}', "an output cannot 'break'; hold, rel"),
        ("outputs", '{"output": "SO(20)", "do": "force"}', "the value of an output is a whole"),
        ("outputs", '{"output": "SO(20)", "do": "force", "value": true}', "the value of an output"),
        ("outputs", '{"output": "SO(20)", "do": "force", "value": 2}', "SO(20) is a bit and can"),
        ("outputs", '{"output": "SI(01)", "do": "hold"}', "SI(01) is an input of the controller"),
        ("outputs", '{"output": "X", "do": "hold"}', ""),
        ("outputs", '{"output": "SOW(99)", "do": "hold"}', ""),
        ("outputs", '{"output": "", "do": "release"}', ""),
        ("workpieces", '{"axis": 0, "pulses": 1}', "there is no axis 0; use 1 to 4"),
        ("workpieces", '{"axis": 9, "pulses": null}', "there is no axis 9"),
        ("workpieces", '{"axis": 1, "pulses": 3000000000}', "a workpiece stands at -2147483648"),
        ("workpieces", '{"axis": 1, "pulses": 1.5}', "a workpiece stands at a whole number of"),
        ("workpieces", '{"axis": NaN}', "a workpiece is expected"),
        ("recording", '{"do": "pause"}', "a recording can only start or stop"),
        ("recording", "{}", 'a recording is expected: {"do": "start"}'),
        ("events", "", 'an event is expected: {"event": "emergency_stop"}'),
        ("events", "[]", 'an event is expected: {"event": "emergency_stop"}'),
        ("events", '{"event": 5}', 'an event is expected: {"event": "emergency_stop"}'),
        ("events", '{"event": "alarm", "args": [1]}', "the arguments of an event are whole numb"),
        (
            *("events", '{"event": "alarm", "args": {"group": true, "category": 1}}'),
            "the arguments of an event are whole numbers by name",
        ),
        ("events", '{"event": "alarm", "args": {"group": 1}}', "event 'alarm' needs category"),
        ("events", '{"event": "alarm", "args": {"event": 1}}', "event 'alarm' does not take event"),
        ("events", '{"event": "alarm", "args": {"self": 1}}', "event 'alarm' does not take self"),
        ("events", '{"event": "explode"}', "unknown event 'explode'"),
        ("events", " " * 5000, "the request is longer than 4096 bytes"),
    ],
)
def test_an_impossible_request_is_refused_in_one_message(
    path: str, body: str, message: str, client: WebClient
) -> None:
    answer = client.post(f"/token/api/robots/0/{path}", data=body.encode())
    said = answer.json["error"]
    assert (answer.status, said.startswith(message), "\n" in said) == (400, True, False), said
    assert said


def test_the_actions_since_the_start_are_offered_as_a_stimulus(
    hosts: list[ServedHost], tmp_path: Path, client: WebClient
) -> None:
    """The actions since the start are offered as a stimulus, for both controllers.

    A run with this stimulus repeats the actions.
    """

    def ask(path: str, **message: object) -> None:
        assert client.post(f"/token/api/{path}", json=message).status == 200

    ask("robots/0/events", event="warning")
    ask("stimulus", do="begin")
    for host in hosts:
        host.run(300)
    ask("robots/0/events", event="alarm", args={"group": 12, "category": 600})
    ask("robots/1/outputs", output="SO(20)", do="force", value=1)
    for host in hosts:
        host.run(100)
    ask("robots/0/workpieces", axis=3, pulses=-5)
    ask("robots/0/workpieces", axis=3, pulses=None)
    ask("robots/0/outputs", output="SO03", do="hold")
    ask("robots/0/outputs", output="SO03", do="release")
    answer = client.get("/token/api/stimulus.toml")
    (tmp_path / "s.toml").write_text(answer.text, encoding="utf-8")
    entries = Stimulus.load(tmp_path / "s.toml").entries
    alarm, force, place, take, hold, release = entries
    assert (alarm.t_us, alarm.events) == (300_000, (("alarm", {"group": 12, "category": 600}),))
    assert (force.t_us, force.controller, force.force) == (300_000, 2, {"SO(20)": 1})
    assert (place.t_us, place.workpieces, take.workpieces) == (405_000, {3: -5}, {3: None})
    assert (hold.hold, release.release) == (("SO03",), ("SO03",))


def test_state_is_never_changed_by_get(client: WebClient) -> None:
    answer = client.get(EVENTS, headers=client.own)
    assert answer.status == 405


@pytest.mark.parametrize("path", ["/api/robots/2", "/api/robots/x", "/api/robots/-1", "/x"])
def test_an_unknown_path_is_not_found(path: str, client: WebClient) -> None:
    answer = client.get(f"/token{path}")
    assert answer.status == 404
    assert "error" in answer.json


def test_a_port_that_is_taken_is_one_clear_message(hosts: list[ServedHost]) -> None:
    async def use() -> None:
        first = web.WebServer(hosts, 0)
        await first.start()
        assert re.fullmatch(rf"http://127.0.0.1:{first.port}/[\w-]{{22}}/", first.address)
        with pytest.raises(InputError, match=f"cannot be served on 127.0.0.1:{first.port}: "):
            await web.WebServer(hosts, first.port).start()
        await first.close()

    asyncio.run(use())


def test_without_aiohttp_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without aiohttp, the message says that it must be installed.

    It names no extra of this package, because the package is not on an index.
    """
    monkeypatch.delitem(sys.modules, "rcx_harness.serve.web", raising=False)
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    with pytest.raises(InputError) as caught:
        asyncio.run(serve([], 0, quiet=True))
    assert str(caught.value) == "the web page needs the library aiohttp; pip install aiohttp"
