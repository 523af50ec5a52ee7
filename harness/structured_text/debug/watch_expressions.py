"""Expressions in Structured Text that a user types: checked as in a POU, and evaluated there.

The front end of the engine checks names and types, and its generator writes the Python. The running
program is not changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from structured_text.engines.builtin.expression_code import ExpressionCode as Python
from structured_text.engines.builtin.runtime import ProgramError
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.declare import Declarations, Scope
from structured_text.language.dialects import rules_of
from structured_text.language.expression_checker import ExpressionChecker as Checker
from structured_text.language.load import read_file
from structured_text.language.parser import read_text
from structured_text.language.project import Project
from structured_text.language.registry import Declared, Registry
from structured_text.language.scalars import BOOL
from structured_text.language.types import Type
from structured_text.language.walk import nodes

__all__ = ["Compiled", "WatchExpressions"]

_HERE = Path("expression")
_HEAD = "FUNCTION HarnessHere : BOOL\n"
_FAULTS = (ArithmeticError, ValueError, ProgramError, RecursionError, TypeError, AttributeError)


@dataclass(frozen=True)
class Compiled:
    """An expression, compiled for a POU.

    Attributes:
        text: The expression as typed.
        node: Its checked syntax tree.
        names: The Python variables that it needs.
        run: The compiled function of these variables.
    """

    text: str
    node: t.Expression
    type: Type
    names: tuple[str, ...]
    run: Callable[..., Any]

    def value(self, variables: Mapping[str, Any]) -> Any:
        """Evaluate the expression; the result has the engine's representation.

        The variables have their Python names: `s` is the instance, `g` the globals, and local
        variables are in upper case.

        Raises:
            InputError: The expression cannot be evaluated, for example because of a division by
                zero or an index out of range.
        """
        try:
            return self.run(*(variables.get(name) for name in self.names))
        except _FAULTS as error:
            said = (
                str(error)
                if isinstance(error, ProgramError)
                else "the expression has no value here"
            )
            if isinstance(error, ZeroDivisionError):
                said = "division by zero"
            raise InputError(f"{self.text}: {said}") from None


class WatchExpressions:
    """A compiler for expressions in the scope of any POU of a program."""

    def __init__(self, project: Project, names: Mapping[str, Any]) -> None:
        self._project, self._names = project, dict(names)
        self._known: dict[tuple[str, str, str], Compiled] = {}
        self._scopes: dict[str, Scope] | None = None

    def compiled(self, pou: t.Pou, text: str, want: Type | None = None) -> Compiled:
        """Compile an expression in the scope of a POU, or raise InputError."""
        key = pou.name.upper(), text, want.name if want is not None else ""
        if key not in self._known:
            self._known[key] = self._made(pou, text, want)
        return self._known[key]

    def condition(self, pou: t.Pou, text: str) -> Compiled:
        """Compile an expression of type BOOL in the scope of a POU."""
        return self.compiled(pou, text, BOOL)

    def names(self, pou: t.Pou) -> list[str]:
        """Return the names of variables that an expression may use in a POU."""
        symbols = [one.name for one in pou.symbols.values() if not one.name.startswith(" ")]
        owner = [one.name for one in pou.owner.symbols.values()] if pou.owner is not None else []
        shared = [one.name for one in self._project.global_symbols.values()]
        return sorted({*symbols, *owner, *shared} - {""}, key=str.upper)

    def _made(self, pou: t.Pou, text: str, want: Type | None) -> Compiled:
        scope = self._scope(pou)
        checker = Checker(scope)
        found = syntax_of(text)
        try:
            node = checker.check(found, want)
        except InputError as error:
            raise InputError(f"{text}: {error.message}", hint=error.hint) from None
        if any(isinstance(one, t.Assigned) for one in nodes(node)):
            hint = "set the variable with the command for that"
            raise InputError(f"{text}: an expression does not assign here", hint=hint)
        if any(isinstance(one, t.CallMethod) for one in nodes(node)):
            hint = "methods may change the program; look at the variables instead"
            raise InputError(f"{text}: a watch expression cannot call a method", hint=hint)
        return self._written(scope, node, text)

    def of_node(self, pou: t.Pou, node: t.Expression, text: str) -> Compiled:
        """Compile a part of an expression that is already checked."""
        return self._written(self._scope(pou), node, text)

    def _written(self, scope: Scope, node: t.Expression, text: str) -> Compiled:
        writer = Python(self._project, scope.pou)
        code = writer.exact(node)
        local = {one.name.upper() for one in scope.pou.symbols.values() if writer.is_local(one)}
        if scope.pou.result is not None:
            local.add(scope.pou.result.name.upper())
        names = ("s", "g", *sorted(name for name in local if name.isidentifier()))
        lines = [f"def here({', '.join(names)}):"]
        lines += [f"    def {name}(): return {part}" for name, part in writer.parts]
        module: dict[str, Any] = dict(self._names)
        exec("\n".join([*lines, f"    return {code}"]), module)
        return Compiled(text, node, node.type, names, module["here"])

    def _scope(self, pou: t.Pou) -> Scope:
        if self._scopes is None:
            self._scopes = _scopes(self._project)
        return self._scopes[pou.name.upper()]


@lru_cache(maxsize=256)
def syntax_of(text: str) -> s.Expression:
    """Parse an expression, or raise InputError."""
    wrong = InputError(
        f"{text!r} is not an expression of Structured Text", hint="write it as Count + 1 > 3"
    )
    source = read_text(f"{_HEAD}HarnessHere := (\n{text}\n);\nEND_FUNCTION\n", _HERE)
    if source.errors:
        raise InputError(f"{text}: {source.errors[0].message}", hint=source.errors[0].hint)
    first = source.declarations[0] if len(source.declarations) == 1 else None
    body = first.body if isinstance(first, s.Pou) else ()
    if len(body) != 1 or not isinstance(body[0], s.Assign):
        raise wrong
    return body[0].value


def _scopes(project: Project) -> dict[str, Scope]:
    """Return the scope of each POU.

    The scopes are built again, because the front end has discarded the scopes of its check.
    """
    sources = [read_file(file) for file in project.files]
    registry = Registry(sources, lambda _: None, rules_of(project.dialect))
    declarations = Declarations(registry, lambda _: None)
    for declared in registry.ordered():
        if isinstance(declared.node, s.Interface):
            declarations.inheritance.add(declared.node, declared)
    for declared in registry.ordered():
        if isinstance(declared.node, s.TypeDecl):
            declarations.add_type(declared.node, declared)
        elif isinstance(declared.node, s.Pou):
            declarations.add_pou(declared.node, declared)
    declarations.add_globals()
    declarations.inheritance.finish()
    where: dict[str, Declared] = {
        one.node.name.key: one for one in registry.ordered() if isinstance(one.node, s.Pou)
    }
    scopes: dict[str, Scope] = {}
    for key, declared in where.items():
        scopes[key] = Scope(declarations.pous[key], declared, registry, declarations)
    for method, _, declared in declarations.inheritance.bodies():
        scopes[method.name.upper()] = Scope(method, declared, registry, declarations)
    for key, scope in scopes.items():
        known = project.pous.get(key)
        for name, symbol in scope.pou.symbols.items():
            same = known.symbols.get(name) if known is not None else None
            if same is not None:  # only the check of bodies sets these attributes
                symbol.addressed, symbol.shared = same.addressed, same.shared
    return {key: replace(scope) for key, scope in scopes.items() if key in project.pous}
