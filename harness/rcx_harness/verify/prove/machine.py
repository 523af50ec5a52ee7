"""Runs checked Structured Text on terms of the solver: one scan, for every value at once.

Memory is a table of scalars by path (`("MAIN", "Y", 3)`); a long array of scalars is one array
term. Both branches of an IF are run and joined; a loop is unrolled until its condition cannot hold
any more. What would stop the engine (an index outside of its array, a division by zero, a
conversion out of range) is noted as an obligation, with the condition under which it happens.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import Any

import z3

from rcx_harness.engine.builtin.storage import address_slot, is_scalar, stored
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.frontend.standard import BLOCKS
from rcx_harness.engine.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    StructType,
    Type,
)
from rcx_harness.verify.prove import standard, values
from rcx_harness.verify.prove.expressions import Expressions
from rcx_harness.verify.prove.logic import Bool, UnsupportedError, both, either, negated
from rcx_harness.verify.prove.values import Value

__all__ = ["Alternatives", "Call", "Machine", "Obligation", "Path", "leaves"]

#: Names and positions, from the outermost variable inwards.
Path = tuple[Any, ...]
#: The places that an access may mean, each with its condition; one of them holds.
Alternatives = list[tuple[Bool, Path]]
#: Arrays of scalars with more elements than this are one term.
_LONG = 64
#: Rounds of a loop; more are refused.
_ROUNDS = 4096


@dataclass(frozen=True)
class Obligation:
    """Something that must not happen: its `kind` (index, division ...), where, and when."""

    kind: str
    file: str
    line: int
    when: Bool


@dataclass(frozen=True)
class Call:
    """A call of a block: its instance, its type, and the condition under which it is reached."""

    instance: Path
    block: str
    when: Bool


@dataclass(frozen=True)
class Leaf:
    """A scalar, or a long array of scalars, inside a variable."""

    suffix: Path
    type: Type

    @property
    def long(self) -> bool:
        """It is an array, held as one term."""
        return isinstance(self.type, ArrayType)


@lru_cache(maxsize=4096)
def _standard_memory(name: str) -> tuple[tuple[str, str], ...]:
    return standard.memory(name)


def leaves(kind: Type, project: Project) -> tuple[Leaf, ...]:
    """The scalars of a variable of this type, in order."""
    return tuple(_leaves(kind, project))


def _leaves(kind: Type, project: Project) -> Iterator[Leaf]:
    if is_scalar(kind) or _is_long(kind):
        yield Leaf((), kind)
    elif isinstance(kind, ArrayType):
        inner = leaves(kind.element, project)
        for place in range(_count(kind)):
            for leaf in inner:
                yield Leaf((place, *leaf.suffix), leaf.type)
    elif isinstance(kind, StructType):
        for name, part in kind.fields:
            for leaf in _leaves(part, project):
                yield Leaf((name.upper(), *leaf.suffix), leaf.type)
    elif isinstance(kind, BlockType):
        if kind.name in BLOCKS:
            for name, elementary in _standard_memory(kind.name):
                yield Leaf((name,), ElementaryType(elementary))
        else:
            for symbol in stored(project.pous[kind.name.upper()].symbols.values()):
                for leaf in _leaves(symbol.type, project):
                    yield Leaf((symbol.name.upper(), *leaf.suffix), leaf.type)


def _is_long(kind: Type) -> bool:
    return isinstance(kind, ArrayType) and values.bits(kind.element) > 0 and _count(kind) > _LONG


def _count(kind: ArrayType) -> int:
    count = 1
    for low, high in kind.bounds:
        count *= high - low + 1
    return count


@dataclass
class _Frame:
    """A POU under way: where its variables are."""

    pou: t.Pou
    roots: dict[str, Alternatives] = field(default_factory=dict)


class Machine:
    """A program's memory as terms, and what runs on it.

    Args:
        project: The checked sources.
        summaries: What stands for a call of a function instead of its body: takes the machine and
            the arguments, gives the result; of a block it takes the path of the instance. Each has
            to be proved of the body on its own.

    Attributes:
        now: The PLC's time in nanoseconds.
        obligations: What must not happen, of all that was run.
        calls: The calls of blocks, of all that was run.
        assumptions: What is taken for granted: the range of each value that may be anything.
    """

    def __init__(
        self,
        project: Project,
        summaries: Mapping[str, Callable[[Machine, list[Value]], Value]] | None = None,
    ) -> None:
        self.project = project
        self.now: Value = 0
        self.obligations: list[Obligation] = []
        self.calls: list[Call] = []
        self.assumptions: list[Any] = []
        self.summaries = dict(summaries or {})
        self._memory: dict[Path, Value] = {}
        self._types: dict[Path, Type] = {}
        self._guards: list[Bool] = []
        self._frames: list[_Frame] = []
        self._fresh = 0
        self._leaves: dict[Type, tuple[Leaf, ...]] = {}
        self.expressions = Expressions(self)
        self._at: tuple[str, int] = ("", 0)
        self._solver = z3.Solver()
        self._solver.set("timeout", 2000)

    # --- memory ---

    def leaves(self, kind: Type) -> tuple[Leaf, ...]:
        """The scalars of a variable of this type."""
        if kind not in self._leaves:
            self._leaves[kind] = leaves(kind, self.project)
        return self._leaves[kind]

    def fresh(self, name: str) -> str:
        """A name that no other variable of the solver has."""
        self._fresh += 1
        return f"{name}!{self._fresh}"

    def create(self, path: Path, kind: Type, initial: Any = None) -> None:
        """A variable with its initial value; of a block with those of its variables."""
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
            for place in range(_count(kind)):
                value = None if isinstance(kind.element, BlockType) else initial[place]
                self.create((*path, place), kind.element, value)
        else:
            self._types[path] = kind
            self._memory[path] = values.constant(kind, initial)

    def havoc(self, path: Path, kind: Type) -> None:
        """Let a variable be anything that its type allows."""
        for leaf in self.leaves(kind):
            place = path + leaf.suffix
            self._types[place] = leaf.type
            name = self.fresh(".".join(str(part) for part in place))
            if leaf.long:
                self._memory[place] = _any_array(leaf.type, name)
                continue
            value = values.anything(leaf.type, name)
            legal = values.legal(leaf.type, value)
            if legal is not True:
                self.assume(legal)
            self._memory[place] = value

    def assume(self, condition: Bool) -> None:
        """Take something for granted from here on."""
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
        """A scalar as a term of the solver, also where its value is known; of a `snapshot`."""
        value = (self._memory if memory is None else memory)[path]
        kind = self._types[path]
        return value if isinstance(kind, ArrayType) else values.scalar(kind, value)

    def type_of(self, path: Path) -> Type:
        """The type of a scalar, or of a long array."""
        return self._types[path]

    def snapshot(self) -> dict[Path, Value]:
        """All of the memory as it is."""
        return dict(self._memory)

    def restore(self, memory: Mapping[Path, Value]) -> None:
        """Bring back what `snapshot` gave."""
        self._memory = dict(memory)

    # --- reading and writing by alternatives ---

    def load(self, places: Alternatives, kind: Type) -> Value:
        """The scalar that an access means."""
        result = self._memory[places[-1][1]]
        for condition, path in reversed(places[:-1]):
            result = values.choose(condition, self._memory[path], result, kind)
        return result

    def store(self, places: Alternatives, kind: Type, value: Value) -> None:
        """Write a scalar where an access means."""
        if len(places) == 1:
            self._memory[places[0][1]] = value
            return
        for condition, path in places:
            self._memory[path] = values.choose(condition, value, self._memory[path], kind)

    def element(self, array: Alternatives, kind: ArrayType, index: Value) -> Value:
        """An element of a long array; `index` counts from 0."""
        result = None
        for condition, path in reversed(array):
            value = z3.Select(self._memory[path], _index(index))
            result = value if result is None else z3.If(condition, value, result)
        return result

    def set_element(self, array: Alternatives, kind: ArrayType, index: Value, value: Value) -> None:
        """Write an element of a long array."""
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

    # --- what is under way ---

    @property
    def frame(self) -> _Frame:
        """The POU that runs."""
        return self._frames[-1]

    def oblige(self, kind: str, bad: Bool) -> None:
        """Note what must not happen here."""
        when = both(*self._guards, bad)
        if when is not False:
            self.obligations.append(Obligation(kind, *self._at, when))

    def possible(self, condition: Bool) -> bool:
        """Whether a condition can hold here; True also where the solver cannot tell in time."""
        if isinstance(condition, bool):
            return condition
        self._solver.push()
        self._solver.add(*[guard for guard in self._guards if guard is not True], condition)
        result = self._solver.check()
        self._solver.pop()
        return bool(result != z3.unsat)

    # --- POUs ---

    def call_block(
        self,
        instance: Path,
        block: str,
        in_outs: Mapping[str, Path | Alternatives],
    ) -> None:
        """Run the body of a block on an instance, with the variables of its VAR_IN_OUT."""
        self.calls.append(Call(instance, block, both(*self._guards)))
        if block in BLOCKS:
            standard.run(self, instance, block)
            return
        if block.upper() in self.summaries:
            self.summaries[block.upper()](self, [instance])
            return
        pou = self.project.pous[block.upper()]
        frame = _Frame(pou)
        for symbol in pou.symbols.values():
            name = symbol.name.upper()
            if symbol.section == "VAR_IN_OUT":
                places = in_outs[name]
                frame.roots[name] = places if isinstance(places, list) else [(True, places)]
            elif symbol.section == "VAR_TEMP":
                frame.roots[name] = [(True, self._temporary(symbol))]
        frame.roots[""] = [(True, instance)]
        self._run(frame)

    def call_function(self, name: str, arguments: list[Value | Alternatives | None]) -> Any:
        """Run a function; scalars are values, structures and arrays the places they are at."""
        if name in self.summaries:
            return self.summaries[name](self, arguments)
        pou = self.project.pous[name]
        frame = _Frame(pou)
        for symbol in (*pou.section("VAR"), *([pou.result] if pou.result else [])):
            frame.roots[symbol.name.upper()] = [(True, self._temporary(symbol))]
        for symbol, argument in zip(pou.section("VAR_INPUT"), arguments, strict=True):
            path = self._temporary(symbol)
            frame.roots[symbol.name.upper()] = [(True, path)]
            if is_scalar(symbol.type):
                if argument is not None:
                    self._memory[path] = argument
            elif argument is not None:
                self.copy([(True, path)], argument, symbol.type)
        self._run(frame)
        assert pou.result is not None
        root = frame.roots[pou.result.name.upper()]
        return self.load(root, pou.result.type) if is_scalar(pou.result.type) else root

    def _temporary(self, symbol: t.Symbol) -> Path:
        path = (f"#{len(self._frames)}.{self.fresh(symbol.name.upper())}",)
        self.create(path, symbol.type, symbol.initial)
        return path

    def _run(self, frame: _Frame) -> None:
        if len(self._frames) > 60:
            raise UnsupportedError("blocks and functions too deep inside each other")
        self._frames.append(frame)
        at = self._at
        self._statements(frame.pou.body)
        self._frames.pop()
        self._at = at

    def root(self, symbol: t.Symbol) -> Alternatives:
        """Where a variable of the POU that runs is."""
        name = symbol.name.upper()
        if symbol.section == "VAR_EXTERNAL":
            symbol = self.project.global_symbols[name]
            return [(True, ("", address_slot(symbol.address) if symbol.address else name))]
        if symbol.address is not None:
            return [(True, ("", address_slot(symbol.address)))]
        found = self.frame.roots.get(name)
        if found is not None:
            return found
        return [(condition, (*path, name)) for condition, path in self.frame.roots[""]]

    # --- statements: each gives the conditions under which what follows is not reached ---

    def _statements(self, statements: tuple[t.Statement, ...]) -> _Left:
        left = _Left()
        for number, statement in enumerate(statements):
            gone = left.all()
            if gone is True:
                break
            if gone is not False:
                rest = statements[number:]
                inner = _Left()

                def follow(rest: tuple[t.Statement, ...] = rest, inner: _Left = inner) -> None:
                    inner.take(self._statements(rest))

                self._guarded(negated(gone), follow)
                left.take(inner, negated(gone))
                break
            self._at = (self.frame.pou.file, statement.at.line)
            left.take(self._statement(statement))
        return left

    def _guarded(self, condition: Bool, body: Callable[[], None]) -> None:
        """Run something whose effect holds only under a condition."""
        self._branches([(condition, body)])

    def _branches(self, branches: list[tuple[Bool, Callable[[], None]]]) -> None:
        """Run each from the same memory, then join: the first whose condition holds counts."""
        before = self._memory
        results: list[tuple[Bool, dict[Path, Value]]] = []
        none: Bool = True
        for condition, body in branches:
            here = both(none, condition)
            if here is False:
                continue
            self._memory = dict(before) if here is not True else before
            self._guards.append(here)
            body()
            self._guards.pop()
            results.append((here, self._memory))
            none = both(none, negated(condition))
            if here is True:
                return
            if none is False:
                break
        self._memory = self._joined(before, results, covered=none is False)

    def _joined(
        self,
        before: dict[Path, Value],
        results: list[tuple[Bool, dict[Path, Value]]],
        covered: bool,
    ) -> dict[Path, Value]:
        if not results:
            return before
        if covered and len(results) == 1:
            return results[0][1]
        changed: set[Path] = set()
        for _, memory in results:
            changed.update(path for path, value in memory.items() if before.get(path) is not value)
        joined = dict(before)
        for path in changed:
            if path not in before:
                continue  # a temporary of a function: nobody reads it again
            *first, (_, last) = results
            value = last[path] if covered else before[path]
            for condition, memory in reversed(first if covered else results):
                value = self._chosen(condition, memory[path], value, self._types[path])
            joined[path] = value
        return joined

    def _chosen(self, condition: Bool, yes: Value, no: Value, kind: Type) -> Value:
        if isinstance(kind, ArrayType):
            return yes if yes is no else z3.If(condition, yes, no)
        return values.choose(condition, yes, no, kind)

    def _statement(self, node: t.Statement) -> _Left:
        left = _Left()
        if isinstance(node, t.Assign):
            self.assign(node)
        elif isinstance(node, t.CallBlock):
            self._call(node)
        elif isinstance(node, (t.If, t.Case)):
            left = self._if(node)
        elif isinstance(node, (t.For, t.While, t.Repeat)):
            left = self._loop(node)
        elif isinstance(node, t.Exit):
            left.exits = True
        else:
            left.returns = True
        return left

    def assign(self, node: t.Assign) -> None:
        """Run an assignment."""
        kind = node.target.type
        if not is_scalar(kind):
            value = self.expressions.places(node.value)
            self.copy(self.expressions.places(node.target), value, kind)
            return
        self.expressions.assign(node.target, self.expressions.exact(node.value))

    def _call(self, node: t.CallBlock) -> None:
        pins = {pin.name: pin for pin in node.block.variables}
        instances = self.expressions.places(node.instance)
        for pin, expression in node.inputs:
            target = [(c, (*path, pin.upper())) for c, path in instances]
            if is_scalar(pins[pin].type):
                self.store(target, pins[pin].type, self.expressions.exact(expression))
            else:
                self.copy(target, self.expressions.places(expression), pins[pin].type)
        in_outs = {name.upper(): self.expressions.places(v) for name, v in node.in_outs}
        if len(instances) == 1:
            self.call_block(instances[0][1], node.block.name, in_outs)
        else:
            self._branches(
                [
                    (condition, partial(self.call_block, path, node.block.name, in_outs))
                    for condition, path in instances
                ]
            )
        for pin, variable in node.outputs:
            source = [(c, (*path, pin.upper())) for c, path in instances]
            if is_scalar(pins[pin].type):
                self.expressions.assign(variable, self.load(source, pins[pin].type))
            else:
                self.copy(self.expressions.places(variable), source, pins[pin].type)

    def _if(self, node: t.If | t.Case) -> _Left:
        left = _Left()
        if isinstance(node, t.If):
            choices = node.branches
            tests: Iterator[Bool] = (self.expressions.exact(item[0]) for item in choices)
        else:
            selector = self.expressions.exact(node.selector)
            kind = node.selector.type
            tests = (
                either(*(_labelled(selector, low, high, kind) for low, high in item[0]))
                for item in node.branches
            )
        branches: list[tuple[Bool, Callable[[], None]]] = []
        none: Bool = True
        bodies = [body for _, body in node.branches]
        # A condition is evaluated on the memory before all branches: in Structured Text it has no
        # effect, so that those after one that holds may be looked at, too.
        for test, body in zip(tests, bodies, strict=True):
            self._add_branch(branches, test, body, left, none)
            none = both(none, negated(test))
            if none is False:
                break
        if none is not False and node.otherwise:
            self._add_branch(branches, True, node.otherwise, left, none)
        self._branches(branches)
        return left

    def _add_branch(
        self,
        branches: list[tuple[Bool, Callable[[], None]]],
        test: Bool,
        body: tuple[t.Statement, ...],
        left: _Left,
        none: Bool,
    ) -> None:
        def run() -> None:
            left.take(self._statements(body), both(none, test))

        branches.append((test, run))

    def _loop(self, node: t.For | t.While | t.Repeat) -> _Left:
        """Each round runs under the condition that the loop has not ended before."""
        left = _Left()
        ends = _Ends(self, node)
        depth = len(self._guards)
        before: list[dict[Path, Value]] = []

        def enter(condition: Bool) -> bool:
            """Go on under a condition; whether it can hold."""
            if condition is False or (condition is not True and not self.possible(condition)):
                return False
            if condition is not True:
                before.append(self._memory)
                self._memory = dict(self._memory)
                self._guards.append(condition)
            return True

        for count in range(_ROUNDS + 1):
            if count == _ROUNDS:
                raise UnsupportedError(f"a loop of more than {_ROUNDS} rounds")
            if not enter(ends.first()):
                break
            inner = self._statements(node.body)
            left.returns = either(left.returns, both(*self._guards[depth:], inner.returns))
            if not enter(negated(inner.all())) or not enter(ends.last()):
                break
        for memory in reversed(before):
            condition = self._guards.pop()
            self._memory = self._joined(memory, [(condition, self._memory)], covered=False)
        return left


class _Ends:
    """When a loop goes on: before a round, and after it."""

    def __init__(self, machine: Machine, node: t.For | t.While | t.Repeat) -> None:
        self._node = node
        self._machine = machine
        self._end: Value = None
        if isinstance(node, t.For):
            if not isinstance(node.step, t.Constant):
                raise UnsupportedError("FOR with a step that is not constant")
            self._end = machine.expressions.exact(node.end)
            start = t.Assign(node.counter, node.start, node.at)
            self._step = t.Binary("+", node.counter, node.step, node.counter.type)
            machine.assign(start)

    def first(self) -> Bool:
        node = self._node
        if isinstance(node, t.While):
            return self._machine.expressions.exact(node.condition)
        if isinstance(node, t.Repeat):
            return True
        op = "<=" if int(node.step.value) > 0 else ">="  # type: ignore[union-attr]
        counter = self._machine.expressions.exact(node.counter)
        return values.compare(op, counter, self._end, node.counter.type)

    def last(self) -> Bool:
        node = self._node
        if isinstance(node, t.Repeat):
            return negated(self._machine.expressions.exact(node.condition))
        if isinstance(node, t.For):
            self._machine.assign(t.Assign(node.counter, self._step, node.at))
        return True


@dataclass
class _Left:
    """Under which condition a POU (RETURN) or a loop (EXIT) has been left."""

    returns: Bool = False
    exits: Bool = False

    def all(self) -> Bool:
        return either(self.returns, self.exits)

    def take(self, other: _Left, under: Bool = True) -> None:
        self.returns = either(self.returns, both(under, other.returns))
        self.exits = either(self.exits, both(under, other.exits))


def _labelled(selector: Value, low: int, high: int, kind: Type) -> Bool:
    if low == high:
        return values.compare("=", selector, low, kind)
    return both(
        values.compare(">=", selector, low, kind), values.compare("<=", selector, high, kind)
    )


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
