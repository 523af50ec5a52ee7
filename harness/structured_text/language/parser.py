"""The parser: turns a source file into its syntax tree.

`_Builder` has the rules of grammar.lark for declarations; `building.Statements` has those for
statements. Each method is named after its rule, so most methods have no docstring.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from importlib.resources import files
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lark import Lark, Token, v_args
from lark.lexer import Lexer

from structured_text.errors import COMMAND, InputError
from structured_text.language import cache
from structured_text.language import syntax as s
from structured_text.language.building import Statements, name_of, nodes_of, position_of
from structured_text.language.constructs import refuse
from structured_text.language.foreign import (
    corrected,
    not_structured_text,
    one_for_all,
)
from structured_text.language.lexer import KEYWORDS, PUNCTUATION, Notes, tokens
from structured_text.language.pou_names import with_names
from structured_text.language.recovery import AT_END, read_tokens
from structured_text.language.source import Extract, source_text, title_of
from structured_text.language.words import ACCESSORS, EXCEPTIONS
from structured_text.output.limits import MOST_TOKENS

__all__ = [
    "ACTION",
    "CLASS",
    "SHELL",
    "TWO_BASES",
    "parse",
    "parse_portable",
    "parse_text",
    "read_text",
]

#: Name of the POU for a `.var` file of Automation Studio, which has sections of variables without a
#: POU.
SHELL = "_VARIABLES"
#: Marker among the access words of a block that extends two blocks.
TWO_BASES = "EXTENDS TWO"
#: Word among the access words of an ACTION. An ACTION is a method without variables.
ACTION = "ACTION"
#: Word among the access words of a CLASS, which has no body.
CLASS = "CLASS"


def _optional(token: Token | None) -> s.Name | None:
    return None if token is None else name_of(token)


def _base_of(
    bases: Sequence[s.Name | s.NamedSpec] | None,
) -> tuple[s.Name | None, tuple[s.Expression, ...]]:
    """Return the base block, and the values of the base block's generic constants."""
    if not bases:
        return None, ()
    base = bases[0]
    return (base.name, base.generics) if isinstance(base, s.NamedSpec) else (base, ())


def _names_of(tokens: Iterable[Token]) -> tuple[s.Name, ...]:
    return tuple(name_of(token) for token in tokens if token.type == "IDENT")


@dataclass(frozen=True)
class _Detailed:
    """A type name with a parenthesis behind it, as in `INT (0..5)` or `Drive(Axis := 1)`.

    The meaning of the parenthesis differs inside and outside a TYPE, which the grammar does not
    distinguish.
    """

    name: s.Name
    items: tuple[tuple[s.Expression, s.Expression | None], ...]

    def of_type(self, builder: _Builder) -> s.EnumSpec:
        """Return the name with parentheses as an enumeration with a base type (inside a TYPE)."""
        members = [(item, value) for item, value in self.items if isinstance(item, s.Name)]
        base = s.NamedSpec(self.name, self.name.at)
        return builder.enumeration(members, base, self.name.at)

    def of_variable(self) -> s.NamedSpec:
        """Return the name with parentheses as a block with initial arguments (in a VAR section)."""
        arguments = tuple(
            s.Argument(item, value, False, item.at)
            if value is not None and isinstance(item, s.Name)
            else s.Argument(None, item, False, item.at)
            for item, value in self.items
        )
        return s.NamedSpec(self.name, self.name.at, None, arguments)


@v_args(inline=True)
class _Builder(Statements):
    """The grammar rules of declarations; the base class has the rules of statements."""

    # --- declarations ---

    def start(self, *units: Any) -> list[Any]:
        flat: list[Any] = []
        for unit in units:
            flat.extend(unit if isinstance(unit, list) else [unit])
        return [one for one in flat if one is not None and not isinstance(one, Token)]

    def type_block(self, _type: Token, *rest: Any) -> list[s.TypeDecl]:
        return list(nodes_of(rest, s.TypeDecl))

    def type_declaration(
        self, name: Token, base: Any, _colon: Token, spec: Any, _is: Any, initial: Any, _end: Token
    ) -> s.TypeDecl:
        if isinstance(spec, _Detailed):
            spec = spec.of_type(self)
        return s.TypeDecl(name_of(name), spec, initial, position_of(name), _base_of(base)[0])

    def struct_declaration(
        self, name: Token, base: Any, _colon: Token, spec: s.StructSpec
    ) -> s.TypeDecl:
        return s.TypeDecl(name_of(name), spec, None, position_of(name), _base_of(base)[0])

    def broken(self, *_: Any) -> None:
        """Drop a part that could not be read."""

    def empty(self, *_: Any) -> None:
        """Drop a semicolon that does not end a statement or an END."""

    def qualified(self, *parts: Token) -> s.Name:
        return s.Name("".join(parts), position_of(parts[0]))

    def named_spec(self, name: s.Name) -> s.NamedSpec:
        return s.NamedSpec(name, name.at)

    def sized_spec(
        self, name: s.Name, _left: Token, size: s.Expression, _right: Token
    ) -> s.NamedSpec:
        self.note("STRING with a length", name.at)
        return s.NamedSpec(name, name.at, size)

    def generic_spec(self, name: s.Name, *rest: Any) -> s.NamedSpec:
        self.note("VAR_GENERIC", name.at)
        arguments = next((one for one in rest if isinstance(one, tuple)), ())
        parts = (one for one in rest if one is not None and not isinstance(one, (Token, tuple)))
        return s.NamedSpec(name, name.at, None, arguments, generics=tuple(parts))

    def detailed_spec(self, name: s.Name, *rest: Any) -> Any:
        items = [item for item in rest if item is not None and not isinstance(item, Token)]
        if not items:
            self.note("an empty initial value", name.at)
            return s.NamedSpec(name, name.at, empty=True)
        commas = [item for item in rest if isinstance(item, Token) and item.type == "COMMA"]
        if len(commas) == len(items):
            self.note("a comma behind the last argument", position_of(commas[-1]))
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

    def array_spec(self, array: Token, *rest: Any) -> s.ArraySpec:
        return s.ArraySpec(nodes_of(rest, s.Range), self._plain(rest[-1]), position_of(array))

    def _plain(self, spec: Any) -> Any:
        """Return the type of a variable; parentheses behind its name hold initial arguments."""
        return spec.of_variable() if isinstance(spec, _Detailed) else spec

    def open_dimension(self, star: Token) -> s.Range:
        whole = s.Name("*", position_of(star))
        return s.Range(whole, whole, position_of(star))

    def enum_spec(self, left: Token, *rest: Any) -> s.EnumSpec:
        members = [item for item in rest if isinstance(item, tuple)]
        return self.enumeration(members, self._plain(rest[-1]), position_of(left))

    def enumeration(self, members: Any, base: Any, at: s.Position) -> s.EnumSpec:
        """Return an enumeration with these members; each is a pair (name, value or None)."""
        if any(value is not None for _, value in members):
            self.note("an enumeration with values", at)
        if base is not None:
            self.note("an enumeration with a base type", at)
        names = tuple(name for name, _ in members)
        return s.EnumSpec(names, at, tuple(value for _, value in members), base)

    def named_value(self, name: Token, _is: Token | None, value: Any) -> tuple[s.Name, Any]:
        return name_of(name), value

    def struct_spec(self, struct: Token, *rest: Any) -> s.StructSpec:
        if union := struct.type == "UNION":
            self.note("a UNION", position_of(struct))
        return s.StructSpec(nodes_of(rest, s.VarDecl), position_of(struct), union)

    def field_declaration(self, *rest: Any) -> s.VarDecl:
        *_, _word, address, _colon, spec, _is, initial, _end = rest
        names = _names_of(rest[:-7])
        return s.VarDecl(names, self._plain(spec), initial, _optional(address), names[0].at)

    def struct_field(self, *rest: Any) -> s.VarDecl:
        names = _names_of(rest[:-2])
        return s.VarDecl(names, rest[-1], None, None, names[0].at)

    def array_init(self, left: Token, *rest: Any) -> s.ArrayInit:
        return s.ArrayInit(nodes_of(rest, tuple), position_of(left))

    def one_item(self, value: s.Init) -> tuple[None, s.Init]:
        return None, value

    def repeated(self, *items: Any) -> tuple[Any, ...]:
        return nodes_of(items, tuple)

    def repeated_item(
        self, count: Token, _left: Token, items: Any, _right: Token
    ) -> tuple[s.Literal, s.Init]:
        times = s.Literal("INTEGER", str(count), position_of(count))
        if items is not None and len(items) == 1 and items[0][0] is None:
            return times, items[0][1]
        return times, s.Sequence(items or (), position_of(count))

    def bare_array(self, *rest: Any) -> s.ArrayInit:
        items = nodes_of(rest, tuple)
        at = items[0][1].at
        self.note("an initial value without brackets", at)
        return s.ArrayInit(items, at)

    def bare_repeated(self, count: Token, left: Token, items: Any, right: Token) -> s.ArrayInit:
        self.note("an initial value without brackets", position_of(count))
        return s.ArrayInit((self.repeated_item(count, left, items, right),), position_of(count))

    def struct_init(self, left: Token, *rest: Any) -> s.StructInit:
        if not nodes_of(rest, tuple):
            self.note("an empty initial value", position_of(left))
        return s.StructInit(nodes_of(rest, tuple), position_of(left))

    def _headed(self, rest: tuple[Any, ...]) -> None:
        """Note a superfluous semicolon behind the first line of a POU."""
        for token in rest[:1]:
            if isinstance(token, Token) and token.type == "SEMICOLON":
                self.note("a ; behind the name of a POU", position_of(token))

    def function(
        self, word: Token, words: Any, name: Token, _colon: Any, result: Any, *rest: Any
    ) -> s.Pou:
        self._headed(rest)
        if result is None:
            self.note("a function without a result", position_of(name))
        self._ended(word, rest[-1])
        (body,) = nodes_of(rest, tuple)
        sections = nodes_of(rest, s.Section)
        kind, plain = word.upper(), self._plain(result)
        return s.Pou(kind, name_of(name), plain, sections, body, position_of(word), words=words)

    def block(
        self, word: Token, words: Any, name: Token, base: Any, interfaces: Any, *rest: Any
    ) -> s.Pou:
        if base is not None and len(base) > 1:
            words = (*words, TWO_BASES)
        pou = self.program(word, name, *rest)
        base, values = _base_of(base)
        return replace(pou, words=words, extends=base, implements=interfaces or (), generics=values)

    def generic_block(self, word: Token, words: Any, name: Token, *rest: Any) -> s.Pou:
        """Return a block with its generic constants before EXTENDS."""
        place = self._after_generics(rest, "EXTENDS")
        others = (*rest[:place], *rest[place + 2 :])
        return self.block(word, words, name, rest[place], rest[place + 1], *others)

    def generic_implementer(self, word: Token, words: Any, name: Token, *rest: Any) -> s.Pou:
        """Return a block with its generic constants before IMPLEMENTS."""
        place = self._after_generics(rest, "IMPLEMENTS")
        others = (*rest[:place], *rest[place + 1 :])
        return self.block(word, words, name, None, rest[place], *others)

    def _after_generics(self, rest: tuple[Any, ...], word: str) -> int:
        """Return the index behind the first sections, all of which must be VAR_GENERIC."""
        place = next(k for k, one in enumerate(rest) if not isinstance(one, s.Section))
        for section in rest[:place]:
            if section.kind != "VAR_GENERIC":
                text = f"{word} stands behind {section.kind}"
                self._refused(text, section.at, f"write {word} behind the name of the block")
        return place

    def _refused(self, text: str, at: s.Position, hint: str) -> None:
        """Report a mistake that the grammar itself does not find."""
        self.errors.append(
            InputError(text, file=self.file, line=at.line, column=at.column, hint=hint)
        )

    def class_(
        self, word: Token, words: Any, name: Token, base: Any, interfaces: Any, *rest: Any
    ) -> s.Pou:
        """Return a CLASS: a block without a body, with CLASS among its words."""
        self.note("a CLASS", position_of(word))
        if base is not None and len(base) > 1:
            words = (*words, TWO_BASES)
        return s.Pou(
            "FUNCTION_BLOCK",
            name_of(name),
            None,
            nodes_of(rest, s.Section),
            (),
            position_of(word),
            words=(*words, CLASS),
            extends=_base_of(base)[0],
            implements=interfaces or (),
            members=nodes_of(rest, (s.Method, s.Property)),
            generics=_base_of(base)[1],
        )

    def _ended(self, word: Token, end: Token) -> None:
        """Note a missing END. recovery.py inserts an END token without text for it."""
        if not end:
            self.note("no END of a POU", position_of(word))

    def program(self, word: Token, name: Token, *rest: Any) -> s.Pou:
        self._headed(rest)
        self._ended(word, rest[-1])
        (inside,) = nodes_of(rest, tuple)
        others = (s.Method, s.Property)
        return s.Pou(
            word.upper(),
            name_of(name),
            None,
            nodes_of(rest, s.Section),
            tuple(one for one in inside if not isinstance(one, others)),
            position_of(word),
            members=nodes_of(inside, others),
        )

    # --- object orientation and references ---

    def access_words(self, *words: Token) -> tuple[str, ...]:
        if words:
            self.note("an access specifier", position_of(words[0]))
        return tuple(word.upper() for word in words)

    def bases(self, word: Token, *rest: Any) -> tuple[s.Name | s.NamedSpec, ...]:
        self.note(word.upper(), position_of(word))
        return nodes_of(rest, (s.Name, s.NamedSpec))

    def generic_base(self, name: s.Name, *rest: Any) -> s.NamedSpec:
        return self.generic_spec(name, *rest)

    def interface(
        self, word: Token, _words: Any, name: Token, base: Any, *rest: Any
    ) -> s.Interface:
        self.note("an INTERFACE", position_of(word))
        members = nodes_of(rest, (s.Method, s.Property))
        bases = tuple(one.name if isinstance(one, s.NamedSpec) else one for one in base or ())
        return s.Interface(name_of(name), bases, members, position_of(word))

    def method(self, word: Token, words: Any, name: Token, *rest: Any) -> s.Method:
        self.note("a METHOD", position_of(word))
        sections, result = nodes_of(rest, s.Section), self._plain(rest[1])
        return s.Method(name_of(name), words, result, sections, rest[-2], position_of(name))

    def property(
        self, word: Token, words: Any, name: Token, _colon: Token, result: Any, *rest: Any
    ) -> s.Property:
        self.note("a PROPERTY", position_of(word))
        found: dict[str, s.Method] = {}
        for one in nodes_of(rest, s.Method):
            # GET or SET may have a more restrictive access word than their property.
            own = one.words if set(one.words) & _ACCESS else ()
            found[one.name.text] = replace(
                one,
                name=name_of(name),
                words=(*own, *(word for word in words if not own or word not in _ACCESS)),
                result=self._plain(result),
            )
        getter, setter = found.get("GET"), found.get("SET")
        return s.Property(
            name_of(name), words, self._plain(result), getter, setter, position_of(name)
        )

    def getter(self, word: Token, words: tuple[str, ...], *rest: Any) -> s.Method:
        name = s.Name(word.upper(), position_of(word))
        return s.Method(name, words, None, nodes_of(rest, s.Section), rest[-2], position_of(word))

    def pointer_spec(self, kind: Token, *rest: Any) -> s.PointerSpec:
        self.note(
            "REFERENCE TO" if kind.upper() == "REFERENCE" else "POINTER TO", position_of(kind)
        )
        return s.PointerSpec(kind.upper(), self._plain(rest[-1]), position_of(kind))

    def type_argument(self, spec: s.PointerSpec | s.ArraySpec) -> s.Argument:
        return s.Argument(None, s.TypeName(spec, spec.at), False, spec.at)

    def namespace(self, word: Token, name: s.Name, *rest: Any) -> list[Any]:
        self.note("a NAMESPACE", position_of(word))
        found: list[Any] = [s.Namespace(name, False, position_of(word))]
        for one in rest[:-1]:
            found += one if isinstance(one, list) else [one]
        return [one for one in found if one is not None and not isinstance(one, Token)]

    def using(self, word: Token, *names: Any) -> list[s.Namespace]:
        self.note("a NAMESPACE", position_of(word))
        return [s.Namespace(name, True, position_of(word)) for name in nodes_of(names, s.Name)]

    def this(self, word: Token) -> s.This:
        self.note("THIS or SUPER", position_of(word))
        return s.This(word.upper() == "SUPER", position_of(word), pointer=True)

    def action(self, word: Token, name: Token, _colon: Token, body: Any, _end: Token) -> s.Method:
        self.note("an ACTION", position_of(word))
        return s.Method(name_of(name), (ACTION,), None, (), body, position_of(name))

    def section(self, word: Token, *rest: Any) -> s.Section:
        given = [item for item in rest if isinstance(item, Token)][:-1]
        access = [item for item in given if item.type == "WORD"]
        words = [str(item).upper() for item in given if item.type != "WORD"]
        if access:
            self.note("an access specifier", position_of(access[0]))
        if len(words) > 1:
            self.note("several qualifiers", position_of(word))
        if "PERSISTENT" in words:
            self.note("PERSISTENT", position_of(word))
        if word.type in ("VAR_STAT", "VAR_INST", "VAR_GENERIC"):
            self.note(word.upper(), position_of(word))
        qualifier = "CONSTANT" if "CONSTANT" in words else "RETAIN" if words else ""
        qualifier = "NON_RETAIN" if words == ["NON_RETAIN"] else qualifier
        kept = access[0].upper() if access else ""
        variables = nodes_of(rest, s.VarDecl)
        return s.Section(word.upper(), qualifier, variables, position_of(word), kept)

    def global_list(self, word: Token, *rest: Any) -> s.GlobalList:
        self.note("VAR_GLOBAL outside a CONFIGURATION", position_of(word))
        return s.GlobalList(
            s.Name("", position_of(word)), self.section(word, *rest), position_of(word)
        )

    def var_declaration(self, *rest: Any) -> s.VarDecl:
        _word, address, _colon, spec, _is, initial, _end = rest[-7:]
        names = _names_of(rest[:-7])
        bound = isinstance(_is, Token) and _is.upper() == "REF="
        if isinstance(_is, Token) and _is.type == "LATCH" and not bound:
            text, place = f"{_is} is not an initial value", position_of(_is)
            error = InputError(text, file=self.file, line=place.line, column=place.column)
            self.errors.append(error)
        plain, at = self._plain(spec), names[0].at
        return s.VarDecl(names, plain, initial, _optional(address), at, bound)

    # --- configuration ---

    def configuration(self, word: Token, name: Token, *rest: Any) -> s.Configuration:
        resources = [item for item in rest if isinstance(item, list)]
        items = [*rest, *(item for resource in resources for item in resource)]
        return s.Configuration(
            name_of(name),
            nodes_of(items, s.Section),
            nodes_of(items, s.TaskDeclaration),
            nodes_of(items, s.ProgramInstance),
            len(resources),
            position_of(word),
        )

    def config_section(self, word: Token, *rest: Any) -> None:
        self.note("VAR_CONFIG", position_of(word))
        self.entries += nodes_of(rest, s.ConfigEntry)

    def config_entry(
        self, path: s.Variable, _at: Any, address: Any, _colon: Token, spec: Any, *rest: Any
    ) -> s.ConfigEntry:
        plain = self._plain(spec)
        return s.ConfigEntry(path, _optional(address), plain, rest[1], path.at)

    def resource(self, _word: Token, *rest: Any) -> list[Any]:
        return [item for item in rest if not isinstance(item, Token)]

    def task(self, _word: Token, name: Token, *rest: Any) -> s.TaskDeclaration:
        return s.TaskDeclaration(name_of(name), nodes_of(rest, tuple), position_of(name))

    def program_instance(
        self, _word: Token, name: Token, _with: Any, task: Any, _colon: Token, *rest: Any
    ) -> s.ProgramInstance:
        connected = any(part is not None for part in rest[1:-1])
        return s.ProgramInstance(
            name_of(name), _optional(task), name_of(rest[0]), connected, position_of(name)
        )


#: Attributes of an enumeration that change how the checker treats it.
_ATTRIBUTE = re.compile(r"attribute\s+'(strict|to_string)'")
_ACCESS = frozenset(("PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL"))
_START = Token("$START", "", 0, 1, 1)
_LITERALS = ("INTEGER", "REALNUM", "STRING", "TYPED")
#: Cached parser tables. Building them takes longer than parsing the library.
_TABLES = "grammar.tables"


class _NoLexer(Lexer):
    """An empty lexer, because lark requires a lexer. The tokens come from `lexer.tokens`."""

    def __init__(self, lexer_conf: Any) -> None:
        del lexer_conf

    def lex(self, lexer_state: Any, parser_state: Any = None) -> Iterator[Token]:
        del lexer_state, parser_state
        return iter(())


@lru_cache(maxsize=1)
def _parser() -> tuple[Lark, _Builder]:
    grammar = files(__package__).joinpath("grammar.lark").read_text(encoding="utf-8")
    names = {*KEYWORDS, *PUNCTUATION.values(), *_LITERALS, "IDENT", "LABEL", "DIRECT", "PART"}
    names |= {"WORD", *ACCESSORS, *EXCEPTIONS.values()}
    declared = f"\n%declare {' '.join(sorted(names))} LATCH ERROR\n"
    builder = _Builder()
    make = partial(
        Lark,
        grammar + declared,
        parser="lalr",
        lexer=_NoLexer,
        transformer=builder,
        maybe_placeholders=True,
    )
    kept = cache.folder()
    if kept is None:
        return make(), builder
    before: bytes | None = None
    # lark unpickles its cache file, which can execute code. Therefore lark gets a copy of a cache
    # entry, after `cache` has verified that this user has written the entry.
    with TemporaryDirectory(prefix=f"{COMMAND}-") as folder:
        tables = Path(folder, _TABLES)
        with suppress(OSError, ValueError):
            before = cache.content(kept / _TABLES)
            tables.write_bytes(before)
        lark = make(cache=str(tables))  # lark rebuilds the tables if the grammar has changed
        with suppress(OSError):
            if (after := tables.read_bytes()) != before:
                cache.put(kept / _TABLES, after)
    return lark, builder


def parse(file: Path) -> s.Source:
    """Read and parse a file, or raise InputError."""
    return parse_text(source_text(file), file)


def parse_text(text: str, file: Path) -> s.Source:
    """Parse a source, or raise InputError."""
    return _whole(read_text(text, file))


def parse_portable(text: str, file: Path) -> s.Source:
    """Parse a source of the portable subset, without caching the result.

    Raises:
        InputError: The text has a syntax error, or a construct beyond the portable subset.
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
    """Parse as much of a source as can be read, and collect the errors.

    The result is cached per process by text and file.
    """
    lark, builder = _parser()
    notes = Notes()
    found = list(islice(tokens(text, file, notes), MOST_TOKENS + 1))
    if len(found) > MOST_TOKENS:
        return s.Source(file, (), errors=(_too_many(found[-1], file),))
    if file.suffix.lower() == ".var":
        found = [
            Token("PROGRAM", "PROGRAM", 0, 1, 1),
            Token("IDENT", SHELL, 0, 1, 1),
            *found,
            Token.new_borrow_pos("END_PROGRAM", "END_PROGRAM", found[-1] if found else _START),
        ]
    if not isinstance(file, Extract) and (error := not_structured_text(found, file)):
        return s.Source(file, (), errors=(error,))
    found = corrected(found, file, notes.errors.append)
    found = with_names(found, file, notes.uses)
    builder.uses, builder.errors, builder.file = notes.uses, notes.errors, file
    builder.entries = []
    declarations, errors = read_tokens(lark, found, file)
    if any("is never closed" in error.message for error in notes.errors):
        errors = [one for one in errors if not one.hint.endswith(AT_END)]
    named = _named(declarations, file, notes.pragmas, errors)
    lines = {error.line for error in notes.errors}
    every = [*notes.errors, *(error for error in errors if error.line not in lines)]
    every.sort(key=lambda error: (error.line or 0, error.column or 0))
    return s.Source(
        file,
        named,
        tuple(sorted(notes.uses, key=lambda use: use.at)),
        tuple(notes.pragmas),
        tuple(one_for_all(every)),
        nodes_of(declarations, s.Namespace),
        len(text),
        len(found),
        tuple(builder.entries),
    )


def _too_many(token: Token, file: Path) -> InputError:
    return InputError(
        f"more than {MOST_TOKENS:,} words, numbers and signs up to here",
        file=file,
        line=token.line,
        column=token.column,
        hint="leave out what the program does not need",
    )


def _named(
    declarations: list[Any], file: Path, pragmas: list[s.Name], errors: list[InputError]
) -> tuple[Any, ...]:
    """Return the declarations with names for global lists and with members in their POUs.

    A list of globals is named after its file. An ACTION, METHOD or PROPERTY behind a POU or
    INTERFACE belongs to it; `errors` receives an error for each of these elements that follows
    neither a POU nor an INTERFACE.
    """
    result: list[Any] = []
    for one in declarations:
        if isinstance(one, s.Namespace):
            continue
        if isinstance(one, (s.Method, s.Property)):  # the element belongs to the POU before it
            if result and isinstance(result[-1], (s.Pou, s.Interface)):
                result[-1] = replace(result[-1], members=(*result[-1].members, one))
            else:
                text = f"{one.name.text} belongs to no block"
                errors.append(
                    InputError(
                        text,
                        file=file,
                        line=one.at.line,
                        column=one.at.column,
                        hint="a METHOD, PROPERTY or ACTION stands inside its block or behind it",
                    )
                )
            continue
        if isinstance(one, s.TypeDecl) and isinstance(one.spec, s.EnumSpec):
            begin = result[-1].at if result else s.Position(1, 1)
            said = " ".join(pragma.text for pragma in pragmas if begin <= pragma.at < one.at)
            given = frozenset(_ATTRIBUTE.findall(said.lower()))
            one = replace(one, spec=replace(one.spec, attributes=given))
        if isinstance(one, s.GlobalList):
            begin = result[-1].at if result else s.Position(1, 1)
            qualified = any(
                "qualified_only" in pragma.text and begin <= pragma.at < one.at
                for pragma in pragmas
            )
            one = replace(one, name=s.Name(title_of(file), one.at), qualified=qualified)
        result.append(one)
    return tuple(result)
