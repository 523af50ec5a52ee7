"""The plugin does not disturb projects that have it installed but do not use it."""

from __future__ import annotations

from collections.abc import Callable

import pytest

Run = Callable[..., pytest.RunResult]


def test_without_settings_nothing_of_the_harness_is_loaded_and_nothing_printed(
    pytester: pytest.Pytester,
) -> None:
    pytester.makepyfile("""
        import sys
        def test_it():
            ours = ("rcx_harness", "structured_text")
            loaded = sorted(name for name in sys.modules if name.startswith(ours))
            parts = ("", ".testing", ".testing.plugin")
            expected = [f"{name}{part}" for name in ours for part in parts]
            expected += ["structured_text.errors", "structured_text_names"]
            assert loaded == sorted(expected)
            assert "typer" not in sys.modules and "cpppo" not in sys.modules
        """)
    result = pytester.runpytest_subprocess("-p", "no:xdist", "-p", "no:hypothesispytest")
    result.assert_outcomes(passed=1)
    assert not [line for line in result.outlines if line.startswith("rcx")]


def test_fixtures_of_the_project_win_over_those_of_the_plugin(
    run: Run, pytester: pytest.Pytester
) -> None:
    pytester.makeconftest("""
        import pytest
        @pytest.fixture
        def cell():
            return "a cell of a table"
        @pytest.fixture
        def robot():
            return "a toy"
        """)
    result = run(
        "def test_it(cell, robot):\n    assert (cell, robot) == ('a cell of a table', 'a toy')"
    )
    result.assert_outcomes(passed=1)


def test_a_project_may_extend_cell(run: Run, pytester: pytest.Pytester) -> None:
    pytester.makeconftest("""
        import pytest
        @pytest.fixture
        def cell(cell):
            cell.run("1s")
            return cell
        """)
    result = run(
        "def test_it(cell, robot):\n    assert cell.now_us == 1_000_000 and robot is cell.robot"
    )
    result.assert_outcomes(passed=1)


def test_options_and_markers_are_documented(pytester: pytest.Pytester) -> None:
    help_text = pytester.runpytest_inprocess("--help").stdout.str()
    for option in ("engine", "link", "seed", "scan", "robot", "artifacts"):
        assert f"--rcx-{option}" in help_text
        assert f"rcx_{option} " in help_text
    markers = pytester.runpytest_inprocess("--markers").stdout.str()
    assert "@pytest.mark.rcx(" in markers
    assert "@pytest.mark.allow_violations(" in markers
