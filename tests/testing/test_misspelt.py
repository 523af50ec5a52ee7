"""Misspelt ini keys and rules, and numbers without a unit, are refused and not ignored."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness.testing.settings import RULES

Run = Callable[..., pytest.RunResult]

_EMPTY = "def test_it():\n    pass\n"
_ROBOTT = "there is no setting rcx_robott; did you mean rcx_robot"


def _refused(result: pytest.RunResult, message: str) -> None:
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert [line for line in result.errlines if line] == [f"ERROR: rcx: {message}"]
    assert "Traceback" not in result.stdout.str()


def test_a_misspelt_key_of_the_ini_file_ends_the_run(run: Run, pytester: pytest.Pytester) -> None:
    ini = pytester.path / "pytest.ini"
    _refused(run(_EMPTY, robott="robot.toml"), f"{ini}: {_ROBOTT}")
    dashed = f"{ini}: there is no setting rcx-robot; did you mean rcx_robot"
    pytester.makefile(".ini", pytest="[pytest]\nrcx-robot = robot.toml\n")
    _refused(pytester.runpytest_inprocess("-pno:cacheprovider"), dashed)


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("pyproject.toml", '[tool.pytest.ini_options]\nrcx_robott = "robot.toml"\n'),
        ("tox.ini", "[pytest]\nrcx_robott = robot.toml\n"),
        ("setup.cfg", "[tool:pytest]\nrcx_robott = robot.toml\n"),
    ],
)
def test_a_misspelt_key_ends_the_run_in_every_file_that_pytest_reads(
    pytester: pytest.Pytester, file: str, text: str
) -> None:
    (pytester.path / file).write_text(text, encoding="utf-8")
    pytester.makepyfile(test_it=_EMPTY)
    result = pytester.runpytest_inprocess("-pno:cacheprovider")
    _refused(result, f"{pytester.path / file}: {_ROBOTT}")


def test_a_misspelt_key_on_the_command_line_ends_the_run(run: Run) -> None:
    _refused(run(_EMPTY, "-o", "rcx_robott=robot.toml"), _ROBOTT)


def test_a_key_that_is_near_to_none_is_answered_with_all(run: Run) -> None:
    result = run(_EMPTY, zzzzzzzz="1")
    assert "there is no setting rcx_zzzzzzzz; use rcx_engine, " in result.stderr.str()


def test_keys_of_other_plugins_and_of_the_users_conftest_stay_possible(
    run: Run, pytester: pytest.Pytester
) -> None:
    pytester.makeconftest(
        "def pytest_addoption(parser):\n    parser.addini('rcx_mine', 'mine', default=None)\n"
    )
    run(_EMPTY, mine="1").assert_outcomes(passed=1)
    pytester.makefile(".ini", pytest="[pytest]\nothers_robott = 1\n")
    result = pytester.runpytest_inprocess("-pno:cacheprovider")
    result.assert_outcomes(passed=1, warnings=1)


def test_a_rule_that_does_not_exist_is_an_error_of_the_test_that_allows_it(run: Run) -> None:
    wrong = {
        '"intervall"': "there is no rule 'intervall'; did you mean interval",
        '"interval", "reservd"': "there is no rule 'reservd'; did you mean reserved",
        '"zzz"': "there is no rule 'zzz'; the rules are: interval, start against stop, reserved, "
        "data before code, command held, ready before code, contract, calls, ready-first, "
        "hold-command",
        '["interval"]': "there is no rule [[]'interval'[]]; the rules are: interval, *",
        'rule="interval"': "@pytest.mark.allow_violations takes names of rules, not rule=; "
        'write it as @pytest.mark.allow_violations("interval")',
    }
    tests = [
        f"@pytest.mark.allow_violations({marker})\ndef test_{number}({fixture}):\n    pass\n"
        for number, marker in enumerate(wrong)
        for fixture in ("cell" if number else "",)
    ]
    result = run("import pytest\n" + "".join(tests))
    result.assert_outcomes(errors=len(wrong))
    result.stdout.fnmatch_lines([f"rcx: {message}" for message in wrong.values()])
    assert "Traceback" not in result.stdout.str()


def test_every_rule_that_is_reported_can_be_allowed(run: Run, repository: Path) -> None:
    """Every rule that can be reported as broken can also be allowed.

    The names of the rules are those that monitor, contract and controller give to `Violation`.

    Source: the source code of these modules
    """
    package = repository / "harness" / "rcx_harness"
    monitor = (package / "watch" / "wire.py").read_text(encoding="utf-8")
    contract = (package / "watch" / "contract.py").read_text(encoding="utf-8")
    calls = (package / "watch" / "calls.py").read_text(encoding="utf-8")
    robot = "".join(path.read_text("utf-8") for path in sorted((package / "robot").glob("*.py")))
    quoted = r'"([a-z -]+)"'
    found = {
        "monitor": re.findall(rf"found\.append\(\s*\(\s*{quoted},", monitor),
        "contract": re.findall(rf"Violation\(t_us, {quoted},", contract),
        "calls": re.findall(rf"Violation\(t_us, {quoted},", calls),
        "robot": re.findall(rf"findings\.add\(\s*[\w.]+,\s*{quoted},", robot),
    }
    assert {who: set(rules) for who, rules in found.items()} == {
        who: set(rules) for who, rules in RULES.items()
    }
    assert sum(text.count("Violation(") for text in (monitor, contract, robot)) == 3
    assert robot.count("findings.add(") == len(found["robot"])
    assert monitor.count("found.append(") == len(found["monitor"])
    every = ", ".join(f'"{rule}"' for rules in RULES.values() for rule in rules)
    test = f"import pytest\n@pytest.mark.allow_violations({every})\n{_EMPTY}"
    run(test).assert_outcomes(passed=1)
