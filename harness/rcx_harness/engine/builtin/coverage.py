"""Counting which Structured Text is executed; off unless it is asked for.

With `RCX_COVERAGE=FOLDER` in the environment every program that the built-in engine compiles
counts, and each process writes what it has counted to a JSON file in that folder when it ends.
`RCX_COVERAGE_OF=FOLDER` limits this to the sources below a folder. All programs of a process
that have been compiled from one file share its counters.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from rcx_harness.engine.builtin.expressions import Expressions, Value, type_name
from rcx_harness.engine.builtin.statements import Writer
from rcx_harness.engine.builtin.storage import Storage, slot_name
from rcx_harness.engine.compiling import deeply
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.project import Project

__all__ = ["Collector", "CountingWriter", "Counts", "Decision", "Plan", "environment_collector"]

_LOGIC = ("AND", "OR", "XOR")
_COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")


@dataclass(frozen=True)
class Decision:
    """A Boolean expression and its conditions, from left to right.

    Attributes:
        root: The whole expression.
        conditions: Its operands that are no constants.
        line: Where the statement begins that it belongs to.
    """

    root: t.Expression
    conditions: tuple[t.Expression, ...]
    line: int

    def outcome(self, vector: int) -> bool:
        """What the expression gives where the condition k has the value of bit k."""
        numbers = {id(condition): k for k, condition in enumerate(self.conditions)}
        return deeply(lambda: _evaluate(self.root, vector, numbers))


def _evaluate(node: t.Expression, vector: int, numbers: dict[int, int]) -> bool:
    if id(node) in numbers:
        return bool(vector >> numbers[id(node)] & 1)
    if isinstance(node, t.Constant):
        return bool(node.value)
    if isinstance(node, t.Unary):
        return not _evaluate(node.operand, vector, numbers)
    assert isinstance(node, t.Binary)
    left = _evaluate(node.left, vector, numbers)
    right = _evaluate(node.right, vector, numbers)
    if node.op == "AND":
        return left and right
    return left or right if node.op == "OR" else left != right


@dataclass
class Plan:
    """The numbers of one POU.

    Attributes:
        size: How many counters there are.
        run: Counter of the run that a statement is in, by `id` of the statement.
        first: The same, of the first statement of each run only.
        empty: Counter of the branch without statements of an IF, CASE or WHILE, by its `id`.
        decisions: In their order.
        number: Number of a decision, by `id` of its root.
    """

    size: int = 0
    run: dict[int, int] = field(default_factory=dict)
    first: dict[int, int] = field(default_factory=dict)
    empty: dict[int, int] = field(default_factory=dict)
    decisions: list[Decision] = field(default_factory=list)
    number: dict[int, int] = field(default_factory=dict)

    @classmethod
    def of(cls, pou: t.Pou) -> Plan:
        """Number the body of a POU; the same source gives the same numbers."""
        plan = cls()
        plan._statements(pou.body)
        return plan

    def _count(self) -> int:
        self.size += 1
        return self.size - 1

    def _statements(self, statements: tuple[t.Statement, ...]) -> None:
        run: int | None = None
        for statement in statements:
            if run is None:
                run = self.first[id(statement)] = self._count()
            self.run[id(statement)] = run
            self._parts(statement)
            if isinstance(statement, (t.If, t.Case, t.For, t.While, t.Repeat)):
                run = None

    def _parts(self, node: t.Statement) -> None:
        line = node.at.line
        if isinstance(node, t.If):
            for condition, body in node.branches:
                self._decision(condition, line)
                self._statements(body)
            self._statements(node.otherwise)
        elif isinstance(node, t.Case):
            self._expression(node.selector, line)
            for _, body in node.branches:
                self._statements(body)
            self._statements(node.otherwise)
        elif isinstance(node, t.While):
            self._decision(node.condition, line)
            self._statements(node.body)
        elif isinstance(node, t.Repeat):
            self._statements(node.body)
            self._decision(node.condition, line)
        elif isinstance(node, t.For):
            for part in (node.start, node.end, node.step):
                self._expression(part, line)
            self._statements(node.body)
        elif isinstance(node, t.Assign):
            self._expression(node.target, line)
            self._expression(node.value, line)
        elif isinstance(node, t.CallBlock):
            for _, value in (*node.inputs, *node.in_outs, *node.outputs):
                self._expression(value, line)
        elif isinstance(node, t.Evaluate):
            self._expression(node.value, line)
        elif isinstance(node, t.CallBase):
            for _, value in node.inputs:
                self._expression(value, line)
        if isinstance(node, t.While) or (isinstance(node, (t.If, t.Case)) and not node.otherwise):
            self.empty[id(node)] = self._count()

    def _expression(self, node: t.Expression, line: int) -> None:
        """Find the decisions in an expression that decides nothing itself."""
        if _is_operator(node):
            self._decision(node, line)
            return
        for part in _parts(node):
            self._expression(part, line)

    def _decision(self, node: t.Expression, line: int) -> None:
        conditions = tuple(_conditions(node))
        if conditions:
            self.number[id(node)] = len(self.decisions)
            self.decisions.append(Decision(node, conditions, line))
        for condition in conditions:
            for part in _parts(condition):
                self._expression(part, line)


def _is_operator(node: t.Expression) -> bool:
    """Whether it is a BOOL expression with an operator of its own."""
    if isinstance(node, t.Binary):
        return node.op in _COMPARISONS or _is_logic(node)
    return isinstance(node, t.Same) or _is_logic(node)


def _is_logic(node: t.Expression) -> bool:
    if type_name(node.type) != "BOOL":
        return False
    return isinstance(node, t.Unary) or (isinstance(node, t.Binary) and node.op in _LOGIC)


def _conditions(node: t.Expression) -> Iterator[t.Expression]:
    waiting = [node]
    while waiting:
        one = waiting.pop()
        if _is_logic(one):
            waiting += reversed(_parts(one))
        elif not isinstance(one, t.Constant):
            yield one


def _parts(node: t.Expression) -> tuple[t.Expression, ...]:
    """The operands, arguments or indices of an expression."""
    if isinstance(node, t.Unary):
        return (node.operand,)
    if isinstance(node, t.Binary):
        return node.left, node.right
    if isinstance(node, t.Member):
        return (node.base,)
    if isinstance(node, t.Index):
        return node.base, *node.indices
    if isinstance(node, (t.CallFunction, t.Standard)):
        return tuple(argument for argument in node.arguments if argument is not None)
    if isinstance(node, t.CallMethod):
        given = tuple(argument for argument in node.arguments if argument is not None)
        return node.instance, *given, *(value for _, value in (*node.in_outs, *node.outputs))
    if isinstance(node, t.Deref):
        return (node.base,) if node.offset is None else (node.base, node.offset)
    if isinstance(node, t.Address):
        return (node.variable,)
    if isinstance(node, t.Offset):
        return node.base, node.bytes
    if isinstance(node, t.Valid):
        return (node.reference,)
    if isinstance(node, t.Recast):
        return (node.base,)
    return (node.left, node.right) if isinstance(node, t.Same) else ()


#: Conditions of a decision that are put together by an operator each.
_FEW = 50


class Seen(dict[int, bool]):
    """The vectors in which a decision has been evaluated, each with its outcome."""

    def __init__(self, decision: Decision) -> None:
        super().__init__()
        self._decision = decision

    def __missing__(self, vector: int) -> bool:
        outcome = self[vector] = self._decision.outcome(vector)
        return outcome


class Counts:
    """What has been counted in one POU.

    Attributes:
        counters: How often each run of statements and each empty branch was executed.
        seen: The vectors of each decision.
    """

    def __init__(self, plan: Plan) -> None:
        self.counters = [0] * plan.size
        self.seen = [Seen(decision) for decision in plan.decisions]


class Collector:
    """The counts of all sources below a folder.

    Args:
        folder: The sources; None for all.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = folder.resolve() if folder else None
        self._counts: dict[tuple[str, str, str], Counts] = {}

    def counts(self, pou: t.Pou, plan: Plan) -> Counts | None:
        """Where a POU counts; None if its source is none of those counted."""
        file = _resolved(pou.file)
        if self._folder is not None and self._folder not in file.parents:
            return None
        key = str(file), _hash(file, file.stat().st_mtime_ns), pou.name.upper()
        if key not in self._counts:
            self._counts[key] = Counts(plan)
        return self._counts[key]

    def data(self) -> list[dict[str, Any]]:
        """The counts of each POU, as JSON."""
        return [
            {
                "file": file,
                "hash": text,
                "pou": name,
                "counters": counts.counters,
                "seen": [sorted(int(vector) for vector in seen) for seen in counts.seen],
            }
            for (file, text, name), counts in self._counts.items()
        ]

    def write(self, folder: Path) -> None:
        """Write the counts of this process, if it has any."""
        if self._counts:
            folder.mkdir(parents=True, exist_ok=True)
            target = folder / f"{os.getpid()}-{os.urandom(4).hex()}.json"
            target.write_text(json.dumps(self.data()), encoding="utf-8")


@lru_cache(maxsize=1024)
def _resolved(file: str) -> Path:
    return Path(file).resolve()


@lru_cache(maxsize=1024)
def _hash(file: Path, stamp: int) -> str:
    """A hash of the file as it was at `stamp`."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


@lru_cache(maxsize=1)
def environment_collector() -> Collector | None:
    """The collector that the environment asks for, which writes at the end of the process."""
    folder = os.environ.get("RCX_COVERAGE")
    if not folder:
        return None
    below = os.environ.get("RCX_COVERAGE_OF")
    collector = Collector(Path(below) if below else None)
    atexit.register(collector.write, Path(folder).absolute())
    return collector


class _CountingExpressions(Expressions):
    """Expressions whose decisions are looked up by the vector of their conditions."""

    def __init__(self, project: Project, pou: t.Pou, plan: Plan) -> None:
        super().__init__(project, pou)
        self._pou_name = slot_name(pou.name)
        self._plan = plan

    def value(self, node: t.Expression) -> Value:
        """Code of an expression; all conditions of a decision are evaluated."""
        number = self._plan.number.get(id(node))
        if number is None:
            return super().value(node)
        bits = [
            f"{super(_CountingExpressions, self).value(condition).code} << {k}"
            for k, condition in enumerate(self._plan.decisions[number].conditions)
        ]
        # A long chain of operators would be too deep for Python; the bits are different ones.
        vector = " | ".join(bits) if len(bits) < _FEW else f"sum(({', '.join(bits)}))"
        return Value(f"q_{self._pou_name}[{number}][{vector}]")


class CountingWriter(Writer):
    """Writes a POU that counts.

    Args:
        project: The project.
        pou: The POU to write.
        storage: For copies of structures and arrays.
        plan: Its numbers.
    """

    def __init__(self, project: Project, pou: t.Pou, storage: Storage, plan: Plan) -> None:
        super().__init__(project, pou, storage)
        self._plan = plan
        self._code = _CountingExpressions(project, pou, plan)
        self._code.pointing.storage = storage

    def _counted(self, number: int) -> str:
        return f"n_{slot_name(self._pou.name)}[{number}] += 1"

    def _statement(self, node: t.Statement) -> None:
        first = self._plan.first.get(id(node))
        if first is not None:
            self._emit(self._counted(first))
        super()._statement(node)

    def _no_branch(self, node: t.If | t.Case) -> None:
        super()._no_branch(node)
        empty = self._plan.empty.get(id(node))
        if empty is not None:
            self._at = node.at.line
            self._emit(f"else: {self._counted(empty)}")

    def _while(self, node: t.While) -> None:
        # The Python variable of the loop is 0 where its end comes before the first round.
        self._emit("for _ in FUSE:")
        self._depth += 1
        self._emit(f"if not {self._code.exact(node.condition)}:")
        self._emit(f"    if not _: {self._counted(self._plan.empty[id(node)])}")
        self._emit("    break")
        self._statements(node.body)
        self._loop(node.at.line)
