"""A project has instances, tasks with their order, and types."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from mistakes import check
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, ElementaryType, EnumType, StructType

Build = Callable[..., BuiltinProgram]
Load = Callable[..., Project]

INT, WORD = ElementaryType("INT"), ElementaryType("WORD")


def test_a_program_without_configuration_runs_as_main(project_of: Load) -> None:
    project = project_of("PROGRAM Pump\nVAR I : INT; END_VAR\nI := 1;\nEND_PROGRAM")
    assert [(name, block.name) for name, block in project.instances.items()] == [("Main", "Pump")]
    assert not project.configured
    assert project.tick_us is None
    assert [(run.instance, run.every) for run in project.schedule] == [("Main", 1)]


def test_sources_without_a_program_cannot_be_loaded_but_checked(tmp_path: Path) -> None:
    file = tmp_path / "type.st"
    file.write_text("TYPE A1 : INT; END_TYPE")
    assert check([file]) == []
    with pytest.raises(InputError, match="there is no PROGRAM"):
        load([file])


def test_files_come_in_the_order_of_their_dependencies(project_of: Load) -> None:
    sources = (
        "PROGRAM P1\nVAR B : Block1; END_VAR\nB(X := 1);\nEND_PROGRAM",
        "FUNCTION_BLOCK Block1\nVAR_INPUT X : INT; END_VAR\nVAR K : Kind; END_VAR\n"
        "K.A := Twice(X);\nEND_FUNCTION_BLOCK",
        "FUNCTION Twice : INT\nVAR_INPUT X : INT; END_VAR\nTwice := 2 * X;\nEND_FUNCTION",
        "TYPE Kind : STRUCT A : Inner; END_STRUCT; END_TYPE",
        "TYPE Inner : INT; END_TYPE",
    )
    project = project_of(*sources)
    assert [file.name for file in project.files] == ["source4.st", "source3.st", "source2.st",
                                                     "source1.st", "source0.st"]  # fmt: skip
    assert [unit.name for unit in project.units] == ["Inner", "Kind", "Twice", "Block1", "P1"]
    assert list(project.blocks) == ["BLOCK1", "P1"]


_TASKS = """\
PROGRAM P1
VAR I : INT; END_VAR
I := I + 1;
END_PROGRAM
CONFIGURATION Cell
  VAR_GLOBAL Level AT %IW3 : WORD; Total : INT := 7; END_VAR
  RESOURCE Plc ON Computer
    TASK Slow(INTERVAL := T#60ms, PRIORITY := 2);
    TASK Fast(INTERVAL := T#40ms, PRIORITY := 1);
    PROGRAM First WITH Slow : P1;
    PROGRAM Second WITH Fast : P1;
    PROGRAM Third : P1;
    PROGRAM Fourth WITH Fast : P1;
  END_RESOURCE
END_CONFIGURATION
"""


def test_tasks_run_by_priority_and_in_every_nth_tick(project_of: Load) -> None:
    """The base tick is 10 ms, because the program Third has no task and runs every 10 ms."""
    project = project_of(_TASKS)
    assert list(project.instances) == ["First", "Second", "Third", "Fourth"]
    assert [(task.name, task.interval_us, task.priority) for task in project.tasks] == [
        ("Slow", 60_000, 2),
        ("Fast", 40_000, 1),
    ]
    assert project.tasks[1].instances == ("Second", "Fourth")
    assert project.tick_us == 10_000
    assert project.free == ("Third",)
    assert [(run.instance, run.every) for run in project.schedule] == [
        ("Second", 4),
        ("Fourth", 4),
        ("First", 6),
        ("Third", 1),
    ]


def test_global_and_located_variables_are_known(project_of: Load) -> None:
    project = project_of(_TASKS)
    assert {key: (item.name, item.type) for key, item in project.globals.items()} == {
        "LEVEL": ("Level", WORD),
        "TOTAL": ("Total", INT),
    }
    assert [(item.address, item.path) for item in project.located] == [("%IW3", "Level")]


@pytest.mark.parametrize(
    ("runs", "located"),
    [
        # A program that is called by name has its own entry, unless it has an instance.
        ("PROGRAM B WITH T1 : Top;", [("%QW2", "B.Speed"), ("%QW1", "Feeder.Pulse")]),
        (
            "PROGRAM A WITH T1 : Feeder; PROGRAM B WITH T1 : Top;",
            [("%QW1", "A.Pulse"), ("%QW2", "B.Speed")],
        ),
    ],
)
def test_located_variables_of_a_program_that_others_name_are_known(
    runs: str, located: list[tuple[str, str]], project_of: Load
) -> None:
    project = project_of(
        "PROGRAM Feeder VAR Pulse AT %QW1 : INT; N : INT; END_VAR N := N + 1; END_PROGRAM\n"
        "PROGRAM Top VAR Speed AT %QW2 : INT; N : INT; END_VAR N := Feeder.N; END_PROGRAM\n"
        "CONFIGURATION C1 RESOURCE R1 ON Plc TASK T1 (INTERVAL := T#10ms, PRIORITY := 1);\n"
        f"{runs} END_RESOURCE END_CONFIGURATION\n"
    )
    assert [(item.address, item.path) for item in project.located] == located


@pytest.mark.parametrize(
    ("pragma", "bare"),
    [("qualified_only", False), ("linkalways", True), ("init_on_onlchange", True)],
)
def test_only_the_attribute_qualified_only_requires_the_name_of_the_list(
    pragma: str, bare: bool, mistakes_of: Callable[..., list[InputError]]
) -> None:
    """Only with the attribute 'qualified_only' is the list's name needed.

    Source: TwinCAT and CODESYS, attribute 'qualified_only'; the list is called as its file.
    """
    lists = f"{{attribute '{pragma}'}}\nVAR_GLOBAL Level : INT; END_VAR\n"
    program = "PROGRAM P1\n{0} := 1;\nEND_PROGRAM\n"
    assert mistakes_of(lists, program.format("source0.Level")) == []
    assert [error.line for error in mistakes_of(lists, program.format("Level"))] == [2] * (not bare)


def test_a_variable_goes_before_a_list_of_its_name(build: Build) -> None:
    """A variable and a list of globals have the same name.

    The expression reads the property of the variable (+ 1), not the global variable.
    """
    program = build(
        "VAR_GLOBAL Level : INT; END_VAR\n",
        "FUNCTION_BLOCK Tank VAR N : INT; END_VAR\n"
        "PROPERTY Level : INT GET Level := N; END_GET SET N := Level + 1; END_SET END_PROPERTY\n"
        "END_FUNCTION_BLOCK\n"
        "PROGRAM P1 VAR source0 : Tank; END_VAR\nsource0.Level := 5;\nEND_PROGRAM\n",
    )
    program.scan(0)
    assert program.read("Main.source0.N") == 6


def test_a_label_of_a_case_may_be_a_global_constant(build: Build) -> None:
    """A label of a CASE may be a global constant, with or without the name of its list."""
    program = build(
        "VAR_GLOBAL CONSTANT Full : INT := 3; END_VAR\n",
        "PROGRAM P1 VAR I : INT := 3; A, B : INT; END_VAR\n"
        "CASE I OF 1: A := 1; Full: A := 2; END_CASE;\n"
        "CASE I OF 1: B := 1; source0.Full: B := 2; END_CASE;\nEND_PROGRAM\n",
    )
    program.scan(0)
    assert (program.read("Main.A"), program.read("Main.B")) == (2, 2)


def test_types_are_resolved_with_names_as_declared(project_of: Load) -> None:
    project = project_of(
        "TYPE Colour : (RED, GREEN); END_TYPE\n"
        "TYPE Grid : ARRAY [0..1, -1..1] OF Colour; END_TYPE\n"
        "TYPE\n  Speed : INT := 5;\n  Motor : STRUCT Now, Max1 : Speed; Map : Grid; END_STRUCT;\n"
        "END_TYPE\nPROGRAM P1\nVAR M : motor; END_VAR\nM.now := 1;\nEND_PROGRAM"
    )
    colour = EnumType("Colour", ("RED", "GREEN"))
    grid = ArrayType("Grid", ((0, 1), (-1, 1)), colour)
    assert project.types["GRID"] == grid
    assert project.types["SPEED"] == INT
    assert project.types["MOTOR"] == StructType(
        "Motor", (("Now", INT), ("Max1", INT), ("Map", grid))
    )
    assert project.initial["MOTOR"] == {"Now": 5, "Max1": 5, "Map": [0] * 6}


def test_a_file_given_twice_counts_once(tmp_path: Path) -> None:
    file = tmp_path / "one.st"
    file.write_text("PROGRAM P1\nVAR I : INT; END_VAR\nI := 1;\nEND_PROGRAM")
    assert load([file, file]).files == (file,)
