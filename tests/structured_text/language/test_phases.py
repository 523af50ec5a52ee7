"""Tests of Automation Studio programs: a task is a folder with `.st`, `.var` and other files."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.language.load import analyse, load

_MAIN = """
PROGRAM _INIT
  Count := 10; RETURN; Count := 99;
END_PROGRAM
PROGRAM _CYCLIC
  Count := Count + Step; Pair.A := F_Twice(Count);
END_PROGRAM
PROGRAM _EXIT
  Count := 0;
END_PROGRAM
FUNCTION F_Twice F_Twice := X * 2; END_FUNCTION
"""


def _written(folder: Path, texts: dict[str, str]) -> list[Path]:
    for name, text in texts.items():
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return [folder / name for name in texts]


def _task(tmp_path: Path) -> list[Path]:
    texts = {
        "Task/Main.st": _MAIN,
        "Task/Own.var": "VAR\n  Count : INT;\n  Pair : T_Pair;\nEND_VAR",
        "Task/Own.typ": "TYPE T_Pair : STRUCT A : INT; END_STRUCT; END_TYPE\n",
        "Task/Own.fun": "FUNCTION F_Twice : INT VAR_INPUT X : INT; END_VAR END_FUNCTION\n",
        "Global.var": "VAR CONSTANT\n  Step : INT := 3;\nEND_VAR\n",
    }
    return _written(tmp_path, texts)


def test_the_first_scan_runs_init_before_cyclic(tmp_path: Path) -> None:
    """_INIT runs only in the first scan, before _CYCLIC: 10 + 3 = 13, then 16.

    RETURN in _INIT does not end _CYCLIC, and _EXIT does not run.
    """
    program = BuiltinProgram.build(load(_task(tmp_path)))
    program.scan(0)
    assert [program.read(f"Main.{name}") for name in ("Count", "Pair.A")] == [13, 26]
    program.scan(0)
    assert [program.read(f"Main.{name}") for name in ("Count", "Pair.A")] == [16, 32]


def test_the_program_is_named_after_its_folder_and_not_portable(tmp_path: Path) -> None:
    project = load(_task(tmp_path))
    assert [block.name for block in project.instances.values()] == ["Task"]
    assert "a program of _INIT and _CYCLIC" in {use.construct for use in project.uses}


@pytest.mark.parametrize("missing", ["Own.var", "Global.var", "Own.typ", "Own.fun"])
def test_a_missing_file_is_named_by_what_it_declares(tmp_path: Path, missing: str) -> None:
    files = [file for file in _task(tmp_path) if file.name != missing]
    _, errors = analyse(files)
    assert errors
    said = {"Own.var": "Count is not", "Global.var": "Step is not", "Own.typ": "no type T_Pair"}
    assert said.get(missing, "") in errors[0].message
    if missing.endswith(".var"):
        assert errors[0].hint == "name its .var file, too, or the folder of the task"


def test_a_mistake_in_a_file_of_variables_has_its_line_and_column(tmp_path: Path) -> None:
    (file,) = _written(tmp_path, {"Own.var": "VAR A : ; END_VAR\n"})
    _, errors = analyse([file])
    assert [(one.file, one.line, one.column) for one in errors] == [(str(file), 1, 9)]


def test_a_cyclic_program_alone_and_the_usual_names_stay_as_they_are(tmp_path: Path) -> None:
    files = _written(
        tmp_path,
        {
            "A.st": "PROGRAM _CYCLIC VAR N : INT; END_VAR N := N + 1; END_PROGRAM",
        },
    )
    program = BuiltinProgram.build(load(files))
    program.scan(0)
    assert program.read("Main.N") == 1
