"""Conditions in Structured Text over the variables of a running program.

A condition names variables by their paths: `NOT (Main.Gripper AND Main.State = CELL_MOVING)`.
The front end checks it. The built-in engine evaluates it, whatever engine runs the program.

Each path is replaced by a variable of a small generated program, one for each condition. To
evaluate the condition, the values are copied from the running program, and the generated program is
scanned once. The results are cached by the values.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path

from structured_text.engines.base import Program, Value
from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.dialects import IEC
from structured_text.language.source import in_dialect
from structured_text.language.types import ElementaryType, EnumType, Type

__all__ = ["Condition", "conditions"]

_TOKEN = re.compile(
    r"""'(?:\$.|[^'$])*'                                   # a text
    | "(?:\$.|[^"$])*"
    | \(\*.*?\*\)                                          # a comment
    | \w+\#[\w#.:+-]+                                      # a literal with its type
    | \d[\w.]*                                             # a number
    | (?P<before>\bBEFORE\s*\(\s*(?P<then>[^\W\d][\w.\[\], ]*?)\s*\))
    | (?P<path>[^\W\d]\w*(?:\s*\[[^\[\]]*\]|\.[^\W\d]\w*)*)""",
    re.VERBOSE | re.IGNORECASE | re.DOTALL,
)
_OURS = re.compile(r"\bHarness(?:Value|Before)(\d+)\b", re.IGNORECASE)
_REMEMBERED = 10_000


class Condition:
    """A condition on a running program; made by `conditions`.

    Attributes:
        text: The condition as the user wrote it.
        paths: The variables in the condition.
        has_before: Whether the condition contains a `BEFORE(...)`.
        before_paths: The variables inside `BEFORE(...)`, in their order.
        before: The values that `mark` saved for these variables; the attribute can be set.
    """

    def __init__(self, text: str, program: Program, evaluator: _Evaluator) -> None:
        paths, then = evaluator.paths, evaluator.then
        self.text = text
        self.paths = tuple(dict.fromkeys([*paths, *then]))
        self.before: tuple[Value, ...] = ()
        self.has_before = bool(then)
        self.before_paths = tuple(then)
        self._look, self._look_then = program.reader(paths), program.reader(then)
        self._evaluator = evaluator
        self._known: dict[tuple[Value, ...], bool] = {}
        self.mark()

    def mark(self) -> None:
        """Save the current values as the values of `BEFORE(...)`."""
        if self.has_before:
            self.before = self._look_then()

    def holds(self) -> bool:
        """Return whether the condition holds now.

        Raise InputError if the condition cannot be evaluated: a division by 0, or a number out of
        its range.
        """
        values = self._look() + self.before
        known = self._known.get(values)
        if known is None:
            known = self._evaluate(values)
            if len(self._known) < _REMEMBERED:
                self._known[values] = known
        return known

    def _evaluate(self, values: tuple[Value, ...]) -> bool:
        program = self._evaluator.program
        for name, value in zip(self._evaluator.names, values, strict=True):
            program.write(f"Main.{name}", value)
        try:
            program.scan(0)
        except InputError as error:
            raise InputError(f"{self.text}: {error.message}", hint=error.hint) from None
        return bool(program.read("Main.HarnessHolds"))

    def fixed(self, literals: Sequence[str]) -> str:
        """Return the text with literals for each `BEFORE(...)`, in the order of `before_paths`."""
        values = dict(zip(self.before_paths, literals, strict=True))
        return _TOKEN.sub(lambda one: values[one["then"]] if one["then"] else one[0], self.text)


def conditions(program: Program, texts: Sequence[str]) -> list[Condition]:
    """Check conditions and prepare them for evaluation.

    Raise InputError if a variable is unknown (the message suggests similar names), or the text is
    not an expression of type BOOL.

    Args:
        program: The program whose variables the conditions name.
        texts: Expressions of type BOOL: variables by path, literals, members of enumerations,
            operators and standard functions. `BEFORE(path)` is the value at the last call of
            `Condition.mark`.
    """
    return [Condition(text, program, _Evaluator(text, program)) for text in texts]


class _Evaluator:
    """The generated program of a condition.

    Attributes:
        paths: The variables that the condition names.
        then: The variables inside `BEFORE(...)`.
        names: The names of all these variables in the generated program.
        program: The generated program.
    """

    def __init__(self, text: str, running: Program) -> None:
        self.paths: list[str] = []
        self.then: list[str] = []
        self._running = running
        self._kinds: dict[str, Type] = {}
        try:
            if not text.strip():
                raise InputError(
                    "the condition is empty", hint='write it as "Main.State = CELL_READY"'
                )
            dialect = getattr(getattr(running, "project", None), "dialect", IEC)
            self.program = _compiled(_TOKEN.sub(self._replaced, text), self._kinds, dialect)
        except InputError as error:
            places = list(self._kinds)
            said = _OURS.sub(lambda one: places[int(one[1])], error.message)
            raise InputError(f"{text}: {said}", hint=error.hint) from None
        self.names = [self._name("Value", path) for path in self.paths]
        self.names += [self._name("Before", path) for path in self.then]

    def _name(self, kind: str, path: str) -> str:
        return f"Harness{kind}{list(self._kinds).index(path)}"

    def _replaced(self, one: re.Match[str]) -> str:
        """Return the name of a generated variable for a path; return any other token unchanged."""
        path = one["then"] or one["path"]
        if path is None or (not one["then"] and not _is_path(self._running, path)):
            return one[0]
        self._kinds.setdefault(path, _kind(self._running, path))
        found = self.then if one["then"] else self.paths
        if path not in found:
            found.append(path)
        return self._name("Before" if one["then"] else "Value", path)


def _is_path(program: Program, path: str) -> bool:
    """Return whether a name is a variable and not a word of the language.

    A name with members or indices is always taken as a variable. A bare name must be a global
    variable.
    """
    if "." in path or "[" in path:
        return True
    try:
        return isinstance(program.type_of(path), (ElementaryType, EnumType))
    except InputError:
        return False


def _kind(program: Program, path: str) -> Type:
    kind = program.type_of(path)
    if not isinstance(kind, (ElementaryType, EnumType)):
        raise InputError(f"{path} is not a single value", hint="name one of its members")
    return kind


def _compiled(body: str, kinds: dict[str, Type], dialect: str) -> BuiltinProgram:
    lines = [*_types(kinds), "PROGRAM HarnessConditions", "VAR", "HarnessHolds : BOOL;"]
    for number, kind in enumerate(kinds.values()):
        lines += [f"HarnessValue{number} : {kind.name};", f"HarnessBefore{number} : {kind.name};"]
    lines += ["END_VAR", f"HarnessHolds := ({body});", "END_PROGRAM", ""]
    return _built("\n".join(lines), dialect)


@lru_cache(maxsize=256)
def _built(text: str, dialect: str) -> BuiltinProgram:
    """Return the compiled program for a text.

    The program keeps no values between scans, so several conditions may share it.
    """
    # The import is here because few runs have conditions.
    from structured_text.language.load import load

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "conditions.st"
        file.write_text(text, encoding="utf-8")
        return BuiltinProgram.build(load([in_dialect(file, dialect)]))


def _types(kinds: dict[str, Type]) -> Iterator[str]:
    for kind in dict.fromkeys(one for one in kinds.values() if isinstance(one, EnumType)):
        values = kind.values or tuple(range(len(kind.members)))
        pairs = zip(kind.members, values, strict=True)
        base = "" if kind.base == "INT" else f" {kind.base}"
        members = ", ".join(f"{name} := {value}" for name, value in pairs)
        yield f"TYPE {kind.name} : ({members}){base}; END_TYPE"
