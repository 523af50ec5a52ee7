from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.matiec.build import Matiec, Message, TranslationError
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.matiec.source import SourceText, explain, join_sources
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.language.project import Project

Compile = Callable[..., MatiecProgram]


@pytest.fixture
def joined(tmp_path: Path) -> tuple[Project, SourceText]:
    """Return a source joined from a program of five lines and a type of three lines."""
    program, kind = tmp_path / "program.st", tmp_path / "kind.st"
    program.write_text("PROGRAM PROBE\n  VAR\n    P : POINT;\n  END_VAR\n  P.X := 1; END_PROGRAM")
    kind.write_text("TYPE POINT : STRUCT\r\n    X : INT;\r\n  END_STRUCT; END_TYPE\r\n")
    project = load([program, kind])
    return project, join_sources(project)


def test_files_are_joined_in_the_order_that_matiec_wants(
    joined: tuple[Project, SourceText], tmp_path: Path
) -> None:
    _, source = joined
    lines = source.text.splitlines()
    assert lines[0] == "TYPE POINT : STRUCT"
    assert lines[3] == "PROGRAM PROBE"
    assert source.place(1) == (tmp_path / "kind.st", 1)
    assert source.place(3) == (tmp_path / "kind.st", 3)
    assert source.place(4) == (tmp_path / "program.st", 1)
    assert source.place(8) == (tmp_path / "program.st", 5)


def test_a_missing_configuration_is_added(joined: tuple[Project, SourceText]) -> None:
    assert "HARNESS_HIDDEN_INSTANCE WITH HARNESS_HIDDEN_TASK : PROBE;" in joined[1].text


@pytest.mark.parametrize(
    ("failure", "file", "line", "message"),
    [
        (([Message("Data type mismatch", 8, 3)], "", 1), "program.st", 5,
         "matiec: Data type mismatch"),
        (([], "timer.txt:2-5..2-13: error: invalid input variable(s) declaration.\n", 1), "kind.st",
         1, "matiec uses the name POINT inside its own library"),
        (([], "\ncore dumped\n", -11), "program.st", None,
         "iec2c, the compiler of matiec, crashed on this program or one of 1 more files (SIGSEGV)"),
        (([], "\nno library\n", 3), "", None, "iec2c failed with status 3 and said: no library"),
    ],
    ids=["a mistake", "a name of matiec's library", "a crash", "no place"],
)  # fmt: skip
def test_a_failure_of_iec2c_is_reported_at_the_users_line(
    joined: tuple[Project, SourceText],
    tmp_path: Path,
    failure: tuple[list[Message], str, int],
    file: str,
    line: int | None,
    message: str,
) -> None:
    project, source = joined
    (tmp_path / "timer.txt").write_text("(* pins *)\n  VAR_INPUT Point : TIME; END_VAR\n")
    matiec = Matiec(Path("iec2c"), tmp_path, tmp_path / "C")
    error = explain(TranslationError(*failure), source, project, matiec)
    assert error.file == (str(tmp_path / file) if file else None)
    assert (error.line, error.message) == (line, message)
    assert "installation" not in str(error) or not file


def test_a_refusal_of_matiec_has_its_line(compiled: Compile, tmp_path: Path) -> None:
    """The message of iec2c about a refused initial value gets the line in the user's file."""
    kind = "TYPE TAGGED : STRUCT X : REAL; Tag : STRING; END_STRUCT; END_TYPE\n"
    program = "PROGRAM PROBE\n  VAR\n    P : TAGGED := (Tag := 'a');\n  END_VAR\n  P.Tag := 'b';\n"
    with pytest.raises(InputError) as caught:
        compiled(program + "END_PROGRAM\n", kind)
    assert caught.value.file == str(tmp_path / "source0.st")
    assert caught.value.line == 3
    assert caught.value.message.startswith("matiec: Initialization element")


def test_a_configuration_needs_no_resource(compiled: Compile) -> None:
    program = compiled(
        "PROGRAM PROBE VAR N : INT; END_VAR N := N + 1; END_PROGRAM\n"
        "CONFIGURATION PLANT TASK CYCLE(INTERVAL := T#5ms, PRIORITY := 0);\n"
        "PROGRAM Cell WITH CYCLE : PROBE; END_CONFIGURATION\n"
    )
    program.scan(0)
    assert program.read("Cell.N") == 1


TASKS = """PROGRAM PROBE VAR N : INT; END_VAR N := N + 1; END_PROGRAM
CONFIGURATION PLANT
  RESOURCE CPU ON PLC
    TASK QUICK_TASK(INTERVAL := T#20ms, PRIORITY := 2);
    TASK SLOW_TASK(INTERVAL := T#50ms, PRIORITY := 1);
    PROGRAM Quick WITH QUICK_TASK : PROBE;
    PROGRAM Slow WITH SLOW_TASK : PROBE;
  END_RESOURCE
END_CONFIGURATION
"""


def test_programs_declared_against_their_priorities_are_refused(compiled: Compile) -> None:
    """Matiec runs programs in the order of their declarations, so Quick would run first.

    The program is refused.
    """
    with pytest.raises(
        InputError, match=r"runs programs as they are declared \(Quick, Slow\)"
    ) as no:
        compiled(TASKS)
    assert no.value.line == TASKS.splitlines().index("CONFIGURATION PLANT") + 1
    assert no.value.hint == "declare them in the order Slow, Quick"
