"""The wheel contains everything that a user without the repository needs.

By default it is built and unpacked beside the installed packages. With `pytest -m external`, pip
installs it into an empty environment, which needs a package index and some minutes.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import venv
from email import message_from_bytes
from importlib.metadata import version
from pathlib import Path
from shutil import which
from zipfile import ZipFile

import pytest

from structured_text.export import TARGETS

_FULL = pytest.mark.external(reason="needs a package index: pytest -m external tests/wheel")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel of the repository, built by its build tool."""
    pytest.importorskip("hatchling", reason="hatchling is missing: pip install -e '.[dev]'")
    folder = tmp_path_factory.mktemp("wheel")
    _call(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        Path(__file__).parents[2],
        dict(os.environ),
    )
    (built,) = folder.glob("*.whl")
    return built


def _call(command: list[str], folder: Path, environment: dict[str, str]) -> str:
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def _own(environment: dict[str, str]) -> dict[str, str]:
    """Return the environment without variables that make Python import from the repository."""
    return {
        name: value
        for name, value in environment.items()
        if not name.startswith(("PYTEST_", "RCX_", "PYTHONPATH"))
    }


def test_library_tables_and_template_are_in_it_as_in_the_repository(
    wheel: Path, repository: Path
) -> None:
    with ZipFile(wheel) as archive:
        held = {name: archive.read(name) for name in archive.namelist()}
    folders = {
        "plc/examples/01_power_up": "rcx_harness/_data/plc/examples/01_power_up",
        "plc/lib": "rcx_harness/_data/plc/lib",
        "spec": "rcx_harness/_data/spec",
        "harness/rcx_harness/new/template": "rcx_harness/new/template",
        "harness/rcx_harness/serve/page": "rcx_harness/serve/page",
    }
    for source, place in folders.items():
        expected = {
            f"{place}/{path.relative_to(repository / source).as_posix()}": path.read_bytes()
            for path in (repository / source).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
        assert len(expected) > 3, source
        assert {name: held[name] for name in held if name.startswith(place + "/")} == expected


def test_the_wheel_has_only_the_packages_that_users_need(wheel: Path) -> None:
    """Source: docs/explanation/architecture.md, the rooms."""
    with ZipFile(wheel) as archive:
        tops = {name.partition("/")[0] for name in archive.namelist()}
        told = archive.read(next(n for n in archive.namelist() if n.endswith("entry_points.txt")))
    assert {top for top in tops if not top.endswith(".dist-info")} == {
        "rcx_harness",
        "structured_text",
        "structured_text_names.py",
    }
    assert b"rcx_tools" not in told
    assert b"rcx-harness = rcx_harness.cli.start:main" in told, "for pipx run rcx-harness"


def test_both_packages_have_the_mark_that_they_are_typed(wheel: Path) -> None:
    """Source: PEP 561."""
    with ZipFile(wheel) as archive:
        assert {"rcx_harness/py.typed", "structured_text/py.typed"} <= set(archive.namelist())


def test_the_description_explains_each_extra_and_has_no_links(wheel: Path) -> None:
    """A relative link would lead nowhere on the page of a package index."""
    with ZipFile(wheel) as archive:
        name = next(one for one in archive.namelist() if one.endswith("METADATA"))
        metadata = message_from_bytes(archive.read(name))
    assert metadata["Description-Content-Type"] == "text/markdown"
    description = str(metadata.get_payload())
    assert "](" not in description
    extras = set(metadata.get_all("Provides-Extra", [])) - {"dev"}
    assert set(re.findall(r"^\| `(\w+)` \|", description, re.MULTILINE)) == extras


def test_the_page_about_extras_agrees_with_the_description(repository: Path) -> None:
    """Source: docs/reference/platforms.md, extras."""
    rows = [
        re.findall(r"^\| `\w+` \| .*", re.sub(r"\[(.*?)\]\(.*?\)", r"\1", text), re.MULTILINE)
        for text in (
            (repository / "harness/README.md").read_text(encoding="utf-8"),
            (repository / "docs/reference/platforms.md").read_text(encoding="utf-8"),
        )
    ]
    assert rows[0] == rows[1]
    assert len(rows[0]) == 8


@pytest.mark.skipif(which("git") is None, reason="needs git")
def test_a_tag_of_this_commit_names_the_version(repository: Path) -> None:
    """A commit without a tag has nothing to compare.

    Source: CONTRIBUTING.md, make a release
    """
    done = subprocess.run(
        ["git", "tag", "--points-at", "HEAD"],
        cwd=repository,
        capture_output=True,
        text=True,
        check=False,
    )
    tags = [tag for tag in done.stdout.split() if re.match(r"v\d", tag)]
    assert tags in ([], [f"v{version('rcx-harness')}"])


@pytest.mark.exhaustive
def test_without_the_repository_a_new_project_is_written_and_its_test_passes(
    wheel: Path, tmp_path: Path
) -> None:
    site = tmp_path / "site"
    with ZipFile(wheel) as archive:
        archive.extractall(site)
    environment = _own(dict(os.environ)) | {"PYTHONPATH": str(site)}
    _call([sys.executable, "-m", "rcx_harness", "new", "cell"], tmp_path, environment)
    cell = tmp_path / "cell"
    (cell / "tests" / "test_from.py").write_text(
        "import rcx_harness\n"
        "from rcx_harness.cell.sources import default_lib\n"
        "def test_library_comes_from_the_wheel():\n"
        f"    assert str(default_lib()).startswith({str(site)!r})\n"
        f"    assert rcx_harness.__file__.startswith({str(site)!r})\n"
    )
    command = [sys.executable, "-m", "pytest", "--assert=plain", "-pno:hypothesispytest"]
    command += ["-pno:xdist", "-k", "one_part or from_the_wheel", "--rcx-engine=builtin"]
    assert "2 passed" in _call(command, cell, environment)


@pytest.mark.exhaustive
def test_without_the_repository_the_demo_ends_as_in_the_readme(
    wheel: Path, repository: Path, tmp_path: Path
) -> None:
    site = tmp_path / "site"
    with ZipFile(wheel) as archive:
        archive.extractall(site)
    environment = _own(dict(os.environ)) | {"PYTHONPATH": str(site), "PYTHONUTF8": "1"}
    environment |= {"PATH": "", "COLUMNS": "100"}  # as the README: one engine, 100 columns
    printed = _call([sys.executable, "-m", "rcx_harness", "demo"], tmp_path, environment)
    last = "".join(printed.splitlines(keepends=True)[-3:])
    assert f"-->\n```text\n{last}```\n" in (repository / "README.md").read_text(encoding="utf-8")
    names = sorted(path.name for path in (tmp_path / "out" / "demo").iterdir())
    assert names == ["chart.svg", "trace.jsonl", "view.html", "wave.vcd"]


@_FULL
def test_installed_by_pip_into_an_empty_environment_all_commands_work(
    wheel: Path, tmp_path: Path
) -> None:
    environment = _own(dict(os.environ))
    venv.create(tmp_path / "venv", with_pip=True)
    programs = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    pip = [str(programs / "python"), "-m", "pip", "--disable-pip-version-check"]
    index = subprocess.run(
        [*pip, "download", "--no-deps", "-q", "-d", str(tmp_path), "iniconfig"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if index.returncode:
        pytest.skip(f"pip reaches no package index: {index.stderr.strip().splitlines()[-1]}")
    _call([*pip, "install", "-q", f"{wheel}[test,serve]", "pytest-html"], tmp_path, environment)
    rcx, cell = str(programs / "rcx"), tmp_path / "cell"
    _call([rcx, "new", "cell"], tmp_path, environment)
    pytest_in_it = [str(programs / "python"), "-m", "pytest"]
    assert "19 passed" in _call(pytest_in_it, cell, environment)
    assert "19 passed" in _call([*pytest_in_it, "-n", "2"], cell, environment)
    _call([rcx, "check", "plc"], cell, environment)
    named = ["--robot", "robot.toml", "--stimulus", "stimulus.toml", "--for", "2s"]
    _call([rcx, "run", "plc", *named], cell, environment)
    _call([rcx, "run", "plc", *named, "--link", "enip"], cell, environment)
    for target in TARGETS:
        options = ["--program", "plc", "--allow-missing", "-o", f"out/{target}"]
        _call([rcx, "export", target, *options], cell, environment)
    _call([rcx, "eds", "out/robot.eds"], cell, environment)
    _call([rcx, "encode", "MovePtp", "point=19"], cell, environment)
    _call([rcx, "demo"], cell, environment)
    _call([str(programs / "rcx-harness"), "demo", "-o", "out/again"], cell, environment)
    for command in ("serve", "scan", "new", "export"):
        _call([rcx, command, "--help"], cell, environment)
    failing = cell / "tests" / "test_failing.py"
    failing.write_text("def test_it(cell):\n    cell.run('1s')\n    assert False\n")
    failed = subprocess.run(
        [*pytest_in_it, str(failing), "--html=out/report.html"],
        cwd=cell,
        env=environment,
        capture_output=True,
        check=False,
    )
    assert failed.returncode == 1
    assert "&lt;svg" in (cell / "out" / "report.html").read_text(encoding="utf-8")
