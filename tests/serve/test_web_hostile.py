"""The server of the web page answers malformed requests, and writes no log line about them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Sequence

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from log_records import log_messages
from rcx_harness.robot import EVENTS
from rcx_harness.serve.web import WebServer
from served import ServedHost

_LONG_S = 30.0
Request = tuple[bytes, bytes, Sequence[bytes], bytes]
_TOP = b"/token"
_EVENTS = _TOP + b"/api/robots/0/events"
_STOP = b'{"event": "emergency_stop"}'
_EXPECTED = 'an event is expected: {"event": "emergency_stop"}'
_DIGITS = b"9" * 5000


def ask(*requests: Request) -> list[tuple[int, str]]:
    """Send requests (method, path, header lines, body); return status and text of each answer."""

    async def main() -> list[tuple[int, str]]:
        server = WebServer([ServedHost(), ServedHost(address="127.0.0.2")], 0, "token")
        await server.start()
        try:
            return [await one(server.port, *request) for request in requests]
        finally:
            await server.close()

    async def one(
        port: int, method: bytes, path: bytes, headers: Sequence[bytes], body: bytes
    ) -> tuple[int, str]:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        own = b"127.0.0.1:%d" % port
        lines = [b"Connection: close", *headers]
        if not any(line.startswith(b"Host") for line in headers):
            lines += [b"Host: " + own, b"Origin: http://" + own]
        if not any(line.startswith((b"Content-Length", b"Transfer")) for line in headers):
            lines.append(b"Content-Length: %d" % len(body))
        head = b"\r\n".join([method + b" " + path + b" HTTP/1.1", *lines])
        writer.write(head + b"\r\n\r\n" + body)
        answer = await asyncio.wait_for(reader.read(), _LONG_S)
        writer.close()
        head, _, text = answer.partition(b"\r\n\r\n")
        return int(head.split(b" ")[1]), text.decode()

    return asyncio.run(main())


def said(text: str) -> str:
    """Return the message of a refusal."""
    message: str = json.loads(text)["error"]
    return message


@pytest.mark.parametrize(
    ("body", "message"),
    [
        *((b"[" * 4000, _EXPECTED), (b'{"a":' * 800, _EXPECTED), (_DIGITS[:4096], _EXPECTED)),
        (b'{"event": "alarm", "args": {"group": ' + _DIGITS[:4000] + b"}}", ""),
        *((b"\xff\xfe", _EXPECTED), (b'"\\ud800"', _EXPECTED), (b"NaN", _EXPECTED)),
        (_DIGITS, "the request is longer than 4096 bytes"),
    ],
)
def test_a_body_that_is_no_event_is_refused_in_one_message(body: bytes, message: str) -> None:
    ((answered, text),) = ask((b"POST", _EVENTS, (), body))
    assert answered == 400
    assert said(text).startswith(message)
    assert said(text)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (
            "Content-Type: application/json; charset=nonsense",
            "the charset 'nonsense' is not accepted",
        ),
        ("Content-Type: text/plain; charset=rot13", "the charset 'rot13' is not accepted"),
        ("Content-Type: text/plain; charset=hex", "the charset 'hex' is not accepted"),
        ("Content-Type: text/plain; charset=utf-16", "the charset 'utf-16' is not accepted"),
        ("Content-Type: text/plain; charset=" + "x" * 3000, "the charset 'xxxxxxxxxxxxxxxxxxxx'"),
        ("Content-Encoding: gzip", "a compressed request is not accepted"),
        ("Content-Encoding: deflate", "a compressed request is not accepted"),
        ("Content-Encoding: foo", "a compressed request is not accepted"),
    ],
)
def test_another_encoding_is_refused(header: str, message: str) -> None:
    ((status, text),) = ask((b"POST", _EVENTS, (header.encode(),), _STOP))
    assert status == 400
    assert said(text).startswith(message)


@pytest.mark.parametrize("kind", ["", "Content-Type: application/json; charset=UTF-8"])
def test_an_event_in_utf_8_is_taken(kind: str) -> None:
    assert ask((b"POST", _EVENTS, (kind.encode(),) if kind else (), _STOP))[0][0] == 200


@pytest.mark.parametrize("name", ["9" * 5000, "0" * 5000, "00", "%D9%A0", "%C2%B2", "%00", "%0a"])
def test_a_controller_that_does_not_exist_is_not_found(name: str) -> None:
    """A controller that does not exist is "not found".

    Its number may have 5,000 digits, or digits of another script.
    """
    for path in (f"/token/api/robots/{name}", f"/token/api/robots/{name}/chart.svg"):
        ((status, text),) = ask((b"GET", path.encode(), (), b""))
        assert status == 404
        assert said(text).startswith("there is no controller ")


@pytest.mark.parametrize("seconds", ["9" * 5000, "%ff", "inf", "-1", "1e400"])
def test_a_chart_of_another_length_is_refused(seconds: str) -> None:
    ((status, text),) = ask(
        (b"GET", f"/token/api/robots/0/chart.svg?seconds={seconds}".encode(), (), b"")
    )
    assert status == 400
    assert said(text).endswith(" is not 1 to 60")
    assert len(said(text)) < 60


_METHODS = [b"HEAD", b"PUT", b"OPTIONS", b"TRACE", b"CONNECT", b"FOO", b"get", b"\xff", b"A" * 9000]
_PATHS = [
    *(_TOP + b"//", _TOP + b"//page.css", _TOP + b"/page%2Ecss", _TOP + b"/a/../page.css"),
    *(_TOP + b"/" + b"a" * 9000, _TOP + b"/api/robots/\xff", _TOP + b"/api/robots/{id}", b"/\xff"),
    *(b"//", b"//page.css", b"/page%2Ecss", b"/a/../page.css", b"*", b"", b"page.css", b"/ /"),
    *(b"http://127.0.0.1/page.css", b"http://[/", b"http://127.0.0.1:x/", b"/api/robots/\xff"),
    *(b"/" + b"a" * 9000, b"/?" + b"a" * 9000, b"/api/robots/{id}", b"//evil/page.css"),
]
_HEADERS = [
    *(b"Content-Length: -1", b"Content-Length: x", b"Content-Length: " + _DIGITS),
    *(b"Transfer-Encoding: foo", b"Transfer-Encoding: chunked", b"Expect: foo", b"Range: x"),
    *(b'Cookie: \xff="\\', b"X" * 9000 + b": 1", b"Origin: \xff", b"Content-Type: \xff"),
    *(b"Host: ", b"Host: [", b"Host: [::1", b"Host: 127.0.0.1:x", b"Host: a b", b"Host: \xff"),
    *(b"Host: 127.0.0.1:" + _DIGITS, b"Content-Type: ;;;", b"If-Modified-Since: x"),
]


def test_a_malformed_request_is_answered_without_a_line_in_the_log() -> None:
    """Any request gets a status 2xx or 4xx and leaves no line in the log.

    A log line for each request could fill the disk.
    """
    asked: list[Request] = [
        (method, path, (), b"")
        for method in _METHODS
        for path in (_EVENTS, _TOP + b"/", _TOP + b"/x", b"/")
    ]
    asked += [(method, path, (), b"") for method in (b"GET", b"POST") for path in _PATHS]
    asked += [(b"POST", _EVENTS, (header,), b"5\r\nhello\r\nx" + _STOP) for header in _HEADERS]
    with log_messages() as logged:
        answers = ask(*asked)
    wrong = [
        (request, status)
        for request, (status, _) in zip(asked, answers, strict=True)
        if status // 100 not in (2, 4)
    ]
    assert wrong == []
    assert logged == []


def test_every_event_with_arguments_that_it_may_not_take_is_answered() -> None:
    odd: list[dict[str, int]] = [
        *({}, {"group": -1, "category": -1}, {"group": 10**50, "category": 10**50}),
        *({"port": 10**30, "on": 1}, {"port": -1, "on": 2}, {"machine": 1}, {"args": 1}, {"": 1}),
    ]
    asked = [
        (b"POST", _EVENTS, (), json.dumps({"event": name, "args": args}).encode())
        for name in (*EVENTS, "link_down", "x" * 3000)
        for args in odd
    ]
    assert {status for status, _ in ask(*asked)} == {200, 400}


_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    method=st.sampled_from([b"POST", b"GET"]),
    path=st.binary(max_size=60).map(lambda tail: _EVENTS + tail.replace(b"\n", b""))
    | st.just(_EVENTS),
    body=st.binary() | _JSON.map(lambda value: json.dumps(value).encode()),
)
@example(method=b"POST", path=_EVENTS, body=b"[" * 4000)
def test_no_request_is_a_mistake_of_the_server(method: bytes, path: bytes, body: bytes) -> None:
    ((status, _),) = ask((method, path, (), body))
    assert status // 100 in (2, 4)
