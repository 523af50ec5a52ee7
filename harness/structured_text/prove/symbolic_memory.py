"""A program's memory as terms: a table of scalars by path, with access to read and write it.

A long array of scalars is one array term.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import z3

from structured_text.engines.builtin.storage import is_scalar, stored
from structured_text.language.project import Project
from structured_text.language.standard import BLOCKS
from structured_text.language.types import ArrayType, BlockType, ElementaryType, StructType, Type
from structured_text.language.values import array_length
from structured_text.prove import standard, values
from structured_text.prove.logic import Bool
from structured_text.prove.values import Value

__all__ = ["Alternatives", "Leaf", "Path", "SymbolicMemory", "leaves"]

#: The path of a variable: names and positions, from the outermost variable inwards.
Path = tuple[Any, ...]
#: The paths that an access to a variable may refer to, each with its condition. Exactly one
#: condition holds.
Alternatives = list[tuple[Bool, Path]]
#: Arrays of scalars with more elements than this are stored as one array term.
_LONG = 64


@dataclass(frozen=True)
class Leaf:
    """A scalar, or a long array of scalars, inside a variable."""

    suffix: Path
    type: Type

    @property
    def long(self) -> bool:
        """Return whether the leaf is an array that is stored as one term."""
        return isinstance(self.type, ArrayType)


def leaves(kind: Type, project: Project) -> tuple[Leaf, ...]:
    """Return the scalars of a variable of this type, in order."""
    return tuple(_leaves(kind, project))


def _leaves(kind: Type, project: Project) -> Iterator[Leaf]:
    if is_scalar(kind) or _is_long(kind):
        yield Leaf((), kind)
    elif isinstance(kind, ArrayType):
        inner = leaves(kind.element, project)
        for place in range(array_length(kind)):
            for leaf in inner:
                yield Leaf((place, *leaf.suffix), leaf.type)
    elif isinstance(kind, StructType):
        for name, part in kind.fields:
            for leaf in _leaves(part, project):
                yield Leaf((name.upper(), *leaf.suffix), leaf.type)
    elif isinstance(kind, BlockType):
        if kind.name in BLOCKS:
            for name, elementary in standard.memory(kind.name):
                yield Leaf((name,), ElementaryType(elementary))
        else:
            for symbol in stored(project.pous[kind.name.upper()].symbols.values()):
                for leaf in _leaves(symbol.type, project):
                    yield Leaf((symbol.name.upper(), *leaf.suffix), leaf.type)


def _is_long(kind: Type) -> bool:
    return (
        isinstance(kind, ArrayType) and values.bits(kind.element) > 0 and array_length(kind) > _LONG
    )


class SymbolicMemory:
    """The variables of a program as terms.

    Attributes:
        assumptions: The conditions that are assumed, for example the range of an arbitrary value.
        places: Maps the name of a solver variable to the path of the program's variable.
    """

    def __init__(self, project: Project) -> None:
        self.project = project
        self.assumptions: list[Any] = []
        self.places: dict[str, Path] = {}
        self._memory: dict[Path, Value] = {}
        self._types: dict[Path, Type] = {}
        self._fresh = 0
        self._leaves: dict[Type, tuple[Leaf, ...]] = {}
        self._solver = z3.Solver()
        self._solver.set("timeout", 2000)

    def leaves(self, kind: Type) -> tuple[Leaf, ...]:
        """Return the scalars of a variable of this type."""
        if kind not in self._leaves:
            self._leaves[kind] = leaves(kind, self.project)
        return self._leaves[kind]

    def fresh(self, name: str) -> str:
        """Return a name that no other variable of the solver has."""
        self._fresh += 1
        return f"{name}!{self._fresh}"

    def create(self, path: Path, kind: Type, initial: Any = None) -> None:
        """Create a variable with its initial value; each variable of a block gets its own value."""
        if isinstance(kind, BlockType):
            if kind.name in BLOCKS:
                for leaf in self.leaves(kind):
                    self._types[path + leaf.suffix] = leaf.type
                    self._memory[path + leaf.suffix] = values.constant(leaf.type, 0)
                return
            for symbol in stored(self.project.pous[kind.name.upper()].symbols.values()):
                self.create((*path, symbol.name.upper()), symbol.type, symbol.initial)
        elif isinstance(kind, StructType):
            for name, part in kind.fields:
                self.create((*path, name.upper()), part, initial[name])
        elif _is_long(kind):
            assert isinstance(kind, ArrayType)
            self._types[path] = kind
            self._memory[path] = _long_array(kind, initial)
        elif isinstance(kind, ArrayType):
            for place in range(array_length(kind)):
                value = None if isinstance(kind.element, BlockType) else initial[place]
                self.create((*path, place), kind.element, value)
        else:
            self._types[path] = kind
            self._memory[path] = values.constant(kind, initial)

    def havoc(self, path: Path, kind: Type) -> None:
        """Set a variable to an arbitrary value of its type."""
        for leaf in self.leaves(kind):
            place = path + leaf.suffix
            self._types[place] = leaf.type
            name = self.fresh(".".join(str(part) for part in place))
            self.places[name] = place
            if leaf.long:
                self._memory[place] = _any_array(leaf.type, name)
                continue
            value = values.anything(leaf.type, name)
            legal = values.legal(leaf.type, value)
            if legal is not True:
                self.assume(legal)
            self._memory[place] = value

    def assume(self, condition: Bool) -> None:
        """Add a condition to the assumptions."""
        if condition is not True:
            self.assumptions.append(
                condition if not isinstance(condition, bool) else z3.BoolVal(condition)
            )
            self._solver.add(condition)

    def __getitem__(self, path: Path) -> Value:
        return self._memory[path]

    def __setitem__(self, path: Path, value: Value) -> None:
        self._memory[path] = value

    def __contains__(self, path: Path) -> bool:
        return path in self._memory

    def term(self, path: Path, memory: Mapping[Path, Value] | None = None) -> Any:
        """Return a scalar as a term, even if its value is known.

        `memory` is a snapshot to read instead of the current memory.
        """
        value = (self._memory if memory is None else memory)[path]
        kind = self._types[path]
        return value if isinstance(kind, ArrayType) else values.scalar(kind, value)

    def type_of(self, path: Path) -> Type:
        """Return the type of a scalar, or of a long array."""
        return self._types[path]

    def snapshot(self) -> dict[Path, Value]:
        """Return a copy of the memory."""
        return dict(self._memory)

    def restore(self, memory: Mapping[Path, Value]) -> None:
        """Restore the memory from a `snapshot`."""
        self._memory = dict(memory)

    # --- reading and writing by alternatives ---

    def load(self, places: Alternatives, kind: Type) -> Value:
        """Return the scalar that an access refers to, as a choice among its possible paths."""
        result = self._memory[places[-1][1]]
        for condition, path in reversed(places[:-1]):
            result = values.choose(condition, self._memory[path], result, kind)
        return result

    def store(self, places: Alternatives, kind: Type, value: Value) -> None:
        """Write a scalar to each path that an access may refer to, under the path's condition."""
        if len(places) == 1:
            self._memory[places[0][1]] = value
            return
        for condition, path in places:
            self._memory[path] = values.choose(condition, value, self._memory[path], kind)

    def element(self, array: Alternatives, kind: ArrayType, index: Value) -> Value:
        """Return an element of a long array; `index` counts from 0."""
        result = None
        for condition, path in reversed(array):
            value = z3.Select(self._memory[path], _index(index))
            result = value if result is None else z3.If(condition, value, result)
        return result

    def set_element(self, array: Alternatives, kind: ArrayType, index: Value, value: Value) -> None:
        """Write an element of a long array; `index` counts from 0."""
        for condition, path in array:
            before = self._memory[path]
            after = z3.Store(before, _index(index), values.scalar(kind.element, value))
            self._memory[path] = after if condition is True else z3.If(condition, after, before)

    def copy(self, target: Alternatives, source: Alternatives, kind: Type) -> None:
        """Assign a structure or an array."""
        for leaf in self.leaves(kind):
            got = [(condition, path + leaf.suffix) for condition, path in source]
            to = [(condition, path + leaf.suffix) for condition, path in target]
            if leaf.long:
                value = self._memory[got[-1][1]]
                for condition, path in reversed(got[:-1]):
                    value = z3.If(condition, self._memory[path], value)
                for condition, path in to:
                    before = self._memory[path]
                    self._memory[path] = (
                        value if condition is True else z3.If(condition, value, before)
                    )
            else:
                self.store(to, leaf.type, self.load(got, leaf.type))


def _index(index: Value) -> Any:
    if isinstance(index, int):
        return z3.BitVecVal(index, 32)
    size = index.size()
    return z3.SignExt(32 - size, index) if size < 32 else index


def _element_sort(kind: Type) -> Any:
    assert isinstance(kind, ArrayType)
    return z3.BitVecSort(values.bits(kind.element))


def _any_array(kind: Type, name: str) -> Any:
    return z3.Array(name, z3.BitVecSort(32), _element_sort(kind))


def _long_array(kind: ArrayType, initial: Any) -> Any:
    sort = _element_sort(kind)
    first = initial[0]
    term = z3.K(z3.BitVecSort(32), z3.BitVecVal(first, sort.size()))
    for place, value in enumerate(initial):
        if value != first:
            term = z3.Store(term, place, z3.BitVecVal(value, sort.size()))
    return term
