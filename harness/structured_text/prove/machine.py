"""Symbolic execution of checked Structured Text: one scan, for all values at once.

Memory is a table of scalars by path (`("MAIN", "Y", 3)`); a long array of scalars is one array
term. Both branches of an IF are run and joined. A loop is unrolled until its condition cannot hold
any more. Some operations would stop an engine: an index outside its array, a division by zero, a
conversion out of range. Each such operation is recorded as an obligation, with the condition under
which it fails.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import z3

from structured_text.engines.builtin.storage import address_slot, is_scalar
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.scalars import ELEMENTARY, INT_RANGE
from structured_text.language.standard import BLOCKS
from structured_text.language.types import ArrayType, Type, type_name
from structured_text.prove import standard, values
from structured_text.prove.expression_terms import ExpressionTerms
from structured_text.prove.logic import Bool, UnsupportedError, both, either, negated
from structured_text.prove.overflow import Operation, Span
from structured_text.prove.symbolic_memory import Alternatives, Path, SymbolicMemory
from structured_text.prove.values import Value

__all__ = ["Call", "Machine", "Obligation"]

_BOOL = ELEMENTARY["BOOL"]

#: Highest number of rounds to which a loop is unrolled; a longer loop is refused.
_ROUNDS = 4096
#: After this number of rounds, the solver checks only every 16th time whether another round is
#: possible. A superfluous round changes nothing, because its condition cannot hold.
_ASKED = 16

#: The condition of a branch, and the function that runs it.
_Branch = tuple[Bool, Callable[[], None]]


@dataclass(frozen=True)
class Obligation:
    """An operation that must not fail, with the kind of failure (such as index) and position.

    `when` is the condition under which the operation fails. `properties.Watch` reads the
    obligations of each scan.
    """

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


@dataclass
class _Frame:
    """The frame of a running POU, with the memory paths of its variables."""

    pou: t.Pou
    roots: dict[str, Alternatives] = field(default_factory=dict)


class Machine(SymbolicMemory):
    """A symbolic machine: a program's memory as terms, and the execution of code on it.

    Args:
        project: The checked sources.
        summaries: Replacements for the bodies of functions and blocks, by upper-case name. Each
            takes the machine and the arguments, and returns the result; each must be proved against
            the body separately. For a block without VAR_IN_OUT it takes the instance and sets its
            variables. A summary can also stand for a standard function that has no term.

    Attributes:
        now: The PLC's time in nanoseconds.
        obligations: The operations in all code run so far that must not fail.
        calls: The calls of blocks in all code run so far.
        operations: The arithmetic in all code run so far that may leave its type.
    """

    def __init__(
        self,
        project: Project,
        summaries: Mapping[str, Callable[[Machine, list[Value]], Value]] | None = None,
    ) -> None:
        super().__init__(project)
        self.now: Value = 0
        self.obligations: list[Obligation] = []
        self.calls: list[Call] = []
        self.operations: list[Operation] = []
        self.summaries = dict(summaries or {})
        self._guards: list[Bool] = []
        self._frames: list[_Frame] = []
        self.expressions = ExpressionTerms(self)
        self._at: tuple[str, int] = ("", 0)

    # --- the running POU and its conditions ---

    @property
    def frame(self) -> _Frame:
        """Return the frame of the running POU."""
        return self._frames[-1]

    def oblige(self, kind: str, bad: Bool) -> None:
        """Record an obligation: under the current conditions, `bad` must not hold."""
        when = both(*self._guards, bad)
        if when is not False:
            self.obligations.append(Obligation(kind, *self._at, when))

    def computes(self, node: t.Expression, leaves: Callable[[Span], Bool]) -> None:
        """Record an arithmetic operation that may leave its type."""
        pou, guards = self.frame.pou.name, tuple(self._guards)
        self.operations.append(Operation(node, pou, *self._at, guards, leaves))

    @contextmanager
    def under(self, condition: Bool) -> Iterator[None]:
        """Add a condition to the guards while the `with` block runs.

        Obligations that are recorded meanwhile apply only if the condition holds.
        """
        self._guards.append(condition)
        yield
        self._guards.pop()

    def possible(self, condition: Bool) -> bool:
        """Return whether a condition can hold here; True if the solver times out.

        An undecided condition counts as possible. Then a loop is at worst unrolled for one more
        round, which does no harm. If it counted as impossible, the proof would omit runs and be
        unsound.
        """
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
        """Run the body of a block on an instance.

        `in_outs` holds the memory paths of the variables that are passed as VAR_IN_OUT.
        """
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
        """Run a function and return its result.

        Scalars are passed and returned as values; structures and arrays are passed and returned as
        memory paths.
        """
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
            raise UnsupportedError("blocks and functions are nested too deeply")
        self._frames.append(frame)
        at = self._at
        self._statements(frame.pou.body)
        self._frames.pop()
        self._at = at

    def root(self, symbol: t.Symbol) -> Alternatives:
        """Return the memory paths of a variable of the running POU."""
        name = symbol.name.upper()
        if symbol.section == "VAR_EXTERNAL":
            name = symbol.source or name
            symbol = self.project.global_symbols[name]
            return [(True, ("", address_slot(symbol.address) if symbol.address else name))]
        if symbol.address is not None:
            return [(True, ("", address_slot(symbol.address)))]
        found = self.frame.roots.get(name)
        if found is not None:
            return found
        return [(condition, (*path, name)) for condition, path in self.frame.roots[""]]

    # --- statements: each returns the conditions under which the code after it is not reached ---

    def _statements(self, statements: tuple[t.Statement, ...]) -> _Left:
        """Run statements in order; return the conditions under which the POU or loop is left.

        If a RETURN or EXIT is reached under a condition, the remaining statements run as one branch
        under the negated condition. If it is reached in any case, they do not run.
        """
        left = _Left()
        for number, statement in enumerate(statements):
            gone = left.all()
            if gone is True:
                break
            if gone is not False:
                branches: list[_Branch] = []
                self._add_branch(branches, negated(gone), statements[number:], left, True)
                self._branches(branches)
                break
            self._at = (self.frame.pou.file, statement.at.line)
            left.take(self._statement(statement))
        return left

    def _branches(self, branches: list[_Branch]) -> None:
        """Run each body on a copy of the memory and join the results.

        The first branch with a true condition takes effect.
        """
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
        """Return the memory after several branches, with a choice for each changed value.

        `results` holds the memory at the end of each branch with the condition of that branch. If
        `covered`, one of the branches was taken in any case; otherwise `before` is a further
        alternative. Only values that differ from `before` by identity are joined, so that terms
        stay small.
        """
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
                continue  # No statement reads a temporary variable of a function after the branch.
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
        elif isinstance(node, s.Exit):
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
        written_back: list[Callable[[], None]] = []
        in_outs = {name.upper(): self._connected(v, written_back) for name, v in node.in_outs}
        if len(instances) == 1:
            self.call_block(instances[0][1], node.block.name, in_outs)
        else:
            self._branches(
                [
                    (condition, partial(self.call_block, path, node.block.name, in_outs))
                    for condition, path in instances
                ]
            )
        for write in written_back:
            write()
        for pin, variable in node.outputs:
            source = [(c, (*path, pin.upper())) for c, path in instances]
            if is_scalar(pins[pin].type):
                self.expressions.assign(variable, self.load(source, pins[pin].type))
            else:
                self.copy(self.expressions.places(variable), source, pins[pin].type)

    def _connected(self, node: t.Variable, written_back: list[Callable[[], None]]) -> Alternatives:
        """Return the memory paths of a variable that is connected to a VAR_IN_OUT.

        An element of a long array has no path of its own. The element is copied into a temporary
        variable, and a function that writes it back is added to `written_back`.
        """
        found = self.expressions.long_element(node)
        if found is None:
            return self.expressions.places(node)
        path = (f"#{len(self._frames)}.{self.fresh('element')}",)
        self._types[path] = node.type
        self._memory[path] = self.element(*found)
        written_back.append(lambda: self.set_element(*found, self._memory[path]))
        return [(True, path)]

    def _if(self, node: t.If | t.Case) -> _Left:
        left = _Left()
        if isinstance(node, t.If):
            tests = [partial(self.expressions.exact, item[0]) for item in node.branches]
        else:
            selector = self.expressions.exact(node.selector)
            kind = node.selector.type
            tests = [partial(_labelled, selector, item[0], kind) for item in node.branches]
        branches: list[_Branch] = []
        none: Bool = True
        bodies = [body for _, body in node.branches]
        # All conditions are evaluated on the memory before the branches, because a condition in
        # Structured Text has no side effects. Their obligations apply only if no earlier branch was
        # taken.
        for ask, body in zip(tests, bodies, strict=True):
            with self.under(none):
                test = ask()
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
        branches: list[_Branch],
        test: Bool,
        body: tuple[t.Statement, ...],
        left: _Left,
        none: Bool,
    ) -> None:
        def run() -> None:
            left.take(self._statements(body), both(none, test))

        branches.append((test, run))

    def _loop(self, node: t.For | t.While | t.Repeat) -> _Left:
        """Run a loop by unrolling it, and return the conditions under which the POU was left.

        Round n runs under the guards that the loop has not ended in rounds 1 to n-1. Each guard
        that is not constant saves the memory before it. After the last round the memories are
        joined from the inside out, so that each round takes effect only if its guard holds. The
        solver decides if another round is possible; with a constant loop condition it is not
        needed. Raise UnsupportedError if the loop may have more than `_ROUNDS` rounds.
        """
        left = _Left()
        ends = _Ends(self, node)
        depth = len(self._guards)
        before: list[dict[Path, Value]] = []

        def enter(condition: Bool) -> bool:
            """Add a guard and return True, or return False if the guard cannot hold."""
            asked = count < _ASKED or count % _ASKED == 0
            if condition is False or (asked and not self.possible(condition)):
                return False
            if condition is not True:
                before.append(self._memory)
                self._memory = dict(self._memory)
                self._guards.append(condition)
            return True

        for count in range(_ROUNDS + 1):
            if count == _ROUNDS:
                raise UnsupportedError(f"a loop has more than {_ROUNDS} rounds")
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
    """The conditions of a loop, before and after each round.

    The end of a FOR loop is evaluated once, before the first round.
    """

    def __init__(self, machine: Machine, node: t.For | t.While | t.Repeat) -> None:
        self._node = node
        self._machine = machine
        self._end: Value = None
        if isinstance(node, t.For):
            self._end = machine.expressions.exact(node.end)
            start = t.Assign(node.counter, node.start, node.at)
            self._step = t.Binary("+", node.counter, node.step, node.counter.type)
            machine.assign(start)

    def first(self) -> Bool:
        """Return the condition, before a round, under which the round is run."""
        node = self._node
        if isinstance(node, t.While):
            return self._machine.expressions.exact(node.condition)
        if isinstance(node, t.Repeat):
            return True
        step = self._machine.expressions.exact(node.step)
        counter = self._machine.expressions.exact(node.counter)
        kind = node.counter.type
        up, down = (values.compare(op, counter, self._end, kind) for op in ("<=", ">="))
        return values.choose(values.compare(">", step, 0, kind), up, down, _BOOL)

    def last(self) -> Bool:
        """Step a FOR counter, and return the condition under which the loop continues."""
        node = self._node
        if isinstance(node, t.Repeat):
            return negated(self._machine.expressions.exact(node.condition))
        if not isinstance(node, t.For):
            return True
        down = -int(node.step.value) if isinstance(node.step, t.Constant) else 0
        kind, more = node.counter.type, True
        # An unsigned counter cannot go below 0, so the loop ends.
        if down > 0 and INT_RANGE[type_name(kind)][0] == 0:
            counter = self._machine.expressions.exact(node.counter)
            more = values.compare(">=", counter, down, kind)
        self._machine.assign(t.Assign(node.counter, self._step, node.at))
        return more


@dataclass
class _Left:
    """The conditions under which a RETURN has left a POU, or an EXIT a loop."""

    returns: Bool = False
    exits: Bool = False

    def all(self) -> Bool:
        """Return the condition under which the POU or the loop has been left."""
        return either(self.returns, self.exits)

    def take(self, other: _Left, under: Bool = True) -> None:
        """Add the conditions of statements that ran under a further condition."""
        self.returns = either(self.returns, both(under, other.returns))
        self.exits = either(self.exits, both(under, other.exits))


def _labelled(selector: Value, labels: Iterable[tuple[int, int]], kind: Type) -> Bool:
    """Return the condition that the selector of a CASE matches one of the labels of a branch."""
    return either(
        *(
            values.compare("=", selector, low, kind)
            if low == high
            else both(
                values.compare(">=", selector, low, kind),
                values.compare("<=", selector, high, kind),
            )
            for low, high in labels
        )
    )
