"""The programs of the tutorial run as its pages say."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from rcx_harness import Cell
from rcx_tools.docs import pages as docs

_FIRST = docs.ROOT / "docs/tutorial/first"
_TESTS = runpy.run_path(str(_FIRST / "tests/test_first_program.py"))


def _cell(program: list[Path]) -> Cell:
    return Cell.build(program, robot=_FIRST / "robot.toml", engine="builtin")


@pytest.mark.parametrize("name", [name for name in _TESTS if name.startswith("test_")])
def test_the_tests_of_the_third_part_pass(name: str) -> None:
    """Source: docs/tutorial/3-first-test.md."""
    with _cell(sorted((_FIRST / "plc").glob("*.st"))) as cell:
        _TESTS[name](cell)
        assert cell.violations == []


def test_a_test_fails_if_the_program_moves_to_a_point_that_does_not_exist(tmp_path: Path) -> None:
    """Source: docs/tutorial/3-first-test.md, "Watch it fail"."""
    text = (_FIRST / "plc/Main.st").read_text(encoding="utf-8")
    (tmp_path / "Main.st").write_text(text.replace("Point := 1", "Point := 2"), encoding="utf-8")
    with (
        _cell([tmp_path / "Main.st", _FIRST / "plc/Config.st"]) as cell,
        pytest.raises(Exception, match="not within 5000 ms"),
    ):
        _TESTS["test_start_moves_the_robot_to_point_1"](cell)


def test_the_second_program_is_the_first_one_with_the_lines_of_the_page() -> None:
    """Source: docs/tutorial/2-break-a-rule.md."""
    page = (docs.ROOT / "docs/tutorial/2-break-a-rule.md").read_text(encoding="utf-8")
    added = page.partition("```iecst\n")[2].partition("```")[0]
    first = (_FIRST / "plc/Main.st").read_text(encoding="utf-8").partition("PROGRAM ")[2]
    broken = (docs.ROOT / "docs/tutorial/broken/plc/Main.st").read_text(encoding="utf-8")
    wanted = first.replace("END_PROGRAM", f"\n{added}END_PROGRAM").replace("First", "Broken", 1)
    assert broken.partition("PROGRAM ")[2] == wanted


def test_the_readme_is_short() -> None:
    assert len((docs.ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120
