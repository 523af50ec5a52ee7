"""A fixture that compiles ST texts with matiec and with STruC++."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from both_engines import COMPILED
from structured_text.engines.load import build
from structured_text.engines.native.program import NativeProgram


@pytest.fixture(params=COMPILED)
def compiled(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[..., NativeProgram]:
    """Return a function that writes each text into a file and compiles the files."""

    def compile_texts(*texts: str) -> NativeProgram:
        files = []
        for number, text in enumerate(texts):
            files.append(tmp_path / f"source{number}.st")
            files[-1].write_text(text)
        program = build(files, request.param).program
        assert isinstance(program, NativeProgram)
        return program

    return compile_texts
