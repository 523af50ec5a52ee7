"""The lines of a routine through its connectors, and the order in which its blocks are executed.

A block is executed after the blocks that feed it. A wire with the mark Assume Data Available, and
a wire from a block to itself, pass the value of the last scan: the block at its right end is
executed first, unless other wires need the other order. Blocks that are not wired together have no
order on the controller; here they are executed sheet after sheet, from top to bottom.

Source: Rockwell 1756-PM009E, order of execution; Studio 5000 help, function block attributes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.sheets.model import BLOCKS, Node, Routine, title_of

__all__ = ["Feed", "Graph"]


@dataclass(frozen=True)
class Feed:
    """What a pin gets its value from: an element with an output, and its pin.

    `feedback` is true if it is the value of the last scan.
    """

    node: Node
    output: str
    feedback: bool


class Graph:
    """The lines of a routine."""

    def __init__(self, routine: Routine) -> None:
        self._routine = routine
        self._nodes = {node.id: node for node in routine.nodes}
        self._wires = {(wire.target, wire.input.upper()): wire for wire in routine.wires}
        self._pins: dict[str, list[str]] = {}
        for wire in routine.wires:
            self._pins.setdefault(wire.target, []).append(wire.input)
        self._connectors: dict[str, Node] = {}
        for node in routine.nodes:
            if node.kind == "OCon":
                other = self._connectors.setdefault(node.name.upper(), node)
                if other is not node:
                    text = f"there are two output wire connectors {node.name}"
                    raise _wrong(node, text, "give each connector a name of its own")

    def inputs(self, node: Node) -> Iterator[tuple[str, Feed]]:
        """Yield the input pins of an element that are wired, in the order of its visible pins."""
        places = {pin.upper(): place for place, pin in enumerate(node.pins)}
        wired = self._pins.get(node.id, [])
        for pin in sorted(wired, key=lambda pin: places.get(pin.upper(), len(places))):
            yield pin, self._feed(node, pin)

    def _feed(self, node: Node, pin: str) -> Feed:
        wire = self._wires[node.id, pin.upper()]
        source, feedback, passed = self._nodes[wire.source], wire.feedback, {node.id}
        while source.kind == "ICon":
            end = self._connectors.get(source.name.upper())
            if end is None:
                text = f"there is no output wire connector {source.name}"
                raise _wrong(source, text, "draw it, or remove the input wire connector")
            found = self._wires.get((end.id, ""))
            if found is None or end.id in passed:
                raise _wrong(end, f"{end.title} is not connected", "connect it, or remove it")
            passed.add(end.id)
            wire = found
            source, feedback = self._nodes[wire.source], feedback or wire.feedback
        if source.kind in ("ORef", "OCon"):
            text = f"a wire begins at {source.title}, which has no output"
            raise _wrong(source, text, "draw the wire again")
        return Feed(source, wire.output, feedback or source.id == node.id)

    def executed(self) -> list[Node]:
        """Return the blocks in the order of their execution, or raise LadderError for a loop."""
        places = {sheet.number: place for place, sheet in enumerate(self._routine.sheets)}
        blocks = [node for node in self._routine.nodes if node.kind in BLOCKS]
        blocks.sort(key=lambda node: (places[node.sheet], node.y, node.x))
        before = {
            node.id: [
                feed.node
                for _, feed in self.inputs(node)
                if feed.node.kind in BLOCKS and not feed.feedback
            ]
            for node in blocks
        }
        done: dict[str, Node] = {}
        for block in blocks:
            _visit(block, before, done)
        for node in blocks:
            for _, feed in self.inputs(node):
                source = feed.node
                if feed.feedback and source.kind in BLOCKS and not _needs(node, source, before):
                    before[source.id].append(node)
        done.clear()
        for block in blocks:
            _visit(block, before, done)
        return list(done.values())

    def outputs(self) -> list[Node]:
        """Return the output references in the order of the file."""
        return [node for node in self._routine.nodes if node.kind == "ORef"]

    def feeds_back(self) -> set[tuple[str, str]]:
        """Return the output pins whose value of the last scan is used: element and pin."""
        found = set()
        for node in self._nodes.values():
            if node.kind not in ("OCon", "ICon"):
                for _, feed in self.inputs(node):
                    if feed.feedback:
                        found.add((feed.node.id, feed.output.upper()))
        return found


def _visit(block: Node, before: Mapping[str, Sequence[Node]], done: dict[str, Node]) -> None:
    """Add a block behind the blocks that feed it; a chain may be long, so without recursion."""
    waiting: dict[str, Iterator[Node]] = {}
    path = [block] if block.id not in done else []
    while path:
        node = path[-1]
        if node.id not in waiting:
            waiting[node.id] = iter(before[node.id])
        feeder = next(waiting[node.id], None)
        if feeder is None:
            done[node.id] = path.pop()
        elif feeder.id in waiting and feeder.id not in done:
            loop = path[[one.id for one in path].index(feeder.id) :]
            names = ", ".join(one.operand or one.name for one in loop)
            hint = "mark one of its wires with Assume Data Available"
            raise _wrong(node, f"the blocks {names} are in a loop", hint)
        elif feeder.id not in done:
            path.append(feeder)


def _needs(node: Node, other: Node, before: Mapping[str, Sequence[Node]]) -> bool:
    """Return whether another block must be executed before a block, or is the block itself."""
    waiting, seen = [node], {node.id}
    while waiting:
        one = waiting.pop()
        if one.id == other.id:
            return True
        waiting += [feeder for feeder in before[one.id] if feeder.id not in seen]
        seen.update(feeder.id for feeder in before[one.id])
    return False


def _wrong(node: Node, text: str, hint: str) -> LadderError:
    return LadderError(f"{title_of(node.sheet)}: {text}", node.at, hint)
