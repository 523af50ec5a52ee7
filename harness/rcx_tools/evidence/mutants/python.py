"""Mutation operators for Python: small mistakes that people make, in each function and table.

Cosmic Ray and mutmut also have operators. However, these tools do not delete statements, do not
replace an attribute by a similar attribute, do not save outcomes, and do not support tables. The
module `ast` is sufficient for all of this.
"""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TypeVar

from rcx_tools.evidence.mutants.sample import Change
from structured_text.mutants.text import Edit, Span

__all__ = [
    "PYTHON_OPERATORS",
    "concerned",
    "file_key",
    "function_at",
    "functions",
    "python_changes",
    "python_meaning",
]

PYTHON_OPERATORS = (
    *("relational", "boolean", "operand", "negation", "condition", "arithmetic", "off-by-one"),
    *("mask", "constant", "swapped", "neighbour", "dropped statement", "dropped exit"),
)

_Op = TypeVar("_Op")


def _both(one: _Op, other: _Op) -> list[tuple[_Op, _Op]]:
    """Return the exchange of two operators in both directions."""
    return [(one, other), (other, one)]


_RELATIONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    **dict(_both(ast.Lt, ast.LtE)),
    **dict(_both(ast.Gt, ast.GtE)),
    **dict(_both(ast.Eq, ast.NotEq)),
    **dict(_both(ast.In, ast.NotIn)),
    **dict(_both(ast.Is, ast.IsNot)),
}
_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    **dict(_both(ast.Add, ast.Sub)),
    **dict(_both(ast.Mult, ast.FloorDiv)),
    **dict(_both(ast.LShift, ast.RShift)),
    **dict(_both(ast.BitAnd, ast.BitOr)),
    ast.Div: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.BitXor: ast.BitOr,
}
_PAIRS = {"min": "max", "max": "min", "any": "all", "all": "any"}
_SIGNAL = re.compile(r"S[IO]\d\d")
#: Methods with results for people only, and classes of errors. Changes in these have no effect on
#: the behaviour.
_SPOKEN = ("__repr__", "__str__")
_ERRORS = ("InputError", "LiteralError", "ProgramError")


def functions(text: str) -> dict[int, str]:
    """Return the qualified names of the functions, by their first line (including decorators)."""
    return {
        min([node.lineno, *(one.lineno for one in node.decorator_list)]): name
        for name, node in _functions(ast.parse(text), "")
    }


def concerned(pou: str, line: int, texts: Mapping[str, str]) -> frozenset[str]:
    """Return the functions that a change at this line may affect, in upper case.

    A change in a function affects that function. A change of a named value affects the functions
    that use the value, also in other modules. If no function uses it, the whole module is affected.

    Args:
        pou: Name of the function, `robot/handshake.py:_check`; for a value, the module.
        line: Line of the change in the module.
        texts: The modules of the package, by `file_key`.
    """
    names = _named(texts[pou], line) if pou in texts else frozenset[str]()
    using = [
        f"{key}:{function}"
        for key, text in texts.items()
        if any(name in text for name in names)
        for function, used in _uses(text).items()
        if names & used
    ]
    return frozenset(name.upper() for name in using or [pou])


def _named(text: str, line: int) -> frozenset[str]:
    """Return the names to which this line assigns a value."""
    targets = [
        target
        for node in ast.walk(ast.parse(text))
        if isinstance(node, (ast.Assign, ast.AnnAssign))
        and node.lineno <= line <= (node.end_lineno or node.lineno)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
    ]
    return frozenset(one.id for at in targets for one in ast.walk(at) if isinstance(one, ast.Name))


@cache
def _uses(text: str) -> dict[str, frozenset[str]]:
    """Return the names and attributes that each function of a module uses."""
    return {
        name: frozenset(
            one.id if isinstance(one, ast.Name) else one.attr
            for one in ast.walk(node)
            if isinstance(one, (ast.Name, ast.Attribute))
        )
        for name, node in _functions(ast.parse(text), "")
    }


def _functions(node: ast.AST, prefix: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield the functions of a module with their qualified names."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.FunctionDef, ast.ClassDef)):
            name = f"{prefix}{child.name}"
            if not isinstance(child, ast.ClassDef):
                yield name, child
            yield from _functions(child, f"{name}.")
        else:
            yield from _functions(child, prefix)


def python_changes(text: str, path: str) -> list[Change]:
    """Return all changes of a module; `path` is its path in the repository."""
    return list(_Finder(text, file_key(path)).changes())


def python_meaning(text: str) -> str:
    """Return a text that is equal for modules with the same syntax tree.

    Raises:
        SyntaxError: the text is not correct Python.
    """
    return ast.dump(ast.parse(text))


def function_at(text: str, offset: int, path: str) -> str:
    """Return the outermost function at an offset, in the form of mutants.

    Outside of functions, return the module.
    """
    line = text.count("\n", 0, offset) + 1
    key = file_key(path)

    def inside(node: ast.AST, prefix: str) -> str:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, (ast.FunctionDef, ast.ClassDef)):
                first = min([child.lineno, *(one.lineno for one in child.decorator_list)])
                if first <= line <= (child.end_lineno or first):
                    name = f"{prefix}{child.name}"
                    if isinstance(child, ast.FunctionDef):
                        return f"{key}:{name}"
                    return inside(child, f"{name}.")
        return key

    return inside(ast.parse(text), "")


def file_key(path: str) -> str:
    """Return the name of a module in reports: `robot/handshake.py`."""
    return path.removeprefix("harness/rcx_harness/").removeprefix("harness/structured_text/")


class _Finder:
    """Search for all positions in a module at which a mistake is possible."""

    def __init__(self, text: str, key: str) -> None:
        self._text = text
        self._key = key
        self._tree = ast.parse(text)
        self._starts = [0]
        for line in text.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))
        self._lines = text.splitlines()
        self._siblings = self._attributes()
        self._signals = sorted(set(_SIGNAL.findall(text)))

    def changes(self) -> Iterator[Change]:
        """Yield every possible change of the module, in the order of the text."""
        yield from self._inside(self._tree, "", "")

    # --- tree ---

    def _inside(self, node: ast.AST, name: str, function: str) -> Iterator[Change]:
        pou = f"{self._key}:{function}" if function else self._key
        for child in _parts(node):
            if isinstance(child, (ast.FunctionDef, ast.ClassDef)):
                inner = f"{name}.{child.name}" if name else child.name
                if child.name not in _SPOKEN:
                    own = function or ("" if isinstance(child, ast.ClassDef) else inner)
                    yield from self._inside(child, inner, own)
                continue
            if isinstance(child, ast.stmt):
                building = function.endswith(("__init__", "__post_init__"))
                yield from self._statement(child, pou, building, isinstance(node, ast.If))
            if isinstance(child, ast.expr):
                yield from self._expression(child, pou)
            yield from self._inside(child, name, function)

    def _statement(
        self, node: ast.stmt, pou: str, building: bool, branch: bool
    ) -> Iterator[Change]:
        if isinstance(node, (ast.If, ast.While)):
            yield self._made("condition", pou, node.test, ast.UnaryOp(ast.Not(), node.test))
        elif isinstance(node, ast.AugAssign) and type(node.op) in _ARITHMETIC:
            yield self._made("arithmetic", pou, node, _with(node, op=_ARITHMETIC[type(node.op)]()))
        if pou == self._key:
            return
        if _leaves(node) and branch:
            yield self._made("dropped exit", pou, node, ast.Pass())
        elif _acts(node) and not building:
            yield self._made("dropped statement", pou, node, ast.Pass())

    def _expression(self, node: ast.expr, pou: str) -> Iterator[Change]:
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            other = _RELATIONS[type(node.ops[0])]
            yield self._made("relational", pou, node, _with(node, ops=[other()]))
        elif isinstance(node, ast.Compare):
            ops = [_RELATIONS[type(node.ops[0])](), *node.ops[1:]]
            yield self._made("relational", pou, node, _with(node, ops=ops))
        elif isinstance(node, ast.BoolOp):
            other_op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
            yield self._made("boolean", pou, node, _with(node, op=other_op))
            for index in range(len(node.values)):
                rest = [*node.values[:index], *node.values[index + 1 :]]
                left = rest[0] if len(rest) == 1 else _with(node, values=rest)
                yield self._made("operand", pou, node, left)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            yield self._made("negation", pou, node, node.operand)
        elif isinstance(node, ast.IfExp):
            swapped = _with(node, body=node.orelse, orelse=node.body)
            yield self._made("swapped", pou, node, swapped)
        elif isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC and not _is_text(node):
            other_one = _ARITHMETIC[type(node.op)]()
            yield self._made("arithmetic", pou, node, _with(node, op=other_one))
        elif isinstance(node, ast.Constant):
            yield from self._constant(node, pou)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id in _PAIRS:
                yield self._made("swapped", pou, node.func, ast.Name(_PAIRS[node.func.id]))
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
            key = _family(node)
            if key in self._siblings and len(self._siblings[key]) > 1:
                names = self._siblings[key]
                other_name = names[(names.index(node.attr) + 1) % len(names)]
                yield self._made("neighbour", pou, node, _with(node, attr=other_name))

    def _constant(self, node: ast.Constant, pou: str) -> Iterator[Change]:
        value = node.value
        if isinstance(value, bool):
            yield self._made("constant", pou, node, ast.Constant(not value))
        elif isinstance(value, int):
            if self._text[self._span(node).start :].startswith("0x") and value:
                edit = Edit(self._span(node), f"0x{value << 1:04X}")
                yield Change("mask", pou, (edit,))
            else:
                yield self._made("off-by-one", pou, node, ast.Constant(value + 1))
                if value > 1:
                    yield self._made("off-by-one", pou, node, ast.Constant(value - 1))
        elif isinstance(value, float):
            yield self._made("constant", pou, node, ast.Constant(2 * value or 1.0))
        elif isinstance(value, str) and value in self._signals and len(self._signals) > 1:
            place = self._signals.index(value) + 1
            other = self._signals[place % len(self._signals)]
            yield self._made("neighbour", pou, node, ast.Constant(other))

    # --- text ---

    def _made(self, operator: str, pou: str, node: ast.expr | ast.stmt, by: ast.AST) -> Change:
        text = ast.unparse(by)
        if isinstance(by, (ast.BoolOp, ast.Compare, ast.BinOp, ast.UnaryOp, ast.IfExp)):
            text = f"({text})"
        return Change(operator, pou, (Edit(self._span(node), text),))

    def _span(self, node: ast.expr | ast.stmt) -> Span:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        start = self._offset(node.lineno, node.col_offset)
        return Span(start, self._offset(node.end_lineno, node.end_col_offset))

    def _offset(self, line: int, column: int) -> int:
        """Return the offset of a position. Columns count the bytes of UTF-8."""
        before = self._lines[line - 1].encode()[:column].decode()
        return self._starts[line - 1] + len(before)

    def _attributes(self) -> dict[str, list[str]]:
        """Return groups of attributes that a programmer may confuse, by family."""
        found: dict[str, set[str]] = {}
        for node in ast.walk(self._tree):
            if isinstance(node, ast.Attribute) and (key := _family(node)):
                found.setdefault(key, set()).add(node.attr)
        return {key: sorted(names) for key, names in found.items()}


def _family(node: ast.Attribute) -> str:
    """Return the family of an attribute, or "".

    The family is `Phase` for a member of that enumeration, and `config...alarm` for attributes of
    `config` whose names have the same last word.
    """
    base = ast.unparse(node.value)
    if isinstance(node.value, ast.Name) and base[0].isupper():
        return base
    if base.endswith("config") and "_" in node.attr:
        return f"{base}...{node.attr.rpartition('_')[2]}"
    return ""


def _parts(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the parts of a node that have an effect.

    Types, decorators, texts and export lists have none.
    """
    if isinstance(node, (ast.JoinedStr, ast.Assert, ast.Import, ast.ImportFrom)):
        return
    if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in _ERRORS:
        return
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases"):
            continue
        if isinstance(node, ast.keyword) and node.arg == "strict":
            continue
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, ast.AST) and not _is_spoken(one):
                yield one


def _is_spoken(node: ast.AST) -> bool:
    """Return whether a statement is a docstring, `__all__`, or code for type checkers only."""
    if isinstance(node, ast.Assign):
        return ast.unparse(node.targets[0]) == "__all__"
    if isinstance(node, ast.If):
        return ast.unparse(node.test) == "TYPE_CHECKING"
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _acts(node: ast.stmt) -> bool:
    """Return whether a statement changes something that still exists after the function."""
    if isinstance(node, ast.Assign):
        return isinstance(node.targets[0], (ast.Attribute, ast.Subscript))
    if isinstance(node, ast.AugAssign):
        return True
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Call) and "super()" not in ast.unparse(node)
    return isinstance(node, ast.Delete)


def _leaves(node: ast.stmt) -> bool:
    return isinstance(node, (ast.Return, ast.Continue, ast.Break, ast.Raise))


def _is_text(node: ast.BinOp) -> bool:
    return any(
        isinstance(side, ast.JoinedStr)
        or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in (node.left, node.right)
    )


def _with(node: ast.AST, **changes: object) -> ast.AST:
    changed = copy.copy(node)
    for name, value in changes.items():
        setattr(changed, name, value)
    return changed
