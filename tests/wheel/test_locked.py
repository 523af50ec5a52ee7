"""The files in requirements/ lock the packages that `make` installs, for each Python version.

They contain the version and the hashes of each package.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement

from structured_text.output.toml_files import load_toml

_PYTHONS = ("3.10", "3.11", "3.12", "3.13")
_ENTRY = re.compile(
    r"(?P<pin>[\w.-]+==[^ ;]+(?: ; .+?)?)(?P<hashes>(?: +--hash=sha256:[0-9a-f]{64})+)"
)


def _entries(file: Path) -> list[str]:
    """Return the entries of a requirements file, each on one line, without comments."""
    lines = file.read_text(encoding="utf-8").replace("\\\n", "").splitlines()
    return [line for line in lines if line and not line.lstrip().startswith("#")]


def _pins(file: Path, python: str) -> dict[str, str]:
    """Return a dictionary of package names to the versions that are locked for this Python."""
    environment = {"python_version": python, "python_full_version": f"{python}.9"}
    found: dict[str, str] = {}
    for entry in _entries(file):
        one = Requirement(entry.partition(" --hash")[0])
        if one.marker is None or one.marker.evaluate(environment):
            assert one.name not in found, f"{one.name} twice for Python {python}"
            found[one.name] = next(iter(one.specifier)).version
    return found


def _asked(pyproject: dict[str, Any], extra: str = "dev") -> list[Requirement]:
    """Return all requirements in pyproject.toml: to build, to run, and those of the named extra."""
    project = pyproject["project"]
    asked = [*pyproject["build-system"]["requires"], *project["dependencies"]]
    extras = [extra]
    for name in extras:
        for text in project["optional-dependencies"][name]:
            one = Requirement(text)
            if one.name == project["name"]:
                extras += one.extras
            else:
                asked.append(text)
    return [Requirement(text) for text in asked]


@pytest.mark.parametrize("name", ["build.txt", "dev.txt", "site.txt"])
def test_every_entry_is_one_version_with_its_hashes_and_names_no_index(
    repository: Path, name: str
) -> None:
    entries = _entries(repository / "requirements" / name)
    assert len(entries) > 5
    for entry in entries:
        assert _ENTRY.fullmatch(entry), entry[:80]
    assert "://" not in (repository / "requirements" / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("python", _PYTHONS)
def test_the_locked_versions_match_the_pyproject(repository: Path, python: str) -> None:
    """Each dependency in pyproject.toml is locked at a version in its range.

    If this test fails after a change of a dependency, run `make lock`.
    """
    pins = _pins(repository / "requirements/dev.txt", python)
    environment = {"python_version": python, "python_full_version": f"{python}.9"}
    for one in _asked(load_toml(repository / "pyproject.toml")):
        if one.marker is None or one.marker.evaluate(environment):
            assert one.name in pins, f"{one} is not in requirements/dev.txt: run `make lock`"
            assert one.specifier.contains(pins[one.name]), f"{one}, locked {pins[one.name]}"


@pytest.mark.parametrize("python", _PYTHONS)
def test_the_build_tools_are_locked_to_the_same_versions(repository: Path, python: str) -> None:
    folder = repository / "requirements"
    build, every = _pins(folder / "build.txt", python), _pins(folder / "dev.txt", python)
    assert {name: every[name] for name in build} == build
    assert set(_entries(folder / "build.in")) <= set(build)


def test_the_lock_is_for_every_python_that_the_package_takes(repository: Path) -> None:
    makefile = (repository / "Makefile").read_text(encoding="utf-8")
    requires = load_toml(repository / "pyproject.toml")["project"]["requires-python"]
    assert f"--python-version {_PYTHONS[0]} " in makefile
    assert requires == f">={_PYTHONS[0]}"
