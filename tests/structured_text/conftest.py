"""Fixtures that load and compile Structured Text from strings in a test."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from mistakes import check
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.language.project import Project


@pytest.fixture
def files_of(tmp_path: Path) -> Callable[..., list[Path]]:
    """Return a function that writes each source into its own file: source0.st, source1.st."""

    def write(*sources: str) -> list[Path]:
        files = [tmp_path / f"source{number}.st" for number in range(len(sources))]
        for file, source in zip(files, sources, strict=True):
            file.write_text(source, encoding="utf-8")
        return files

    return write


@pytest.fixture
def build(files_of: Callable[..., list[Path]]) -> Callable[..., BuiltinProgram]:
    """Return a function that compiles one or more sources."""
    return lambda *sources: BuiltinProgram.build(load(files_of(*sources)))


@pytest.fixture
def project_of(files_of: Callable[..., list[Path]]) -> Callable[..., Project]:
    """Return a function that loads one or more sources."""
    return lambda *sources: load(files_of(*sources))


@pytest.fixture
def mistakes_of(files_of: Callable[..., list[Path]]) -> Callable[..., list[InputError]]:
    """Return a function that lists all errors in one or more sources."""
    return lambda *sources: check(files_of(*sources))
