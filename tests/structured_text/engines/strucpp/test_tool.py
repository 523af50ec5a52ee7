"""The installation of STruC++ is found and its messages are read.

The tests use stand-in scripts.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.load import build, why_not
from structured_text.engines.strucpp.build import Strucpp, find_strucpp
from structured_text.errors import InputError


def _executable(path: Path, body: str = "exit 0") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return path


def _rest(folder: Path, headers: str) -> tuple[Path, Path]:
    """Create the files of an installation besides the compiler: standard blocks and headers."""
    blocks, include = folder / "libs" / "iec-standard-fb.stlib", folder / headers
    for path in (blocks, include / "iec_std_lib.hpp"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    return blocks, include


@pytest.fixture(autouse=True)
def _nothing_installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("RCX_STRUCPP", raising=False)
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    monkeypatch.setenv("RCX_CACHE", "off")


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "program.st"
    path.write_text("PROGRAM PROBE\n  VAR N : INT; END_VAR\n  N := N + 1;\nEND_PROGRAM\n")
    return path


def _install(monkeypatch: pytest.MonkeyPatch, folder: Path, body: str, compiler: str = "") -> None:
    """Install shell scripts in place of STruC++ and a C++ compiler."""
    _executable(folder / "strucpp", body)
    _rest(folder, "runtime/include")
    monkeypatch.setenv("RCX_STRUCPP", str(folder))
    monkeypatch.setenv("CXX", str(_executable(folder / "cxx", compiler)))
    monkeypatch.setenv("PATH", "/usr/bin:/bin")


def test_a_machine_without_strucpp_finds_no_strucpp() -> None:
    assert find_strucpp() is None
    assert why_not("strucpp") == "STruC++ not found: set RCX_STRUCPP or PATH"


def test_asking_for_a_missing_strucpp_is_one_clear_error(program: Path) -> None:
    with pytest.raises(InputError) as caught:
        build([program], "strucpp")
    assert str(caught.value) == why_not("strucpp") + ", or use the built-in engine"


def test_a_release_is_found_on_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    binary = _executable(tmp_path / "release" / "strucpp")
    blocks, headers = _rest(tmp_path / "release", "runtime/include")
    for name in ("RCX_STRUCPP", "PATH"):
        with monkeypatch.context() as patch:
            patch.setenv(name, str(tmp_path / "release"))
            assert find_strucpp() == Strucpp((str(binary),), blocks, headers)
    assert why_not("strucpp") == "STruC++ not found: set RCX_STRUCPP or PATH"


def test_built_sources_are_run_by_node(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    script = _executable(tmp_path / "source" / "dist" / "node" / "cli.js")
    blocks, headers = _rest(tmp_path / "source", "src/runtime/include")
    monkeypatch.setenv("RCX_STRUCPP", str(tmp_path / "source"))
    with pytest.raises(InputError, match="needs node, which is not found"):
        find_strucpp()
    node = _executable(tmp_path / "bin" / "node")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    assert find_strucpp() == Strucpp((str(node), str(script)), blocks, headers)
    assert why_not("strucpp") == "STruC++ found, but no C++ compiler: set CXX or PATH"


def test_a_wrong_rcx_strucpp_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RCX_STRUCPP", str(tmp_path))
    with pytest.raises(InputError, match="has neither strucpp nor dist/node"):
        find_strucpp()
    _executable(tmp_path / "strucpp")
    with pytest.raises(InputError, match="has neither runtime/include nor libs/iec-standard-fb"):
        find_strucpp()


@pytest.mark.parametrize(
    ("said", "place", "message"),
    [
        ("part0.st:3:5: error: Undeclared 'x'.", ("program.st", 3, 5), "STruC++: Undeclared 'x'"),
        (
            "part0.st:0:0: error: unexpected character: ->#<- at offset: 39, skipped 1 characters.",
            ("program.st", 3, 3),
            "STruC++: unexpected character: ->#<- at offset: 39, skipped 1 characters",
        ),
        ("no library", ("program.st", None, None), "STruC++ failed with status 1 and said: no lib"),
    ],
)
def test_a_refusal_of_strucpp_has_the_users_line(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    program: Path,
    said: str,
    place: tuple[str, int | None, int | None],
    message: str,
) -> None:
    """A message of STruC++ is reported with the line in the user's file.

    Source: docs/CLI.md of STruC++, Error Output.
    """
    _install(monkeypatch, tmp_path / "own", f"cat >&2 <<'END'\n\n{said}\nEND\nexit 1")
    with pytest.raises(InputError) as caught:
        build([program], "strucpp")
    assert (Path(str(caught.value.file)).name, caught.value.line, caught.value.column) == place
    assert caught.value.message.startswith(message)


def test_a_refusal_of_the_cxx_compiler_has_the_users_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, program: Path
) -> None:
    refusal = "echo 'iec.hpp:9:1: error: no match\n  part0.st:3:2: required from here' >&2; exit 1"
    _install(monkeypatch, tmp_path / "own", "exit 0", refusal)
    with pytest.raises(InputError) as caught:
        build([program], "strucpp")
    assert (caught.value.file, caught.value.line) == (str(program), 3)
    assert caught.value.message == (
        "the C++ compiler refuses what STruC++ made of the program: no match"
    )
    assert "--engine builtin" in caught.value.hint
