from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.matiec.build import Matiec, Message, TranslationError, find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError


def _executable(path: Path, body: str = "exit 0") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return path


def _library(folder: Path, headers: Path | None = None) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "ieclib.txt").write_text("")
    headers = headers or folder / "C"
    headers.mkdir(parents=True, exist_ok=True)
    (headers / "iec_std_lib.h").write_text("")


@pytest.fixture(autouse=True)
def _nothing_installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("RCX_MATIEC", raising=False)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    monkeypatch.setattr("structured_text.engines.matiec.build.PACKAGED", ())


def test_a_machine_without_matiec_finds_no_matiec() -> None:
    assert find_matiec() is None
    assert find_c_compiler() is None


def test_rcx_matiec_names_a_build_tree(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    binary = _executable(tmp_path / "matiec" / "iec2c")
    _library(tmp_path / "matiec" / "lib")
    monkeypatch.setenv("RCX_MATIEC", str(tmp_path / "matiec"))
    library = tmp_path / "matiec" / "lib"
    assert find_matiec() == Matiec(binary, library, library / "C")


def test_rcx_matiec_goes_before_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("one", "two"):
        _executable(tmp_path / name / "iec2c")
        _library(tmp_path / name / "lib")
    monkeypatch.setenv("RCX_MATIEC", str(tmp_path / "two"))
    monkeypatch.setenv("PATH", str(tmp_path / "one"))
    found = find_matiec()
    assert found is not None
    assert found.iec2c == tmp_path / "two" / "iec2c"


@pytest.mark.parametrize("place", ["lib/matiec", "share/matiec/lib", "share/matiec", "lib"])
def test_an_installation_under_a_prefix_is_found_on_path(
    place: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    _executable(tmp_path / "bin" / "iec2c")
    _library(tmp_path / place)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    found = find_matiec()
    assert found is not None
    assert found.library == tmp_path / place


def test_openplc_has_its_headers_elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    server = tmp_path / "webserver"
    _executable(server / "iec2c")
    _library(server / "lib", headers=server / "core" / "lib")
    monkeypatch.setenv("RCX_MATIEC", str(server))
    found = find_matiec()
    assert found is not None
    assert found.headers == server / "core" / "lib"


def test_a_wrong_rcx_matiec_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RCX_MATIEC", str(tmp_path))
    with pytest.raises(InputError, match="RCX_MATIEC has no iec2c in it") as caught:
        find_matiec()
    assert "the directory that holds iec2c and lib" in caught.value.hint


def test_a_missing_library_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    _executable(tmp_path / "bin" / "iec2c")
    monkeypatch.setenv("RCX_MATIEC", str(tmp_path / "bin"))
    with pytest.raises(InputError, match=r"has no library: neither ieclib.txt nor"):
        find_matiec()


def test_cc_names_the_c_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    _executable(tmp_path / "bin" / "gcc")
    own = _executable(tmp_path / "own-cc")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    assert find_c_compiler() == str(tmp_path / "bin" / "gcc")
    monkeypatch.setenv("CC", str(own))
    assert find_c_compiler() == str(own)


_FAILING = """
echo 'program.st:3-7..3-9: error: Data type mismatch.' >&2
echo 'program.st:5-1..8-17: error while generating C code: No task!' >&2
echo 'timer.txt:80-5..80-13: error: invalid variable.' >&2
echo 'program.st:9-1..9-2: warning: not an error.' >&2
"""


@pytest.mark.parametrize(("end", "status"), [("exit 1", 1), ("kill -SEGV $$", -11)])
def test_a_failing_iec2c_gives_its_messages(end: str, status: int, tmp_path: Path) -> None:
    binary = _executable(tmp_path / "iec2c", _FAILING + end)
    _library(tmp_path / "lib")
    matiec = Matiec(binary, tmp_path / "lib", tmp_path / "lib" / "C")
    source = tmp_path / "program.st"
    source.write_text("")
    with pytest.raises(TranslationError) as caught:
        matiec.translate(source, tmp_path)
    assert caught.value.status == status
    assert caught.value.messages == [Message("Data type mismatch", 3, 7), Message("No task", 5, 1)]
