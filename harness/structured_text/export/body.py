"""Statements with the functions and pins of a tool; comments and line breaks are preserved.

The translation works on tokens, not on the syntax tree. The text between tokens is copied, so the
output has the layout of the source. Only calls, names, paths and literals are rewritten. A subclass
for a tool overrides the methods whose result differs in this tool.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from structured_text.export.parts import Part, Sources
from structured_text.export.words import Words
from structured_text.language import syntax as s
from structured_text.language.lexer import tokens
from structured_text.language.standard import BLOCKS, FUNCTIONS, conversion
from structured_text.language.walk import declared

__all__ = ["Body", "Scope", "variables_of"]

_OPERATORS = frozenset(
    (
        *("PLUS", "MINUS", "STAR", "SLASH", "POWER", "AND", "OR", "XOR", "MOD", "NOT"),
        *("EQ", "NE", "LT", "GT", "LE", "GE", "AMPERSAND"),
    )
)
_OPEN = {"LPAR": 1, "LSQB": 1, "RPAR": -1, "RSQB": -1}
_ENDS = ("IDENT", "LABEL", "INTEGER", "REALNUM", "STRING", "TYPED", "TRUE", "FALSE", "RPAR", "RSQB")
_PASSED = ("VAR_INPUT", "VAR_IN_OUT")

#: A step of a path, which is a field or an index: the number of its first token, the number of the
#: token after it, and the types before and after the step.
_Step = tuple[int, int, "s.TypeSpec | None", "s.TypeSpec | None"]


@dataclass(frozen=True)
class Scope:
    """The meaning of names in the statements of a POU, by upper-case name.

    Attributes:
        variables: Types of the variables of the POU.
        base: A function that returns the definition of a named type.
        pins: The inputs and VAR_IN_OUT of each block and function of the sources, in order.
        functions: The functions of the sources.
    """

    variables: Mapping[str, s.TypeSpec]
    base: Callable[[s.TypeSpec | None], s.TypeSpec | None]
    pins: Mapping[str, tuple[str, ...]]
    functions: Collection[str]

    @staticmethod
    def of(part: Part, sources: Sources) -> Scope:
        """Return the scope for the statements of a declaration."""
        return Scope(
            variables_of(part.node) if isinstance(part.node, s.Pou) else {},
            sources.base,
            {
                one.name.upper(): _pins(one.node)
                for one in sources.parts
                if isinstance(one.node, s.Pou)
            },
            {one.name.upper() for one in sources.of("FUNCTION")},
        )

    def block(self, spec: s.TypeSpec | None) -> str:
        """Return the upper-case name of a type if it is a block type, else ""."""
        key = spec.name.key if isinstance(spec, s.NamedSpec) else ""
        return key if key in BLOCKS or key in self.pins else ""


def variables_of(node: s.Pou) -> dict[str, s.TypeSpec]:
    """Return the types of a POU's variables by upper-case name.

    The result includes the name of a function itself, with the type of its result.
    """
    found = {name.key: one.spec for _, one, name in declared(node.sections)}
    return found if node.result is None else {**found, node.name.key: node.result}


def _pins(node: s.Pou) -> tuple[str, ...]:
    names = declared(one for one in node.sections if one.kind in _PASSED)
    return tuple(name.text for _, _, name in names)


class Body:
    """A writer of statements with a tool's own standard functions and pins of standard blocks."""

    def __init__(self, text: str, scope: Scope, words: Words) -> None:
        self._text = text
        self._found = list(tokens(text, Path("body")))
        self._scope = scope
        self._words = words

    def all(self) -> str:
        """Return the translated statements, with the text before and after the statements."""
        if not self._found:
            return self._text
        last = len(self._found)
        return f"{self._gap(0)}{self._run(0, last)}{self._text[self._end(last - 1) :]}"

    # --- methods that a tool may override -------------------------------------------------

    def _plain(self, text: str) -> str:
        """Return the tool's name for a variable, pin, field or function of the sources."""
        return text

    def _word(self, at: int) -> str:
        """Return the tool's name for a member of an enumeration or for a function."""
        return str(self._found[at])

    def _own(self, at: int, given: list[tuple[str, int, int]], end: int) -> str:
        """Return a call of a function that the sources declare, in the tool's form."""
        return self._listed(at, given, end, self._scope.pins[self._found[at].upper()], named=None)

    def _typed(self, text: str) -> str:
        """Return a typed literal such as `UINT#1`, in the tool's form."""
        return text

    # --- tokens ---------------------------------------------------------------------------

    def _end(self, at: int) -> int:
        return (self._found[at].start_pos or 0) + len(self._found[at]) if at >= 0 else 0

    def _gap(self, at: int) -> str:
        return self._text[self._end(at - 1) : self._found[at].start_pos or 0]

    def _kind(self, at: int) -> str:
        return str(self._found[at].type) if 0 <= at < len(self._found) else ""

    def _run(self, first: int, last: int) -> str:
        """Return the text of the tokens from `first` to before `last`.

        The text before the first token is not included.
        """
        pieces, at = [], first
        while at < last:
            gap = self._gap(at) if at > first else ""
            piece, at = self._piece(at)
            pieces.append(f"{gap}{piece}")
        return "".join(pieces)

    def _piece(self, at: int) -> tuple[str, int]:
        """Return the text of a token, call or variable, and the index of the token after it."""
        token, kind = self._found[at], self._kind(at)
        called = self._kind(at + 1) == "LPAR"
        if kind == "AMPERSAND":
            return "AND", at + 1
        if kind in FUNCTIONS and called and self._kind(at - 1) not in _ENDS:
            return self._function(at)
        if kind == "TYPED":
            return self._typed(str(token)), at + 1
        if kind not in ("IDENT", "LABEL"):
            return str(token), at + 1
        if kind == "IDENT" and token.upper() in self._scope.variables:
            return self._path(at)
        return self._function(at) if called else (self._word(at), at + 1)

    def _path(self, at: int) -> tuple[str, int]:
        """Return a variable with its fields and indices, or a block's instance with its call."""
        pieces = [self._variable(at)]
        spec = self._scope.base(self._scope.variables[self._found[at].upper()])
        at += 1
        for first, end, before, after in self._steps(at, spec):
            if self._kind(first) == "LSQB":
                pieces.append(f"{self._gap(first)}{self._enclosed(first, end)}")
            else:
                pin = self._pin(self._scope.block(before), str(self._found[first + 1]))
                pieces.append(f"{self._gap(first)}.{self._gap(first + 1)}{pin}")
            at, spec = end, after
        if self._kind(at) == "LPAR" and self._scope.block(spec):
            end = self._closed(at)
            pieces.append(f"{self._gap(at)}({self._pins(at, end, self._scope.block(spec))})")
            at = end
        return "".join(pieces), at

    def _steps(self, at: int, spec: s.TypeSpec | None) -> Iterator[_Step]:
        """Yield the steps (fields and indices) of a path from a token on."""
        while self._kind(at) in ("DOT", "LSQB"):
            if self._kind(at) == "LSQB":
                end, after = self._closed(at), getattr(spec, "element", None)
            else:
                end, after = at + 2, self._field(spec, self._found[at + 1].upper())
            after = self._scope.base(after)
            yield at, end, spec, after
            at, spec = end, after

    def _variable(self, at: int) -> str:
        return self._plain(str(self._found[at]))

    def _enclosed(self, at: int, end: int) -> str:
        """Return the text of a pair of brackets, including the brackets."""
        inside = f"{self._gap(at + 1)}{self._run(at + 1, end - 1)}{self._gap(end - 1)}"
        return f"{self._found[at]}{inside}{self._found[end - 1]}"

    def _pin(self, block: str, name: str) -> str:
        """Return the tool's name for a field, or for a pin of a standard block."""
        form = self._words.blocks.get(block)
        if form is None or block not in BLOCKS:
            return self._plain(name)
        pins = [one.name.upper() for one in BLOCKS[block].variables]
        found = form.parameters[pins.index(name.upper())]
        return name if found.upper() == name.upper() else found

    def _pins(self, at: int, end: int, block: str) -> str:
        """Return the arguments of a call of a block, each with the tool's name of its pin."""
        pieces = []
        standard = BLOCKS.get(block)
        order = [one.name for one in standard.variables] if standard else self._scope.pins[block]
        for place, (name, first, last) in enumerate(self._arguments(at + 1, end - 1)):
            if place:
                pieces.append(f"{self._gap(self._begin(name, first) - 1)},")
            pieces.append(self._gap(self._begin(name, first)))
            if name:
                sign = f"{self._gap(first - 1)}{self._found[first - 1]}{self._gap(first)}"
                pieces.append(f"{self._pin(block, str(self._found[first - 2]))}{sign}")
            else:
                pieces.append(f"{self._pin(block, order[place])} := ")
            pieces.append(self._run(first, last))
        return f"{''.join(pieces)}{self._gap(end - 1)}"

    # --- functions ------------------------------------------------------------------------

    def _function(self, at: int) -> tuple[str, int]:
        end = self._closed(at + 1)
        given = self._arguments(at + 2, end - 1)
        key = self._found[at].upper()
        if key in self._scope.functions:
            return self._own(at, given, end), end
        types = conversion(key)
        if types is not None:
            return self._converted(*types, given[0][1:]), end
        return (self._standard(key, given) if key in FUNCTIONS else self._run(at, end)), end

    def _converted(self, source: str, target: str, value: tuple[int, int]) -> str:
        return f"{source}_TO_{target}({self._run(*value)})"

    def _standard(self, key: str, given: list[tuple[str, int, int]]) -> str:
        """Return a call of a standard function in the form that the tool's list gives."""
        form = self._words.functions[key]
        ordered = sorted(given, key=lambda one: _rank(key, one[0])) if given[0][0] else given
        texts = []
        for place, (name, first, last) in enumerate(ordered):
            kept = place and given[place] == ordered[place]
            gap = self._gap(self._begin(name, first)) if kept else " " if place else ""
            texts.append(f"{gap}{self._argument(key, place, first, last)}")
        return form.text(key, texts)

    def _argument(self, key: str, place: int, first: int, last: int) -> str:
        """Return an argument of a standard function; `place` is the index of the argument."""
        return self._run(first, last)

    def _listed(
        self,
        at: int,
        given: list[tuple[str, int, int]],
        end: int,
        parameters: tuple[str, ...],
        *,
        named: bool | None,
        defaults: Mapping[str, str] | None = None,
    ) -> str:
        """Return a call of a function of the sources.

        `at` is the index of the function's name, and `end` the index of the token after the call.
        `named` says whether arguments are named; None leaves them as in the source. `defaults` are
        values for omitted arguments, by upper-case name.
        """
        texts, keys = {}, [one.upper() for one in parameters]
        for place, (name, first, last) in enumerate(given):
            key = name or keys[place]
            wanted = keys.index(key) if named is False else place
            begin = self._begin(name, first)
            gap = self._gap(begin) if place == wanted and place else " "
            parameter = self._plain(parameters[keys.index(key)])
            written = f"{parameter} := " if named or (named is None and name) else ""
            texts[key] = (gap, f"{written}{self._run(first, last)}")
        missing = {key: (" ", value) for key, value in (defaults or {}).items() if key not in texts}
        if named:
            missing = {
                key: (gap, f"{self._plain(parameters[keys.index(key)])} := {value}")
                for key, (gap, value) in missing.items()
            }
        every = texts | missing
        order = keys if named is False else every
        pieces = [every[key] for key in order if key in every]
        inside = "".join(f"{',' + gap if k else ''}{text}" for k, (gap, text) in enumerate(pieces))
        return f"{self._word(at)}({inside})"

    def _begin(self, name: str, first: int) -> int:
        """Return the index of the first token of an argument's value."""
        return first - 2 if name else first

    def _arguments(self, first: int, end: int) -> list[tuple[str, int, int]]:
        """Return the name (upper case or ""), first token and end of each argument."""
        found, depth, begin = [], 0, first
        for at in range(first, end + 1):
            depth += _OPEN.get(self._kind(at), 0) if at < end else 0
            if at == end or (depth == 0 and self._kind(at) == "COMMA"):
                named = self._kind(begin + 1) in ("ASSIGN", "SENDTO")
                name = self._found[begin].upper() if named else ""
                if begin < at:
                    found.append((name, begin + 2 if named else begin, at))
                begin = at + 1
        return found

    def _closed(self, at: int) -> int:
        """Return the index after the closing parenthesis or bracket of the opening one at `at`."""
        depth = 0
        while True:
            depth += _OPEN.get(self._kind(at), 0)
            at += 1
            if depth == 0:
                return at

    def _compound(self, first: int, last: int) -> bool:
        depth = 0
        for at in range(first, last):
            depth += _OPEN.get(self._kind(at), 0)
            if depth == 0 and self._kind(at) in _OPERATORS:
                return True
        return False

    def _type(self, at: int) -> s.TypeSpec | None:
        """Return the type of a variable, a field or an element."""
        spec = self._scope.base(self._scope.variables.get(self._found[at].upper()))
        steps = list(self._steps(at + 1, spec))
        return steps[-1][-1] if steps else spec

    def _field(self, spec: s.TypeSpec | None, key: str) -> s.TypeSpec | None:
        if not isinstance(spec, s.StructSpec):
            return None
        return next(
            (one.spec for one in spec.fields if key in {name.key for name in one.names}), None
        )


def _rank(key: str, name: str) -> int:
    """Return the standard's position of a named argument of a standard function."""
    pins = [pin for pin, _ in FUNCTIONS[key].pins]
    if name in pins:
        return pins.index(name)
    return len(pins) + int(name.lstrip("IN"))
