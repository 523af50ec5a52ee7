"""The server for assistants lists its tools, checks their arguments and shows the blocks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from mcp.client import Client
from mcp.shared.exceptions import MCPError

from assistant_client import asked
from rcx_harness.assistant.tools import TOOLS

_NAMES = [
    "check",
    "run",
    "explain_trace",
    "prove",
    "campaign",
    "mutants",
    "list_blocks",
    "block_page",
]


def _refused(place: Path, tool: str, given: dict[str, Any]) -> str:
    """Return the message with which the server refuses a call."""

    async def ask(client: Client) -> Any:
        return await client.call_tool(tool, given)

    result = asked(place, ask)
    assert result.is_error
    assert result.structured_content is None
    text: str = result.content[0].text
    return text


def test_each_tool_has_a_description_and_closed_schemas(tmp_path: Path) -> None:
    """A closed schema has no unknown parameters, so that a wrong name is noticed.

    Source: docs/how-to/assistant.md.
    """

    async def ask(client: Client) -> Any:
        return await client.list_tools()

    tools = asked(tmp_path, ask).tools
    assert [tool.name for tool in tools] == _NAMES
    for tool in tools:
        assert tool.description
        for schema in (tool.input_schema, tool.output_schema):
            jsonschema.Draft202012Validator.check_schema(schema)
            assert schema["additionalProperties"] is False


@pytest.mark.parametrize(
    ("tool", "given", "words"),
    [
        ("chekc", {}, ["there is no tool 'chekc'", "did you mean check"]),
        ("check", {"files": ["a.st"], "fro": "tia"}, ["no parameter 'fro'", "did you mean for"]),
        ("check", {}, ["check: 'files' is a required property"]),
        ("run", {"files": ["a.st"], "seed": -1}, ["run: seed: -1 is less than the minimum of 0"]),
        ("run", {"files": ["a.st"], "duration": "5 s"}, ["run: duration: '5 s' does not match"]),
        ("campaign", {"files": ["a.st"], "seeds": 1001}, ["seeds: 1001 is greater than"]),
        ("check", {"files": ["a.st"], "folder": "/"}, ["'/' is not a folder of this server"]),
    ],
)
def test_a_wrong_call_is_refused_with_its_mistake(
    tmp_path: Path, tool: str, given: dict[str, Any], words: list[str]
) -> None:
    said = _refused(tmp_path, tool, given)
    for word in words:
        assert word in said


def test_a_block_has_its_page_as_tool_and_as_resource(tmp_path: Path) -> None:
    """Source: plc/lib/sequence/FB_ServoOn.st; spec/errors.toml, 16#8004."""

    async def ask(client: Client) -> tuple[Any, Any, Any]:
        listed = await client.call_tool("list_blocks", {"search": "servos on"})
        page = await client.call_tool("block_page", {"name": "FB_ServoOn"})
        return listed, page, await client.read_resource("rcx://blocks/FB_ServoOn")

    listed, page, resource = asked(tmp_path, ask)
    row = next(row for row in listed.structured_content["blocks"] if row["name"] == "FB_ServoOn")
    assert row["inputs"] == ["Robot", "Execute", "Timeout"]
    assert row["outputs"] == ["Done", "Busy", "Active", "Error", "ErrorID"]
    assert row["purpose"] == "Switch the servos on."
    assert row["section"] == "chapter 5, 3.1"
    text = page.content[0].text
    assert "| Timeout | TIME | T#5s | longest wait for the controller's answer" in text
    assert "| 16#8004 | Alarm |" in text
    assert resource.contents[0].text == text
    assert json.loads(json.dumps(page.structured_content))["page"] == text


def test_an_unknown_block_is_refused_with_a_similar_name(tmp_path: Path) -> None:
    async def ask(client: Client) -> str:
        with pytest.raises(MCPError) as refused:
            await client.read_resource("rcx://blocks/FB_ServoOnn")
        return str(refused.value)

    assert "did you mean FB_ServoOn" in asked(tmp_path, ask)


def test_every_public_block_has_a_purpose_and_pins() -> None:
    """A change of the layout of plc/lib must not empty the pages.

    Source: plc/lib.
    """
    from rcx_harness.assistant.blocks import blocks

    assert len(blocks()) > 150
    for block in blocks().values():
        assert block.purpose, block.name
        assert block.pins or block.name == "FC_LibraryVersion", block.name


@pytest.mark.exhaustive
def test_the_tools_of_the_table_can_all_be_run() -> None:
    for tool in TOOLS.values():
        module = __import__(f"rcx_harness.assistant.{tool.home}", fromlist=[tool.name])
        assert callable(getattr(module, tool.name))
