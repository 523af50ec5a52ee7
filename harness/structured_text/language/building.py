"""The grammar rules of statements and expressions: they turn tokens into syntax nodes."""

# ruff: noqa: D102 (each method is the rule of its name in grammar.lark)

from __future__ import annotations

from pathlib import Path
from typing import Any

from lark import Token, Transformer, v_args

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.constructs import Use

__all__ = ["Statements", "name_of", "nodes_of", "position_of"]

_OPERATORS = {"&": "AND"}
#: The operators by precedence, the weakest first. All operators are left-associative.
_RANKS = (
    ("OR", "OR_ELSE"),
    ("XOR",),
    ("AND", "AMPERSAND", "AND_THEN"),
    ("EQ", "NE"),
    ("LT", "GT", "LE", "GE"),
    ("PLUS", "MINUS"),
    ("STAR", "SLASH", "MOD"),
    ("POWER",),
)
_RANK = {name: rank for rank, names in enumerate(_RANKS) for name in names}


def position_of(token: Token) -> s.Position:
    """Return the position of a token."""
    return s.Position(token.line or 1, token.column or 1)


def name_of(token: Token) -> s.Name:
    """Return a token as a name."""
    return s.Name(str(token), position_of(token))


def nodes_of(children: Any, kind: Any) -> tuple[Any, ...]:
    """Return the children that are syntax nodes; tokens and absent options are left out."""
    return tuple(child for child in children if isinstance(child, kind))


def _is_text(label: s.Expression | s.Range) -> bool:
    """Return whether the label of a CASE is a text or a range of characters."""
    first = label.low if isinstance(label, s.Range) else label
    return isinstance(first, s.Literal) and first.kind == "STRING"


def _any_of(
    selector: s.Expression, labels: tuple[s.Expression | s.Range, ...], at: s.Position
) -> s.Expression:
    """Return the condition that a text matches one of the labels of a CASE."""
    found: s.Expression | None = None
    for label in labels:
        if isinstance(label, s.Range):
            low = s.Binary(">=", selector, label.low, label.at)
            one = s.Binary("AND", low, s.Binary("<=", selector, label.high, label.at), label.at)
        else:
            one = s.Binary("=", selector, label, label.at)
        found = one if found is None else s.Binary("OR", found, one, at)
    assert found is not None
    return found


def _join(operands: list[s.Expression], op: Token) -> None:
    """Replace the last two operands in the list by the operation on them."""
    right, left = operands.pop(), operands.pop()
    word = op.upper()
    operands.append(s.Binary(_OPERATORS.get(word, word), left, right, position_of(op)))


@v_args(inline=True)
class Statements(Transformer[Token, Any]):
    """A lark transformer: each method turns the children of its rule into a syntax node.

    Attributes:
        uses: Constructs beyond the portable subset.
        errors: Mistakes that the grammar accepts and the transformer finds.
        file: The file that is parsed.
        entries: The entries of VAR_CONFIG.
    """

    def __init__(self) -> None:
        super().__init__()
        self.uses: list[Use] = []
        self.errors: list[InputError] = []
        self.file = Path()
        self.entries: list[s.ConfigEntry] = []

    def note(self, construct: str, at: s.Position) -> None:
        """Note a construct beyond the portable subset."""
        self.uses.append(Use(construct, self.file, at))

    # --- statements ---

    def statements(self, *statements: s.Statement | None) -> tuple[s.Statement, ...]:
        return tuple(one for one in statements if one is not None)

    def assign(self, *rest: Any) -> s.Assign | s.AssignChain:
        parts = rest[:-1:2]
        if len(parts) == 2:
            return s.Assign(parts[0], parts[1], parts[0].at)
        self.note("several targets of an assignment", parts[0].at)
        return s.AssignChain(parts[:-1], parts[-1], parts[0].at)

    def attempt(
        self, target: s.Variable, _op: Token, value: s.Expression, _end: Token
    ) -> s.CallStatement:
        """Return `target ?= value` as a query for the interface of the target."""
        self.note("?=", target.at)
        arguments = tuple(s.Argument(None, one, False, one.at) for one in (value, target))
        return s.CallStatement(s.Name("__QUERYINTERFACE", target.at), arguments, target.at)

    def latch(self, target: s.Variable, op: Token, value: s.Expression, _end: Token) -> s.Latch:
        word = op.upper()[:-1]
        self.note("REFERENCE TO" if word == "REF" else "S= or R=", position_of(op))
        return s.Latch(target, word, value, target.at)

    def call_statement(self, call: s.Call | s.Invoke, _end: Token) -> s.CallStatement:
        callee = call.function if isinstance(call, s.Call) else call.callee
        return s.CallStatement(callee, call.arguments, callee.at)

    def name_statement(self, named: s.Variable, _end: Token) -> s.CallStatement:
        self.note("a name as a statement", named.at)
        return s.CallStatement(named, (), named.at, bare=True)

    def if_(self, word: Token, condition: s.Expression, *rest: Any) -> s.If:
        _then, body, *elsifs, else_, otherwise, _end = rest
        branches = ((condition, body), *elsifs)
        for _, statements in branches:
            self._filled(statements, word)
        if else_ is not None:
            self._filled(otherwise, word)
        return s.If(branches, otherwise or (), position_of(word))

    def _filled(self, body: tuple[s.Statement, ...], word: Token) -> None:
        if not body:
            self.note("an empty branch", position_of(word))

    def elsif(
        self, _word: Token, condition: s.Expression, _then: Token, body: Any
    ) -> tuple[s.Expression, tuple[s.Statement, ...]]:
        return condition, body

    def case(self, word: Token, selector: s.Expression, *rest: Any) -> s.Case | s.If:
        branches = nodes_of(rest, s.CaseBranch)
        if any(_is_text(label) for branch in branches for label in branch.labels):
            self.note("a CASE of texts", position_of(word))
            # The selector is a function call, which the condition of each label would repeat.
            if isinstance(selector, (s.Call, s.Invoke)):
                text = "a CASE of texts needs a variable"
                hint = "assign the result to a variable first"
                at = position_of(word)
                self.errors.append(
                    InputError(text, file=self.file, line=at.line, column=at.column, hint=hint)
                )
            tests = [(_any_of(selector, one.labels, one.at), one.body) for one in branches]
            return s.If(tuple(tests), rest[-2] or (), position_of(word))
        if not branches or rest[-3] is not None:
            self._filled(rest[-2] or (), word)
        return s.Case(selector, branches, rest[-2] or (), position_of(word))

    def branch(self, *rest: Any) -> s.CaseBranch:
        labels = tuple(item for item in rest[:-1] if not isinstance(item, Token))
        if not rest[-1]:
            self.note("an empty branch", labels[0].at)
        return s.CaseBranch(labels, rest[-1], labels[0].at)

    def label_path(self, label: Token, *rest: Token) -> s.Name | s.Field:
        found: s.Name | s.Field = name_of(label)
        for token in rest[1::2]:
            found = s.Field(found, name_of(token), found.at)
        return found

    def range(self, low: s.Expression, _dots: Token, high: s.Expression) -> s.Range:
        return s.Range(low, high, low.at)

    def for_(self, word: Token, counter: s.Variable, _is: Token, *rest: Any) -> s.For:
        start, _to, end, _by, step, _do, body, _end = rest
        self._filled(body, word)
        return s.For(counter, start, end, step, body, position_of(word))

    def while_(
        self, word: Token, condition: s.Expression, _do: Token, body: Any, _end: Token
    ) -> s.While:
        self._filled(body, word)
        return s.While(condition, body, position_of(word))

    def repeat(
        self, word: Token, body: Any, _until: Token, condition: s.Expression, *_: Any
    ) -> s.Repeat:
        self._filled(body, word)
        return s.Repeat(body, condition, position_of(word))

    def try_(self, word: Token, body: Any, catch: Any, *rest: Any) -> s.Try:
        *_, code, _right, handler, _finally, last, _end = rest
        at = position_of(word)
        self.note("__TRY", at)
        if catch is None:
            text, hint = "__TRY has no __CATCH", "write __CATCH before __FINALLY or __ENDTRY"
            self.errors.append(
                InputError(text, file=self.file, line=at.line, column=at.column, hint=hint)
            )
        return s.Try(body, code, handler or (), last or (), at)

    def exit(self, word: Token, _end: Token) -> s.Exit:
        return s.Exit(position_of(word))

    def return_(self, word: Token, _end: Token) -> s.Return:
        return s.Return(position_of(word))

    def return_if(self, word: Token, _left: Token, condition: s.Expression, *_: Any) -> s.If:
        at = position_of(word)
        self.note("RETURN with a condition", at)
        return s.If(((condition, (s.Return(at),)),), (), at)

    def continue_(self, word: Token, _end: Token) -> s.Continue:
        self.note("CONTINUE", position_of(word))
        return s.Continue(position_of(word))

    # --- expressions ---

    def name(self, token: Token) -> s.Name:
        return name_of(token)

    def field(self, base: s.Variable, _dot: Token, name: Token) -> s.Field:
        return s.Field(base, name_of(name), base.at)

    def bit(self, base: s.Variable, _dot: Token, number: Token) -> s.Part:
        self.note("a bit by its number", position_of(number))
        return s.Part(base, "X", int(number.replace("_", "")), base.at)

    def part(self, base: s.Variable, _dot: Token, part: Token) -> s.Part:
        bit = part[1].upper() == "X"
        self.note("a bit by its number" if bit else "a part of a word", position_of(part))
        return s.Part(base, part[1].upper(), int(part[2:]), base.at)

    def dereference(self, base: s.Variable, caret: Token) -> s.Dereference | s.This:
        if isinstance(base, s.This):
            return s.This(base.above, base.at)
        self.note("POINTER TO", position_of(caret))
        return s.Dereference(base, base.at)

    def index(self, base: s.Variable, *rest: Any) -> s.Index:
        indices = tuple(item for item in rest if not isinstance(item, Token))
        return s.Index(base, indices, base.at)

    def arguments(self, *rest: Any) -> tuple[s.Argument, ...]:
        if isinstance(rest[-1], Token):
            self.note("a comma behind the last argument", position_of(rest[-1]))
        return nodes_of(rest, s.Argument)

    def positional(self, value: s.Expression) -> s.Argument:
        return s.Argument(None, value, False, value.at)

    def named_input(self, name: Token, _is: Token, value: Any) -> s.Argument | None:
        return None if value is None else s.Argument(name_of(name), value, False, position_of(name))

    def named_output(self, name: Token, _to: Token, value: Any) -> s.Argument | None:
        return None if value is None else s.Argument(name_of(name), value, True, position_of(name))

    # The grammar gives all operators of an expression as one flat list. This method builds the tree
    # by operator precedence. `waiting` has the operators whose right operand is not complete. An
    # operator completes every waiting operator of the same or a higher precedence, which also makes
    # operators of the same precedence left-associative.
    def expression(self, first: s.Expression, *rest: Any) -> s.Expression:
        operands: list[s.Expression] = [first]
        waiting: list[Token] = []
        for op, operand in zip(rest[::2], rest[1::2], strict=True):
            if op.type in ("AND_THEN", "OR_ELSE"):
                self.note("AND_THEN or OR_ELSE", position_of(op))
            while waiting and _RANK[waiting[-1].type] >= _RANK[op.type]:
                _join(operands, waiting.pop())
            waiting.append(op)
            operands.append(operand)
        while waiting:
            _join(operands, waiting.pop())
        return operands[0]

    def assigned(self, target: s.Variable, _is: Token, value: s.Expression) -> s.Assigned:
        self.note("an assignment in an expression", target.at)
        return s.Assigned(target, value, target.at)

    def unary(self, op: Token, operand: s.Expression) -> s.Unary:
        return s.Unary(op.upper(), operand, position_of(op))

    def literal(self, token: Token) -> s.Literal:
        kind = "BOOLEAN" if token.type in ("TRUE", "FALSE") else token.type
        return s.Literal(kind, str(token), position_of(token))

    def negative_literal(self, minus: Token, token: Token) -> s.Unary:
        return s.Unary("-", self.literal(token), position_of(minus))

    def parenthesised(self, _left: Token, inner: s.Expression, _right: Token) -> s.Expression:
        return inner

    def plus(self, _plus: Token, operand: s.Expression) -> s.Expression:
        return operand

    def call(
        self, callee: s.Variable, _left: Token, arguments: Any, _right: Token
    ) -> s.Call | s.Invoke:
        if isinstance(callee, s.Name):
            return s.Call(callee, arguments or (), callee.at)
        return s.Invoke(callee, arguments or (), callee.at)

    def operator_call(self, word: Token, _left: Token, arguments: Any, _right: Token) -> s.Call:
        return s.Call(name_of(word), arguments, position_of(word))
