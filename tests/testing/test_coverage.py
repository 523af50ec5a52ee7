"""`pytest --rcx-coverage` reports the parts of the user's sources that the tests execute."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines import load as engines
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec import faults
from structured_text.engines.matiec.program import MatiecProgram

#: A program with 4 statements, 2 branches and 1 condition. Line 6 runs if Start is TRUE.
_LAMP = """\
PROGRAM Lamp
  VAR Start, Lit : BOOL; InputArea, OutputArea : ARRAY [0..47] OF BYTE; END_VAR
  VAR Count : INT; Block : FB_Blink; END_VAR
  Lit := FALSE;
  IF Start THEN
    Lit := TRUE;
  END_IF;
  Block(Run := Start);
END_PROGRAM
"""

#: A block of the project's library.
_BLINK = """\
FUNCTION_BLOCK FB_Blink
  VAR_INPUT Run : BOOL; END_VAR
  VAR Runs : INT; END_VAR
  Runs := Runs + 1;
END_FUNCTION_BLOCK
"""

_OTHER = """\
PROGRAM Other
  VAR k : INT; InputArea, OutputArea : ARRAY [0..47] OF BYTE; END_VAR
  k := k + 1;
END_PROGRAM
"""

_DARK = "def test_dark(cell):\n    cell.scan(3)\n    assert not cell['Main.Lit']\n"
_LIT = "def test_lit(cell):\n    cell['Main.Start'] = True\n    cell.scan()\n"

_PLAIN = [f"-pno:{name}" for name in ("cacheprovider", "hypothesispytest")]

Run = Callable[..., pytest.RunResult]


@pytest.fixture
def run(pytester: pytest.Pytester) -> Run:
    """Return a function that runs the tests of a project with coverage.

    With workers, the run has its own process.
    """
    for name, text in {"plc/Lamp.st": _LAMP, "lib/FB_Blink.st": _BLINK, "other.st": _OTHER}.items():
        file = pytester.path / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)

    def run(test: str, *options: str, workers: int = 0, **ini: str) -> pytest.RunResult:
        keys = {"sources": "plc/*.st", "lib": "lib"} | ini
        lines = [f"rcx_{name} = {value}" for name, value in keys.items()]
        pytester.makefile(".ini", pytest="\n".join(["[pytest]", *lines]))
        pytester.makepyfile(test_it=test)
        if workers:
            return pytester.runpytest_subprocess(*_PLAIN, "-n", str(workers), *options)
        return pytester.runpytest_inprocess(*_PLAIN, "-pno:xdist", *options)

    return run


def _table(result: pytest.RunResult) -> list[str]:
    """Return the rows below the table's head, with single spaces."""
    lines = [re.sub(" +", " ", line) for line in result.outlines]
    start = next(k for k, line in enumerate(lines) if line.startswith("file "))
    return lines[start + 1 : lines.index("", start)]


def test_the_tests_of_a_run_count_together(run: Run) -> None:
    result = run(_DARK, "--rcx-coverage")
    assert _table(result) == ["plc/Lamp.st 75.0 % 3/4 50.0 % 1/2 0.0 % 0/1 6"]
    result = run(_DARK + _LIT, "--rcx-coverage")
    assert _table(result) == ["plc/Lamp.st 100.0 % 4/4 100.0 % 2/2 100.0 % 1/1"]
    result.stdout.fnmatch_lines(
        [
            "coverage of statements and branches: 100.0 %",
            "written: out/coverage/index.html, out/coverage/coverage.lcov, *coverage.xml",
        ]
    )
    # The lamp was lit in 1 of 3 + 1 scans.
    assert {"DA:4,4", "DA:6,1"} <= {*Path("out/coverage/coverage.lcov").read_text().splitlines()}


def test_several_programs_count_together(run: Run) -> None:
    other = "@pytest.mark.rcx(sources='other.st')\ndef test_other(cell):\n    cell.scan()\n"
    result = run(f"import pytest\n{_DARK}{other}", "--rcx-coverage")
    assert _table(result) == [
        "other.st 100.0 % 1/1 - -",
        "plc/Lamp.st 75.0 % 3/4 50.0 % 1/2 0.0 % 0/1 6",
        "all 80.0 % 4/5 50.0 % 1/2 0.0 % 0/1",
    ]


@pytest.mark.exhaustive
def test_the_workers_of_xdist_count_together(run: Run) -> None:
    """The counts of the workers of xdist are added.

    Each worker runs one test, and MC/DC needs both tests.
    """
    result = run(_DARK + _LIT, "--rcx-coverage", workers=2)
    assert _table(result) == ["plc/Lamp.st 100.0 % 4/4 100.0 % 2/2 100.0 % 1/1"]
    assert "DA:4,4" in Path("out/coverage/coverage.lcov").read_text().splitlines()


@pytest.mark.exhaustive
def test_the_counts_of_a_dead_worker_are_reported_as_missing(run: Run) -> None:
    dies = "import os\ndef test_dies(cell):\n    cell.scan()\n    os._exit(3)\n"
    result = run(dies + _DARK, "--rcx-coverage", "--max-worker-restart=1", workers=1)
    result.stdout.fnmatch_lines(["worker gw0 died: its counts are missing"])
    assert _table(result) == ["plc/Lamp.st 75.0 % 3/4 50.0 % 1/2 0.0 % 0/1 6"]
    assert "gw1 died" not in result.stdout.str()


def test_a_run_fails_if_less_is_covered_than_required(run: Run) -> None:
    """If less is covered than required, the run fails with the exit code of failed tests.

    4 of 6 statements and branches are 66.6 %.
    """
    result = run(_DARK, "--rcx-coverage", "--rcx-cover-fail-under", "66.7")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(
        ["coverage of statements and branches: 66.6 %, FAIL: at least 66.7 % is demanded"]
    )
    result = run(_DARK, "--rcx-coverage", "--rcx-cover-fail-under", "66.6")
    assert result.ret == pytest.ExitCode.OK
    assert run(_DARK, coverage="true", cover_fail_under="70").ret == pytest.ExitCode.TESTS_FAILED
    assert run(_DARK, cover_fail_under="70").ret == pytest.ExitCode.OK, "no statement is counted"


def test_nothing_counted_is_not_enough(run: Run) -> None:
    result = run("def test_it(): pass", "--rcx-coverage", "--rcx-cover-fail-under=1")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["nothing was counted: no program with statements was built"])
    assert not Path("out").exists()


@pytest.mark.exhaustive
def test_the_library_counts_only_where_it_is_asked_for(run: Run) -> None:
    result = run(_DARK, "--rcx-coverage", "--rcx-coverage-library")
    assert _table(result)[0] == "lib/FB_Blink.st 100.0 % 1/1 - -"
    assert len(_table(run(_DARK, "--rcx-coverage"))) == 1
    assert len(_table(run(_DARK, coverage="yes", coverage_library="on"))) > 1


def test_a_source_that_changes_while_tests_run_is_reported(run: Run) -> None:
    changes = "def test_change(rcx_build):\n    rcx_build().scan()\n"
    changes += "    with open('plc/Lamp.st', 'a') as file: file.write('(* more *)')\n"
    changes += "    rcx_build().scan()\n"
    result = run(changes, "--rcx-coverage")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["plc/Lamp.st was changed since it was compiled: run again"])


def test_pages_of_an_earlier_run_go_and_others_stay(run: Run) -> None:
    run(_DARK, "--rcx-coverage", "--rcx-coverage-library", "--rcx-coverage-out=report")
    Path("report/mine.html").write_text("<html>mine</html>")
    assert Path("report/lib-FB_Blink.html").is_file()
    run(_DARK, coverage="true", coverage_out="report")
    assert sorted(file.name for file in Path("report").iterdir()) == [
        *("coverage.lcov", "coverage.xml", "index.html", "mcdc.lcov", "mine.html"),
        "plc-Lamp.html",
    ]


@pytest.mark.parametrize(
    ("options", "ini", "message"),
    [
        (
            ["--rcx-cover-fail-under=90"],
            {},
            "rcx: --rcx-cover-fail-under: no coverage is counted; add --rcx-coverage",
        ),
        (["--rcx-coverage-out=x"], {}, "rcx: --rcx-coverage-out: no coverage *"),
        (
            ["--rcx-coverage", "--rcx-cover-fail-under=much"],
            {},
            "rcx: --rcx-cover-fail-under is much; give a percentage from 0 to 100",
        ),
        (
            ["--rcx-coverage"],
            {"cover_fail_under": "101"},
            "rcx: rcx_cover_fail_under is 101; give a percentage from 0 to 100",
        ),
        ([], {"coverage": "maybe"}, "rcx: rcx_coverage is 'maybe'; write true or false"),
        (
            ["--rcx-coverage", "--rcx-engine=strucpp"],
            {},
            "rcx: coverage is counted by the built-in engine; leave out *",
        ),
        (
            ["--rcx-coverage", "--rcx-coverage-out=other.st"],
            {},
            "rcx: *other.st: is not a folder; *",
        ),
        (["--rcx-coverage", "--rcx-coverage-out=taken"], {}, "rcx: *index.html: already exists*"),
        ([], {"coverige": "true"}, "rcx: *there is no setting rcx_coverige; *rcx_coverage*"),
    ],
)
def test_a_wrong_setting_is_one_message_before_any_test(
    run: Run, options: list[str], ini: dict[str, str], message: str
) -> None:
    Path("taken").mkdir()
    Path("taken/index.html").write_text("<html>mine</html>")
    result = run(_DARK, *options, **ini)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: {message}"])
    assert Path("taken/index.html").read_text() == "<html>mine</html>"


def test_a_report_that_cannot_be_written_is_one_message(run: Run) -> None:
    """A report that cannot be written gives one message.

    The file in its place appears during the run.
    """
    blocks = "    open('out', 'w').close()\n"
    result = run(_DARK + blocks, "--rcx-coverage")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert re.search(r"^rcx: .*out.coverage.*: cannot be written: ", result.stdout.str(), re.M)
    assert "Traceback" not in result.stdout.str()


def test_a_run_on_another_engine_is_reported_as_not_counted(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A test that runs on an engine without coverage is not refused but reported as not counted."""
    monkeypatch.setattr(engines, "find_matiec", object)
    monkeypatch.setattr(engines, "find_c_compiler", lambda: "cc")
    monkeypatch.setattr(faults, "is_new", lambda _: True)
    monkeypatch.setattr(MatiecProgram, "build", lambda project, *_: BuiltinProgram.build(project))
    demands = "import pytest\n@pytest.mark.rcx(engine='matiec')\ndef test_matiec(cell): pass\n"
    result = run(demands + _DARK, "--rcx-coverage")
    result.assert_outcomes(passed=2)
    result.stdout.fnmatch_lines(["not counted: the matiec engine counts no coverage"])
    result = run(_DARK, "--rcx-coverage")
    assert "not counted" not in result.stdout.str(), "--engine auto selects the engine that counts"
    result.stdout.fnmatch_lines(["rcx-harness *: engine builtin (it counts coverage), *"])
