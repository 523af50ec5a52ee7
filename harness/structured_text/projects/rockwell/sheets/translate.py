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
    places = {node.id: place for place, node in enumerate(order)}
    written = _Written()
    for node in outputs:
        written.add(targets[node.id], len(order))
    for place, node in enumerate(order):
        written.add(_named(node, blocks.written), place)
    behind: dict[str, list[Node]] = {}
    last = []
    for node in outputs:
        own = next((places.get(feed.node.id) for _, feed in graph.inputs(node)), None)
        if own is None or written.meets(targets[node.id], own, own=True):
            last.append(node)
        else:
            behind.setdefault(order[own].id, []).append(node)
    found: list[Node] = []
    for node in order:
        found += [node, *behind.get(node.id, ())]
    return [*found, *last]


def _changing(order: Iterable[Node], graph: Graph, blocks: Blocks) -> list[Node]:
    """Return the input references whose tags may be written before their last use."""
    found: dict[str, Node] = {}
    written = _Written()
    for place, node in enumerate(order):
        is_output = node.kind == "ORef"
        own = _named(node, blocks.paths if is_output else blocks.written)
        if not is_output:  # a block with a structure of data assigns its inputs one by one
            written.add(own if own is not None else (), place)
        for _, feed in graph.inputs(node):
            source = feed.node
            if source.kind != "IRef" or source.id in found:
                continue
            if written.meets(_named(source, blocks.paths), 0):
                found[source.id] = source
        written.add(own, place)
    return list(found.values())


class _Written:
    """The tags that elements write, by their names, each with the place of the element."""

    def __init__(self) -> None:
        self._paths: dict[str, dict[Path, list[int]]] = {}
        #: The place of the last element that may write any tag.
        self._anything = -1

    def add(self, paths: Iterable[Path] | None, place: int) -> None:
        """Add the tags that an element writes; None for any tag."""
        if paths is None:
            self._anything = place
            return
        for path in paths:
            self._paths.setdefault(path[0], {}).setdefault(path, []).append(place)

    def meets(self, paths: Iterable[Path], first: int, *, own: bool = False) -> bool:
        """Return whether an element from a place on may write one of some tags.

        If `own` is true, the tags are in the table themselves, once.
        """
        if self._anything >= first:
            return True
        for path in paths:
            known = self._paths.get(path[0], {})
            places = [place for other in known if meet((path,), (other,)) for place in known[other]]
            if sum(place >= first for place in places) > own:
                return True
        return False


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
