"""From one source file to its syntax tree: one method per rule of grammar.lark."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedToken
from lark.lexer import Lexer

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.lexer import KEYWORDS, PUNCTUATION, tokens
from rcx_harness.errors import InputError

__all__ = ["parse", "parse_text"]

_OPERATORS = {"&": "AND"}
#: The operators from the weakest to the strongest; those of a line go from left to right.
_RANKS = (
    ("OR",),
    ("XOR",),
    ("AND", "AMPERSAND"),
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


@v_args(inline=True)
class _Builder(Transformer[Token, Any]):
    """Turns the children of each rule into a node of `syntax`."""

    # --- declarations ---

    def start(self, *units: Any) -> list[Any]:
        flat: list[Any] = []
        for unit in units:
            flat.extend(unit if isinstance(unit, list) else [unit])
        return flat

    def type_block(self, _type: Token, *rest: Any) -> list[s.TypeDecl]:
        return list(rest[:-1])

    def type_declaration(
        self, name: Token, _colon: Token, spec: s.TypeSpec, _is: Any, initial: Any, _end: Token
    ) -> s.TypeDecl:
        return s.TypeDecl(_name(name), spec, initial, _at(name))

    def named_spec(self, name: Token) -> s.NamedSpec:
        return s.NamedSpec(_name(name), _at(name))

    def sized_spec(self, name: Token, *_: Any) -> s.NamedSpec:
        return s.NamedSpec(_name(name), _at(name), "a length in []")

    def subrange_spec(self, name: Token, *_: Any) -> s.NamedSpec:
        return s.NamedSpec(_name(name), _at(name), "a subrange in ()")

    def array_spec(self, array: Token, *rest: Any) -> s.ArraySpec:
        return s.ArraySpec(_nodes(rest, s.Range), rest[-1], _at(array))

    def dimension(self, low: s.Expression, _dots: Token, high: s.Expression) -> s.Range:
        return s.Range(low, high, low.at)

    def enum_spec(self, left: Token, *rest: Any) -> s.EnumSpec:
        members = [item for item in rest if isinstance(item, tuple)]
        return s.EnumSpec(
            tuple(name for name, _ in members), _at(left), any(given for _, given in members)
        )

    def enum_member(self, name: Token, _is: Token | None, value: Any) -> tuple[s.Name, bool]:
        return _name(name), value is not None

    def struct_spec(self, struct: Token, *rest: Any) -> s.StructSpec:
        return s.StructSpec(_nodes(rest, s.VarDecl), _at(struct))

    def field_declaration(self, *rest: Any) -> s.VarDecl:
        spec, _is, initial, _end = rest[-4:]
        names = tuple(_name(token) for token in rest[:-4] if token.type == "IDENT")
        return s.VarDecl(names, spec, initial, None, names[0].at)

    def array_init(self, left: Token, *rest: Any) -> s.ArrayInit:
        return s.ArrayInit(_nodes(rest, tuple), _at(left))

    def one_item(self, value: s.Init) -> tuple[None, s.Init]:
        return None, value

    def repeated_item(
        self, count: Token, _left: Token, value: s.Init | None, _right: Token
    ) -> tuple[s.Literal, s.Init]:
        times = s.Literal("INTEGER", str(count), _at(count))
        return times, value if value is not None else s.ArrayInit((), _at(count))

    def struct_init(self, left: Token, *rest: Any) -> s.StructInit:
        return s.StructInit(_nodes(rest, tuple), _at(left))

    def field_init(self, name: Token, _is: Token, value: s.Init) -> tuple[s.Name, s.Init]:
        return _name(name), value

    def function(self, word: Token, name: Token, _colon: Token, *rest: Any) -> s.Pou:
        return self._pou(word, name, rest[0], rest[1:])

    def block(self, word: Token, name: Token, *rest: Any) -> s.Pou:
        return self._pou(word, name, None, rest)

    def program(self, word: Token, name: Token, *rest: Any) -> s.Pou:
        return self._pou(word, name, None, rest)

    def _pou(self, word: Token, name: Token, result: s.NamedSpec | None, rest: Any) -> s.Pou:
        sections = _nodes(rest, s.Section)
        return s.Pou(word.upper(), _name(name), result, sections, rest[-2], _at(word))

    def body(self, *statements: s.Statement) -> tuple[s.Statement, ...]:
        return statements

    def section(self, word: Token, *rest: Any) -> s.Section:
        qualifier = str(rest[0]).upper() if isinstance(rest[0], Token) else ""
        qualifier = "" if qualifier == "END_VAR" else qualifier
        return s.Section(word.upper(), qualifier, _nodes(rest, s.VarDecl), _at(word))

    def var_declaration(self, *rest: Any) -> s.VarDecl:
        _word, address, _colon, spec, _is, initial, _end = rest[-7:]
        names = tuple(_name(token) for token in rest[:-7] if token.type == "IDENT")
        return s.VarDecl(names, spec, initial, _optional(address), names[0].at)

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

    def statements(self, *statements: s.Statement) -> tuple[s.Statement, ...]:
        return statements

    def assign(self, target: s.Variable, _is: Token, value: s.Expression, _end: Token) -> s.Assign:
        return s.Assign(target, value, target.at)

    def call_statement(
        self, callee: s.Variable, _left: Token, arguments: Any, _right: Token, _end: Token
    ) -> s.CallStatement:
        return s.CallStatement(callee, arguments or (), callee.at)

    def if_(self, word: Token, *rest: Any) -> s.If:
        condition, _then, body = rest[:3]
        elsifs = [item for item in rest[3:] if isinstance(item, tuple)]
        otherwise = rest[-3] or ()
        branches = ((condition, body), *(item for item in elsifs if item is not rest[-3]))
        return s.If(branches, otherwise, _at(word))

    def elsif(
        self, _word: Token, condition: s.Expression, _then: Token, body: Any
    ) -> tuple[s.Expression, tuple[s.Statement, ...]]:
        return condition, body

    def case(self, word: Token, selector: s.Expression, *rest: Any) -> s.Case:
        return s.Case(selector, _nodes(rest, s.CaseBranch), rest[-3] or (), _at(word))

    def branch(self, *rest: Any) -> s.CaseBranch:
        labels = tuple(item for item in rest[:-1] if not isinstance(item, Token))
        return s.CaseBranch(labels, rest[-1], labels[0].at)

    def label_name(self, label: Token) -> s.Name:
        return _name(label)

    def label_name_range(self, label: Token, _dots: Token, high: s.Expression) -> s.Range:
        return s.Range(_name(label), high, _at(label))

    def label_constant(self, value: s.Expression) -> s.Expression:
        return value

    def label_range(self, low: s.Expression, _dots: Token, high: s.Expression) -> s.Range:
        return s.Range(low, high, low.at)

    def for_(self, word: Token, counter: Token, _is: Token, *rest: Any) -> s.For:
        start, _to, end, _by, step, _do, body, _end_for, _end = rest
        return s.For(_name(counter), start, end, step, body, _at(word))

    def while_(
        self, word: Token, condition: s.Expression, _do: Token, body: Any, *_: Token
    ) -> s.While:
        return s.While(condition, body, _at(word))

    def repeat(
        self, word: Token, body: Any, _until: Token, condition: s.Expression, *_: Token
    ) -> s.Repeat:
        return s.Repeat(body, condition, _at(word))

    def exit(self, word: Token, _end: Token) -> s.Exit:
        return s.Exit(_at(word))

    def return_(self, word: Token, _end: Token) -> s.Return:
        return s.Return(_at(word))

    # --- expressions ---

    def name(self, token: Token) -> s.Name:
        return _name(token)

    def field(self, base: s.Variable, _dot: Token, name: Token) -> s.Field:
        return s.Field(base, _name(name), base.at)

    def index(self, base: s.Variable, *rest: Any) -> s.Index:
        indices = tuple(item for item in rest if not isinstance(item, Token))
        return s.Index(base, indices, base.at)

    def arguments(self, *rest: Any) -> tuple[s.Argument, ...]:
        return _nodes(rest, s.Argument)

    def positional(self, value: s.Expression) -> s.Argument:
        return s.Argument(None, value, False, value.at)

    def named_input(self, name: Token, _is: Token, value: s.Expression) -> s.Argument:
        return s.Argument(_name(name), value, False, _at(name))

    def named_output(self, name: Token, _to: Token, value: s.Variable) -> s.Argument:
        return s.Argument(_name(name), value, True, _at(name))

    def expression(self, first: s.Expression, *rest: Any) -> s.Expression:
        operands: list[s.Expression] = [first]
        waiting: list[Token] = []
        for op, operand in zip(rest[::2], rest[1::2], strict=True):
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

    def call(self, function: Token, _left: Token, arguments: Any, _right: Token) -> s.Call:
        return s.Call(_name(function), arguments or (), _at(function))


_SPELLING = {name: f"'{text}'" for text, name in PUNCTUATION.items()}
_ENDS = ("END_IF", "ELSE", "ELSIF", "END_CASE", "END_WHILE", "END_FOR", "UNTIL")
_LITERALS = ("INTEGER", "REALNUM", "STRING", "TYPED")
_INSTRUCTION_LIST = frozenset(
    ["LD", "LDN", "ST", "STN", "ANDN", "ORN", "XORN", "CAL", "CALC", "RET", "RETC"]
)


class _Tokens(Lexer):
    """Hands the tokens of `lexer.tokens` to lark."""

    def __init__(self, lexer_conf: Any) -> None:
        del lexer_conf

    def lex(self, lexer_state: Any, parser_state: Any = None) -> Iterator[Token]:
        del parser_state
        text, file = lexer_state
        return tokens(text, file)


@lru_cache(maxsize=1)
def _parser() -> Lark:
    grammar = files(__package__).joinpath("grammar.lark").read_text(encoding="utf-8")
    names = sorted({*KEYWORDS, *PUNCTUATION.values(), *_LITERALS, "IDENT", "LABEL", "DIRECT"})
    declared = f"\n%declare {' '.join(names)}\n"
    return Lark(
        grammar + declared,
        parser="lalr",
        lexer=_Tokens,
        transformer=_Builder(),
        maybe_placeholders=True,
    )


def parse(file: Path) -> s.Source:
    """Read and parse one file.

    Raises:
        InputError: the file cannot be read, is not UTF-8, or has a syntax error.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read the file: {error.strerror}", file=file) from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"byte {error.start} is not UTF-8", file=file, hint="save the file as UTF-8"
        ) from None
    return parse_text(text, file)


@lru_cache(maxsize=1024)
def parse_text(text: str, file: Path) -> s.Source:
    """Parse a source; the same text of the same file is parsed once per process.

    Raises:
        InputError: a syntax error.
    """
    try:
        declarations: list[Any] = _parser().parse((text, file))  # type: ignore[assignment]
    except UnexpectedToken as error:
        raise _syntax_error(error, text, file) from None
    return s.Source(file, tuple(declarations))


def _syntax_error(error: UnexpectedToken, text: str, file: Path) -> InputError:
    token = error.token
    expected = set(error.accepts or error.expected)
    before = _before(token, text, file)
    if before.upper() in _INSTRUCTION_LIST and token.type != "ASSIGN":
        return _error_at("Instruction List is not supported", before, file, "write Structured Text")
    if "SEMICOLON" in expected:
        return _error_at(
            "a ';' is missing", before, file, f"write it after {str(before)!r}", after=True
        )
    if token.type == "$END":
        return _error_at("the file ends in the middle", before, file, _expectation(expected))
    if token.type == "SEMICOLON" and "IDENT" in expected and "LPAR" not in expected:
        return _error_at("an empty statement", token, file, "remove the ';'")
    if token.type in _ENDS and "IDENT" in expected:
        return _error_at(f"no statement before {token}", token, file, "branches cannot be empty")
    if token.type == "INTEGER" and before.type == "DOT":
        return _error_at("bits by number are not supported", before, file, "use AND, SHL and SHR")
    if token.type in KEYWORDS and not token.startswith("END_") and "IDENT" in expected:
        message = f"{token} is a reserved word and cannot be used here"
        return _error_at(message, token, file, _expectation(expected))
    return _error_at(f"{str(token)!r} is not expected here", token, file, _expectation(expected))


def _before(token: Token, text: str, file: Path) -> Token:
    """The token before one, or the last where that is the end of the file."""
    found = token
    for candidate in tokens(text, file):
        if token.type != "$END" and (candidate.start_pos or 0) >= (token.start_pos or 0):
            break
        found = candidate
    return found


def _expectation(expected: set[str]) -> str:
    """What could stand there, if that is few enough to help."""
    words = {"IDENT": "a name", "LABEL": "a label", "INTEGER": "a number", "DIRECT": "an address"}
    if "LPAR" in expected and "INTEGER" in expected:
        return "an expression is expected"
    shown = sorted(_SPELLING.get(name) or words.get(name) or name for name in expected)
    return f"expected {' or '.join(shown)}" if len(shown) <= 6 else ""


def _error_at(
    message: str, token: Token, file: Path, hint: str = "", *, after: bool = False
) -> InputError:
    column = (token.column or 1) + (len(token) if after else 0)
    return InputError(message, file=file, line=token.line, column=column, hint=hint)
