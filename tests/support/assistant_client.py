"""A client of the server for assistants, which calls the tools in the process of the test."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import anyio
from mcp.client import Client

from rcx_harness.assistant.call import Call
from rcx_harness.assistant.child import answered
from rcx_harness.assistant.folders import Folders
from rcx_harness.assistant.limits import Limits
from rcx_harness.assistant.server import Assistant
from rcx_harness.assistant.worker import Report
from rcx_harness.cli.mcp_child import command

_T = TypeVar("_T")


def here(tool: str, folder: Path, /, **given: Any) -> dict[str, Any]:
    """Answer a call of a tool in this process; the current folder must be `folder`."""
    call = Call(tool, given, Folders.of([folder]), folder, folder / ".tmp", command)
    call.temporary.mkdir(exist_ok=True)
    return answered(call)


def asked(folder: Path, ask: Callable[[Client], Awaitable[_T]]) -> _T:
    """Start the server in this process, and return what `ask` gets from it."""

    async def worker(
        tool: str,
        given: Mapping[str, Any],
        folders: Folders,
        place: Path,
        limits: Limits,
        report: Report,
    ) -> dict[str, Any]:
        del folders, limits, report
        return here(tool, place, **given)

    async def run() -> _T:
        assistant = Assistant(Folders.of([folder]), worker)
        async with Client(assistant.server()) as client:
            return await ask(client)

    return anyio.run(run)
