"""The hooks for pre-commit and the action for GitHub run on a new project.

Source: docs/how-to/ci.md
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cli.app import main

yaml = pytest.importorskip("yaml", reason="needs PyYAML")
Captured = pytest.CaptureFixture[str]

_FAULTY = "PROGRAM P\n  VAR\n    a : INT;\n  END_VAR\n  a := TRUE;\nEND_PROGRAM\n"


def _loaded(file: Path) -> Any:
    return yaml.safe_load(file.read_text(encoding="utf-8"))


@pytest.fixture
def cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a small program, which is the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my plc").mkdir()
    program = "PROGRAM P\n  VAR\n    a : INT; b : DINT;\n  END_VAR\n  b := a;\nEND_PROGRAM\n"
    (tmp_path / "my plc" / "Main.st").write_text(program, encoding="utf-8")
    return tmp_path


def test_the_hooks_have_what_pre_commit_requires(repository: Path) -> None:
    """Source: pre-commit.com, creating new hooks."""
    hooks = _loaded(repository / ".pre-commit-hooks.yaml")
    assert [hook["id"] for hook in hooks] == ["rcx-check", "rcx-format"]
    for hook in hooks:
        assert {"name", "entry", "language"} <= hook.keys()
        assert hook["language"] == "python"
        pattern = re.compile(hook["files"])
        assert pattern.search("plc/Main.st")
        assert not pattern.search("plc/Main.stl")
        assert not pattern.search("README.md")


@pytest.mark.parametrize("number", [0, 1])
def test_the_entry_of_each_hook_runs(cell: Path, repository: Path, number: int) -> None:
    """A hook ends with 0 for good files, and not with 0 for a faulty program."""
    hook = _loaded(repository / ".pre-commit-hooks.yaml")[number]
    command, *words = shlex.split(hook["entry"])[1:]
    files = ["my plc/Main.st"] if hook.get("pass_filenames", True) else []
    call = [command, *words, *hook.get("args", []), *files]
    main(call)  # a formatter may change the file, and report it
    assert main(call) == 0
    (cell / "my plc" / "Main.st").write_text(_FAULTY.replace("END_VAR", ""), encoding="utf-8")
    assert main(call) != 0


def _step(repository: Path, cell: Path, **inputs: str) -> subprocess.CompletedProcess[str]:
    """Run the last step of the action as GitHub does, with the inputs in its environment."""
    action = _loaded(repository / "action.yml")
    step = action["runs"]["steps"][-1]
    given = {name: entry["default"] for name, entry in action["inputs"].items()} | inputs
    expressions = {f"${{{{ inputs.{name} }}}}": value for name, value in given.items()}
    own = {name: expressions[value] for name, value in step["env"].items()}
    programs = cell / "programs"
    programs.mkdir(exist_ok=True)
    rcx = programs / "rcx"
    rcx.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m rcx_harness "$@"\n', encoding="utf-8")
    rcx.chmod(0o755)
    environment = {**os.environ, **own, "PATH": f"{programs}:{os.environ['PATH']}"}
    shell = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
    return subprocess.run(
        shell, cwd=cell, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.exhaustive
def test_the_action_checks_and_writes_sarif(cell: Path, repository: Path) -> None:
    """The names of files may contain a blank, and each line of the input is a name."""
    (cell / "more").mkdir()
    (cell / "more" / "F.st").write_text(
        "FUNCTION F : INT\n  F := 1;\nEND_FUNCTION\n", encoding="utf-8"
    )
    done = _step(repository, cell, files="my plc\nmore\n", sarif="out/it.sarif")
    assert (done.returncode, done.stderr) == (0, "")
    assert "2 files checked" in done.stdout
    log = json.loads((cell / "out/it.sarif").read_text(encoding="utf-8"))
    assert log["version"] == "2.1.0"


@pytest.mark.exhaustive
def test_the_inputs_for_and_strict_reach_the_command(cell: Path, repository: Path) -> None:
    """The implicit conversion of the program may be refused by Logix."""
    assert _step(repository, cell, **{"for": "rockwell"}).returncode == 0
    assert _step(repository, cell, **{"for": "rockwell", "strict": "true"}).returncode == 1
    (cell / "my plc" / "Main.st").write_text(_FAULTY, encoding="utf-8")
    assert _step(repository, cell).returncode == 2


def test_a_wrong_value_of_strict_fails(cell: Path, repository: Path) -> None:
    done = _step(repository, cell, strict="yes")
    assert (done.returncode, done.stderr) == (2, "strict is yes; write true or false\n")


def test_an_installed_rcx_is_used(cell: Path, repository: Path) -> None:
    """The first step installs nothing if the job has installed `rcx`."""
    step = _loaded(repository / "action.yml")["runs"]["steps"][0]
    programs = cell / "programs"
    programs.mkdir()
    (programs / "rcx").write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
    (programs / "rcx").chmod(0o755)
    path = f"{programs}:{os.environ['PATH']}"
    own = {"PATH": path, "RUNNER_TEMP": str(cell / "temp"), "SOURCE": str(cell)}
    done = subprocess.run(
        ["bash", "-eo", "pipefail", "-c", step["run"]], env=own, capture_output=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    assert not (cell / "temp").exists()


@pytest.mark.exhaustive
def test_the_hooks_of_a_new_project_pass_and_change_nothing(
    cell: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["new", "new cell"]) == 0
    monkeypatch.chdir("new cell")
    files = sorted(Path("plc").glob("*.st"))
    before = [file.read_bytes() for file in files]
    (repository,) = _loaded(Path(".pre-commit-config.yaml"))["repos"]
    check, layout = repository["hooks"]
    assert main(shlex.split(check["entry"])[1:]) == 0
    assert "files checked" in capsys.readouterr().out
    assert all(re.search(layout["files"], file.as_posix()) for file in files)
    assert main([*shlex.split(layout["entry"])[1:], *map(str, files)]) == 0
    assert [file.read_bytes() for file in files] == before
