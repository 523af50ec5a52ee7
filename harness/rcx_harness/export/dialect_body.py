"""Statements in a tool's dialect: the source's own text, its comments and line breaks kept."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.lexer import tokens
from rcx_harness.engine.frontend.standard import FUNCTIONS, conversion
from rcx_harness.export.dialect import Names

__all__ = ["dialect_body"]

_OPERATORS = frozenset(
    (
        *("PLUS", "MINUS", "STAR", "SLASH", "POWER", "AND", "OR", "XOR", "MOD", "NOT"),
        *("EQ", "NE", "LT", "GT", "LE", "GE", "AMPERSAND"),
    )
)
_COMPARED = ("EQ", "NE", "LT", "GT", "LE", "GE")
_SHIFTS = ("SHL", "SHR", "ROL", "ROR")
_OPEN = {"LPAR": 1, "LSQB": 1, "RPAR": -1, "RSQB": -1}


def dialect_body(text: str, variables: Mapping[str, s.TypeSpec], names: Names) -> str:
    """Rewrite statements.

    Arguments of functions lose their names and stand in the order of the parameters, left-out
    ones are written out; members of enumerations, typed literals and conversions are the
    tool's; where it has no BYTE, what could leave the lower half of a WORD is masked.

    Args:
        text: The statements.
        variables: Types of the POU's variables by upper-case name.
        names: What the other names mean.
    """
    return _Body(text, variables, names).all()


class _Body:
    def __init__(self, text: str, variables: Mapping[str, s.TypeSpec], names: Names) -> None:
        self._text = text
        self._found = list(tokens(text, Path("body")))
        self._variables = variables
        self._names = names
        self._dialect = names.dialect
        self._pins: Mapping[str, str] = {}

    def all(self) -> str:
        """The statements, with what stands before and after them."""
        if not self._found:
            return self._text
        last = len(self._found)
        return f"{self._gap(0)}{self._run(0, last)}{self._text[self._end(last - 1) :]}"

    def _end(self, at: int) -> int:
        return (self._found[at].start_pos or 0) + len(self._found[at]) if at >= 0 else 0

    def _gap(self, at: int) -> str:
        return self._text[self._end(at - 1) : self._found[at].start_pos or 0]

    def _kind(self, at: int) -> str:
        return str(self._found[at].type) if 0 <= at < len(self._found) else ""

    def _run(self, first: int, last: int) -> str:
        """Tokens from `first` to before `last`, without what stands before the first one."""
        pieces, at = [], first
        while at < last:
            gap = self._gap(at) if at > first else ""
            piece, at = self._piece(at)
            pieces.append(f"{gap}{piece}")
        return "".join(pieces)

    def _piece(self, at: int) -> tuple[str, int]:
        """A token's text, or that of a call or a masked NOT, and where the next piece begins."""
        token, kind = self._found[at], self._kind(at)
        if kind == "NOT" and self._byte(at + 1):
            end = self._primary(at + 1)
            return f"(NOT {self._run(at + 1, end)} AND {self._dialect.mask})", end
        if kind == "TYPED":
            return self._dialect.typed(str(token)), at + 1
        if kind not in ("IDENT", "LABEL"):
            return str(token), at + 1
        if self._kind(at + 1) == "LPAR" and self._kind(at - 1) != "DOT":
            return self._call(at)
        return self._name(at), at + 1

    def _name(self, at: int) -> str:
        token = self._found[at]
        key = token.upper()
        if self._kind(at + 1) in ("ASSIGN", "SENDTO") and key in self._pins:
            return self._pins[key]
        if self._kind(at - 1) != "DOT" and key not in self._variables:
            if key in self._names.members:
                return self._names.member(key)
            if key in self._names.functions:
                return str(token)
        return self._dialect.name(str(token))

    def _call(self, at: int) -> tuple[str, int]:
        token, end = self._found[at], self._closed(at + 1)
        spec = self._variables.get(token.upper())
        if spec is not None:
            block = spec.name.key if isinstance(spec, s.NamedSpec) else ""
            self._pins, outer = self._dialect.pins.get(block, {}), self._pins
            inside = self._run(at + 2, end - 1)
            self._pins = outer
            gaps = self._gap(at + 2), self._gap(end - 1)
            return f"{self._dialect.name(str(token))}({gaps[0]}{inside}{gaps[1]})", end
        return self._function(at, end), end

    def _function(self, at: int, end: int) -> str:
        name = self._found[at].upper()
        given = self._arguments(at + 2, end - 1)
        own = self._names.functions.get(name)
        types = conversion(name)
        if own is None and types is not None:
            return self._converted(*types, given[0][1:])
        if own is not None:
            parameters = list(own.defaults)
        elif name in FUNCTIONS:
            parameters = [one for one, _ in FUNCTIONS[name].pins]
        else:
            parameters = []
        texts = {}
        for place, (named, first, last) in enumerate(given):
            key = named or (parameters[place] if place < len(parameters) else str(place))
            wanted = parameters.index(key) if key in parameters else place
            begin = first - 2 if named else first
            gap = self._gap(begin) if place == wanted and place else " "
            texts[key] = (self._wrapped(name, wanted, first, last), gap)
        rest = [one for one in texts if one not in parameters]
        every = [
            texts.get(one) or (own.defaults[one] if own else "", " ")
            for one in (*parameters, *rest)
            if one in texts or own
        ]
        inside = "".join(f"{',' + gap if k else ''}{text}" for k, (text, gap) in enumerate(every))
        call = f"{self._found[at]}({inside})"
        if name in self._dialect.results:
            call = f"{self._dialect.results[name]}({call})"
        if name in _SHIFTS and given and self._byte(given[0][1]):
            return f"({call} AND {self._dialect.mask})"
        return call

    def _converted(self, source: str, target: str, value: tuple[int, int]) -> str:
        first, last = self._dialect.word(source), self._dialect.word(target)
        text = self._run(*value)
        if first != last:
            text = f"{first}_TO_{last}({text})"
        elif self._compound(*value):
            text = f"({text})"
        narrowed = target == "BYTE" and not self._dialect.bytes
        return f"({text} AND {self._dialect.mask})" if narrowed else text

    def _wrapped(self, function: str, place: int, first: int, last: int) -> str:
        """An argument, converted where the tool's standard function wants another type."""
        text = self._run(first, last)
        wanted = self._dialect.arguments.get(function, ())
        plain = last == first + 1 and self._kind(first) == "INTEGER"
        if place >= len(wanted) or not wanted[place] or plain:
            return text
        return f"{wanted[place]}({text})"

    def _arguments(self, first: int, end: int) -> list[tuple[str, int, int]]:
        """Name in upper case or "", and first and behind the last token, of each argument."""
        found, depth, begin = [], 0, first
        for at in range(first, end + 1):
            depth += _OPEN.get(self._kind(at), 0) if at < end else 0
            if at == end or (depth == 0 and self._kind(at) == "COMMA"):
                named = self._kind(begin + 1) == "ASSIGN"
                name = self._found[begin].upper() if named else ""
                if begin < at:
                    found.append((name, begin + 2 if named else begin, at))
                begin = at + 1
        return found

    def _closed(self, at: int) -> int:
        """Behind the parenthesis or bracket that closes the one at a place."""
        depth = 0
        while True:
            depth += _OPEN.get(self._kind(at), 0)
            at += 1
            if depth == 0:
                return at

    def _primary(self, at: int) -> int:
        """Behind a variable, a literal, a call or what is in parentheses."""
        if self._kind(at) == "LPAR":
            return self._closed(at)
        at += 1
        while self._kind(at) in ("DOT", "LSQB", "LPAR"):
            at = at + 2 if self._kind(at) == "DOT" else self._closed(at)
        return at

    def _compound(self, first: int, last: int) -> bool:
        depth = 0
        for at in range(first, last):
            depth += _OPEN.get(self._kind(at), 0)
            if depth == 0 and self._kind(at) in _OPERATORS:
                return True
        return False

    def _byte(self, at: int) -> bool:
        """Whether an operand is a BYTE that the tool does not have."""
        token, kind = self._found[at], self._kind(at)
        if self._dialect.bytes:
            return False
        if kind == "NOT":
            return self._byte(at + 1)
        if kind == "LPAR":
            inside = range(at + 1, self._closed(at) - 1)
            return self._byte(at + 1) and not any(self._kind(k) in _COMPARED for k in inside)
        if kind == "TYPED":
            return str(token).upper().startswith("BYTE#")
        if kind != "IDENT":
            return False
        if self._kind(at + 1) == "LPAR":
            own, types = self._names.functions.get(token.upper()), conversion(token.upper())
            if own is not None:
                return self._names.is_byte(own.result)
            if types is not None:
                return types[1] == "BYTE"
            given = self._arguments(at + 2, self._closed(at + 1) - 1)
            return token.upper() in _SHIFTS and self._byte(given[0][1])
        return self._names.is_byte(self._variable(at))

    def _variable(self, at: int) -> s.TypeSpec | None:
        """The type of a variable, a field or an element."""
        spec = self._names.base(self._variables.get(self._found[at].upper()))
        at += 1
        while self._kind(at) in ("DOT", "LSQB"):
            if self._kind(at) == "LSQB":
                spec = spec.element if isinstance(spec, s.ArraySpec) else None
                at = self._closed(at)
            else:
                spec = self._field(spec, self._found[at + 1].upper())
                at += 2
            spec = self._names.base(spec)
        return spec

    @staticmethod
    def _field(spec: s.TypeSpec | None, key: str) -> s.TypeSpec | None:
        if not isinstance(spec, s.StructSpec):
            return None
        return next(
            (one.spec for one in spec.fields if key in {name.key for name in one.names}), None
        )
