"""Conditional compilation: the pragmas {IF}, {ELSIF}, {ELSE}, {END_IF}, {define} and {undefine}.

For each of these pragmas, `Conditions` returns the offset at which the lexer continues. A name is
defined from its `{define Name}` to the end of the file. Conditions on declarations, such as
`defined (variable: x)`, are not supported, because the declarations are not read yet.

Source: help of CODESYS and TwinCAT, conditional pragmas.
"""

from __future__ import annotations

import re
from collections.abc import Callable

__all__ = ["PRAGMA", "ConditionError", "Conditions"]

#: The content of a pragma of conditional compilation: its word, and the rest.
PRAGMA = re.compile(r"(IF|ELSIF|ELSE|END_IF|DEFINE|UNDEFINE)\b\s*(.*)", re.IGNORECASE | re.DOTALL)
#: Matches a comment or a string literal, which is skipped, or a pragma.
_PART = re.compile(
    r"\(\*.*?\*\)|//[^\n]*|/\*.*?\*/|'(?:\$.|[^$'\n])*'|\"(?:\$.|[^$\"\n])*\"|\{([^}]*)\}",
    re.DOTALL,
)
_TOKEN = re.compile(r"\s*('(?:[^'])*'|\w+|[(),:]|\S)")
_DEFINITION = re.compile(r"(\w+)(?:\s+'?([^']*)'?)?\s*")


class ConditionError(Exception):
    """The error for a condition that cannot be evaluated. The hint says what to write instead."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


class Conditions:
    """The definitions and open conditions at the current position in a source.

    Args:
        note: A function that is called with each undefined name that a condition depends on.
    """

    def __init__(self, note: Callable[[str], None]) -> None:
        self._note = note
        self._defined: dict[str, str] = {}
        # Offset of each open {IF}, and whether one of its branches has been taken.
        self._open: list[tuple[int, bool]] = []

    @property
    def unclosed(self) -> int | None:
        """Return the offset of the last {IF} without {END_IF}; None if there is none."""
        return self._open[-1][0] if self._open else None

    def behind(self, word: str, rest: str, offset: int, end: int, text: str) -> int:
        """Return the offset where the text continues behind a pragma from `offset` to `end`.

        Raises:
            ConditionError: The pragma has no {IF}, or its condition cannot be evaluated.
        """
        word = word.upper()
        if word in ("DEFINE", "UNDEFINE"):
            self._define(word, rest)
            return end
        if word == "IF":
            # The entry is added first. If the condition cannot be evaluated, {END_IF} still finds
            # its {IF}.
            self._open.append((offset, True))
            if self._is_true(rest):
                return end
            self._open[-1] = (offset, False)
            return self._skipped(end, text)
        if not self._open:
            raise ConditionError(f"{{{word}}} without {{IF}}", "remove it")
        if word == "END_IF":
            self._open.pop()
            return end
        # An {ELSIF} or {ELSE} follows a branch that has been read: the text up to {END_IF} is
        # skipped.
        return self._skipped(end, text)

    def _define(self, word: str, rest: str) -> None:
        found = _DEFINITION.fullmatch(rest)
        if found is None:
            raise ConditionError(f"{{{word.lower()}}} needs a name", "write {define Name}")
        if word == "DEFINE":
            self._defined[found[1].upper()] = found[2] or ""
        else:
            self._defined.pop(found[1].upper(), None)

    def _skipped(self, at: int, text: str) -> int:
        """Return the offset behind the next pragma with a true condition, or behind {END_IF}."""
        depth = 0
        for part in _PART.finditer(text, at):
            pragma = PRAGMA.fullmatch(part[1].strip()) if part[1] is not None else None
            if pragma is None:
                continue
            word = pragma[1].upper()
            if word == "IF":
                depth += 1
            elif word == "END_IF" and depth:
                depth -= 1
            elif not depth and word == "END_IF":
                self._open.pop()
                return part.end()
            elif not depth and word in ("ELSIF", "ELSE"):
                start, taken = self._open[-1]
                if not taken and (word == "ELSE" or self._is_true(pragma[2])):
                    self._open[-1] = (start, True)
                    return part.end()
        return len(text)

    def _is_true(self, text: str) -> bool:
        tokens = [found[1] for found in _TOKEN.finditer(text.strip())]
        reader = _Reader(tokens, self._defined)
        value = reader.expression()
        if reader.tokens:
            raise ConditionError(f"{reader.tokens[0]!r} is not expected in this condition")
        for name in dict.fromkeys(reader.missing):
            self._note(f"{name} is not defined")
        return value


class _Reader:
    """A recursive reader of a condition; `missing` collects names that are not defined."""

    def __init__(self, tokens: list[str], defined: dict[str, str]) -> None:
        self.tokens = tokens
        self._defined = defined
        self.missing: list[str] = []

    def expression(self) -> bool:
        """Read operands joined by OR."""
        value = self._all()
        while self._takes("OR"):
            value = self._all() or value
        return value

    def _all(self) -> bool:
        value = self._operand()
        while self._takes("AND"):
            value = self._operand() and value
        return value

    def _operand(self) -> bool:
        if self._takes("NOT"):
            return not self._operand()
        if self._takes("("):
            value = self.expression()
            self._expect(")")
            return value
        word = self._next().upper()
        if word in ("TRUE", "FALSE") or word.isdecimal():
            return word not in ("FALSE", "0")
        self._expect("(")
        name = self._next()
        if self.tokens[:1] == [":"] or word not in ("DEFINED", "PROJECT_DEFINED", "HASVALUE"):
            what = f"{word.lower()} ({name}: …)" if self.tokens[:1] == [":"] else word.lower()
            hint = "leave one of the branches"
            raise ConditionError(f"the condition {what} is not supported", hint)
        found = self._defined.get(name.upper()) if word != "PROJECT_DEFINED" else None
        if found is None:
            self.missing.append(name)
        if word != "HASVALUE":
            self._expect(")")
            return found is not None
        self._expect(",")
        wanted = self._next().strip("'")
        self._expect(")")
        return found == wanted

    def _takes(self, word: str) -> bool:
        if self.tokens and self.tokens[0].upper() == word:
            self.tokens.pop(0)
            return True
        return False

    def _next(self) -> str:
        if not self.tokens:
            raise ConditionError("this condition ends in the middle", "write {IF defined (Name)}")
        return self.tokens.pop(0)

    def _expect(self, sign: str) -> None:
        if not self._takes(sign):
            there = repr(self.tokens[0]) if self.tokens else "the end"
            raise ConditionError(f"{sign!r} is expected in this condition, not {there}")
