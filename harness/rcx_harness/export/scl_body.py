"""Statements in Siemens SCL: the source's own text with its names marked as SCL wants them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from rcx_harness.export.body import Body, Scope
from rcx_harness.export.words import words

__all__ = ["Names", "quoted", "scl_body"]

#: Words of SCL that are names in IEC 61131-3.
_RESERVED = frozenset(
    (
        *("AUTHOR", "BEGIN", "BLOCK", "BLOCK_DB", "BLOCK_FB", "BLOCK_FC", "CHAR", "CONTINUE"),
        *("COUNTER", "DATA_BLOCK", "DATE", "DT", "DTL", "END", "FAMILY", "GOTO"),
        *("KNOW_HOW_PROTECT", "LABEL", "LDT", "LTIME", "LTOD", "NAME", "NIL", "OK"),
        *("ORGANIZATION_BLOCK", "POINTER", "REF", "REF_TO", "REGION", "S5TIME", "TIMER"),
        *("TITLE", "TOD", "VARIANT", "VERSION", "VOID", "WCHAR", "WSTRING"),
    )
)


@dataclass(frozen=True)
class Names:
    """What the names of the sources mean, in upper case.

    Attributes:
        members: Members of enumerations: `#Name`, as variables are.
        defaults: Functions of the sources, `"Name"`, with what stands for each parameter that is
            left out, by upper-case name.
    """

    members: Collection[str]
    defaults: Mapping[str, Mapping[str, str]]


def scl_body(text: str, scope: Scope, names: Names) -> str:
    """Rewrite statements; comments and line breaks stay.

    `Name` becomes `#Name`, a function `"Name"`; arguments of functions and blocks are named, and
    left-out arguments of functions, for which SCL has no defaults, are written out.
    """
    return _Body(text, scope, names).all()


def quoted(name: str) -> str:
    """A name, in quotes if it is a word of SCL."""
    return f'"{name}"' if name.upper() in _RESERVED else name


class _Body(Body):
    def __init__(self, text: str, scope: Scope, names: Names) -> None:
        super().__init__(text, scope, words("scl"))
        self._names = names

    def _plain(self, text: str) -> str:
        return quoted(text)

    def _variable(self, at: int) -> str:
        return f"#{quoted(str(self._found[at]))}"

    def _word(self, at: int) -> str:
        token = self._found[at]
        if token.upper() in self._names.members:
            return f"#{quoted(str(token))}"
        return f'"{token}"' if token.upper() in self._names.defaults else str(token)

    def _own(self, at: int, given: list[tuple[str, int, int]], end: int) -> str:
        key = self._found[at].upper()
        defaults = self._names.defaults[key]
        return self._listed(at, given, end, self._scope.pins[key], named=True, defaults=defaults)
