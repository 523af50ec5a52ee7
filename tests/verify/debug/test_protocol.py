"""The debug adapter handles its protocol on standard input and on a port, and bad input."""

from __future__ import annotations

import io
import json
import re
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from editor import Editor, RefusedError
from rcx_harness.cli.app import main as rcx
from structured_text.debug.protocol import encoded, read_message
from structured_text.errors import InputError

_RCX = [sys.executable, "-m", "rcx_harness", "debug"]
_LONGEST = 60
LAMPS = Path(__file__).parent / "programs" / "Lamps.st"


def test_a_message_is_json_after_its_length() -> None:
    """Source: the protocol's overview, Base Protocol: the length counts bytes, not letters."""
    assert encoded({"a": "ä"}) == b'Content-Length: 10\r\n\r\n{"a":"\xc3\xa4"}'


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b'Content-Length: 10\r\n\r\n{"a":"\xc3\xa4"}', {"a": "ä"}),
        (b'content-length:8\r\nX: y\r\n\r\n{"b": 1}rest', {"b": 1}),
        (b"", None),
        (b"Content-Length: 20\r\n\r\n{}", None),
    ],
)
def test_messages_are_read(data: bytes, message: dict[str, Any] | None) -> None:
    assert read_message(io.BytesIO(data)) == message


_DEEP = b"[" * 100_000


@pytest.mark.parametrize(
    "data",
    [
        b"Content-Length: 4\r\n\r\nhaha",
        b"Content-Length: 99999999999\r\n\r\n",
        b"Content-Length: 1048577\r\n\r\n",
        b"Content-Length: -4\r\n\r\n",
        b"Content-Length: 100000\r\n\r\n" + _DEEP,
        b"Content-Length: 2\r\n\r\n[]",
        b"hello\r\n\r\n",
        b'POST / HTTP/1.1\r\nContent-Length: 8\r\n\r\n{"b": 1}',
        b'POST http://127.0.0.1:4711/ HTTP/1.1\r\nContent-Length: 8\r\n\r\n{"b": 1}',
        b"Content-Length: 8\r\nX: " + b"y" * 5000,
        b"X: y\r\n" * 1000 + b'Content-Length: 8\r\n\r\n{"b": 1}',
        b"y" * 5000,
    ],
)
def test_a_wrong_message_is_refused(data: bytes) -> None:
    """A malformed message is refused, such as HTTP that a web page sends to the port.

    A header of the protocol has only fields.

    Source: a defect report: the protocol's overview, Base Protocol.
    """
    with pytest.raises(InputError):
        read_message(io.BytesIO(data))


def test_a_header_without_an_end_is_read_only_up_to_a_limit() -> None:
    """Source: a defect report: the port limits header and body."""
    stream = io.BytesIO(b"x" * 100_000)
    with pytest.raises(InputError, match="debug adapter protocol"):
        read_message(stream)
    assert stream.tell() < 10_000


@pytest.mark.exhaustive
def test_a_wrong_message_ends_the_adapter_with_one_line() -> None:
    data = b"Content-Length: 4\r\n\r\nhaha"
    ended = subprocess.run(_RCX, input=data, capture_output=True, timeout=_LONGEST)
    assert ended.returncode == 2
    assert ended.stderr.decode().startswith("rcx: ")
    assert len(ended.stderr.splitlines()) == 1


def _requests(lamps: Path, **launch: Any) -> bytes:
    every = [
        ("initialize", {"adapterID": "rcx"}),
        ("launch", {"sources": [str(lamps)], "for": "1s", **launch}),
        ("configurationDone", {}),
        ("continue", {"threadId": 1}),
        ("disconnect", {}),
    ]
    return b"".join(
        encoded({"seq": k, "type": "request", "command": command, "arguments": arguments})
        for k, (command, arguments) in enumerate(every, 1)
    )


def _messages(data: bytes) -> list[dict[str, Any]]:
    stream, found = io.BytesIO(data), []
    while (message := read_message(stream)) is not None:
        found.append(message)
    return found


@pytest.mark.exhaustive
def test_on_standard_output_there_is_nothing_but_messages(lamps: Path) -> None:
    given = _requests(lamps, stopOnEntry=True)
    ended = subprocess.run(_RCX, input=given, capture_output=True, timeout=_LONGEST)
    assert (ended.returncode, ended.stderr) == (0, b"")
    messages = _messages(ended.stdout)
    assert b"".join(map(encoded, messages)) == ended.stdout
    assert [one["seq"] for one in messages] == list(range(1, len(messages) + 1))
    answered = [one for one in messages if one.get("command") == "disconnect"]
    assert [one["success"] for one in answered] == [True]


def test_the_adapter_ends_with_its_client(lamps: Path) -> None:
    """The adapter ends after a disconnect request. VS Code does not close the streams."""
    pipe = subprocess.PIPE
    with subprocess.Popen(_RCX, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        process.stdin.write(_requests(lamps))
        process.stdin.flush()
        assert process.wait(_LONGEST) == 0
        assert process.stderr.read() == b""


@pytest.fixture(scope="module")
def port() -> Iterator[tuple[int, str]]:
    """Return a port that waits for clients, and its token."""
    process = subprocess.Popen(
        [*_RCX, "--port", "0", str(LAMPS)], stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stderr is not None
        said = process.stderr.readline() + process.stderr.readline()
        found = re.search(r"waiting for a debug client on 127\.0\.0\.1:(\d+)", said)
        token = re.search(r'"token": "([^"]+)"', said)
        assert found is not None, said
        assert token is not None, said
        yield int(found[1]), token[1]
    finally:
        process.kill()
        process.wait(_LONGEST)


def _answers(port: int, data: bytes) -> list[dict[str, Any]]:
    """Send messages to the port, and return the answers until the adapter ends the connection."""
    with socket.create_connection(("127.0.0.1", port), _LONGEST) as client:
        client.sendall(data)
        received = b""
        with suppress(ConnectionError):  # the adapter has ended while data were unread
            while some := client.recv(65536):
                received += some
    return _messages(received)


def _launches(**arguments: Any) -> bytes:
    every = [("initialize", {}), ("attach", arguments), ("disconnect", {})]
    return b"".join(
        encoded({"seq": k, "type": "request", "command": command, "arguments": given})
        for k, (command, given) in enumerate(every, 1)
    )


@pytest.mark.exhaustive
def test_on_a_port_of_this_computer_one_client_comes_after_the_other(port: tuple[int, str]) -> None:
    number, token = port
    for _ in range(2):
        told = _answers(number, _launches(token=token))
        answers = [one["success"] for one in told if one["type"] == "response"]
        assert answers == [True, True, True], "the program comes from the command line"


@pytest.mark.parametrize("given", [{}, {"token": "guessed"}, {"token": None}, {"token": ["x"]}])
def test_a_wrong_token_launches_nothing(port: tuple[int, str], given: dict[str, Any]) -> None:
    """Source: a defect report: the port asks for a token."""
    told = _answers(port[0], _launches(**given))
    (answer,) = [one for one in told if one.get("command") == "attach"]
    assert not answer["success"]
    assert "token" in answer["message"]


def test_a_web_page_gets_no_answer(port: tuple[int, str]) -> None:
    """Source: a defect report: it refuses what is not the debug adapter protocol."""
    body = _launches(token=port[1])
    head = f"POST / HTTP/1.1\r\nOrigin: http://evil.example\r\nContent-Length: {len(body)}\r\n\r\n"
    assert _answers(port[0], head.encode() + body) == []


def test_a_refused_client_cannot_send_more_messages(port: tuple[int, str]) -> None:
    """A refused client cannot send more messages, because its connection is closed at once.

    Source: docs/how-to/debug.md, the port
    """
    with (
        socket.create_connection(("127.0.0.1", port[0]), timeout=20) as sock,
        pytest.raises(ConnectionError),
    ):
        sock.sendall(b"x" * 64_000_000)


def test_a_short_token_in_the_environment_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/how-to/debug.md, any other client."""
    monkeypatch.setenv("RCX_DEBUG_TOKEN", "short")
    assert rcx(["debug", "--port", "0"]) == 2
    assert "RCX_DEBUG_TOKEN is too short" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_a_port_that_is_taken_is_named() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        command = [*_RCX, "--port", str(port)]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST)
    assert ended.returncode == 2
    assert ended.stderr.startswith(f"rcx: --port {port}: ")


@pytest.mark.parametrize(
    ("launch", "message"),
    [
        ({}, 'no program is named; write "sources": ["plc/Main.st"]'),
        ({"sources": ["gone.st"]}, "gone.st: no such file"),
        ({"sources": ["LAMPS"], "scam": "5ms"}, "launch has no option 'scam'; did you mean scan"),
        ({"sources": ["LAMPS"], "scan": "5"}, "the scan"),
        ({"sources": ["LAMPS"], "seed": "many"}, "seed"),
        ({"sources": ["LAMPS"], "for": "long"}, "for"),
        (
            {"sources": ["LAMPS"], "trace": "t.jsonl"},
            "trace is an option of rcx run, not of rcx debug",
        ),
        ({"sources": ["LAMPS"], "connect": "1.2.3.4"}, "connect is an option of rcx run"),
        ({"sources": ["LAMPS"], "link": "enip"}, "link is an option of rcx run"),
        ({"sources": ["LAMPS"], "engine": "matiec"}, "the matiec engine cannot be debugged"),
        ({"sources": ["LAMPS"], "cwd": "/no/such"}, "cwd '/no/such' is not a folder"),
        ({"sources": ["LAMPS"], "properties": "p.py"}, "properties is an option of rcx run"),
        ({"sources": ["LAMPS"], "panel": 0}, "panel is an option of rcx run"),
        ({"sources": ["LAMPS"], "view": "v.html"}, "view is an option of rcx run"),
        ({"sources": ["--trace=t.jsonl", "x.st"]}, "sources: --trace=t.jsonl is an option"),
        ({"sources": "-v"}, "sources: -v is an option"),
        ({"program": ["--connect=1.2.3.4", "--yes"]}, "--connect=1.2.3.4 is an option"),
        ({"sources": [["--trace=t.jsonl"]]}, "sources is not a text"),
        ({"sources": {"a": 1}}, "sources is not a text"),
        ({"sources": ["LAMPS"], "scan": True}, "scan is not a text or a number"),
        ({"sources": ["LAMPS"], "for": {"a": 1}}, "for is not a text or a number"),
        ({"sources": ["LAMPS"], "cwd": 1}, "cwd is not a text"),
        ({"recording": 1}, "recording is not a text"),
        ({"recording": "gone.jsonl"}, "gone.jsonl: cannot be read: No such file or directory"),
    ],
)
def test_a_launch_with_wrong_arguments_gives_one_message(
    editor: Editor, lamps: Path, launch: dict[str, Any], message: str
) -> None:
    """A launch with wrong arguments gives one message and exit code 2."""
    given = {key: [str(lamps)] if one == ["LAMPS"] else one for key, one in launch.items()}
    with pytest.raises(RefusedError) as refused:
        editor.request("launch", **given)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)
    editor.event("terminated")
    editor.request("disconnect")
    editor.close()
    assert editor.exit_code == 2


def test_options_have_the_names_that_they_have_in_rcx_run(editor: Editor, lamps: Path) -> None:
    """Launch arguments have the names of the options of `rcx run`.

    `onLoss`, `on-loss` and `on_loss` are the same. Lists are repeated options.
    """
    launch: dict[str, Any] = {"scan": "20ms", "on-loss": "clear", "seed": 3, "m": [0]}
    launch["onLoss"] = "clear"
    editor.start(sources=[str(lamps)], for_="100ms", __sessionId="x", **launch)
    assert editor.value("C.Value") == "5", "five scans in 100 ms"


def test_a_source_with_a_mistake_is_named_with_its_line(editor: Editor, tmp_path: Path) -> None:
    (tmp_path / "Bad.st").write_text(
        "PROGRAM Bad\n  VAR\n    X : INT;\n  END_VAR\n  X := ;\nEND_PROGRAM\n"
    )
    with pytest.raises(RefusedError, match=r"Bad\.st:5"):
        editor.request("launch", sources=[str(tmp_path / "Bad.st")])


def test_requests_out_of_order_or_unknown_are_refused(editor: Editor, lamps: Path) -> None:
    with pytest.raises(RefusedError, match="no program is being debugged yet: send launch first"):
        editor.request("stackTrace", threadId=1)
    with pytest.raises(RefusedError, match="does not know the request 'fly'"):
        editor.request("fly")
    editor.start(sources=[str(lamps)], stopOnEntry=True)
    with pytest.raises(RefusedError, match="a program has been launched already"):
        editor.request("launch", sources=[str(lamps)])
    with pytest.raises(RefusedError, match="arguments of 'variables' are not as the protocol says"):
        editor.request("variables")
    with pytest.raises(RefusedError, match="arguments of 'scopes' are not as the protocol says"):
        editor.request("scopes", frameId=99)


_WRONG: list[Any] = [[], 0, -1, "x", {}, None, True, 1e308, [1], [[]], {"a": 1}, [None], "\0"]


@pytest.mark.parametrize(
    ("command", "keys"),
    [
        ("initialize", ["linesStartAt1"]),
        ("setBreakpoints", ["source", "breakpoints", "lines"]),
        ("setFunctionBreakpoints", ["breakpoints"]),
        ("setDataBreakpoints", ["breakpoints"]),
        ("setExceptionBreakpoints", ["filters", "filterOptions"]),
        ("breakpointLocations", ["source", "line", "endLine"]),
        ("dataBreakpointInfo", ["variablesReference", "name"]),
        ("threads", []),
        ("stackTrace", ["threadId", "startFrame", "levels"]),
        ("scopes", ["frameId"]),
        ("variables", ["variablesReference", "start", "count"]),
        ("setVariable", ["variablesReference", "name", "value"]),
        ("setExpression", ["expression", "value", "frameId"]),
        ("evaluate", ["expression", "frameId", "context"]),
        ("completions", ["text", "column", "frameId"]),
        ("rcx/backToChange", ["variable", "frameId"]),
    ],
)
def test_arguments_of_wrong_types_are_answered(
    at_entry: Callable[..., Editor], command: str, keys: list[str]
) -> None:
    """A request with arguments of wrong types gets an error, and the next request is answered.

    Source: a defect report: the debug adapter with wrong types or deep JSON.
    """
    editor = at_entry()
    editor.scope("Variables")
    whole: dict[str, Any] = {"source": {"path": str(LAMPS)}, "line": 1, "variablesReference": 1}
    whole |= {"name": "Lamp", "value": "1", "expression": "Lamp", "text": "L", "column": 1}
    for key in keys:
        for wrong in _WRONG:
            with suppress(RefusedError):
                editor.request(command, **{**whole, key: wrong})
    for wrong in _WRONG:
        with suppress(RefusedError):
            editor.request(command, **dict.fromkeys(keys, wrong))
    assert editor.value("C.Value") == "0", (
        "the program has stopped before the first scan, and answers"
    )


def test_a_malformed_request_is_answered(editor: Editor) -> None:
    """Source: a defect report."""
    for message in (
        {"type": "request", "command": ["launch"]},
        {"type": "request", "command": "launch", "arguments": [1]},
        {"type": "request", "command": "launch", "arguments": "x", "seq": [[[]]]},
    ):
        answer = editor.answer_to(message)
        assert not answer["success"]
        assert isinstance(answer["request_seq"], int)


def test_an_unknown_reference_has_no_variables(at_entry: Callable[..., Editor]) -> None:
    """Source: debug adapter protocol: a reference of 0 means none; references begin at 1."""
    editor = at_entry()
    editor.scope("Variables")
    for number in (0, -1, 999):
        with pytest.raises(RefusedError, match="not as the protocol says"):
            editor.request("variables", variablesReference=number)
    with pytest.raises(RefusedError, match="not as the protocol says"):
        editor.request("scopes", frameId=-1)


@pytest.mark.exhaustive
def test_the_extension_for_vs_code_is_written(tmp_path: Path) -> None:
    """`rcx debug --vscode` writes its extension, and does not replace another extension."""
    folder = tmp_path / "extension"
    command = [*_RCX, "--vscode", str(folder)]
    for _ in range(2):
        subprocess.run(command, check=True, capture_output=True, timeout=_LONGEST)
    described = json.loads((folder / "package.json").read_text())
    (debugger,) = described["contributes"]["debuggers"]
    assert debugger["type"] == "rcx"
    assert (folder / described["main"]).is_file()
    (folder / "package.json").write_text("{}")
    ended = subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST)
    assert ended.returncode == 2
    assert (folder / "package.json").read_text() == "{}"
