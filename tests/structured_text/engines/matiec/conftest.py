"""A fixture that compiles ST texts with matiec."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.language.load import load


@pytest.fixture
def compiled(matiec: Matiec, tmp_path: Path) -> Callable[..., MatiecProgram]:
    """Return a function that writes each text into a file and compiles the files."""

    def compile_texts(*texts: str) -> MatiecProgram:
        files = []
        for number, text in enumerate(texts):
            files.append(tmp_path / f"source{number}.st")
            files[-1].write_text(text)
        compiler = find_c_compiler()
        assert compiler is not None
        return MatiecProgram.build(load(files), matiec, compiler)

    return compile_texts
