"""Garbage collection pauses while trees are built, and is restored afterwards."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path

import pytest

from mistakes import check
from structured_text.engines.load import build
from structured_text.errors import InputError
from structured_text.language.compiling import uncollected


@pytest.fixture(autouse=True)
def running() -> Iterator[None]:
    """Enable garbage collection, as at Python's start, and restore it after the test."""
    before = gc.isenabled()
    gc.enable()
    yield
    (gc.enable if before else gc.disable)()


def test_nested_pauses_stop_garbage_collection_until_the_outermost_ends() -> None:
    """Garbage collection is off inside nested pauses, and on after the outermost pause.

    Source: language/compiling.py.
    """
    with uncollected():
        assert not gc.isenabled()
        with uncollected():
            assert not gc.isenabled()
        assert not gc.isenabled()
    assert gc.isenabled()


def test_a_collector_that_was_off_stays_off() -> None:
    """If garbage collection was off before a pause, it stays off after the pause.

    Source: rcx serve: its loop makes no cycles and runs without the search.
    """
    gc.disable()
    with uncollected():
        pass
    assert not gc.isenabled()


def test_garbage_collection_is_on_after_an_error_in_the_sources(tmp_path: Path) -> None:
    """Garbage collection is on again after sources with an error.

    Source: engines/load.py and language/load.py, which build trees.
    """
    file = tmp_path / "Main.st"
    file.write_text("PROGRAM Main X := 1; END_PROGRAM", encoding="utf-8")
    with pytest.raises(InputError, match="X is not declared"):
        build([file], "builtin")
    assert gc.isenabled()
    assert [error.message for error in check([file])] == ["X is not declared"]
    assert gc.isenabled()


@pytest.mark.parametrize(
    ("module", "step", "whole"),
    [
        ("structured_text.engines.load", "load", lambda file: build([file], "builtin")),
        (
            "structured_text.engines.builtin.compile",
            "_code",
            lambda file: build([file], "builtin"),
        ),
        ("structured_text.language.load", "read_text", lambda file: check([file])),
    ],
)
def test_garbage_collection_is_off_while_trees_are_built(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    step: str,
    whole: Callable[[Path], object],
) -> None:
    """Garbage collection is off while trees are built.

    Source: docs/explanation/timing.md: the library compiles within 2 s.
    """
    file = tmp_path / "Main.st"
    file.write_text("PROGRAM Main VAR X : INT; END_VAR X := 1; END_PROGRAM", encoding="utf-8")
    place = import_module(module)
    real: Callable[..., object] = getattr(place, step, compile)
    searched: list[bool] = []

    def noted(*arguments: object) -> object:
        searched.append(gc.isenabled())
        return real(*arguments)

    monkeypatch.setattr(place, step, noted, raising=False)
    whole(file)
    assert searched == [False]
