"""The body of a user's POU as ladder, with the blocks for statements that cannot be rungs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from structured_text.export.ladder.diagram import Rung, diagram_of
from structured_text.export.ladder.operations import Operation, Operations, RefusedError
from structured_text.export.ladder.own_block import OwnBlock, own_block
from structured_text.export.ladder.pieces import Piece, pieces_of
from structured_text.export.ladder.types import Scope
from structured_text.export.parts import Part, Sources
from structured_text.language import syntax as s
from structured_text.language.parser import parse_text
from structured_text.projects.diagrams.networks.model import Diagram

__all__ = ["Ladder", "ladder_of"]


@dataclass
class Ladder:
    """The ladder of a POU.

    Attributes:
        diagram: The diagram; None if the POU stays in Structured Text.
        variables: The added variables with their types.
        blocks: The blocks for statements that cannot be rungs.
        notes: What stays in Structured Text, with the reason.
    """

    diagram: Diagram | None = None
    variables: list[tuple[str, str]] = field(default_factory=list)
    blocks: list[Part] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def ladder_of(part: Part, sources: Sources, *, ordered: bool = True) -> Ladder:
    """Return the ladder of a program or function block.

    Statements that cannot be rungs become a function block in Structured Text. If such statements
    need the POU itself, the whole POU stays in Structured Text.
    """
    scope = Scope(part, sources)
    try:
        return _Maker(part, scope).ladder(pieces_of(part), ordered)
    except RefusedError as error:
        line = error.at.line + part.line - f"{part.head}\n".count("\n") - 1
        what = f"{part.kind} {part.name}"
        note = f"{part.file}:{line}: {what} stays in Structured Text: {error.message}"
        return Ladder(notes=[note])


class _Maker:
    def __init__(self, part: Part, scope: Scope) -> None:
        self._part, self._scope = part, scope
        self._names = set(scope.names)
        self._found = Ladder()
        self._operations = Operations(scope, self._fresh_number)

    def _fresh_number(self, name: str) -> str:
        """Return the name with the lowest number that makes it new."""
        return self._fresh_of([f"{name}{number}" for number in range(1, len(self._names) + 2)])

    def _fresh(self, name: str) -> str:
        """Return the name, with a number only if it is not new."""
        others = [f"{name}_{number}" for number in range(2, len(self._names) + 3)]
        return self._fresh_of([name, *others])

    def _fresh_of(self, names: Sequence[str]) -> str:
        found = next(name for name in names if name.upper() not in self._names)
        self._names.add(found.upper())
        return found

    def ladder(self, pieces: Sequence[Piece], ordered: bool) -> Ladder:
        rungs: list[Rung] = []
        waiting: list[tuple[Piece, RefusedError]] = []
        for piece in pieces:
            operations = self._of(piece, waiting)
            if operations:
                rungs += self._moved(waiting)
                rungs.append(Rung(tuple(operations), piece.comment, piece.line))
        rungs += self._moved(waiting)
        self._found.variables[:0] = [(name, "BOOL") for name in self._operations.added]
        self._found.diagram = diagram_of(rungs, ordered=ordered)
        return self._found

    def _of(self, piece: Piece, waiting: list[tuple[Piece, RefusedError]]) -> list[Operation]:
        """Return the operations of a statement; if it cannot be a rung, it waits for the next."""
        names = set(self._names)
        try:
            return self._operations.of(piece.node)
        except RefusedError as error:
            self._names = names
            if not error.moved:
                raise
            waiting.append((piece, error))
            return []

    def _moved(self, waiting: list[tuple[Piece, RefusedError]]) -> list[Rung]:
        """Return the rung that calls the block of the waiting statements, if there are any."""
        if not waiting:
            return []
        name = self._fresh(f"{self._part.name}_Text")
        instance = self._fresh_number("Text")
        pieces = [piece for piece, _ in waiting]
        own = own_block(pieces, self._scope, name, instance, self._fresh)
        self._found.blocks.append(self._block(own, pieces[0]))
        self._found.variables.append((instance, name))
        for piece, error in waiting:
            line = error.at.line + piece.shift
            what = f"{self._part.kind} {self._part.name}"
            text = f"{what}: stays in Structured Text, in {name}: {error.message}"
            self._found.notes.append(f"{self._part.file}:{line}: {text}")
        waiting.clear()
        return [Rung((own.call,), "", pieces[0].line)]

    def _block(self, own: OwnBlock, piece: Piece) -> Part:
        text = f"{own.head}\n{own.body}\nEND_FUNCTION_BLOCK"
        (node,) = parse_text(text, self._part.file).declarations
        assert isinstance(node, s.Pou)
        header = f"Statements of {self._part.name} that are not rungs."
        kind, folder = "FUNCTION_BLOCK", self._part.folder
        return Part(
            kind, own.name, self._part.file, folder, header, own.head, own.body, piece.line, node
        )
