"""Statements in the dialect of a tool that has no word for some types."""

from __future__ import annotations

from rcx_harness.engine.frontend.standard import FUNCTIONS, conversion
from rcx_harness.export.body import Body, Scope
from rcx_harness.export.dialect.dialect import Names

__all__ = ["dialect_body"]

_COMPARED = ("EQ", "NE", "LT", "GT", "LE", "GE")
_SHIFTS = ("SHL", "SHR", "ROL", "ROR")


def dialect_body(text: str, scope: Scope, names: Names) -> str:
    """Rewrite statements.

    Arguments of functions lose their names and stand in the order of the parameters, left-out
    ones are written out; members of enumerations, typed literals and conversions are the
    tool's; where it has no BYTE, what could leave the lower half of a WORD is masked.

    Args:
        text: The statements.
        scope: What the POU's names mean.
        names: What the other names are here.
    """
    return _Body(text, scope, names).all()


class _Body(Body):
    def __init__(self, text: str, scope: Scope, names: Names) -> None:
        super().__init__(text, scope, names.dialect.words_of)
        self._names = names
        self._dialect = names.dialect

    def _plain(self, text: str) -> str:
        return self._dialect.name(text)

    def _typed(self, text: str) -> str:
        return self._dialect.typed(text)

    def _word(self, at: int) -> str:
        token = self._found[at]
        key = token.upper()
        if key in self._names.members:
            return self._names.member(key)
        return str(token) if key in self._names.functions else self._dialect.name(str(token))

    def _piece(self, at: int) -> tuple[str, int]:
        if self._kind(at) == "NOT" and self._byte(at + 1):
            end = self._primary(at + 1)
            return f"(NOT {self._run(at + 1, end)} AND {self._dialect.mask})", end
        return super()._piece(at)

    def _own(self, at: int, given: list[tuple[str, int, int]], end: int) -> str:
        key = self._found[at].upper()
        defaults = self._names.functions[key].defaults
        pins = self._scope.pins[key]
        return self._listed(at, given, end, pins, named=False, defaults=defaults)

    def _standard(self, key: str, given: list[tuple[str, int, int]]) -> str:
        call = super()._standard(key, given)
        if key in self._dialect.results:
            call = f"{self._dialect.results[key]}({call})"
        shifted = next((first for name, first, _ in given if name in ("", "IN")), 0)
        if key in _SHIFTS and self._byte(shifted):
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

    def _argument(self, key: str, place: int, first: int, last: int) -> str:
        """An argument, converted where the tool's standard function wants another type."""
        text = self._run(first, last)
        wanted = self._dialect.arguments.get(key, ())
        plain = last == first + 1 and self._kind(first) == "INTEGER"
        if place >= len(wanted) or not wanted[place] or plain:
            return text
        return f"{wanted[place]}({text})"

    def _primary(self, at: int) -> int:
        """Behind a variable, a literal, a call or what is in parentheses."""
        if self._kind(at) == "LPAR":
            return self._closed(at)
        at += 1
        while self._kind(at) in ("DOT", "LSQB", "LPAR"):
            at = at + 2 if self._kind(at) == "DOT" else self._closed(at)
        return at

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
        if self._kind(at + 1) == "LPAR" and (kind == "IDENT" or kind in FUNCTIONS):
            own, types = self._names.functions.get(token.upper()), conversion(token.upper())
            if own is not None:
                return self._names.is_byte(own.result)
            if types is not None:
                return types[1] == "BYTE"
            return self._byte_of_standard(at)
        return kind == "IDENT" and self._names.is_byte(self._type(at))

    def _byte_of_standard(self, at: int) -> bool:
        """Whether a standard function's result is: one of its values is a BYTE."""
        key = self._found[at].upper()
        if key not in FUNCTIONS or FUNCTIONS[key].result != "T":
            return False
        pins = [name for name, kind in FUNCTIONS[key].pins if kind == "T"]
        given = self._arguments(at + 2, self._closed(at + 1) - 1)
        skipped = len(FUNCTIONS[key].pins) - len(pins) if key in ("SEL", "MUX") else 0
        values = [
            first
            for place, (name, first, _) in enumerate(given)
            if (name in pins if name else place >= skipped)
        ]
        return any(self._byte(first) for first in values[: len(values) if skipped else 1])
