"""The web server of the faceplates has pages and messages, and refuses requests of other sites."""

from __future__ import annotations

import re
import urllib.request
from collections.abc import Iterator
from importlib.resources import files

import pytest

from plc_bench import ROOT, compiled
from rcx_harness.serve.panel.plate import Plate, plates_of
from rcx_harness.serve.panel.server import FILES, PanelServer, application
from structured_text.errors import InputError
from web_client import WebClient

_BENCH = ROOT / "tests/data/library/Operator.st"


@pytest.fixture
def plate() -> Plate:
    """Return the panel of a program."""
    (one,) = plates_of(compiled(_BENCH, "builtin"))
    one.exchange()
    return one


@pytest.fixture
def client(plate: Plate) -> Iterator[WebClient]:
    """Return a client of the panel's page, with the token `token`."""
    client = WebClient(application([plate], "token"))
    yield client
    client.close()


def test_the_page_and_all_it_asks_for_come_from_this_server(client: WebClient) -> None:
    page = client.get("/token/").text
    wanted = re.findall(r'(?:src|href)="([^":]+)"', page)
    assert wanted == ["page.css", "panel.css", "panel.js"]
    for name in ["", *wanted]:
        answer = client.get(f"/token/{name}")
        assert answer.status == 200
        assert "default-src 'self'" in answer.headers["Content-Security-Policy"]


def test_no_file_of_the_page_names_another_server() -> None:
    for package, name, _ in FILES.values():
        text = files(package).joinpath("page").joinpath(name).read_text(encoding="utf-8")
        assert "://" not in text, name


def test_every_key_lamp_and_selection_of_the_structure_is_on_the_page(plate: Plate) -> None:
    """Source: RCX_PANEL."""
    folder = files("rcx_harness.serve.panel").joinpath("page")
    page = folder.joinpath("index.html").read_text(encoding="utf-8")
    script = folder.joinpath("panel.js").read_text(encoding="utf-8")
    shown = plate.shown()
    assert sorted(re.findall(r'data-key="(\w+)"', page)) == sorted(shown["Key"])
    assert {*shown["Lamp"]} - {"Fault"} == {
        *re.findall(r"^  (\w+): \[.*(?:green|red)", script, re.M)
    }
    chosen = {*re.findall(r'data-(?:choice|number)="(\w+)"', page), "Axis"}
    written = {"Can", "Following", "Lamp", "Mode", "MessageID", "AlarmGroup", "AlarmCategory"}
    written |= {"Message", "Position", "Version", "name", "Key"}
    assert chosen == shown.keys() - written


def test_keys_and_selections_reach_the_program_and_the_state_comes_back(
    plate: Plate, client: WebClient
) -> None:
    assert client.get("/token/api/panels").json == ["Main.Panel"]
    for path, message in (
        ("keys", {"page": "p", "beat": 1, "keys": ["Stop"]}),
        ("choices", {"name": "Axis", "value": 3}),
    ):
        answer = client.post(f"/token/api/panels/0/{path}", json=message, headers=client.own)
        assert answer.status == 200
    plate.exchange()
    state = client.get("/token/api/panels/0").json
    assert (state["Key"]["Stop"], state["Key"]["Start"], state["Axis"]) == (True, False, 3)


@pytest.mark.parametrize(
    ("path", "message", "status"),
    [
        ("0/keys", {"page": "p", "beat": 1, "keys": ["Begin"]}, 400),
        ("0/keys", {"page": "p", "beat": 1, "keys": [1]}, 400),
        ("0/keys", {"page": "p" * 50, "beat": 1, "keys": []}, 400),
        ("0/keys", {"page": "p", "keys": []}, 400),
        ("0/keys", {"page": "p", "beat": True, "keys": []}, 400),
        ("0/choices", {"name": "Lamp", "value": True}, 400),
        ("0/choices", {"value": 3}, 400),
        ("1/keys", {"page": "p", "beat": 1, "keys": []}, 404),
        ("x/choices", {"name": "Axis", "value": 3}, 404),
    ],
)
def test_an_invalid_message_is_refused_in_one_line(
    path: str, message: object, status: int, client: WebClient
) -> None:
    answer = client.post(f"/token/api/panels/{path}", json=message)
    assert answer.status == status
    assert "\n" not in answer.json["error"]


@pytest.mark.parametrize("page", ["/other/", "/token2/api/panels"])
def test_without_the_token_it_says_who_has_printed_it(page: str, client: WebClient) -> None:
    answer = client.get(page)
    assert answer.status == 403
    assert "the one that rcx run printed" in answer.json["error"]


def test_another_site_cannot_press_a_key(plate: Plate, client: WebClient) -> None:
    message = {"page": "p", "beat": 1, "keys": ["Start"]}
    for headers in ({"Origin": "http://example.org"}, {"Host": "example.org"}):
        answer = client.post("/token/api/panels/0/keys", json=message, headers=headers)
        assert answer.status == 403
    plate.exchange()
    assert not plate.shown()["Key"]["Start"]


def test_it_serves_from_a_thread_and_ends_with_the_run(plate: Plate) -> None:
    with PanelServer([plate], 0) as server:
        address = server.address
        assert re.fullmatch(r"http://127.0.0.1:\d+/[\w-]{22}/", address)
        with urllib.request.urlopen(f"{address}api/panels") as answer:
            assert answer.read() == b'["Main.Panel"]'
        taken = int(address.split(":")[2].split("/")[0])
        with (
            pytest.raises(InputError, match="choose a free port with --panel"),
            PanelServer([plate], taken),
        ):
            pass
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(address)
