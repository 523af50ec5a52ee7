"""The robot programs in the pages are read without an error."""

from __future__ import annotations

import re

import pytest

from plc_bench import ROOT
from rcx_harness.robot.program import read_program
from rcx_harness.robot.program.checks import problems
from rcx_harness.robot.program.words import words
from rcx_tools.docs.robot_language import robot_language_page


@pytest.mark.parametrize(
    "page", ["docs/how-to/robot-program.md", "docs/reference/robot-language.md"]
)
def test_the_program_of_a_page_has_no_error(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    program, *_ = re.findall(r"```text\n(.*?)```", text, re.DOTALL)
    read, errors = read_program(program)
    assert errors == []
    assert read is not None
    assert problems(read, 48) == []


def test_the_page_lists_each_statement_with_its_source() -> None:
    page = robot_language_page()
    for word in words().values():
        assert f"`{word.form or word.name}`" in page
        assert word.source in ("guide", "public", "assumed")
