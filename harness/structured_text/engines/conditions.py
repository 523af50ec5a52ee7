"""Conditions in Structured Text over the variables of a running program, by their paths.

`NOT (Main.Gripper AND Main.State = CELL_MOVING)`: a path stands where a variable could. They are
checked by the front end and evaluated by the built-in engine, whatever engine runs the program.
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
from structured_text.language.types import ElementaryType, EnumType, Type

__all__ = ["Condition", "conditions"]

_TOKEN = re.compile(
    r"""'(?:\$.|[^'$])*'                                   # a text
    | "(?:\$.|[^"$])*"
    | \(\*.*?\*\)                                          # a comment
    | \w+\#[\w#.:+-]+                                      # a literal with its type
    | \d[\w.]*                                             # a number
    | (?P<before>\bBEFORE\s*\(\s*(?P<then>[A-Za-z_][\w.\[\], ]*?)\s*\))
    | (?P<path>[A-Za-z_]\w*(?:\s*\[[^\[\]]*\]|\.[A-Za-z_]\w*)*)""",
    re.VERBOSE | re.IGNORECASE | re.DOTALL,
)
_OURS = re.compile(r"\bHarness(?:Value|Before)(\d+)\b", re.IGNORECASE)
_REMEMBERED = 10_000


class Condition:
    """A condition on a running program.

    Attributes:
        text: As it was written.
        paths: The variables that it names.
    """

    def __init__(
        self, text: str, number: int, program: Program, paths: list[str], then: list[str]
    ) -> None:
        self.text = text
        self.paths = tuple(dict.fromkeys([*paths, *then]))
        self._number = number
        self._look, self._look_then = program.reader(paths), program.reader(then)
        self._names: list[str] = []
        self._evaluator: BuiltinProgram | None = None
        self._then: tuple[Value, ...] = ()
        self._known: dict[tuple[Value, ...], bool] = {}
        self.has_before = bool(then)
        """Does it name a `BEFORE(...)`?"""
        self._before_paths = then

    def evaluated_by(self, evaluator: BuiltinProgram, names: list[str]) -> None:
        """Which program evaluates it, and the names there of what it reads."""
        self._evaluator, self._names = evaluator, names
        self.mark()

    def mark(self) -> None:
        """From now on `BEFORE(x)` is the value that x has now."""
        if self.has_before:
            self._then = self._look_then()

    @property
    def before(self) -> tuple[Value, ...]:
        """What `mark` has noted; may be set to what it was."""
        return self._then

    @before.setter
    def before(self, then: tuple[Value, ...]) -> None:
        self._then = then

    def holds(self) -> bool:
        """Does it hold now?

        Raises:
            InputError: it cannot be evaluated: a division by 0, a number out of its range.
        """
        values = self._look() + self._then
        known = self._known.get(values)
        if known is None:
            known = self._evaluate(values)
            if len(self._known) < _REMEMBERED:
                self._known[values] = known
        return known

    def _evaluate(self, values: tuple[Value, ...]) -> bool:
        program = self._evaluator
        assert program is not None
        for name, value in zip(self._names, values, strict=True):
            program.write(f"Main.{name}", value)
        program.write("Main.HarnessWhich", self._number)
        try:
            program.scan(0)
        except InputError as error:
            raise InputError(f"{self.text}: {error.message}", hint=error.hint) from None
        return bool(program.read("Main.HarnessHolds"))

    def fixed(self, literals: Sequence[str]) -> str:
        """Its text with literals, in the order of `before_paths`, in place of `BEFORE(...)`."""
        values = dict(zip(self._before_paths, literals, strict=True))
        return _TOKEN.sub(lambda one: values[one["then"]] if one["then"] else one[0], self.text)

    @property
    def before_paths(self) -> tuple[str, ...]:
        """The variables of its `BEFORE(...)`, in their order."""
        return tuple(self._before_paths)


def conditions(program: Program, texts: Sequence[str]) -> list[Condition]:
    """Check conditions and make them ready.

    Args:
        program: The program that they are about.
        texts: Expressions of type BOOL: variables by path, literals, members of enumerations,
            operators and standard functions. `BEFORE(path)` is the value at `Condition.mark`.

    Raises:
        InputError: an unknown variable (with the names near it), or no such expression.
    """
    made: list[Condition] = []
    kinds: dict[str, Type] = {}
    bodies: list[str] = []
    names: list[list[str]] = []
    for number, text in enumerate(texts):
        try:
            body, paths, then = _with_names(text, program, kinds)
        except InputError as error:
            raise InputError(f"{text}: {error.message}", hint=error.hint) from None
        made.append(Condition(text, number, program, paths, then))
        places = list(kinds)
        names.append(
            [f"HarnessValue{places.index(path)}" for path in paths]
            + [f"HarnessBefore{places.index(path)}" for path in then]
        )
        bodies.append(body)
        _compiled([body], [number], kinds, text)  # each alone, so that an error is its own
    if made:
        evaluator = _compiled(bodies, range(len(bodies)), kinds, "")
        for one, own in zip(made, names, strict=True):
            one.evaluated_by(evaluator, own)
    return made


def _with_names(
    text: str, program: Program, kinds: dict[str, Type]
) -> tuple[str, list[str], list[str]]:
    """The expression with a variable of our own for each path; the paths, and those before."""
    paths: list[str] = []
    then: list[str] = []

    def put(one: re.Match[str]) -> str:
        if one["before"]:
            kinds.setdefault(one["then"], _kind(program, one["then"]))
            then.append(one["then"])
            return f"HarnessBefore{list(kinds).index(one['then'])}"
        path = one["path"]
        if path is None or not _is_path(program, path):
            return one[0]
        kinds.setdefault(path, _kind(program, path))
        if path not in paths:
            paths.append(path)
        return f"HarnessValue{list(kinds).index(path)}"

    if not text.strip():
        raise InputError("the condition is empty", hint='write it as "Main.State = CELL_READY"')
    return _TOKEN.sub(put, text), paths, list(dict.fromkeys(then))


def _is_path(program: Program, path: str) -> bool:
    """A name alone may be a global variable; all else that is a name is of the language."""
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


def _compiled(
    bodies: Sequence[str], numbers: Sequence[int], kinds: dict[str, Type], text: str
) -> BuiltinProgram:
    lines = [
        *_types(kinds),
        "PROGRAM HarnessConditions",
        "VAR",
        "HarnessWhich : INT;",
        "HarnessHolds : BOOL;",
    ]
    for number, kind in enumerate(kinds.values()):
        lines += [f"HarnessValue{number} : {kind.name};", f"HarnessBefore{number} : {kind.name};"]
    lines.append("END_VAR")
    for number, body in zip(numbers, bodies, strict=True):
        lines.append(f"IF HarnessWhich = {number} THEN HarnessHolds := ({body}); END_IF;")
    lines.append("END_PROGRAM")
    try:
        return _evaluator("\n".join(lines) + "\n")
    except InputError as error:
        places = list(kinds)
        said = _OURS.sub(lambda one: places[int(one[1])], error.message)
        raise InputError(f"{text}: {said}", hint=error.hint) from None


@lru_cache(maxsize=256)
def _evaluator(text: str) -> BuiltinProgram:
    """A program that has no memory: it may serve several conditions."""
    from structured_text.language.load import load  # few runs have conditions

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "conditions.st"
        file.write_text(text, encoding="utf-8")
        return BuiltinProgram.build(load([file]))


def _types(kinds: dict[str, Type]) -> Iterator[str]:
    for kind in dict.fromkeys(one for one in kinds.values() if isinstance(one, EnumType)):
        values = kind.values or tuple(range(len(kind.members)))
        pairs = zip(kind.members, values, strict=True)
        base = "" if kind.base == "INT" else f" {kind.base}"
        members = ", ".join(f"{name} := {value}" for name, value in pairs)
        yield f"TYPE {kind.name} : ({members}){base}; END_TYPE"
