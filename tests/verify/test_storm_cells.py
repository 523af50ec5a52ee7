"""A campaign has only one cell in memory at a time."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest

from feeder import feeder
from rcx_harness.verify.properties import followed
from rcx_harness.verify.storm.cells import Cells, CellsOf
from structured_text.errors import InputError


@pytest.fixture
def by_hand() -> Iterator[None]:
    """Disable Python's collector: a cell disappears only if the code under test frees it."""
    gc.disable()
    yield
    gc.enable()


def _cells(folder: Path) -> Cells:
    feeder(folder)
    return CellsOf.of([folder / "Feeder.st"], {"engine": "builtin"}).make()


@pytest.mark.usefixtures("by_hand")
def test_a_cell_is_gone_when_the_next_one_begins(tmp_path: Path) -> None:
    cells = _cells(tmp_path)
    first = weakref.ref(cells.cell(0))
    second = cells.cell(1)
    assert first() is None
    assert second.now_us == 0


@pytest.mark.exhaustive
@pytest.mark.usefixtures("by_hand")
def test_older_objects_are_collected_after_the_cells(tmp_path: Path) -> None:
    """Objects that existed before the cells are collected after the last cell.

    They are excluded while cells are collected, which makes each collection fast.
    """
    cells = _cells(tmp_path)
    assert gc.get_freeze_count() > 0
    del cells
    assert gc.get_freeze_count() == 0


@pytest.mark.parametrize(
    ("name", "text", "shown"),
    [
        ("demands.py", "import rcx_harness as rcx\n@rcx.always\ndef fed(cell):\n    return 1 / 0\n",
         ":4: fed: ZeroDivisionError"),
        ("demands.py", "import rcx_harness as rcx\n@rcx.always\ndef fed(cell):\n    return 5\n",
         ":2: fed: a property returns int"),
        ("demands.toml", '[[always]]\nname = "fed"\nthat = "Main.Nothing = 1"\n',
         ": fed: Main.Nothing = 1: "),
    ],
)  # fmt: skip
def test_an_error_of_a_property_names_the_users_file(
    tmp_path: Path, name: str, text: str, shown: str
) -> None:
    """An error of a property names the file of the user.

    A worker uses a copy in a temporary folder, which no longer exists when the error is shown.

    Source: docs/how-to/campaign.md: exit code 2 on bad input
    """
    feeder(tmp_path)
    demands = tmp_path / name
    demands.write_text(text)
    cells = CellsOf.of([tmp_path / "Feeder.st"], {"engine": "builtin"}, [demands]).make()
    cell = cells.cell(0)
    with pytest.raises(InputError) as caught:
        followed(cell.program, cells.demands.properties, cell)
    assert str(caught.value).startswith(f"{demands}{shown}")


def test_an_empty_library_folder_is_refused_and_not_replaced(tmp_path: Path) -> None:
    """Source: `rcx campaign --help`, --lib: folder of the library."""
    feeder(tmp_path)
    (empty := tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=r"--lib .*empty has no ST file; name a folder"):
        CellsOf.of([tmp_path / "Feeder.st"], {"engine": "builtin", "lib": empty})


def test_the_files_that_a_robot_file_names_are_sent_to_the_workers(tmp_path: Path) -> None:
    """The files that a robot file names are sent to the workers.

    A worker on another computer has no files of the user.
    """
    feeder(tmp_path)
    robot = tmp_path / "robots/robot.toml"
    robot.parent.mkdir()
    robot.write_text('data_file = "CELL.ALL"\n[[programs]]\nfile = "MAIN.PGM"\n')
    (robot.parent / "MAIN.PGM").write_text("SO(20)=1\n")
    (robot.parent / "CELL.ALL").write_text("[PNT]\nP7=1 2 3 4 5 6\n")
    cells = CellsOf.of([tmp_path / "Feeder.st"], {"engine": "builtin", "robot": str(robot)})
    (robot.parent / "MAIN.PGM").unlink()
    (robot.parent / "CELL.ALL").unlink()
    config = cells.make().cell(0).robot.config
    assert [program.name for program in config.programs] == ["MAIN"]
    assert [*config.points] == [7]
