"""Looks into the checked tree: all statements of a body, what they write, and how it reads."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, ElementaryType, EnumType

__all__ = ["calls_of", "constants", "root_of", "statements", "targets", "text_of", "written"]

#: Parts of a statement or expression without numbers of the program.
_NO_CODE = ("at", "type", "block", "symbol")


def statements(body: Iterable[t.Statement]) -> Iterator[t.Statement]:
    """All of them, those inside others too, in the order of the source."""
    for one in body:
        yield one
        if isinstance(one, (t.If, t.Case)):
            for _, inner in one.branches:
                yield from statements(inner)
            yield from statements(one.otherwise)
        elif isinstance(one, (t.For, t.While, t.Repeat)):
            yield from statements(one.body)


def calls_of(body: Iterable[t.Statement]) -> Iterator[t.CallBlock]:
    """The calls of blocks in a body."""
    return (one for one in statements(body) if isinstance(one, t.CallBlock))


def targets(one: t.Statement) -> Iterator[t.Variable]:
    """The variables that a statement itself may write."""
    if isinstance(one, t.Assign):
        yield one.target
    elif isinstance(one, t.For):
        yield one.counter
    elif isinstance(one, t.CallBlock):
        for _, variable in (*one.in_outs, *one.outputs):
            yield variable


def root_of(variable: t.Expression) -> t.Symbol | None:
    """The declared variable that an access begins with."""
    while isinstance(variable, (t.Member, t.Index)):
        variable = variable.base
    return variable.symbol if isinstance(variable, t.Use) else None


def written(pou: t.Pou) -> set[str]:
    """Names and addresses, in upper case, of the variables that a POU's body may write."""
    found = set()
    for one in statements(pou.body):
        for variable in targets(one):
            symbol = root_of(variable)
            if symbol is not None:
                found.add(symbol.name.upper())
                if symbol.address is not None:
                    found.add(symbol.address.upper())
    return found


def constants(project: Project, files: Container[str]) -> set[int]:
    """The whole numbers in the code of some files, bounds of arrays among them, and 1 less."""
    found = {0, 1}
    for pou in project.pous.values():
        if pou.file not in files:
            continue
        for symbol in pou.symbols.values():
            if isinstance(symbol.type, ArrayType):
                found.update(bound for pair in symbol.type.bounds for bound in pair)
            elif isinstance(symbol.initial, int):
                found.add(int(symbol.initial))
        waiting: list[Any] = [pou.body]
        while waiting:
            one = waiting.pop()
            if isinstance(one, t.Constant):
                if isinstance(one.value, int):
                    found.add(int(one.value))
            elif isinstance(one, tuple):
                waiting += one
            elif is_dataclass(one) and not isinstance(one, t.Symbol):
                inner = [part.name for part in fields(one) if part.name not in _NO_CODE]
                waiting += [getattr(one, name) for name in inner]
            elif isinstance(one, int):
                found.add(int(one))
    return found | {number - 1 for number in found}


def text_of(node: t.Expression) -> str:
    """An expression as Structured Text: literals without their types, a TIME in ms."""
    if isinstance(node, t.Constant):
        return _literal(node)
    if isinstance(node, t.Use):
        return node.symbol.name
    if isinstance(node, t.Member):
        return f"{text_of(node.base)}.{node.name}"
    if isinstance(node, t.Index):
        return f"{text_of(node.base)}[{', '.join(map(text_of, node.indices))}]"
    if isinstance(node, t.Unary):
        return f"{'-' if node.op == '-' else 'NOT '}{_operand(node.operand)}"
    if isinstance(node, t.Binary):
        return f"{_operand(node.left)} {node.op} {_operand(node.right)}"
    if isinstance(node, t.CallFunction):
        given = [text_of(one) for one in node.arguments if one is not None]
        return f"{node.function}({', '.join(given)})"
    assert isinstance(node, t.Standard)  # the others are refused by their names
    return f"{node.name}({', '.join(map(text_of, node.arguments))})"


def _operand(node: t.Expression) -> str:
    inside = isinstance(node, t.Binary) or (
        isinstance(node, t.Constant) and str(node.value)[0] == "-"
    )
    return f"({text_of(node)})" if inside else text_of(node)


def _literal(node: t.Constant) -> str:
    if isinstance(node.type, EnumType):
        return node.type.member_of(int(node.value)) or str(node.value)
    name = node.type.name if isinstance(node.type, ElementaryType) else ""
    if name == "TIME":
        return f"T#{int(node.value) / 1_000_000:g}ms"
    return str(node.value).upper() if name == "BOOL" else repr(node.value)
