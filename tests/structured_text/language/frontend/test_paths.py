"""Paths lead to variables, and wrong paths are reported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.language.paths import resolve, walk
from structured_text.language.project import Project
from structured_text.language.types import ElementaryType

Load = Callable[..., Project]

_SOURCE = """\
TYPE Outputs : STRUCT Ready : BOOL; Servo : BOOL; END_STRUCT; END_TYPE
TYPE Robot : STRUCT SO : Outputs; Words : ARRAY [1..3] OF WORD; END_STRUCT; END_TYPE
FUNCTION_BLOCK Drive
  VAR_IN_OUT Ref1 : Robot; END_VAR
  VAR_INPUT Go : BOOL; END_VAR
  VAR Delay : TON; END_VAR
  VAR_TEMP Aid : INT; END_VAR
  Delay(IN := Go); Aid := 1; Ref1.SO.Ready := Delay.Q;
END_FUNCTION_BLOCK
PROGRAM Plant
  VAR R1 : Robot; Grid : ARRAY [0..1, -1..1] OF INT; D1 : Drive;
      Nested : ARRAY [1..2] OF ARRAY [0..1] OF INT; END_VAR
  VAR Lamp AT %QX1.0 : BOOL; END_VAR
  D1(Ref1 := R1);
END_PROGRAM
"""


@pytest.fixture
def project(project_of: Load) -> Project:
    return project_of(_SOURCE)


@pytest.mark.parametrize(
    ("path", "canonical", "steps"),
    [
        ("Main", "Main", ()),
        ("plant.r1.so.SERVO", "Main.R1.SO.Servo", ("R1", "SO", "Servo")),
        ("MAIN.R1.Words[3]", "Main.R1.Words[3]", ("R1", "Words", 2)),
        ("Main.Grid[1, -1]", "Main.Grid[1,-1]", ("Grid", 3)),
        ("Main.Nested[2][0]", "Main.Nested[2][0]", ("Nested", 1, 0)),
        (" Main . D1 . Delay . Q ", "Main.D1.Delay.Q", ("D1", "Delay", "Q")),
    ],
)
def test_names_are_found_without_case_and_given_as_declared(
    project: Project, path: str, canonical: str, steps: tuple[object, ...]
) -> None:
    found = resolve(project, path)
    assert (found.path, found.root, found.steps) == (canonical, "Main", steps)


def test_the_address_of_a_located_variable_is_given(project: Project) -> None:
    found = resolve(project, "Main.Lamp")
    assert (found.address, found.type) == ("%QX1.0", ElementaryType("BOOL"))


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("Mein.R1", "there is no program instance Mein; did you mean Main?"),
        ("Main.R2", "Main of type Plant has no member R2; there are R1, Grid, D1"),
        ("Main.R1.SO.Redy", "has no member Redy; did you mean Ready?"),
        ("Main.R1.SO.Ready.X", "Main.R1.SO.Ready is of type BOOL and has no member X"),
        ("Main.R1[1]", "Main.R1 is of type Robot and has no elements"),
        ("Main.R1.Words[0]", "Main.R1.Words: index 0 is outside 1..3"),
        ("Main.R1.Words[4]", "index 4 is outside 1..3"),
        ("Main.Grid[1]", "Main.Grid has 2 dimensions, not 1"),
        ("Main.Grid[1,2]", "index 2 is outside -1..1"),
        ("Main.D1.Ref1", "Main.D1.Ref1 is a VAR_IN_OUT and has no value of its own"),
        ("Main.D1.Aid", "has no member Aid"),
        ("Main..R1", "is not a path"),
        ("Main.R1.Words[x]", "is not a path"),
        ("Main.R1.Words[1", "is not a path"),
        ("Main R1", "is not a path"),
        ("", "is not a path"),
    ],
)
def test_a_wrong_path_gets_suggestions(project: Project, path: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        resolve(project, path)
    assert message in str(caught.value)


def test_walk_gives_parents_before_children_and_arrays_whole(project: Project) -> None:
    assert [path for path, _ in walk(project)] == ["Main.R1", "Main.R1.SO", "Main.R1.SO.Ready",
                                                   "Main.R1.SO.Servo", "Main.R1.Words", "Main.Grid",
                                                   "Main.D1", "Main.D1.Go", "Main.D1.Delay",
                                                   "Main.D1.Delay.IN", "Main.D1.Delay.PT",
                                                   "Main.D1.Delay.Q", "Main.D1.Delay.ET",
                                                   "Main.Nested", "Main.Lamp"]  # fmt: skip


def test_a_global_variable_may_stand_behind_the_name_of_its_list(tmp_path: Path) -> None:
    """A path may have the name of the list before a global variable.

    A list has the name of its file.
    """
    (tmp_path / "Plant.st").write_text("PROGRAM Plant\nVAR a : INT; END_VAR\na := 1;\nEND_PROGRAM")
    (tmp_path / "GVL.st").write_text(
        "VAR_GLOBAL\n  Limit : INT;\n  Grid : ARRAY [1..2] OF INT;\nEND_VAR"
    )
    project = load([tmp_path / "Plant.st", tmp_path / "GVL.st"])
    for path in ("Limit", "GVL.Limit", "gvl.limit"):
        found = resolve(project, path)
        assert (found.path, found.is_global) == ("Limit", True)
    assert resolve(project, "GVL.Grid[2]").steps == (1,)
    for path, message in (
        ("GVL.Limt", "the list GVL has no variable Limt; did you mean Limit?"),
        ("GVL", "there is no program instance GVL"),
        ("Main.Limit", "has no member Limit"),
    ):
        with pytest.raises(InputError) as caught:
            resolve(project, path)
        assert message in str(caught.value)


def test_a_program_reaches_a_global_through_var_external(project_of: Load) -> None:
    project = project_of(
        "PROGRAM P1\nVAR_EXTERNAL Total : INT; END_VAR\nTotal := 1;\nEND_PROGRAM\n"
        "CONFIGURATION C1 VAR_GLOBAL Total : INT; END_VAR RESOURCE R1 ON Plc\n"
        "PROGRAM A : P1; PROGRAM B : P1; END_RESOURCE END_CONFIGURATION"
    )
    for path in ("Total", "A.Total", "b.total"):
        found = resolve(project, path)
        assert (found.path, found.root, found.is_global) == ("Total", "Total", True)
    with pytest.raises(InputError, match="there is no program instance Main"):
        resolve(project, "Main.Total")
