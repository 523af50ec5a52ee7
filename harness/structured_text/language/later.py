"""Parts of an initial value that are no constants: they are assigned when the program starts."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from structured_text.language import syntax as s
from structured_text.language.types import ArrayType, ReferenceType, Type

__all__ = ["Later", "Part"]


@dataclass(frozen=True)
class Part:
    """A part of a variable, the steps to it (indices or a member each), and what it becomes."""

    steps: tuple[tuple[int, ...] | s.Name, ...]
    value: s.Expression
    type: Type

    def assignment(self, variable: s.Name) -> s.Assign | s.Latch:
        """As a statement."""
        target: s.Variable = variable
        for step in self.steps:
            if isinstance(step, s.Name):
                target = s.Field(target, step, variable.at)
            else:
                numbers = tuple(_number(one, variable.at) for one in step)
                target = s.Index(target, numbers, variable.at)
        if isinstance(self.type, ReferenceType) and self.type.kind == "REFERENCE":
            return s.Latch(target, "REF", self.value, variable.at)
        return s.Assign(target, self.value, variable.at)


@dataclass(frozen=True)
class Later:
    """Where an initial value is read, and what was found that is no constant."""

    steps: tuple[tuple[int, ...] | s.Name, ...] = ()
    found: list[Part] = field(default_factory=list)

    def element(self, kind: ArrayType, position: int) -> Later:
        """The element at a position of the flat list of all."""
        indices = []
        for low, high in reversed(kind.bounds):
            position, offset = divmod(position, high - low + 1)
            indices.append(low + offset)
        return replace(self, steps=(*self.steps, tuple(reversed(indices))))

    def member(self, name: s.Name) -> Later:
        """A member of a structure."""
        return replace(self, steps=(*self.steps, name))

    def takes(self, node: s.Init, kind: Type) -> bool:
        """Keep a part for later, if it is one and has a value that could be assigned."""
        if not self.steps or isinstance(node, (s.ArrayInit, s.StructInit, s.Sequence)):
            return False
        self.found.append(Part(self.steps, node, kind))
        return True


def _number(value: int, at: s.Position) -> s.Expression:
    literal = s.Literal("INTEGER", str(abs(value)), at)
    return literal if value >= 0 else s.Unary("-", literal, at)
