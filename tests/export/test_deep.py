"""Deeply nested expressions are exported, or rejected with file and line."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.cell.exports import export
from rcx_harness.cli.app import main
from structured_text.errors import InputError
from structured_text.export import targets as module

_HEAD = "PROGRAM Own\nVAR InputArea, OutputArea : RCX_IMAGE; x, y : INT; END_VAR\n"


def _program(folder: Path, expression: str) -> Path:
    file = folder / "own.st"
    file.write_text(f"{_HEAD}\n  x := {expression};\nEND_PROGRAM\n", encoding="utf-8")
    return file


@pytest.mark.parametrize(("target", "depth"), [("scl", 400), ("plcopen", 400), ("l5x", 1_000)])
def test_calls_deep_inside_each_other_are_exported(target: str, depth: int, tmp_path: Path) -> None:
    """Thousands of nested calls are exported, although Python's default stack is too small.

    Source: docs/reference/limits.md, programs: calls may be nested 10,000 times.
    """
    file = _program(tmp_path, "ABS(" * depth + "y" + ")" * depth)
    output = export(target, program=[file], only_needed=True)
    assert any(text.count("ABS") >= depth for text in output.files.values())


def test_an_expression_that_is_too_deep_is_reported_with_its_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If an expression is too deep for the stack, the message has its line.

    Source: docs/reference/limits.md, programs.
    """

    def too_small(work: object) -> None:
        raise RecursionError

    monkeypatch.setattr(module, "deeply", too_small)
    file = _program(tmp_path, "ABS(" * 50 + "y" + ")" * 50)
    with pytest.raises(
        InputError, match=r"own\.st:4: too many operators, brackets or calls"
    ) as told:
        export("scl", program=[file], only_needed=True)
    assert told.value.hint == "assign parts of the expression to variables first"


def test_a_proof_reports_the_line_of_an_expression_that_is_too_deep(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`rcx prove` reports the line of an expression that is too deep.

    Source: docs/reference/limits.md.
    """
    pytest.importorskip("z3")
    file = _program(tmp_path, " + ".join(["y"] * 2_000))
    assert main(["prove", str(file), "--out", str(tmp_path)]) == 2
    assert "own.st:4: too many operators, brackets or calls inside each other" in (
        capsys.readouterr().err
    )
