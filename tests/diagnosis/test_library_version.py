"""FC_LibraryVersion, the exports and the changelog have the version of the Python package."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import pytest

from plc_bench import compiled
from rcx_harness.cell.exports import export
from rcx_tools.library.version import version, version_number
from structured_text.errors import InputError
from structured_text.export import TARGETS

_PROGRAM = """PROGRAM Versions
  VAR
    Part  : INT;
    Found : DINT;
  END_VAR

  Found := FC_LibraryVersion(Part := Part);
END_PROGRAM
"""


@pytest.mark.parametrize("engine", ["auto", "builtin"])
def test_the_function_returns_the_version_of_the_package(engine: str) -> None:
    """The version is one number: 0.1.0 is 100, because minor and patch have two digits each."""
    program = compiled(_PROGRAM, engine)
    found = []
    for scan, part in enumerate((0, 1, 2, 3, 4, -1)):
        program.write("Main.Part", part)
        program.scan(scan * 10_000)
        found.append(program.read("Main.Found"))
    major, minor, patch = map(int, metadata.version("rcx-harness").split("."))
    assert found == [major * 10_000 + minor * 100 + patch, major, minor, patch, -1, -1]


def test_pyproject_has_the_installed_version() -> None:
    assert version() == metadata.version("rcx-harness")


@pytest.mark.parametrize("text", ["1.0", "1.2.3.4", "1.100.0", "01.2.3", "1.2.3rc1", ""])
def test_an_invalid_version_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="is not of the form"):
        version_number(text)


@pytest.mark.parametrize("target", TARGETS)
def test_every_export_contains_its_version(target: str, tmp_path: Path) -> None:
    """Each export contains its version as text, so a user can read it in the PLC project."""
    (tmp_path / "Versions.st").write_text(_PROGRAM, encoding="utf-8")
    files = export(target, program=[tmp_path / "Versions.st"], only_needed=True).files
    said = f"Version {metadata.version('rcx-harness')}"
    assert any(said in text for text in files.values())
    assert any("FC_LibraryVersion" in text for text in files.values())
