"""The server of the Model Context Protocol: its tools and resources, on standard input and output.

Each call runs in a process of its own (`worker`), so that its limits end the call and not the
server.
"""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any, cast

import anyio
import jsonschema
import mcp_types as types
from mcp.server import Server, ServerRequestContext
from mcp.server.stdio import stdio_server
from mcp.shared.exceptions import MCPError

from rcx_harness.assistant.blocks import blocks, page
from rcx_harness.assistant.call import Call, Ran
from rcx_harness.assistant.child import answered
from rcx_harness.assistant.folders import Folders
from rcx_harness.assistant.limits import MOST_CALLS, Limits
from rcx_harness.assistant.standard_input import lines_of_standard_input
from rcx_harness.assistant.tools import TOOLS, Tool
from rcx_harness.assistant.worker import Report, work
from structured_text.errors import InputError, legible, near

__all__ = ["Assistant", "serve"]

_ABOUT = (
    "Tools for IEC 61131-3 Structured Text that drives a YAMAHA RCX340/RCX320 robot controller "
    "over EtherNet/IP. Everything runs against a virtual controller; no robot moves. Begin with "
    "list_blocks and block_page to see the library, check after each change, run with a stimulus, "
    "and explain_trace to see what happened. Paths are relative to the folder of the server."
)
_SCHEME = "rcx://blocks/"
_MARKDOWN = "text/markdown"

Worker = Callable[[str, Mapping[str, Any], Folders, Path, Limits, Report], Awaitable[Any]]
"""Answers a call of a tool."""


@dataclass
class Assistant:
    """The answers of the server.

    Attributes:
        folders: The folders that the calls may use.
        worker: Answers a call of a tool.
        limits: Limits of each call.
    """

    folders: Folders
    worker: Worker
    limits: Limits = field(default_factory=Limits)

    def server(self) -> Server[Any]:
        """Return the server."""
        room = anyio.CapacityLimiter(MOST_CALLS)

        async def call(
            context: ServerRequestContext[Any], asked: types.CallToolRequestParams
        ) -> types.CallToolResult:
            steps = 0.0

            async def report(text: str, done: float | None, total: float | None) -> None:
                nonlocal steps
                steps = steps + 1 if done is None else done
                await context.session.report_progress(steps, total, text)

            async with room:
                return await self.called(asked.name, asked.arguments or {}, report)

        return Server(
            "rcx",
            title="RCX3 function blocks",
            version=version("rcx-harness"),
            instructions=_ABOUT,
            on_list_tools=_list_tools,
            on_call_tool=call,
            on_list_resources=_list_resources,
            on_list_resource_templates=_list_templates,
            on_read_resource=_read_resource,
        )

    async def called(
        self, name: str, given: Mapping[str, Any], report: Report
    ) -> types.CallToolResult:
        """Check a call, let the worker answer it, and return the answer for the client."""
        try:
            tool = _tool(name)
            _check_arguments(tool, given)
            here = self.folders.chosen(given.get("folder", ""))
        except InputError as error:
            return _failed(legible(str(error)))
        if tool.of_library:
            answer = answered(Call(name, given, self.folders, here, here, _no_command))
        else:
            answer = await self.worker(name, given, self.folders, here, self.limits, report)
        if "error" in answer:
            return _failed(answer["error"])
        data = json.dumps(answer["data"], sort_keys=True, ensure_ascii=False)
        content: list[types.ContentBlock] = [types.TextContent(type="text", text=answer["text"])]
        if not answer["whole"]:  # for clients that do not read structured content
            content.append(types.TextContent(type="text", text=data))
        return types.CallToolResult(content=content, structured_content=json.loads(data))


def serve(folders: Folders, limits: Limits, entry: str) -> None:
    """Serve an assistant on standard input and output until it closes standard input.

    `entry` is the module that answers a call in its own process (`child.serve_call`).
    """

    async def worker(
        tool: str,
        given: Mapping[str, Any],
        folders: Folders,
        here: Path,
        limits: Limits,
        report: Report,
    ) -> dict[str, Any]:
        return await work(entry, tool, given, folders, here, limits, report)

    async def run() -> None:
        server = Assistant(folders, worker, limits).server()
        async with (
            lines_of_standard_input() as lines,
            # The library only iterates over the lines.
            stdio_server(stdin=cast("anyio.AsyncFile[str]", lines)) as (reading, writing),
        ):
            await server.run(reading, writing, server.create_initialization_options())

    anyio.run(run)


def _no_command(words: Sequence[str], tell: Callable[[str], None]) -> Ran:
    """Refuse to run a command; a tool that shows the library needs none."""
    del tell
    raise InputError(f"the server itself runs no command: {' '.join(words)}")


def _failed(text: str) -> types.CallToolResult:
    return types.CallToolResult(content=[types.TextContent(type="text", text=text)], is_error=True)


def _tool(name: str) -> Tool:
    if name not in TOOLS:
        raise InputError(f"there is no tool {name!r:.100}", hint=near(name, TOOLS))
    return TOOLS[name]


def _check_arguments(tool: Tool, given: Mapping[str, Any]) -> None:
    """Raise InputError if arguments do not fit the schema of the tool."""
    unknown = [name for name in given if name not in tool.given["properties"]]
    if unknown:
        hint = near(unknown[0], tool.given["properties"])
        raise InputError(f"{tool.name} has no parameter {unknown[0]!r:.100}", hint=hint)
    errors = jsonschema.Draft202012Validator(tool.given).iter_errors(dict(given))
    error = jsonschema.exceptions.best_match(errors)
    if error is not None:
        place = ".".join(map(str, error.absolute_path))
        about = error.schema.get("description", "") if isinstance(error.schema, dict) else ""
        where = f"{tool.name}: {place}" if place else tool.name
        raise InputError(f"{where}: {error.message:.300}", hint=about)


async def _list_tools(
    context: ServerRequestContext[Any], asked: types.PaginatedRequestParams | None
) -> types.ListToolsResult:
    del context, asked
    return types.ListToolsResult(
        tools=[
            types.Tool(
                name=tool.name,
                title=tool.title,
                description=tool.about,
                input_schema=tool.given,
                output_schema=tool.answer,
                annotations=types.ToolAnnotations(
                    read_only_hint=not tool.writes,
                    destructive_hint=False,
                    idempotent_hint=True,
                    open_world_hint=False,
                ),
            )
            for tool in TOOLS.values()
        ]
    )


async def _list_resources(
    context: ServerRequestContext[Any], asked: types.PaginatedRequestParams | None
) -> types.ListResourcesResult:
    del context, asked
    return types.ListResourcesResult(
        resources=[
            types.Resource(
                uri=f"{_SCHEME}{block.name}",
                name=block.name,
                description=block.purpose,
                mime_type=_MARKDOWN,
            )
            for block in blocks().values()
            if not block.internal
        ]
    )


async def _list_templates(
    context: ServerRequestContext[Any], asked: types.PaginatedRequestParams | None
) -> types.ListResourceTemplatesResult:
    del context, asked
    template = types.ResourceTemplate(
        uri_template=f"{_SCHEME}{{name}}",
        name="block",
        title="Page of a block",
        description="What a block of the library does, its pins, its errors and its source.",
        mime_type=_MARKDOWN,
    )
    return types.ListResourceTemplatesResult(resource_templates=[template])


async def _read_resource(
    context: ServerRequestContext[Any], asked: types.ReadResourceRequestParams
) -> types.ReadResourceResult:
    del context
    uri = str(asked.uri)
    try:
        if not uri.startswith(_SCHEME):
            raise InputError(f"there is no resource {uri!r:.100}", hint=f"use {_SCHEME}NAME")
        text = page(uri.removeprefix(_SCHEME))
    except InputError as error:
        raise MCPError(types.INVALID_PARAMS, legible(str(error))) from None
    contents = types.TextResourceContents(uri=asked.uri, mime_type=_MARKDOWN, text=text)
    return types.ReadResourceResult(contents=[contents])
