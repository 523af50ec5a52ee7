"""Each of the 116 remote commands has a block, a test, a row in the table, and an effect."""

from __future__ import annotations

import re

from for_each import for_each
from plc_bench import LIBRARY, ROOT
from rcx_harness import spec
from rcx_harness.spec.telegram import Command
from rcx_tools.library.tables import Block, library

_COMMANDS = [command for command in spec.commands().values() if command.code]
_FILES = {file.stem: file for file in LIBRARY}
_ROWS = re.compile(r"^\| `0x([0R][0-9A-F]{3})` \|(.*)\|$", re.MULTILINE)

every_command = for_each("command", _COMMANDS)


def _blocks(command: Command) -> list[str]:
    return [name for name, block in library().blocks.items() if command in block.commands]


#: The codes in the lists of the guide, by category. For motor power, the list is wrong, and section
#: 4.2.20 has the right codes.
_CODES = {
    1: "001 002 003 004 006 007 009 00A 00E 00F 010 012 013 014 016 017 018 019 020 021 022 024 "
    "025 026 027 028 030 031 032 033 034 035 036 038 039 03A 03B 03C 03D 041 042 043 044 045 048 "
    "04B 04C 04D",
    2: "100 101 104 105 108 109 10C 10D 110 111",
    3: "200 201 204 205 208 209 20C 20D 210 211 214 220 224 230 234 235 238 240 241 245",
    4: "300 301 304",
    5: "401 402 403 404 405 406 408",
    6: "501 502 503 505 506 507 508 509 50A 50B 50C 50F 510 511 512 513 514 515 516",
    7: "602 603 604 605 606 607",
    8: "701 702 703",
}


def test_the_commands_are_the_116_of_the_lists() -> None:
    """spec/remote_commands.toml has the 116 commands of the guide's lists.

    Source: remote command guide 4.2 to 4.9, lists at their beginning.
    """
    listed = [(number, code) for number, text in _CODES.items() for code in text.split()]
    assert len(listed) == 116
    assert [(one.category, f"{one.code:03X}") for one in _COMMANDS] == listed


@every_command
def test_each_code_is_in_a_block_with_a_test(command: Command) -> None:
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
    page = (ROOT / "docs/reference/commands.md").read_text(encoding="utf-8")
    rows = dict(_ROWS.findall(page))
    row = rows[command.shown.removeprefix("0x")]
    for name in _blocks(command):
        (link,) = re.findall(rf"\[{name}\]\(\.\./\.\./(plc/lib/command/\S+)\)", row)
        assert (ROOT / link).is_file(), link
    assert command.title in row
    assert re.search(r"tests/command/\w+\.py", row)
    assert row.split("|")[-1].strip().endswith(command.section)


@every_command
def test_the_blocks_of_a_command_together_have_all_its_fields(command: Command) -> None:
    """Together, the blocks send every field and value of the manual, and show every answer field.

    Source: design of the library, 3: every flag and field of the manual is reachable.
    """
    blocks = [library().blocks[name] for name in _blocks(command)]
    if any(block.handwritten for block in blocks):
        return  # FB_RemoteCommand sends every code, which its own tests check
    for part in command.request:
        sent = [block for block in blocks if part.name not in block.zero]
        assert sent, part.name
        values = {value for block in sent for value in block.only.get(part.name, part.values)}
        assert values == set(part.values), part.name
    for part in command.response:
        shown = {one.source for block in blocks for one in block.outputs}
        assert part.name in shown | {"flag_bit0"}, part.name


@for_each("block", library().blocks.values())
def test_a_real_pin_has_the_unit_mm_or_percent(
    block: Block,
) -> None:
    """A pin is a REAL in mm or % if its field has the unit 0.001 mm or 0.01 %.

    Source: remote command guide 4.2.1.
    """
    for pin in block.inputs:
        part = block.requests[pin.to[0]]
        if pin.scale_by:
            assert (part.name, pin.scale_by) == ("speed", {1: 100, 2: 1, 3: 1})
        elif "REAL" in _kinds(pin.type) and not pin.encoding:
            assert "0.001 mm" in part.unit
            assert pin.scale == 1000
        else:
            assert not pin.scale
            assert part.unit != "0.001 mm"
    for output in block.outputs:
        part = block.responses[output.source]
        if "REAL" in _kinds(output.type) and not output.encoding:
            assert "0.001 mm" in part.unit
            assert output.scale == 0.001
        else:
            assert not output.scale
            assert part.unit != "0.001 mm"


def _kinds(kind: str) -> tuple[str, ...]:
    return (kind, library().arrays[kind].of) if kind in library().arrays else (kind,)


def test_the_virtual_controller_executes_every_command() -> None:
    """The virtual controller has every command. tests/robot/commands checks the effects."""
    import rcx_harness.robot.commands
    from rcx_harness.robot.commands.base import registered

    assert rcx_harness.robot.commands
    assert registered() == [command.code for command in _COMMANDS]
