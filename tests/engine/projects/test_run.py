"""Projects of PLC tools run and are checked without changes, or with bodies of the user."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from rcx_harness.cell import Cell
from rcx_harness.cell.sources import source_files
from rcx_harness.cli.app import main
from structured_text.engines.load import build
from structured_text.projects.open import project_sources

_DATA = Path(__file__).parent / "data"

#: A project in which Main calls Lamp, whose body is in CFC. Spare is never called.
_PROJECT = """\
<project xmlns="http://www.plcopen.org/xml/tc6_0200"><types><pous>
<pou name="Main" pouType="program">
<interface><localVars>
<variable name="One"><type><derived name="Lamp"/></type></variable>
<variable name="n"><type><INT/></type></variable>
</localVars></interface>
<body><ST><p>One(Lit := TRUE);
n := %s;</p></ST></body>
</pou>
<pou name="Lamp" pouType="functionBlock">
<interface><inputVars><variable name="Lit"><type><BOOL/></type></variable></inputVars>
<outputVars><variable name="Q"><type><BOOL/></type></variable></outputVars></interface>
<body><CFC/></body>
</pou>
<pou name="Spare" pouType="functionBlock"><body><IL/></body></pou>
</pous></types></project>
"""


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """Write a project in which the block Lamp has a body in CFC, and return its file."""
    file = tmp_path / "cell.xml"
    file.write_text(_PROJECT % "n + 1", encoding="utf-8")
    return file


def test_a_program_of_beremiz_runs_at_its_tasks_interval() -> None:
    """A program runs at the interval of its task in the project.

    Source: docs/how-to/projects.md.
    """
    program = build(source_files(_DATA / "beremiz.xml").all, "builtin").program
    assert program.tick_us == 50_000
    program.scan(0)
    program.scan(50_000)
    assert program.read("Main.Row[1]") == 2


def test_a_body_in_another_language_is_named(
    cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A body in CFC is reported, and a program that calls its block does not run.

    Source: docs/how-to/projects.md.
    """
    said = f"{cell}:13: the body of Lamp is in Continuous Function Chart (CFC) and is not read"
    assert main(["check", str(cell)]) == 0
    assert f"note: {said}\n" in capsys.readouterr().out
    assert main(["run", str(cell), "--no-robot", "--for", "100ms", "--engine", "builtin"]) == 2
    refused = f"rcx: {said}; write it in Structured Text: --replace Lamp=file.st\n"
    assert capsys.readouterr().err.removeprefix("compiling ...\n") == refused
    assert main(["export", "st", "--program", str(cell), "-o", str(cell.parent / "out")]) == 2
    assert capsys.readouterr().err.startswith(f"rcx: {said}")


@pytest.mark.parametrize(
    "text",
    [
        "Q := Lit;",
        "(* mine *)\n\nQ := Lit;\n",
        "FUNCTION_BLOCK Lamp\n  VAR_INPUT\n    Lit : BOOL;\n  END_VAR\n  VAR_OUTPUT\n"
        "    Q : BOOL;\n"
        "  END_VAR\n  Q := Lit;\nEND_FUNCTION_BLOCK\n",
    ],
)
def test_a_cfc_body_is_replaced_by_a_body_or_a_block_of_the_user(
    cell: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A body in CFC is replaced by a body or a whole block of the user.

    An unused body is reported.
    """
    own = cell.with_name("lamp.st")
    own.write_text(text, encoding="utf-8")
    program = build(source_files(cell, None, {"lamp": own}).all, "builtin").program
    program.scan(0)
    assert program.read("Main.One.Q") is True
    assert main(["check", str(cell), "--replace", f"Lamp={own}"]) == 0
    assert f"note: {cell}:15: the body of Spare is in Instruction List (IL) and is not" in (
        capsys.readouterr().out
    )


def test_a_mistake_in_the_users_body_is_reported_in_the_users_file(
    cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A mistake in the user's body is reported with the line of the user's file."""
    own = cell.with_name("lamp.st")
    own.write_text("Q := Lit;\nQ := Nothing;\n", encoding="utf-8")
    assert main(["check", str(cell), "--replace", f"Lamp={own}"]) == 2
    assert f"{own}:2:6: Nothing is not declared" in capsys.readouterr().err


def test_a_mistake_in_a_project_is_reported_with_its_line(
    cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A mistake in a project is reported with its line. Source: docs/how-to/projects.md."""
    cell.write_text(_PROJECT % "m", encoding="utf-8")
    own = _DATA / "lamp.st"
    assert main(["check", str(cell), "--replace", f"Lamp={own}"]) == 2
    assert capsys.readouterr().err.startswith(f"error: {cell}:8:6: m is not declared")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["Lamb=lamp.st"], "--replace Lamb: there is no POU of this name in the project; did you"),
        (["Lamp"], "--replace Lamp; write it as --replace POU=file.st"),
        (["Lamp=nowhere.st"], "nowhere.st: --replace Lamp: no such file"),
        (["Lamp=lamp.st", "LAMP=lamp.st"], "--replace LAMP is given twice"),
    ],
)
def test_a_replacement_without_a_matching_body_is_refused(
    given: list[str],
    message: str,
    cell: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A --replace that matches no body is rejected. Source: rcx check --help."""
    monkeypatch.chdir(cell.parent)
    Path("lamp.st").write_text("Q := Lit;", encoding="utf-8")
    options = [part for one in given for part in ("--replace", one)]
    assert main(["check", "cell.xml", *options]) == 2
    assert message in capsys.readouterr().err


def test_a_replacement_needs_a_project(capsys: pytest.CaptureFixture[str]) -> None:
    """--replace is rejected for files that are not projects. Source: rcx check --help."""
    own = str(_DATA / "lamp.st")
    assert main(["check", own, "--replace", f"P={own}"]) == 2
    assert "--replace is for projects of PLC tools" in capsys.readouterr().err


def test_a_source_in_a_project_file_can_be_pickled_and_compared() -> None:
    """A source inside a project file can be pickled and compared, as caches and workers need it."""
    paths = project_sources([_DATA / "beremiz.xml"], {}).paths
    assert pickle.loads(pickle.dumps(paths)) == paths
    assert len({*paths, _DATA / "beremiz.xml"}) == len(paths) + 1
    assert all(path.resolve() == (_DATA / "beremiz.xml").resolve() for path in paths)


def test_a_process_image_may_be_inside_a_block(tmp_path: Path) -> None:
    """InputArea and OutputArea may be variables of a block.

    In some tools a PROGRAM has no static variables.

    Source: docs/how-to/projects.md.
    """
    (tmp_path / "a.st").write_text(
        "FUNCTION_BLOCK Station\n  VAR\n    InputArea, OutputArea : RCX_IMAGE;\n"
        "    Connected : BOOL;\n  END_VAR\n  OutputArea[3] := InputArea[0];\nEND_FUNCTION_BLOCK\n"
        "PROGRAM P\n  VAR\n    S : Station;\n  END_VAR\n  S();\nEND_PROGRAM\n",
        encoding="utf-8",
    )
    with Cell.build(tmp_path / "a.st", engine="builtin") as cell:
        cell.run("200ms")
        assert cell["Main.S.Connected"] is True
        assert cell.connected


def test_check_writes_interfaces_of_missing_blocks_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Interfaces of missing blocks are written, but never over existing files.

    Source: rcx check --help, --stubs.
    """
    text = _PROJECT % "n + 1"
    file, stubs = tmp_path / "cell.xml", tmp_path / "stubs"
    file.write_text(text.replace('<derived name="Lamp"/>', '<derived name="FB_Gate"/>'), "utf-8")
    assert main(["check", str(file)]) == 2
    assert "there is no type FB_Gate" in capsys.readouterr().err
    assert main(["check", str(file), "--stubs", str(stubs)]) == 0
    assert f"written: 1 interface in {stubs}" in capsys.readouterr().out
    written = (stubs / "FB_Gate.st").read_text("utf-8")
    assert "  Lit : BOOL;\n" in written
    assert main(["check", str(file), str(stubs)]) == 0
    (stubs / "FB_Gate.st").write_text(f"{written}(* mine *)\n", "utf-8")
    capsys.readouterr()
    assert main(["check", str(file), "--stubs", str(stubs)]) == 2
    assert "FB_Gate.st: already exists; nothing was written" in capsys.readouterr().err
    assert (stubs / "FB_Gate.st").read_text("utf-8").endswith("(* mine *)\n")
