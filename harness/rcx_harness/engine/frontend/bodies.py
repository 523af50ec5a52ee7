"""Checks the statements of POUs and gives them their checked form."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.blocks import BlockCalls
from rcx_harness.engine.frontend.constants import constant
from rcx_harness.engine.frontend.expressions import Expressions, Scope, group
from rcx_harness.engine.frontend.scalars import ANY_INT, BOOL
from rcx_harness.engine.frontend.values import describe
from rcx_harness.engine.types import EnumType, Type
from rcx_harness.errors import InputError

__all__ = ["check_body"]

#: Statements, and among them loops, that may lie inside each other: Python has its own limits.
_MOST_NESTED, _MOST_LOOPS = 64, 16


def check_body(
    scope: Scope, body: Iterable[s.Statement], report: Callable[[InputError], None]
) -> None:
    """Check the body of a POU and store it in `scope.pou`.

    Args:
        scope: The POU and its surroundings.
        body: Its statements as parsed.
        report: Takes each error; checking goes on with the next statement.
    """
    statements = _Statements(scope, report)
    scope.pou.body = statements.block(body)
    result = scope.pou.result
    if result is not None and result not in statements.assigned:
        name = scope.where.node.name
        report(scope.error(f"{name.text} never sets its result", name.at, f"assign to {name.text}"))


class _Statements:
    """The statements of one POU; `assigned` collects the variables that are written."""

    def __init__(self, scope: Scope, report: Callable[[InputError], None]) -> None:
        self._scope = scope
        self._report = report
        self._expressions = Expressions(scope)
        self._calls = BlockCalls(self._expressions)
        self._loops = self._depth = 0
        self.assigned: set[t.Symbol] = set()

    def block(self, statements: Iterable[s.Statement]) -> tuple[t.Statement, ...]:
        """Check a list of statements; those with an error are reported and left out."""
        result = []
        self._depth += 1
        for statement in statements:
            try:
                self._check_depth(statement)
                result.append(self._statement(statement))
            except InputError as error:
                self._report(error)
        self._depth -= 1
        return tuple(result)

    def _check_depth(self, node: s.Statement) -> None:
        hint = "move the inner ones into a function block; ELSIF instead of ELSE IF needs no depth"
        if self._depth > _MOST_NESTED:
            message = f"more than {_MOST_NESTED} statements inside each other"
        elif self._loops > _MOST_LOOPS:
            message = f"more than {_MOST_LOOPS} loops inside each other"
        else:
            return
        raise self._scope.error(message, node.at, hint)

    def _statement(self, node: s.Statement) -> t.Statement:
        if isinstance(node, s.Assign):
            return self._assign(node)
        if isinstance(node, s.CallStatement):
            return self._calls.check(node)
        if isinstance(node, s.If):
            branches = tuple(
                (self._condition(condition), self.block(body)) for condition, body in node.branches
            )
            return t.If(branches, self.block(node.otherwise), node.at)
        if isinstance(node, s.Case):
            return self._case(node)
        if isinstance(node, s.For):
            return self._for(node)
        if isinstance(node, s.While):
            return t.While(self._condition(node.condition), self._loop(node.body), node.at)
        if isinstance(node, s.Repeat):
            return t.Repeat(self._loop(node.body), self._condition(node.condition), node.at)
        if isinstance(node, s.Exit):
            if not self._loops:
                raise self._scope.error("EXIT outside a loop", node.at)
            return t.Exit(node.at)
        return t.Return(node.at)

    def _condition(self, node: s.Expression) -> t.Expression:
        return self._expressions.check(node, BOOL)

    def _loop(self, body: tuple[s.Statement, ...]) -> tuple[t.Statement, ...]:
        self._loops += 1
        try:
            return self.block(body)
        finally:
            self._loops -= 1

    def _assign(self, node: s.Assign) -> t.Assign:
        target = self._calls.target(node.target)
        root: t.Variable = target
        while not isinstance(root, t.Use):
            root = root.base
        self.assigned.add(root.symbol)
        return t.Assign(target, self._expressions.check(node.value, target.type), node.at)

    def _for(self, node: s.For) -> t.For:
        counter = self._calls.target(node.counter)
        kind = counter.type
        if not isinstance(counter, t.Use) or group(kind) not in ANY_INT:
            raise self._scope.error(
                f"a FOR needs an integer counter, not a {describe(kind)}", node.counter.at
            )
        start = self._expressions.check(node.start, kind)
        end = self._expressions.check(node.end, kind)
        step = self._expressions.check(node.step, kind) if node.step else t.Constant(1, kind)
        if isinstance(step, t.Constant) and step.value == 0:
            raise self._scope.error("a step of 0 never ends", node.at)
        return t.For(counter, start, end, step, self._loop(node.body), node.at)

    def _case(self, node: s.Case) -> t.Case:
        kind = self._expressions.infer(node.selector)
        if not isinstance(kind, EnumType) and group(kind) not in ANY_INT:
            shown = describe(kind) if kind is not None else "number"
            raise self._scope.error(
                f"CASE needs an integer or enumeration, not a {shown}", node.selector.at
            )
        selector = self._expressions.check(node.selector, kind)
        seen: list[tuple[int, int]] = []
        branches = []
        for branch in node.branches:
            labels = []
            for label in branch.labels:
                try:
                    labels.append(self._label(label, selector.type, seen))
                except InputError as error:
                    self._report(error)
            branches.append((tuple(labels), self.block(branch.body)))
        return t.Case(selector, tuple(branches), self.block(node.otherwise), node.at)

    def _label(
        self, label: s.Expression | s.Range, kind: Type, seen: list[tuple[int, int]]
    ) -> tuple[int, int]:
        types, where = self._scope.declarations.types, self._scope.where
        ends = (label.low, label.high) if isinstance(label, s.Range) else (label, label)
        low, high = (int(constant(end, kind, types, where).value) for end in ends)
        if low > high:
            raise self._scope.error(f"the range {low}..{high} is empty", label.at)
        if any(low <= other_high and other_low <= high for other_low, other_high in seen):
            raise self._scope.error("this label occurs twice in the CASE", label.at)
        seen.append((low, high))
        return low, high
