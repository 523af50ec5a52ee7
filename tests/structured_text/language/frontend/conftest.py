"""Checks sources that a test writes down."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import check, load
from structured_text.language.project import Project


def _write(folder: Path, sources: tuple[str, ...]) -> list[Path]:
    files = []
    for number, source in enumerate(sources):
        files.append(folder / f"source{number}.st")
        files[-1].write_text(source, encoding="utf-8")
    return files


@pytest.fixture
def project_of(tmp_path: Path) -> Callable[..., Project]:
    """Loads one or more sources, each as a file of its own."""
    return lambda *sources: load(_write(tmp_path, sources))


@pytest.fixture
def build_of(tmp_path: Path) -> Callable[..., BuiltinProgram]:
    """Compiles one or more sources, each as a file of its own."""
    return lambda *sources: BuiltinProgram.build(load(_write(tmp_path, sources)))


@pytest.fixture
def errors_of(tmp_path: Path) -> Callable[..., list[InputError]]:
    """Everything the front end finds wrong with one or more sources."""
    return lambda *sources: check(_write(tmp_path, sources))
