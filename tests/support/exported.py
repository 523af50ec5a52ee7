"""Exports for the tests, and functions for properties that export and import must preserve."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

from example_runs import EXAMPLES, changes, recorded_trace
from rcx_harness.cell.exports import sources_of
from rcx_tools.docs.examples import Example, examples
from structured_text.export import TARGETS
from structured_text.export.output import Output, write
from structured_text.export.parts import Sources
from structured_text.language import syntax as s
from structured_text.language.parser import parse
from structured_text.language.standard import FUNCTIONS
from structured_text.projects.open import read_project
from structured_text.projects.texts import st_texts

#: The first example, and a block that exports treat specially.
SAMPLE = [EXAMPLES[0].folder, Path(__file__).parents[1] / "export/data/FB_Sample.st"]

#: Examples with features that an export can lose: arrays of structures, words, texts, user blocks.
EXPORTED = [one for one in EXAMPLES if one.name[:2] in ("01", "02", "03", "06", "12")]


def left_out(output: Output) -> tuple[str, ...]:
    """Return the parts that the export has left out, each with the reason."""
    return tuple(f"{one.what}: {one.why}" for one in output.missing)


@cache
def library() -> Sources:
    """Return the library, which is read and checked once."""
    return sources_of()


@cache
def sample(*, whole: bool = False) -> Sources:
    """Return `SAMPLE` with the library parts that it needs, or with the whole library."""
    return sources_of(program=SAMPLE, only_needed=not whole)


@cache
def example_sources(name: str) -> Sources:
    """Return an example with the library parts that it needs."""
    return sources_of(program=[examples()[name].folder], only_needed=True)


@cache
def written(target: str, *, whole: bool = False) -> Output:
    """Return the export of `sample` to a target. Each export is made once."""
    return TARGETS[target].write(sample(whole=whole))


def imported(project: Path, folder: Path) -> list[Path]:
    """Import a project as `rcx import` does, and return the files."""
    files = sorted(project.rglob("*.Tc*")) if project.is_dir() else [project]
    return write(Output(st_texts(read_project(files))), folder)


def shapes(files: Iterable[Path]) -> dict[str, Any]:
    """Return the declarations of the files by name: syntax trees without positions in the text."""
    return {node.name.text: shape(node) for file in files for node in parse(file).declarations}


def comments(files: Iterable[Path]) -> list[str]:
    """Return the words of all comments of the files in alphabetical order."""
    found = []
    for file in files:
        for text in re.findall(r"\(\*(.*?)\*\)", file.read_text(encoding="utf-8"), re.DOTALL):
            found += [word for word in text.split() if word != "*"]
    return sorted(found)


def trace_of(example: Example, program: list[Path], folder: Path) -> list[str]:
    """Return the changes in an example's trace, with the program taken from other files.

    Args:
        example: The example, which gives the robot, the events and the duration of the run.
        program: All files of the program; the library is not searched.
        folder: Folder in which an empty library is made.
    """
    empty = folder / "no-library"
    empty.mkdir()
    with example.build("builtin", program=program, lib=empty) as cell:
        cell.run(example.duration)
        return list(changes(cell.trace.lines()))


def recorded(example: Example) -> list[str]:
    """Return the changes in the recorded trace of an example."""
    return recorded_trace(example).read_text(encoding="utf-8").splitlines()[1:]


def shape(node: Any) -> Any:
    """Return a syntax tree as nested lists and tuples, without line and column numbers."""
    if isinstance(node, s.Position):
        return None
    if isinstance(node, tuple):
        return [one for item in node for one in _single(item)]
    if is_dataclass(node):
        values = [shape(getattr(node, field.name)) for field in fields(node)]
        return (type(node).__name__, *values)
    return node


def by_position(node: Any) -> Any:
    """Return a nested syntax tree without argument names in calls of standard functions."""
    if isinstance(node, dict):
        return {name: by_position(one) for name, one in node.items()}
    if isinstance(node, list):
        return [by_position(one) for one in node]
    if isinstance(node, tuple) and node and node[0] == "Call" and node[1][1] in FUNCTIONS:
        given = [("Argument", None, by_position(one[2]), *one[3:]) for one in node[2]]
        return ("Call", node[1], given, *node[3:])
    return tuple(map(by_position, node)) if isinstance(node, tuple) else node


def _single(item: Any) -> list[Any]:
    """Split a declaration: `a, b : INT` is `a : INT; b : INT`."""
    if isinstance(item, s.VarDecl) and len(item.names) > 1:
        rest = (item.spec, item.initial, item.address, item.at)
        return [shape(s.VarDecl((name,), *rest)) for name in item.names]
    return [shape(item)]
