"""All 116 remote commands: each has a block, a test, a line in the table and an effect."""

from __future__ import annotations

import re

import pytest

from plc_bench import LIBRARY, ROOT
from rcx_harness import spec
from rcx_harness.library.tables import library
from rcx_harness.telegram import Command

_COMMANDS = [command for command in spec.commands().values() if command.code]
_FILES = {file.stem: file for file in LIBRARY}
_ROWS = re.compile(r"^\| `0x([0R][0-9A-F]{3})` \|(.*)\|$", re.MULTILINE)

every_command = pytest.mark.parametrize("command", _COMMANDS, ids=lambda one: str(one.name))


def _blocks(command: Command) -> list[str]:
    return [name for name, block in library().blocks.items() if command in block.commands]


def test_there_are_116_commands_besides_the_status_reset() -> None:
    """Source: remote command guide 3., list of remote commands, and 4.2 to 4.9"""
    assert len(_COMMANDS) == 116
    assert [command.code for command in _COMMANDS] == sorted({one.code for one in _COMMANDS})
    counts = [sum(one.category == number for one in _COMMANDS) for number in range(1, 9)]
    assert counts == [51, 10, 20, 3, 7, 16, 6, 3]


@every_command
def test_the_code_stands_in_the_file_of_a_block_that_has_a_test(command: Command) -> None:
    blocks = _blocks(command)
    assert blocks
    for name in blocks:
        text = _FILES[name].read_text(encoding="utf-8")
        head, _, body = text.partition("*)")
        assert f"WORD#16#{command.code:04X}" in body
        tests = re.findall(r"tests/[\w/]+\.py", head)
        assert tests
        assert all((ROOT / test).is_file() for test in tests)


@every_command
def test_the_table_of_commands_has_a_row_with_block_test_and_section(command: Command) -> None:
    page = (ROOT / "docs/commands.md").read_text(encoding="utf-8")
    rows = {code: row for code, row in _ROWS.findall(page)}
    row = rows[command.shown.removeprefix("0x")]
    for name in _blocks(command):
        assert f"plc/lib/command/{name}.st" in row
    assert command.title in row
    assert re.search(r"tests/command/\w+\.py", row)
    assert row.split("|")[-1].strip().endswith(command.section)


def test_the_virtual_controller_executes_every_command() -> None:
    from rcx_harness.robot.commands.base import registered

    assert sorted(registered()) == [command.code for command in _COMMANDS]
