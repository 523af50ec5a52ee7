"""Parts of an initial value that are not constant. They are assigned when the program starts."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from structured_text.language import syntax as s
from structured_text.language.types import ArrayType, ReferenceType, Type
from structured_text.language.values import indices_at

__all__ = ["Later", "Part"]


@dataclass(frozen=True)
class Part:
    """A part of a variable with a value that is not constant.

    `steps` leads to the part: indices of an array or the name of a member.
    """

    steps: tuple[tuple[int, ...] | s.Name, ...]
    value: s.Expression
    type: Type

    def assignment(self, variable: s.Name) -> s.Assign | s.Latch:
        """Return the statement that assigns the value to this part of the variable."""
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
    """A position inside a variable, and the parts found so far that are assigned at the start."""

    steps: tuple[tuple[int, ...] | s.Name, ...] = ()
    found: list[Part] = field(default_factory=list)

    def element(self, kind: ArrayType, position: int) -> Later:
        """Return the position of an array element; `position` counts in row-major order."""
        return replace(self, steps=(*self.steps, indices_at(kind, position)))

    def member(self, name: s.Name) -> Later:
        """Return the position of a member of a structure."""
        return replace(self, steps=(*self.steps, name))

    def takes(self, node: s.Init, kind: Type) -> bool:
        """Add the value of a part if it can be assigned; return whether it was added."""
        if not self.steps or isinstance(node, (s.ArrayInit, s.StructInit, s.Sequence)):
            return False
        self.found.append(Part(self.steps, node, kind))
        return True


def _number(value: int, at: s.Position) -> s.Expression:
    literal = s.Literal("INTEGER", str(abs(value)), at)
    return literal if value >= 0 else s.Unary("-", literal, at)
