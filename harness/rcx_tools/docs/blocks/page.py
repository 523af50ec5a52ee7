"""Generator of the pages docs/reference/blocks/FB_X.md, and of one page for all functions."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import timedelta
from functools import cache
from pathlib import Path
from typing import Any

from rcx_harness import spec
from rcx_harness.trace.chart_svg import svg_chart
from rcx_tools.docs.blocks.examples import (
    FOLDER,
    Snippet,
    own_pins,
    program,
    shows_all,
    snippets,
    without,
)
from rcx_tools.docs.blocks.ladders import ladder_text
from rcx_tools.docs.blocks.ranges import range_of
from rcx_tools.docs.blocks.runs import Run, run_of
from rcx_tools.docs.blocks.source import ROOT, Pin, Pou, kinds, pous
from rcx_tools.docs.processes import processes
from rcx_tools.library import library
from structured_text.output.toml_files import load_toml

__all__ = ["CHART_MARK", "MARK", "block_chart", "block_page", "functions_page", "tasks"]

#: First line of every generated page in docs/reference/blocks.
MARK = "<!-- generated from plc/lib, spec/ and docs/reference/blocks/snippets.toml by `make docs`"

#: Mark of a generated chart. It stands below the first line of the file.
CHART_MARK = "<!-- generated from docs/reference/blocks/snippets.toml by `make docs` -->"

_ZERO = {
    "BOOL": "FALSE",
    "REAL": "0.0",
    "TIME": "T#0s",
    "STRING": "''",
    "BYTE": "16#00",
    "WORD": "16#0000",
    "DWORD": "16#00000000",
}
_DIGITS = {"BYTE": 2, "WORD": 4, "DWORD": 8}
#: Tests that are run for every command block.
_OF_ALL_COMMANDS = ("tests/command/test_command_blocks.py",)
#: Greatest number of blocks that the page of an internal block lists as its users.
_SHOWN_USERS = 4
_WHOLE = "Complete program, stimulus, robot"


def block_chart(name: str) -> str:
    """Return the timing chart of a block's example as SVG."""
    run = run_of(name)
    if run.scaled:
        return run.scaled.chart(CHART_MARK)
    begin, end, rest = svg_chart(run.timeline, name).partition("\n")
    return f"{begin}{end}{CHART_MARK}\n{rest}"


def block_page(name: str) -> str:
    """Return the page of a block as Markdown."""
    pou = pous()[name]
    lines = [f"{MARK}; do not edit -->", "", f"# {name}", "", pou.does]
    for paragraph in pou.about:
        lines += ["", _linked(paragraph, name)]
    lines += [*(_instead(pou) if pou.internal else _choices(name)), "", *_facts(pou), *_pins(pou)]
    if name in snippets():
        lines += _example(run_of(name))
    elif name in without():
        lines += ["", f"No example of its own: {without()[name]}."]
    lines += [*_robot_side(pou), *_errors(pou), *_types(pou), *_see_also(pou)]
    return "\n".join(lines) + "\n"


def functions_page() -> str:
    """Return the page of the functions."""
    lines = [f"{MARK}; do not edit -->", "", "# Functions", ""]
    lines += ["Functions used by the blocks. A function has no memory.", ""]
    for pou in pous().values():
        if not pou.is_function:
            continue
        lines += [f"## {pou.name}", "", pou.does, ""]
        for paragraph in pou.about:
            lines += [_linked(paragraph, pou.name), ""]
        lines += [f"Returns {pou.result}. {_meant(pou)}".rstrip(), ""]
        lines += [*_table(_input_row(pou, pin) for pin in pou.of("VAR_INPUT")), ""]
        users = [_link_to(one.name) for one in pous().values() if pou.name in one.uses]
        lines += [f"- Source: {_file(pou.file)}", f"- Tests: {_tests(pou)}"]
        lines += [f"- Manual: {pou.section}"] if pou.section else []
        lines += [f"- Used by: {_several(users)}"] if users else []
        lines += [""]
    return "\n".join(lines)


def _meant(pou: Pou) -> str:
    errors = pou.errors()
    shown = ", ".join(f"`16#{error:04X}`" for error in errors)
    return f"Possible ErrorIDs: {shown} ([errors](../errors.md))." if errors else ""


# ---- head


def _facts(pou: Pou) -> Iterator[str]:
    yield "| | |"
    yield "|---|---|"
    yield f"| Source | {_file(pou.file)} |"
    yield f"| Tests | {_tests(pou)} |"
    only = f" -k {pou.name}" if pou.tests == _OF_ALL_COMMANDS else ""
    yield f"| Run them | `.venv/bin/python -m pytest {' '.join(pou.tests)}{only}` |"
    block = library().blocks.get(pou.name)
    if pou.section:
        titles = [f"{one.title} command" for one in block.commands] if block else []
        yield f"| Manual | {', '.join((_full(pou.section), *titles))} |"
    if block:
        shown = (f"[`{one.shown}` {one.name}](../commands.md#{one.name.lower()})"
                 for one in block.commands)  # fmt: skip
        yield f"| Remote command | {', '.join(shown)} |"
    charts = [one for one in processes().values() if pou.name in one.blocks]
    if charts:
        shown = (
            f"[{one.title}](../../explanation/processes.md#{_anchor(one.title)})" for one in charts
        )
        yield f"| Processes | {', '.join(shown)} |"
    if found := _examples(pou.name):
        yield f"| Examples | {', '.join(found)} |"
    if pou.internal:
        users = [one.name for one in pous().values() if pou.name in one.uses]
        yield f"| Part of | {_several(map(_link_to, users))} |"


@cache
def _example_texts() -> dict[Path, str]:
    files = sorted((ROOT / "plc/examples").rglob("*.st"))
    return {file: file.read_text(encoding="utf-8") for file in files}


def _examples(name: str) -> list[str]:
    """Return links to the complete programs that use a block."""
    used = re.compile(rf"\b{name}\b")
    return [
        f"[{file.parent.name}](../../../{file.relative_to(ROOT).as_posix()})"
        for file, text in _example_texts().items()
        if used.search(text)
    ]


def _full(section: str) -> str:
    """Return a reference to a section of the manual, with the name of its document."""
    if "guide" not in section:
        return f"EtherNet/IP user's manual, {section}"
    named = re.sub(r"^(?:remote command )?guide\b", "Remote command guide", section)
    return re.sub(r"; chapter", "; EtherNet/IP user's manual, chapter", named)


@cache
def _alternatives() -> list[dict[str, str]]:
    table: list[dict[str, str]] = load_toml(FOLDER / "choices.toml")["choice"]
    return table


def tasks() -> dict[str, list[str]]:
    """Return the blocks that a user needs for each task."""
    found: dict[str, list[str]] = load_toml(FOLDER / "tasks.toml")
    return found


def _choices(name: str) -> Iterator[str]:
    """Yield a table about the choice between the block and similar blocks."""
    rows: dict[str, str] = {}
    for choice in _alternatives():
        if name in choice:
            for other, text in ((name, choice[name]), *choice.items()):
                rows.setdefault(other, text)  # the first entry contains the general description
    if not rows:
        return
    yield "\n## When to use it\n\n| Block | What it does |\n|---|---|"
    for other, text in rows.items():
        yield f"| {f'**{name}**' if other == name else _link_to(other)} | {text} |"


def _instead(pou: Pou) -> Iterator[str]:
    """Yield the advice to use the public blocks that contain an internal block."""
    found: dict[str, Pou] = {}
    left = [pou.name]
    while left:
        for user in pous().values():
            if user.name not in found and left[0] in user.uses:
                found[user.name] = user
                left += [user.name] if user.internal else []
        left.pop(0)
    blocks = [_link_to(user.name) for user in found.values() if not user.internal]
    yield "\n## When to use it\n"
    yield "Your program does not call this block."
    if blocks:
        shown = blocks[:_SHOWN_USERS]
        more = f" and {len(blocks) - len(shown)} more blocks" if len(blocks) > len(shown) else ""
        instead = "that block" if len(blocks) == 1 else "one of those blocks"
        yield f"It is a part of {', '.join(shown)}{more}. Call {instead} instead."


def _tests(pou: Pou) -> str:
    return ", ".join(_file(ROOT / test) for test in pou.tests)


# ---- pins


def _pins(pou: Pou) -> Iterator[str]:
    inputs = pou.of("VAR_IN_OUT", "VAR_INPUT")
    if inputs:
        yield "\n## Inputs\n"
        yield from _table(_input_row(pou, pin) for pin in inputs)
    outputs = pou.of("VAR_OUTPUT")
    if outputs:
        yield "\n## Outputs\n"
        yield "| Pin | Type | Unit | Meaning |\n|---|---|---|---|"
        for pin in outputs:
            yield f"| `{pin.name}` | {_type(pin)} | {pin.unit} | {_cell(pin.comment)} |"


def _table(rows: Iterable[str]) -> Iterator[str]:
    yield "| Pin | Type | Default | Unit | Range | Meaning |"
    yield "|---|---|---|---|---|---|"
    yield from rows


def _input_row(pou: Pou, pin: Pin) -> str:
    if pin.section == "VAR_IN_OUT":
        text = {"Robot": "the robot; one variable for all blocks", "Image": "your process image"}
        said = _cell(pin.comment) or text.get(pin.name, "")
        return f"| `{pin.name}` | {_type(pin)} | in and out | | | {said} |"
    limits = _cell(range_of(pou, pin))
    default = f"`{_default(pin)}`" if _default(pin) else ""
    cells = (f"`{pin.name}`", _type(pin), default, pin.unit, limits, _cell(pin.comment))
    return f"| {' | '.join(cells)} |"


def _default(pin: Pin) -> str:
    if pin.default:
        return pin.default
    if pin.type in kinds():
        kind = kinds()[pin.type]
        if kind.members:
            return next(iter(kind.members))
        return f"all {_ZERO.get(kind.element, '0')}" if kind.count else ""
    return _ZERO.get(pin.type, "0")


def _type(pin: Pin) -> str:
    kind = kinds().get(pin.type)
    return f"[{pin.type}]({_path(kind.file)})" if kind else pin.type


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("docs/reference/errors.md", "[errors](#errors)")


# ---- example


def _example(run: Run) -> Iterator[str]:
    snippet = run.snippet
    yield "\n## Example\n"
    yield f"```iecst\n{_code(snippet)}\n```\n"
    yield ladder_text(snippet.pou.name)
    if snippet.about:
        yield f"{snippet.about}\n"
    files = [f"programs/{snippet.path.name}", f"programs/{snippet.stimulus_path.name}"]
    links = ", ".join(f"[{Path(one).name}]({one})" for one in [*files, f"programs/{snippet.robot}"])
    yield f"{_WHOLE}: {links}. To run it:\n"
    yield "\n".join(f"    {line}" for line in snippet.command(run.seconds).splitlines())
    yield f"\n### Timing\n\n![Timing chart of the example](charts/{snippet.pou.name}.svg)\n"
    yield _timing(run)
    if run.outputs:
        when = "At the end of this run" if snippet.last else _at_end(snippet)
        yield f"\n### Result\n\n{when}:\n\n| Pin | Value |\n|---|---|"
        types = {pin.name: pin.type for pin in snippet.pou.pins}
        for name, value in run.outputs.items():
            yield f"| `{name}` | `{_value(value, types[name])}` |"


def _robot_side(pou: Pou) -> Iterator[str]:
    """Yield the robot program for the block, as text that users can copy."""
    for file in sorted((ROOT / "plc/robot").glob("*.PGM")):
        if any(file.name in paragraph for paragraph in pou.about):
            text = file.read_text(encoding="utf-8").strip()
            yield f"\n## Robot program\n\n{_file(file)}, to paste into your robot program:\n"
            yield f"```text\n{text}\n```"


def _at_end(snippet: Snippet) -> str:
    if snippet.pou.pin("Done"):
        return "With `Done`"
    return "With `Valid`" if snippet.pou.pin("Enable") else "300 ms after `Start`"


def _timing(run: Run) -> str:
    pou = run.snippet.pou
    begin, end = ("Execute", "Done") if pou.pin("Done") else ("Enable", "Valid")
    took = ""
    if run.took_us is not None:
        took = f"From `{begin}` to `{end}` it took {run.took_us / 1000:g} ms. "
    less = f" Not shown: {', '.join(run.left_out)}." if run.left_out else ""
    return (
        f"{took}Scan and RPI are 10 ms. The times are those of the virtual controller; a real "
        f"controller may be faster or slower ([fidelity](../../explanation/fidelity.md)).{less}"
    )


def _code(snippet: Snippet) -> str:
    """Return the lines of a program that an example has added to it."""
    text = program(snippet)
    names = {step.instance for step in snippet.steps}
    for step in snippet.steps:
        names |= {name for name, one in step.inputs.items() if isinstance(one, (list, dict))}
        names |= {pin.name for pin in own_pins(step.block)}
    declared = text.partition("  VAR\n")[2].partition("  END_VAR")[0].splitlines()
    rows = [line[4:] for line in declared if line.split()[0] in names]
    body = text.partition("END_VAR\n\n")[2].partition("END_PROGRAM")[0]
    if not shows_all(snippet):
        begin, end = body.index("\n\n") + 2, body.rindex("\n\n")
        body = body[begin:end]
    lines = [line.removeprefix("  ") for line in body.strip("\n").splitlines()]
    head = ["VAR", *(f"  {re.sub(' +:', ' :', row)}" for row in rows), "END_VAR", ""]
    return "\n".join([*(head if rows else []), *lines])


def _value(value: Any, kind: str) -> str:
    known = kinds().get(kind)
    if isinstance(value, list):
        element = known.element if known else ""
        between = "`<br>`" if value and isinstance(value[0], dict) else ", "
        return between.join(_value(one, element) for one in value)
    if isinstance(value, dict):
        return _structure(value, known.fields if known else {})
    if isinstance(value, bool):
        return str(value).upper()
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, timedelta):
        return f"T#{value // timedelta(milliseconds=1)}ms"
    if kind in _DIGITS:
        return f"16#{value:0{_DIGITS[kind]}X}"
    return f"'{value}'" if kind == "STRING" else str(value)


def _structure(value: Mapping[str, Any], types: Mapping[str, str]) -> str:
    """Return the fields of a structure as text in parentheses, without zero values."""
    given = [(name, one) for name, one in value.items() if one]
    if all(isinstance(one, bool) for _, one in given):
        return f"({', '.join(name for name, _ in given)} TRUE)" if given else "(nothing)"
    return f"({', '.join(f'{name} {_value(one, types.get(name, str()))}' for name, one in given)})"


# ---- errors, types, related blocks


@cache
def _error_table() -> dict[int, dict[str, Any]]:
    return {one["id"]: one for one in load_toml(spec.folder() / "errors.toml")["error"]}


def _errors(pou: Pou) -> Iterator[str]:
    pin = pou.pin("ErrorID")
    if pin is None or pin.section != "VAR_OUTPUT" or not pou.errors():
        return
    yield "\n## Errors\n"
    yield "| ErrorID | Name | Cause | Remedy |\n|---|---|---|---|"
    for error in pou.errors():
        one = _error_table()[error]
        yield f"| `16#{error:04X}` | {one['name']} | {one['cause']} | {one['remedy']} |"
    if pou.pin("WorkErrorID"):
        yield "\nAn ErrorID of `WorkErrorID` is shown unchanged."
    if pou.pin("AlarmGroup"):
        yield "\nWith `16#8020`, `AlarmGroup` and `AlarmCategory` are the number of the alarm. The"
        yield "[panel sheet](../panel.html) lists the alarms that the manual names."


def _types(pou: Pou) -> Iterator[str]:
    used = list(dict.fromkeys(pin.type for pin in pou.pins if pin.type in kinds()))
    elements = [kinds()[name].element for name in used]
    rows = [name for name in elements if name in kinds() and kinds()[name].fields]
    elements += [kind for name in rows for kind in kinds()[name].fields.values()]
    used += [name for name in dict.fromkeys(elements) if name in kinds() and name not in used]
    shown = [name for name in used if kinds()[name].members or kinds()[name].count or name in rows]
    shown = [name for name in shown if not name.startswith("RCX_IMAGE")]
    if not shown:
        return
    yield "\n## Types\n"
    for name in shown:
        kind = kinds()[name]
        if kind.count:
            what = f"array of {kind.count} {kind.element}, {kind.does}"
            yield f"- [{name}]({_path(kind.file)}): {what}"
            continue
        yield f"- [{name}]({_path(kind.file)}): {kind.does}"
        yield from (f"  - `{member}`: {said}" for member, said in kind.members.items())


def _see_also(pou: Pou) -> Iterator[str]:
    near = _neighbours(pou)
    if near:
        yield "\n## See also\n"
        yield from (f"- {_link_to(name)}: {_short(pous()[name].does)}" for name in near)
    yield "\nAll blocks: [blocks.md](../blocks.md)."


def _neighbours(pou: Pou) -> list[str]:
    """Return related blocks.

    Two blocks are related if one names the other, if both have the same section of the guide, or if
    they are twins for bytes and words.
    """
    found = [name for name in pou.said if name in pous()]
    names = [one.name for one in pous().values() if pou.name in one.said]
    twin = (
        pou.name.removesuffix("InWords") if pou.name.endswith("InWords") else f"{pou.name}InWords"
    )
    turned = re.sub(r"^FB_(Read|Write|Set|Change)", "", pou.name)
    pairs = [f"FB_{verb}{turned}" for verb in ("Read", "Write", "Set", "Change")]
    commands = [
        one.name
        for one in pous().values()
        if pou.folder == "command" and one.section == pou.section and "guide" in pou.section
    ]
    near = dict.fromkeys([*found, *names, twin, *pairs, *commands])
    plain = {"FB_ReadArea", "FB_WriteArea"}
    return [
        name
        for name in near
        if name in pous()
        and name != pou.name
        and name not in plain
        and (pou.internal or not pous()[name].internal)
        and not pous()[name].is_function
    ]


def _short(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:].rstrip(".")


# ---- links


def _linked(text: str, own: str) -> str:
    """Return the text with the names of blocks as links."""

    def link(match: re.Match[str]) -> str:
        name = match[0]
        return _link_to(name) if name in pous() and name != own else name

    return re.sub(r"\bF[BC]_\w+\b", link, text)


def _link_to(name: str) -> str:
    if pous()[name].is_function:
        return f"[{name}](functions.md#{name.lower()})"
    return f"[{name}]({name}.md)"


def _file(path: Path) -> str:
    return f"[{path.name}]({_path(path)})"


def _path(path: Path) -> str:
    return f"../../../{path.relative_to(ROOT).as_posix()}"


def _several(texts: Iterable[str]) -> str:
    found: Sequence[str] = list(texts)
    most = 8
    if len(found) > most:
        return f"{', '.join(found[:most])} and {len(found) - most} more"
    return ", ".join(found)


def _anchor(title: str) -> str:
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")
