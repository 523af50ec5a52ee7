"""Every row of `standard_table` is true on both engines: each standard function at its limits.

Each row runs twice: with literals and with variables as arguments.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from for_each import for_each
from standard_rows import Row
from standard_table import TABLE
from structured_text.engines.base import Program
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.language.load import load

_BY_NAME = ("BOOL", "STRING")


def _literal(argument: str) -> str:
    kind, _, value = argument.partition(" ")
    return value if kind in _BY_NAME else f"{kind}#{value}"


def _initial(argument: str) -> str:
    """Return the initial value of a variable: untyped, except for durations and dates."""
    kind, _, value = argument.partition(" ")
    return f"{kind}#{value}" if kind in ("TIME", "DATE", "TOD", "DT") else value


def _source(table: list[Row], *, constants: bool) -> str:
    declared, body = [], []
    for number, row in enumerate(table):
        declared.append(f"  R{number} : {row.kind};")
        names = []
        for place, argument in enumerate(row.arguments):
            name = f"A{number}I{place}"
            declared.append(f"  {name} : {argument.partition(' ')[0]} := {_initial(argument)};")
            names.append(_literal(argument) if constants else name)
        body.append(f"  R{number} := {row.code.format(*names)};")
    return "\n".join(["PROGRAM P1", "VAR", *declared, "END_VAR", *body, "END_PROGRAM", ""])


def _run(
    source: str, folder: Path, matiec: Matiec | None = None, compiler: str | None = None
) -> Program:
    file = folder / "table.st"
    file.write_text(source, encoding="utf-8")
    program: Program
    if matiec is None:
        program = BuiltinProgram.build(load([file]))
    else:
        assert compiler is not None
        program = MatiecProgram.build(load([file]), matiec, compiler)
    program.scan(0)
    return program


@pytest.fixture(scope="module")
def with_variables(tmp_path_factory: pytest.TempPathFactory) -> Program:
    return _run(_source(TABLE, constants=False), tmp_path_factory.mktemp("variables"))


@pytest.fixture(scope="module")
def with_literals(tmp_path_factory: pytest.TempPathFactory) -> Program:
    return _run(_source(TABLE, constants=True), tmp_path_factory.mktemp("literals"))


def _named(row: Row) -> str:
    given = [
        argument if len(argument) < 40 else f"{argument[:20]}..." for argument in row.arguments
    ]
    return row.code.format(*given)


def _same(got: Any, expected: Any) -> bool:
    return type(got) is type(expected) and got == expected


@for_each("number, row", enumerate(TABLE))
def test_a_function_gives_what_the_standard_says_of_variables_and_of_literals(
    with_variables: Program, with_literals: Program, number: int, row: Row
) -> None:
    for program in (with_variables, with_literals):
        got = program.read(f"Main.R{number}")
        assert _same(got, row.value), f"{_named(row)}: {got!r}, expected {row.value!r}"


def test_matiec_agrees_where_it_keeps_to_the_standard(matiec: Matiec, tmp_path: Path) -> None:
    table = [row for row in TABLE if row.alike]
    program = _run(_source(table, constants=False), tmp_path, matiec, find_c_compiler())
    found = {
        _named(row): (got, row.value)
        for number, row in enumerate(table)
        if not _same(got := program.read(f"Main.R{number}"), row.value)
    }
    program.close()
    assert not found, "\n".join(
        f"{name}: {got!r}, expected {value!r}" for name, (got, value) in found.items()
    )


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("R := MUX(K, 1, 2);", "MUX selects input -1, but has inputs 0 to 1"),
        ("R := MUX(K + 3, 1, 2);", "MUX selects input 2, but has inputs 0 to 1"),
        ("R := R / (K + 1);", "division by zero"),
        ("R := DIV(R, K + 1);", "division by zero"),
        ("W := SHL(W, K);", "the shift count -1 is negative"),
        ("W := SHR(W, K);", "the shift count -1 is negative"),
        ("T := LEFT(T, K);", "a STRING function has the negative length or position -1"),
        ("T := RIGHT(T, K);", "a STRING function has the negative length or position -1"),
        ("T := MID(T, K, 1);", "a STRING function has the negative length or position -1"),
        ("T := MID(T, 1, K + 1);", "a STRING function has position 0, but positions begin at 1"),
        ("T := DELETE(T, 1, K + 1);", "a STRING function has position 0, but positions begin at 1"),
        (
            "T := REPLACE(T, T, 1, K + 1);",
            "a STRING function has position 0, but positions begin at 1",
        ),
        ("T := INSERT(T, T, K);", "a STRING function has the negative length or position -1"),
        ("F := SQRT(F);", "a function is not defined for its argument"),
        ("F := LN(F + 1.0);", "a function is not defined for its argument"),
    ],
)
def test_a_call_that_the_standard_does_not_define_ends_the_run(
    tmp_path: Path, code: str, message: str
) -> None:
    variables = "K : INT := -1; R : INT; W : WORD; T : STRING := 'abc'; F : REAL := -1.0;"
    with pytest.raises(InputError, match=message):
        _run(f"PROGRAM P1 VAR {variables} END_VAR {code} END_PROGRAM", tmp_path)
