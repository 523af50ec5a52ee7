"""The adapter as an editor starts it: framing, standard input and output, a port, bad input."""

from __future__ import annotations

import io
import json
import re
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from editor import Editor, RefusedError
from rcx_harness.errors import InputError
from rcx_harness.verify.debug.protocol import encoded, read_message

_RCX = [sys.executable, "-m", "rcx_harness", "debug"]
_LONGEST = 60


def test_a_message_is_json_behind_its_length() -> None:
    """Source: the protocol's overview, Base Protocol: the length counts bytes, not letters."""
    assert encoded({"a": "ä"}) == b'Content-Length: 10\r\n\r\n{"a":"\xc3\xa4"}'


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b'Content-Length: 10\r\n\r\n{"a":"\xc3\xa4"}', {"a": "ä"}),
        (b'content-length:8\r\nX: y\r\n\r\n{"b": 1}rest', {"b": 1}),
        (b"", None),
        (b"Content-Length: 20\r\n\r\n{}", None),
        (b"hello\r\n\r\n", None),
    ],
)
def test_messages_are_read(data: bytes, message: dict[str, Any] | None) -> None:
    assert read_message(io.BytesIO(data)) == message


@pytest.mark.parametrize(
    "data", [b"Content-Length: 4\r\n\r\nhaha", b"Content-Length: 99999999999\r\n\r\n"]
)
def test_what_is_no_message_ends_it_with_one_line(data: bytes) -> None:
    with pytest.raises(InputError, match="debug adapter protocol"):
        read_message(io.BytesIO(data))
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


def test_on_standard_output_there_is_nothing_but_messages(lamps: Path) -> None:
    given = _requests(lamps, stopOnEntry=True)
    ended = subprocess.run(_RCX, input=given, capture_output=True, timeout=_LONGEST)
    assert (ended.returncode, ended.stderr) == (0, b"")
    messages = _messages(ended.stdout)
    assert b"".join(map(encoded, messages)) == ended.stdout
    assert [one["seq"] for one in messages] == list(range(1, len(messages) + 1))
    answered = [one for one in messages if one.get("command") == "disconnect"]
    assert [one["success"] for one in answered] == [True]


def test_it_ends_with_its_client_also_where_that_leaves_the_line_open(lamps: Path) -> None:
    """As VS Code does: it asks to disconnect, and closes nothing."""
    pipe = subprocess.PIPE
    with subprocess.Popen(_RCX, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        process.stdin.write(_requests(lamps))
        process.stdin.flush()
        assert process.wait(_LONGEST) == 0
        assert process.stderr.read() == b""


def test_on_a_port_of_this_computer_one_client_comes_after_the_other(lamps: Path) -> None:
    process = subprocess.Popen(
        [*_RCX, "--port", "0", str(lamps)], stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stderr is not None
        said = process.stderr.readline()
        found = re.search(r"waiting for a debug client on 127\.0\.0\.1:(\d+)", said)
        assert found is not None, said
        for _ in range(2):
            with socket.create_connection(("127.0.0.1", int(found[1])), _LONGEST) as client:
                stream = client.makefile("rwb")
                for k, command in enumerate(("initialize", "attach", "disconnect"), 1):
                    stream.write(encoded({"seq": k, "type": "request", "command": command}))
                stream.flush()
                answers = []
                while (message := read_message(stream)) is not None:  # type: ignore[arg-type]
                    answers += [message["success"]] if message["type"] == "response" else []
                assert answers == [True, True, True], "the program is that of the command line"
    finally:
        process.terminate()
        process.wait(_LONGEST)


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
        ({"sources": ["LAMPS"], "trace": "t.jsonl"}, "trace goes with rcx run, not with rcx debug"),
        ({"sources": ["LAMPS"], "connect": "1.2.3.4"}, "connect goes with rcx run"),
        ({"sources": ["LAMPS"], "link": "enip"}, "link goes with rcx run"),
        ({"sources": ["LAMPS"], "engine": "matiec"}, "the matiec engine cannot be debugged"),
        ({"sources": ["LAMPS"], "cwd": "/no/such"}, "cwd '/no/such' is no folder"),
        ({"recording": "gone.jsonl"}, "gone.jsonl: the recording cannot be read"),
    ],
)
def test_a_wrong_launch_is_one_message(
    editor: Editor, lamps: Path, launch: dict[str, Any], message: str
) -> None:
    """Exit code 2, as every bad input."""
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
    """`onLoss`, `on-loss` and `on_loss` are one; lists are options that are repeated."""
    launch: dict[str, Any] = {"scan": "20ms", "on-loss": "clear", "seed": 3, "m": [0]}
    launch["onLoss"] = "clear"
    editor.start(sources=[str(lamps)], for_="100ms", __sessionId="x", **launch)
    assert editor.value("C.Value") == "5", "of 100 ms with a scan of 20 ms"


def test_a_source_with_a_mistake_is_named_with_its_line(editor: Editor, tmp_path: Path) -> None:
    (tmp_path / "Bad.st").write_text(
        "PROGRAM Bad\n  VAR\n    X : INT;\n  END_VAR\n  X := ;\nEND_PROGRAM\n"
    )
    with pytest.raises(RefusedError, match=r"Bad\.st:5"):
        editor.request("launch", sources=[str(tmp_path / "Bad.st")])


def test_requests_out_of_order_or_unknown_are_refused(editor: Editor, lamps: Path) -> None:
    with pytest.raises(RefusedError, match="nothing is debugged yet: launch comes first"):
        editor.request("stackTrace", threadId=1)
    with pytest.raises(RefusedError, match="does not know the request 'fly'"):
        editor.request("fly")
    editor.start(sources=[str(lamps)], stopOnEntry=True)
    with pytest.raises(RefusedError, match="there is a run already"):
        editor.request("launch", sources=[str(lamps)])
    with pytest.raises(RefusedError, match="arguments of 'variables' are not as the protocol says"):
        editor.request("variables")
    with pytest.raises(RefusedError, match="arguments of 'scopes' are not as the protocol says"):
        editor.request("scopes", frameId=99)


def test_the_extension_for_vs_code_is_written(tmp_path: Path) -> None:
    """Again over itself; a file that is another stays."""
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
