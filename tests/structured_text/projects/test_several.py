"""A project can use another project as a library, with its namespace."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.bench import Bench
from structured_text.errors import InputError
from structured_text.language.load import analyse
from structured_text.projects.open import project_sources
from structured_text.projects.sources import source_files
from twincat_projects import written_project

_COUNTER = """\
FUNCTION_BLOCK Counter
VAR_OUTPUT
  Q : INT;
END_VAR
---
Q := Q + Limits.Step; // Counter
"""
_LIBRARY = {
    "Counter.TcPOU": _COUNTER,
    "Limits.TcGVL": "VAR_GLOBAL CONSTANT\n  Step : INT := 3;\nEND_VAR",
    "Mode.TcDUT": "TYPE Mode : (Off, Slow := 7); END_TYPE",
    "MAIN.TcPOU": "PROGRAM MAIN\nVAR\n  own : Counter;\nEND_VAR\n---\nown();\n",
}
_APPLICATION = {
    "Counter.TcPOU": "FUNCTION_BLOCK Counter EXTENDS Parts.Counter\n---\nSUPER^(); Q := Q + 100;\n",
    "Limits.TcGVL": "VAR_GLOBAL CONSTANT\n  Step : INT := 50;\nEND_VAR",
    "MAIN.TcPOU": """\
PROGRAM MAIN
VAR
  a : Parts.Counter;
  b : Counter;
  c, d : INT;
  m : Parts.Mode := Parts.Mode.Slow;
END_VAR
---
a();
b();
c := Limits.Step;
d := Parts.Limits.Step;
""",
}


def _projects(folder: Path) -> list[Path]:
    settings = "<Title>Spare Parts</Title><DefaultNamespace>Parts</DefaultNamespace>"
    library = written_project(folder / "Library", _LIBRARY, settings)
    uses = {"Spare Parts": "Parts", "Tc2_Utilities": "Tc2_Utilities"}
    return [written_project(folder / "Machine", _APPLICATION, libraries=uses), library]


@pytest.mark.parametrize("order", [1, -1])
def test_a_library_is_found_by_its_namespace(order: int, tmp_path: Path) -> None:
    """A name with the library's namespace means the declaration in the library.

    Both projects have a block, a list, a program and a task of the same name. In two scans, a is 3
    and 6, and b is 103 and 206.

    Source: Beckhoff Information System, TwinCAT 3 PLC: library reference, Namespace.
    """
    files = source_files(_projects(tmp_path)[::order], None)
    with Bench.build(files, engine="builtin") as bench:
        bench.scan(2)
        names = ("a.Q", "b.Q", "c", "d")
        assert [bench[f"MAIN.{name}"] for name in names] == [6, 206, 50, 3]
        assert bench["MAIN.m"] == "Slow"


def test_only_the_libraries_that_are_not_given_are_noted(tmp_path: Path) -> None:
    """A note names only the libraries that the user has not given.

    Source: docs/how-to/projects.md.
    """
    machine, library = _projects(tmp_path)
    notes = project_sources([machine, library], {}).notes
    assert [note.rpartition(":")[2].strip() for note in notes] == [
        "the library Tc2_Utilities is not read",
        "the tasks of the library Spare Parts do not run",
    ]
    alone = project_sources([machine], {}).notes
    assert [note.rpartition("the library ")[2] for note in alone] == [
        "Spare Parts is not read",
        "Tc2_Utilities is not read",
    ]


def test_two_projects_that_do_not_refer_to_each_other_are_two_programs(tmp_path: Path) -> None:
    """Two independent projects are refused, because they are two programs.

    Source: docs/how-to/projects.md.
    """
    one = written_project(tmp_path / "One", {"MAIN.TcPOU": "PROGRAM MAIN\n---\n;\n"})
    two = written_project(tmp_path / "Two", {"PRG.TcPOU": "PROGRAM PRG\n---\n;\n"})
    _, errors = analyse(project_sources([one, two], {}).paths)
    assert "a second CONFIGURATION" in str(errors[0])


def test_a_library_without_a_namespace_is_known_by_its_title(tmp_path: Path) -> None:
    """The title of a library is its namespace if the project gives no other.

    Source: Beckhoff Information System, TwinCAT 3 PLC: project properties, Common.
    """
    library = written_project(tmp_path / "Library", _LIBRARY, "<Title>Parts</Title>")
    body = "PROGRAM MAIN\nVAR\n  a : PARTS.Counter;\nEND_VAR\n---\na();\n"
    machine = written_project(tmp_path / "Machine", {"MAIN.TcPOU": body}, libraries={"Parts": ""})
    with Bench.build(source_files([machine, library], None), engine="builtin") as bench:
        bench.scan(1)
        assert bench["MAIN.a.Q"] == 3


@pytest.mark.parametrize(
    "text",
    [
        "FUNCTION_BLOCK Own EXTENDS Parts.Own",
        "FUNCTION_BLOCK Own IMPLEMENTS Parts.Own",
        "FUNCTION_BLOCK Own\nVAR\n  a : Parts.Own;\nEND_VAR",
    ],
)
def test_a_name_with_an_unknown_namespace_is_not_the_block_itself(
    text: str, tmp_path: Path
) -> None:
    """A name with an unknown namespace gives one message.

    It is not taken for the block itself, which would be a recursion.

    Source: IEC 61131-3, 3rd edition, 6.9: namespaces.
    """
    file = tmp_path / "own.st"
    file.write_text(f"{text}\nEND_FUNCTION_BLOCK\n", encoding="utf-8")
    _, errors = analyse([file])
    assert [(one.message, one.hint) for one in errors] == [
        ("there is no namespace Parts", "name its project, too, or check the spelling")
    ]


def test_an_unknown_namespace_is_not_that_of_another_project(tmp_path: Path) -> None:
    """An unknown namespace is an error, even if another project has the name.

    Source: docs/how-to/projects.md.
    """
    library = written_project(tmp_path / "Library", _LIBRARY, task=False)
    body = "PROGRAM MAIN2\nVAR\n  a : Other.Counter;\nEND_VAR\n---\na();\n"
    machine = written_project(tmp_path / "Machine", {"MAIN2.TcPOU": body}, task=False)
    with pytest.raises(InputError, match="there is no namespace Other"):
        Bench.build(source_files([machine, library], None), engine="builtin")


def test_a_library_that_no_other_project_names_keeps_its_own_elements(tmp_path: Path) -> None:
    """Two libraries have a block `Space`, and the machine uses one of them.

    In each library, the type `Space` means the library's own block.

    Source: Beckhoff Information System, TwinCAT 3 PLC: library reference, Namespace.
    """
    block = "FUNCTION_BLOCK Space\nVAR_OUTPUT\n  Q : INT := {};\nEND_VAR\n"
    reader = (
        "FUNCTION_BLOCK Reader\nVAR_OUTPUT\n  Space : Space;\n  R : INT;\nEND_VAR\n---\n"
        "R := Space.Q;\n"
    )
    used = written_project(
        tmp_path / "Used",
        {"Space.TcPOU": block.format(1), "Reader.TcPOU": reader},
        "<Title>My parts</Title><DefaultNamespace>Parts</DefaultNamespace>",
        task=False,
    )
    unused = written_project(
        tmp_path / "Unused",
        {"Space.TcPOU": block.format(2), "Other.TcPOU": reader.replace("Reader", "Other")},
        "<Title>Other parts</Title><DefaultNamespace>Others</DefaultNamespace>",
        task=False,
    )
    main = "PROGRAM MAIN\nVAR\n  a : Parts.Reader;\nEND_VAR\n---\na();\n"
    machine = written_project(
        tmp_path / "Machine", {"MAIN.TcPOU": main}, libraries={"[My parts]": "Parts"}
    )
    with Bench.build(source_files([machine, used, unused], None), engine="builtin") as bench:
        bench.scan(1)
        assert bench["MAIN.a.R"] == 1
