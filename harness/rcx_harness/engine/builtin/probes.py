"""What coverage counts in a POU: statements, branches and decisions, numbered in their order.

A run of statements that are always executed one after the other has one counter. Branches are
counted by the run they begin with; those without statements (an IF without ELSE, a CASE in which
no label fits, a WHILE that does no round) have a counter of their own. FOR and REPEAT, which the
library does not use, have their statements counted only.

A decision is the condition of an IF, ELSIF, WHILE or REPEAT, and every other BOOL expression with
an operator. Its conditions are what AND, OR, XOR and NOT connect; a comparison is one condition.
Structured Text evaluates all of them each time, so that each evaluation is a full vector: the
condition k is its bit k.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from rcx_harness.engine.builtin.value import type_name
from rcx_harness.engine.deep import deeply
from rcx_harness.engine.frontend import tree as t

__all__ = ["Decision", "Plan"]

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
    return _is_logic(node)


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
    return ()
