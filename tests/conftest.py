"""What tests of several folders share."""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rcx_harness import Cell
from shown import hexadecimal_comparison

REPOSITORY = Path(__file__).resolve().parents[1]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """In the order that RCX_ORDER says: `reverse`, or a number that draws one."""
    order = os.environ.get("RCX_ORDER", "")
    if order == "reverse":
        items.reverse()
    elif order:
        random.Random(int(order)).shuffle(items)


def pytest_assertrepr_compare(op: str, left: object, right: object) -> list[str] | None:
    """Codes, ErrorIDs and words of telegrams are shown in 16#."""
    return hexadecimal_comparison(op, left, right)


@pytest.fixture
def repository() -> Path:
    """The folder of the repository."""
    return REPOSITORY


@pytest.fixture
def build_cell() -> Iterator[Callable[..., Cell]]:
    """Builds cells with the arguments of `Cell.build` and closes them after the test."""
    cells: list[Cell] = []

    def build(*args: Any, **options: Any) -> Cell:
        cells.append(Cell.build(*args, **options))
        return cells[-1]

    yield build
    for cell in cells:
        cell.close()


@pytest.fixture
def raw_cell(build_cell: Callable[..., Cell], tmp_path: Path) -> Callable[..., Cell]:
    """Builds cells of a program that writes the area without the library and without any rule."""
    program = REPOSITORY / "tests" / "cell" / "programs" / "RawArea.st"
    empty = tmp_path / "no-library"
    empty.mkdir()

    def build(**options: Any) -> Cell:
        return build_cell(program, lib=empty, **options)

    return build
