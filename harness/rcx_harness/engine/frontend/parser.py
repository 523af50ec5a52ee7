"""From one source file to its syntax tree: one method per rule of grammar.lark."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from lark import Lark, Token, Transformer, v_args
from lark.lexer import Lexer

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.constructs import Use, refuse
from rcx_harness.engine.frontend.lexer import KEYWORDS, PUNCTUATION, Notes, tokens
from rcx_harness.engine.frontend.recovery import read_tokens
from rcx_harness.engine.frontend.words import ACCESSORS
from rcx_harness.engine.source import source_text, title_of
from rcx_harness.errors import InputError

__all__ = ["TWO_BASES", "parse", "parse_portable", "parse_text", "read_text"]

#: Stands among the words of a block that extends two.
TWO_BASES = "EXTENDS TWO"
_OPERATORS = {"&": "AND"}
#: The operators from the weakest to the strongest; those of a line go from left to right.
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


def _at(token: Token) -> s.Position:
    return s.Position(token.line or 1, token.column or 1)


def _name(token: Token) -> s.Name:
    return s.Name(str(token), _at(token))


def _optional(token: Token | None) -> s.Name | None:
    return None if token is None else _name(token)


def _nodes(children: Any, kind: Any) -> tuple[Any, ...]:
    """The children that are of a syntax class, without tokens and absent options."""
    return tuple(child for child in children if isinstance(child, kind))


def _join(operands: list[s.Expression], op: Token) -> None:
    """Make one of the last two operands."""
    right, left = operands.pop(), operands.pop()
    word = op.upper()
    operands.append(s.Binary(_OPERATORS.get(word, word), left, right, _at(op)))


@dataclass(frozen=True)
class _Detailed:
    """A type with something in brackets behind it, whose meaning depends on where it stands."""

    name: s.Name
    items: tuple[tuple[s.Expression, s.Expression | None], ...]

    def of_type(self, builder: _Builder) -> s.EnumSpec:
        """In a TYPE: the base type of an enumeration with its members."""
        members = [(item, value) for item, value in self.items if isinstance(item, s.Name)]
        base = s.NamedSpec(self.name, self.name.at)
        return builder.enumeration(members, base, self.name.at)

    def of_variable(self) -> s.NamedSpec:
        """Elsewhere: what a block is initialised with."""
        arguments = tuple(
            s.Argument(item, value, False, item.at)
            if value is not None and isinstance(item, s.Name)
            else s.Argument(None, item, False, item.at)
            for item, value in self.items
        )
        return s.NamedSpec(self.name, self.name.at, None, arguments)


@v_args(inline=True)
class _Builder(Transformer[Token, Any]):
    """Turns the children of each rule into a node of `syntax`."""

    def __init__(self) -> None:
        super().__init__()
        self.uses: list[Use] = []
        self.errors: list[InputError] = []
        self.file = Path()

    def note(self, construct: str, at: s.Position) -> None:
        """Note a construct beyond the portable subset."""
        self.uses.append(Use(construct, self.file, at))

    # --- declarations ---

    def start(self, *units: Any) -> list[Any]:
        flat: list[Any] = []
        for unit in units:
            flat.extend(unit if isinstance(unit, list) else [unit])
        return [one for one in flat if not isinstance(one, Token)]

    def type_block(self, _type: Token, *rest: Any) -> list[s.TypeDecl]:
        return list(_nodes(rest, s.TypeDecl))

    def type_declaration(
        self, name: Token, base: Any, _colon: Token, spec: Any, _is: Any, initial: Any, _end: Token
    ) -> s.TypeDecl:
        if isinstance(spec, _Detailed):
            spec = spec.of_type(self)
        return s.TypeDecl(_name(name), spec, initial, _at(name), base[0] if base else None)

    def struct_declaration(
        self, name: Token, base: Any, _colon: Token, spec: s.StructSpec
    ) -> s.TypeDecl:
        return s.TypeDecl(_name(name), spec, None, _at(name), base[0] if base else None)

    def broken(self, *_: Any) -> None:
        """What could not be read."""

    def empty(self, *_: Any) -> None:
        """A semicolon that ends nothing, or the END before it."""

    def qualified(self, *parts: Token) -> s.Name:
        return s.Name("".join(parts), _at(parts[0]))

    def named_spec(self, name: s.Name) -> s.NamedSpec:
        return s.NamedSpec(name, name.at)

    def sized_spec(
        self, name: s.Name, _left: Token, size: s.Expression, _right: Token
    ) -> s.NamedSpec:
        self.note("STRING with a length", name.at)
        return s.NamedSpec(name, name.at, size)

    def detailed_spec(self, name: s.Name, *rest: Any) -> Any:
        items = [item for item in rest if not isinstance(item, Token)]
        if len(items) == 1 and isinstance(items[0], s.Range):
            self.note("a subrange", name.at)
            (limits,) = items
            base = s.NamedSpec(name, name.at)
            return s.SubrangeSpec(base, limits.low, limits.high, name.at)
        if name.key in ("STRING", "WSTRING") and len(items) == 1 and items[0][1] is None:
            self.note("STRING with a length", name.at)
            return s.NamedSpec(name, name.at, items[0][0])
        return _Detailed(name, tuple(item for item in items if isinstance(item, tuple)))

    def spec_item(
        self, first: s.Expression, _is: Any, value: Any
    ) -> tuple[s.Expression, s.Expression | None]:
        return first, value

    def spec_range(self, low: s.Expression, _dots: Token, high: s.Expression) -> s.Range:
        return s.Range(low, high, low.at)

    def array_spec(self, array: Token, *rest: Any) -> s.ArraySpec:
        return s.ArraySpec(_nodes(rest, s.Range), self._plain(rest[-1]), _at(array))

    def _plain(self, spec: Any) -> Any:
        """A type outside of a TYPE declaration."""
        return spec.of_variable() if isinstance(spec, _Detailed) else spec

    def dimension(self, low: s.Expression, _dots: Token, high: s.Expression) -> s.Range:
        return s.Range(low, high, low.at)

    def open_dimension(self, star: Token) -> s.Range:
        whole = s.Name("*", _at(star))
        return s.Range(whole, whole, _at(star))

    def enum_spec(self, left: Token, *rest: Any) -> s.EnumSpec:
        members = [item for item in rest if isinstance(item, tuple)]
        return self.enumeration(members, self._plain(rest[-1]), _at(left))

    def enumeration(self, members: Any, base: Any, at: s.Position) -> s.EnumSpec:
        """An enumeration of (name, value or None)."""
        if any(value is not None for _, value in members):
            self.note("an enumeration with values", at)
        if base is not None:
            self.note("an enumeration with a base type", at)
        names = tuple(name for name, _ in members)
        return s.EnumSpec(names, at, tuple(value for _, value in members), base)

    def enum_member(self, name: Token, _is: Token | None, value: Any) -> tuple[s.Name, Any]:
        return _name(name), value

    def struct_spec(self, struct: Token, *rest: Any) -> s.StructSpec:
        if union := struct.type == "UNION":
            self.note("a UNION", _at(struct))
        return s.StructSpec(_nodes(rest, s.VarDecl), _at(struct), union)

    def field_declaration(self, *rest: Any) -> s.VarDecl:
        *_, _word, address, _colon, spec, _is, initial, _end = rest
        names = tuple(_name(token) for token in rest[:-7] if token.type == "IDENT")
        at = names[0].at
        return s.VarDecl(names, self._plain(spec), initial, _optional(address), at)

    def struct_field(self, *rest: Any) -> s.VarDecl:
        names = tuple(_name(token) for token in rest[:-2] if token.type == "IDENT")
        return s.VarDecl(names, rest[-1], None, None, names[0].at)

    def array_init(self, left: Token, *rest: Any) -> s.ArrayInit:
        return s.ArrayInit(_nodes(rest, tuple), _at(left))

    def one_item(self, value: s.Init) -> tuple[None, s.Init]:
        return None, value

    def repeated(self, *items: Any) -> tuple[Any, ...]:
        return _nodes(items, tuple)

    def repeated_item(
        self, count: Token, _left: Token, items: Any, _right: Token
    ) -> tuple[s.Literal, s.Init]:
        times = s.Literal("INTEGER", str(count), _at(count))
        if items is not None and len(items) == 1 and items[0][0] is None:
            return times, items[0][1]
        return times, s.Sequence(items or (), _at(count))

    def bare_array(self, *rest: Any) -> s.ArrayInit:
        items = _nodes(rest, tuple)
        at = items[0][1].at
        self.note("an initial value without brackets", at)
        return s.ArrayInit(items, at)

    def bare_repeated(self, count: Token, left: Token, items: Any, right: Token) -> s.ArrayInit:
        self.note("an initial value without brackets", _at(count))
        return s.ArrayInit((self.repeated_item(count, left, items, right),), _at(count))

    def struct_init(self, left: Token, *rest: Any) -> s.StructInit:
        return s.StructInit(_nodes(rest, tuple), _at(left))

    def field_init(self, name: Token, _is: Token, value: s.Init) -> tuple[s.Name, s.Init]:
        return _name(name), value

    def function(
        self, word: Token, words: Any, name: Token, _colon: Any, result: Any, *rest: Any
    ) -> s.Pou:
        if result is None:
            self.note("a function without a result", _at(name))
        (body,) = _nodes(rest, tuple)
        sections = _nodes(rest, s.Section)
        kind, plain = word.upper(), self._plain(result)
        return s.Pou(kind, _name(name), plain, sections, body, _at(word), words=words)

    def block(
        self, word: Token, words: Any, name: Token, base: Any, interfaces: Any, *rest: Any
    ) -> s.Pou:
        if base is not None and len(base) > 1:
            words = (*words, TWO_BASES)
        pou = self._pou(word, name, rest)
        base = base[0] if base else None
        return replace(pou, words=words, extends=base, implements=interfaces or ())

    def program(self, word: Token, name: Token, *rest: Any) -> s.Pou:
        return self._pou(word, name, rest)

    def _pou(self, word: Token, name: Token, rest: Any) -> s.Pou:
        (inside,) = _nodes(rest, tuple)
        others = (s.Method, s.Property)
        return s.Pou(
            word.upper(),
            _name(name),
            None,
            _nodes(rest, s.Section),
            tuple(one for one in inside if not isinstance(one, others)),
            _at(word),
            members=_nodes(inside, (s.Method, s.Property)),
        )

    def members(self, *items: Any) -> tuple[Any, ...]:
        return tuple(one for one in items if one is not None)

    # --- object orientation and references ---

    def access_words(self, *words: Token) -> tuple[str, ...]:
        if words:
            self.note("an access specifier", _at(words[0]))
        return tuple(word.upper() for word in words)

    def extends(self, word: Token, *rest: Any) -> tuple[s.Name, ...]:
        self.note("EXTENDS", _at(word))
        return _nodes(rest, s.Name)

    def implements(self, word: Token, *rest: Any) -> tuple[s.Name, ...]:
        self.note("IMPLEMENTS", _at(word))
        return _nodes(rest, s.Name)

    def interface(
        self, word: Token, _words: Any, name: Token, base: Any, *rest: Any
    ) -> s.Interface:
        self.note("an INTERFACE", _at(word))
        members = _nodes(rest, (s.Method, s.Property))
        return s.Interface(_name(name), base or (), members, _at(word))

    def method(self, word: Token, words: Any, name: Token, *rest: Any) -> s.Method:
        self.note("a METHOD", _at(word))
        sections, result = _nodes(rest, s.Section), self._plain(rest[1])
        return s.Method(_name(name), words, result, sections, rest[-2], _at(name))

    def property(
        self, word: Token, words: Any, name: Token, _colon: Token, result: Any, *rest: Any
    ) -> s.Property:
        self.note("a PROPERTY", _at(word))
        found: dict[str, s.Method] = {}
        for one in _nodes(rest, s.Method):
            found[one.name.text] = replace(
                one, name=_name(name), words=words, result=self._plain(result)
            )
        getter, setter = found.get("GET"), found.get("SET")
        return s.Property(_name(name), words, self._plain(result), getter, setter, _at(name))

    def getter(self, word: Token, *rest: Any) -> s.Method:
        name = s.Name(word.upper(), _at(word))
        return s.Method(name, (), None, _nodes(rest, s.Section), rest[-2], _at(word))

    def setter(self, word: Token, *rest: Any) -> s.Method:
        return self.getter(word, *rest)

    def pointer_spec(self, kind: Token, *rest: Any) -> s.PointerSpec:
        self.note("REFERENCE TO" if kind.upper() == "REFERENCE" else "POINTER TO", _at(kind))
        return s.PointerSpec(kind.upper(), self._plain(rest[-1]), _at(kind))

    def namespace(self, word: Token, name: s.Name, *rest: Any) -> list[Any]:
        self.note("a NAMESPACE", _at(word))
        found: list[Any] = [s.Namespace(name, False, _at(word))]
        for one in rest[:-1]:
            found += one if isinstance(one, list) else [one]
        return [one for one in found if not isinstance(one, Token)]

    def using(self, word: Token, *names: Any) -> list[s.Namespace]:
        self.note("a NAMESPACE", _at(word))
        return [s.Namespace(name, True, _at(word)) for name in _nodes(names, s.Name)]

    def this(self, word: Token) -> s.This:
        self.note("THIS or SUPER", _at(word))
        return s.This(word.upper() == "SUPER", _at(word), pointer=True)

    def action(self, word: Token, name: Token, _colon: Token, body: Any, _end: Token) -> s.Method:
        self.note("an ACTION", _at(word))
        return s.Method(_name(name), (), None, (), body, _at(name), action=True)

    def body(self, *statements: s.Statement | None) -> tuple[s.Statement, ...]:
        return tuple(one for one in statements if one is not None)

    def section(self, word: Token, *rest: Any) -> s.Section:
        words = [str(item).upper() for item in rest if isinstance(item, Token)][:-1]
        if len(words) > 1:
            self.note("several qualifiers", _at(word))
        if "PERSISTENT" in words:
            self.note("PERSISTENT", _at(word))
        if word.type in ("VAR_STAT", "VAR_INST"):
            self.note(word.upper(), _at(word))
        qualifier = "CONSTANT" if "CONSTANT" in words else "RETAIN" if words else ""
        qualifier = "NON_RETAIN" if words == ["NON_RETAIN"] else qualifier
        return s.Section(word.upper(), qualifier, _nodes(rest, s.VarDecl), _at(word))

    def global_list(self, word: Token, *rest: Any) -> s.GlobalList:
        self.note("VAR_GLOBAL outside a CONFIGURATION", _at(word))
        return s.GlobalList(s.Name("", _at(word)), self.section(word, *rest), _at(word))

    def var_declaration(self, *rest: Any) -> s.VarDecl:
        _word, address, _colon, spec, _is, initial, _end = rest[-7:]
        names = tuple(_name(token) for token in rest[:-7] if token.type == "IDENT")
        at = names[0].at
        bound = isinstance(_is, Token) and _is.upper() == "REF="
        if isinstance(_is, Token) and _is.type == "LATCH" and not bound:
            text, place = f"{_is} is no initial value", _at(_is)
            error = InputError(text, file=self.file, line=place.line, column=place.column)
            self.errors.append(error)
        plain = self._plain(spec)
        return s.VarDecl(names, plain, initial, _optional(address), at, bound)

    # --- configuration ---

    def configuration(self, word: Token, name: Token, *rest: Any) -> s.Configuration:
        resources = [item for item in rest if isinstance(item, list)]
        items = [*rest, *(item for resource in resources for item in resource)]
        return s.Configuration(
            _name(name),
            _nodes(items, s.Section),
            _nodes(items, s.Task),
            _nodes(items, s.ProgramInstance),
            len(resources),
            _at(word),
        )

    def resource(self, _word: Token, *rest: Any) -> list[Any]:
        return [item for item in rest if not isinstance(item, Token)]

    def task(self, _word: Token, name: Token, *rest: Any) -> s.Task:
        return s.Task(_name(name), _nodes(rest, tuple), _at(name))

    def task_setting(
        self, name: Token, _is: Token, value: s.Expression
    ) -> tuple[s.Name, s.Expression]:
        return _name(name), value

    def program_instance(
        self, _word: Token, name: Token, _with: Any, task: Any, _colon: Token, *rest: Any
    ) -> s.ProgramInstance:
        connected = any(part is not None for part in rest[1:-1])
        return s.ProgramInstance(_name(name), _optional(task), _name(rest[0]), connected, _at(name))

    # --- statements ---

    def statements(self, *statements: s.Statement | None) -> tuple[s.Statement, ...]:
        return tuple(one for one in statements if one is not None)

    def assign(self, *rest: Any) -> s.Assign | s.AssignChain:
        parts = rest[:-1:2]
        if len(parts) == 2:
            return s.Assign(parts[0], parts[1], parts[0].at)
        self.note("several targets of an assignment", parts[0].at)
        return s.AssignChain(parts[:-1], parts[-1], parts[0].at)

    def latch(self, target: s.Variable, op: Token, value: s.Expression, _end: Token) -> s.Latch:
        word = op.upper()[:-1]
        self.note("REFERENCE TO" if word == "REF" else "S= or R=", _at(op))
        return s.Latch(target, word, value, target.at)

    def call_statement(self, call: s.Call | s.Invoke, _end: Token) -> s.CallStatement:
        callee = call.function if isinstance(call, s.Call) else call.callee
        return s.CallStatement(callee, call.arguments, callee.at)

    def if_(self, word: Token, condition: s.Expression, *rest: Any) -> s.If:
        _then, body, *elsifs, else_, otherwise, _end = rest
        branches = ((condition, body), *elsifs)
        for _, statements in branches:
            self._filled(statements, word)
        if else_ is not None:
            self._filled(otherwise, word)
        return s.If(branches, otherwise or (), _at(word))

    def _filled(self, body: tuple[s.Statement, ...], word: Token) -> None:
        if not body:
            self.note("an empty branch", _at(word))

    def elsif(
        self, _word: Token, condition: s.Expression, _then: Token, body: Any
    ) -> tuple[s.Expression, tuple[s.Statement, ...]]:
        return condition, body

    def case(self, word: Token, selector: s.Expression, *rest: Any) -> s.Case:
        branches = _nodes(rest, s.CaseBranch)
        if not branches or rest[-3] is not None:
            self._filled(rest[-2] or (), word)
        return s.Case(selector, branches, rest[-2] or (), _at(word))

    def branch(self, *rest: Any) -> s.CaseBranch:
        labels = tuple(item for item in rest[:-1] if not isinstance(item, Token))
        if not rest[-1]:
            self.note("an empty branch", labels[0].at)
        return s.CaseBranch(labels, rest[-1], labels[0].at)

    def label_path(self, label: Token, *rest: Token) -> s.Name | s.Field:
        found: s.Name | s.Field = _name(label)
        for token in rest[1::2]:
            found = s.Field(found, _name(token), found.at)
        return found

    def label_constant(self, value: s.Expression) -> s.Expression:
        return value

    def label_range(self, low: s.Expression, _dots: Token, high: s.Expression) -> s.Range:
        return s.Range(low, high, low.at)

    def for_(self, word: Token, counter: s.Variable, _is: Token, *rest: Any) -> s.For:
        start, _to, end, _by, step, _do, body, _end = rest
        self._filled(body, word)
        return s.For(counter, start, end, step, body, _at(word))

    def while_(
        self, word: Token, condition: s.Expression, _do: Token, body: Any, _end: Token
    ) -> s.While:
        self._filled(body, word)
        return s.While(condition, body, _at(word))

    def repeat(
        self, word: Token, body: Any, _until: Token, condition: s.Expression, *_: Any
    ) -> s.Repeat:
        self._filled(body, word)
        return s.Repeat(body, condition, _at(word))

    def exit(self, word: Token, _end: Token) -> s.Exit:
        return s.Exit(_at(word))

    def return_(self, word: Token, _end: Token) -> s.Return:
        return s.Return(_at(word))

    def continue_(self, word: Token, _end: Token) -> s.Continue:
        self.note("CONTINUE", _at(word))
        return s.Continue(_at(word))

    # --- expressions ---

    def name(self, token: Token) -> s.Name:
        return _name(token)

    def field(self, base: s.Variable, _dot: Token, name: Token) -> s.Field:
        return s.Field(base, _name(name), base.at)

    def bit(self, base: s.Variable, _dot: Token, number: Token) -> s.Part:
        self.note("a bit by its number", _at(number))
        return s.Part(base, "X", int(number.replace("_", "")), base.at)

    def part(self, base: s.Variable, _dot: Token, part: Token) -> s.Part:
        bit = part[1].upper() == "X"
        self.note("a bit by its number" if bit else "a part of a word", _at(part))
        return s.Part(base, part[1].upper(), int(part[2:]), base.at)

    def dereference(self, base: s.Variable, caret: Token) -> s.Dereference | s.This:
        if isinstance(base, s.This):
            return s.This(base.above, base.at)
        self.note("POINTER TO", _at(caret))
        return s.Dereference(base, base.at)

    def index(self, base: s.Variable, *rest: Any) -> s.Index:
        indices = tuple(item for item in rest if not isinstance(item, Token))
        return s.Index(base, indices, base.at)

    def arguments(self, *rest: Any) -> tuple[s.Argument, ...]:
        return _nodes(rest, s.Argument)

    def positional(self, value: s.Expression) -> s.Argument:
        return s.Argument(None, value, False, value.at)

    def named_input(self, name: Token, _is: Token, value: Any) -> s.Argument | None:
        return None if value is None else s.Argument(_name(name), value, False, _at(name))

    def named_output(self, name: Token, _to: Token, value: Any) -> s.Argument | None:
        return None if value is None else s.Argument(_name(name), value, True, _at(name))

    def expression(self, first: s.Expression, *rest: Any) -> s.Expression:
        operands: list[s.Expression] = [first]
        waiting: list[Token] = []
        for op, operand in zip(rest[::2], rest[1::2], strict=True):
            if op.type in ("AND_THEN", "OR_ELSE"):
                self.note("AND_THEN or OR_ELSE", _at(op))
            while waiting and _RANK[waiting[-1].type] >= _RANK[op.type]:
                _join(operands, waiting.pop())
            waiting.append(op)
            operands.append(operand)
        while waiting:
            _join(operands, waiting.pop())
        return operands[0]

    def unary(self, op: Token, operand: s.Expression) -> s.Unary:
        return s.Unary(op.upper(), operand, _at(op))

    def literal(self, token: Token) -> s.Literal:
        kind = "BOOLEAN" if token.type in ("TRUE", "FALSE") else token.type
        return s.Literal(kind, str(token), _at(token))

    def negative_literal(self, minus: Token, token: Token) -> s.Unary:
        return s.Unary("-", self.literal(token), _at(minus))

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
        return s.Call(_name(word), arguments, _at(word))


_LITERALS = ("INTEGER", "REALNUM", "STRING", "TYPED")


class _NoLexer(Lexer):
    """The tokens come from `lexer.tokens`."""

    def __init__(self, lexer_conf: Any) -> None:
        del lexer_conf

    def lex(self, lexer_state: Any, parser_state: Any = None) -> Iterator[Token]:
        del lexer_state, parser_state
        return iter(())


@lru_cache(maxsize=1)
def _parser() -> tuple[Lark, _Builder]:
    grammar = files(__package__).joinpath("grammar.lark").read_text(encoding="utf-8")
    names = {*KEYWORDS, *PUNCTUATION.values(), *_LITERALS, "IDENT", "LABEL", "DIRECT", "PART"}
    names |= {"WORD", *ACCESSORS}
    declared = f"\n%declare {' '.join(sorted(names))} LATCH ERROR\n"
    builder = _Builder()
    lark = Lark(
        grammar + declared,
        parser="lalr",
        lexer=_NoLexer,
        transformer=builder,
        maybe_placeholders=True,
    )
    return lark, builder


def parse(file: Path) -> s.Source:
    """Read and parse one file.

    Raises:
        InputError: the file cannot be read, is not UTF-8, or has a syntax error.
    """
    return parse_text(source_text(file), file)


def parse_text(text: str, file: Path) -> s.Source:
    """Parse a source.

    Raises:
        InputError: the first syntax error.
    """
    return _whole(read_text(text, file))


def parse_portable(text: str, file: Path) -> s.Source:
    """Parse a source of the portable subset, without remembering it.

    Raises:
        InputError: a syntax error, or a construct beyond the portable subset.
    """
    source = _whole(read_text.__wrapped__(text, file))
    refuse(source.uses, "the portable subset")
    return source


def _whole(source: s.Source) -> s.Source:
    if source.errors:
        raise source.errors[0]
    return source


@lru_cache(maxsize=1024)
def read_text(text: str, file: Path) -> s.Source:
    """Parse a source as far as it can be read, with its errors.

    The same text of the same file is parsed once per process.
    """
    lark, builder = _parser()
    notes = Notes()
    found = list(tokens(text, file, notes))
    builder.uses, builder.errors, builder.file = notes.uses, notes.errors, file
    declarations, errors = read_tokens(lark, found, file)
    lines = {error.line for error in notes.errors}
    every = [*notes.errors, *(error for error in errors if error.line not in lines)]
    every.sort(key=lambda error: (error.line or 0, error.column or 0))
    return s.Source(
        file,
        _named(declarations, file, notes.pragmas),
        tuple(sorted(notes.uses, key=lambda use: use.at)),
        tuple(notes.pragmas),
        tuple(every),
        _nodes(declarations, s.Namespace),
    )


def _named(declarations: list[Any], file: Path, pragmas: list[s.Name]) -> tuple[Any, ...]:
    """The declarations: lists of globals with the name of the file, actions in their POU."""
    result: list[Any] = []
    for one in declarations:
        if isinstance(one, s.Namespace):
            continue
        if isinstance(one, s.Method):  # an ACTION behind the POU that it belongs to
            if result and isinstance(result[-1], s.Pou):
                result[-1] = replace(result[-1], members=(*result[-1].members, one))
            continue
        if isinstance(one, s.GlobalList):
            begin = result[-1].at if result else s.Position(1, 1)
            qualified = any(
                "qualified_only" in pragma.text and begin <= pragma.at < one.at
                for pragma in pragmas
            )
            one = replace(one, name=s.Name(title_of(file), one.at), qualified=qualified)
        result.append(one)
    return tuple(result)
