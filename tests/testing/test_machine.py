"""`rcx_machine` lets hypothesis run a cell at random, and reports the shortest failure."""

from __future__ import annotations

from pathlib import Path

import pytest

from feeder import feeder
from rcx_harness.cli.app import main

_TEST = """
from hypothesis import Phase

def test_feeder(rcx_machine):
    rcx_machine("campaign.toml", max_examples=40, stateful_step_count=10, derandomize=True,
                database=None, phases=(Phase.generate,))
"""


def _project(pytester: pytest.Pytester, **bugs: bool) -> None:
    feeder(pytester.path, **bugs)
    pytester.makepyfile(test_it=_TEST)
    pytester.makeini(
        "[pytest]\nrcx_sources = Feeder.st\nrcx_engine = builtin\nrcx_artifacts = out\n"
    )


@pytest.mark.exhaustive
def test_a_cell_that_keeps_what_is_demanded_passes(pytester: pytest.Pytester) -> None:
    _project(pytester)
    pytester.runpytest_subprocess().assert_outcomes(passed=1)


@pytest.mark.exhaustive
def test_a_failing_run_is_written_and_replayed(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    _project(pytester, runs_open=True)
    result = pytester.runpytest_subprocess()
    result.assert_outcomes(failed=1)
    replay = pytester.path / "out" / "test_it" / "test_feeder" / "replay.toml"
    assert replay.read_text().startswith("# rcx replay: always closed at ")
    program = str(Path(pytester.path / "Feeder.st"))
    assert main(["run", program, "--engine", "builtin", "--stimulus", str(replay)]) == 1
    assert "expect: NOT (Main.Running AND NOT Main.Closed)" in capsys.readouterr().out
