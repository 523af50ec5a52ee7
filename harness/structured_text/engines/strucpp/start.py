"""A check of the initial values of a program: STruC++ omits some of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from structured_text.engines.base import Value
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.language.tree import Symbol
from structured_text.language.types import ArrayType, BlockType, StructType, Type
from structured_text.language.values import nest, scalar_to_python

__all__ = ["check_start"]

_STORED = ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_GLOBAL")


def check_start(project: Project, read: Callable[[str], Value]) -> None:
    """Compare the first state of a program with its sources.

    `read` is `Program.read` before the first scan.

    Raises:
        InputError: A variable does not have its initial value; the error has the line of its
            declaration.
    """
    seen: set[str] = set()

    def check(symbols: Iterable[Symbol], prefix: str, file: str | None) -> None:
        for symbol in symbols:
            path = prefix + symbol.name
            if symbol.section not in _STORED:
                continue
            if isinstance(symbol.type, BlockType):
                check_block(symbol.type, path)
            elif symbol.initial is not None and read(path) != _shown(symbol.type, symbol.initial):
                raise InputError(
                    f"STruC++ does not start {path} with its initial value",
                    file=file,
                    line=symbol.at.line,
                    hint="assign it in the first scan, or use --engine builtin",
                )

    def check_block(block: BlockType, path: str) -> None:
        """Check one instance of each block: all instances start alike."""
        pou = project.pous.get(block.name.upper())
        if pou is not None and pou.name not in seen:
            seen.add(pou.name)
            check(pou.symbols.values(), f"{path}.", pou.file)

    check(project.global_symbols.values(), "", None)
    for name, block in project.instances.items():
        check_block(block, name)


def _shown(kind: Type, initial: Any) -> Value:
    """Return an initial value in the form of `Program.read`."""
    if isinstance(kind, StructType):
        return {name: _shown(field, initial[name]) for name, field in kind.fields}
    if isinstance(kind, ArrayType):
        return nest(kind, [_shown(kind.element, item) for item in initial])
    return scalar_to_python(kind, initial)
