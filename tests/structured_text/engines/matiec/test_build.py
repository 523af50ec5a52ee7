from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.matiec.build import Matiec, RefusedCodeError, Wanted, compile_program
from structured_text.engines.native.toolchain import find_c_compiler

WANTED = Wanted(instances=("MAIN",), globals=(), layout=("sizeof(PROBE)",))


def _text(step: int) -> str:
    return f"""
PROGRAM PROBE VAR N : INT; END_VAR N := N + {step}; END_PROGRAM
CONFIGURATION PLANT
  RESOURCE CPU ON PLC
    TASK CYCLE(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM Main WITH CYCLE : PROBE;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("RCX_CACHE", raising=False)
    return tmp_path / "rcx-harness"


@pytest.fixture
def compiler(matiec: Matiec) -> str:
    found = find_c_compiler()
    assert found is not None
    return found


def test_a_program_is_compiled_once_and_then_taken_from_the_cache(
    cache: Path, matiec: Matiec, compiler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    image = compile_program(_text(1), WANTED, matiec, compiler)
    assert len(list(cache.iterdir())) == 1
    monkeypatch.setattr(Matiec, "translate", _forbidden)
    assert compile_program(_text(1), WANTED, matiec, compiler) == image


def _forbidden(*_: object) -> None:
    raise AssertionError("the program was compiled again")


def test_any_change_compiles_anew(cache: Path, matiec: Matiec, compiler: str) -> None:
    compile_program(_text(1), WANTED, matiec, compiler)
    compile_program(_text(2), WANTED, matiec, compiler)
    assert len(list(cache.iterdir())) == 2
    other = Wanted(WANTED.instances, (), ("sizeof(PROBE)", "offsetof(PROBE, N.value)"))
    compile_program(_text(2), other, matiec, compiler)
    assert len(list(cache.iterdir())) == 3


def test_rcx_cache_off_writes_nothing(
    cache: Path, matiec: Matiec, compiler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RCX_CACHE", "off")
    assert compile_program(_text(1), WANTED, matiec, compiler)
    assert not cache.exists()


def test_an_unwritable_cache_is_ignored(cache: Path, matiec: Matiec, compiler: str) -> None:
    cache.write_text("a file where the directory should be")
    assert compile_program(_text(1), WANTED, matiec, compiler)


def test_the_cache_forgets_the_oldest_programs(
    cache: Path, matiec: Matiec, compiler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("structured_text.language.cache.IN_FOLDER", 2)
    for step in (1, 2, 3):
        compile_program(_text(step), WANTED, matiec, compiler)
    assert len(list(cache.iterdir())) == 2


def test_a_failing_compiler_is_reported(cache: Path, matiec: Matiec, tmp_path: Path) -> None:
    failing = tmp_path / "cc"
    failing.write_text("#!/bin/sh\necho 'x.c:1:2: error: no such thing' >&2\nexit 1\n")
    failing.chmod(0o755)
    with pytest.raises(RefusedCodeError, match="error: no such thing"):
        compile_program(_text(1), WANTED, matiec, str(failing))
    assert list(cache.iterdir()) == []
