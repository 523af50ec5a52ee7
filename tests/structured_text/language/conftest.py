"""Runs rows of tables: expressions with their types and values, in one program each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import check, load

Evaluate = Callable[..., list[Any]]


@pytest.fixture
def evaluate(tmp_path: Path) -> Evaluate:
    """Gives the values of expressions, each assigned to a variable of its type.

    Takes pairs of type and expression, and declarations of the variables they use.
    """

    def values(rows: Sequence[tuple[str, str]], variables: str = "", before: str = "") -> list[Any]:
        declared = "".join(f"  Row{k} : {kind};\n" for k, (kind, _) in enumerate(rows))
        body = "".join(f"Row{k} := {code};\n" for k, (_, code) in enumerate(rows))
        file = tmp_path / "rows.st"
        text = f"{before}\nPROGRAM Rows\nVAR\n{variables}\n{declared}END_VAR\n{body}END_PROGRAM\n"
        file.write_text(text, encoding="utf-8")
        program = BuiltinProgram.build(load([file]))
        program.scan(0)
        return [program.read(f"Main.Row{k}") for k in range(len(rows))]

    return values


@pytest.fixture
def errors_of(tmp_path: Path) -> Callable[..., list[InputError]]:
    """Everything that is wrong with a source, or with a statement and the variables it uses."""

    def errors(source: str, variables: str | None = None) -> list[InputError]:
        file = tmp_path / "wrong.st"
        if variables is not None:
            source = f"PROGRAM Wrong\nVAR {variables} END_VAR\n{source}\nEND_PROGRAM\n"
        file.write_text(source, encoding="utf-8")
        return check([file])

    return errors


@pytest.fixture
def build(tmp_path: Path) -> Callable[[str], BuiltinProgram]:
    """Compiles a whole source."""

    def compile_source(source: str) -> BuiltinProgram:
        file = tmp_path / "program.st"
        file.write_text(source, encoding="utf-8")
        return BuiltinProgram.build(load([file]))

    return compile_source


@pytest.fixture
def mistakes_of(tmp_path: Path) -> Callable[[str], list[InputError]]:
    """Everything the front end finds wrong with a whole source."""

    def find(source: str) -> list[InputError]:
        file = tmp_path / "program.st"
        file.write_text(source, encoding="utf-8")
        return check([file])

    return find
