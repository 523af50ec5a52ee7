"""The mutation operators: one function per kind of mistake, which yields edits of the text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, NamedTuple

from structured_text.language import syntax as s
from structured_text.language.types import ArrayType, BlockType, EnumType, StructType, Type
from structured_text.language.walk import bodies, declared, nodes
from structured_text.mutants.text import Edit, Span
from structured_text.mutants.walk import Body, Place, places

__all__ = ["OPERATORS", "Change", "changes", "changes_nothing", "constants"]

#: The operators by name, each with a description of the change.
OPERATORS = {
    "relational": "another comparison: < for <=, <> for =",
    "wrap": "< or > for <> of counters, which holds until they wrap",
    "boolean": "OR for AND, AND for OR",
    "operand": "one operand of AND or OR is left out: a guard or a hold is missing",
    "negation": "a NOT is missing or superfluous",
    "condition": "a condition is always TRUE or always FALSE",
    "arithmetic": "- for +, * for /, / for MOD",
    "off-by-one": "an index, offset, bit number or limit one too large or too small",
    "mask": "a bit pattern with its bits one place away",
    "code": "another command code, status or state word",
    "error-id": "another ErrorID",
    "constant": "another BOOL, REAL, TIME, text or member of the enumeration",
    "time-out": "the Q of a timer counts as FALSE or TRUE, or its IN is always TRUE",
    "dropped reset": "an output or a state is not cleared",
    "dropped assignment": "another assignment is missing",
    "dropped call": "a call is missing",
    "neighbour": "the next or previous field or variable, as after copy and paste",
    "swapped": "two arguments exchanged; high word for low word; SHR for SHL",
    "labels": "the labels of two branches of a CASE exchanged",
    "cancel": "a falling Execute clears the output",
    "default": "another default of an input, or another initial value",
}


class Change(NamedTuple):
    """One mistake in a body; `operator` is a name of OPERATORS."""

    operator: str
    edits: tuple[Edit, ...]


_RELATIONAL = {
    "=": ("<>",),
    "<>": ("=",),
    "<": ("<=", ">="),
    ">": (">=", "<="),
    "<=": ("<", ">"),
    ">=": (">", "<"),
}
_ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "MOD": "/"}
#: Words in names of functions that programmers easily confuse.
_TWINS = {"SHL": "SHR", "SHR": "SHL", "LOW": "HIGH", "HIGH": "LOW"}
_TWIN = re.compile("^SHL$|^SHR$|LOW|HIGH")
_COUNTERS = ("SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT")
_NOTHING = ("FALSE", "0", "0.0", "''", "BYTE#16#00", "WORD#16#0000", "DWORD#16#00000000")


def changes(body: Body) -> Iterator[Change]:
    """Yield every change that the operators can make in a POU, in order.

    The changes need not be type-correct, because the checker removes changes with errors.
    """
    for place in places(body):
        for operator in _OPERATORS:
            yield from operator(place, body)
    yield from _cancel(body)
    yield from _defaults(body)


def _one(operator: str, span: Span, text: str) -> Change:
    return Change(operator, (Edit(span, text),))


def _text(body: Body, span: Span) -> str:
    return body.source.text[span.start : span.end]


def _relational(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.Binary):
        span = body.source.operator(node)
        for other in _RELATIONAL.get(node.op, ()):
            yield _one("relational", span, other)
        if node.op == "<>" and body.type_name(node.left) in _COUNTERS:
            yield _one("wrap", span, "<")
            yield _one("wrap", span, ">")


def _boolean(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.Binary) and node.op in ("AND", "OR"):
        other = "OR" if node.op == "AND" else "AND"
        whole = body.source.span(node)
        left, right = body.source.operands(node)
        # The whole expression gets parentheses, because AND binds more tightly than OR.
        edits = (Edit(body.source.operator(node), other),)
        around = (Edit(Span(whole.start, whole.start), "("), Edit(Span(whole.end, whole.end), ")"))
        yield Change("boolean", (*edits, *around))
        yield _one("operand", whole, _text(body, left))
        yield _one("operand", whole, _text(body, right))


def _negation(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.Unary) and node.op == "NOT":
        yield _one("negation", body.source.span(node), _text(body, body.source.operand(node)))
    variable = isinstance(node, (s.Name, s.Field, s.Index))
    if variable and not place.written and not place.denied and body.type_name(node) == "BOOL":
        start = body.source.span(node).start
        yield _one("negation", Span(start, start), "NOT ")


def _condition(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.If):
        for condition, _ in node.branches:
            for value in ("TRUE", "FALSE"):
                yield _one("condition", body.source.span(condition), value)
    elif isinstance(node, s.While):
        yield _one("condition", body.source.span(node.condition), "FALSE")
    elif isinstance(node, s.Repeat):
        yield _one("condition", body.source.span(node.condition), "TRUE")


def _arithmetic(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.Binary) and node.op in _ARITHMETIC:
        yield _one("arithmetic", body.source.operator(node), _ARITHMETIC[node.op])


def _constant(place: Place, body: Body) -> Iterator[Change]:
    for operator, span, text in constants(place, body):
        yield _one(operator, span, text)


def _time_out(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.Field) and node.name.key == "Q" and body.type_name(node.base) == "TON":
        for value in ("FALSE", "TRUE"):
            yield _one("time-out", body.source.span(node), value)
    if isinstance(node, s.CallStatement) and body.type_name(node.callee) == "TON":
        for argument in node.arguments:
            if argument.name is not None and argument.name.key == "IN":
                start = body.source.token_after(body.source.span(argument.name), "ASSIGN").end
                span = Span(start, body.source.span(argument).end)
                if not isinstance(argument.value, s.Literal):
                    yield _one("time-out", span, " TRUE")


def _dropped(place: Place, body: Body) -> Iterator[Change]:
    """Yield the removal of a statement.

    The only statement of a branch moves into an `IF FALSE`, because a branch must not be empty.
    """
    node = place.node
    if isinstance(node, s.Assign):
        reset = body.source.of(node.value) in _NOTHING
        if reset and changes_nothing(node, body):
            return
        operator = "dropped reset" if reset else "dropped assignment"
    elif isinstance(node, s.CallStatement):
        operator = "dropped call"
    elif isinstance(node, (s.AssignChain, s.Latch)):
        operator = "dropped assignment"
    else:
        return
    span = body.source.span(node)
    if place.alone:
        yield _one(operator, span, f"IF FALSE THEN {_text(body, span)} END_IF;")
    else:
        yield _one(operator, span, "")


def _neighbour(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.Field):
        other = _next_field(node, body)
        if other:
            yield _one("neighbour", body.source.span(node.name), other)
    elif isinstance(node, s.Name):
        symbol = body.scope.symbol(node.key)
        if symbol is not None and symbol.section != "RESULT":
            alike = [
                one.name
                for one in body.symbols()
                if one.section == symbol.section and one.type == symbol.type
            ]
            if len(alike) > 1:
                other = alike[(alike.index(symbol.name) + 1) % len(alike)]
                yield _one("neighbour", body.source.span(node), other)


def _next_field(node: s.Field, body: Body) -> str:
    kind = body.type_of(node.base)
    if isinstance(kind, StructType):
        pairs = list(kind.fields)
    elif isinstance(kind, BlockType):
        pairs = [(pin.name, pin.type) for pin in kind.variables if pin.section == "VAR_OUTPUT"]
    else:
        return ""
    names = {name.upper(): (name, field) for name, field in pairs}
    if node.name.key not in names:
        return ""
    found, wanted = names[node.name.key]
    alike = [name for name, field in pairs if field == wanted]
    return alike[(alike.index(found) + 1) % len(alike)] if len(alike) > 1 else ""


def _swapped(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    twin = _twin(node.function.key, body) if isinstance(node, s.Call) else None
    if twin is not None:
        yield _one("swapped", body.source.span(node.function), twin)
    if isinstance(node, (s.Call, s.CallStatement)):
        inputs = [one for one in node.arguments if not one.output and one.name is not None]
        for first, second in pairwise(inputs):
            kind = body.type_of(first.value)
            if kind is not None and kind == body.type_of(second.value):
                spans = [_value(first, body), _value(second, body)]
                texts = [_text(body, span) for span in spans]
                if texts[0] != texts[1] and not isinstance(kind, (ArrayType, BlockType)):
                    edits = (Edit(spans[0], texts[1]), Edit(spans[1], texts[0]))
                    yield Change("swapped", edits)


def _twin(function: str, body: Body) -> str | None:
    """Return the function that is easily confused with this one, or None.

    Examples are SHR instead of SHL, and the function for the high word instead of the low word.
    """
    other = _TWIN.sub(lambda found: _TWINS[found[0]], function)
    if function in ("SHL", "SHR"):
        return other
    found = body.scope.declarations.registry.pous.get(other) if other != function else None
    return found.node.name.text if found is not None else None


def _value(argument: s.Argument, body: Body) -> Span:
    """Return the span of a named argument's value, including parentheses around the value."""
    assert argument.name is not None
    whole = body.source.span(argument)
    start = body.source.token_after(body.source.span(argument.name), "ASSIGN").end + 1
    return Span(start, whole.end)


def _labels(place: Place, body: Body) -> Iterator[Change]:
    node = place.node
    if isinstance(node, s.Case):
        for first, second in pairwise(node.branches):
            pair = (first.labels[0], second.labels[0])
            if len(first.labels) == len(second.labels) == 1 and not any(
                isinstance(label, s.Range) for label in pair
            ):
                spans = [body.source.span(label) for label in pair]
                edits = (
                    Edit(spans[0], _text(body, spans[1])),
                    Edit(spans[1], _text(body, spans[0])),
                )
                yield Change("labels", edits)


def _cancel(body: Body) -> Iterator[Change]:
    """Yield changes at the end of a block that clear an output while Execute is FALSE."""
    execute = body.scope.symbol("EXECUTE")
    if execute is None or not body.pou.body:
        return
    end = body.source.span(body.pou.body[-1]).end
    for symbol in body.symbols():
        if symbol.section == "VAR_OUTPUT" and getattr(symbol.type, "name", "") == "BOOL":
            text = f"\n  {symbol.name} := {symbol.name} AND Execute;"
            yield _one("cancel", Span(end, end), text)


def _defaults(body: Body) -> Iterator[Change]:
    for section in body.pou.sections:
        for declaration in section.variables:
            if isinstance(declaration.initial, (s.Literal, s.Name)):
                place = Place(declaration.initial)
                kind = body.scope.symbol(declaration.names[0].key)
                for _, span, text in constants(place, body, kind.type if kind else None):
                    yield _one("default", span, text)


_OPERATORS: tuple[Callable[[Place, Body], Iterator[Change]], ...] = (
    _relational,
    _boolean,
    _negation,
    _condition,
    _arithmetic,
    _constant,
    _time_out,
    _dropped,
    _neighbour,
    _swapped,
    _labels,
)


def changes_nothing(node: s.Assign, body: Body) -> bool:
    """Return whether an assignment sets a variable of a function to the value it already has.

    This is so if the value is the default value, the declaration sets no other value, and no
    earlier statement in the function writes the variable. The library has such lines because some
    compilers require them.
    """
    if body.scope.pou.kind != "FUNCTION" or not isinstance(node.target, s.Name):
        return False
    symbol = body.scope.symbol(node.target.key)
    if symbol is None or symbol.section not in ("VAR", "RESULT"):
        return False
    is_set = any(
        one.initial is not None and node.target.key == name.key
        for _, one, name in declared(body.pou.sections)
    )
    return not is_set and not _written_before(body.pou.body, node, node.target.key)


def _written_before(statements: tuple[Any, ...], node: s.Assign, key: str) -> bool:
    """Return whether the variable may have been written before the statement is reached."""
    for statement in statements:
        if statement is node:
            return False
        if not any(one is node for one in nodes(statement)):
            if _writes(statement, key):
                return True
        elif isinstance(statement, (s.If, s.Case)):
            inner = next(branch for branch in bodies(statement) if _holds(branch, node))
            return _written_before(inner, node, key)
        else:  # In a loop, later statements may have run in an earlier round.
            return True
    return True


def _holds(branch: tuple[Any, ...], node: s.Assign) -> bool:
    return any(one is node for one in nodes(branch))


def _writes(statement: Any, key: str) -> bool:
    return any(
        isinstance(one, s.Assign) and isinstance(one.target, s.Name) and one.target.key == key
        for one in nodes(statement)
    )


_BITS = re.compile(r"(BYTE|WORD|DWORD)#16#([0-9A-F]+)", re.IGNORECASE)
_TIME = re.compile(r"T#(\d+)(ms|s|m)", re.IGNORECASE)
_TYPED_INTEGER = re.compile(r"(U?[SDL]?INT)#(\d+)", re.IGNORECASE)
#: ErrorIDs of the library, see docs/reference/errors.md.
_ERRORS = range(0x8000, 0x8100)


def constants(
    place: Place, body: Body, kind: Type | None = None
) -> Iterator[tuple[str, Span, str]]:
    """Yield other values of a literal or a member of an enumeration.

    `kind` is the type that the context requires, if it requires one.

    Yields:
        The operator, the replaced span, and the new text.
    """
    node = place.node
    if isinstance(node, s.Literal):
        span = body.source.span(node)
        for operator, text in _literal(node):
            yield operator, span, text
    elif isinstance(node, s.Name) and body.scope.symbol(node.key) is None:
        found = kind or body.type_of(node)
        if isinstance(found, EnumType):
            members = list(found.members)
            keys = [member.upper() for member in members]
            other = members[(keys.index(node.key) + 1) % len(members)]
            yield "constant", body.source.span(node), other


def _literal(node: s.Literal) -> Iterator[tuple[str, str]]:
    text = node.text
    if node.kind == "BOOLEAN":
        yield "constant", "FALSE" if text.upper() == "TRUE" else "TRUE"
    elif node.kind == "INTEGER" and "#" not in text:
        yield "off-by-one", str(int(text) + 1)
        yield "off-by-one", str(int(text) - 1)
    elif node.kind == "REALNUM":
        value = float(text)
        yield "constant", repr(value * 10 if value else 1.0)
        yield "constant", repr(value + 1.0 if abs(value) > 2 else value / 2)
    elif node.kind == "STRING":
        yield "constant", "'X'" if text == "''" else "''"
    elif node.kind == "TYPED":
        yield from _typed(text)


def _typed(text: str) -> Iterator[tuple[str, str]]:
    bits, time = _BITS.fullmatch(text), _TIME.fullmatch(text)
    integer = _TYPED_INTEGER.fullmatch(text)
    if bits:
        name, digits = bits[1], bits[2]
        yield from (
            (operator, f"{name}#16#{value:0{len(digits)}X}")
            for operator, value in _pattern(int(digits, 16), 4 * len(digits))
        )
    elif integer:
        yield "off-by-one", f"{integer[1]}#{int(integer[2]) + 1}"
        if int(integer[2]):
            yield "off-by-one", f"{integer[1]}#{int(integer[2]) - 1}"
    elif time:
        value = int(time[1])
        yield "constant", f"T#{value * 2 or 1}{time[2]}"
        if value > 1:
            yield "constant", f"T#{value // 2}{time[2]}"


def _pattern(value: int, width: int) -> Iterator[tuple[str, int]]:
    """Yield other bit patterns: a mask is shifted by one bit, any other value is incremented."""
    if value in _ERRORS and value != 0x8000:
        yield "error-id", value + 1
        return
    top = 1 << (width - 1)
    if value == 0:
        yield "code", 1
    elif value & (value - 1) == 0 or _is_run(value):
        if not value & top:
            yield "mask", value << 1
        if not value & 1:
            yield "mask", value >> 1
        if value & top and value & 1:
            yield "mask", value >> 1
    else:
        yield "code", value + 1 if value + 1 < 1 << width else value - 1


def _is_run(value: int) -> bool:
    """Return whether the bits that are 1 are adjacent."""
    value //= value & -value
    return value & (value + 1) == 0
