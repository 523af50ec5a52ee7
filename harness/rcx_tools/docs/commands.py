"""Generator of docs/reference/commands.md: each remote command with block, test and data words."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from rcx_harness import spec
from rcx_harness.spec.telegram import Command, Field, intervals
from rcx_tools.library import CATEGORIES, Block, library

__all__ = ["blocks_of", "commands_page"]

_INTRO = """\
The remote commands of the guide, all 116: code, block, test and section. `R` in a code is the
robot number, 0 to 4. `FB_RemoteCommand` sends any of them in words; `rcx encode` and
`rcx decode` put them into words and plain language.

Below the table are the words of each command: `n` is the first byte that the master writes, `m`
the first one that it reads. Bits and words that are not listed must be 0.

| Code | Command | Block | Test | Guide |
|---|---|---|---|---|"""


def blocks_of(command: Command) -> list[Block]:
    """Return the blocks that send a command. For the status reset there are none."""
    return [block for block in library().blocks.values() if command in block.commands]


def commands_page() -> Iterator[str]:
    """Yield the lines of the page about remote commands."""
    yield _INTRO
    every = list(spec.commands().values())
    for command in every:
        blocks = blocks_of(command)
        shown = ", ".join(_file(block) for block in blocks)
        tests = ", ".join(dict.fromkeys(_test(block) for block in blocks))
        if not command.code:
            shown = "[FB_RcxHandshake](../../plc/lib/core/FB_RcxHandshake.st)"
            tests = _link("tests/area/test_handshake.py")
        title = f"[{command.title}](#{command.name.lower()})"
        yield f"| `{command.shown}` | {title} | {shown} | {tests} | {command.section} |"
    category = None
    for command in every:
        if command.category != category and command.category:
            category = command.category
            yield f"\n## Category {category}: {CATEGORIES[category][1]}"
        yield from _details(command)


def _details(command: Command) -> Iterator[str]:
    yield f"\n### {command.name}\n"
    yield f"`{command.shown}` {command.title} (guide {command.section}). " + _conditions(command)
    for title, letter, fields in (
        ("Request", "n", command.request),
        ("Response at the normal end", "m", command.response),
    ):
        if not fields:
            continue
        yield f"\n| {title} | Address | May be |\n|---|---|---|"
        names = [part.name for part in fields]
        for part in fields:
            yield f"| `{part.name}` | {_address(part, letter)} | {_allowed(part, names)} |"


def _conditions(command: Command) -> str:
    texts = []
    if command.robot:
        texts.append(f"R = 0 is {command.robot_zero}.")
    if command.pendant:
        texts.append("Works also while the programming box has control authority.")
    texts += [f"`{a}` and `{b}` cannot both be 1." for a, b in command.exclusive]
    if command.product:
        low, high = command.product.range
        texts.append(f"{' * '.join(command.product.fields)} is {low} to {high}.")
    return " ".join(texts)


def _address(part: Field, letter: str) -> str:
    if part.type == "bits":
        low, high = part.bits
        return f"{letter}+{part.at}, bit {low}" + (f" to {high}" if high > low else "")
    last = 2 * part.words[-1]
    span = f" to {letter}+{last}" if last > part.at else ""
    many = f", {part.count} of them" if part.count > 1 else ""
    kind = f"{part.length} characters" if part.type == "text" else part.type
    return f"{letter}+{part.at}{span}, {kind}{many}"


def _allowed(part: Field, names: Sequence[str]) -> str:
    """Return the legal values of a field. `names` has all field names of the telegram."""
    texts = []
    by, units = part.units_by(names)
    if part.values:
        texts.append("; ".join(f"{value}: {text}" for value, text in part.values.items()))
    if part.range and part.type != "text":
        texts.append(_limits(part.range))
    groups: dict[tuple[tuple[int, ...], str], list[int]] = {}
    for value, limits in part.ranges.items():
        unit = f" [{units[value]}]" if part.by == by and value in units else ""
        groups.setdefault((limits, unit), []).append(value)
    for (limits, unit), values in groups.items():
        where = f"if `{part.by}` is {', '.join(map(str, values))}"
        texts.append(where if part.type == "text" else f"{_limits(limits)}{unit} {where}")
    if by and by != part.by:
        texts.append(", ".join(f"[{unit}] if `{by}` is {k}" for k, unit in units.items()))
    unit = f"[{part.unit}]" if part.unit and not by else ""
    texts += [text for text in (unit, part.meaning) if text]
    return "; ".join(texts).replace("|", "\\|") or "any"


def _limits(limits: tuple[int, ...]) -> str:
    return ", ".join(
        f"{low} to {high}" if low < high else f"{low}" for low, high in intervals(limits)
    )


def _file(block: Block) -> str:
    return f"[{block.name}](../../{block.file})"


def _test(block: Block) -> str:
    text = (spec.folder().parent / block.file).read_text(encoding="utf-8")
    head = text.partition("*)")[0]
    return ", ".join(_link(path) for path in re.findall(r"tests/[\w/]+\.py", head))


def _link(path: str) -> str:
    return f"[{path.rpartition('/')[2]}](../../{path})"
