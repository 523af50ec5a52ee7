"""A whole session of an assistant: the client of the package starts `rcx mcp` and calls its tools.

Each call runs in a process of its own, with its limits and its fence.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, TypeVar

import anyio
import pytest
from mcp.client.session import ClientSession
from mcp.client.stdio import StdioServerParameters, stdio_client

from rcx_harness.cli.app import main

pytestmark = pytest.mark.exhaustive

_T = TypeVar("_T")
#: A session that hangs fails after this time [s].
_LONGEST = 500
_EXAMPLE = ["PowerUp.st", "POWER_STAGE.st", "Config.st"]
_TEST = """from pathlib import Path

from structured_text.bench import Bench


def test_the_counter_counts():
    with Bench.build("Counter.st", engine="builtin") as bench:
        bench.run("20ms")
        assert bench["Counter.Sum"] >= 1
"""
_COUNTER = """PROGRAM Counter
  VAR
    Sum : INT;
  END_VAR
  Sum := Sum + 1;
END_PROGRAM
"""


@pytest.fixture
def project(tmp_path: Path, repository: Path) -> Path:
    """Return a copy of the first example, with a test of its own."""
    folder = tmp_path / "project"
    shutil.copytree(repository / "plc/examples/01_power_up", folder)
    (folder / "Counter.st").write_text(_COUNTER)
    (folder / "test_counter.py").write_text(_TEST)
    return folder


def _session(project: Path, use: Callable[[ClientSession], Awaitable[_T]], *words: str) -> _T:
    """Start the server, and return what `use` gets from a session with it."""
    command = ["-m", "rcx_harness", "mcp", "--folder", str(project), *words]
    server = StdioServerParameters(command=sys.executable, args=command, env=dict(os.environ))

    async def run() -> _T:
        with anyio.fail_after(_LONGEST):
            async with (
                stdio_client(server) as (reading, writing),
                ClientSession(reading, writing) as session,
            ):
                await session.initialize()
                return await use(session)

    return anyio.run(run)


async def _call(session: ClientSession, tool: str, **given: Any) -> Any:
    return await session.call_tool(tool, given)


async def _data(session: ClientSession, tool: str, **given: Any) -> Any:
    result = await _call(session, tool, **given)
    assert not result.is_error, result.content[0].text
    return result.structured_content


async def _error(session: ClientSession, tool: str, **given: Any) -> str:
    result = await _call(session, tool, **given)
    assert result.is_error
    text: str = result.content[0].text
    assert "Traceback" not in text
    return text


def test_a_session_uses_every_tool(project: Path) -> None:
    """Each tool answers, and its result agrees with its schema, which the client checks.

    Source: docs/how-to/assistant.md; plc/examples/01_power_up/PowerUp.st, the stages.
    """

    async def use(session: ClientSession) -> None:
        assert len((await session.list_tools()).tools) == 8
        assert (await _data(session, "check", files=_EXAMPLE))["exit_code"] == 0
        given = {"files": _EXAMPLE, "robot": ["robot.toml"]}
        stimulus = (project / "stimulus.toml").read_text()
        ran = await _data(
            session, "run", **given, stimulus=stimulus, watch=["Main.Stage"], duration="10s"
        )
        assert ran["watched"] == {"Main.Stage": "STAGE_COMPLETE"}
        assert ran["violation_count"] == 0
        told = await _data(session, "explain_trace", trace=ran["trace"])
        assert any("SI(01) ON" in event["text"] for event in told["events"])
        proved = await _data(session, "prove", files=["Counter.st"], no_robot=True)
        assert {row["status"] for row in proved["properties"]} <= {"proved", "noted"}
        storm = await _data(
            session, "campaign", **given, stimulus="stimulus.toml", seeds=2, duration="5s"
        )
        assert (storm["seeds"], storm["failures"]) == ({"first": 0, "count": 2}, [])
        killed = await _data(session, "mutants", files=["Counter.st"], tests=["test_counter.py"])
        assert killed["mutants"] == killed["killed"] + killed["survivor_count"]
        assert killed["killed"] > 0
        assert (await _data(session, "list_blocks", search="FB_ServoOn"))["blocks"]
        assert (await _data(session, "block_page", name="FB_ServoOn"))["pins"]

    _session(project, use)


def test_the_same_calls_have_the_same_bytes(project: Path) -> None:
    """A second server gives the same answers, byte for byte.

    Source: docs/how-to/assistant.md.
    """
    given = {"files": _EXAMPLE, "robot": ["robot.toml"]}
    calls: list[tuple[str, dict[str, Any]]] = [
        ("check", {"files": _EXAMPLE, "for": "tia"}),
        ("run", {**given, "jitter": "3ms", "seed": 5, "duration": "2s"}),
        ("campaign", {**given, "stimulus": "stimulus.toml", "seeds": 2, "duration": "3s"}),
        ("mutants", {"files": ["Counter.st"]}),
        ("prove", {"files": ["Counter.st"], "no_robot": True}),
    ]

    async def use(session: ClientSession) -> list[str]:
        return [(await _call(session, *call[:1], **call[1])).model_dump_json() for call in calls]

    assert _session(project, use) == _session(project, use)


def test_files_named_by_files_stay_inside(project: Path, tmp_path: Path) -> None:
    """A robot file, a project file and a test name files outside; nothing of these is read.

    Source: docs/how-to/assistant.md.
    """
    (tmp_path / "SECRET.PGM").write_text("THE SECRET LINE\n")
    (project / "robot.toml").write_text('[[programs]]\nname = "A"\nfile = "../SECRET.PGM"\n')
    (tmp_path / "Secret.st").write_text("THE SECRET LINE\n")
    (project / "link.st").symlink_to(tmp_path / "Secret.st")
    (project / "folder").symlink_to(tmp_path)
    (project / "test_counter.py").write_text(
        _TEST + f'    Path("{tmp_path}/SECRET.PGM").read_text()\n'
    )

    async def use(session: ClientSession) -> list[str]:
        return [
            await _error(session, "run", files=_EXAMPLE, robot=["robot.toml"]),
            await _error(session, "check", files=["link.st"]),
            await _error(session, "check", files=["folder/Secret.st"]),
            (await _data(session, "check", files=["."]))["findings"][0]["text"],
            await _error(session, "mutants", files=["Counter.st"], tests=["test_counter.py"]),
        ]

    for text in _session(project, use):
        assert "outside of the folders" in text
        assert "SECRET LINE" not in text


def test_the_fence_stands_before_code_of_the_project_runs(project: Path, tmp_path: Path) -> None:
    """A plugin that the settings of pytest name is loaded first, and is inside of the fence.

    Source: docs/how-to/assistant.md.
    """
    (tmp_path / "secret.txt").write_text("THE SECRET LINE\n")
    (project / "pytest.ini").write_text("[pytest]\naddopts = -p early\n")
    (project / "early.py").write_text(f'raise ValueError(open("{tmp_path}/secret.txt").read())\n')

    async def use(session: ClientSession) -> str:
        return await _error(session, "mutants", files=["Counter.st"])

    text = _session(project, use)
    assert "outside of the folders" in text
    assert "SECRET LINE" not in text


def test_tests_of_the_project_have_no_network(project: Path) -> None:
    """Source: docs/how-to/assistant.md."""
    lines = ["import socket", "", "", _TEST]
    lines += ['    socket.create_connection(("192.0.2.1", 80), 1)', ""]
    (project / "test_counter.py").write_text("\n".join(lines))

    async def use(session: ClientSession) -> str:
        return await _error(session, "mutants", files=["Counter.st"])

    assert "the network cannot be used inside of rcx mcp" in _session(project, use)


def test_a_call_that_takes_too_long_is_ended_and_the_server_lives(project: Path) -> None:
    """Source: docs/how-to/assistant.md, the limits."""

    async def use(session: ClientSession) -> None:
        said = await _error(session, "campaign", files=["Counter.st"], seeds=1000)
        assert "took longer than 0.5 s and was ended" in said
        assert (await _data(session, "list_blocks", search="FB_ServoOn"))["blocks"]

    _session(project, use, "--limit", "500ms")


def test_a_call_that_needs_too_much_memory_is_ended(project: Path) -> None:
    """Source: docs/how-to/assistant.md, the limits."""
    source = _COUNTER.replace("Sum : INT;", "Sum : INT; Big : ARRAY [0..3900000] OF LREAL;")
    (project / "Counter.st").write_text(source)

    async def use(session: ClientSession) -> None:
        given = {"files": ["Counter.st"], "no_robot": True, "watch": ["Main.Big"]}
        assert "memory" in await _error(session, "run", **given)
        assert (await _data(session, "list_blocks", search="FB_ServoOn"))["blocks"]

    _session(project, use, "--memory", "256")


def test_a_cancelled_call_ends_its_process(project: Path) -> None:
    """The process writes progress until it ends; after the cancellation, the server has no child.

    Source: docs/how-to/assistant.md.
    """

    async def use(session: ClientSession) -> None:
        begun = anyio.Event()

        async def reported(progress: float, total: float | None, message: str | None) -> None:
            begun.set()

        async def call() -> None:
            given = {"files": _EXAMPLE, "stimulus": "stimulus.toml", "seeds": 1000}
            await session.call_tool("campaign", given, progress_callback=reported)

        async with anyio.create_task_group() as group:
            group.start_soon(call)
            await begun.wait()
            assert _workers(project)
            group.cancel_scope.cancel()
        while _workers(project):  # ends with the time limit of the session
            await anyio.lowlevel.checkpoint()
            await _data(session, "list_blocks", search="FB_ServoOn")

    _session(project, use)


def test_a_failure_has_a_replay_that_fails_again(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The commands in the answers of campaign and prove replay the failures.

    The stage leaves its first value in every good run. Place is 0 in the first scan, which is
    outside of 1..5.

    Source: docs/how-to/assistant.md.
    """
    always = '[[always]]\nname = "idle"\nthat = "Main.Stage = STAGE_IDLE"\n'
    (project / "idle.toml").write_text(f'length = "3s"\n{always}')
    body = "VAR Place : INT; List : ARRAY [1..5] OF INT; END_VAR\nList[Place] := 1;"
    (project / "Index.st").write_text(f"PROGRAM Index\n{body}\nEND_PROGRAM\n")

    async def use(session: ClientSession) -> list[dict[str, Any]]:
        given = {"files": _EXAMPLE, "robot": ["robot.toml"], "properties": ["idle.toml"]}
        storm = await _data(session, "campaign", **given, stimulus="stimulus.toml", seeds=1)
        proved = await _data(session, "prove", files=["Index.st"], no_robot=True)
        return [*storm["failures"], *proved["properties"]]

    failure, index = _session(project, use)
    assert (failure["kind"], failure["fails_again"]) == ("always idle", True)
    assert (index["name"], index["status"]) == ("index Index.st:3", "refuted")
    monkeypatch.chdir(project)
    for row, code in ((failure, 1), (index, 2)):
        assert (project / row["replay"]).is_file()
        assert main(row["command"].split()[1:]) == code
    said = capsys.readouterr()
    assert "Main.Stage = STAGE_IDLE is not so" in said.out
    assert "Index.st:3" in said.err


@pytest.mark.parametrize(("how", "code"), [("end of input", 0), ("SIGTERM", 143), ("SIGINT", 130)])
def test_the_end_of_the_server_ends_its_calls(project: Path, how: str, code: int) -> None:
    """The server ends although a call is running and standard input is open.

    Source: docs/how-to/assistant.md; the exit codes are those of a shell, 128 and the signal.
    """
    command = [sys.executable, "-m", "rcx_harness", "mcp", "--folder", str(project)]
    hello: dict[str, Any] = {"protocolVersion": "2025-06-18", "capabilities": {}}
    hello["clientInfo"] = {"name": "test", "version": "1"}
    given = {"files": _EXAMPLE, "stimulus": "stimulus.toml", "seeds": 1000}
    work = {"name": "campaign", "arguments": given, "_meta": {"progressToken": 1}}
    messages: list[dict[str, Any]] = [
        {"id": 1, "method": "initialize", "params": hello},
        {"method": "notifications/initialized"},
        {"id": 2, "method": "tools/call", "params": work},
    ]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        for message in messages:
            server.stdin.write(json.dumps({"jsonrpc": "2.0", **message}).encode() + b"\n")
        server.stdin.flush()
        assert json.loads(server.stdout.readline())["id"] == 1
        assert json.loads(server.stdout.readline())["method"] == "notifications/progress"
        assert _workers(project)
        if how == "end of input":
            server.stdin.close()
        else:
            server.send_signal(signal.Signals[how])
        assert server.wait(_LONGEST) == code
    assert _workers(project) == []


def _workers(project: Path) -> list[str]:
    """Return the processes whose current folder is the project."""
    found = []
    for process in Path("/proc").iterdir():
        try:
            if process.name.isdigit() and os.readlink(process / "cwd") == str(project):
                found.append(process.name)
        except OSError:  # the process has ended
            continue
    return found
