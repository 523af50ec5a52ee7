"""`rcx new` writes a project that works without changes, and never overwrites a file."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

from editor import Editor
from rcx_harness.cli.app import main
from rcx_harness.new import CI
from rcx_harness.robot import RobotConfig

Captured = pytest.CaptureFixture[str]

#: Plugins that the inner run omits, because loading them takes longer than the run itself.
_PLAIN = [f"-pno:{name}" for name in ("cacheprovider", "xdist", "hypothesispytest")]


_CELL = "plc --robot robot.toml --properties campaign.toml"
#: Commands of the README that verify the cell, with options that make them fast here.
_VERIFY = {
    "pytest --rcx-coverage": (),
    f"rcx campaign {_CELL} --seeds 100": (
        *("--seeds", "1", "--workers", "0", "--engine", "builtin"),
    ),
    f"rcx sweep {_CELL} --stimulus stimulus.toml --for 3s": (
        *("--every", "100", "--workers", "0", "--engine", "builtin"),
    ),
    "rcx mutants plc --fail-under 90 -- pytest": (),
    "rcx explore plc --properties campaign.toml --scan 1s --bound 2000": ("--bound", "50"),
    "rcx prove plc": (),
    "rcx debug --vscode ~/.vscode/extensions/rcx": (),
}
#: Commands with tests of their own in this file.
_TESTED_SEPARATELY = ("pytest", "rcx mutants")


def _files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_the_tests_of_a_new_project_pass(pytester: pytest.Pytester) -> None:
    """The tests of a new project pass, and execute every statement and branch of its program.

    Normal run, emergency stop, alarm and loss of the link have a test file each.
    """
    assert main(["new", "."]) == 0
    options = ("--rcx-engine=builtin", "--rcx-coverage", "--rcx-cover-fail-under=100")
    result = pytester.runpytest_inprocess(*_PLAIN, *options, "-v")
    assert result.ret == pytest.ExitCode.OK
    result.assert_outcomes(passed=19)
    for name in ("normal_run", "emergency_stop", "alarm", "link_loss"):
        result.stdout.fnmatch_lines([f"tests/test_{name}.py::*PASSED*"])


@pytest.mark.exhaustive
def test_its_tests_pass_with_areas_of_256_bytes(pytester: pytest.Pytester) -> None:
    assert main(["new", ".", "--size", "256"]) == 0
    result = pytester.runpytest_inprocess(*_PLAIN, "--rcx-engine=builtin", "-k", "one_part")
    result.assert_outcomes(passed=1, deselected=18)


@pytest.mark.exhaustive
def test_the_tests_of_a_new_project_detect_an_automatic_restart(
    pytester: pytest.Pytester,
) -> None:
    """If the program of a new project restarts by itself, one test of the project fails."""
    assert main(["new", "."]) == 0
    program = Path("plc/PickAndPlace.st")
    source = program.read_text(encoding="utf-8")
    changed = source.replace("IF Acknowledge THEN", "IF CellSafe THEN")
    assert changed != source
    program.write_text(changed, encoding="utf-8")
    result = pytester.runpytest_inprocess(*_PLAIN, "--rcx-engine=builtin", "-k", "acknowledge")
    result.assert_outcomes(failed=1, deselected=18)


def test_a_misspelt_key_of_its_pytest_ini_is_refused(pytester: pytest.Pytester) -> None:
    assert main(["new", "."]) == 0
    with Path("pytest.ini").open("a", encoding="utf-8") as file:
        file.write("test_paths = tests\n")
    result = pytester.runpytest_inprocess(*_PLAIN, "--rcx-engine=builtin", "--collect-only", "-q")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*Unknown config option: test_paths*"])


def test_its_program_is_portable_and_runs_from_the_command_line(
    tmp_path: Path, capsys: Captured
) -> None:
    folder = tmp_path / "cell"
    assert main(["new", str(folder)]) == 0
    assert main(["check", "--lint", str(folder / "plc")]) == 0
    capsys.readouterr()
    named = [f"--{name}={folder / name}.toml" for name in ("robot", "stimulus")]
    assert main(["run", str(folder / "plc"), *named, "--engine=builtin", "--for=3s"]) == 0
    assert "4 remote commands, no violations" in capsys.readouterr().out


def test_the_readme_has_one_line_for_each_command(tmp_path: Path) -> None:
    assert main(["new", str(tmp_path / "cell")]) == 0
    text = (tmp_path / "cell/README.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `((?:rcx|pytest) [^`]*)` \| .+ \|$", text, re.MULTILINE) == [*_VERIFY]


@pytest.mark.exhaustive(
    but=[
        "rcx explore plc --properties campaign.toml --scan 1s --bound 2000",
        "rcx debug --vscode ~/.vscode/extensions/rcx",
    ]
)
@pytest.mark.parametrize(
    "command", [one for one in _VERIFY if not one.startswith(_TESTED_SEPARATELY)]
)
def test_each_of_them_ends_with_0_in_a_new_project(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    if command == "rcx prove plc":
        pytest.importorskip("z3", reason="needs the extra prove")
    monkeypatch.chdir(tmp_path)
    for home in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(home, str(tmp_path / "home"))
    assert main(["new", "."]) == 0
    words = [os.path.expanduser(word) for word in command.split()[1:]]
    assert main([*words, *_VERIFY[command]]) == 0


@pytest.mark.exhaustive
def test_mutants_of_a_new_project_are_tried_with_its_tests(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    """`rcx mutants` works in a new project. The option `--minutes 0` ends it early."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    assert main(["new", "."]) == 0
    quick = ["--fail-under", "0", "--minutes", "0", "--workers", "1"]
    assert main(["mutants", "plc", *quick, "--", "pytest", "-k", "one_part"]) == 0
    assert "NOT RUN YET (the next call continues)" in capsys.readouterr().out


def test_the_configurations_of_its_launch_json_can_be_debugged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "."]) == 0
    text = Path(".vscode/launch.json").read_text(encoding="utf-8")
    good, recording = json.loads(text.replace("${workspaceFolder}", tmp_path.as_posix()))[
        "configurations"
    ]
    assert recording["recording"] == "${input:recording}"
    editor = Editor()
    try:
        editor.start(**good)
        assert editor.stack()[0][0] == "Main (PickAndPlace)"
    finally:
        editor.close()


def test_it_prints_its_files_and_the_next_three_commands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my cell"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert {line.strip() for line in lines[: lines.index("")][:-1]} == _files(tmp_path / "my cell")
    assert lines[-4:] == [
        "next:",
        '  cd "my cell"',
        "  pytest",
        "  rcx run plc --robot robot.toml --stimulus stimulus.toml --for 5s --show",
    ]


def test_where_pytest_is_missing_its_installation_comes_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    monkeypatch.setattr("rcx_harness.cli.new.find_spec", lambda name: None)
    assert main(["new", str(tmp_path / "cell")]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()[-3:]]
    assert lines[0] == f"cd {tmp_path / 'cell'}"
    assert lines[1].startswith("pip install pytest ")
    assert lines[2] == "pytest"


def test_name_and_version_stand_in_it_and_no_mark_of_the_template_is_left(tmp_path: Path) -> None:
    assert main(["new", str(tmp_path / "one")]) == 0
    assert main(["new", str(tmp_path / "two"), "--name", "Press 4"]) == 0
    assert (tmp_path / "one" / "README.md").read_text().startswith("# one\n")
    assert (tmp_path / "two" / "README.md").read_text().startswith("# Press 4\n")
    for path in (tmp_path / "two").rglob("*"):
        if path.is_file():
            assert not re.search(r"@[A-Z]+@", path.read_text(encoding="utf-8")), path
    assert re.search(r"==\d+\.\d+", (tmp_path / "one" / "requirements.txt").read_text())


@pytest.mark.parametrize("ci", sorted(CI))
def test_one_ci_system_leaves_the_files_of_the_others_out(tmp_path: Path, ci: str) -> None:
    assert main(["new", str(tmp_path / "all")]) == 0
    assert main(["new", str(tmp_path / ci), "--ci", ci]) == 0
    assert _files(tmp_path / "all") - _files(tmp_path / ci) == set(CI.values()) - {CI[ci]}


@pytest.mark.parametrize("ci", sorted(CI))
def test_each_ci_file_installs_checks_tests_and_keeps_the_charts(tmp_path: Path, ci: str) -> None:
    assert main(["new", str(tmp_path / ci), "--ci", ci]) == 0
    text = (tmp_path / ci / CI[ci]).read_text(encoding="utf-8")
    commands = (
        "pip install -r requirements.txt",
        "rcx check plc",
        "pytest --junitxml=out/junit.xml --rcx-coverage",
        "rcx campaign plc --robot robot.toml --properties campaign.toml --seeds 30",
    )
    places = [text.index(command) for command in commands]
    assert places == sorted(places)
    assert re.search(r"(artifact|archiveArtifacts)[^#]*\bout/", text), "out/failed is inside out/"
    assert "\t" not in text
    assert ("windows-latest" in text) is (ci == "github")
    assert "out/failed" in (tmp_path / ci / "pytest.ini").read_text(encoding="utf-8")


def test_a_folder_with_files_is_refused_and_stays_as_it_is(
    tmp_path: Path, capsys: Captured
) -> None:
    (tmp_path / "pytest.ini").write_text("mine")
    assert main(["new", str(tmp_path)]) == 2
    assert capsys.readouterr().err == (
        f"rcx: {tmp_path}: is not empty: pytest.ini; nothing was written; "
        "name a folder that is new or empty\n"
    )
    assert _files(tmp_path) == {"pytest.ini"}
    assert (tmp_path / "pytest.ini").read_text() == "mine"


@pytest.mark.parametrize("model", ["YK400XE", "YK1200XG", "SXYX"])
def test_a_named_robot_reaches_both_points(tmp_path: Path, model: str) -> None:
    """With a robot type in robot.toml, the robot still reaches both points.

    The `robot` line comes before the tables, and the points are within the soft limits.
    """
    assert main(["new", str(tmp_path / "cell"), "--robot", model]) == 0
    config = RobotConfig.load(tmp_path / "cell" / "robot.toml")
    assert config.robot == (model,)
    for number in (1, 2):
        data = config.points[number].data
        for axis, place in zip(config.axes, data, strict=False):
            assert axis.soft_low < place < axis.soft_high


def test_an_empty_repository_is_taken(tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    (tmp_path / ".git" / "HEAD").write_text("ref: refs/heads/main\n")
    assert main(["new", str(tmp_path), "--name", "cell"]) == 0
    assert (tmp_path / ".git" / "HEAD").read_text() == "ref: refs/heads/main\n"
    assert (tmp_path / "pytest.ini").is_file()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["--ci", "travis"],
            "there is no template for 'travis'; use github, gitlab, jenkins or all",
        ),
        (["--robot", "YK4"], "there is no robot 'YK4'; use YK400XE, YK400XEC, YK510XEC"),
        (["--size", "47"], "an area of 47 bytes does not exist"),
        (["--name", "<b>"], "'<b>' is not a name for a cell; give --name"),
        (["--name", ""], "'' is not a name for a cell; give --name"),
    ],
)
def test_a_wrong_option_is_one_message_and_nothing_is_written(
    tmp_path: Path, capsys: Captured, options: list[str], message: str
) -> None:
    assert main(["new", str(tmp_path / "cell"), *options]) == 2
    assert capsys.readouterr().err.startswith(f"rcx: {message}")
    assert not (tmp_path / "cell").exists()


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path, capsys: Captured) -> None:
    (tmp_path / "cell").write_text("mine")
    assert main(["new", str(tmp_path / "cell")]) == 2
    assert "is a file; name a folder that is new or empty" in capsys.readouterr().err
    assert main(["new", str(tmp_path / "cell" / "below")]) == 2
    assert "cannot be written: Not a directory" in capsys.readouterr().err
