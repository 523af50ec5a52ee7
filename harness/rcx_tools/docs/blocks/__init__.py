"""Generators of docs/reference/blocks: each block gets a page, and an example with run and chart.

The sources are the heads and pins in plc/lib, the tables in spec/, and
docs/reference/blocks/snippets.toml.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from rcx_tools.docs.blocks.examples import program, snippets, stimulus
from rcx_tools.docs.blocks.ladders import LADDER_MARK, block_ladder
from rcx_tools.docs.blocks.page import (
    CHART_MARK,
    MARK,
    block_chart,
    block_page,
    functions_page,
    tasks,
)
from rcx_tools.docs.blocks.source import ROOT, pous

__all__ = ["files", "files_of", "leftovers", "tasks"]

_GENERATED = (
    MARK,
    "# Generated from docs/reference/blocks",
    " * Generated from docs/reference/blocks",
    CHART_MARK,
    LADDER_MARK,
)


def files() -> dict[str, Callable[[], str]]:
    """Return the generators of docs/reference/blocks, by the path of the file."""
    written: dict[str, Callable[[], str]] = {"docs/reference/blocks/functions.md": functions_page}
    for name, pou in pous().items():
        if not pou.is_function:
            written |= files_of(name)
    return written


def files_of(name: str) -> dict[str, Callable[[], str]]:
    """Return the generators of a block: its page, and the files of its example.

    These are program, stimulus, chart and ladder.
    """
    written: dict[str, Callable[[], str]] = {
        f"docs/reference/blocks/{name}.md": partial(block_page, name)
    }
    snippet = snippets().get(name)
    if snippet:
        for path, render in ((snippet.path, program), (snippet.stimulus_path, stimulus)):
            written[path.relative_to(ROOT).as_posix()] = partial(render, snippet)
        written[f"docs/reference/blocks/charts/{name}.svg"] = partial(block_chart, name)
        written[f"docs/reference/blocks/ladders/{name}.svg"] = partial(block_ladder, name)
    return written


def leftovers(root: Path = ROOT) -> list[str]:
    """Return generated files that no generator makes any more, such as the page of a removed block.

    Only files with the mark of a generated file are returned, as paths relative to `root`.
    """
    written = files()
    found = []
    for file in sorted((root / "docs/reference/blocks").rglob("*.*")):
        path = file.relative_to(root).as_posix()
        if path not in written and file.is_file():
            head = file.read_text(encoding="utf-8")[:400]
            if any(mark in head for mark in _GENERATED):
                found.append(path)
    return found
