"""Generator of files in plc/lib: each command block, and the types of its pins."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from rcx_harness.spec.telegram import Command
from rcx_tools.library.answer import answer
from rcx_tools.library.checks import checks
from rcx_tools.library.packing import packing
from rcx_tools.library.st import WIDTH, case, indent, named, word
from rcx_tools.library.tables import Array, Block, Enumeration, Input, Library, library

__all__ = ["files"]

_FROM = "Generated from spec/blocks.toml and spec/remote_commands.toml by `make docs`."
_TESTS = "tests/command/test_command_blocks.py"

#: Greatest length of a type. After a longer type the comment is not in the common column.
_KIND = 24

#: While Execute is TRUE, Busy, Done or Error is TRUE, too. This early return therefore never skips
#: a call that has to detect the falling edge.
_IDLE = ["IF NOT (Execute OR Busy OR Done OR Error) THEN", "  RETURN;", "END_IF;"]

_SHOWN = [
    "Done := Job.Done;",
    "Busy := Job.Busy;",
    "Active := Job.Active;",
    "Error := Job.Error;",
    "ErrorID := Job.ErrorID;",
    "AlarmGroup := FC_RcxAlarmWord(ErrorID := ErrorID, Ended := Job.Ended, Before := AlarmGroup,",
    "                              Response := Robot.Response[1]);",
    "AlarmCategory := FC_RcxAlarmWord(ErrorID := ErrorID, Ended := Job.Ended, "
    "Before := AlarmCategory,",
    "                                 Response := Robot.Response[2]);",
]

#: A declaration: name, type with default value, comment.
_Row = tuple[str, str, str]


def files() -> dict[str, Callable[[], str]]:
    """Return the generators of the files, by the path in the repository."""
    tables = library()
    written: dict[str, Callable[[], str]] = {}
    for enumeration in tables.enumerations.values():
        written[f"plc/lib/types/{enumeration.name}.st"] = partial(_enumeration, enumeration)
    for array in tables.arrays.values():
        written[f"plc/lib/types/{array.name}.st"] = partial(_array, array)
    for block in tables.blocks.values():
        if not block.handwritten:
            written[block.file] = partial(_block, block, tables)
    return written


def _head(name: str, does: str, section: str, *paragraphs: Iterable[str]) -> list[str]:
    """Return the comment at the head of a file."""
    title = textwrap.wrap(f"{name}: {does} ({section}).", 97)
    lines = ["(*", *(f" * {line}" for line in title)]
    for paragraph in paragraphs:
        lines += [" *", *(f" * {line}" for line in paragraph)]
    return [*lines, " *)"]


def _enumeration(one: Enumeration) -> str:
    width = max(len(member.name) for member in one.members) + 1
    last = one.members[-1]
    rows = []
    for member in one.members:
        name = member.name if member is last else f"{member.name},"
        rows.append(f"    {name:<{width}}  (* {member.meaning} *)")
    head = _head(one.name, one.does, one.section, [_FROM])
    return "\n".join([*head, "TYPE", f"  {one.name} : (", *rows, "  );", "END_TYPE", ""])


def _array(one: Array) -> str:
    head = _head(one.name, one.does, one.section, [_FROM])
    body = f"  {one.name} : ARRAY [1..{one.count}] OF {one.of};"
    return "\n".join([*head, "TYPE", body, "END_TYPE", ""])


def _block(block: Block, tables: Library) -> str:
    command = block.commands[0]
    about = [line for part in block.about.strip().split("\n") for line in textwrap.wrap(part, 97)]
    sections = " and ".join(dict.fromkeys(one.section for one in block.commands))
    more = [about] if about else []
    head = _head(block.name, block.does, f"guide {sections}", *more, [_FROM, f"Tests: {_TESTS}"])
    body = [
        *_IDLE,
        "IF Execute AND NOT (Job.Busy OR Job.WasExecute) THEN",
        *indent(
            [
                *_code(block, tables),
                *checks(block, tables, packing(block, tables)),
                "Job.Longest := FC_RcxMilliseconds(Value := Timeout);",
            ]
        ),
        "END_IF;",
        "",
        "Job(Channel := Robot.Inner.Command, Execute := Execute, Scan := Robot.Inner.Scan,",
        "    InScan := Robot.Inner.InScan, Elapsed := Robot.Inner.Elapsed,",
        "    Answer := Robot.Inner.Answer, Remote := TRUE,",
        "    Applied := Robot.Inner.Phase = PHASE_COMMAND_RUN);",
        "",
        "IF Job.Request THEN",
        "  Robot.Inner.Code := Robot.Inner.Command.Holder;",
        "  Robot.Inner.Data := Data;",
        "  Robot.Inner.CodeRequest := TRUE;",
        "END_IF;",
        *answer(block, tables),
        *_SHOWN,
    ]
    text = "\n".join(body)
    sections_of_pins = (
        ("VAR_IN_OUT", [("Robot", "RCX_REF", "")]),
        ("VAR_INPUT", _inputs(block, command)),
        ("VAR_OUTPUT", _outputs(block)),
        ("VAR", _inner(text)),
    )
    lines = [*head, f"FUNCTION_BLOCK {block.name}"]
    for keyword, rows in sections_of_pins:
        lines += [f"  {keyword}", *_declared(rows), "  END_VAR"]
    lines += ["", *map(named, indent(body)), "END_FUNCTION_BLOCK", ""]
    return "\n".join(line.rstrip() for line in lines)


def _code(block: Block, tables: Library) -> list[str]:
    """Return the statements that set the command code.

    The code contains the robot number. The job shows the code while it has the turn.
    """
    robot = " OR SHL(INT_TO_WORD(RobotNumber), 12)" if block.commands[0].robot else ""
    if block.select is None:
        return [f"Job.Holder := {word(block.commands[0].code)}{robot};"]
    members = tables.enumerations[block.select.type].members
    pairs = zip(members, block.commands, strict=True)
    rows = [(one.name, f"Job.Holder := {word(command.code)}{robot};") for one, command in pairs]
    return case(block.select.pin, rows)


def _inputs(block: Block, command: Command) -> list[_Row]:
    rows = [("Execute", "BOOL", "rising edge starts; may go FALSE at once")]
    if command.robot:
        rows.append(("RobotNumber", "INT", f"1 to 4; 0 = {command.robot_zero}"))
    for pin in (*([block.select] if block.select else []), *block.inputs):
        rows.append((pin.pin, _type(pin), pin.comment))
    limit = "longest wait for the end; T#0s = no limit"
    rows.append(("Timeout", f"TIME := {block.timeout}", limit))
    return rows


def _type(pin: Input) -> str:
    neutral = pin.default in ("", "0", "FALSE", "''", "0.0")
    return pin.type if neutral else f"{pin.type} := {pin.default}"


def _outputs(block: Block) -> list[_Row]:
    return [
        ("Done", "BOOL", f"{block.done}; TRUE until Execute is FALSE"),
        ("Busy", "BOOL", "running, or waiting for the turn; call in every scan"),
        ("Active", "BOOL", "this block has the turn and uses the command words"),
        ("Error", "BOOL", "refused, abnormal end, timeout or lost link; see ErrorID"),
        ("ErrorID", "WORD", "docs/reference/errors.md; 16#0000 = none"),
        ("AlarmGroup", "WORD", "alarm group, such as 12 of alarm 12.600; 0 = no alarm"),
        ("AlarmCategory", "WORD", "alarm category, such as 600 of alarm 12.600; 0 = no alarm"),
        *((pin.pin, pin.type, pin.comment) for pin in block.outputs),
    ]


def _inner(body: str) -> list[_Row]:
    every = (
        ("Job", "FB_RcxJob", ""),
        ("Data", "RCX_WORDS", "command data, sampled at the rising edge of Execute"),
        ("Refused", "WORD", "ErrorID of an illegal input"),
        ("Number", "DINT", ""),
        ("k", "INT", ""),
    )
    return [row for row in every if re.search(rf"(?<!\w|\.){row[0]}\b(?! := \w+[,)])", body)]


def _declared(rows: Sequence[_Row]) -> list[str]:
    width = max(len(name) for name, _, _ in rows)
    kinds = max((len(kind) for _, kind, comment in rows if comment), default=0)
    column = width + min(kinds, _KIND) + 10
    lines = []
    for name, kind, comment in rows:
        text = f"    {name:<{width}} : {kind};"
        if comment:
            remark = f"(* {comment} *)"
            begin = min(column, WIDTH - len(remark))  # a long comment begins further to the left
            text = f"{text:<{begin - 2}}  {remark}"
        lines.append(text)
    return lines
