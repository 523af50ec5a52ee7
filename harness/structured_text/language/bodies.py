"""Checks the statements of POUs and builds their checked form."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.calls import ENABLING, block_arguments, enabling, pin_of
from structured_text.language.declare import Scope
from structured_text.language.expression_checker import ExpressionChecker
from structured_text.language.function_overloads import chosen_function
from structured_text.language.functions import same_text
from structured_text.language.memory import is_memory_function
from structured_text.language.methods import NOTHING
from structured_text.language.objects import START
from structured_text.language.parser import ACTION, CLASS
from structured_text.language.references import PLACES, place_of
from structured_text.language.registry import ConsequenceError
from structured_text.language.resolve import fills
from structured_text.language.scalars import ANY_BIT, ANY_INT, BOOL, ELEMENTARY, INT_RANGE, WIDTH
from structured_text.language.standard import BLOCKS, reserved
from structured_text.language.starting import Start, start_calls, start_of, starting
from structured_text.language.system import SPACE
from structured_text.language.types import (
    ArrayType,
    BlockType,
    EnumType,
    ReferenceType,
    Type,
    Variable,
    has_block,
    integer_name,
    type_name,
)
from structured_text.language.values import describe
from structured_text.language.walk import nodes, root_of
from structured_text.language.widening import widens

__all__ = ["check_body", "check_start", "root_of"]

_QUERIES = ("__QUERYINTERFACE", "__QUERYPOINTER")
#: Deepest nesting of statements and of loops. Python limits the depth of generated code.
_MOST_NESTED, _MOST_LOOPS = 64, 16


def check_body(
    scope: Scope, body: Iterable[s.Statement], report: Callable[[InputError], None]
) -> None:
    """Check the body of a POU and store it in `scope.pou`.

    After an error, checking continues with the next statement.
    """
    statements = _Statements(scope, report)
    scope.pou.body = statements.block(body)
    for one in nodes(scope.pou.body):
        if isinstance(one, t.Assigned) and (root := root_of(one.target)) is not None:
            statements.assigned.add(root)
    result = scope.pou.result
    is_function = scope.pou.kind == "FUNCTION"
    if is_function and result is not None and result not in statements.assigned:
        name = scope.where.node.name
        scope.note("a function that never sets its result", name.at)


def check_start(
    scope: Scope, sections: Iterable[s.Section], report: Callable[[InputError], None]
) -> None:
    """Check the initial values that are known only at run time.

    These are initial values of pointers, references and interfaces, calculated values, and the
    arguments of blocks. Each value becomes an assignment. In a function or method, the assignments
    stand before the body. A block gets a method `START` with the assignments.
    """
    pou, statements = scope.pou, _Statements(scope, report)
    start = statements.block(starting(sections, scope))
    if not start:
        return
    if pou.block is None:
        pou.body = (*start, *pou.body)
        if START in pou.words:  # this POU assigns the initial values of a list of globals
            scope.declarations.pous[pou.name.upper()] = pou
        return
    name = f"{pou.name}.{START.lower()}"
    method = t.Pou("METHOD", name, pou.file, {}, body=start, owner=pou, at=pou.at)
    scope.declarations.pous[name.upper()] = method
    scope.declarations.objects.own[pou.name.upper()][START.upper()] = method


class _Statements:
    """Checks the statements of one POU; `assigned` collects the written variables."""

    def __init__(self, scope: Scope, report: Callable[[InputError], None]) -> None:
        self._scope = scope
        self._report = report
        self._expressions = ExpressionChecker(scope)
        self._calls = _BlockCalls(self._expressions)
        self._loops = self._depth = 0
        # Nodes created here must stay alive, because `ExpressionChecker` caches by `id`.
        self._made: list[s.Expression] = []
        self.assigned: set[t.Symbol] = set()

    def block(self, statements: Iterable[s.Statement | Start]) -> tuple[t.Statement, ...]:
        """Check a list of statements.

        A statement with an error is reported and left out.
        """
        result: list[t.Statement] = []
        self._depth += 1
        for statement in statements:
            try:
                self._check_depth(statement)
                result += self._lowered(statement)
            except InputError as error:
                self._report(error)
        self._depth -= 1
        return tuple(result)

    def _check_depth(self, node: s.Statement | Start) -> None:
        hint = "move the inner ones into a function block; ELSIF instead of ELSE IF needs no depth"
        if self._depth > _MOST_NESTED:
            message = f"more than {_MOST_NESTED} statements inside each other"
        elif self._loops > _MOST_LOOPS:
            message = f"more than {_MOST_LOOPS} loops inside each other"
        else:
            return
        raise self._scope.error(message, node.at, hint)

    def _lowered(self, node: s.Statement | Start) -> Iterable[t.Statement]:
        """Check a statement, and return the checked statements that replace it."""
        if isinstance(node, s.AssignChain):
            return self._chain(node)
        if isinstance(node, (s.Assign, s.CallStatement)):
            if isinstance(node, s.Assign) and self._is_new(node.value):
                return self._new(node)
            enabled = self._enabled(node)
            if enabled is not None:
                return enabled
        if isinstance(node, s.CallStatement):
            return self._call(node)
        if isinstance(node, Start):
            return start_calls(node, self._expressions)
        return (self._statement(node),)

    def _statement(self, node: s.Statement) -> t.Statement:
        if isinstance(node, s.Assign):
            return self._assign(node.target, node.value, node.at)
        if isinstance(node, s.Latch):
            return self._bind(node) if node.op == "REF" else self._latch(node)
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
        if isinstance(node, s.Try):
            return self._try(node)
        if isinstance(node, s.Exit):
            if not self._loops:
                raise self._scope.error("EXIT stands outside a loop", node.at)
            return node
        if isinstance(node, s.Continue) and not self._loops:
            raise self._scope.error("CONTINUE stands outside a loop", node.at)
        assert isinstance(node, (s.Return, s.Continue))
        return node

    def _try(self, node: s.Try) -> t.Try:
        body = self.block(node.body)
        code = None
        if node.code is not None:
            kind = self._scope.declarations.type_named("EXCEPTIONCODE")
            code = self._target(node.code)
            if kind is None or code.type != kind:
                text = f"__CATCH needs a variable of {SPACE}.ExceptionCode"
                raise self._scope.error(f"{text}, not {describe(code.type)}", node.code.at)
        return t.Try(body, code, self.block(node.handler), self.block(node.last), node.at)

    def _is_new(self, node: s.Expression) -> bool:
        known = self._scope.declarations.pous
        return isinstance(node, s.Call) and node.function.key == "__NEW" and "__NEW" not in known

    def _new(self, node: s.Assign) -> list[t.Statement]:
        """Return the statements for `pointer := __NEW(…)`: assignment and call of `INIT`."""
        assert isinstance(node.value, s.Call)
        target = self._expressions.place(node.target)
        self._write(target)
        pointer, given = self._expressions.references.made(node.value, target.type)
        found: list[t.Statement] = [t.Assign(target, pointer, node.at)]
        kind = pointer.made if isinstance(pointer, t.New) else None
        starter = None
        if isinstance(kind, BlockType):
            starter = self._scope.declarations.objects.starter(kind.name.upper())
        if given is None and starter is None:
            return found
        if not isinstance(kind, BlockType):
            raise self._scope.error(f"{describe(target.type)} takes no arguments", node.at)
        instance = t.Deref(target, kind)
        calls = start_of(kind, instance, given or (), node.at, self._expressions)
        made = t.Same(
            "<>", target, t.Null(target.type), BOOL
        )  # `__NEW` returns 0 if no memory is free
        return [*found, t.If(((made, tuple(calls)),), (), node.at)]

    def _enabled(self, node: s.Assign | s.CallStatement) -> list[t.Statement] | None:
        """Return a call with EN or ENO as an IF; None for a statement without them.

        If EN is FALSE, the call is not executed: all outputs, and the target of the result, keep
        their values, and ENO is FALSE. After an executed call ENO is TRUE.
        """
        call = node.value if isinstance(node, s.Assign) else node
        if not isinstance(call, (s.Call, s.Invoke, s.CallStatement)):
            return None
        if all(one.name is None or one.name.key not in ENABLING for one in call.arguments):
            return None
        found = enabling(call, self._pins(call), self._scope)
        if not found:
            return None
        self._scope.note("EN or ENO", next(iter(found.values())).at)
        rest = tuple(one for one in call.arguments if one not in found.values())
        plain = replace(call, arguments=rest)
        inner: Any = plain if node is call else replace(node, value=plain)  # type: ignore[arg-type]
        self._made.append(inner)
        condition = self._condition(found["EN"].value) if "EN" in found else None
        then = [*self._lowered(inner), *self._flag(found.get("ENO"), "TRUE")]
        if condition is None:
            return then
        otherwise = tuple(self._flag(found.get("ENO"), "FALSE"))
        return [t.If(((condition, tuple(then)),), otherwise, node.at)]

    def _flag(self, argument: s.Argument | None, value: str) -> list[t.Statement]:
        """Return the assignment of `value` to the target of `ENO => target`.

        The result is empty if the call has no ENO.
        """
        if argument is None:
            return []
        literal = s.Literal("BOOLEAN", value, argument.at)
        self._made.append(literal)
        if not isinstance(argument.value, (*PLACES, s.Part)):
            raise self._scope.error("ENO needs a variable", argument.at)
        return [self._assign(argument.value, literal, argument.at)]

    def _pins(self, call: s.Call | s.Invoke | s.CallStatement) -> frozenset[str]:
        """Return the upper-case variable names of the called block, method or function."""
        callee = call.function if isinstance(call, s.Call) else call.callee
        callee = self._expressions.methods.bare(callee)
        method = self._expressions.methods.called(callee)
        if method is not None:
            return frozenset(method[1].symbols)
        if isinstance(callee, s.Name) and self._scope.symbol(callee.key) is None:
            keys = self._scope.registry.overloads.get(callee.key, [callee.key])
            pous = [self._scope.declarations.pous.get(key) for key in keys]
            if len(pous) > 1:
                return frozenset(key for one in pous if one is not None for key in one.symbols)
            pou = pous[0]
            return frozenset(pou.symbols if pou is not None else ())
        if not isinstance(callee, PLACES) or isinstance(call, (s.Call, s.Invoke)):
            return frozenset()
        kind = self._expressions.variable(callee).type
        pins = kind.variables if isinstance(kind, BlockType) else ()
        return frozenset(pin.name.upper() for pin in pins)

    def _condition(self, node: s.Expression) -> t.Expression:
        return self._expressions.check(node, BOOL)

    def _loop(self, body: tuple[s.Statement, ...]) -> tuple[t.Statement, ...]:
        self._loops += 1
        try:
            return self.block(body)
        finally:
            self._loops -= 1

    def _assign(self, to: s.Variable, value: s.Expression, at: s.Position) -> t.Assign | t.Evaluate:
        if isinstance(to, s.Part):
            return self._assign_part(to, value, at)
        setter = self._expressions.methods.setter(to)
        if setter is not None:
            instance, method, final = setter
            (pin,) = method.section("VAR_INPUT")[:1]
            given = (self._expressions.check(value, pin.type),)
            call = t.CallMethod(instance, method, final, given, (), (), NOTHING)
            return t.Evaluate(call, at)
        target = self._target(to)
        if isinstance(target.type, ArrayType) and target.type.open:
            text = "an array of open length cannot be assigned"
            raise self._scope.error(text, at, "assign its elements")
        if has_block(target.type):
            self._scope.note("the assignment of a block", at)
        return t.Assign(target, self._expressions.check(value, target.type), at)

    def _target(self, node: s.Variable) -> t.Variable:
        target = self._expressions.writable(node)
        self._write(target)
        return target

    def _assign_part(self, to: s.Part, value: s.Expression, at: s.Position) -> t.Assign:
        """Return the assignment that replaces a bit or part of a variable by a value.

        AND with a mask preserves the other bits. OR inserts the value, shifted to its position. For
        a single bit, SEL selects between both results, so that no conversion from BOOL is needed.
        """
        self._target(to.base)
        base, bits, first, kind = self._expressions.part(to)
        whole = bits.type
        part = self._expressions.check(value, kind)
        mask = ((1 << WIDTH.get(kind.name, 1)) - 1) << first
        rest = t.Constant(INT_RANGE[type_name(whole)][1] ^ mask, whole, True)
        others: t.Expression = t.Binary("AND", bits, rest, whole)
        if kind == BOOL:
            with_bit = t.Binary("OR", bits, t.Constant(mask, whole, True), whole)
            changed: t.Expression = t.Standard("SEL", (part, others, with_bit), whole)
        else:
            if kind != whole:
                part = t.Standard(f"{kind.name}_TO_{type_name(whole)}", (part,), whole)
            if first:
                count = t.Constant(first, ELEMENTARY["INT"])
                part = t.Standard("SHL", (part, count), whole)
            changed = t.Binary("OR", others, part, whole)
        name = integer_name(base.type)
        if name != type_name(whole):
            changed = t.Standard(f"{type_name(whole)}_TO_{name}", (changed,), ELEMENTARY[name])
        if isinstance(base.type, EnumType):
            changed = t.Standard("MOVE", (changed,), base.type)
        return t.Assign(base, changed, at)

    def _chain(self, node: s.AssignChain) -> list[t.Statement]:
        """Return the assignments for `a := b := value;`, from right to left.

        The last target gets the value, and every other target gets the value of the next one.
        """
        values = (*node.targets[1:], node.value)
        pairs = zip(node.targets, values, strict=True)
        return [self._assign(target, value, node.at) for target, value in reversed(list(pairs))]

    def _bind(self, node: s.Latch) -> t.Assign:
        """Return the assignment of a reference for `target REF= value;`."""
        target = self._expressions.place(node.target)
        if not isinstance(target.type, ReferenceType) or place_of(target) is None:
            raise self._scope.error(
                f"REF= needs a variable of REFERENCE TO, not a {describe(target.type)}", node.at
            )
        return t.Assign(target, self._expressions.check(node.value, target.type), node.at)

    def _latch(self, node: s.Latch) -> t.If:
        value = s.Literal("BOOLEAN", "TRUE" if node.op == "S" else "FALSE", node.at)
        self._made.append(value)
        then = self._assign(node.target, value, node.at)
        return t.If(((self._condition(node.value), (then,)),), (), node.at)

    def _call(self, node: s.CallStatement) -> list[t.Statement]:
        """Return a call of a block, method or function.

        Outputs that go to a bit or to a wider type are assigned in statements behind the call.
        """
        callee = self._expressions.methods.bare(node.callee)
        if node.bare:
            return self._named(replace(node, callee=callee))
        if isinstance(callee, s.This) and callee.above:
            return [self._calls.base(node)]
        method = self._expressions.methods.call(replace(node, callee=callee), value=False)
        if method is not None:
            return [t.Evaluate(method, node.at)]
        if isinstance(callee, s.Name) and self._scope.symbol(callee.key) is None:
            callee = chosen_function(callee, node.arguments, self._expressions)
        node = replace(node, callee=callee)
        if isinstance(callee, s.Name) and self._scope.symbol(callee.key) is None:
            pou = self._scope.declarations.pous.get(callee.key)
            if pou is None and callee.key == "__DELETE":
                return [t.Evaluate(self._expressions.references.deleted(node), node.at)]
            memory = is_memory_function(callee.key, self._expressions)
            if memory or (pou is None and callee.key in ("__NEW", *_QUERIES)):
                asked = s.Call(callee, node.arguments, node.at)
                self._made.append(asked)
                return [t.Evaluate(self._expressions.check(asked, None), node.at)]
            if pou is not None and pou.kind == "FUNCTION":
                if pou.result is not None:
                    self._scope.note("a result that is not used", node.at)
                call = s.Call(callee, node.arguments, node.at)
                self._made.append(call)
                found = self._expressions.functions.user(call, pou)
                for _, variable in (*found.in_outs, *found.outputs):
                    self._write(variable)
                return [t.Evaluate(found, node.at)]
        later = tuple(one for one in node.arguments if one.output and self._is_later(callee, one))
        plain = tuple(one for one in node.arguments if one not in later)
        found_call = self._calls.check(replace(node, arguments=plain))
        for _, variable in (*found_call.in_outs, *found_call.outputs):
            self._write(variable)
        behind = []
        for one in later:
            assert one.name is not None
            pin = s.Field(node.callee, one.name, one.at)
            self._made.append(pin)
            behind.append(self._assign(one.value, pin, node.at))  # type: ignore[arg-type]
        return [found_call, *behind]

    def _named(self, node: s.CallStatement) -> list[t.Statement]:
        """Return the statements for a name without parentheses.

        An ACTION is called, and a property is read. Any other variable is not changed, so there is
        no statement. A method needs parentheses (compiler error C0130 of CODESYS and TwinCAT).
        """
        callee, methods = node.callee, self._expressions.methods
        found = methods.called(callee)
        if found is not None and ACTION in found[1].words:
            call = methods.call(node, value=False)
            assert call is not None
            return [t.Evaluate(call, node.at)]
        if found is not None:
            text = f"the method {found[1].name} is named without parentheses"
            raise self._scope.error(text, node.at, "call it with ()")
        if isinstance(callee, s.Part):
            self._expressions.part(callee)
            return []
        if isinstance(callee, s.Name) and not self._expressions.is_variable(callee):
            pou = self._scope.declarations.pous.get(callee.key)
            if pou is not None or reserved(callee.key):
                text = f"{callee.text} is named without parentheses"
                raise self._scope.error(text, node.at, "call it with ()")
        if self._expressions.is_member(callee):
            return []
        value = self._expressions.variable(callee)
        return [t.Evaluate(value, node.at)] if isinstance(value, t.CallMethod) else []

    def _is_later(self, callee: s.Variable, argument: s.Argument) -> bool:
        """Return whether an output is assigned to a bit, or to a variable of a wider type."""
        value = argument.value
        if isinstance(value, s.Part) or not isinstance(value, PLACES):
            return isinstance(value, s.Part)
        block = self._expressions.variable(callee).type
        if not isinstance(block, BlockType) or argument.name is None:
            return False
        pin = pin_of(block, argument.name.text)
        found = self._expressions.infer(value)
        if pin is None or found is None:
            return False
        numbers = isinstance(pin.type, EnumType) or isinstance(found, EnumType)
        return widens(pin.type, found) or (numbers and pin.type != found)

    def _write(self, variable: t.Variable) -> None:
        root = root_of(variable)
        if root is not None:
            self.assigned.add(root)

    def _for(self, node: s.For) -> t.For:
        counter = self._target(node.counter)
        kind = counter.type
        if isinstance(kind, EnumType) and isinstance(counter, (t.Use, t.Member, t.Index, t.Deref)):
            # The loop counts in the base type of the enumeration. The tree does not show this, so
            # the construct is noted here.
            self._scope.note("an enumeration as a number", node.counter.at)
            kind = ELEMENTARY[kind.base]
            counter = replace(counter, type=kind)
        if not isinstance(counter, t.Use):
            self._scope.note("a FOR counter that is not a plain variable", node.counter.at)
        if type_name(kind) in ANY_BIT and kind != BOOL:
            self._scope.note("arithmetic of bit strings", node.counter.at, "a FOR counter")
        elif type_name(kind) not in ANY_INT:
            raise self._scope.error(
                f"a FOR needs an integer counter, not a {describe(kind)}", node.counter.at
            )
        start = self._start(node.start, kind)
        end = self._expressions.check(node.end, kind)
        step = self._step(node.step, kind) if node.step else t.Constant(1, kind)
        if isinstance(step, t.Constant) and step.value == 0:
            raise self._scope.error("a FOR loop with a step of 0 never ends", node.at)
        return t.For(counter, start, end, step, self._loop(node.body), node.at)

    def _start(self, node: s.Expression, kind: Type) -> t.Expression:
        """Check the start value of a FOR. SIMATIC AX silently converts a value of a wider type."""
        found = self._expressions.infer(node)
        wider = found != kind and type_name(found) in ANY_INT and type_name(kind) in ANY_INT
        if self._scope.registry.dialect.name != "ax" or not wider:
            return self._expressions.check(node, kind)
        self._scope.note("an implicit conversion", node.at, "the start of a FOR")
        found_value = self._expressions.check(node, None)
        return self._expressions.converted(found_value, ELEMENTARY[type_name(kind)])

    def _step(self, node: s.Expression, kind: Type) -> t.Expression:
        """Check the step of a FOR. An unsigned counter may also have a negative step."""
        found = self._expressions.fold(node)
        value = found.value if found is not None and not found.typed else 0
        if isinstance(value, int) and value < 0 and INT_RANGE[type_name(kind)][0] == 0:
            if -value > INT_RANGE[type_name(kind)][1]:
                raise self._scope.error(f"a step of {value} leaves {describe(kind)}", node.at)
            self._scope.note("a negative step of an unsigned counter", node.at)
            return t.Constant(value, kind)
        return self._expressions.check(node, kind)

    def _case(self, node: s.Case) -> t.Case:
        kind = self._expressions.infer(node.selector) or ELEMENTARY["DINT"]
        if type_name(kind) in WIDTH and type_name(kind) not in ANY_INT:
            self._scope.note("a CASE of bit strings", node.selector.at)
        elif not isinstance(kind, EnumType) and type_name(kind) not in ANY_INT:
            raise self._scope.error(
                f"CASE needs an integer or enumeration, not a {describe(kind)}", node.selector.at
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
        declarations, where = self._scope.declarations, self._scope.where
        declarations.local = self._scope.pou.symbols
        ends = (label.low, label.high) if isinstance(label, s.Range) else (label, label)
        low, high = (
            int(declarations.constant(end, kind, where, "a CASE label").value) for end in ends
        )
        if low > high:
            raise self._scope.error(f"the range {low}..{high} is empty", label.at)
        if any(low <= other_high and other_low <= high for other_low, other_high in seen):
            raise self._scope.error("this label occurs twice in the CASE", label.at)
        seen.append((low, high))
        return low, high


class _BlockCalls:
    """Checks the calls of blocks in one POU; `_Statements` uses this class."""

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions
        self._scope = expressions.scope

    def check(self, node: s.CallStatement) -> t.CallBlock:
        """Check and type a call of a block instance.

        Raises:
            InputError: The variable is not a block instance, the arguments do not fit, or a
                VAR_IN_OUT is missing.
        """
        instance = self._instance(node)
        declarations = self._scope.declarations
        if isinstance(instance, t.Use) and instance.symbol.source in declarations.programs:
            declarations.called.add(instance.symbol.source)
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

    def base(self, node: s.CallStatement) -> t.CallBase:
        """Check and type a call of the base block's body, `SUPER^()`.

        The base block gets the VAR_IN_OUT that were passed to the derived block. In a method these
        are not known, so the call raises InputError if there are any.
        """
        if self._scope.pou.owner is not None:
            pins = self._scope.pou.owner.section("VAR_IN_OUT")
            if pins:
                text = f"SUPER^() in a method, where the VAR_IN_OUT {pins[0].name} is not known"
                raise self._scope.error(text, node.at, "call it in the body")
        block = self._expressions.methods.this(node.at, above=True).type
        assert isinstance(block, BlockType)
        given = block_arguments(node, block, self._scope)
        types = {pin.name: pin.type for pin in block.variables if pin.section == "VAR_INPUT"}
        inputs = tuple(
            (name, self._expressions.check(given[name.upper()].value, kind))
            for name, kind in types.items()
            if name.upper() in given
        )
        return t.CallBase(block, inputs, node.at)

    def _instance(self, node: s.CallStatement) -> t.Variable:
        callee = node.callee
        if isinstance(callee, s.Name) and self._scope.symbol(callee.key) is None:
            pou = self._scope.declarations.pous.get(callee.key)
            if callee.key in BLOCKS or (pou is not None and pou.kind == "FUNCTION_BLOCK"):
                raise self._scope.error(
                    f"{callee.text} is a type of block", callee.at, "declare and call an instance"
                )
            if callee.key in self._scope.declarations.broken:
                raise ConsequenceError(f"{callee.text} has an error")
            if reserved(callee.key) or pou is not None:
                raise self._scope.error(
                    f"the result of {callee.text} is not used", callee.at, "assign it"
                )
        found = self._expressions.variable(callee)
        of_block = self._scope.declarations.pous.get(found.type.name.upper())
        if of_block is not None and CLASS in of_block.words:
            text = f"{of_block.name} is a CLASS and has no body"
            raise self._scope.error(text, callee.at, "call one of its methods")
        if not isinstance(found.type, BlockType):
            raise self._scope.error(
                f"a {describe(found.type)} cannot be called; only blocks can", callee.at
            )
        return found

    def _in_out(self, argument: s.Argument, pin: Variable, block: BlockType) -> t.Variable:
        value = argument.value
        if not isinstance(value, PLACES):
            raise self._scope.error(
                f"the VAR_IN_OUT {pin.name} of {block.name} needs a variable", argument.at
            )
        declarations, is_block = self._scope.declarations, isinstance(pin.type, BlockType)
        found = self._expressions.variable(value) if is_block else self._expressions.writable(value)
        below = is_block and declarations.objects.is_a(found.type, pin.type)
        if declarations.derives(found.type, pin.type):
            self._scope.note("a structure as its base", argument.at)
            below = True
        below = below or fills(found.type, pin.type)
        if found.type != pin.type and not same_text(found.type, pin.type) and not below:
            raise self._scope.error(
                f"{pin.name} of {block.name} needs a {describe(pin.type)},"
                f" not a {describe(found.type)}",
                argument.at,
            )
        part: t.Variable = found
        while isinstance(part, (t.Member, t.Index)):
            if isinstance(part.base.type, BlockType):
                self._scope.note("pins as VAR_IN_OUT", argument.at)
            part = part.base
        return found

    def _check_aliases(
        self, in_outs: list[tuple[str, t.Variable]], block: BlockType, node: s.CallStatement
    ) -> None:
        """Refuse a call that passes one variable under two names.

        Such a call behaves differently on each PLC.
        """
        reached = self._scope.declarations.externals(block)
        for position, (name, variable) in enumerate(in_outs):
            root = _path(variable)[0]
            if not isinstance(root, t.Symbol):
                continue
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
                f"use {', '.join(outputs)}",
            )
        assert isinstance(argument.value, PLACES)
        found = self._expressions.writable(argument.value)
        if found.type != pin.type and not same_text(found.type, pin.type):
            raise self._scope.error(
                f"{pin.name} is a {describe(pin.type)}, its target a {describe(found.type)}",
                argument.at,
            )
        return pin.name, found


def _path(variable: t.Variable) -> list[object]:
    """Return the path of a variable: its symbol, then each member name or index.

    An index that is not constant is None.
    """
    if isinstance(variable, t.Use):
        return [variable.symbol]
    if isinstance(variable, t.Member):
        return [*_path(variable.base), variable.name]
    if not isinstance(variable, t.Index):
        return [object()]  # The target of a pointer is known only at run time.
    indices = variable.indices
    known = all(isinstance(index, t.Constant) for index in indices)
    step = tuple(index.value for index in indices if isinstance(index, t.Constant))
    return [*_path(variable.base), step if known else None]


# Two variables overlap if one path is the beginning of the other: a whole contains its parts. An
# index that is known only at run time (None) may be any element, so it matches every index.
def _overlap(first: list[object], second: list[object]) -> bool:
    return all(a is None or b is None or a == b for a, b in zip(first, second, strict=False))
