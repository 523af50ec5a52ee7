"""Generator of the section about dialects in language.md, from the table of the engine."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from structured_text.language.dialects import Row, dialects, rows

__all__ = ["language_page", "section"]

_BEGIN = "<!-- dialects: generated from harness/structured_text/language/dialects.toml -->"
_END = "<!-- end of dialects -->"

_ABOUT = """\
The format of a project says to which tool it belongs: TwinCAT objects, PLCopen XML of CODESYS,
TwinCAT, Beremiz or OpenPLC (by its header), an L5X, SCL. `.st` files below an `apax.yml` are of
SIMATIC AX. For other `.st` files, or to choose another tool, use `--dialect` of `rcx run`, `check`,
`debug`, `test`, `explore`, `prove`, `campaign`, `sweep` and `mutants`, `rcx_dialect` of pytest, or
`dialect=` of `Cell.build` and `Bench.build`. One program has one dialect. If its files are of two
tools, you must choose one.

    rcx run plc --dialect codesys

| Name | Tools |
|---|---|"""

_TABLE = """
The built-in engine, the debugger, coverage and `rcx prove` compute as the tool does. matiec and
STruC++ do not support dialects. Therefore `auto` uses the built-in engine for all dialects except
`iec` and `openplc`, with a message. It does the same if there are tasks and also a program without
a task. If you choose another engine, a message says that it does not compute in the dialect. matiec
counts as `openplc` does. If the result of a counter in an `iec` program may differ for this reason,
the line is reported, as for the other [faults of matiec](engines.md#faults-of-matiec).

| Question | Dialects | What is computed | Source |
|---|---|---|---|"""


def language_page(page: Path) -> str:
    """Return language.md with the current section between the marks."""
    text = page.read_text(encoding="utf-8")
    between = re.compile(f"{re.escape(_BEGIN)}.*?{re.escape(_END)}", re.DOTALL)
    body = "\n".join(section())
    return between.sub(lambda _: f"{_BEGIN}\n\n{body}\n\n{_END}", text)


def section() -> Iterator[str]:
    """Yield the lines of the section about dialects, without its title."""
    yield _ABOUT
    for name, tools in dialects().items():
        yield f"| `{name}` | {tools} |"
    yield _TABLE
    asked = ""
    for row in rows():
        yield _line(row, "" if row.rule == asked else row.title)
        asked = row.rule
    yield ""
    for title, also in dict.fromkeys((row.title, row.also) for row in rows() if row.also):
        yield f"- {title}: {also}"


def _line(row: Row, title: str) -> str:
    tools = ", ".join(f"`{tool}`" for tool in row.tools)
    return f"| {title} | {tools} | {row.meaning} | {row.source} |"
