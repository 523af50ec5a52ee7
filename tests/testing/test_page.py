"""docs/how-to/testing.md is complete, and its examples pass."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.testing import LISTS, OPTIONS, VALUES
from rcx_harness.testing.settings import RULES
from structured_text.testing import COVERAGE

_PLAIN = [f"-pno:{name}" for name in ("cacheprovider", "xdist", "hypothesispytest")]


@pytest.fixture
def page(repository: Path) -> str:
    return (repository / "docs/how-to/testing.md").read_text(encoding="utf-8")


def test_every_option_and_every_key_is_in_the_page_and_no_other(page: str) -> None:
    options = {f"--rcx-{name.replace('_', '-')}" for name in (*OPTIONS, *COVERAGE)}
    assert set(re.findall(r"--rcx-[\w-]+", page)) == options
    keys = {f"rcx_{name}" for name in (*OPTIONS, *COVERAGE, *LISTS, *VALUES)}
    others = {"rcx_build", "rcx_harness", "rcx_chart", "rcx_trace", "rcx_view", "rcx_recording"}
    assert set(re.findall(r"\brcx_[a-z_]+\b", page)) == keys | others


def test_every_option_of_coverage_is_in_its_page_and_no_other(repository: Path) -> None:
    text = (repository / "docs/how-to/coverage.md").read_text(encoding="utf-8")
    options = {name.replace("_", "-") for name in COVERAGE}
    assert set(re.findall(r"--rcx-(cover[\w-]+)", text)) == options
    assert set(re.findall(r"`--(cover[\w-]+)`", text)) == options
    assert set(re.findall(r"`rcx_(cover\w+)\b", text)) == set(COVERAGE)


def test_every_rule_that_can_be_allowed_is_in_the_page_and_no_other(page: str) -> None:
    table = page.partition("| Rule | Broken by |")[2].partition("\n\n")[0]
    shown = re.findall(r"^\| `([^`]+)` \|", table, re.MULTILINE)
    assert sorted(shown) == sorted({rule for some in RULES.values() for rule in some})


_MOTOR = """
PROGRAM Motor
  VAR Start : BOOL; Motor : BOOL; END_VAR
  Motor := Start;
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM Main WITH Cyclic : Motor;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.mark.exhaustive
def test_the_examples_of_the_page_pass_in_a_new_project(
    page: str, pytester: pytest.Pytester
) -> None:
    assert main(["new", "."]) == 0
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 4
    Path("motor.st").write_text(_MOTOR, encoding="utf-8")
    for number, block in enumerate(blocks):
        Path(f"tests/test_page_{number}.py").write_text(block, encoding="utf-8")
    result = pytester.runpytest_inprocess(*_PLAIN, "--rcx-engine=builtin", "-k", "test_page")
    result.assert_outcomes(passed=5, deselected=19)
