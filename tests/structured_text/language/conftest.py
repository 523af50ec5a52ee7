"""Fixtures for tables of expressions: all expressions of a table run in one program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Evaluate = Callable[..., list[Any]]


@pytest.fixture
def evaluate(build: Callable[..., BuiltinProgram]) -> Evaluate:
    """Return a function that gives the values of expressions, each as a variable of its type.

    The function takes pairs of type and expression, and declarations of the variables used.
    """

    def values(rows: Sequence[tuple[str, str]], variables: str = "", before: str = "") -> list[Any]:
        declared = "".join(f"  Row{k} : {kind};\n" for k, (kind, _) in enumerate(rows))
        body = "".join(f"Row{k} := {code};\n" for k, (_, code) in enumerate(rows))
        text = f"{before}\nPROGRAM Rows\nVAR\n{variables}\n{declared}END_VAR\n{body}END_PROGRAM\n"
        program = build(text)
        program.scan(0)
        return [program.read(f"Main.Row{k}") for k in range(len(rows))]

    return values


@pytest.fixture
def errors_of(
    mistakes_of: Callable[..., list[InputError]],
) -> Callable[[str, str], list[InputError]]:
    """Return a function that lists all errors of a statement and of the variables it uses."""
    return lambda statement, variables: mistakes_of(
        f"PROGRAM Wrong\nVAR {variables} END_VAR\n{statement}\nEND_PROGRAM\n"
    )
