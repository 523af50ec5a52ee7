"""`rcx export st` writes the library as one file. Names are declared before their use."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from example_runs import EXAMPLES
from exported import comments, shapes, written
from mistakes import check
from rcx_harness.cell.exports import export, sources_of
from rcx_harness.cli.app import main
from structured_text.engines.load import build
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.export.output import Output, write
from structured_text.export.parts import Sources
from structured_text.language.load import load
from structured_text.output.exported import MARK

Captured = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def single(whole: bool, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of the exported sample."""
    (file,) = write(written("st", whole=whole), tmp_path_factory.mktemp("st") / "rcx3.st")
    return file


@pytest.fixture(scope="module")
def original(sources: Sources) -> list[Path]:
    """Return the source files of the exported sample."""
    return list(dict.fromkeys(part.file for part in sources.parts))


def test_the_file_declares_the_whole_library(single: Path, original: list[Path]) -> None:
    assert check([single]) == []
    assert shapes([single]) == shapes(original)
    assert set(comments(original)) <= set(comments([single]))
    assert "SPDX-License-Identifier: MIT" in single.read_text()[:300]


def test_names_are_declared_before_their_use(sources: Sources) -> None:
    names = {part.name for part in sources.parts}
    known: set[str] = set()
    for part in sources.parts:
        code = re.sub(r"\(\*.*?\*\)|'[^']*'", " ", part.text, flags=re.DOTALL)
        used = set(re.findall(r"\w+", code)) & names - {part.name}
        assert used <= known, part.name
        known.add(part.name)


def test_matiec_compiles_the_exported_file(tmp_path: Path) -> None:
    if find_matiec() is None or find_c_compiler() is None:
        pytest.skip("matiec not found: set RCX_MATIEC or PATH")
    (file,) = write(export("st", program=[EXAMPLES[0].folder]), tmp_path / "one.st")
    build([file], "matiec").program.close()


def test_an_existing_file_is_kept_without_force(tmp_path: Path, capsys: Captured) -> None:
    out = tmp_path / "mine.st"
    out.write_text("mine")
    arguments = ["export", "st", "--program", str(EXAMPLES[0].folder), "--needed", "-o", str(out)]
    assert main(arguments) == 2
    assert capsys.readouterr().err == f"rcx: {out}: already exists; use --force to overwrite it\n"
    assert out.read_text() == "mine"
    assert main([*arguments, "--force"]) == 2
    said = f"rcx: {out}: was not written by an export; nothing was written; move it away\n"
    assert capsys.readouterr().err == said
    assert out.read_text() == "mine"
    out.write_text("")
    assert main([*arguments, "--force"]) == 0
    assert capsys.readouterr().out == f"written: {out}\n"
    assert main(arguments) == 2
    assert main([*arguments, "--force"]) == 0
    assert capsys.readouterr().out == f"written: {out}\n"
    assert "PROGRAM PowerUp" in out.read_text()
    assert "FB_ReadTorqueOfMax" not in out.read_text(), "the block is not needed"
    load([out])


def test_an_input_is_never_written_over(tmp_path: Path, capsys: Captured) -> None:
    mine = tmp_path / "PowerUp.st"
    for file in EXAMPLES[0].folder.glob("*.st"):
        (tmp_path / file.name).write_text(file.read_text())
    before = mine.read_text()
    program = ["--program", str(tmp_path), "--needed"]
    assert main(["export", "st", *program, "-o", str(mine), "--force"]) == 2
    assert "would be overwritten, but it is an input" in capsys.readouterr().err
    assert mine.read_text() == before


def test_several_files_are_written_together_or_not_at_all(tmp_path: Path) -> None:
    (tmp_path / "b").write_text(MARK)
    with pytest.raises(InputError, match="already exists"):
        write(Output({"a": "1", "b": "2"}), tmp_path)
    assert not (tmp_path / "a").exists()
    assert write(Output({"a": "1", "b": "2"}), tmp_path, force=True) == [
        tmp_path / "a",
        tmp_path / "b",
    ]


def test_a_folder_and_a_file_do_not_replace_each_other(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="name a file"):
        write(Output({"": "1"}), tmp_path, force=True)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError) as caught:
        write(Output({"a": "1"}), tmp_path / "file", force=True)
    assert str(caught.value) == f"{tmp_path / 'file'}: is a file; name a folder"
    with pytest.raises(InputError, match="/file: is a file; name a folder"):
        write(Output({"a": "1", "file/b": "2"}), tmp_path, force=True)
    assert not (tmp_path / "a").exists()
    assert (tmp_path / "file").read_text() == "mine"


def test_an_unknown_target_is_refused_with_the_known_targets(capsys: Captured) -> None:
    assert main(["export", "ladder"]) == 2
    assert "there is no target 'ladder'; use st, plcopen" in capsys.readouterr().err


def test_the_option_needed_requires_a_program(capsys: Captured) -> None:
    assert main(["export", "st", "--needed"]) == 2
    assert "name it with --program" in capsys.readouterr().err


def test_sources_with_an_error_are_not_exported(tmp_path: Path, capsys: Captured) -> None:
    file, out = tmp_path / "Bad.st", tmp_path / "out.st"
    file.write_text(
        "FUNCTION_BLOCK Bad\n  VAR\n    a : INT;\n  END_VAR\n  a := b;\nEND_FUNCTION_BLOCK\n"
    )
    assert main(["export", "st", "--needed", "--program", str(file), "-o", str(out)]) == 2
    assert f"{file}:5:" in capsys.readouterr().err
    assert not out.exists()


def test_comments_and_types_of_a_users_file_keep_their_places(tmp_path: Path) -> None:
    file = tmp_path / "Mine.st"
    file.write_text(
        "(* head *)\nTYPE\n  (* first *)\n  MINE_A : INT; (* one *)\n"
        "  MINE_B : STRUCT\n    a, b : INT; (* both *)\n    (* own line *)\n    c : INT;\n"
        "    (* at the end *)\n  END_STRUCT;\nEND_TYPE\n"
        "FUNCTION_BLOCK FB_Mine\n  VAR_INPUT\n    x : INT; (* of x *)\n    (* last *)\n  END_VAR\n"
        "  (* sections *)\n  VAR\n    y : INT;\n  END_VAR\n  (* body *)\n  y := x;\n"
        "END_FUNCTION_BLOCK\n(* tail *)\n"
    )
    parts = {part.name: part for part in sources_of(program=[file], only_needed=True).parts}
    assert set(parts) == {"MINE_A", "MINE_B", "FB_Mine"}
    assert parts["MINE_A"].header == "head"
    assert parts["MINE_B"].notes == {"B": "both", "C": "own line\nat the end"}
    assert parts["FB_Mine"].notes == {"X": "of x\nlast", "Y": "sections"}
    assert parts["FB_Mine"].header == "tail"
    assert parts["FB_Mine"].body == "  (* body *)\n  y := x;"
    assert {part.folder for part in parts.values()} == {"program"}
