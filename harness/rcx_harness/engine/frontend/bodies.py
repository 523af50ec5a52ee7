"""Checks the statements of POUs and gives them their checked form."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.calls import block_arguments, pin_of
from rcx_harness.engine.frontend.constants import constant
from rcx_harness.engine.frontend.declare import Scope
from rcx_harness.engine.frontend.expressions import Expressions, group
from rcx_harness.engine.frontend.scalars import ANY_INT, BOOL
from rcx_harness.engine.frontend.standard import BLOCKS
from rcx_harness.engine.frontend.values import describe
from rcx_harness.engine.types import BlockType, EnumType, Type, Variable
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
        self._calls = _BlockCalls(self._expressions)
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
            return node
        return node

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


class _BlockCalls:
    """The block calls and assignment targets of one POU; shares its expressions."""

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._scope = expressions.scope

    def target(self, node: s.Variable) -> t.Variable:
        """A variable that is to be written.

        Raises:
            InputError: it cannot be written here: an input, a constant, a block or an output
                of a block.
        """
        known = not isinstance(node, s.Name) or self._scope.symbol(node.key) is not None
        if isinstance(node, s.Name) and not known and node.key in self._scope.registry.members:
            raise self._scope.error(f"{node.text} is a member of an enumeration", node.at)
        found = self._expressions.variable(node)
        if isinstance(found.type, BlockType):
            raise self._scope.error("a block cannot be assigned", node.at)
        part: t.Variable = found
        while not isinstance(part, t.Use):
            if isinstance(part, t.Member) and isinstance(part.base.type, BlockType):
                pin = pin_of(part.base.type, part.name)
                if pin is None or pin.section != "VAR_INPUT":
                    raise self._scope.error(
                        f"{part.name} is an output of {part.base.type.name}", node.at
                    )
            part = part.base
        symbol = part.symbol
        if symbol.section == "VAR_INPUT":
            raise self._scope.error(
                f"{symbol.name} is a VAR_INPUT and cannot be written inside",
                node.at,
                "copy it to a variable of its own",
            )
        external = symbol.section == "VAR_EXTERNAL"
        source = self._scope.declarations.globals.get(symbol.name.upper()) if external else None
        if symbol.constant or (source is not None and source.constant):
            raise self._scope.error(f"{symbol.name} is CONSTANT", node.at)
        return found

    def check(self, node: s.CallStatement) -> t.CallBlock:
        """Type a call of a block instance.

        Raises:
            InputError: no block instance, arguments that do not fit, or a VAR_IN_OUT left out.
        """
        instance = self._instance(node)
        block = instance.type
        assert isinstance(block, BlockType)
        given = block_arguments(node, block, self._scope)
        inputs: list[tuple[str, t.Expression]] = []
        in_outs: list[tuple[str, t.Variable]] = []
        for pin in block.variables:
            argument = given.get(pin.name.upper())
            if pin.section == "VAR_IN_OUT":
                if argument is None:
                    raise self._scope.error(
                        f"the VAR_IN_OUT {pin.name} of {block.name} is missing", node.at
                    )
                in_outs.append((pin.name, self._in_out(argument, pin, block)))
            elif argument is not None and pin.section == "VAR_INPUT":
                inputs.append((pin.name, self._expressions.check(argument.value, pin.type)))
        self._check_aliases(in_outs, block, node)
        outputs = [self._output(argument, block) for argument in node.arguments if argument.output]
        return t.CallBlock(instance, block, tuple(inputs), tuple(in_outs), tuple(outputs), node.at)

    def _instance(self, node: s.CallStatement) -> t.Variable:
        callee = node.callee
        if isinstance(callee, s.Name) and self._scope.symbol(callee.key) is None:
            pou = self._scope.declarations.pous.get(callee.key)
            if callee.key in BLOCKS or (pou is not None and pou.kind == "FUNCTION_BLOCK"):
                raise self._scope.error(
                    f"{callee.text} is a type of block", callee.at, "declare and call an instance"
                )
            if self._scope.registry.is_standard(callee.key) or pou is not None:
                raise self._scope.error(
                    f"the result of {callee.text} is not used", callee.at, "assign it"
                )
        found = self._expressions.variable(callee)
        if not isinstance(found.type, BlockType):
            raise self._scope.error(
                f"a {describe(found.type)} cannot be called; only blocks can", callee.at
            )
        return found

    def _in_out(self, argument: s.Argument, pin: Variable, block: BlockType) -> t.Variable:
        value = argument.value
        if not isinstance(value, (s.Name, s.Field, s.Index)):
            raise self._scope.error(
                f"the VAR_IN_OUT {pin.name} of {block.name} needs a variable", argument.at
            )
        found = self.target(value)
        if found.type != pin.type:
            raise self._scope.error(
                f"{pin.name} of {block.name} needs a {describe(pin.type)},"
                f" not a {describe(found.type)}",
                argument.at,
            )
        part: t.Variable = found
        while not isinstance(part, t.Use):
            if isinstance(part.base.type, BlockType):
                raise self._scope.error(
                    f"a pin of a block cannot be passed to the VAR_IN_OUT {pin.name}", argument.at
                )
            part = part.base
        return found

    def _check_aliases(
        self, in_outs: list[tuple[str, t.Variable]], block: BlockType, node: s.CallStatement
    ) -> None:
        """One variable under two names behaves differently on each PLC, so it is refused."""
        reached = self._scope.declarations.externals(block)
        for position, (name, variable) in enumerate(in_outs):
            root = _path(variable)[0]
            assert isinstance(root, t.Symbol)
            if root.section == "VAR_EXTERNAL" and root.name.upper() in reached:
                raise self._scope.error(
                    f"{block.name} also uses the global variable {root.name} itself", node.at
                )
            for other_name, other in in_outs[:position]:
                if _overlap(_path(variable), _path(other)):
                    raise self._scope.error(
                        f"{other_name} and {name} are given the same variable", node.at
                    )

    def _output(self, argument: s.Argument, block: BlockType) -> tuple[str, t.Variable]:
        assert argument.name is not None
        pin = pin_of(block, argument.name.text)
        if pin is None or pin.section != "VAR_OUTPUT":
            outputs = [pin.name for pin in block.variables if pin.section == "VAR_OUTPUT"]
            raise self._scope.error(
                f"{block.name} has no output {argument.name.text}",
                argument.at,
                f"it has {', '.join(outputs)}",
            )
        assert isinstance(argument.value, (s.Name, s.Field, s.Index))
        found = self.target(argument.value)
        if found.type != pin.type:
            raise self._scope.error(
                f"{pin.name} is a {describe(pin.type)}, its target a {describe(found.type)}",
                argument.at,
            )
        return pin.name, found


def _path(variable: t.Variable) -> list[object]:
    """The symbol, then each member name or constant index; None for an index unknown yet."""
    if isinstance(variable, t.Use):
        return [variable.symbol]
    if isinstance(variable, t.Member):
        return [*_path(variable.base), variable.name]
    indices = variable.indices
    known = all(isinstance(index, t.Constant) for index in indices)
    step = tuple(index.value for index in indices if isinstance(index, t.Constant))
    return [*_path(variable.base), step if known else None]


def _overlap(first: list[object], second: list[object]) -> bool:
    return all(a is None or b is None or a == b for a, b in zip(first, second, strict=False))
