"""Parts of a ladder that CODESYS executes in its own way, in terms of the standard.

A parallel branch of CODESYS with a block in some of its lines is a short circuit: the lines without
a block are evaluated first, and if one of them is TRUE, the blocks of the other lines are not
executed. Each of these blocks gets an EN that is FALSE in this case.

A comparison with EN in a rung has no ENO: its output is the power behind it. It is FALSE while EN
is FALSE.

Source: CODESYS help, LD element "Closed Branch" (Beckhoff: "Closed line branch").
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from structured_text.projects.diagrams.networks.check import inputs_of
from structured_text.projects.diagrams.networks.model import (
    Block,
    Connection,
    Element,
    Input,
    Output,
    Rail,
)

__all__ = ["Branch", "with_bypasses", "with_power"]

_COMPARISONS = ("GT", "GE", "EQ", "LE", "LT", "NE")


@dataclass(frozen=True)
class Branch:
    """A parallel branch.

    Attributes:
        id: Its number in the file.
        starts: The lines to its left side.
        ends: The lines to its right side, for each of its lines from top to bottom.
        short: Whether it is a short circuit.
    """

    id: str
    starts: tuple[Connection, ...]
    ends: tuple[tuple[Connection, ...], ...]
    short: bool = True


def with_bypasses(elements: Sequence[Element], branches: Sequence[Branch]) -> list[Element]:
    """Return the elements; blocks in short circuits are executed on a condition."""
    found = list(elements)
    for branch in branches:
        if branch.short:
            found = _with_bypass(found, branch)
    return found


def _with_bypass(elements: list[Element], branch: Branch) -> list[Element]:
    known = {one.id: one for one in elements}
    stops = {line.source for line in branch.starts}
    skipped: dict[str, None] = {}
    free: list[Connection] = []
    for tree in branch.ends:
        blocks = [one.id for one in _behind(tree, known, stops) if _acts(one)]
        skipped.update(dict.fromkeys(blocks))
        if not blocks:
            free += tree
    if not skipped or not free:
        return elements
    name = f"{branch.id}.free"
    made: list[Element] = []
    for one in elements:
        if not isinstance(one, Block) or one.id not in skipped:
            made.append(one)
            continue
        if not any(found.id == name for found in made):
            pin = Input("IN", tuple(free))
            made.append(_block(one, name, "NOT", pin))
        line = Connection(name, "OUT")
        old = next((pin for pin in one.inputs if pin.name.upper() == "EN"), None)
        if old is not None:
            made.append(
                _block(
                    one, f"{name}.{one.id}", "AND", replace(old, name="IN1"), Input("IN2", (line,))
                )
            )
            line = Connection(f"{name}.{one.id}", "OUT")
        others = tuple(pin for pin in one.inputs if pin is not old)
        made.append(replace(one, inputs=(Input("EN", (line,)), *others)))
    return made


def _behind(
    lines: Sequence[Connection], known: dict[str, Element], stops: set[str]
) -> Iterator[Element]:
    """Yield the elements between the left side of a branch and the end of one of its lines."""
    waiting, seen = [line.source for line in lines], set(stops)
    while waiting:
        name = waiting.pop()
        if name in seen or name not in known:
            continue
        seen.add(name)
        yield known[name]
        waiting += [line.source for pin in inputs_of(known[name]) for line in pin.connections]


def _acts(element: Element) -> bool:
    """Return whether an element does something besides its output."""
    return isinstance(element, Block) and bool(
        element.instance or element.statements or any(pin.target for pin in element.outputs)
    )


def with_power(elements: Sequence[Element]) -> list[Element]:
    """Return the elements; a comparison with EN and without ENO becomes a series with its EN."""
    rails = {one.id for one in elements if isinstance(one, Rail)}
    made: list[Element] = []
    for one in elements:
        if not isinstance(one, Block) or not _is_power(one):
            made.append(one)
            continue
        enable = one.inputs[0]
        compared = replace(one, inputs=one.inputs[1:])
        if any(line.source in rails for line in enable.connections) and not enable.negated:
            made.append(compared)
            continue
        inner = f"{one.id}.compared"
        made.append(replace(compared, id=inner, outputs=(Output("OUT"),)))
        series = Input("IN2", (Connection(inner, "OUT"),), negated=one.outputs[0].negated)
        made.append(
            replace(
                _block(one, one.id, "AND", replace(enable, name="IN1"), series),
                outputs=(replace(one.outputs[0], negated=False),),
            )
        )
    return made


def _is_power(block: Block) -> bool:
    return (
        block.type.upper() in _COMPARISONS
        and len(block.outputs) == 1
        and bool(block.inputs)
        and block.inputs[0].name.upper() == "EN"
        and bool(block.inputs[0].connections)
    )


def _block(like: Block, name: str, kind: str, *inputs: Input) -> Block:
    """Return a new function in the place of a block."""
    return Block(
        name,
        like.network,
        position=like.position,
        at=like.at,
        type=kind,
        inputs=inputs,
        outputs=(Output("OUT"),),
    )
