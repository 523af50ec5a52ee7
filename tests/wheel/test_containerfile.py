"""The Containerfile copies what the wheel needs, and runs the steps of the template's CI.

No image is built here, because that needs a builder.

Source: docs/how-to/ci.md, in a container
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest


@pytest.fixture
def steps(repository: Path) -> list[tuple[str, str]]:
    """Return the instructions of the Containerfile with their arguments."""
    text = (repository / "Containerfile").read_text(encoding="utf-8")
    lines = re.sub(r"\\\n\s*", "", re.sub(r"^#.*\n", "", text, flags=re.MULTILINE)).splitlines()
    words = [line.partition(" ") for line in lines if line]
    return [(instruction, arguments) for instruction, _, arguments in words]


def _copied(steps: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the copied paths of the repository with their places."""
    found = []
    for instruction, arguments in steps:
        if instruction == "COPY" and not arguments.startswith("--from"):
            *sources, place = arguments.split()
            found += [(one, one if place == "./" else place) for one in sources]
    return found


def test_each_copied_path_exists(steps: list[tuple[str, str]], repository: Path) -> None:
    copied = _copied(steps)
    assert len(copied) == 6
    assert [source for source, _ in copied if not (repository / source).exists()] == []


def test_each_step_is_a_correct_shell_command(steps: list[tuple[str, str]]) -> None:
    commands = [arguments for instruction, arguments in steps if instruction == "RUN"]
    assert len(commands) == 6
    for command in commands:
        done = subprocess.run(["sh", "-n", "-c", command], capture_output=True, check=False)
        assert (done.returncode, done.stderr) == (0, b""), command


def test_it_runs_the_steps_of_the_templates_ci(
    steps: list[tuple[str, str]], repository: Path
) -> None:
    """The image already has what `pip install -r requirements.txt` installs."""
    template = repository / "harness/rcx_harness/new/template"
    script = (template / "dot_gitlab-ci.yml").read_text(encoding="utf-8")
    expected = re.findall(r"^    - ((?:rcx|pytest) .+)$", script, re.MULTILINE)
    assert len(expected) == 3
    (command,) = (json.loads(arguments) for name, arguments in steps if name == "CMD")
    assert command == ["sh", "-ec", "; ".join(expected)]
    requirements = (template / "requirements.txt").read_text(encoding="utf-8")
    extras = re.findall(r"^rcx-harness(\[.+\])==", requirements, re.MULTILINE)
    assert extras == ["[test,prove]"]
    assert sum(f'"$wheel{extras[0]}"' in arguments for _, arguments in steps) == 1


@pytest.mark.exhaustive
def test_the_copied_paths_are_enough_for_the_wheel(
    steps: list[tuple[str, str]], repository: Path, tmp_path: Path
) -> None:
    pytest.importorskip("hatchling", reason="needs hatchling")
    for source, place in _copied(steps):
        if (repository / source).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(repository / source, tmp_path / "some" / place, ignore=ignored)
        else:
            (tmp_path / "some").mkdir(exist_ok=True)
            shutil.copy(repository / source, tmp_path / "some" / place)
    names = []
    for folder in (repository, tmp_path / "some"):
        out = tmp_path / f"dist of {folder.name}"
        command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(out)]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        (wheel,) = out.glob("*.whl")
        with ZipFile(wheel) as archive:
            names.append({one for one in archive.namelist() if "__pycache__" not in one})
    assert names[0] == names[1]
