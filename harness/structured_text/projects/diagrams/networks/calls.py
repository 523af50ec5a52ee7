"""Calls of blocks and functions of a diagram, with EN and ENO.

A function with EN FALSE is not executed, and a block with EN FALSE is not called. ENO has the value
of EN, unless the POU declares it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from structured_text.errors import near
from structured_text.language.scalars import ANY_BIT, ANY_INT, ANY_REAL
from structured_text.language.standard import FUNCTIONS, conversion
from structured_text.projects.diagrams.networks.check import named, wrong
from structured_text.projects.diagrams.networks.expressions import (
    TRUE,
    Call,
    Expression,
    Text,
    Use,
    inverted,
)
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connection,
    Contact,
    Continuation,
    Element,
    Input,
    InVariable,
    Jump,
    Output,
    OutVariable,
    Return,
)
from structured_text.projects.diagrams.networks.operators import (
    applied,
    common,
    inputs_count,
    needs_context,
    result_type,
    standard_name,
)
from structured_text.projects.diagrams.networks.order import Graph
from structured_text.projects.diagrams.networks.statements import ANYTHING, OUTSIDE, Statements
from structured_text.projects.diagrams.networks.types import Callee, Types

__all__ = ["Blocks"]

_ENABLE, _ENABLED = "EN", "ENO"
#: Functions for which matiec computes with more bits than the type of the argument has, if the
#: argument is a sum or product. As Beremiz gives each result to a variable, it is cut to its type.
_COMPARISONS = ("GT", "GE", "EQ", "LE", "LT", "NE")
_WIDE = (*_COMPARISONS, "DIV", "MOD", "MAX", "MIN", "LIMIT", "MUX", "ABS")
#: The number of blocks on a line within which the type of a value is searched.
_FARTHEST = 8


class Owner(Protocol):
    """The translation that the blocks belong to."""

    def value(
        self, element: Element, pin: Input, *, ordered: bool = False, passed: bool = False
    ) -> Expression | None:
        """Return the value at an input."""

    def assign(
        self,
        element: Element,
        target: str,
        value: Expression,
        storage: str,
        guard: Expression | None = None,
    ) -> None:
        """Add an assignment."""


class Blocks:
    """Translates the blocks of a diagram."""

    def __init__(
        self, owner: Owner, statements: Statements, graph: Graph, types: Types, by_position: bool
    ) -> None:
        self._owner, self._statements, self._graph = owner, statements, graph
        self._types, self._by_position = types, by_position
        self._done: set[str] = set()
        self._open: set[str] = set()
        self._copies: dict[str, str] = {}
        self._places: dict[tuple[str, str], Expression] = {}

    def guard(self, lines: Sequence[Connection]) -> Expression | None:
        """Return the condition under which an output variable takes the value of a block.

        A variable behind a block with EN keeps its value while EN is FALSE.
        """
        if len(lines) != 1:
            return None
        block = self._graph.elements[lines[0].source]
        if not isinstance(block, Block) or not self._has_enable(block):
            return None
        if not self._by_position and self._graph.key(lines[0])[1] == _ENABLED:
            return None
        return self._enabled(block)

    def output(self, block: Block, pin: str, *, ordered: bool) -> Expression | None:
        """Return the value of an output pin, after the block was executed if it has to be."""
        self.execute(block, ordered=ordered)
        output = next((one for one in block.outputs if one.name.upper() == pin), None)
        if output is None:
            raise self._no_pin(block, pin, [one.name for one in block.outputs], "output")
        found = self._output(block, output)
        return inverted(found) if output.negated else found

    def _output(self, block: Block, output: Output) -> Expression:
        pin = output.name.upper()
        if pin == _ENABLED and not self._declares(block, _ENABLED):
            return self._enabled(block) if self._has_enable(block) else TRUE
        callee = self._callee(block)
        declared = callee.pin(pin) if callee is not None else None
        if block.instance and not self._is_function(block):
            kind = declared.type if declared is not None else ""
            if (block.id, pin) in self._places and not self._by_position:
                return self._places[block.id, pin]
            if self._by_position or block.id in self._open:
                return Text(f"{block.instance}.{output.name}", kind)
            return self._statements.use((block.id, pin), kind)
        if (block.id, pin) in self._places:
            return self._places[block.id, pin]
        return self._value_of((block.id, self._result_pin(block, pin)), block, pin)

    def _value_of(self, key: tuple[str, str], block: Block, pin: str) -> Use:
        kind = self._type_of(block, pin, frozenset())
        if not self._statements.is_bound(key):
            if not self._by_position:
                text = f"{named(block)} depends on its own result"
                raise wrong(block, text, "use a variable for the value of the last scan")
            self._statements.remember(key, block)
        return self._statements.use(key, kind)

    def execute(self, block: Block, *, ordered: bool) -> None:
        """Execute a block with its inputs, unless that was done or is not allowed now."""
        if block.id in self._done or ordered:
            return
        self._done.add(block.id)
        self._open.add(block.id)
        if block.statements:
            self._statements_of(block)
        elif self._is_function(block):
            self._function(block)
        else:
            self._call(block)
        self._open.discard(block.id)

    # --- parts of a block ---

    def _callee(self, block: Block) -> Callee | None:
        kind = self._types.of(block.instance) if block.instance else ""
        return (self._types.callee(kind) if kind else None) or self._types.callee(block.type)

    def _is_function(self, block: Block) -> bool:
        callee = self._callee(block)
        if callee is not None:
            return callee.kind == "FUNCTION"
        if block.instance:
            return False
        if not standard_name(block.type) and not block.statements:
            text = f"there is no function or block {block.type}"
            hint = "declare it, or add the library that declares it, or remove the block"
            raise wrong(block, text, hint)
        return True

    def _declares(self, block: Block, pin: str) -> bool:
        callee = self._callee(block)
        return callee is not None and callee.pin(pin) is not None

    def _has_enable(self, block: Block) -> bool:
        """Return whether EN of a block is connected and not a declared input."""
        return self._enable_pin(block) is not None and not self._declares(block, _ENABLE)

    def _enable_pin(self, block: Block) -> Input | None:
        for pin in block.inputs:
            if pin.name.upper() == _ENABLE and (pin.connections or pin.value.strip()):
                return pin
        return None

    def _inputs(self, block: Block) -> list[Input]:
        """Return the inputs of a block without EN, unless the POU declares it."""
        declared = self._declares(block, _ENABLE)
        return [pin for pin in block.inputs if declared or pin.name.upper() != _ENABLE]

    def _result_pin(self, block: Block, pin: str) -> str:
        """Return the pin of an output; that of the result of a function is empty."""
        callee = self._callee(block)
        if pin == _ENABLED:
            return pin
        return pin if callee is not None and callee.pin(pin) is not None else ""

    def _no_pin(self, block: Block, pin: str, known: Sequence[str], kind: str) -> Exception:
        text = f"{named(block)} has no {kind} {pin}"
        return wrong(block, text, near(pin, known, f"its {kind}s are"))

    def _enabled(self, block: Block) -> Expression:
        key = block.id, _ENABLED
        if not self._statements.is_bound(key):
            self._statements.remember(key, block)
        return self._statements.use(key, "BOOL")

    def _begin(self, block: Block, value: Expression | None) -> Expression | None:
        """Return the condition of a block from the value at EN; None if it is always executed.

        ENO gets the value. If it was read before, it gets the value behind the call, because the
        other inputs may read the value of the last scan.
        """
        key = block.id, _ENABLED
        if value is None:
            return None
        if self._statements.is_kept(key):
            name = self._statements.variable("Enable", str(block.network), "BOOL")
            text = f"{name} := {{0}};"
            self._statements.add(block, text, (name,), (value,), release=False)
            return Text(name, "BOOL")
        users = (*self._graph.user_ids(key), *self._guarded(block))
        self._statements.bind(key, block, value, users=users)
        return self._statements.use(key, "BOOL")

    def _end(self, block: Block, condition: Expression | None) -> None:
        """Give ENO its value behind the call, if that was not done before."""
        key = block.id, _ENABLED
        if condition is not None and not self._statements.is_bound(key):
            self._statements.bind(key, block, condition, users=self._guarded(block))

    def _guarded(self, block: Block) -> tuple[str, ...]:
        """Return the identities of the elements whose statements have EN as a condition."""
        found: list[str] = []
        for output in block.outputs:
            for element, _ in self._graph.users((block.id, output.name.upper())):
                if isinstance(element, OutVariable) and len(element.input.connections) == 1:
                    found.append(element.id)
        if len(found) == 1 and self._waits_for_output(block):
            return tuple(found)
        return (*found, block.id)

    def _waits_for_output(self, block: Block) -> bool:
        """Return whether a function is executed in the statement of one output variable alone."""
        if not self._is_function(block) or any(output.target.strip() for output in block.outputs):
            return False
        result = self._result_of(block)
        users = self._graph.users((block.id, result.name.upper())) if result is not None else ()
        return len(users) == 1 and self._is_guarded(users[0][0])

    # --- calls of blocks ---

    def _call(self, block: Block) -> None:
        callee = self._callee(block)
        if not block.instance and (callee is None or callee.kind not in ("PROGRAM", "ACTION")):
            text = f"{named(block)} has no instance"
            raise wrong(block, text, "declare a variable of its type, and name it at the block")
        name = block.instance or block.type
        arguments, changed, condition = self._arguments(block, callee)
        changed |= self._statements.target(name)
        if callee is None or not callee.standard:
            changed |= {OUTSIDE, ANYTHING}
        texts = [f"{pin} := {{{number}}}" for number, (pin, _) in enumerate(arguments)]
        values = [value for _, value in arguments]
        text = f"{name}({', '.join(texts)});"
        self._statements.add(block, text, changed, values, condition)
        self._end(block, condition)
        self._bind_outputs(block, callee)
        self._write_targets(block, condition)

    def _arguments(
        self, block: Block, callee: Callee | None
    ) -> tuple[list[tuple[str, Expression]], set[str], Expression | None]:
        """Return the values of the connected inputs, the variables for VAR_IN_OUT, and EN."""
        arguments: list[tuple[str, Expression]] = []
        changed: set[str] = set()
        enable: Expression | None = None
        for pin in block.inputs:
            ordered = block.order > 0
            if pin.name.upper() == _ENABLE and not self._declares(block, _ENABLE):
                enable = self._owner.value(block, pin, ordered=ordered)
                continue
            declared = callee.pin(pin.name) if callee is not None else None
            if callee is not None and declared is None:
                known = [one.name for one in callee.pins if one.section != "VAR_OUTPUT"]
                raise self._no_pin(block, pin.name, known, "input")
            passed = pin.in_out or (declared is not None and declared.section == "VAR_IN_OUT")
            value = self._owner.value(block, pin, ordered=ordered, passed=passed)
            if value is None and passed:
                raise self._no_variable(block, pin)
            if value is None:
                continue
            if passed:
                value = self._place(block, pin, value, declared.type if declared else "")
                changed |= self._statements.target(self._statements.written(value))
            arguments.append((pin.name, value))
        return arguments, changed, self._begin(block, enable)

    def _no_variable(self, block: Block, pin: Input) -> Exception:
        text = f"the input {pin.name} of {named(block)} is a VAR_IN_OUT and is not connected"
        return wrong(block, text, "connect a variable")

    def _place(self, block: Block, pin: Input, value: Expression, kind: str) -> Expression:
        """Return the variable for a VAR_IN_OUT; a value gets a variable of its own."""
        if isinstance(value, Use):
            self._statements.released(block)
            return Text(self._statements.keep(value.key), value.type)
        source = self._graph.elements[pin.connections[0].source] if pin.connections else None
        if isinstance(source, Block) and source.instance and isinstance(value, Text):
            output = self._graph.key(pin.connections[0])[1]
            if not self._by_position and (source.id, output) in self._places:
                self._places[block.id, pin.name.upper()] = value
                return value
            copy = f"{source.instance}_{output}"
            name = self._copies.get(copy)
            if name is None:
                name = self._statements.variable(source.instance, output, value.type or kind)
                self._copies[copy] = name
                self._statements.add(block, f"{name} := {{0}};", (name,), (value,), release=False)
            return Text(name, value.type or kind)
        if not isinstance(value, Text):
            raise self._no_variable(block, pin)
        self._places[block.id, pin.name.upper()] = value
        return value

    def _bind_outputs(self, block: Block, callee: Callee | None) -> None:
        if self._by_position:
            return
        for output in block.outputs:
            pin = output.name.upper()
            if pin == _ENABLED and not self._declares(block, _ENABLED):
                continue
            declared = callee.pin(pin) if callee is not None else None
            kind = declared.type if declared is not None else ""
            value = Text(f"{block.instance or block.type}.{output.name}", kind)
            self._statements.bind((block.id, pin), block, value)

    def _write_targets(self, block: Block, condition: Expression | None) -> None:
        for output in block.outputs:
            if output.target.strip():
                value = self._output(block, output)
                value = inverted(value) if output.negated else value
                guard = None if output.name.upper() == _ENABLED else condition
                self._owner.assign(block, output.target.strip(), value, output.storage, guard)

    # --- calls of functions ---

    def _function(self, block: Block) -> None:
        callee = self._callee(block)
        arguments, changed, condition = self._arguments(block, callee)
        if callee is not None:
            self._own_function(block, callee, arguments, changed, condition)
        else:
            self._standard_function(block, arguments, condition)
        self._end(block, condition)

    def _standard_function(
        self, block: Block, arguments: list[tuple[str, Expression]], condition: Expression | None
    ) -> None:
        name = standard_name(block.type)
        result = self._result_of(block)
        if not arguments and self._by_position:
            # Beremiz does not execute a function without a connected input.
            if self._statements.is_kept((block.id, "")):
                kind = self._type_of(block, result.name.upper() if result else "", frozenset())
                self._statements.result((block.id, ""), block, kind)
            return
        count, extensible = inputs_count(name)
        if len(arguments) < count or (len(arguments) < len(self._inputs(block)) and not extensible):
            given = {pin for pin, _ in arguments}
            missing = next((p.name for p in self._inputs(block) if p.name not in given), "")
            text = f"the input {missing} of {named(block)} is not connected".replace("  ", " ")
            raise wrong(block, text, "connect it to a variable or a literal")
        kinds = [value.type for _, value in arguments]
        expected = ""
        if result is not None and needs_context(name, kinds, self._types):
            expected = self._expected(block, result.name.upper(), frozenset())
        if self._by_position and name in _WIDE:
            for _, value in arguments:
                self._statements.cut(value)
        value = applied(name, arguments, self._types, expected)
        if not value.type or value.type.startswith("ANY"):
            value = self._with_type(value, expected)
        self._give(block, value, condition)

    def _with_type(self, value: Expression, expected: str) -> Expression:
        kind = expected or {"ANY_INT": "INT", "ANY_REAL": "REAL"}.get(value.type, "")
        return replace(value, type=kind) if kind else value

    def _own_function(
        self,
        block: Block,
        callee: Callee,
        arguments: list[tuple[str, Expression]],
        changed: set[str],
        condition: Expression | None,
    ) -> None:
        value = Call(callee.name, tuple(arguments), callee.result, not self._by_position)
        outputs = [
            (output, pin)
            for output in block.outputs
            if (pin := callee.pin(output.name)) is not None and pin.section == "VAR_OUTPUT"
        ]
        if not outputs and not changed:
            self._give(block, value, condition)
            return
        parts = [f"{pin} := {{{number}}}" for number, (pin, _) in enumerate(arguments)]
        kept = []
        for output, pin in outputs:
            key = block.id, output.name.upper()
            name = self._statements.result(key, block, pin.type)
            kept.append((key, Text(name, pin.type)))
            parts.append(f"{pin.name} => {name}")
            changed.add(name)
        text = f"{callee.name}({', '.join(parts)});"
        if callee.result:
            name = self._statements.result((block.id, ""), block, callee.result)
            kept.append(((block.id, ""), Text(name, callee.result)))
            text = f"{name} := {text}"
            changed.add(name)
        values = [value for _, value in arguments]
        self._statements.add(block, text, {*changed, ANYTHING, OUTSIDE}, values, condition)
        for key, variable in kept:
            self._statements.settle(key, variable)
        self._write_targets(block, condition)

    def _give(self, block: Block, value: Expression, condition: Expression | None) -> None:
        """Give a function's result to its target or to its users."""
        result = self._result_of(block)
        key = block.id, ""
        users = self._graph.users((block.id, result.name.upper())) if result is not None else ()
        target = result.target.strip() if result is not None else ""
        self._statements.released(block)
        if result is not None and target and not users:
            shown = inverted(value) if result.negated else value
            self._owner.assign(block, target, shown, result.storage, condition)
        elif users or target:
            guarded = self._waits_for_output(block)
            names = tuple(element.id for element, _ in users)
            again = (block.id,) if target else ()
            alone = all(self._is_guarded(element) for element, _ in users)
            otherwise = (
                ""
                if condition is None or alone or not self._by_position
                else (self._zero(value.type))
            )
            self._statements.bind(
                key, block, value, condition, users=(*names, *again), otherwise=otherwise
            )
            if condition is not None and not guarded and self._statements.waits(key):
                self._statements.keep(key, otherwise)
        elif isinstance(value, Call) and value.outside:
            self._statements.result(key, block, value.type)
            self._statements.bind(key, block, value, condition)
        for output in block.outputs:
            if output.target.strip() and (output is not result or users):
                shown = self._output(block, output)
                shown = inverted(shown) if output.negated else shown
                guard = None if output.name.upper() == _ENABLED else condition
                self._owner.assign(block, output.target.strip(), shown, output.storage, guard)

    def _is_guarded(self, element: Element) -> bool:
        return isinstance(element, OutVariable) and len(element.input.connections) == 1

    def _result_of(self, block: Block) -> Output | None:
        """Return the output of a function's result."""
        for output in block.outputs:
            if self._result_pin(block, output.name.upper()) == "":
                return output
        return None

    def _zero(self, kind: str) -> str:
        """Return the initial value of a type, which matiec gives to a function that is not run."""
        base = self._types.base(kind)
        if base in ANY_BIT:
            return "FALSE" if base == "BOOL" else f"{base}#0"
        if base in (*ANY_INT, *ANY_REAL):
            return "0" if base in ANY_INT else "0.0"
        return {"TIME": "T#0s", "STRING": "''"}.get(base, "")

    def _expected(self, block: Block, pin: str, seen: frozenset[str]) -> str:
        """Return the type that the users of an output expect; empty if it is unknown."""
        for output in block.outputs:
            if output.name.upper() == pin and output.target.strip():
                return self._types.of(output.target)
        for element, name in self._graph.users((block.id, pin)):
            found = self._expected_by(element, name, seen | {block.id})
            if found and not found.upper().startswith("ANY"):
                return found
        return ""

    def _expected_by(self, element: Element, name: str, seen: frozenset[str]) -> str:
        """Return the type that an element expects at an input; empty if it is unknown."""
        if isinstance(element, OutVariable):
            return self._types.of(element.expression)
        if not isinstance(element, Block):
            return "BOOL" if isinstance(element, (Coil, Contact, Jump, Return)) else ""
        callee = self._callee(element)
        if callee is not None:
            pin = callee.pin(name)
            return pin.type if pin is not None else ""
        function = standard_name(element.type)
        if element.id in seen or not function or len(seen) > _FARTHEST:
            return ""
        pair = conversion(function)
        if pair is not None:
            return pair[0]
        # The other inputs and the result of most standard functions have the same type.
        others = [one for one in self._inputs(element) if one.name != name]
        if function in ("SEL", "MUX"):
            others = others[1:] if self._inputs(element)[0].name != name else []
        kinds = [self._type_at(one, seen | {element.id}) for one in others]
        found = common([kind for kind in kinds if not kind.startswith("ANY")], self._types)
        result = self._result_of(element)
        same = function == "NOT" or (function in FUNCTIONS and FUNCTIONS[function].result == "T")
        if not found and same and result is not None:
            found = self._expected(element, result.name.upper(), seen)
        return found

    def _type_of(self, block: Block, pin: str, seen: frozenset[str]) -> str:
        """Return the type of an output from the types of the inputs, before it is computed."""
        callee = self._callee(block)
        if pin == _ENABLED:
            return "BOOL"
        if callee is not None:
            declared = callee.pin(pin)
            return declared.type if declared is not None else callee.result
        found = self._statements.kind_of((block.id, self._result_pin(block, pin)))
        if found or block.id in seen or len(seen) > _FARTHEST:
            return found
        kinds = [
            self._type_at(one, seen | {block.id})
            for one in self._inputs(block)
            if one.connections or one.value.strip()
        ]
        name = standard_name(block.type)
        expected = ""
        if needs_context(name, kinds, self._types):
            expected = self._expected(block, pin, seen)
        return result_type(name, kinds, self._types, expected)

    def _type_at(self, pin: Input, seen: frozenset[str]) -> str:
        """Return the type of the value at an input, from the first line with a known type."""
        if pin.value.strip():
            return self._types.of(pin.value)
        for line in pin.connections:
            source = self._graph.elements[line.source]
            if isinstance(source, Continuation):
                connector = self._graph.connectors[source.name.upper()]
                if connector.id in seen:
                    continue
                found = self._type_at(connector.input, seen | {connector.id})
            elif isinstance(source, Block):
                found = self._type_of(source, self._graph.key(line)[1], seen)
            elif isinstance(source, (InVariable, OutVariable)):
                found = self._types.of(source.expression)
            else:
                found = "BOOL"
            if found:
                return found
        return ""

    # --- execute boxes ---

    def _statements_of(self, block: Block) -> None:
        pin = self._enable_pin(block)
        condition = self._begin(block, self._owner.value(block, pin) if pin is not None else None)
        changed = {OUTSIDE, ANYTHING}
        for text in block.statements:
            changed |= self._statements.named(text)
        self._statements.add(block, block.statements, changed, (), condition)
