"""The translation of a function block diagram of Logix to Structured Text.

Each block becomes a statement, in the order of execution: an instruction with a structure of its
own is the call of a function block, others assign the inputs and the result of their structure. The
value of a function without a structure is in a variable. A routine latches the values of its input
references when it begins, and writes its output references when all blocks are executed. If nothing
can see a difference, the translation reads a tag later, and writes it earlier.

Source: Rockwell 1756-PM009E, latching data and order of execution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from textwrap import wrap
from typing import TypeVar

from structured_text.errors import InputError
from structured_text.language.source import Line
from structured_text.projects.model import Lines, in_comment
from structured_text.projects.rockwell.ladder.call import Body
from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.ladder.paths import Path, meet
from structured_text.projects.rockwell.sheets.model import Node, Routine, title_of
from structured_text.projects.rockwell.sheets.order import Graph
from structured_text.projects.rockwell.sheets.statements import Blocks

__all__ = ["translated_sheets"]

_T = TypeVar("_T")
_INDENT = "  "
#: Longest line of a sheet's description.
_WIDTH = 80
#: Longest line of a statement.
_LONGEST = 96


def translated_sheets(routine: Routine, body: Body) -> Lines:
    """Return the statements of a routine, or raise LadderError that names sheet and block."""
    graph = Graph(routine)
    order = graph.executed()
    _check_tags(order)
    blocks = Blocks(body, graph)
    back = {key for key, _ in graph.feeds_back()}
    for node in order:
        if node.kind == "Function" and node.id in back:
            _named(node, blocks.remember)
    order = _with_outputs(order, graph, blocks)
    made = [(node, [_named(node, blocks.latch)]) for node in _changing(order, graph, blocks)]
    for node in order:
        translate = blocks.assigned if node.kind == "ORef" else blocks.statements
        made.append((node, _named(node, translate)))
    return tuple(_with_headings(made, routine))


def _named(node: Node, translate: Callable[[Node], _T]) -> _T:
    """Return the translation of an element; an error names the sheet and the element."""
    place = f"{title_of(node.sheet)}: {node.title}"
    try:
        return translate(node)
    except LadderError as error:
        raise LadderError(f"{place}: {error.message}", error.at, error.hint) from None
    except InputError as error:
        raise LadderError(f"{place}: {error.message}", error.line or node.at, error.hint) from None


def _check_tags(order: Iterable[Node]) -> None:
    """Raise LadderError if two blocks have the same tag."""
    seen: dict[str, Node] = {}
    for node in order:
        if node.operand and seen.setdefault(node.operand.upper(), node) is not node:
            text = f"{title_of(node.sheet)}: {node.title}: another block has the same tag"
            raise LadderError(text, node.at, "give each block a tag of its own")


def _with_outputs(order: Sequence[Node], graph: Graph, blocks: Blocks) -> list[Node]:
    """Return the blocks with the output references.

    An output reference is written behind all blocks. It stands behind its own block if no other
    element can see the difference; input references are latched in any case.
    """
    outputs = graph.outputs()
    targets = {node.id: _named(node, blocks.paths) for node in outputs}
    written = [_named(node, blocks.written) for node in order]
    places = {node.id: place for place, node in enumerate(order)}
    behind: dict[str, list[Node]] = {}
    last = []
    for node in outputs:
        place = next((places.get(feed.node.id) for _, feed in graph.inputs(node)), None)
        others = [paths for key, paths in targets.items() if key != node.id]
        later: list[frozenset[Path] | None] = [*(written[place:] if place is not None else ())]
        if place is None or any(
            paths is None or meet(targets[node.id], paths) for paths in (*later, *others)
        ):
            last.append(node)
        else:
            behind.setdefault(order[place].id, []).append(node)
    found: list[Node] = []
    for node in order:
        found += [node, *behind.get(node.id, ())]
    return [*found, *last]


def _changing(order: Iterable[Node], graph: Graph, blocks: Blocks) -> list[Node]:
    """Return the input references whose tags may be written before their last use."""
    found: dict[str, Node] = {}
    written: set[Path] = set()
    anything = False
    for node in order:
        is_output = node.kind == "ORef"
        own = _named(node, blocks.paths if is_output else blocks.written)
        for _, feed in graph.inputs(node):
            source = feed.node
            if source.kind != "IRef" or source.id in found:
                continue
            # A block with a structure of data assigns its inputs one after the other.
            before = written if is_output else {*written, *(own or ())}
            if anything or meet(_named(source, blocks.paths), before):
                found[source.id] = source
        anything = anything or own is None
        written |= own or frozenset()
    return list(found.values())


def _with_headings(made: Iterable[tuple[Node, list[str]]], routine: Routine) -> Iterator[Line]:
    """Yield the lines with a comment where another sheet begins."""
    said = {sheet.number: sheet.description for sheet in routine.sheets}
    before = 0
    for node, texts in made:
        if texts and node.sheet != before:
            texts = [*_heading(node.sheet, said.pop(node.sheet, "")), *texts]
            before = node.sheet
        for text in chain.from_iterable(map(_broken, texts)):
            yield Line(f"{_INDENT}{text}", node.at, network=title_of(node.sheet))


def _broken(text: str) -> list[str]:
    """Return a statement in several lines if it is long."""
    if len(text) <= _LONGEST or "'" in text or text.startswith("(*"):
        return [text]
    return wrap(
        text,
        _LONGEST,
        subsequent_indent=_INDENT,
        break_long_words=False,
        break_on_hyphens=False,
        drop_whitespace=True,
    )


def _heading(number: int, description: str) -> list[str]:
    title = title_of(number).capitalize()
    wrapped = [text for line in in_comment(description).splitlines() for text in wrap(line, _WIDTH)]
    if not wrapped:
        return [f"(* {title} *)"]
    first, *others = wrapped
    lines = [f"(* {title}: {first}", *(f"   {text}" for text in others)]
    return [*lines[:-1], f"{lines[-1]} *)"]
