"""The start of the process of a call, its limits of time, its progress and its end."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import anyio
from anyio import to_thread

from rcx_harness.assistant.folders import Folders
from rcx_harness.assistant.limits import Limits
from structured_text.output.programs import Program, environment

__all__ = ["Report", "work"]

Report = Callable[[str, float | None, float | None], Awaitable[None]]
"""Passes progress to the client: a line of text, the finished part and the whole, if known."""

#: The variables of the environment that a call gets. Others may be secrets, or change its result.
_KEPT = {
    *("HOME", "LANG", "LC_ALL", "LC_CTYPE", "RCX_CACHE", "SYSTEMROOT", "USERPROFILE"),
    *("APPDATA", "LOCALAPPDATA", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"),
}


async def work(
    entry: str,
    tool: str,
    given: Mapping[str, Any],
    folders: Folders,
    here: Path,
    limits: Limits,
    report: Report,
) -> dict[str, Any]:
    """Answer a call in a process of its own, which ends with the call.

    Args:
        entry: The module that the process runs.
        tool: Name of the tool.
        given: Its arguments.
        folders: The folders that the process may use.
        here: The folder that it works in.
        limits: Limits of the call.
        report: Passes progress to the client.
    """
    with tempfile.TemporaryDirectory(prefix="rcx-mcp-", ignore_cleanup_errors=True) as name:
        temporary = Path(os.path.realpath(name))
        request = {
            "tool": tool,
            "given": dict(given),
            "folders": list(map(str, folders.roots)),
            "here": str(here),
            "temporary": str(temporary),
            "limits": {"seconds": limits.seconds, "megabytes": limits.megabytes},
        }
        # The start must not be abandoned, because its process would never end.
        with anyio.CancelScope(shield=True):
            program = await to_thread.run_sync(_started, entry, temporary)
        try:
            await to_thread.run_sync(_send, program, json.dumps(request))
            with anyio.move_on_after(limits.seconds):
                return await _answer(program, report)
            return {
                "error": f"the call took longer than {limits.seconds:g} s and was ended; give it "
                "less work, or start the server with a longer --limit"
            }
        finally:
            with anyio.CancelScope(shield=True):
                await to_thread.run_sync(_end, program)


def _started(module: str, temporary: Path) -> Program:
    """Start the process in an empty folder, so that it imports no file of the user by accident.

    `python -m` has put the current folder into the path of this process. It is left out.
    """
    path = [os.path.abspath(entry) for entry in sys.path if entry]
    variables = environment(
        without=[name for name in os.environ if name.upper() not in _KEPT],
        PATH="",
        PYTHONDONTWRITEBYTECODE="1",
        PYTHONHASHSEED="0",
        PYTHONPATH=os.pathsep.join(entry for entry in path if entry != os.getcwd()),
        TEMP=str(temporary),
        TMP=str(temporary),
        TMPDIR=str(temporary),
    )
    pipe, nothing = subprocess.PIPE, subprocess.DEVNULL
    command = [sys.executable, "-m", module]
    return Program(command, stdin=pipe, stdout=pipe, stderr=nothing, cwd=temporary, env=variables)


def _send(program: Program, text: str) -> None:
    assert program.stdin is not None
    with suppress(OSError), program.stdin as stream:  # if the process has ended, no answer comes
        stream.write(text.encode() + b"\n")


async def _answer(program: Program, report: Report) -> dict[str, Any]:
    """Read lines of progress and the answer; return an error if the process ends without one."""
    assert program.stdout is not None
    read = program.stdout.readline
    while line := await to_thread.run_sync(read, abandon_on_cancel=True):
        found: dict[str, Any] = json.loads(line)
        if "progress" not in found:
            return found
        await report(*found["progress"])
    return {
        "error": "the process of the call ended without an answer; it may have needed more memory "
        "than its limit allows: give it less work, or start the server with a greater --memory"
    }


def _end(program: Program) -> None:
    """End the process and the processes that it has started."""
    program.kill()
    with program:  # waits, and closes the pipes
        pass
