"""Fixtures with the cell of the chapter tests. It is compiled once and restarted for each test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from chapter_cell import ChapterCell
from rcx_harness.cell.sources import source_files
from rcx_harness.robot import RobotConfig
from structured_text.engines.base import Program
from structured_text.engines.load import build

Start = Callable[..., ChapterCell]


@pytest.fixture(scope="session")
def compiled() -> Iterator[tuple[Program, object]]:
    """Return the compiled program of the chapter tests and its state before the first scan."""
    files = source_files(Path(__file__).parent / "programs")
    program = build(files.all).program
    yield program, program.snapshot()
    program.close()


@pytest.fixture
def start(compiled: tuple[Program, object]) -> Iterator[Start]:
    """Return a function that starts a cell. Its arguments are fields of RobotConfig and `plc_size`.

    After the test, no rule of the manual or of the blocks' contract may have been broken.
    """
    cells: list[ChapterCell] = []

    def begin(*, plc_size: int | None = None, **config: Any) -> ChapterCell:
        robot = RobotConfig(**config)
        cells.append(ChapterCell(*compiled, robot, plc_size or robot.size))
        return cells[-1]

    yield begin
    for one in cells:
        assert [found.text for found in one.cell.violations] == []
