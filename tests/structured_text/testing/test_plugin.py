"""The toolkit's part of the pytest plugin works without the harness."""

from __future__ import annotations

import pytest

from structured_text.errors import COMMAND

_ALONE = ["-pno:rcx", "-pstructured_text.testing.plugin", "-pno:xdist", "-pno:cacheprovider"]
_TEST = """
    from pathlib import Path
    from structured_text.engines.builtin import BuiltinProgram
    from structured_text.language.load import load

    def test_it():
        program = BuiltinProgram.build(load([Path("Main.st")]))
        program.scan(0)
        assert program.read("Main.n") == 1
"""
_PROGRAM = """PROGRAM Main
  VAR n : INT; END_VAR
  n := n + 1;
  IF n > 10 THEN
    n := 0;
  END_IF;
END_PROGRAM
"""


@pytest.mark.exhaustive
def test_without_the_plugin_of_the_harness_coverage_is_counted(pytester: pytest.Pytester) -> None:
    """The toolkit's plugin counts coverage without the plugin of rcx_harness.

    Two of three statements are executed, the IF and one assignment.

    Source: docs/how-to/testing.md.
    """
    pytester.makepyfile(_TEST)
    (pytester.path / "Main.st").write_text(_PROGRAM)
    result = pytester.runpytest_subprocess(*_ALONE, f"--{COMMAND}-coverage")
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines([f"*{COMMAND} coverage*", "*Main.st*2*3*"])


def test_without_the_harness_a_misspelt_setting_is_refused(pytester: pytest.Pytester) -> None:
    """The toolkit's plugin alone refuses a misspelt setting and proposes the right name.

    Source: docs/how-to/testing.md, the settings.
    """
    pytester.makeini(f"[pytest]\n{COMMAND}_coverag = true\n")
    result = pytester.runpytest_subprocess(*_ALONE)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    said = f"*there is no setting {COMMAND}_coverag*{COMMAND}_coverage*"
    result.stderr.fnmatch_lines([said])
