"""Two symbolic machines that run two versions of a program side by side.

Both machines use the same terms for equal states and equal inputs. A call of the same unchanged
library block with equal state and equal arguments then has the same result, so its body need not
be run (congruence).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from structured_text.engines.builtin.storage import is_scalar
from structured_text.language.project import Project
from structured_text.language.standard import BLOCKS
from structured_text.language.types import ArrayType, Type
from structured_text.prove import reals, texts, values
from structured_text.prove.logic import Bool, both
from structured_text.prove.machine import Call
from structured_text.prove.program import ProgramMachine
from structured_text.prove.symbolic_memory import Alternatives, Leaf, Path
from structured_text.prove.values import Value

__all__ = ["Calls", "PairedMachine", "same"]


def same(left: Any, right: Any, kind: Type) -> Bool:
    """Return the condition that two values of a type are the same, bit by bit."""
    if left is right:
        return True
    if isinstance(left, reals.Real):
        return reals.identical(left, right)
    if isinstance(left, texts.Text):
        return texts.compare("=", left, right)
    if isinstance(kind, ArrayType):
        return True if left.eq(right) else left == right
    return values.compare("=", left, right, kind)


@dataclass(frozen=True)
class _Made:
    """The values before and after a call that the first machine has replaced by its result."""

    before: tuple[Value, ...]
    after: tuple[Value, ...]


@dataclass
class Calls:
    """The calls of the first machine in the current scan, by name and instance."""

    made: dict[tuple[str, Path], list[_Made]] = field(default_factory=dict)

    def of(self, name: str, instance: Path) -> list[_Made]:
        """Return the calls on an instance, or else all calls of this block or function."""
        here = self.made.get((name, instance))
        if here is not None:
            return here
        return [one for (known, _), calls in self.made.items() if known == name for one in calls]


class PairedMachine(ProgramMachine):
    """A symbolic machine for one of the two versions.

    Args:
        project: The sources of the version.
        library: The files of the library.
        unchanged: Blocks and functions of the library, in upper case, that are the same in both
            versions. Their calls are replaced by arbitrary results. Equal calls of the two
            machines have equal results.
        calls: The calls of the first machine in this scan.
        side: 0 for the first machine, 1 for the second.
        exact: See `ProgramMachine`.
        milliseconds: See `ProgramMachine`.
    """

    def __init__(
        self,
        project: Project,
        library: frozenset[str],
        unchanged: frozenset[str],
        calls: Calls,
        side: int,
        *,
        exact: bool = False,
        milliseconds: str = "",
    ) -> None:
        super().__init__(project, library, exact=exact, milliseconds=milliseconds)
        self.side = side
        self._unchanged, self._paired = unchanged, calls
        if milliseconds.upper() in unchanged:
            self.summaries.pop(milliseconds.upper(), None)

    def fresh(self, name: str) -> str:
        """Return a name that no other variable of either machine has."""
        return f"{super().fresh(name)}{'ab'[self.side]}"

    def call_block(
        self, instance: Path, block: str, in_outs: Mapping[str, Path | Alternatives]
    ) -> None:
        """Run a block, or replace the call by a result that depends only on its arguments."""
        if block in BLOCKS or block.upper() not in self._unchanged:
            super().call_block(instance, block, in_outs)
            return
        if self.frame.pou.file not in self._library:
            self.own.append(Call(instance, block, both(*self._guards)))
        pou = self.project.pous[block.upper()]
        assert pou.block is not None
        slots: list[tuple[Alternatives, Leaf]] = [
            ([(True, instance)], leaf) for leaf in self.leaves(pou.block)
        ]
        for symbol in pou.section("VAR_IN_OUT"):
            given = in_outs[symbol.name.upper()]
            places = given if isinstance(given, list) else [(True, given)]
            slots += [(places, leaf) for leaf in self.leaves(symbol.type)]
        before = tuple(self._slot(places, leaf) for places, leaf in slots)
        kinds = [leaf.type for _, leaf in slots]
        after = self._result(block.upper(), instance, before, kinds, kinds)
        for (places, leaf), value in zip(slots, after, strict=True):
            self._fill(places, leaf, value)

    def call_function(self, name: str, arguments: list[Any]) -> Any:
        """Run a function, or replace the call by a result that depends only on its arguments."""
        pou = self.project.pous[name]
        if name not in self._unchanged or pou.result is None or not is_scalar(pou.result.type):
            return super().call_function(name, arguments)
        before: list[Value] = []
        kinds: list[Type] = []
        for symbol, argument in zip(pou.section("VAR_INPUT"), arguments, strict=True):
            if is_scalar(symbol.type):
                before.append(
                    values.constant(symbol.type, symbol.initial) if argument is None else argument
                )
                kinds.append(symbol.type)
            elif argument is None:
                return super().call_function(name, arguments)
            else:
                for leaf in self.leaves(symbol.type):
                    before.append(self._slot(argument, leaf))
                    kinds.append(leaf.type)
        kind = pou.result.type
        return self._result(name, (), tuple(before), kinds, [kind])[0]

    def _slot(self, places: Alternatives, leaf: Leaf) -> Value:
        """Return the value of a part of a variable, as a choice among its possible paths."""
        found = [(condition, path + leaf.suffix) for condition, path in places]
        if not leaf.long:
            return self.load(found, leaf.type)
        value = self[found[-1][1]]
        for condition, path in reversed(found[:-1]):
            value = self._chosen(condition, self[path], value, leaf.type)
        return value

    def _fill(self, places: Alternatives, leaf: Leaf, value: Value) -> None:
        """Write a part of a variable to each path that it may have."""
        for condition, path in places:
            place = path + leaf.suffix
            self.put(place, condition, value)

    def put(self, place: Path, condition: Bool, value: Value) -> None:
        """Write a scalar or a long array if a condition holds."""
        if condition is not True:
            value = self._chosen(condition, value, self[place], self.type_of(place))
        self[place] = value

    def _result(
        self,
        name: str,
        instance: Path,
        before: tuple[Value, ...],
        kinds: list[Type],
        results: list[Type],
    ) -> tuple[Value, ...]:
        """Return the values after a call.

        They are arbitrary. If the other machine has made the same call, they are its values.
        """
        equal: list[tuple[Bool, _Made]] = []
        if self.side:
            for made in self._paired.of(name, instance):
                condition = self._all_same(made.before, before, kinds)
                if condition is True:
                    return made.after
                if condition is not False:
                    equal.append((condition, made))
        after = tuple(self._any(kind, f"{name}.{number}") for number, kind in enumerate(results))
        for condition, made in reversed(equal):
            after = tuple(
                self._chosen(condition, there, here, kind)
                for there, here, kind in zip(made.after, after, results, strict=True)
            )
        if not self.side:
            self._paired.made.setdefault((name, instance), []).append(_Made(before, after))
        return after

    def _any(self, kind: Type, name: str) -> Value:
        path = (f"#{self.fresh(name)}",)
        self.havoc(path, kind)
        return self[path]

    def _all_same(
        self, left: tuple[Value, ...], right: tuple[Value, ...], kinds: list[Type]
    ) -> Bool:
        if len(left) != len(right):
            return False
        found = []
        for one, other, kind in zip(left, right, kinds, strict=True):
            condition = same(one, other, kind)
            if condition is False:
                return False
            found.append(condition)
        return both(*found)
