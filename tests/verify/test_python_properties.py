"""An error in the Python code of a property never makes a run pass."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.verify.properties import from_python
from structured_text.errors import InputError
from structured_text.farm.farm import Farm

_HEAD = "import sys\nimport rcx_harness as rcx\n"
_PROGRAM = """PROGRAM Main
  VAR
    Count : INT;
    InputArea AT %IB0 : ARRAY [0..47] OF BYTE;
    OutputArea AT %QB0 : ARRAY [0..47] OF BYTE;
  END_VAR
  Count := Count + 1;
END_PROGRAM
"""
_RUN = ["run", "main.st", "--properties", "mine.py", "--for", "50ms", "--engine", "builtin"]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "main.st").write_text(_PROGRAM)
    return tmp_path


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("sys.exit(0)\n", 3, "SystemExit: 0"),
        ("sys.exit()\n", 3, "SystemExit"),
        ("raise SystemExit\n", 3, "SystemExit"),
        ("def f():\n    exit(0)\nf()\n", 4, "SystemExit: 0"),
        ("import unittest\nunittest.main(argv=['x'])\n", 4, "SystemExit"),
        ("raise KeyboardInterrupt\n", 3, "KeyboardInterrupt"),
        ("raise GeneratorExit\n", 3, "GeneratorExit"),
        ("def f():\n    f()\nf()\n", 4, "RecursionError: maximum recursion depth"),
        ("1 / 0\n", 3, "ZeroDivisionError: division by zero"),
        ("raise ValueError('\\x1b[2Jgone\\nand gone')\n", 3, r"\x1b[2Jgone and gone"),
        ("class E(Exception):\n    def __str__(self): return 1 / 0\nraise E\n", 5, "E: no text"),
        ("import gone_and_gone\n", 3, "ModuleNotFoundError"),
        ("def f(:\n", 3, "SyntaxError"),
        ("@rcx.eventually(within='soon')\ndef f(cell):\n    return True\n", 3, "soon"),
        ("sys.exit = lambda code: None\nraise ValueError('no')\n", 4, "ValueError: no"),
    ],
)
@pytest.mark.parametrize("relative", [True, False])
def test_a_file_that_raises_is_bad_input_at_its_line(
    here: Path, text: str, line: int, message: str, relative: bool
) -> None:
    """An exception in a file of properties is bad input, reported with file and line.

    Source: a defect report: sys.exit(0) in such a file gives exit code 2.
    """
    file = Path("mine.py") if relative else here / "mine.py"
    file.write_text(_HEAD + text)
    exits = sys.exit
    with pytest.raises(InputError) as raised:
        from_python(file)
    assert str(raised.value).startswith(f"{file}:{line}: ")
    assert message in str(raised.value)
    assert str(raised.value).isprintable()
    assert raised.value.exit_code == 2
    assert sys.exit is exits, "the command ends with this code"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("sys.exit(0)", "SystemExit: 0; return True or False"),
        ("raise SystemExit(0)", "SystemExit: 0"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("return f(cell)", "RecursionError"),
        ("return cell['Main.Nothing']", "has no member Nothing"),
        ("cell['Main.Count'] >= 0", "a property returns NoneType, not bool"),
        ("return cell['Main.Count']", "a property returns int, not bool"),
        ("return 'no'", "a property returns str, not bool"),
        ("yield False", "a property returns generator, not bool"),
    ],
)
def test_a_property_that_gives_no_answer_is_bad_input_at_its_line(
    here: Path, capsys: pytest.CaptureFixture[str], body: str, message: str
) -> None:
    """Source: a defect report."""
    (here / "mine.py").write_text(f"{_HEAD}@rcx.always\ndef f(cell):\n    {body}\n")
    assert main(_RUN) == 2
    said = capsys.readouterr().err
    assert message in said
    line = 3 if "returns" in message else 5
    assert said.startswith(f"rcx: mine.py:{line}: f: ")
    assert said.count("\n") == 1


def test_true_and_false_are_answers(here: Path) -> None:
    (here / "mine.py").write_text(f"{_HEAD}@rcx.always\ndef f(cell):\n    return True\n")
    assert main(_RUN) == 0
    (here / "mine.py").write_text(
        f"{_HEAD}@rcx.always\ndef f(cell):\n    return cell['Main.Count'] < 3\n"
    )
    assert main(_RUN) == 1


def _leaves(item: int) -> int:
    raise SystemExit(item)


def test_an_item_of_a_farm_that_calls_exit_is_an_error() -> None:
    """An item of work that calls sys.exit is an error.

    In this process it would end the command with any exit code.
    """
    with pytest.raises(RuntimeError, match="SystemExit"):
        list(Farm(0).run(_leaves, [0]))
