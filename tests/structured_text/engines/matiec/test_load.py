from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.load import build
from structured_text.engines.matiec.build import MISSING, Matiec
from structured_text.errors import InputError


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "program.st"
    path.write_text("PROGRAM PROBE VAR N : INT; END_VAR N := N + 1; END_PROGRAM\n")
    return path


@pytest.fixture
def without_matiec(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("RCX_MATIEC", raising=False)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))


@pytest.mark.usefixtures("without_matiec")
def test_auto_falls_back_to_the_built_in_engine(program: Path) -> None:
    built = build([program])
    assert built.program.engine == "builtin"
    assert built.notice == ("matiec not found (RCX_MATIEC, PATH): running on the built-in engine")
    built.program.scan(0)
    assert built.program.read("Main.N") == 1


@pytest.mark.usefixtures("without_matiec")
def test_asking_for_a_missing_matiec_is_one_clear_error(program: Path) -> None:
    with pytest.raises(InputError) as caught:
        build([program], "matiec")
    assert str(caught.value) == MISSING + ", or use the built-in engine"


def test_auto_takes_matiec_where_it_is_found(program: Path, matiec: Matiec) -> None:
    built = build([str(program)])
    assert built.program.engine == "matiec"
    assert built.notice == ""


def test_matiec_without_a_c_compiler_is_named_as_such(
    program: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("lib/ieclib.txt", "lib/C/iec_std_lib.h", "iec2c"):
        path = tmp_path / "matiec" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
        path.chmod(0o755)
    monkeypatch.setenv("RCX_MATIEC", str(tmp_path / "matiec"))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    assert build([program]).notice.startswith("matiec found, but no C compiler (CC, cc, gcc")
    with pytest.raises(InputError, match="matiec found, but no C compiler"):
        build([program], "matiec")


def test_the_built_in_engine_can_be_chosen(program: Path) -> None:
    built = build([program], "builtin")
    assert (built.program.engine, built.notice) == ("builtin", "")


def test_an_unknown_engine_is_refused(program: Path) -> None:
    with pytest.raises(InputError, match="there is no engine 'plc'") as caught:
        build([program], "plc")
    assert caught.value.hint == "use auto, matiec, builtin, strucpp"


def test_an_error_in_the_sources_comes_with_file_and_line(tmp_path: Path) -> None:
    path = tmp_path / "wrong.st"
    path.write_text("PROGRAM PROBE\n  VAR N : INT; END_VAR\n  N := TRUE;\nEND_PROGRAM\n")
    with pytest.raises(InputError) as caught:
        build([path])
    assert (caught.value.file, caught.value.line) == (str(path), 3)
