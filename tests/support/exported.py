"""What two sets of sources must have in common to be the same program."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from example_runs import EXAMPLES, changes, recorded_trace
from rcx_tools.docs.examples import Example
from structured_text.language import syntax as s
from structured_text.language.parser import parse
from structured_text.language.standard import FUNCTIONS

__all__ = ["EXPORTED", "by_position", "comments", "recorded", "shape", "shapes", "trace_of"]

#: Examples with what an export can lose: arrays of structures, words, texts, a block of the user's.
EXPORTED = [one for one in EXAMPLES if one.name[:2] in ("01", "02", "03", "06", "12")]


def shapes(files: Iterable[Path]) -> dict[str, Any]:
    """What the files declare, by name: the syntax trees without the places in the text."""
    return {node.name.text: shape(node) for file in files for node in parse(file).declarations}


def comments(files: Iterable[Path]) -> list[str]:
    """The words of all comments, in the order of the alphabet."""
    found = []
    for file in files:
        for text in re.findall(r"\(\*(.*?)\*\)", file.read_text(encoding="utf-8"), re.DOTALL):
            found += [word for word in text.split() if word != "*"]
    return sorted(found)


def trace_of(example: Example, program: list[Path], folder: Path) -> list[str]:
    """What is new in each line of an example's trace, its program taken from other files.

    Args:
        example: Says what happens to the program.
        program: All its files; the library is not looked for.
        folder: For an empty library.
    """
    empty = folder / "no-library"
    empty.mkdir()
    with example.build("builtin", program=program, lib=empty) as cell:
        cell.run(example.duration)
        return list(changes(cell.trace.lines()))


def recorded(example: Example) -> list[str]:
    """The same of its recorded trace."""
    return recorded_trace(example).read_text(encoding="utf-8").splitlines()[1:]


def shape(node: Any) -> Any:
    """A syntax tree as nested lists and tuples, without the places in the text."""
    if isinstance(node, s.Position):
        return None
    if isinstance(node, tuple):
        return [one for item in node for one in _single(item)]
    if is_dataclass(node):
        values = [shape(getattr(node, field.name)) for field in fields(node)]
        return (type(node).__name__, *values)
    return node


def by_position(node: Any) -> Any:
    """A shape in which calls of standard functions have lost the names of their arguments."""
    if isinstance(node, dict):
        return {name: by_position(one) for name, one in node.items()}
    if isinstance(node, list):
        return [by_position(one) for one in node]
    if isinstance(node, tuple) and node and node[0] == "Call" and node[1][1] in FUNCTIONS:
        given = [("Argument", None, by_position(one[2]), *one[3:]) for one in node[2]]
        return ("Call", node[1], given, *node[3:])
    return tuple(map(by_position, node)) if isinstance(node, tuple) else node


def _single(item: Any) -> list[Any]:
    """`a, b : INT` is `a : INT; b : INT`."""
    if isinstance(item, s.VarDecl) and len(item.names) > 1:
        rest = (item.spec, item.initial, item.address, item.at)
        return [shape(s.VarDecl((name,), *rest)) for name in item.names]
    return [shape(item)]
