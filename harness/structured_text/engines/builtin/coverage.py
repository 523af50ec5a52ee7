"""The plan of the coverage counters of a POU, and the code that counts; see `collector`.

A run is a sequence of statements that are always executed together; it has one counter. A decision
is a Boolean expression with numbered conditions. A vector has one bit for the value of each
condition. Each vector that occurs is recorded. Branch coverage and MC/DC are computed from the
recorded vectors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from structured_text.engines.builtin.expression_code import ExpressionCode
from structured_text.engines.builtin.standard import Value
from structured_text.engines.builtin.statements import Branches, Writer
from structured_text.engines.builtin.storage import Storage, slot_name
from structured_text.errors import VARIABLES
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.scalars import ANY_DATE, ANY_DURATION, ANY_REAL, ANY_STRING
from structured_text.language.source import NetworkLine
from structured_text.language.types import type_name
from structured_text.language.walk import nodes, parts

__all__ = ["CountingWriter", "Decision", "Plan", "Postfix", "outcome"]

#: A Boolean expression in postfix notation: numbers of its conditions, constants and operators.
Postfix = Sequence[int | bool | str]

_LAZY = ("AND_THEN", "OR_ELSE")
_LOGIC = ("AND", "OR", "XOR", *_LAZY)
_COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")


def outcome(code: Postfix, vector: int, skipped: int = 0) -> bool | None:
    """Return the value of an expression if each condition k has the value of bit k of `vector`.

    If bit k of `skipped` is set, the value of condition k is unknown.

    Returns:
        The value; None if it depends on conditions with an unknown value.
    """
    stack: list[bool | None] = []
    for one in code:
        if isinstance(one, bool):
            stack.append(one)
        elif isinstance(one, int):
            stack.append(None if skipped >> one & 1 else bool(vector >> one & 1))
        elif one == "NOT":
            value = stack.pop()
            stack.append(None if value is None else not value)
        else:
            stack.append(_joined(one, stack.pop(), stack.pop()))
    return stack.pop()


def _joined(op: str, left: bool | None, right: bool | None) -> bool | None:
    if op == "XOR":
        return None if left is None or right is None else left != right
    decisive = op in ("OR", "OR_ELSE")
    if left is decisive or right is decisive:
        return decisive
    return None if left is None or right is None else not decisive


@dataclass(frozen=True)
class Decision:
    """A Boolean expression and its conditions, from left to right.

    Attributes:
        root: The whole expression.
        conditions: Its operands that are not constants.
        line: First line of the statement that contains it.
        code: The expression in postfix notation.
        lazy: Whether conditions may be skipped. AND_THEN and OR_ELSE skip conditions without
            influence. The other operators skip such a condition if its evaluation could call a
            function or stop the program, because coverage must not change the behaviour of the
            program.
    """

    root: t.Expression
    conditions: tuple[t.Expression, ...]
    line: int
    code: Postfix = ()
    lazy: bool = False

    def outcome(self, vector: int) -> bool:
        """Return the decision's value if each condition k has the value of bit k of `vector`."""
        return bool(outcome(self.code, vector))


@dataclass
class Plan:
    """The numbers of counters and decisions in one POU.

    Attributes:
        run: The counter of the run that contains a statement, by the `id` of the statement.
        first: The counter of each run, by the `id` of its first statement.
        empty: The counter of the path that skips all bodies of a statement, by the `id` of the IF,
            CASE, WHILE or FOR.
        blank: The counters of empty bodies, in source order, by the `id` of the IF, CASE or loop.
        decisions: The decisions in source order.
        number: The index of a decision in `decisions`, by the `id` of its root.
    """

    size: int = 0
    run: dict[int, int] = field(default_factory=dict)
    first: dict[int, int] = field(default_factory=dict)
    guarded: int = 0
    empty: dict[int, int] = field(default_factory=dict)
    blank: dict[int, list[int]] = field(default_factory=dict)
    decisions: list[Decision] = field(default_factory=list)
    number: dict[int, int] = field(default_factory=dict)

    @classmethod
    def of(cls, pou: t.Pou) -> Plan:
        """Return the plan of a POU's body; equal sources get equal numbers."""
        plan = cls()
        plan._statements(pou.body)
        return plan

    def _count(self) -> int:
        self.size += 1
        return self.size - 1

    def body(self, node: t.Statement, body: tuple[t.Statement, ...], place: int = 0) -> int:
        """Return the counter of a body of an IF, CASE or loop.

        For a body without statements, `place` is its index among the empty bodies of `node`.
        """
        return self.run[id(body[0])] if body else self.blank[id(node)][place]

    def _body(self, node: t.Statement, body: tuple[t.Statement, ...]) -> None:
        if not body:
            self.blank.setdefault(id(node), []).append(self._count())
        self._statements(body)

    def _statements(self, statements: tuple[t.Statement, ...]) -> None:
        run: int | None = None
        for statement in statements:
            if run is None:
                run = self.first[id(statement)] = self._count()
            self.run[id(statement)] = run
            self._parts(statement)
            branches = isinstance(statement, (t.If, t.Case, t.For, t.While, t.Repeat, t.Try))
            if branches or self.guarded:
                run = None

    def _parts(self, node: t.Statement) -> None:
        line = node.at.line
        if isinstance(node, t.If):
            for condition, body in node.branches:
                self._decision(condition, line)
                self._body(node, body)
            self._statements(node.otherwise)
        elif isinstance(node, t.Case):
            self._expression(node.selector, line)
            for _, body in node.branches:
                self._body(node, body)
            self._statements(node.otherwise)
        elif isinstance(node, t.While):
            self._decision(node.condition, line)
            self._body(node, node.body)
        elif isinstance(node, t.Try):
            # Inside a `__TRY` an error may end any statement, so each statement has its own
            # counter.
            self.guarded += 1
            self._statements(node.body)
            self.guarded -= 1
            if node.code is not None:
                self._expression(node.code, line)
            self._statements(node.handler)
            self._statements(node.last)
        elif isinstance(node, t.Repeat):
            self._statements(node.body)
            self._decision(node.condition, line)
        elif isinstance(node, t.For):
            for part in (node.start, node.end, node.step):
                self._expression(part, line)
            self._body(node, node.body)
        elif isinstance(node, t.CallBlock):
            for _, value in node.inputs:
                self._passed(value, line)
            for _, value in (*node.in_outs, *node.outputs):
                self._expression(value, line)
        elif isinstance(node, t.Assign):
            self._expression(node.target, line)
            self._passed(node.value, line)
        else:
            for part in parts(node):
                self._expression(part, line)
        loop = isinstance(node, (t.While, t.For))
        if loop or (isinstance(node, (t.If, t.Case)) and not node.otherwise):
            self.empty[id(node)] = self._count()

    def _passed(self, node: t.Expression, line: int) -> None:
        """Find the decisions in a value that is assigned or passed to an input."""
        if _is_contact(node, line):
            self._decision(node, line)
        else:
            self._expression(node, line)

    def _expression(self, node: t.Expression, line: int) -> None:
        """Find the decisions in an expression that is not a decision itself."""
        if _is_operator(node):
            self._decision(node, line)
            return
        if isinstance(node, t.CallFunction):
            for value in node.arguments:
                if value is not None:
                    self._passed(value, line)
            for _, variable in (*node.in_outs, *node.outputs):
                self._expression(variable, line)
            return
        for part in parts(node):
            self._expression(part, line)

    def _decision(self, node: t.Expression, line: int) -> None:
        code, conditions = _postfix(node)
        if conditions:
            self.number[id(node)] = len(self.decisions)
            lazy = any(one in _LAZY for one in code) or any(map(_matters, conditions[1:]))
            self.decisions.append(Decision(node, conditions, line, code, lazy))
        for condition in conditions:
            for part in parts(condition):
                self._expression(part, line)


#: The parts of drawings that have contacts. A step or an action of a chart may be text.
_CONTACTS = ("rung", "network")


def _is_contact(node: t.Expression, line: int) -> bool:
    """Return whether a value is the only contact of a coil or of a block's input in a drawing.

    It is a decision: without it, `|--| |--( )--|` would be covered although the contact was never
    closed. A variable that holds the power of a rung was a decision at its own assignment.
    """
    if not isinstance(line, NetworkLine) or type_name(node.type) != "BOOL":
        return False
    if not line.network.startswith(_CONTACTS):
        return False
    while isinstance(node, (t.Member, t.Index)):
        node = node.base
    return isinstance(node, t.Use) and not node.symbol.name.startswith(VARIABLES)


def _is_operator(node: t.Expression) -> bool:
    """Return whether a node is an operation with a BOOL result; it is the root of a decision."""
    if isinstance(node, t.Binary):
        return node.op in _COMPARISONS or _is_logic(node)
    return isinstance(node, t.Same) or _is_logic(node)


def _is_logic(node: t.Expression) -> bool:
    if type_name(node.type) != "BOOL":
        return False
    return isinstance(node, t.Unary) or (isinstance(node, t.Binary) and node.op in _LOGIC)


def _postfix(node: t.Expression) -> tuple[Postfix, tuple[t.Expression, ...]]:
    """Return a decision in postfix notation, and its conditions from left to right."""
    code: list[int | bool | str] = []
    conditions: list[t.Expression] = []
    waiting: list[t.Expression | str] = [node]
    while waiting:
        one = waiting.pop()
        if isinstance(one, str):
            code.append(one)
        elif isinstance(one, (t.Unary, t.Binary)) and _is_logic(one):
            waiting += [one.op, *reversed(list(parts(one)))]
        elif isinstance(one, t.Constant):
            code.append(bool(one.value))
        else:
            code.append(len(conditions))
            conditions.append(one)
    return tuple(code), tuple(conditions)


def _matters(node: t.Expression) -> bool:
    """Return whether the evaluation of an expression can have a consequence other than its value.

    This is the case if the expression calls a function, or if it can stop the program: by an index,
    a division, a root, or the conversion of an infinite number.
    """
    return any(map(_does_more, nodes(node)))


def _does_more(one: Any) -> bool:
    if isinstance(one, t.CallFunction):
        return True
    if isinstance(one, t.Standard):
        source, is_conversion, target = one.name.partition("_TO_")
        if is_conversion:
            infinite = source in ANY_REAL and target not in _OF_ANY_REAL
            return infinite or (source in ANY_DATE and target in ANY_STRING)
        return one.name not in _SAFE
    if isinstance(one, t.Index):
        return not all(isinstance(k, t.Constant) for k in one.indices)
    if not isinstance(one, t.Binary):
        return False
    scaled = one.op == "*" and type_name(one.type) in ANY_DURATION
    return scaled or one.op in ("/", "MOD", "**")


#: Types to which an infinite REAL can be converted without an error.
_OF_ANY_REAL = (*ANY_REAL, *ANY_STRING, "BOOL")
#: Standard functions that are defined for every argument.
_SAFE = frozenset(
    (
        *("GT", "GE", "EQ", "LE", "LT", "ADD", "MUL", "AND", "OR", "XOR", "MOVE", "SEL", "ABS"),
        *("MAX", "MIN", "LIMIT", "SHL", "SHR", "ROL", "ROR", "LEN", "FIND", "LEFT", "RIGHT", "MID"),
    )
)

#: From this number of conditions on, the code of a vector is a sum instead of a chain of `|`.
_FEW = 50


class _CountingExpressions(ExpressionCode):
    """The writer of expressions that records the vector of conditions of each decision.

    For a decision without skipped conditions, the code computes all conditions, joins them to a
    vector and looks up the outcome in a dict. For a lazy decision, each evaluated condition reports
    its value through `see`, and Python's own operators decide which conditions are skipped.
    """

    def __init__(self, project: Project, pou: t.Pou, plan: Plan) -> None:
        super().__init__(project, pou)
        self._pou_name = slot_name(pou.name)
        self._plan = plan
        # The code that reports the value of a condition of a lazy decision, by the condition's
        # `id`.
        self._tells: dict[int, str] = {}

    def value(self, node: t.Expression) -> Value:
        """Return the code of an expression.

        If the expression is a decision that is not lazy, the code evaluates all its conditions.
        """
        tells = self._tells.pop(id(node), "")
        if tells:
            return Value(f"{tells}, {self.value(node).code})")
        number = self._plan.number.get(id(node))
        if number is None:
            return super().value(node)
        decision = self._plan.decisions[number]
        if decision.lazy:
            seen = f"q_{self._pou_name}[{number}]"
            told = {id(one): f"{seen}.see({k}" for k, one in enumerate(decision.conditions)}
            self._tells |= told
            return Value(f"{seen}.end({seen}.begin() or {super().value(node).code})")
        bits = [
            f"{super(_CountingExpressions, self).value(condition).code} << {k}"
            for k, condition in enumerate(decision.conditions)
        ]
        # Python cannot nest a long chain of operators. A sum is equivalent, because no two
        # conditions share a bit.
        vector = " | ".join(bits) if len(bits) < _FEW else f"sum(({', '.join(bits)}))"
        return Value(f"q_{self._pou_name}[{number}][{vector}]")


class CountingWriter(Writer):
    """The writer of a POU with coverage counters."""

    def __init__(self, project: Project, pou: t.Pou, storage: Storage, plan: Plan) -> None:
        super().__init__(project, pou, storage)
        self._plan = plan
        self._blank: list[list[int]] = []
        self._code = _CountingExpressions(project, pou, plan)
        self._code.pointing.storage = storage

    def _counted(self, number: int) -> str:
        return f"n_{slot_name(self._pou.name)}[{number}] += 1"

    def _statement(self, node: t.Statement) -> None:
        first = self._plan.first.get(id(node))
        if first is not None:
            self._emit(self._counted(first))
        super()._statement(node)

    def _branches(self, branches: Branches, node: t.If | t.Case) -> None:
        self._blank.append(list(self._plan.blank.get(id(node), ())))
        super()._branches(branches, node)
        self._blank.pop()

    def _nothing(self) -> None:
        self._emit(self._counted(self._blank[-1].pop(0)))

    def _no_branch(self, node: t.If | t.Case) -> None:
        super()._no_branch(node)
        empty = self._plan.empty.get(id(node))
        if empty is not None:
            self._at = node.at.line
            self._emit(f"else: {self._counted(empty)}")

    def _leave(self, condition: str, node: t.While | t.For) -> None:
        # The Python loop variable is 0 if the loop ends before its first round.
        self._emit(f"if {condition}:")
        self._emit(f"    if not _: {self._counted(self._plan.empty[id(node)])}")
        self._emit("    break")
        for number in self._plan.blank.get(id(node), ()):
            self._emit(self._counted(number))
